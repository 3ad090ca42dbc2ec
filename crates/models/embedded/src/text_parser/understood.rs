//! The account of a text in the terms of the scene: object ids instead of mentions, spans of the text instead of
//! tokens.

use std::ops::Range;

use super::account::{Account, Claim, Claimed};
use super::arranged;
use super::draft::Draft;
use super::grammar::ParsedText;
use super::lexicon::{Lexicon, Meaning};
use super::property::{Property, colors};
use super::tokens::{Source, Token};
use scene::InstanceId;
use scene::text_account::{TextMeaning, TextSpan, Understood, Unrecognized, UnrecognizedReason};

/// Maximum number of parts of a text with their nearest known words.
const MAX_NEAREST: usize = 32;

pub(super) fn span_of(source: &Source, tokens: Range<usize>) -> TextSpan {
    let Range { start, end } = source.span(tokens);
    TextSpan { start, end, text: source.text[start..end].to_owned() }
}

/// Meanings of the tokens.
pub(super) fn understood(
    draft: &Draft,
    parsed: &ParsedText,
    source: &Source,
    theme: &str,
    predicate_of_goal: &[Option<usize>],
) -> Vec<Understood> {
    let ids = draft.ids();
    let of = |mentions: &[usize]| -> Vec<InstanceId> {
        mentions.iter().flat_map(|&m| draft.of_mention[m].iter().map(|&o| ids[o].clone())).collect()
    };
    let meaning_of = |claim: &Claim| -> Option<TextMeaning> {
        let words = |claim: &Claim| {
            if is_corrected(parsed, &claim.tokens) {
                return words_of(source, &claim.tokens);
            }
            span_of(source, claim.tokens.clone()).text.to_lowercase()
        };
        Some(match &claim.meaning {
            Claimed::Object(mention) => {
                let objects = of(&[*mention]);
                let first = draft.of_mention[*mention].first()?;
                TextMeaning::Object { category: draft.category(*first).name.clone(), objects }
            }
            Claimed::Property { property: Property::Color, mentions } => {
                let named = colors(draft.lexicon.vocabulary, &source.tokens, &claim.tokens);
                let has =
                    |object: &usize| draft.objects[*object].color.is_some_and(|color| named.contains(&color));
                let objects = mentions.iter().flat_map(|&m| draft.of_mention[m].iter().copied().filter(has));
                TextMeaning::Property {
                    property: Property::Color.name().to_owned(),
                    value: words(claim),
                    objects: objects.map(|object| ids[object].clone()).collect(),
                }
            }
            Claimed::Property { property, mentions } => TextMeaning::Property {
                property: property.name().to_owned(),
                value: words(claim),
                objects: of(mentions),
            },
            Claimed::Relation { kind, from, to } => {
                TextMeaning::Relation { relation: *kind, objects: of(from), targets: of(to) }
            }
            Claimed::Arrangement(index) => {
                let objects = of(&parsed.arrangements.get(*index)?.mentions);
                match arranged::index_of(draft, parsed, *index) {
                    Some(index) => TextMeaning::Arrangement { index, objects },
                    // A single object.
                    None => TextMeaning::Property {
                        property: Property::Arrangement.name().to_owned(),
                        value: words(claim),
                        objects,
                    },
                }
            }
            Claimed::Exclusion(meanings) => {
                TextMeaning::Exclusion { categories: categories_of(draft.lexicon, meanings) }
            }
            Claimed::Goal(index) => {
                TextMeaning::Goal { index: predicate_of_goal.get(*index).copied().flatten()? }
            }
            Claimed::Table => TextMeaning::Table,
            Claimed::Theme => TextMeaning::Theme { theme: theme.to_owned() },
            Claimed::Completion(complete) => TextMeaning::Completion { complete: *complete },
            Claimed::Correction(corrected) => TextMeaning::Correction { corrected: corrected.clone() },
            Claimed::Linked { .. } => return None,
        })
    };
    let mut understood: Vec<Understood> = parsed
        .account
        .claims
        .iter()
        .flat_map(|claim| {
            let meanings = match &claim.meaning {
                Claimed::Linked { from, to } => match linked(draft, from, to) {
                    // A list without a relation names its objects.
                    none if none.is_empty() => {
                        let named = |&m: &usize| Claim { meaning: Claimed::Object(m), ..claim.clone() };
                        from.iter().map(named).find_map(|claim| meaning_of(&claim)).into_iter().collect()
                    }
                    relations => relations,
                },
                _ => meaning_of(claim).into_iter().collect(),
            };
            let span = span_of(source, claim.tokens.clone());
            meanings.into_iter().map(move |meaning| Understood { span: span.clone(), meaning })
        })
        .collect();
    understood.sort_by_key(|part| (part.span.start, part.span.end));
    let mut understood = merged(understood);
    // The number of a list item and the key of a field belong to what they mark.
    let marked: Vec<Understood> = source
        .markers
        .iter()
        .filter_map(|marker| {
            let part = understood.iter().find(|part| part.span.start >= marker.end).or(understood.last())?;
            let Range { start, end } = marker.clone();
            let span = TextSpan { start, end, text: source.text[start..end].to_owned() };
            Some(Understood { span, meaning: part.meaning.clone() })
        })
        .collect();
    understood.extend(marked);
    understood.sort_by_key(|part| (part.span.start, part.span.end));
    understood
}

