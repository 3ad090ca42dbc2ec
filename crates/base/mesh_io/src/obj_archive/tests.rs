//! Valid and hostile OBJ archives.

use std::io::Write;

use proptest::prelude::*;
use zip::write::SimpleFileOptions;

use super::*;
use imaging::Image;
use imaging::codec::encode_png;

fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default()).expect("begins");
        zip.write_all(bytes).expect("is written");
    }
    zip.finish().expect("ends").into_inner()
}

/// A tent of two quadrilaterals, one of them textured.
const OBJ: &str = "# made by a model\nmtllib material.mtl\no tent\nv 0 0 0\nv 2 0 0\nv 2 1 -1\nv 0 1 -1\nv 2 0 -2\nv 0 0 -2\n\
                   vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl Canvas 1\nf 1/1 2/2 3/3 4/4\nusemtl other\nf -4 -3 -2 -1\n";

const MTL: &str =
    "newmtl Canvas 1\nKd 0.5 0.5 0.5\nmap_Kd -clamp on textures\\Canvas.PNG\nnewmtl other\nKd 0.25 0.5 1\n";

fn tent() -> Vec<u8> {
    let image = encode_png(&Image::filled(4, 2, [200, 100, 50, 255]));
    archive(&[
        ("mesh/readme.txt", b"hello"),
        ("mesh/tent.obj", OBJ.as_bytes()),
        ("mesh/material.mtl", MTL.as_bytes()),
        ("mesh/textures/canvas.png", &image),
    ])
}

#[test]
fn read_mesh_obj_archive_reads_triangles_materials_and_textures() {
    let file = tent();
    assert!(is_archive(&file) && !is_archive(b"glTF"));
    let mesh = read_mesh_obj_archive(&file).expect("is a mesh");
    assert_eq!(mesh.triangle_count(), 4);
    // Rotated from y up to z up.
    assert_eq!(mesh.bounds(), (DVec3::ZERO, DVec3::new(2.0, 2.0, 1.0)));
    let [canvas, other] = &mesh.materials[..] else { panic!("two materials") };
    let texture = canvas.base_color_texture.as_ref().expect("has its image");
    assert_eq!((texture.width_px(), texture.pixel(0, 0)), (4, [200, 100, 50, 255]));
    assert_eq!((other.base_color, &other.base_color_texture), (Rgb([0.25, 0.5, 1.0]), &None));
    assert_eq!(mesh.uvs[2], Vec2::new(1.0, 1.0));
    // The front faces forward and up.
    assert!(mesh.normals[0].y < -0.5 && mesh.normals[0].z > 0.5, "{}", mesh.normals[0]);
    assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
}

#[test]
fn read_mesh_obj_archive_rejects_hostile_archives() {
    let message = |bytes: &[u8]| read_mesh_obj_archive(bytes).expect_err("is refused").to_string();
    assert!(message(b"PK\x03\x04 and then nothing").contains("ZIP"));
    assert!(message(&archive(&[("a.txt", b"")])).contains("no OBJ"));
    for (obj, what) in [
        ("v 1 2\n", "three coordinates"),
        ("v 1 2 nan\n", "three coordinates"),
        ("v 0 0 0\nf 1 1 2\n", "not there"),
        ("v 0 0 0\nf 1 1 -2\n", "not there"),
        ("v 0 0 0\nf 0 1 1\n", "not there"),
        ("v 0 0 0\nf 1 1 x\n", "no number"),
        ("v 0 0 0\nf 1 1 /1\n", "not there"),
        ("v 0 0 0\nf 99999999999999999999 1 1\n", "no number"),
    ] {
        let message = message(&archive(&[("a.obj", obj.as_bytes())]));
        assert!(message.contains(what), "{obj:?}: {message}");
    }
    let many: Vec<String> = (0..300).map(|number| format!("{number}.txt")).collect();
    let many: Vec<(&str, &[u8])> = many.iter().map(|name| (name.as_str(), &b""[..])).collect();
    assert!(message(&archive(&many)).contains("256 entries"));
    let broken =
        archive(&[("a.obj", OBJ.as_bytes()), ("a.mtl", MTL.as_bytes()), ("canvas.png", b"\x89PNG nothing")]);
    assert!(message(&broken).contains("texture"));
}

#[test]
fn read_mesh_obj_archive_bounds_unpacked_sizes() {
    // 70 MB of zeros are 70 kB in an archive.
    let bomb = archive(&[("a.obj", b"v 0 0 0\n"), ("a.mtl", &vec![0; 70 << 20])]);
    assert!(bomb.len() < 1 << 20);
    assert!(read_mesh_obj_archive(&bomb).expect_err("is refused").to_string().contains("larger"));
}

proptest! {
    #[test]
    fn read_mesh_obj_archive_never_panics_on_changed_bytes(at in 0_usize..2000, value: u8, cut in 0_usize..2000) {
        let mut file = tent();
        let length = file.len();
        file[at % length] = value;
        file.truncate(length - cut % length);
        let _ = read_mesh_obj_archive(&file);
    }

    #[test]
    fn read_mesh_obj_archive_never_panics_on_changed_lines(at in 0_usize..300, value in 32_u8..127) {
        let mut obj = OBJ.as_bytes().to_vec();
        let length = obj.len();
        obj[at % length] = value;
        let _ = read_mesh_obj_archive(&archive(&[("a.obj", &obj)]));
    }
}
