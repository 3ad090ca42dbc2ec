//! The certificate as a small table for people.

use std::fmt::Write as _;

use super::scene_summary::Outcome;
use super::text_account;
use certificate::{Certificate, ObjectCertificate, RobotFinding};
use scene::clutter::ClutterFinding;
use scene::text_account::TextAccount;

/// Verdict, metrics and objects of a finished scene, and where it lies.
pub fn table(outcome: &Outcome, total_ms: u128) -> String {
    let mut text = String::new();
    let verdict = if outcome.passed { "PASS" } else { "QUARANTINE" };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "scene {}  seed {}  {verdict}", outcome.scene_id, outcome.seed);
    let percent = |name: &str| {
        let share = outcome.metrics[name].as_f64();
        share.map_or_else(|| "?".to_owned(), |share| format!("{:.1} %", share * 100.0))
    };
    let scene_collides = match outcome.metrics["col_s"].as_f64() {
        Some(0.0) => "no",
        Some(_) => "yes",
        None => "?",
    };
    for (name, meaning, value) in [
        ("Col_O", "pairs that collide", percent("col_o").as_str()),
        ("Col_S", "anything collides", scene_collides),
        ("SS", "supported from below", &percent("ss")),
        ("DSS", "stay put for 5 s of gravity", &percent("dss_shipped")),
        ("", "the same before they were settled", &percent("dss_aligned")),
    ] {
        let _ = writeln!(text, "  {name:<6} {meaning:<34} {value:>8}");
    }
    if let Some(certificate) = &outcome.certificate {
        let _ = writeln!(text, "  {}", certificate.summary);
        objects(&mut text, certificate);
        if let Some(finding) = &certificate.clutter {
            text.push_str(&clutter(finding));
        }
        if let Some(finding) = &certificate.robot {
            text.push_str(&robot(finding));
        }
        for reason in &certificate.reasons {
            let _ = writeln!(text, "  quarantined: {}", reason.sentence);
        }
    }
    if let Ok(Some(account)) = serde_json::from_value::<Option<TextAccount>>(outcome.summary["text"].clone())
    {
        text.push_str(&text_account::table(&account, text_account::Detail::Objects));
    }
    if !outcome.passed {
        let _ = writeln!(text, "  the bundle was written to be inspected; do not train on it");
    }
    let _ = writeln!(text, "{}  {:.2} s", outcome.paths.bundle, total_ms as f64 / 1000.0);
    text
}

/// One line an object: how far inside its support, how far it moved, its hulls.
fn objects(text: &mut String, certificate: &Certificate) {
    let objects = &certificate.objects;
    if objects.is_empty() {
        return;
    }
    let name_of = |object: &ObjectCertificate| object.name.as_str().to_owned();
    let width = objects.iter().map(|object| name_of(object).len()).max().unwrap_or(0).max(6);
    let _ = writeln!(
        text,
        "  {:<width$} {:>10} {:>10} {:>7} {:>6}  ",
        "object", "margin mm", "moved mm", "turn", "hulls"
    );
    for object in objects {
        let mut flaws = Vec::new();
        if !object.inside_outline {
            flaws.push("over the edge");
        }
        let health = certificate.bodies.iter().find(|body| body.name == object.name.as_str());
        if health.is_some_and(|health| !health.watertight) {
            flaws.push("not watertight");
        }
        if object.support_margin_m.is_none_or(|margin| margin < 0.0) {
            flaws.push("not supported");
        }
        let margin = object.support_margin_m.map_or("-".to_owned(), |m| format!("{:.1}", m * 1000.0));
        let line = format!(
            "  {:<width$} {:>10} {:>10.2} {:>6.1}° {:>6}  {}",
            name_of(object),
            margin,
            object.moved.from_aligned.distance_m * 1000.0,
            object.moved.from_aligned.angle_rad.to_degrees(),
            health.map_or(0, |health| health.hulls),
            flaws.join(", ")
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

/// Clutter of the scene in a line.
fn clutter(finding: &ClutterFinding) -> String {
    let (covered, hidden) = (100.0 * finding.covered_share, 100.0 * finding.hidden_share);
    format!(
        "  clutter: {covered:.0} % of the heap's area is covered, {} of {} objects touch others ({:.1} each), {hidden:.0} \
         % are hidden by a quarter or more\n",
        finding.touching,
        finding.objects.len(),
        finding.mean_contacts
    )
}

/// Abilities of a robot in the scene: a line with the counts, and one for each task.
fn robot(finding: &RobotFinding) -> String {
    let RobotFinding { name, objects, pickable, tasks_proposed, tasks_done, tasks } = finding;
    let mut text = format!(
        "  {name} picks up {pickable} of {objects} objects and does {tasks_done} of {tasks_proposed} tasks\n"
    );
    for task in tasks {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    {:<12} {}", task.outcome, task.instruction);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use certificate::TaskTried;

    #[test]
    fn counts_and_tasks_of_a_robot_have_lines() {
        let tried = |instruction: &str, outcome: &str| TaskTried {
            instruction: instruction.to_owned(),
            outcome: outcome.to_owned(),
        };
        let finding = RobotFinding {
            name: "panda".to_owned(),
            objects: 3,
            pickable: 2,
            tasks_proposed: 2,
            tasks_done: 1,
            tasks: vec![tried("Lift the mug.", "done"), tried("Put the mug on the tray.", "no_path")],
        };
        let expected = "  panda picks up 2 of 3 objects and does 1 of 2 tasks\n    done         Lift the mug.\n    \
                        no_path      Put the mug on the tray.\n";
        assert_eq!(robot(&finding), expected);
    }
}
