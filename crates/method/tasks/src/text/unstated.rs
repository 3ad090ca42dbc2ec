//! Parts of an instruction that no goal states: recipients, amounts, turns to a direction, conditions and negations.

use scene::text_account::{GoalPredicate, PredicateKind};

use super::verb_check::{Sentence, not_performed};
use crate::refusal::Refusal;
use language::performed::states;

const PERSONS: &[&str] = &[
    "somebody",
    "someone",
    "anybody",
    "anyone",
    "person",
    "people",
    "human",
    "user",
    "man",
    "woman",
    "child",
    "boy",
    "girl",
    "guest",
    "customer",
    "operator",
    "friend",
    "colleague",
    "mother",
    "father",
    "owner",
    "patient",
];
const ARMS: &[&str] =
    &["arm", "arms", "hand", "hands", "gripper", "grippers", "palm", "manipulator", "robot"];
/// Words between a preposition and a person or an arm.
const DESCRIBING: &[&str] = &[
    "the", "a", "an", "your", "my", "his", "her", "its", "our", "their", "left", "right", "other", "another",
    "second", "first", "one", "robot", "robots", "robotic",
];
const CONDITIONS: &[&str] = &["if", "unless", "otherwise", "whenever", "until", "till"];
const UNITS: &[&str] = &[
    "cm",
    "mm",
    "m",
    "centimeter",
    "centimeters",
    "centimetre",
    "centimetres",
    "millimeter",
    "millimeters",
    "meter",
    "meters",
    "metre",
    "metres",
    "inch",
    "inches",
    "foot",
    "feet",
    "degree",
    "degrees",
    "seconds",
    "minute",
    "minutes",
    "times",
    "turn",
    "turns",
];
const REPETITIONS: &[&str] =
    &["twice", "thrice", "repeatedly", "clockwise", "counterclockwise", "anticlockwise"];
const NUMBERS: &[&str] = &[
    "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "twelve", "fifteen",
    "twenty", "thirty", "forty", "fifty", "sixty", "ninety", "hundred", "half", "quarter", "full", "few",
    "several", "a",
];
/// Words that say where something turns or moves to.
const DIRECTIONS: &[&str] = &[
    "left",
    "right",
    "forward",
    "forwards",
    "backward",
    "backwards",
    "back",
    "front",
    "toward",
    "towards",
    "closer",
    "nearer",
    "further",
    "farther",
];
const FACINGS: &[&str] =
    &["face", "faces", "facing", "point", "points", "pointing", "handle", "toward", "towards"];

/// Refuses what the goal of a sentence leaves out.
///
/// # Errors
///
/// [`Refusal::VerbNotPerformed`] for a recipient, [`Refusal::InstructionNotUnderstood`] for the rest.
pub(super) fn unstated(sentence: &Sentence, predicates: &[GoalPredicate]) -> Result<(), Refusal> {
    let all = || 0..sentence.words.len();
    if let Some((from, to)) = all().find_map(|at| recipient(sentence, at)) {
        return Err(not_performed(sentence.words_of(from..to)));
    }
    // "Two plates 20 cm apart. Move the apple to the other plate": what comes before the instruction is described.
    let begin = sentence.first_instruction();
    let unsaid = all().find_map(|at| {
        condition(sentence, at).or_else(|| amount(sentence, at).filter(|(from, _)| *from >= begin))
    });
    let unsaid = unsaid.or_else(|| all().find_map(|at| negation(sentence, at)));
    let unsaid = unsaid.or_else(|| all().find_map(|at| direction(sentence, at, predicates)));
    match unsaid {
        Some((from, to)) => {
            let parts = vec![sentence.words_of(from..to).to_owned()];
            Err(Refusal::InstructionNotUnderstood { parts })
        }
        None => Ok(()),
    }
}

/// A range of words.
type WordRange = Option<(usize, usize)>;

