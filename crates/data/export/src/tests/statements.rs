//! Statements of `report.html`: checks with measured values and limits, in the terms of the documentation.

use super::specimen::{settings, specimen, text};
use crate::*;

/// The page of the specimen, changed.
fn page(change: impl FnOnce(&mut certificate::Certificate)) -> String {
    let (scene, mut certificate, assets, images) = specimen();
    change(&mut certificate);
    let files = write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(UsdForm::Usda));
    text(&files.expect("sound"), "report.html").to_owned()
}

/// The cells of the rows of the table of checks, without tags.
fn checks(page: &str) -> Vec<String> {
    let table = page.split("class=\"checks\"").nth(1).expect("a table of checks");
    let table = table.split("</table>").next().expect("its end");
    let words = |row: &str| {
        let cells = row.split("<td").skip(1).map(|cell| {
            let content = cell.split_once('>').expect("an open tag").1;
            let pieces = content.split('<').enumerate();
            pieces
                .map(|(at, piece)| if at == 0 { piece } else { piece.split_once('>').map_or("", |it| it.1) })
                .collect::<String>()
                .trim()
                .to_owned()
        });
        cells.collect::<Vec<_>>().join(" | ")
    };
    table.split("<tr").skip(2).map(words).collect()
}

fn row(page: &str, check: &str) -> String {
    let rows = checks(page);
    let found = rows.iter().find(|row| row.starts_with(check));
    found.unwrap_or_else(|| panic!("no {check} in {rows:#?}")).clone()
}

#[test]
fn likeness_is_stated_by_measured_value_and_limit() {
    let page = page(|certificate| {
        certificate.fidelity.silhouette_iou = 0.25;
        certificate.fidelity.missed.share = 0.1234;
        certificate.fidelity.invented.share = 0.5;
    });
    for (check, expected) in [
        ("Silhouettes", "mean intersection over union 0.250 | at least 0.3 | "),
        ("The scene shows", "12.3 % of their pixels are missed | at most 40 % | "),
        ("The reference image shows", "50 % of their pixels are invented | at most 40 % | "),
    ] {
        let found = row(&page, check);
        assert!(found.contains(expected), "{found}");
    }
    let verdict = |check: &str| row(&page, check).rsplit(" | ").next().map(str::to_owned);
    assert_ne!(verdict("The scene shows"), verdict("The reference image shows"), "each has its own verdict");
}

#[test]
fn likeness_to_an_own_rendering_is_reported_and_not_judged() {
    let page = page(|certificate| {
        certificate.fidelity.is_judged = false;
        certificate.fidelity.invented.share = 0.5;
    });
    let found = row(&page, "The reference image shows");
    assert!(found.ends_with("if the image were given; the program rendered this one | reported"), "{found}");
}

#[test]
fn the_page_has_the_terms_of_the_documentation() {
    let page = page(|_| {}).to_lowercase();
    let visible = page.split("</style>").nth(1).expect("a page");
    for word in ["picture</", "the picture", "looks like", "things", " told", "thinks"] {
        assert!(!visible.contains(word), "the page has {word:?}");
    }
}
