//! A user's label of an object is data in every format: it reads back unchanged, whatever characters it contains.

use super::specimen::{settings, specimen, text};
use crate::round_trip::read_back;
use crate::*;
use markup::xml::allowed_in_xml;

/// Labels with the special characters of all formats.
fn labels() -> Vec<String> {
    let long: String = "a label of 300 characters, ".chars().cycle().take(300).collect();
    [
        "plain",
        "quotes \" and ' and ` and \"\"\" and '''",
        "<script>alert(\"mug\")</script>",
        "a & b &amp; c &#60; &lt;b&gt; ]]> --> <!-- <![CDATA[ ?>",
        "two\nlines\r\nand a\ttab",
        "🍎 tasse à café 茶碗 كوب \u{202e}turned\u{202c}",
        "../../etc/passwd",
        "@../other.usda@ and @@@three@@@",
        "</text><body name=\"evil\"/>",
        "{rows} {id} %s ${x} \\ \\n \\\" $(rm)",
        "| a | b | `code` [link](http://example.invalid) # head",
        " leading and trailing spaces ",
        "\u{1}\u{7f}\u{85}\u{fffe} controls",
        "",
    ]
    .map(str::to_owned)
    .into_iter()
    .chain([long])
    .collect()
}

#[test]
fn every_format_preserves_labels() {
    for label in labels() {
        let (mut scene, certificate, assets, images) = specimen();
        scene.instances[0].label = label.clone();
        scene.table.label = label.clone();
        let files =
            write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(UsdForm::Usdc));
        // Writing reads back the labels of URDF, MJCF, SDF and GLB, and every number beside them.
        let files = files.unwrap_or_else(|error| panic!("{label:?}: {error}"));

        let read_scene: Scene = serde_json::from_str(text(&files, "scene.json")).expect("our own JSON");
        assert_eq!(read_scene.instances[0].label, label);
        let manifest: serde_json::Value =
            serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
        assert_eq!(manifest["assets"][1]["label"], label);

        let page = text(&files, "report.html");
        assert!(page_texts(page).contains(&shown(&label)), "{label:?} is not on the page");
        let readme = text(&files, "README.md");
        let row = readme.lines().find(|line| line.starts_with("| `mug_1` |")).expect("a row");
        // The label stays in its cell and contains no markup.
        assert_eq!(row.replace("\\|", "").matches('|').count(), 4, "{row}");
        assert!(!row.contains('<') && !readme.contains("<script"), "{row}");
    }
}

#[test]
fn read_back_rejects_a_changed_label() {
    let (mut scene, certificate, assets, images) = specimen();
    let files = write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(UsdForm::Usdc))
        .expect("sound");
    scene.instances[0].label = "plain".into();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let error = read_back(&bodies, &files).expect_err("the files tell the old label");
    assert!(error.to_string().contains("label"), "{error}");
}

/// A label as the page can display it.
fn shown(label: &str) -> String {
    let held = allowed_in_xml(label);
    held.chars().map(|c| if c.is_control() && !"\n\r\t".contains(c) { '\u{fffd}' } else { c }).collect()
}

/// Texts of the page's `<bdi>` elements, read as XML.
fn page_texts(page: &str) -> Vec<String> {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(page);
    let (mut texts, mut inside) = (Vec::new(), false);
    loop {
        match reader.read_event().expect("well-formed") {
            Event::Start(start) if start.name().0 == "bdi" => {
                texts.push(String::new());
                inside = true;
            }
            Event::End(end) if end.name().0 == "bdi" => inside = false,
            Event::Text(text) if inside => texts.last_mut().expect("open").push_str(&text),
            Event::GeneralRef(entity) if inside => {
                let character = match &*entity {
                    "amp" => '&',
                    "lt" => '<',
                    "gt" => '>',
                    "quot" => '"',
                    "#39" => '\'',
                    "#13" => '\r',
                    other => panic!("the page uses &{other};"),
                };
                texts.last_mut().expect("open").push(character);
            }
            Event::Eof => return texts,
            _ => {}
        }
    }
}

#[test]
fn report_page_is_self_contained() {
    let files = super::specimen::files();
    let page = text(&files, "report.html");
    assert!(page.starts_with("<!DOCTYPE html>\n<html lang=\"en\""));
    for (attribute, starts) in [("src=\"", "data:image/jpeg;base64,"), ("href=\"", "#")] {
        let values: Vec<&str> = page.split(attribute).skip(1).collect();
        assert!(!values.is_empty() && values.iter().all(|value| value.starts_with(starts)), "{attribute}");
    }
    // The one address is the name of the markup language, which nothing fetches.
    let addresses = page.matches("://").count();
    let namespaces = page.matches("xmlns=\"http://www.w3.org/1999/xhtml\"").count();
    assert_eq!((addresses, namespaces), (1, 1));
    for forbidden in ["<script", "javascript:", "@import", "url(", "onload", "onerror"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("PASS") || page.contains(">pass<"));
}