/// "bring me", "to the person", "to the right arm": a recipient, from the verb or preposition on.
fn recipient(sentence: &Sentence, at: usize) -> WordRange {
    let word = sentence.word(Some(at));
    let before = sentence.word(at.checked_sub(1));
    if matches!(word, "me" | "us" | "him") {
        let is_given = matches!(before, "to" | "into" | "onto") || states(before).is_some();
        return is_given.then(|| (at - 1, at + 1));
    }
    let is_arm = ARMS.contains(&word) && sentence.word(Some(at + 1)) != "side";
    // "the robot arm", and a toy.
    let is_other_robot =
        word == "robot" && (sentence.is_noun[at] || ARMS.contains(&sentence.word(Some(at + 1))));
    if !is_arm && !PERSONS.contains(&word) || is_other_robot {
        return None;
    }
    let start = (0..at).rev().find(|&k| !DESCRIBING.contains(&sentence.word(Some(k))))?;
    let is_other = (start + 1..at).any(|k| matches!(sentence.word(Some(k)), "other" | "another" | "second"));
    match sentence.word(Some(start)) {
        "to" | "into" | "onto" => Some((start, at + 1)),
        "from" if is_arm => Some((start, at + 1)),
        // One arm is there.
        "both" | "two" if is_arm => Some((start, at + 1)),
        _ if is_arm && is_other => Some((start + 1, at + 1)),
        "between" if is_arm => Some((start, at + 1)),
        _ => None,
    }
}

/// "if the apple is ripe", but not "if you could" and "it would be nice if".
fn condition(sentence: &Sentence, at: usize) -> WordRange {
    let word = sentence.word(Some(at));
    if !CONDITIONS.contains(&word) || sentence.is_noun[at] {
        return None;
    }
    let asks = word == "if"
        && (matches!(sentence.word(Some(at + 1)), "you" | "possible" | "u")
            || matches!(
                sentence.word(at.checked_sub(1)),
                "nice"
                    | "great"
                    | "good"
                    | "lovely"
                    | "happy"
                    | "it"
                    | "wondering"
                    | "wonder"
                    | "grateful"
                    | "helpful"
                    | "glad"
                    | "see"
            ));
    let end = (at + 1..sentence.words.len()).find(|&k| sentence.is_after_pause(k));
    (!asks).then(|| (at, end.unwrap_or(sentence.words.len())))
}

/// "10 cm", "three times", "a quarter turn", "clockwise".
fn amount(sentence: &Sentence, at: usize) -> WordRange {
    let word = sentence.word(Some(at));
    // "the 10 cm cube".
    if sentence.is_property[at] {
        return None;
    }
    let before = at.checked_sub(1)?;
    let number = sentence.word(Some(before));
    let is_number = number.starts_with(|c: char| c.is_ascii_digit()) || NUMBERS.contains(&number);
    let is_turn = matches!(word, "turn" | "turns") && !matches!(number, "half" | "quarter" | "full");
    if UNITS.contains(&word) && is_number && !is_turn && !sentence.is_after_pause(at) {
        return Some((before, at + 1));
    }
    let glued = word.trim_start_matches(|c: char| c.is_ascii_digit());
    if glued.len() < word.len() && UNITS.contains(&glued) || REPETITIONS.contains(&word) {
        return Some((at, at + 1));
    }
    None
}

/// "do not put".
fn negation(sentence: &Sentence, at: usize) -> WordRange {
    let is_negated = matches!(sentence.word(Some(at)), "not" | "dont" | "never" | "cannot" | "cant");
    let acts =
        states(sentence.word(Some(at + 1))).is_some() && !sentence.is_noun.get(at + 1).unwrap_or(&true);
    (is_negated && acts).then_some((at, at + 2))
}

/// The end of a turn, and the direction of a motion, where the goal only says that the object turns or moves.
fn direction(sentence: &Sentence, at: usize, predicates: &[GoalPredicate]) -> WordRange {
    let has = |kind: PredicateKind| predicates.iter().any(|predicate| predicate.predicate == kind);
    let word = sentence.word(Some(at));
    let is_left_out = has(PredicateKind::Rotated) && (FACINGS.contains(&word) || DIRECTIONS.contains(&word))
        || has(PredicateKind::Moved) && DIRECTIONS.contains(&word);
    let describes = sentence.is_property[at] || sentence.word(at.checked_sub(1)) == "the" && word != "handle";
    (is_left_out && !describes).then_some((at, at + 1))
}
