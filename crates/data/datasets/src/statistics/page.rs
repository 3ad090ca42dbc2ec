//! `statistics.html`: one page without scripts, links or files, for screen and print.

use markup::html::{Cell, Html};
use std::collections::BTreeMap;

use super::charts::{Chart, Ticks};
use super::distribution::Distribution;
use super::{CategoryCount, Statistics};

/// Content security policy: the page loads nothing, whatever a category is called.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";

/// Categories with a bar of their own.
const SHOWN_CATEGORIES: usize = 30;

/// The text of the page; `title` names the dataset and its version.
pub fn write(title: &str, statistics: &Statistics) -> String {
    let mut page = Html::default();
    page.open("html", &[("lang", "en"), ("xmlns", "http://www.w3.org/1999/xhtml")]);
    page.open("head", &[]);
    page.void("meta", &[("charset", "utf-8")]);
    page.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
    page.void("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
    page.leaf("title", &[], &format!("Statistics of {title}"));
    page.style(include_str!("page.css"));
    page.close();
    page.open("body", &[]);
    page.open("main", &[]);
    summary(&mut page, title, statistics);
    section(&mut page, "Content", |page| content(page, statistics));
    section(&mut page, "Tables", |page| tables(page, statistics));
    section(&mut page, "Yield", |page| selection(page, statistics));
    section(&mut page, "Numbers", |page| numbers(page, statistics));
    format!("<!DOCTYPE html>\n{}", page.finish())
}

fn summary(page: &mut Html, title: &str, statistics: &Statistics) {
    page.leaf("h1", &[], title);
    let words = format!(
        "{} scenes with {} objects of {} categories; {} stand-ins for objects that the catalog does not have.",
        statistics.scenes,
        statistics.objects,
        statistics.categories.len(),
        statistics.stand_ins
    );
    page.leaf("p", &[], &words);
    let rows: Vec<Vec<String>> = statistics
        .splits
        .iter()
        .map(|split| {
            let per_scene = split.objects as f64 / split.scenes.max(1) as f64;
            vec![
                split.name.clone(),
                percent(split.ratio),
                percent(split.share),
                split.scenes.to_string(),
                split.objects.to_string(),
                format!("{per_scene:.1}"),
            ]
        })
        .collect();
    table(page, &["Split", "Asked for", "Share", "Scenes", "Objects", "Objects per scene"], rows);
}

fn content(page: &mut Html, statistics: &Statistics) {
    let chart = |title, axis, counted| Chart { title, axis, counted };
    chart("Objects per scene", "objects in a scene", "scenes").columns(
        page,
        &statistics.objects_per_scene,
        Ticks::Columns,
    );
    chart("Clutter", "share of the table top that objects cover (1 = all of it)", "scenes").columns(
        page,
        &statistics.covered_share,
        Ticks::Edges,
    );
    let names = categories(&statistics.categories);
    let title = match statistics.categories.len() {
        all if all > SHOWN_CATEGORIES => format!("The {SHOWN_CATEGORIES} largest of {all} categories"),
        _ => "Categories".to_owned(),
    };
    chart(&title, "category", "objects").rows(page, &names);
    chart("Support depth", "levels above the table (1 = on the table)", "objects").columns(
        page,
        &statistics.support_depth,
        Ticks::Columns,
    );
    chart("Support relations", "relation to the supporter", "objects")
        .rows(page, &pairs(&statistics.support_relations));
    chart("Sizes", "largest extent of an object, m", "objects").columns(
        page,
        &statistics.largest_extent_m,
        Ticks::Edges,
    );
    chart("Masses", "mass of an object, kg", "objects").columns(page, &statistics.mass_kg, Ticks::Edges);
}

fn tables(page: &mut Html, statistics: &Statistics) {
    let chart = |title, axis, counted| Chart { title, axis, counted };
    chart("Table shapes", "shape", "scenes").rows(page, &pairs(&statistics.table_shapes));
    chart("Table models", "model", "scenes").rows(page, &pairs(&statistics.table_models));
    chart("Table areas", "area of the table top, m²", "scenes").columns(
        page,
        &statistics.table_area_m2,
        Ticks::Edges,
    );
}

fn selection(page: &mut Html, statistics: &Statistics) {
    let selection = &statistics.selection;
    let chart = |title, axis, counted| Chart { title, axis, counted };
    let title = match statistics.yield_share {
        Some(share) => format!("From requests to the dataset: yield {}", percent(share)),
        None => "From requests to the dataset".to_owned(),
    };
    let steps = [
        ("requested", selection.requested),
        ("finished", selection.read),
        ("passed all checks", selection.passed),
        ("in the dataset", statistics.scenes),
    ];
    chart(&title, "step", "scenes").rows(page, &steps.map(|(name, count)| (name.to_owned(), count)));
    let lists = [
        ("Quarantine reasons (a scene may have several)", "failed check", &selection.quarantine_reasons),
        ("Left out by the filter", "condition not met", &selection.left_out),
        ("Requests without a bundle", "state", &selection.without_bundle),
    ];
    for (title, axis, counts) in lists.into_iter().filter(|(_, _, counts)| !counts.is_empty()) {
        chart(title, axis, "scenes").rows(page, &pairs(counts));
    }
}

fn numbers(page: &mut Html, statistics: &Statistics) {
    let quantities: [(&str, &Distribution); 6] = [
        ("objects per scene", &statistics.objects_per_scene),
        ("covered share of the table", &statistics.covered_share),
        ("support depth", &statistics.support_depth),
        ("largest extent, m", &statistics.largest_extent_m),
        ("mass, kg", &statistics.mass_kg),
        ("table area, m²", &statistics.table_area_m2),
    ];
    let rows: Vec<Vec<String>> = quantities
        .into_iter()
        .map(|(name, of)| {
            let values = [of.min, of.median, of.mean, of.max].map(significant);
            std::iter::once(name.to_owned()).chain([of.count.to_string()]).chain(values).collect()
        })
        .collect();
    page.open("div", &[]);
    table(page, &["Quantity", "Values", "Min", "Median", "Mean", "Max"], rows);
    let licences: Vec<Vec<String>> =
        statistics.licences.iter().map(|(name, count)| vec![name.clone(), count.to_string()]).collect();
    table(page, &["License", "Objects"], licences);
    page.close();
}

/// A table whose first column names what the numbers beside it are of.
fn table(page: &mut Html, head: &[&str], rows: Vec<Vec<String>>) {
    let cell = |(column, text)| if column == 0 { Cell::Words(text) } else { Cell::Number(text) };
    page.table(
        "",
        head,
        rows.into_iter().map(|row| row.into_iter().enumerate().map(cell).collect()).collect(),
    );
}

fn section(page: &mut Html, title: &str, content: impl FnOnce(&mut Html)) {
    page.open("section", &[]);
    page.leaf("h2", &[], title);
    page.open("div", &[("class", "charts")]);
    content(page);
    page.close();
    page.close();
}

/// The largest categories, and the sum of the others.
fn categories(counts: &[CategoryCount]) -> Vec<(String, usize)> {
    let shown = counts.iter().take(SHOWN_CATEGORIES).map(|count| (count.category.clone(), count.objects));
    let others = counts.iter().skip(SHOWN_CATEGORIES).map(|count| count.objects).sum::<usize>();
    shown.chain((others > 0).then(|| ("all others".to_owned(), others))).collect()
}

fn pairs(counts: &BTreeMap<String, usize>) -> Vec<(String, usize)> {
    counts.iter().map(|(name, count)| (name.clone(), *count)).collect()
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Three significant digits.
fn significant(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => {
            let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 6);
            format!("{value:.*}", digits as usize)
        }
    }
}
