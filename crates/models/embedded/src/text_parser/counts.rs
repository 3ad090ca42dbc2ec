//! Instantiates mentions: number and categories of their objects.

use std::collections::BTreeSet;

use rand::RngExt;

use super::DescribeError;
use super::account::Claimed;
use super::draft::{Draft, Kind};
use super::grammar::{LinkKind, Mention, ParsedText};
use super::lexicon::Meaning;
use super::place_settings;
use super::property::{Property, number};
use super::themes::VagueSet;
use super::tokens::Source;
use runtime::seed::child_rng;
use scene::RelationKind;

/// Creates the objects of every mention. The limit is checked before the first one is created.
pub(super) fn instantiate(draft: &mut Draft, parsed: &ParsedText, limit: usize) -> Result<(), DescribeError> {
    let counts: Vec<usize> = (0..parsed.mentions.len()).map(|m| instances(draft, parsed, m, 0)).collect();
    let total = parsed
        .mentions
        .iter()
        .zip(&counts)
        .map(|(mention, &count)| count.saturating_mul(objects_per_unit(draft, mention)))
        .fold(0_usize, usize::saturating_add);
    if total > limit {
        return Err(DescribeError::TooManyObjects { count: total, limit });
    }
    for (m, mention) in parsed.mentions.iter().enumerate() {
        let mut made = Vec::new();
        match open_box(draft, parsed, m).or_else(|| sense(draft, mention)) {
            Some(meaning @ (Meaning::Category(_) | Meaning::StandIn(_))) => {
                for k in 0..counts[m] {
                    let Some(kind) = draft.lexicon.kind(&meaning) else { break };
                    let kind = match &mention.stand_in {
                        Some(noun) => kind.standing_in_for(noun),
                        None => kind,
                    };
                    let label = label(draft, mention, &kind, k);
                    made.push(draft.add_of(mention, kind, label, mention.attributes.of_object(k)));
                }
                if mention.stacked {
                    let size = mention.stack_size.unwrap_or(made.len()).max(1);
                    for pair in made.chunks(size).flat_map(|stack| stack.windows(2)) {
                        draft.relate(pair[1], RelationKind::StackedOn, Some(pair[0]));
                    }
                }
            }
            Some(Meaning::Vague(index)) => {
                let vague = &draft.lexicon.themes.vague[index];
                if vague.place_setting {
                    for _ in 0..counts[m] {
                        made.extend(place_settings::new_setting(draft));
                    }
                } else {
                    for category in members(draft, vague, counts[m], m, parsed) {
                        let category = &draft.lexicon.categories[category];
                        let attributes = mention.attributes.clone();
                        let (kind, label) = match &mention.stand_in {
                            Some(noun) => (Kind::of(category).standing_in_for(noun), noun.clone()),
                            None => (Kind::of(category), category.label.clone()),
                        };
                        made.push(draft.add_of(mention, kind, label, attributes));
                    }
                }
            }
            _ => {}
        }
        draft.of_mention.push(made);
    }
    Ok(())
}

/// Retracts the counts that are not the numbers of their objects ("three" of "three stacks of two books"); their words
/// then belong to the names of the objects.
pub(super) fn retract_others(draft: &Draft, parsed: &mut ParsedText, source: &Source) {
    let made = |mentions: &[usize]| {
        let objects: BTreeSet<usize> = mentions.iter().flat_map(|&m| draft.of_mention[m].clone()).collect();
        objects.len() as u32
    };
    parsed.account.claims.retain(|claim| match &claim.meaning {
        Claimed::Property { property: Property::Count, mentions } if !mentions.is_empty() => {
            number(draft.lexicon, &source.tokens, &claim.tokens)
                .is_none_or(|[low, high]| (low..=high).contains(&made(mentions)))
        }
        _ => true,
    });
}

/// "a box with an apple in it": a box without another name is open if it holds something.
fn open_box(draft: &Draft, parsed: &ParsedText, m: usize) -> Option<Meaning> {
    let mention = &parsed.mentions[m];
    let holds = parsed
        .links
        .iter()
        .any(|link| link.to == m && link.kind == LinkKind::Relation(RelationKind::In) && link.from != m);
    let is_plain =
        matches!(draft.lexicon.vocabulary.singular_of(&mention.words).rsplit(' ').next(), Some("box"))
            && mention.meanings.first() == draft.lexicon.get("box")?.meanings.first();
    (holds && is_plain).then(|| draft.lexicon.index_of("cardboard_box").map(Meaning::Category)).flatten()
}

/// The sense of a mention that fits the scene's family.
fn sense(draft: &Draft, mention: &Mention) -> Option<Meaning> {
    let at_home = mention.meanings.iter().find(|meaning| match meaning {
        Meaning::Category(index) => {
            draft.lexicon.categories[*index].families.iter().any(|f| f == draft.family)
        }
        _ => false,
    });
    let first = mention.meanings.first()?;
    match first {
        Meaning::Category(_) => Some(at_home.unwrap_or(first).clone()),
        _ => Some(first.clone()),
    }
}

fn objects_per_unit(draft: &Draft, mention: &Mention) -> usize {
    match mention.meanings.first() {
        Some(Meaning::Vague(index)) if draft.lexicon.themes.vague[*index].place_setting => 4,
        _ => 1,
    }
}

