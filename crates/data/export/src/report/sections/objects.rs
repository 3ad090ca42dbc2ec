//! One row per object: its support, how far it was moved, and how far it moves under gravity.

use crate::report::Report;
use crate::report::image::EmbeddedImages;
use crate::report::numbers::{mm, movement, percent, word};
use certificate::{Displacement, Displacements, ReasonCode, RelaxationKind};
use markup::html::{Cell, Html};
use scene::StandIn;

pub fn write(page: &mut Html, report: &Report<'_>, images: &EmbeddedImages) {
    cards(page, report, images);
    page.leaf("h3", &[], "Displacements");
    let objects = &report.certificate.objects;
    let spread = |of: fn(&Displacements) -> Displacement| {
        let mut ways: Vec<f64> = objects.iter().map(|object| of(&object.moved).distance_m).collect();
        ways.sort_by(f64::total_cmp);
        match ways.as_slice() {
            [] => "none".to_owned(),
            ways => format!("median {}, maximum {}", mm(ways[ways.len() / 2]), mm(ways[ways.len() - 1])),
        }
    };
    let words = format!(
        "By resolve (dropped onto its supporter, pushed apart): {}. By settling under gravity: {}. From the aligned \
         pose to the shipped one: {}.",
        spread(|moved| moved.by_resolve),
        spread(|moved| moved.by_settling),
        spread(|moved| moved.from_aligned),
    );
    page.leaf("p", &[], &words);
    let limits = &report.certificate.thresholds;
    let head = [
        "",
        "Object",
        "By resolve",
        "By settling",
        "Aligned to shipped",
        &format!("After shipping, {} s", limits.dss_duration_s),
        &format!("From aligned, {} s", limits.dss_duration_s),
    ];
    let rows = (1..).zip(objects).map(|(number, object)| {
        let name = object.name.as_str();
        let moved = &object.moved;
        let rests = !fails(report, ReasonCode::NotAtRest, name);
        vec![
            Cell::Number(format!("{number}")),
            Cell::Body(name.to_owned()),
            Cell::Number(movement(&moved.by_resolve)),
            Cell::Number(movement(&moved.by_settling)),
            Cell::Number(movement(&moved.from_aligned)),
            number_cell(movement(&moved.after_shipping), rests),
            Cell::Number(movement(&moved.after_aligning)),
        ]
    });
    page.table("", &head, rows.collect());
    let resolve = &report.certificate.resolve;
    if !resolve.gave_way.is_empty() {
        page.leaf("h3", &[], "Objects without room");
        let rows = resolve.gave_way.iter().map(|object| {
            let done = match &object.how {
                RelaxationKind::Shrunk { scale } => {
                    format!("made smaller, to {} of its size", percent(*scale))
                }
                RelaxationKind::Moved { from } => format!("moved from {from} to free space on the table"),
            };
            vec![Cell::Body(object.name.clone()), Cell::Words(done)]
        });
        page.table("", &["Object", "Change"], rows.collect());
    }
    if !resolve.log.is_empty() {
        page.leaf("h3", &[], "Changes by the stage resolve");
        page.open("ol", &[]);
        resolve.log.iter().for_each(|step| page.leaf("li", &[], step));
        page.close();
    }
}

/// Thumbnail, label and support of every object.
fn cards(page: &mut Html, report: &Report<'_>, images: &EmbeddedImages) {
    page.open("div", &[("class", "scroll")]);
    page.open("table", &[("class", "cards")]);
    page.open("thead", &[]);
    page.open("tr", &[]);
    ["", "", "Object", "Words", "Stands"].iter().for_each(|title| page.heading(title, false));
    for title in ["Support margin", "To the edge", "Mass", "Friction"] {
        page.heading(title, true);
    }
    page.close();
    page.close();
    page.open("tbody", &[]);
    let objects = report.certificate.objects.iter().zip(&report.scene.instances);
    for (number, (object, instance)) in (1..).zip(objects) {
        let name = object.name.as_str();
        page.open("tr", &[("id", name)]);
        page.leaf("td", &[("class", "n")], &format!("{number}"));
        page.open("td", &[("class", "picture")]);
        if let Some(image) = images.thumbnails.get(name) {
            page.void("img", &[("src", &image.uri), ("width", "64"), ("height", "64"), ("alt", "")]);
        }
        page.close();
        page.leaf("td", &[], name);
        page.open("td", &[("class", "told")]);
        page.user_text(&instance.label);
        let is_filling =
            report.scene.text.as_ref().is_some_and(|text| text.fillings.contains(&instance.name));
        let filling = is_filling.then(|| "filling".to_owned());
        for mark in instance.stand_in.as_ref().map(stand_in).into_iter().chain(filling) {
            page.text(" ");
            page.leaf("span", &[("class", "note")], &mark);
        }
        page.close();
        let relation = word(instance.support.relation);
        page.leaf("td", &[], &format!("{relation} {}", instance.support.parent));
        let margin = object.support_margin_m.map_or("touches nothing".to_owned(), mm);
        value(page, &margin, !fails(report, ReasonCode::NotSupported, name));
        value(page, &mm(object.outline_margin_m), object.inside_outline);
        value(page, &format!("{:.3} kg", instance.mass.mass_kg), true);
        let friction = &instance.friction;
        let words = format!("{} / {}", friction.static_coefficient, friction.dynamic_coefficient);
        value(page, &words, !fails(report, ReasonCode::ImplausibleFriction, name));
        page.close();
    }
    (0..3).for_each(|_| page.close());
}

fn stand_in(mark: &StandIn) -> String {
    match mark {
        StandIn { stands_for, shown_as } if stands_for.is_empty() || shown_as.is_empty() => {
            "stand-in".to_owned()
        }
        StandIn { stands_for, shown_as } => format!("stand-in for {stands_for}, shown as {shown_as}"),
    }
}

fn fails(report: &Report<'_>, code: ReasonCode, name: &str) -> bool {
    let reasons = &report.certificate.reasons;
    reasons.iter().any(|reason| reason.code == code && reason.bodies.iter().any(|body| body == name))
}

fn value(page: &mut Html, text: &str, good: bool) {
    page.leaf("td", &[("class", if good { "n" } else { "n bad" })], text);
}

fn number_cell(text: String, good: bool) -> Cell {
    if good { Cell::Number(text) } else { Cell::Bad(text) }
}
