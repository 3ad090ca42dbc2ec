//! Export of a task as a problem of BDDL, the language of LIBERO and BEHAVIOR tasks.
//!
//! BDDL is a dialect of PDDL (Srivastava et al., "BEHAVIOR: Benchmark for everyday household activities in virtual,
//! interactive, and ecological environments", 2021). The file has objects typed by category, the supports at the start
//! and the goal as a conjunction. Predicates have BEHAVIOR's names where it has them (`inside`, `ontop`, `nextto`,
//! `open`), else those of [`crate::goal::name_of`]; [`domain`] declares all of them. Poses are not expressed: they are
//! in `scene.json`.

use std::collections::BTreeMap;
use std::fmt::Write;

use scene::text_account::{GoalPredicate, PredicateKind};

use crate::goal::{name_of, named};
use crate::task::Task;
use crate::task_scene::TaskScene;

/// Name of the domain of the problems.
pub const DOMAIN: &str = "tabletopgen";

/// Name of the object that is the table.
const TABLE: &str = "table";

/// The problem of a task in a scene. `name` becomes the name of the problem; characters other than letters, digits, `_`
/// and `-` become `_`.
///
/// ```text
/// (define (problem apple_in_bowl)
///     (:domain tabletopgen)
///     (:objects apple_1 - apple bowl_1 - bowl table - table)
///     (:init (ontop apple_1 table) (ontop bowl_1 table))
///     (:goal (and (inside apple_1 bowl_1)))
/// )
/// ```
pub fn problem(name: &str, task: &Task, scene: &TaskScene) -> String {
    let mut text = String::new();
    let instruction: Vec<&str> = task.instruction.split_whitespace().collect();
    // Writing to a string does not fail.
    let _ = writeln!(text, "; {}", instruction.join(" "));
    let _ = writeln!(text, "(define (problem {})", symbol(name));
    let _ = writeln!(text, "    (:domain {DOMAIN})\n    (:objects");
    for (category, names) in by_category(scene) {
        let _ = writeln!(text, "        {} - {category}", names.join(" "));
    }
    let _ = writeln!(text, "    )\n    (:init");
    for object in scene.described() {
        let supporter = object.supporter;
        let below = supporter.parent.map_or(TABLE, |parent| scene.described()[parent].name.as_str());
        let predicate = if supporter.is_container() { "inside" } else { "ontop" };
        let _ = writeln!(text, "        ({predicate} {} {below})", object.name);
    }
    let _ = writeln!(text, "    )\n    (:goal\n        (and");
    for predicate in task.goal.predicates() {
        let _ = writeln!(text, "            {}", literal(predicate));
    }
    text.push_str("        )\n    )\n)\n");
    text
}

/// The domain that the problems name, with every predicate.
pub fn domain() -> String {
    let mut text = format!("(define (domain {DOMAIN})\n    (:requirements :strips)\n    (:predicates\n");
    for declaration in [
        "inside ?a ?b",
        "ontop ?a ?b",
        "nextto ?a ?b",
        "open ?a",
        "stacked_on ?a ?b",
        "left_of ?a ?b",
        "right_of ?a ?b",
        "in_front_of ?a ?b",
        "behind ?a ?b",
        "between ?a ?b ?c",
        "away_from ?a ?b",
        "at_center ?a",
        "at_back ?a",
        "at_front ?a",
        "at_left ?a",
        "at_right ?a",
        "at_back_left ?a",
        "at_back_right ?a",
        "at_front_left ?a",
        "at_front_right ?a",
        "swapped ?a ?b",
        "lifted ?a",
        "upright ?a",
        "lying_on_side ?a",
        "upside_down ?a",
        "rotated ?a",
        "moved ?a",
        "poured_into ?a ?b",
        "used_on ?a ?b",
        "pressed ?a",
    ] {
        let _ = writeln!(text, "        ({declaration})");
    }
    text.push_str("    )\n)\n");
    text
}

/// Objects and the table by type.
fn by_category(scene: &TaskScene) -> BTreeMap<String, Vec<&str>> {
    let mut types: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for object in scene.described() {
        types.entry(symbol(&object.category)).or_default().push(object.name.as_str());
    }
    types.entry(TABLE.to_owned()).or_default().push(TABLE);
    types
}

/// A predicate as a literal of BDDL.
fn literal(predicate: &GoalPredicate) -> String {
    use PredicateKind as P;
    let mut objects: Vec<&str> = named(predicate).map(scene::InstanceId::as_str).collect();
    let (name, negated) = match predicate.predicate {
        P::In => ("inside", false),
        P::OutOf => ("inside", true),
        P::On => ("ontop", false),
        P::Off => ("ontop", true),
        P::NextTo => ("nextto", false),
        P::Opened => ("open", false),
        P::Closed => ("open", true),
        kind => (name_of(kind), false),
    };
    if predicate.predicate == P::On && predicate.target.is_none() {
        objects.push(TABLE);
    }
    let atom = format!("({name} {})", objects.join(" "));
    if negated { format!("(not {atom})") } else { atom }
}

/// A name of the language.
fn symbol(text: &str) -> String {
    let lower = text.to_lowercase();
    let valid = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '_' | '-') { c } else { '_' };
    let symbol: String = lower.chars().map(valid).collect();
    if symbol.is_empty() { "_".to_owned() } else { symbol }
}