/// Number of units of a mention, multiplied by the hosts of "each".
fn instances(draft: &Draft, parsed: &ParsedText, m: usize, depth: usize) -> usize {
    let mention = &parsed.mentions[m];
    let mut rng = child_rng(draft.seed, &format!("count of {m}: {}", mention.words));
    let plural = &draft.lexicon.vocabulary.plural;
    let vague = mention.meanings.iter().find_map(|meaning| match meaning {
        Meaning::Vague(index) => Some(&draft.lexicon.themes.vague[*index]),
        _ => None,
    });
    let range = match (mention.count, vague) {
        (Some([1, 1]) | None, Some(vague)) if vague.place_setting => {
            let people = parsed.people.unwrap_or(1);
            [people, people]
        }
        (Some(range), _) => range,
        (None, Some(vague)) => vague.count,
        (None, None) if mention.stacked => [3, 4],
        (None, None) if mention.plural && mention.each_of.is_none() && !mention.per_person => {
            if mention.contents {
                // Several categories share the vessel.
                match kinds_of_contents(parsed, m) {
                    0 | 1 => plural.contents,
                    2 => [2, 3],
                    _ => [1, 2],
                }
            } else if let (Some(people), true) = (parsed.people, is_tableware(draft, mention)) {
                [people, people]
            } else if mention.attributes.kinds() > 1 {
                // "red, blue and green cubes": one of each.
                [mention.attributes.kinds() as u32; 2]
            } else {
                plural.bare
            }
        }
        _ => [1, 1],
    };
    let persons = if mention.per_person { parsed.people.unwrap_or(1) as usize } else { 1 };
    let own = if range[0] < range[1] { rng.random_range(range[0]..=range[1]) } else { range[0] } as usize;
    let own = own.saturating_mul(persons);
    match mention.each_of {
        Some(host) if host != m && depth < 8 => {
            own.saturating_mul(instances(draft, parsed, host, depth + 1).max(1))
        }
        _ => own,
    }
}

/// Number of content categories in the vessel of this mention.
fn kinds_of_contents(parsed: &ParsedText, m: usize) -> usize {
    let Some(vessel) = parsed.links.iter().find(|link| link.from == m).map(|link| link.to) else { return 1 };
    parsed.links.iter().filter(|link| link.to == vessel && parsed.mentions[link.from].contents).count()
}

fn is_tableware(draft: &Draft, mention: &Mention) -> bool {
    matches!(mention.meanings.first(), Some(Meaning::Category(index))
        if place_settings::is_of_each_person(&draft.lexicon.categories[*index]))
}

/// Categories of a vague set, sampled without repetition until the set is exhausted.
fn members(draft: &Draft, vague: &VagueSet, count: usize, m: usize, parsed: &ParsedText) -> Vec<usize> {
    let mut rng = child_rng(draft.seed, &format!("members of {m}: {}", vague.words[0]));
    let named: Vec<usize> = parsed
        .mentions
        .iter()
        .filter_map(|mention| match mention.meanings[0] {
            Meaning::Category(index) => Some(index),
            _ => None,
        })
        .collect();
    let known: Vec<usize> = vague
        .members_in(draft.family)
        .iter()
        .filter_map(|name| draft.lexicon.index_of(name))
        .filter(|index| !is_excluded(draft, parsed, *index))
        .collect();
    // "model cars and tools": categories named explicitly are sampled only after the others.
    let fresh: Vec<usize> = known.iter().copied().filter(|index| !named.contains(index)).collect();
    let source = if fresh.len() >= count.min(known.len()) { fresh } else { known };
    let mut drawn = Vec::new();
    let mut pool = Vec::new();
    while drawn.len() < count && !source.is_empty() {
        if pool.is_empty() {
            if !drawn.is_empty() && !vague.repeat && drawn.len() >= source.len() * 3 {
                break;
            }
            pool.clone_from(&source);
        }
        drawn.push(pool.swap_remove(rng.random_range(0..pool.len())));
    }
    drawn
}

/// Whether the text excludes the category.
pub(super) fn is_excluded(draft: &Draft, parsed: &ParsedText, category: usize) -> bool {
    parsed.excluded.iter().any(|meaning| match meaning {
        Meaning::Category(index) => *index == category,
        Meaning::Vague(index) => {
            draft.lexicon.themes.vague[*index].members.contains(&draft.lexicon.categories[category].name)
        }
        Meaning::Table(_) | Meaning::StandIn(_) => false,
    })
}

/// The user's words for one of the mention's objects.
fn label(draft: &Draft, mention: &Mention, kind: &Kind, k: usize) -> String {
    let vocabulary = draft.lexicon.vocabulary;
    let known = kind.stand_in.as_ref().map_or(&kind.category.label, |(noun, _)| noun);
    if mention.attributes.color_words.len() > 1 {
        return format!(
            "{} {known}",
            mention.attributes.color_words[k % mention.attributes.color_words.len()]
        );
    }
    if let Some(variant) = mention.attributes.variants.get(k % mention.attributes.variants.len().max(1)) {
        return format!("{} {known}", variant.word);
    }
    let words = if mention.plural { vocabulary.singular_of(&mention.words) } else { mention.words.clone() };
    let short: String = words.chars().take(80).collect();
    if short.trim().is_empty() { known.clone() } else { short }
}
