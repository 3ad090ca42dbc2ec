//! Categories of the user: files that `catalog.paths` names, and their check.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const SPINNER: &str = r##"
[[category]]
name = "spinning_disk"
label = "spinning disk"
synonyms = ["gyrodisk"]
families = ["office_living"]
group = "decor"
size = { low_m = [0.09, 0.09, 0.02], high_m = [0.11, 0.11, 0.03] }
palette = ["#2f63b5"]
substance = "plastic"
mass_kg = 0.1
facing = "any"
symmetry_order = 0
zone = "any"
[category.shape]
part = [{ cylinder = { radius = 0.05, height = 0.025, edge = 0.002, segments = 64 } }]
"##;

fn run(home: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(home).output().expect("starts")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn a_text_names_a_category_of_the_user() {
    let home = tempfile::tempdir().unwrap();
    std::fs::create_dir(home.path().join("own")).unwrap();
    std::fs::write(home.path().join("own/spinner.toml"), SPINNER).unwrap();
    std::fs::write(home.path().join("own/notes.txt"), "no categories").unwrap();
    let own = ["--set", "catalog.paths=own"];
    let parsed = |more: &[&str]| {
        let done = run(home.path(), &[&["parse", "--json", "a gyrodisk beside a mug"], more].concat());
        json(&done)["text"]["understood"].clone()
    };
    let of_category = |understood: &Value, name: &str| {
        understood.as_array().expect("a list").iter().filter(|meaning| meaning["category"] == name).count()
    };
    assert_eq!(of_category(&parsed(&own), "spinning_disk"), 1);
    assert_eq!(of_category(&parsed(&[]), "spinning_disk"), 0, "only where it is configured");
    let shown = run(home.path(), &["catalog", "show", "gyrodisk", "--json", "--set", "catalog.paths=own"]);
    assert_eq!(json(&shown)["name"], "spinning_disk");
}

#[test]
fn a_category_file_is_checked() {
    let home = tempfile::tempdir().unwrap();
    let check = |text: &str| {
        std::fs::write(home.path().join("own.toml"), text).unwrap();
        run(home.path(), &["catalog", "check", "own.toml", "--json", "--sheet", "own.png", "--force"])
    };
    let sound = check(SPINNER);
    assert_eq!(sound.status.code(), Some(0));
    let findings = json(&sound);
    assert_eq!(
        (&findings["sound"], &findings["categories"][0]["name"]),
        (&true.into(), &"spinning_disk".into())
    );
    let mass_kg = findings["categories"][0]["objects"][0]["mass_kg"].as_f64().expect("a mass");
    assert!((0.05..0.2).contains(&mass_kg), "{mass_kg}");
    assert!(std::fs::read(home.path().join("own.png")).expect("a sheet").starts_with(b"\x89PNG"));

    // On a ball it does not stand.
    let ball = r#"part = [{ ball = { size = [0.1, 0.1, 0.025] } }, { cylinder = { radius = 0.01, height = 0.02 }, at = [0.03, 0, 0.02] }]"#;
    let part = SPINNER.lines().find(|line| line.starts_with("part")).expect("a part");
    let tips = check(&SPINNER.replace(part, ball));
    assert_eq!(tips.status.code(), Some(1));
    let objections = json(&tips)["categories"][0]["objections"].to_string();
    assert!(
        objections.contains("alone on a table") && objections.contains("symmetry order 0"),
        "{objections}"
    );

    for (from, to, says) in [
        ("spinning_disk", "mug", "mug has the name"),
        ("height = 0.025", "height = 0.0", "no solid"),
        ("plastic", "unobtainium", "no substance"),
        ("zone", "zones", "zones"),
    ] {
        let refused = check(&SPINNER.replace(from, to));
        let complaint = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{complaint}");
        assert!(complaint.contains(says) && complaint.contains("own.toml"), "{complaint}");
    }
}
