//! From mentions to objects: how many, of which category.

use rand::RngExt;

use super::DescribeError;
use super::draft::Draft;
use super::grammar::{Mention, Reading};
use super::lexicon::Meaning;
use super::phrase::Looks;
use super::themes::VagueSet;
use runtime::seed::child_rng;
use scene::RelationKind;

/// Makes the objects of every mention. The limit is checked before anything is made.
pub(super) fn instantiate(draft: &mut Draft, reading: &Reading, limit: usize) -> Result<(), DescribeError> {
    let counts: Vec<usize> = (0..reading.mentions.len()).map(|m| instances(draft, reading, m, 0)).collect();
    let total = reading
        .mentions
        .iter()
        .zip(&counts)
        .map(|(mention, &count)| count.saturating_mul(objects_per_unit(draft, mention)))
        .fold(0_usize, usize::saturating_add);
    if total > limit {
        return Err(DescribeError::TooManyObjects { count: total, limit });
    }
    for (m, mention) in reading.mentions.iter().enumerate() {
        let mut made = Vec::new();
        match sense(draft, mention) {
            Some(Meaning::Category(category)) => {
                for k in 0..counts[m] {
                    let label = label(draft, mention, category, k);
                    let mut looks = mention.looks.clone();
                    if looks.colors.len() > 1 {
                        let pick = k % looks.colors.len();
                        looks.colors.swap(0, pick);
                    }
                    made.push(draft.add(category, label, looks, true));
                }
                if mention.stacked {
                    for pair in made.windows(2) {
                        draft.relate(pair[1], RelationKind::StackedOn, Some(pair[0]));
                    }
                }
            }
            Some(Meaning::Vague(index)) => {
                let vague = &draft.lexicon.themes.vague[index];
                if vague.place_setting {
                    for _ in 0..counts[m] {
                        made.extend(place_setting(draft, true).first());
                    }
                } else {
                    for category in members(draft, vague, counts[m], m, reading) {
                        let label = draft.lexicon.categories[category].label.clone();
                        made.push(draft.add(category, label, mention.looks.clone(), true));
                    }
                }
            }
            _ => {}
        }
        draft.of_mention.push(made);
    }
    Ok(())
}

/// The sense that fits the scene's family.
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

/// How many units of a mention there are, hosts of "each" multiplied in.
fn instances(draft: &Draft, reading: &Reading, m: usize, depth: usize) -> usize {
    let mention = &reading.mentions[m];
    let mut rng = child_rng(draft.seed, &format!("count of {m}: {}", mention.words));
    let plural = &draft.lexicon.vocabulary.plural;
    let vague = mention.meanings.iter().find_map(|meaning| match meaning {
        Meaning::Vague(index) => Some(&draft.lexicon.themes.vague[*index]),
        _ => None,
    });
    let range = match (mention.count, vague) {
        (Some([1, 1]) | None, Some(vague)) if vague.place_setting => {
            let people = reading.people.unwrap_or(1);
            [people, people]
        }
        (Some(range), _) => range,
        (None, Some(vague)) => vague.count,
        (None, None) if mention.stacked => [3, 4],
        (None, None) if mention.plural && mention.each_of.is_none() => {
            if mention.contents {
                // Several kinds share the vessel.
                match kinds_of_contents(reading, m) {
                    0 | 1 => plural.contents,
                    2 => [2, 3],
                    _ => [1, 2],
                }
            } else if let (Some(people), true) = (reading.people, is_tableware(draft, mention)) {
                [people, people]
            } else {
                plural.bare
            }
        }
        _ => [1, 1],
    };
    let own = if range[0] < range[1] { rng.random_range(range[0]..=range[1]) } else { range[0] } as usize;
    match mention.each_of {
        Some(host) if host != m && depth < 8 => {
            own.saturating_mul(instances(draft, reading, host, depth + 1).max(1))
        }
        _ => own,
    }
}

/// How many kinds of contents the vessel of this one holds.
fn kinds_of_contents(reading: &Reading, m: usize) -> usize {
    let Some(vessel) = reading.links.iter().find(|link| link.from == m).map(|link| link.to) else { return 1 };
    reading.links.iter().filter(|link| link.to == vessel && reading.mentions[link.from].contents).count()
}

fn is_tableware(draft: &Draft, mention: &Mention) -> bool {
    const TABLEWARE: &[&str] = &[
        "plate",
        "bowl",
        "fork",
        "knife",
        "spoon",
        "chopsticks",
        "mug",
        "teacup",
        "saucer",
        "drinking_glass",
        "wine_glass",
        "coaster",
    ];
    matches!(mention.meanings.first(), Some(Meaning::Category(index))
        if TABLEWARE.contains(&draft.lexicon.categories[*index].name.as_str()))
}

/// Categories a vague word stands for, drawn without repetition as far as they last.
fn members(draft: &Draft, vague: &VagueSet, count: usize, m: usize, reading: &Reading) -> Vec<usize> {
    let mut rng = child_rng(draft.seed, &format!("members of {m}: {}", vague.words[0]));
    let named: Vec<usize> = reading
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
        .filter(|index| !is_excluded(draft, reading, *index))
        .collect();
    // "model cars and tools": what is named by itself is not drawn again while others are left.
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

/// Whether the text rules the category out.
pub(super) fn is_excluded(draft: &Draft, reading: &Reading, category: usize) -> bool {
    reading.excluded.iter().any(|meaning| match meaning {
        Meaning::Category(index) => *index == category,
        Meaning::Vague(index) => {
            draft.lexicon.themes.vague[*index].members.contains(&draft.lexicon.categories[category].name)
        }
        Meaning::Table(_) => false,
    })
}

/// A plate with a fork at its left, a knife at its right and a glass behind it; the plate first.
pub(super) fn place_setting(draft: &mut Draft, requested: bool) -> Vec<usize> {
    let mut made = Vec::new();
    let parts = [
        ("plate", None),
        ("fork", Some(RelationKind::LeftOf)),
        ("knife", Some(RelationKind::RightOf)),
        ("drinking_glass", Some(RelationKind::Behind)),
    ];
    for (name, kind) in parts {
        let Some(category) = draft.lexicon.index_of(name) else { continue };
        let label = draft.lexicon.categories[category].label.clone();
        let object = draft.add(category, label, Looks { scale: 1.0, ..Looks::default() }, requested);
        if let (Some(kind), Some(&plate)) = (kind, made.first()) {
            draft.relate(object, kind, Some(plate));
        }
        made.push(object);
    }
    made
}

/// The user's words for one of the mention's objects.
fn label(draft: &Draft, mention: &Mention, category: usize, k: usize) -> String {
    let vocabulary = draft.lexicon.vocabulary;
    let known = &draft.lexicon.categories[category].label;
    if mention.looks.color_words.len() > 1 {
        return format!("{} {known}", mention.looks.color_words[k % mention.looks.color_words.len()]);
    }
    let words = if mention.plural { vocabulary.singular_of(&mention.words) } else { mention.words.clone() };
    let short: String = words.chars().take(80).collect();
    if short.trim().is_empty() { known.clone() } else { short }
}
