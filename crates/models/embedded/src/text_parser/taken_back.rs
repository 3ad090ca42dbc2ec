//! Corrections within a sentence ("four oranges, no wait, six"): tokens as they are meant.

use std::ops::Range;

use super::tokens::{Source, Token};
use language::repair::{SelfRepair, repairs};

/// Drops the tokens that the text takes back. Their bytes count as a part of what stands for them.
pub(super) fn take_back(source: &mut Source) {
    for repair in repairs(&source.text) {
        let mut meant: Vec<(Token, Range<usize>)> = Vec::with_capacity(source.tokens.len());
        let of_source = || source.tokens.iter().cloned().zip(source.spans.iter().cloned());
        for (token, span) in of_source() {
            match &repair.replaced {
                Some((old, _)) if is_within(&span, old) && span.start > old.start => {}
                Some((old, new)) if is_within(&span, old) => {
                    meant.extend(of_source().filter(|(_, span)| is_within(span, new)));
                }
                _ if is_within(&span, &repair.retracted) => {}
                _ => meant.push((token, span)),
            }
        }
        (source.tokens, source.spans) = meant.into_iter().unzip();
        source.markers.extend(unused(repair));
    }
}

fn is_within(span: &Range<usize>, range: &Range<usize>) -> bool {
    range.start <= span.start && span.end <= range.end
}

/// Bytes of a correction that no token has.
fn unused(SelfRepair { retracted, replaced }: SelfRepair) -> Vec<Range<usize>> {
    match replaced {
        Some((old, new)) if is_within(&new, &retracted) => {
            let around = [retracted.start..new.start, new.end..retracted.end];
            [old].into_iter().chain(around).filter(|range| !range.is_empty()).collect()
        }
        Some((old, _)) => vec![retracted, old],
        None => vec![retracted],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_those_that_are_meant_and_no_byte_is_lost() {
        for (text, expected) in [
            ("four oranges, no wait, six, in a basket", "six oranges , in a basket"),
            ("a red mug, I mean a blue one", "a blue mug"),
            ("a cup - no, two bowls - on it", "two bowls , on it"),
        ] {
            let mut source = Source::read(text);
            take_back(&mut source);
            let words: Vec<&str> = source.tokens.iter().map(|token| token.word().unwrap_or(",")).collect();
            assert_eq!(words.join(" "), expected);
            let is_there =
                |at: usize| source.spans.iter().chain(&source.markers).any(|span| span.contains(&at));
            let lost = text.char_indices().find(|(at, c)| c.is_alphanumeric() && !is_there(*at));
            assert_eq!(lost, None, "{text}");
        }
    }
}
