//! Completion of open scenes with typical objects of the theme.

use std::collections::BTreeSet;

use rand::RngExt;

use super::TextParserSettings;
use super::account::Claimed;
use super::counts::is_excluded;
use super::draft::{Draft, DraftRelation, Kind};
use super::grammar::ParsedText;
use super::lexicon::Lexicon;
use super::phrase::Attributes;
use super::themes::{Theme, ThemeItem};
use super::tokens::{Source, match_phrase};
use catalog::Category;
use runtime::seed::child_rng;
use scene::RelationKind;
use scene::predicates::direction_of;

/// Whether the theme completes the scene: the text is bare of objects, or it asks for more than it names. Claims the
/// words that say so.
pub(super) fn is_open(lexicon: &Lexicon, parsed: &mut ParsedText, source: &Source, is_bare: bool) -> bool {
    let grammar = &lexicon.vocabulary.grammar;
    let mut claim = |phrases: &BTreeSet<String>, complete: bool| {
        let mut found = false;
        for at in 0..source.tokens.len() {
            let longest = phrases.iter().filter_map(|phrase| match_phrase(&source.tokens, at, phrase)).max();
            // "this is only a test" is no list.
            let reported = |length: &usize| {
                let mut reports = parsed.account.reports.iter();
                reports.any(|report| report.tokens.start < at + length && at < report.tokens.end)
            };
            if let Some(length) = longest.filter(|length| !reported(length)) {
                parsed.account.claim(at..at + length, Claimed::Completion(complete));
                found = true;
            }
        }
        found
    };
    let (opens, closes) = (claim(&grammar.openers, true), claim(&grammar.closers, false));
    is_bare || (opens && !closes && !parsed.nothing_else)
}

/// Adds typical objects until the seeded number of objects is reached. Categories that the text names or excludes are
/// skipped; added objects are marked as not requested.
pub(super) fn complete(
    draft: &mut Draft,
    parsed: &ParsedText,
    theme: &Theme,
    settings: &TextParserSettings,
    limit: usize,
) {
    let mut rng = child_rng(draft.seed, "completion");
    let low = settings.fewest_objects.min(limit);
    let high = settings.default_max_objects.clamp(low, limit);
    let goal = rng.random_range(low..=high);
    let settings_at_table = parsed.people.or_else(|| {
        theme.settings.map(|[low, high]| if low < high { rng.random_range(low..=high) } else { low })
    });
    // All random numbers are drawn in file order, so that an additional item does not change the others.
    let rolls: Vec<f64> = theme.items.iter().map(|_| rng.random_range(0.0..1.0)).collect();
    let picks: Vec<u64> = theme.items.iter().map(|_| rng.random_range(0..1_u64 << 32)).collect();
    let mut done = vec![false; theme.items.len()];
    for by_probability in [true, false] {
        for (k, item) in theme.items.iter().enumerate() {
            if done[k] || draft.objects.len() >= goal || (by_probability && rolls[k] >= item.probability) {
                continue;
            }
            done[k] = true;
            let names: Vec<&str> = item.names().collect();
            let name = names[picks[k] as usize % names.len()];
            let Some(index) = draft.lexicon.index_of(name) else { continue };
            let category = &draft.lexicon.categories[index];
            let present = draft.objects.iter().any(|object| object.kind.category.name == category.name);
            if present || is_excluded(draft, parsed, index) {
                continue;
            }
            let [min_count, max_count] = item.count;
            let mut count = min_count + (picks[k] >> 8) as u32 % (max_count - min_count + 1);
            if let (Some(settings), true) = (settings_at_table, name == "plate") {
                count = settings;
            }
            // Every guest gets a complete place setting.
            let max_objects =
                if item.each && parsed.people.is_some() { limit } else { settings.default_max_objects };
            add_item(draft, item, category, count as usize, limit.min(max_objects));
        }
    }
}

fn add_item<'c>(
    draft: &mut Draft<'_, 'c>,
    item: &ThemeItem,
    category: &'c Category,
    count: usize,
    limit: usize,
) {
    let targets: Vec<usize> = item
        .target
        .as_deref()
        .map(|name| (0..draft.objects.len()).filter(|&o| draft.category(o).name == name).collect())
        .unwrap_or_default();
    if item.each && targets.is_empty() {
        return;
    }
    let total = if item.each { count * targets.len() } else { count };
    if draft.objects.len() + total > limit.max(1) && !draft.objects.is_empty() {
        return;
    }
    let mut below: Option<usize> = None;
    for k in 0..total {
        let object = draft.add(Kind::of(category), category.label.clone(), Attributes::plain(), false);
        if let (Some(kind), false) = (item.relation, targets.is_empty()) {
            let free = targets
                .iter()
                .position(|&t| !draft.objects.iter().any(|o| kind.is_support() && o.has(kind, Some(t))));
            let target = if item.each {
                Some(k / count.max(1))
            } else if kind.is_support() {
                free
            } else {
                Some(0)
            };
            if let Some(target) = target.map(|target| targets[target]) {
                let at_setting =
                    item.each && draft.category(target).name == "plate" && direction_of(kind).is_some();
                let relation = match at_setting {
                    true => DraftRelation::of_setting(kind, target),
                    false => DraftRelation::new(kind, Some(target)),
                };
                draft.relate_as(object, relation);
            }
        }
        if let Some(place) = item.place {
            draft.relate(object, place, None);
        }
        if item.stacked {
            if let Some(below) = below {
                draft.relate(object, RelationKind::StackedOn, Some(below));
            }
            below = Some(object);
        }
    }
}
