//! The table of metrics against the documents that name them. What a server exposes is compared in `tests/it`.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::*;

const OPERATIONS: &str = include_str!("../../../docs/operations.md");
const DASHBOARD: &str = include_str!("../../../docker/grafana/dashboards/tabletopgen.json");
const ALERTS: &str = include_str!("../../../docker/prometheus/alerts.yaml");

fn known() -> BTreeMap<&'static str, Metric> {
    METRICS.iter().map(|metric| (metric.name, *metric)).collect()
}

/// The names of metrics in a query, with the labels that the query selects or groups by.
fn named(query: &str) -> BTreeSet<&str> {
    query
        .split(|character: char| !(character.is_ascii_alphanumeric() || character == '_'))
        .filter(|word| word.starts_with("tabletopgen_") || word.starts_with("process_"))
        .collect()
}

/// The metric whose series a name in a query is; histograms have three.
fn family(name: &str) -> Option<Metric> {
    let known = known();
    let of_histogram = ["_bucket", "_sum", "_count"].iter().find_map(|end| {
        let metric = known.get(name.strip_suffix(end)?)?;
        (metric.kind == Kind::Histogram).then_some(*metric)
    });
    of_histogram.or_else(|| known.get(name).copied().filter(|metric| metric.kind != Kind::Histogram))
}

#[test]
fn table_of_the_handbook_is_the_table_of_the_program() {
    let rows: Vec<&str> = OPERATIONS
        .lines()
        .filter(|line| line.starts_with("| `tabletopgen_") || line.starts_with("| `process_"))
        .collect();
    let expected: Vec<String> = METRICS
        .iter()
        .map(|metric| {
            let labels: Vec<String> = metric.labels.iter().map(|label| format!("`{label}`")).collect();
            let labels = if labels.is_empty() { "-".to_owned() } else { labels.join(", ") };
            format!("| `{}` | {} | {labels} | {} |", metric.name, metric.kind.as_str(), metric.help)
        })
        .collect();
    assert_eq!(rows, expected, "rows of docs/operations.md and METRICS differ");
}

#[test]
fn names_are_unique_and_follow_the_conventions() {
    assert_eq!(known().len(), METRICS.len());
    for Metric { name, kind, labels, .. } in METRICS {
        assert_eq!(name.ends_with("_total"), *kind == Kind::Counter, "{name}");
        assert!(*kind != Kind::Histogram || name.ends_with("_seconds"), "{name} has no buckets");
        assert!(labels.is_sorted(), "{name}");
    }
}

#[test]
fn every_query_of_the_dashboard_names_metrics_that_exist() {
    let dashboard: Value = serde_json::from_str(DASHBOARD).expect("is JSON");
    let panels = dashboard["panels"].as_array().expect("has panels");
    let queries: Vec<&str> = panels
        .iter()
        .flat_map(|panel| panel["targets"].as_array().into_iter().flatten())
        .map(|target| target["expr"].as_str().expect("has a query"))
        .collect();
    assert!(queries.len() > 30, "{} queries", queries.len());
    let mut shown = BTreeSet::new();
    for query in queries {
        let names = named(query);
        assert!(!names.is_empty(), "{query}");
        for name in names {
            let metric = family(name).unwrap_or_else(|| panic!("{name} in {query}"));
            shown.insert(metric.name);
        }
    }
    let left_out: Vec<&str> = known().into_keys().filter(|name| !shown.contains(name)).collect();
    let not_worth_a_panel = ["process_start_time_seconds", "process_virtual_memory_bytes"];
    assert_eq!(left_out, not_worth_a_panel, "metrics that the dashboard does not show");
}

#[test]
fn every_alert_names_metrics_that_exist_and_has_a_runbook() {
    let rules: Value = serde_norway::from_str(ALERTS).expect("is YAML");
    let rules = rules["groups"][0]["rules"].as_array().expect("has rules");
    assert!(rules.len() >= 15, "{} rules", rules.len());
    for rule in rules {
        let (alert, query) =
            (rule["alert"].as_str().expect("a name"), rule["expr"].as_str().expect("a query"));
        for name in named(query) {
            assert!(family(name).is_some(), "{name} in {alert}");
        }
        let heading = format!("### {alert}");
        assert!(OPERATIONS.lines().any(|line| line == heading), "{alert} has no runbook");
        let anchor = format!("docs/operations.md#{}", alert.to_ascii_lowercase());
        assert_eq!(rule["annotations"]["runbook"], anchor.as_str(), "{alert}");
        assert!(
            rule["annotations"]["summary"].is_string() && rule["labels"]["severity"].is_string(),
            "{alert}"
        );
    }
    let alerts: BTreeSet<&str> = rules.iter().filter_map(|rule| rule["alert"].as_str()).collect();
    for heading in OPERATIONS.lines().filter_map(|line| line.strip_prefix("### Tabletopgen")) {
        assert!(
            alerts.contains(format!("Tabletopgen{heading}").as_str()),
            "a runbook without an alert: {heading}"
        );
    }
}
