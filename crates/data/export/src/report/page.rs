//! `report.html`: a self-contained page without scripts, external links or files, for screen and print.

use super::image::{Embedded, EmbeddedImages};
use super::numbers::word;
use super::{Report, plan, sections};
use markup::html::{Cell, Html};
use scene::Input;

/// Content security policy: the page loads nothing, whatever a label contains.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The text of the page.
pub fn write(report: &Report<'_>) -> String {
    let images = EmbeddedImages::of(report.images);
    let mut page = Html::default();
    page.open("html", &[("lang", "en"), ("xmlns", "http://www.w3.org/1999/xhtml")]);
    head(&mut page, report);
    page.open("body", &[]);
    page.open("main", &[]);
    verdict(&mut page, report);
    figure(&mut page, images.hero.as_ref(), "The finished scene");
    if let Some(account) = &report.scene.text {
        section(&mut page, "Understood text", |page| {
            sections::text::write(page, report, account);
        });
    }
    section(&mut page, "Checks", |page| sections::checks::write(page, report));
    if !report.certificate.collisions.is_empty() {
        section(&mut page, "Collisions", |page| sections::checks::collisions(page, report));
    }
    section(&mut page, "Objects", |page| {
        let at_fault: Vec<bool> = report.bodies[1..]
            .iter()
            .map(|body| report.certificate.reasons.iter().any(|reason| reason.bodies.contains(&body.name)))
            .collect();
        plan::draw(page, &report.scene.table, &report.bodies[1..], &at_fault);
        sections::objects::write(page, report, &images);
    });
    section(&mut page, "Meshes and hulls", |page| sections::bodies::write(page, report));
    section(&mut page, "Comparison with the reference image", |page| {
        let caption = "The reference image; the scene from its camera; pixels that both show as objects (green), that the scene \
                       misses (red) and that it invents (blue)";
        figure(page, images.beside.as_ref(), caption);
        sections::likeness::write(page, report);
    });
    if let Some(finding) = &report.certificate.clutter {
        section(&mut page, "Clutter", |page| sections::clutter::write(page, finding));
    }
    if let Some(finding) = &report.certificate.robot {
        section(&mut page, "Abilities of the robot", |page| sections::robot::write(page, finding));
    }
    if let Some(appraisal) = &report.certificate.appraisal {
        section(&mut page, "Ratings by a model", |page| {
            sections::appraisal::write(page, report, appraisal);
        });
    }
    section(&mut page, "Formats read back", |page| sections::formats::write(page, report));
    views(&mut page, &images);
    section(&mut page, "Provenance", |page| sections::provenance::write(page, report));
    let page = page.finish();
    format!("<!DOCTYPE html>\n{page}")
}

fn head(page: &mut Html, report: &Report<'_>) {
    page.open("head", &[]);
    page.void("meta", &[("charset", "utf-8")]);
    page.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
    page.void("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
    page.leaf("title", &[], &format!("Scene {}: {}", report.scene.id, word(report.certificate.verdict)));
    page.style(include_str!("page.css"));
    page.close();
}

/// Header: verdict, summary, reasons, and the request.
fn verdict(page: &mut Html, report: &Report<'_>) {
    let certificate = report.certificate;
    let word_of_verdict = word(certificate.verdict);
    page.open("header", &[("class", &word_of_verdict)]);
    page.open("h1", &[]);
    page.leaf("span", &[("class", "verdict")], &word_of_verdict);
    page.text(" ");
    page.leaf("span", &[("class", "id")], &format!("scene {}", report.scene.id));
    page.close();
    page.leaf("p", &[("class", "why")], &certificate.summary);
    if !certificate.reasons.is_empty() {
        let rows = certificate
            .reasons
            .iter()
            .map(|reason| vec![Cell::Words(word(reason.code)), Cell::Words(reason.sentence.clone())])
            .collect();
        page.table("reasons", &["Code", "Finding"], rows);
    }
    match &report.scene.request.input {
        Input::Text { text } => {
            page.open("blockquote", &[]);
            page.user_text(text);
            page.close();
        }
        Input::Image { sha256, media_type, text, depth_sha256 } => {
            let mut words = format!("made from an image ({media_type}, SHA-256 {sha256})");
            if let Some(depth_sha256) = depth_sha256 {
                words += &format!(" and its depths (SHA-256 {depth_sha256})");
            }
            page.leaf("p", &[("class", "asked")], &words);
            if let Some(text) = text {
                page.open("blockquote", &[]);
                page.user_text(text);
                page.close();
            }
        }
        Input::Edit { parent, operations, text, .. } => {
            let count = operations.len();
            let plural = if count == 1 { "" } else { "s" };
            page.leaf("p", &[("class", "asked")], &format!("scene {parent} with {count} operation{plural}"));
            if let Some(text) = text {
                page.open("blockquote", &[]);
                page.user_text(text);
                page.close();
            }
        }
        Input::Variant { parent, .. } => {
            page.leaf("p", &[("class", "asked")], &format!("a variant of scene {parent}"));
        }
    }
    page.close();
}

fn section(page: &mut Html, title: &str, content: impl FnOnce(&mut Html)) {
    page.open("section", &[]);
    page.leaf("h2", &[], title);
    content(page);
    page.close();
}

fn views(page: &mut Html, images: &EmbeddedImages) {
    let sides = images.sides.iter().map(|(name, image)| (name.as_str(), image));
    let views: Vec<_> = images.top.iter().map(|image| ("above", image)).chain(sides).collect();
    if views.is_empty() {
        return;
    }
    section(page, "Views", |page| {
        page.open("div", &[("class", "views")]);
        for (name, image) in views {
            let caption = format!("From {}{name}", if name == "above" { "" } else { "the " });
            figure(page, Some(image), &caption);
        }
        page.close();
    });
}

fn figure(page: &mut Html, image: Option<&Embedded>, caption: &str) {
    let Some(image) = image else { return };
    let (width, height) = (image.width_px.to_string(), image.height_px.to_string());
    page.open("figure", &[]);
    page.void("img", &[("src", &image.uri), ("width", &width), ("height", &height), ("alt", caption)]);
    page.leaf("figcaption", &[], caption);
    page.close();
}
