//! The verbs of instructions whose meaning a goal states, and which goals each may state.
//!
//! A goal is the state at the end. "Put", "lift" and "swap" ask for nothing but that state, so a robot that brings it
//! about has done what was said. "Shake", "pour" or "cut" ask for a motion that no goal states, and are not listed.
//! What is not listed is not performed.

use scene::text_account::PredicateKind;

/// Verbs that instructions may use, in words, for messages.
pub const PERFORMED: &str = "pick up, hold, put, place, move, push, take out, remove, stack, swap, turn and stand up \
                             objects: say what should be where at the end, such as \"put the apple in the bowl\"";

/// Predicates that a verb may state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum States {
    /// Place of an object, and its attitude.
    Places,
    /// As [`Self::Places`]; also that it is in the hand, or no longer where it was.
    Takes,
    Leaves,
    Inside,
    Above,
    Stacks,
    Swaps,
    Turns,
    TurnsOver,
    Upright,
    Topples,
    Opens,
    Closes,
    /// Nothing: a step without an end of its own ("find the mug and put it on the plate").
    Nothing,
}

const VERBS: &[(States, &[&str])] = &[
    (
        States::Places,
        &[
            "put",
            "place",
            "set",
            "lay",
            "drop",
            "move",
            "bring",
            "transfer",
            "carry",
            "deposit",
            "position",
            "reposition",
            "relocate",
            "shift",
            "deliver",
            "return",
            "arrange",
            "line",
            "leave",
            "pop",
            "stash",
            "plop",
            "plonk",
            "keep",
            "add",
            "rest",
            "park",
            "sort",
            "collect",
            "gather",
            "organize",
            "organise",
            "group",
            "store",
            "stow",
            "load",
            "tuck",
            "push",
            "pull",
            "slide",
            "drag",
            "shove",
            "nudge",
            "separate",
            "tidy",
        ],
    ),
    (
        States::Takes,
        &[
            "take", "remove", "get", "retrieve", "extract", "fetch", "unload", "unpack", "withdraw",
            "unstack", "pick", "lift", "raise", "hold", "grasp", "grab", "hoist", "grip", "clutch",
        ],
    ),
    (States::Leaves, &["empty", "clear"]),
    (States::Inside, &["insert", "stick", "stuff", "pack", "slot"]),
    (States::Above, &["cover"]),
    (States::Stacks, &["stack", "pile", "nest", "build", "construct", "form"]),
    (States::Swaps, &["swap", "exchange", "switch", "interchange", "trade", "change"]),
    (States::Turns, &["turn", "rotate", "reorient"]),
    (States::TurnsOver, &["flip", "invert"]),
    (States::Upright, &["stand", "straighten", "upright"]),
    (States::Topples, &["knock", "tip", "topple"]),
    (States::Opens, &["open"]),
    (States::Closes, &["close", "shut"]),
    (
        States::Nothing,
        &["find", "locate", "identify", "choose", "select", "look", "see", "check", "make", "ensure"],
    ),
];

/// Forms that no rule gives.
const IRREGULAR: &[(&str, &str)] = &[
    ("took", "take"),
    ("taken", "take"),
    ("got", "get"),
    ("gotten", "get"),
    ("brought", "bring"),
    ("laid", "lay"),
    ("held", "hold"),
    ("kept", "keep"),
    ("stood", "stand"),
    ("built", "build"),
    ("slid", "slide"),
    ("found", "find"),
    ("made", "make"),
    ("chosen", "choose"),
    ("seen", "see"),
    ("stuck", "stick"),
];

/// Predicates that a word may state as a verb, in any of its forms; `None` for a word that is no performed verb.
pub fn states(word: &str) -> Option<States> {
    let known = |base: &str| VERBS.iter().find(|(_, verbs)| verbs.contains(&base)).map(|(states, _)| *states);
    bases(word).iter().find_map(|base| known(base))
}

/// Whether a word is a verb that the robot performs, in any form.
pub fn is_performed(word: &str) -> bool {
    states(word).is_some()
}

/// Base forms of a word, the word itself first.
pub(crate) fn bases(word: &str) -> Vec<String> {
    let mut bases = vec![word.to_owned()];
    bases.extend(IRREGULAR.iter().filter(|(form, _)| *form == word).map(|(_, base)| (*base).to_owned()));
    for ending in ["ing", "ed", "es", "s", "d"] {
        let Some(stem) = word.strip_suffix(ending).filter(|stem| stem.len() > 1) else { continue };
        bases.push(stem.to_owned());
        bases.push(format!("{stem}e"));
        if let Some(stem) = stem.strip_suffix('i') {
            bases.push(format!("{stem}y"));
        }
        let mut letters = stem.chars().rev();
        if letters.next() == letters.next() {
            bases.push(stem[..stem.len() - 1].to_owned());
        }
    }
    bases
}

impl States {
    /// Whether a verb may state a predicate of this kind.
    pub fn includes(self, kind: PredicateKind) -> bool {
        use PredicateKind as P;
        let is_pose = matches!(kind, P::Upright | P::LyingOnSide | P::UpsideDown);
        let leaves = matches!(kind, P::OutOf | P::Off);
        let never = matches!(
            kind,
            P::PouredInto
                | P::UsedOn
                | P::Pressed
                | P::Opened
                | P::Closed
                | P::Rotated
                | P::Swapped
                | P::Lifted
        );
        match self {
            Self::Places => !never,
            Self::Takes => !never || kind == P::Lifted,
            Self::Leaves => leaves,
            Self::Inside => kind == P::In,
            Self::Above => kind == P::On,
            Self::Stacks => matches!(kind, P::StackedOn | P::On | P::In | P::Off),
            Self::Swaps => kind == P::Swapped,
            Self::Turns => kind == P::Rotated || is_pose,
            Self::TurnsOver => matches!(kind, P::UpsideDown | P::Upright),
            Self::Upright => kind == P::Upright || !never && !is_pose && !leaves,
            Self::Topples => kind == P::LyingOnSide,
            Self::Opens => kind == P::Opened,
            Self::Closes => matches!(kind, P::Closed | P::Opened),
            Self::Nothing => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_of_a_verb_is_known_and_no_other_word() {
        for (form, expected) in [
            ("puts", States::Places),
            ("placing", States::Places),
            ("carries", States::Places),
            ("dropped", States::Places),
            ("moved", States::Places),
            ("pushes", States::Places),
            ("taken", States::Takes),
            ("grabbing", States::Takes),
            ("stacked", States::Stacks),
            ("swapping", States::Swaps),
            ("flipped", States::TurnsOver),
            ("closed", States::Closes),
        ] {
            assert_eq!(states(form), Some(expected), "{form}");
        }
        for other in ["shake", "crack", "hand", "throw", "pours", "cutting", "red", "apple", "bowl", "is"] {
            assert_eq!(states(other), None, "{other}");
        }
    }

    #[test]
    fn motions_without_an_end_are_stated_by_no_verb() {
        for (states, _) in VERBS {
            for kind in [PredicateKind::PouredInto, PredicateKind::UsedOn, PredicateKind::Pressed] {
                assert!(!states.includes(kind), "{states:?} {kind:?}");
            }
        }
        assert!(
            States::Takes.includes(PredicateKind::Lifted) && !States::Places.includes(PredicateKind::Lifted)
        );
    }
}
