//! Counts in words and digits.

use super::lexicon::Lexicon;
use super::phrases::phrases;
use super::tokens::{Token, word};

/// The count at `at`: digits, number words, "a dozen", "two or three", "2 to 4", "3x", "exactly two".
pub(super) fn quantity(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<([u32; 2], usize)> {
    let before = phrases().list.hedges.length_at(tokens, at);
    let (range, length) = number_of(lexicon, tokens, at + before)?;
    if before > 0 && range[0] != range[1] {
        return None;
    }
    let range = match word(tokens, at) {
        Some("more") => range.map(|count| count.saturating_add(1)),
        Some("less" | "fewer") => range.map(|count| count.saturating_sub(1).max(1)),
        _ => range,
    };
    Some((range, before + length))
}

fn number_of(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<([u32; 2], usize)> {
    let vocabulary = lexicon.vocabulary;
    let single = |p: usize| -> Option<(u32, usize)> {
        match tokens.get(p)? {
            Token::Number(number) => {
                (number.fract() == 0.0 && *number >= 0.0).then_some((number.min(1e6) as u32, 1))
            }
            Token::Word(w) => {
                let first = *vocabulary.numbers.get(w)?;
                let second = word(tokens, p + 1).and_then(|next| vocabulary.numbers.get(next)).copied();
                match second {
                    Some(unit) if (20..100).contains(&first) && unit < 10 => Some((first + unit, 2)),
                    Some(100) if first < 10 => Some((first * 100, 2)),
                    _ => Some((first, 1)),
                }
            }
            _ => None,
        }
    };
    if let Some((low, length)) = single(at) {
        if word(tokens, at + length) == Some("dozen") {
            let of = usize::from(word(tokens, at + length + 1) == Some("of"));
            return Some(([low.saturating_mul(12); 2], length + 1 + of));
        }
        if matches!(word(tokens, at + length), Some("or" | "to"))
            && let Some((high, more)) = single(at + length + 1)
            && high > low
        {
            return Some(([low, high], length + 1 + more));
        }
        // "3x mug".
        let times =
            usize::from(word(tokens, at + length) == Some("x") && word(tokens, at + length + 1).is_some());
        let of = usize::from(word(tokens, at + length) == Some("of"));
        return Some(([low, low], length + of.max(times)));
    }
    let mut phrase = String::new();
    let mut best = None;
    for k in 0..4 {
        let Some(w) = word(tokens, at + k) else { break };
        if k > 0 {
            phrase.push(' ');
        }
        phrase.push_str(w);
        if let Some(&range) = vocabulary.quantities.get(&phrase) {
            let of = usize::from(word(tokens, at + k + 1) == Some("of") && !phrase.ends_with(" of"));
            best = Some((range, k + 1 + of));
        }
    }
    best
}
