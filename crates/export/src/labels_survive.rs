//! The words a person used for a thing are data in every file: they come back as they were, whatever they are.

use super::parity::read_back;
use super::specimen::{settings, specimen, text};
use super::xml::allowed_in_xml;
use super::*;

/// Labels that break writers that paste strings together.
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
fn every_format_gives_a_label_back() {
    for label in labels() {
        let (mut scene, certificate, assets, pictures) = specimen();
        scene.instances[0].label = label.clone();
        scene.table.label = label.clone();
        let files = write_formats(&scene, &certificate, &assets, &pictures, &settings(UsdForm::Usdc));
        // Writing reads back the labels of URDF, MJCF, SDF and GLB, and every number beside them.
        let files = files.unwrap_or_else(|error| panic!("{label:?}: {error}"));

        let told: Scene = serde_json::from_str(text(&files, "scene.json")).expect("our own JSON");
        assert_eq!(told.instances[0].label, label);
        let manifest: serde_json::Value =
            serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
        assert_eq!(manifest["assets"][1]["label"], label);

        let page = text(&files, "report.html");
        assert!(page_texts(page).contains(&shown(&label)), "{label:?} is not on the page");
        let readme = text(&files, "README.md");
        let row = readme.lines().find(|line| line.starts_with("| `mug_1` |")).expect("a row");
        // However the cell is written, it stays one cell without markup.
        assert_eq!(row.replace("\\|", "").matches('|').count(), 4, "{row}");
        assert!(!row.contains('<') && !readme.contains("<script"), "{row}");
    }
}

#[test]
fn another_label_is_another_scene() {
    let (mut scene, certificate, assets, pictures) = specimen();
    let files =
        write_formats(&scene, &certificate, &assets, &pictures, &settings(UsdForm::Usdc)).expect("sound");
    scene.instances[0].label = "plain".into();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let error = read_back(&bodies, &files).expect_err("the files tell the old label");
    assert!(error.to_string().contains("label"), "{error}");
}

/// What a page can show of a label.
fn shown(label: &str) -> String {
    let held = allowed_in_xml(label);
    held.chars().map(|c| if c.is_control() && !"\n\r\t".contains(c) { '\u{fffd}' } else { c }).collect()
}

/// What stands in the page's `<bdi>` elements, read as XML.
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
fn the_page_stands_alone() {
    let files = super::specimen::files();
    let page = text(&files, "report.html");
    assert!(page.starts_with("<!DOCTYPE html>\n<html lang=\"en\""));
    for (attribute, starts) in [("src=\"", "data:image/jpeg;base64,"), ("href=\"", "#")] {
        let values: Vec<&str> = page.split(attribute).skip(1).collect();
        assert!(!values.is_empty() && values.iter().all(|value| value.starts_with(starts)), "{attribute}");
    }
    // The one address is the name of the markup language, which nothing fetches.
    let addresses = page.matches("://").count();
    let told = page.matches("xmlns=\"http://www.w3.org/1999/xhtml\"").count();
    assert_eq!((addresses, told), (1, 1));
    for forbidden in ["<script", "javascript:", "@import", "url(", "onload", "onerror"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("PASS") || page.contains(">pass<"));
}
