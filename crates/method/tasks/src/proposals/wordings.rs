//! Three wordings of a goal.

use std::collections::BTreeMap;

use scene::InstanceId;
use scene::text_account::{GoalPredicate, PredicateKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::candidates::Candidate;
use super::references::References;
use crate::task_scene::TaskScene;

/// The same task as three people would say it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wordings {
    /// With wide nouns, which may fit several objects.
    pub vague: String,
    /// In a plain sentence that names each object once and clearly.
    pub default: String,
    /// With colors and places, and with each motion.
    pub specific: String,
}

/// Level of detail of a wording.
#[derive(Clone, Copy, PartialEq)]
enum Detail {
    Vague,
    Default,
    Specific,
}

impl Wordings {
    /// The wordings of a goal; `None` for predicates that are not proposed.
    pub(super) fn of(candidate: &Candidate, scene: &TaskScene) -> Option<Self> {
        let mut references: BTreeMap<&InstanceId, References> = BTreeMap::new();
        for name in candidate.goal.named_objects() {
            references.insert(name, References::of(scene, scene.index_of(name)?));
        }
        let word = |detail: Detail| -> Option<String> {
            let steps: Option<Vec<String>> = candidate
                .goal
                .predicates()
                .iter()
                .map(|predicate| clause(predicate, detail, &references))
                .collect();
            Some(sentence(&steps?))
        };
        Some(Self {
            vague: word(Detail::Vague)?,
            default: word(Detail::Default)?,
            specific: word(Detail::Specific)?,
        })
    }
}

/// Clauses as one sentence.
fn sentence(steps: &[String]) -> String {
    let text = steps.join(", then ");
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn clause(
    predicate: &GoalPredicate,
    detail: Detail,
    references: &BTreeMap<&InstanceId, References>,
) -> Option<String> {
    use PredicateKind as P;
    let phrase = |name: &InstanceId| -> Option<&str> {
        let references = references.get(name)?;
        Some(match detail {
            Detail::Vague => &references.vague,
            Detail::Default => &references.default,
            Detail::Specific => &references.specific,
        })
    };
    let a = phrase(&predicate.object)?;
    let b = match &predicate.target {
        Some(target) => phrase(target)?,
        None => "",
    };
    let placed = |place: &str| match detail {
        Detail::Vague => format!("get {a} {place} {b}"),
        Detail::Default => format!("put {a} {place} {b}"),
        Detail::Specific => format!("pick up {a} and place it {place} {b}"),
    };
    Some(match predicate.predicate {
        P::In => placed("in"),
        P::On => placed("on"),
        P::NextTo => placed("next to"),
        P::LeftOf => placed("to the left of"),
        P::RightOf => placed("to the right of"),
        P::StackedOn => match detail {
            Detail::Vague | Detail::Default => format!("stack {a} on {b}"),
            Detail::Specific => format!("pick up {a} and stack it on {b}"),
        },
        P::Swapped => match detail {
            Detail::Vague => format!("let {a} and {b} trade places"),
            Detail::Default => format!("swap {a} and {b}"),
            Detail::Specific => format!("put {a} where {b} is, and {b} where {a} was"),
        },
        P::Lifted => match detail {
            Detail::Vague => format!("take {a}"),
            Detail::Default => format!("pick up {a}"),
            Detail::Specific => format!("grasp {a} and lift it up"),
        },
        _ => return None,
    })
}