/// Parts with the same words and the same meaning are one about all of their objects: the name of objects that the text
/// then tells apart is that of all of them.
fn merged(parts: Vec<Understood>) -> Vec<Understood> {
    let mut merged: Vec<Understood> = Vec::new();
    for part in parts {
        let mut same = merged.iter_mut().rev().take_while(|known| known.span == part.span);
        let joined = same.any(|known| match (&mut known.meaning, &part.meaning) {
            (
                TextMeaning::Object { category, objects },
                TextMeaning::Object { category: other, objects: more },
            ) if category == other => join(objects, more),
            (
                TextMeaning::Property { property, objects, .. },
                TextMeaning::Property { property: other, objects: more, .. },
            ) if property == other => join(objects, more),
            (known, other) => known == other,
        });
        if !joined {
            merged.push(part);
        }
    }
    merged
}

/// The relations that objects of mentions have to those of others.
fn linked(draft: &Draft, from: &[usize], to: &[usize]) -> Vec<TextMeaning> {
    let ids = draft.ids();
    let objects = |mentions: &[usize]| -> Vec<usize> {
        mentions.iter().flat_map(|&m| draft.of_mention[m].iter().copied()).collect()
    };
    let (from, to) = (objects(from), objects(to));
    let mut meanings: Vec<TextMeaning> = Vec::new();
    for (subjects, targets) in [(&from, &to), (&to, &from)] {
        for &subject in subjects {
            let relations = draft.objects[subject].relations.iter();
            let related = relations.filter_map(|relation| Some((relation.kind, relation.to?)));
            for (kind, target) in related.filter(|(_, target)| targets.contains(target)) {
                let (object, target) = (ids[subject].clone(), ids[target].clone());
                let known = meanings.iter_mut().find_map(|meaning| match meaning {
                    TextMeaning::Relation { relation, objects, targets } if *relation == kind => {
                        Some((objects, targets))
                    }
                    _ => None,
                });
                match known {
                    Some((objects, targets)) => {
                        join(objects, &[object]);
                        join(targets, &[target]);
                    }
                    None => meanings.push(TextMeaning::Relation {
                        relation: kind,
                        objects: vec![object],
                        targets: vec![target],
                    }),
                }
            }
        }
    }
    meanings
}

/// Whether a word of the tokens is a corrected one.
fn is_corrected(parsed: &ParsedText, tokens: &Range<usize>) -> bool {
    parsed
        .account
        .claims
        .iter()
        .any(|claim| matches!(claim.meaning, Claimed::Correction(_)) && tokens.contains(&claim.tokens.start))
}

fn words_of(source: &Source, tokens: &Range<usize>) -> String {
    source.tokens[tokens.clone()].iter().filter_map(Token::word).collect::<Vec<_>>().join(" ")
}

fn join(known: &mut Vec<InstanceId>, more: &[InstanceId]) -> bool {
    let new: Vec<InstanceId> = more.iter().filter(|id| !known.contains(id)).cloned().collect();
    known.extend(new);
    true
}

/// Names of the categories of meanings; the members of vague sets.
pub(super) fn categories_of(lexicon: &Lexicon, meanings: &[Meaning]) -> Vec<String> {
    let mut names: Vec<String> = meanings
        .iter()
        .flat_map(|meaning| match meaning {
            Meaning::Category(index) => vec![lexicon.categories[*index].name.clone()],
            Meaning::Vague(index) => lexicon.themes.vague[*index].members.clone(),
            Meaning::Table(_) | Meaning::StandIn(_) => Vec::new(),
        })
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Words without effect, with the nearest known ones.
pub(super) fn unrecognized(lexicon: &Lexicon, account: &Account, source: &Source) -> Vec<Unrecognized> {
    let mut parts: Vec<Unrecognized> = Vec::new();
    for report in &account.reports {
        let unknown =
            matches!(report.reason, UnrecognizedReason::UnknownObject | UnrecognizedReason::UnknownWord);
        let name =
            source.tokens[report.tokens.clone()].iter().filter_map(Token::word).collect::<Vec<_>>().join(" ");
        let compared = unknown && parts.len() < MAX_NEAREST && name.len() <= 40;
        let nearest_by_spelling = if compared { nearest(lexicon, &name) } else { None };
        let singular = lexicon.vocabulary.singular_of(&name);
        let nearest_by_meaning =
            if compared { lexicon.nouns.nearest_by_meaning(&singular).map(str::to_owned) } else { None };
        let is_obstacle = unknown && lexicon.nouns.is_not_placeable(&singular);
        let reason = if is_obstacle { UnrecognizedReason::NotPlaceable } else { report.reason };
        let span = span_of(source, report.tokens.clone());
        parts.push(Unrecognized { span, reason, nearest_by_spelling, nearest_by_meaning });
    }
    parts
}

/// The known object that is spelled most similarly to a phrase, or to its last word.
fn nearest(lexicon: &Lexicon, name: &str) -> Option<String> {
    let last = name.rsplit(' ').next().unwrap_or_default();
    let whole = lexicon.closest(name, 1).into_iter().next();
    whole.or_else(|| lexicon.closest(last, 1).into_iter().next())
}
