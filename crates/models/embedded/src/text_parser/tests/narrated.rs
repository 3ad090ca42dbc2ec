//! Texts of `tests/words/narrated.jsonl`: what is said in other words than an imperative or a plain list.

use std::collections::BTreeMap;

use super::*;
use serde::Deserialize;

/// A text with what a person means by it; see `tests/words/README.md`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Narrated {
    id: String,
    #[expect(dead_code, reason = "for readers of the file")]
    kind: String,
    text: String,
    /// "2 red mug", "1 plate".
    objects: Vec<String>,
    /// "apple in bowl", each for at least one object; other supports are wrong.
    #[serde(default)]
    start: Vec<String>,
    /// "in apple bowl", one for each predicate.
    #[serde(default)]
    goal: Vec<String>,
    /// Words that are reported.
    #[serde(default)]
    reported: Vec<String>,
    /// Words that are reported where no goal is stated.
    #[serde(default)]
    or_reported: Vec<String>,
    #[serde(default)]
    #[expect(dead_code, reason = "for readers of the file")]
    aside: bool,
}

fn narrated() -> Vec<Narrated> {
    let lines = include_str!("../../../../../../tests/words/narrated.jsonl").lines();
    lines.map(|line| serde_json::from_str(line).expect(line)).collect()
}

fn name(value: &impl Serialize) -> String {
    let value = serde_json::to_value(value).expect("a name");
    value.as_str().expect("a string").to_owned()
}

fn objects_are(entry: &Narrated, description: &SceneDescription) -> Option<String> {
    let requested = || description.objects.iter().filter(|object| object.requested);
    let mut wanted: BTreeMap<&str, usize> = BTreeMap::new();
    for words in &entry.objects {
        let words: Vec<&str> = words.split(' ').collect();
        let (count, category): (usize, &str) = (words[0].parse().expect("a number"), words[words.len() - 1]);
        *wanted.entry(category).or_default() += count;
        if let [_, color, _] = words[..] {
            let color = color_of_word(color);
            let found = requested().filter(|o| o.category == category && o.color == color).count();
            if found != count {
                return Some(format!("{found} of {}", words.join(" ")));
            }
        }
    }
    let mut found: BTreeMap<&str, usize> = BTreeMap::new();
    for object in requested() {
        *found.entry(object.category.as_str()).or_default() += 1;
    }
    (found != wanted).then(|| format!("{found:?}"))
}

fn start_is(entry: &Narrated, description: &SceneDescription) -> Option<String> {
    let category = |id: &scene::InstanceId| {
        description
            .objects
            .iter()
            .find(|object| object.id == *id)
            .map_or("", |object| object.category.as_str())
    };
    let supports: Vec<String> = description
        .objects
        .iter()
        .filter(|object| object.requested)
        .flat_map(|object| {
            object.relations.iter().filter(|relation| relation.kind.is_support()).filter_map(|relation| {
                let target = category(relation.target.as_ref()?);
                Some(format!("{} {} {target}", object.category, name(&relation.kind)))
            })
        })
        .collect();
    let same = entry.start.iter().all(|start| supports.contains(start))
        && supports.iter().all(|support| entry.start.contains(support));
    (!same).then(|| format!("start {supports:?}"))
}

fn goal_is(entry: &Narrated, description: &SceneDescription) -> Option<String> {
    let category = |id: &scene::InstanceId| {
        description
            .objects
            .iter()
            .find(|object| object.id == *id)
            .map_or("", |object| object.category.as_str())
    };
    let predicates = description.goal.iter().flat_map(|goal| &goal.predicates);
    let mut found: Vec<String> = predicates
        .map(|predicate| {
            let kind = name(&predicate.predicate).replace("stacked_on", "on");
            let target = predicate.target.as_ref().map_or("", category);
            format!("{kind} {} {target}", category(&predicate.object)).trim().to_owned()
        })
        // Steps on the way.
        .filter(|stated| {
            !["lifted ", "moved ", "out_of ", "off "].iter().any(|step| stated.starts_with(step))
        })
        .collect();
    found.sort();
    let reports = |words: &String| {
        description
            .unrecognized
            .iter()
            .any(|part| part.span.text.to_lowercase().contains(&words.to_lowercase()))
    };
    if let Some(words) = entry.reported.iter().find(|words| !reports(words)) {
        return Some(format!("{words:?} is not reported"));
    }
    let mut wanted = entry.goal.clone();
    wanted.sort();
    let refused = found.is_empty() && !entry.or_reported.is_empty() && entry.or_reported.iter().all(reports);
    (found != wanted && !refused).then(|| format!("goal {found:?}"))
}

fn complaint(entry: &Narrated) -> Option<String> {
    let description = match describe(&entry.text, 3, &options(), &settings()) {
        Ok(description) => description,
        Err(error) => return Some(error.to_string()),
    };
    let wrong =
        [objects_are(entry, &description), start_is(entry, &description), goal_is(entry, &description)];
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    (!wrong.is_empty()).then(|| wrong.join("; "))
}

#[test]
fn what_is_narrated_is_read_or_reported_and_never_a_solved_start() {
    let wrong: Vec<String> = narrated()
        .iter()
        .filter_map(|entry| Some(format!("{} {:?}: {}", entry.id, entry.text, complaint(entry)?)))
        .collect();
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
