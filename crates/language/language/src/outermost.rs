//! Words after a noun that mean the outermost of several objects: "furthest to the left", "nearest the front edge",
//! "closest to me".

/// Side of the table, as seen from the front edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
    Front,
    Back,
}

/// The side that the words at the start of a list name the outermost object of, and their number.
///
/// ```
/// use language::outermost::{Side, outermost};
///
/// let words = ["furthest", "to", "the", "left", "of", "all"];
/// assert_eq!(outermost(&words), Some((Side::Left, 4)));
/// assert_eq!(outermost(&["nearest", "the", "lamp"]), None);
/// ```
pub fn outermost(words: &[&str]) -> Option<(Side, usize)> {
    let word = |at: usize| words.get(at).copied().unwrap_or_default();
    let is_far = matches!(word(0), "furthest" | "farthest");
    let is_near = matches!(word(0), "nearest" | "closest" | "nearer" | "closer");
    if !is_far && !is_near {
        return None;
    }
    let mut at = 1;
    let away = matches!(word(at), "away" | "over" | "out");
    at += usize::from(away);
    let preposition = word(at);
    at += usize::from(matches!(preposition, "to" | "from" | "on" | "at" | "toward" | "towards"));
    let is_from = preposition == "from";
    if matches!(word(at), "me" | "us" | "you") {
        return Some((if is_far { Side::Back } else { Side::Front }, at + 1));
    }
    let has_article = word(at) == "the";
    at += usize::from(has_article);
    if matches!(word(at), "viewer" | "camera" | "user" | "robot") && has_article {
        return Some((if is_far { Side::Back } else { Side::Front }, at + 1));
    }
    let side = match word(at) {
        "left" => Side::Left,
        "right" => Side::Right,
        "front" => Side::Front,
        "back" | "rear" => Side::Back,
        _ => return None,
    };
    at += 1;
    at += usize::from(word(at) == "hand");
    let has_part = matches!(word(at), "edge" | "side" | "end");
    at += usize::from(has_part);
    // "furthest from the left edge" is the other way; "nearest the left mug" is near a mug.
    let names_object = is_near && !has_part && !word(at).is_empty() && !ENDS.contains(&word(at));
    if names_object {
        return None;
    }
    Some((if is_from { side.opposite() } else { side }, at))
}

/// Words that may follow without being a noun.
const ENDS: [&str; 16] = [
    ",", ".", "and", "in", "on", "to", "into", "onto", "next", "should", "is", "goes", "of", "with", "by",
    "behind",
];

impl Side {
    fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            Self::Front => Self::Back,
            Self::Back => Self::Front,
        }
    }
}
