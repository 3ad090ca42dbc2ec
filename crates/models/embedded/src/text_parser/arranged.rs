//! Arrangements of the description from those of the text.

use super::draft::Draft;
use super::grammar::{ArrangementDraft, ParsedText};
use super::phrase::Group;
use scene::{Arrangement, ArrangementKind};

/// The arrangements with at least two objects.
pub(super) fn arrangements(draft: &Draft, parsed: &ParsedText) -> Vec<Arrangement> {
    parsed.arrangements.iter().filter_map(|arrangement| of(draft, arrangement)).collect()
}

/// Index in the description of an arrangement of the text.
pub(super) fn index_of(draft: &Draft, parsed: &ParsedText, index: usize) -> Option<usize> {
    of(draft, parsed.arrangements.get(index)?)?;
    Some(parsed.arrangements[..index].iter().filter(|arrangement| of(draft, arrangement).is_some()).count())
}

fn of(draft: &Draft, arrangement: &ArrangementDraft) -> Option<Arrangement> {
    let ids = draft.ids();
    let members = arrangement.mentions.iter().flat_map(|&mention| draft.of_mention[mention].iter());
    let objects: Vec<_> = members.map(|&object| ids[object].clone()).collect();
    if objects.len() < 2 {
        return None;
    }
    let columns = arrangement.columns.unwrap_or_else(|| (objects.len() as f64).sqrt().ceil() as usize).max(1);
    let kind = match arrangement.group {
        Group::Row => ArrangementKind::Row,
        Group::Column => ArrangementKind::Column,
        Group::Circle => ArrangementKind::Circle,
        Group::Grid => ArrangementKind::Grid { columns },
        Group::Pile => ArrangementKind::Pile,
        Group::Pyramid => ArrangementKind::Pyramid,
    };
    let center =
        arrangement.center.and_then(|center| draft.of_mention[center].first()).map(|&o| ids[o].clone());
    Some(Arrangement { kind, objects, gap_m: arrangement.gap_m, center })
}
