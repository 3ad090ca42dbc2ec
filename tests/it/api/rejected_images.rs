//! `generate` from outside with images that it must reject.

use std::io::Cursor;
use std::path::Path;
use std::process::{Command, Output};

use image::{ImageFormat, Rgb, RgbImage};

fn run(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Images without a table: a page, noise and a drawn face, each 480 x 400.
fn without_a_table() -> [(&'static str, RgbImage); 3] {
    let page = RgbImage::from_pixel(480, 400, Rgb([252, 252, 250]));
    let noise = RgbImage::from_fn(480, 400, |x, y| {
        // A multiplicative hash: neighbors have nothing in common.
        let k = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
        Rgb([(k >> 24) as u8, (k >> 16) as u8, (k >> 8) as u8])
    });
    [("page", page), ("noise", noise), ("face", drawn_face())]
}

/// Head, eyes and a smile on light blue.
fn drawn_face() -> RgbImage {
    let within = |x: u32, y: u32, [cx, cy]: [f64; 2], [rx, ry]: [f64; 2]| {
        ((f64::from(x) - cx) / rx).powi(2) + ((f64::from(y) - cy) / ry).powi(2) < 1.0
    };
    RgbImage::from_fn(480, 400, |x, y| {
        let in_eye = |reach: f64| {
            within(x, y, [190.0, 165.0], [reach, reach]) || within(x, y, [290.0, 165.0], [reach, reach])
        };
        let smile = y > 240
            && within(x, y, [240.0, 235.0], [75.0, 60.0])
            && !within(x, y, [240.0, 225.0], [75.0, 55.0]);
        Rgb(match () {
            _ if in_eye(9.0) => [40, 30, 30],
            _ if in_eye(22.0) => [250, 250, 250],
            _ if smile => [150, 40, 50],
            _ if within(x, y, [240.0, 200.0], [130.0, 165.0]) => [232, 190, 160],
            _ => [190, 215, 235],
        })
    })
}

/// The files are JPEGs named PNG.
#[test]
fn generate_rejects_image_without_table() {
    let home = tempfile::tempdir().unwrap();
    for (what, image) in without_a_table() {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
        let name = format!("{what}.png");
        std::fs::write(home.path().join(&name), bytes.into_inner()).unwrap();
        let output = run(home.path(), &["generate", "--image", &name, "--out", what]);
        let said = message(&output);
        assert_eq!(output.status.code(), Some(4), "{what}: {said}");
        let codes = ["no_table_top", "no_objects", "camera_unclear"];
        assert!(codes.iter().any(|code| said.contains(code)), "{what}: {said}");
        assert!(said.contains("; send ") || said.contains("; hold "), "{what}: {said}");
        assert!(!home.path().join(what).exists(), "{what} left a bundle");
    }
}

#[test]
fn generate_rejects_depths_that_are_none_of_the_image() {
    let home = tempfile::tempdir().unwrap();
    let [(_, page), ..] = without_a_table();
    page.save(home.path().join("page.png")).unwrap();
    let depth = |width_px: u32, height_px: u32, depth_mm: u16| {
        let depths_mm = vec![depth_mm; (width_px * height_px) as usize];
        imaging::DepthImage::new(width_px, height_px, depths_mm).expect("a depth a pixel").encode_png()
    };
    let (width_px, height_px) = page.dimensions();
    for (name, bytes) in [
        ("good.png", depth(width_px, height_px, 800)),
        ("empty.png", depth(width_px, height_px, 0)),
        ("wide.png", depth(2 * width_px, height_px, 800)),
    ] {
        std::fs::write(home.path().join(name), bytes).unwrap();
    }
    let fov = ["--set", "photograph.field_of_view_rad=0.6"];
    let both = ["--set", "photograph.intrinsics_px=500,500,240,200,480,400"];
    for (arguments, says) in [
        (vec!["--depth", "good.png"], vec!["--image"]),
        (
            vec!["--image", "page.png", "--depth", "good.png"],
            vec!["--depth good.png", "photograph.intrinsics_px"],
        ),
        (
            [&["--image", "page.png", "--depth", "empty.png"], &fov[..]].concat(),
            vec!["no pixel has a measurement"],
        ),
        (
            [&["--image", "page.png", "--depth", "wide.png"], &fov[..]].concat(),
            vec!["--depth wide.png", "same ratio"],
        ),
        ([&["--image", "page.png", "--depth", "page.png"], &fov[..]].concat(), vec!["colors of 8 bits"]),
        ([&["--image", "page.png"], &fov[..], &both[..]].concat(), vec!["intrinsics_px", "one of the two"]),
        ([&["--image", "page.png", "--depth", "missing.png"], &fov[..]].concat(), vec!["the depth image"]),
    ] {
        let output = run(home.path(), &[&["generate", "--out", "out"], &arguments[..]].concat());
        let said = message(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(says.iter().all(|part| said.contains(part)), "{arguments:?}: {said}");
        assert!(!home.path().join("out").exists(), "{arguments:?} left a bundle");
    }
}

#[test]
fn generate_rejects_invalid_image_files() {
    let home = tempfile::tempdir().unwrap();
    let [(_, page), ..] = without_a_table();
    let mut png = Cursor::new(Vec::new());
    page.write_to(&mut png, ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let mut claims = png.clone();
    // 20,000 x 20,000 by the header; its check sum is wrong then, too.
    claims[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
    let mut jpeg = Cursor::new(Vec::new());
    page.write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
    let jpeg = jpeg.into_inner();
    for (name, bytes, says, code) in [
        ("cut.png", &png[..png.len() / 2], "the image is damaged", "image_unreadable"),
        ("cut.jpg", &jpeg[..jpeg.len() * 3 / 4], "the image is damaged", "image_unreadable"),
        ("claims.png", &claims[..], "the image is", "image_unreadable"),
        ("moving.gif", b"GIF89a\x10\0\x10\0\0\0\0;", "convert it", "image_format"),
        ("drawn.svg", b"<svg xmlns='http://www.w3.org/2000/svg'/>", "convert it", "image_format"),
        ("text.png", b"a table with a mug", "convert it", "image_format"),
    ] {
        std::fs::write(home.path().join(name), bytes).unwrap();
        let output = run(home.path(), &["generate", "--image", name, "--out", "out"]);
        let said = message(&output);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains(says) && !said.contains("panicked"), "{name}: {said}");
        assert!(!home.path().join("out").exists(), "{name} left a bundle");
        let output = run(home.path(), &["generate", "--image", name, "--out", "out", "--json"]);
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).expect("prints JSON");
        assert_eq!(document["failure"]["problem"]["code"], code, "{name}: {document}");
        assert_eq!(document["failure"]["exit_code"], 2, "{name}: {document}");
    }
}
