//! Qualifiers after the noun of a phrase: relations to other objects, places on the table, orders.

use super::phrase::{NounPhrase, Reader, Unread, read_noun_phrase};
use language::outermost::{Side, outermost};
use language::vocabulary::vocabulary;
use scene::RelationKind;

/// A direction in which objects are ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Left,
    Right,
    Front,
    Back,
    Top,
    Bottom,
}

impl Direction {
    pub fn of(word: &str) -> Option<Self> {
        Some(match word {
            "left" | "leftmost" | "lefthand" => Self::Left,
            "right" | "rightmost" | "righthand" => Self::Right,
            "front" | "frontmost" | "nearest" | "closest" => Self::Front,
            "back" | "backmost" | "rear" | "rearmost" | "farthest" | "furthest" => Self::Back,
            "top" | "topmost" | "upper" | "uppermost" => Self::Top,
            "bottom" | "bottommost" | "lower" | "lowest" => Self::Bottom,
            _ => return None,
        })
    }

    pub fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            Self::Front => Self::Back,
            Self::Back => Self::Front,
            Self::Top => Self::Bottom,
            Self::Bottom => Self::Top,
        }
    }
}

/// A region of the table: the sign of x, of y, or the center.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub x: i8,
    pub y: i8,
}

/// Qualifier after a noun.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Qualifier {
    Related(RelationKind, NounPhrase),
    /// Support of the other object.
    Supporting(NounPhrase),
    Between(Vec<NounPhrase>),
    Closest(NounPhrase),
    Farthest(NounPhrase),
    /// "furthest to the left"
    Outermost(Direction),
    OnTable,
    In(Region),
    /// "that is yellow", "which is wooden": words of a color or a material.
    Appearance(String),
    /// "that is not yellow"
    NotAppearance(String),
    /// Objects are counted from there.
    From(Direction),
}

const CONNECTORS: &[&[&str]] = &[
    &["that", "isnt"],
    &["that", "arent"],
    &["which", "isnt"],
    &["which", "arent"],
    &["that", "is"],
    &["that", "are"],
    &["which", "is"],
    &["which", "are"],
    &["thats"],
    &["that", "stands"],
    &["that", "lies"],
    &["that", "sits"],
    &["standing"],
    &["lying"],
    &["sitting"],
    &["resting"],
    &["placed"],
    &["located"],
    &["that"],
    &["which"],
];

/// Longer patterns precede their beginnings.
const RELATIONS: &[(&[&str], RelationKind)] = &[
    (&["to", "the", "left", "of"], RelationKind::LeftOf),
    (&["on", "the", "left", "of"], RelationKind::LeftOf),
    (&["left", "of"], RelationKind::LeftOf),
    (&["to", "the", "right", "of"], RelationKind::RightOf),
    (&["on", "the", "right", "of"], RelationKind::RightOf),
    (&["right", "of"], RelationKind::RightOf),
    (&["in", "front", "of"], RelationKind::InFrontOf),
    (&["in", "back", "of"], RelationKind::Behind),
    (&["behind"], RelationKind::Behind),
    (&["next", "to"], RelationKind::NextTo),
    (&["close", "to"], RelationKind::NextTo),
    (&["adjacent", "to"], RelationKind::NextTo),
    (&["beside"], RelationKind::NextTo),
    (&["alongside"], RelationKind::NextTo),
    (&["near"], RelationKind::NextTo),
    (&["by"], RelationKind::NextTo),
    (&["on", "top", "of"], RelationKind::On),
    (&["atop"], RelationKind::On),
    (&["upon"], RelationKind::On),
    (&["on"], RelationKind::On),
    (&["inside", "of"], RelationKind::In),
    (&["inside"], RelationKind::In),
    (&["within"], RelationKind::In),
    (&["in"], RelationKind::In),
];

const SUPPORTING: &[&[&str]] = &[
    &["under"],
    &["underneath"],
    &["below"],
    &["beneath"],
    &["holding"],
    &["containing"],
    &["carrying"],
    &["supporting"],
    &["with"],
    &["contains"],
    &["holds"],
];

/// The qualifier at the reader, also as a relative clause; `None` if another word follows.
pub(super) fn qualifier(reader: &mut Reader) -> Result<Option<Qualifier>, Unread> {
    let before = reader.at;
    if let Some(connector) = CONNECTORS.iter().find(|connector| reader.follows(connector)) {
        reader.at += connector.len();
        let is_not = reader.take(&["not"]) || connector.last().is_some_and(|word| word.ends_with("nt"));
        if let Some(length) = vocabulary()
            .color_length(reader.words, reader.at)
            .or_else(|| vocabulary().material_length(reader.words, reader.at))
        {
            let words = reader.words[reader.at..reader.at + length].join(" ");
            reader.at += length;
            return Ok(Some(if is_not {
                Qualifier::NotAppearance(words)
            } else {
                Qualifier::Appearance(words)
            }));
        }
        return match qualifier(reader)? {
            Some(found) => Ok(Some(found)),
            None => Err(reader.words[before..].to_vec()),
        };
    }
    if reader.take(&["from", "the"]) || reader.take(&["from"]) {
        let direction = reader.peek().and_then(Direction::of);
        reader.at += 1;
        return match direction {
            Some(direction) => Ok(Some(Qualifier::From(direction))),
            None => Err(reader.words[before..].to_vec()),
        };
    }
    if let Some(place) = place(reader) {
        return Ok(Some(place));
    }
    if reader.take(&["between"]) || reader.take(&["in", "between"]) {
        let first = read_noun_phrase(reader)?;
        let mut ends = vec![first];
        if reader.take(&["and"]) {
            ends.push(read_noun_phrase(reader)?);
        }
        return Ok(Some(Qualifier::Between(ends)));
    }
    let ahead: Vec<&str> = reader.words[reader.at..].iter().take(7).map(String::as_str).collect();
    if let Some((side, length)) = outermost(&ahead) {
        reader.at += length;
        return Ok(Some(Qualifier::Outermost(match side {
            Side::Left => Direction::Left,
            Side::Right => Direction::Right,
            Side::Front => Direction::Front,
            Side::Back => Direction::Back,
        })));
    }
    let distances = [
        ("closest", true),
        ("nearest", true),
        ("closer", true),
        ("nearer", true),
        ("farthest", false),
        ("furthest", false),
    ];
    for (word, closest) in distances {
        if reader.take(&[word]) {
            let _ = reader.take_one(&["to", "from"]);
            let target = read_noun_phrase(reader)?;
            return Ok(Some(if closest { Qualifier::Closest(target) } else { Qualifier::Farthest(target) }));
        }
    }
    if let Some((pattern, kind)) = RELATIONS.iter().find(|(pattern, _)| reader.follows(pattern)) {
        reader.at += pattern.len();
        let target = read_noun_phrase(reader)?;
        let on_table = *kind == RelationKind::On && vocabulary().is_table(&target.body.join(" "));
        return Ok(Some(if on_table { Qualifier::OnTable } else { Qualifier::Related(*kind, target) }));
    }
    if let Some(pattern) = SUPPORTING.iter().find(|pattern| reader.follows(pattern)) {
        reader.at += pattern.len();
        let target = read_noun_phrase(reader)?;
        let _ = reader.take_one(&["in", "on", "inside"]) && reader.take(&["it"]);
        return Ok(Some(Qualifier::Supporting(target)));
    }
    Ok(None)
}

/// "on the left", "in the front left corner of the table", "at the back". Nothing is consumed unless it is a place.
fn place(reader: &mut Reader) -> Option<Qualifier> {
    let before = reader.at;
    let found = read_place(reader);
    if found.is_none() {
        reader.at = before;
    }
    found
}

fn read_place(reader: &mut Reader) -> Option<Qualifier> {
    if !reader.take_one(&["on", "at", "in", "to", "near"]) || !reader.take(&["the"]) {
        return None;
    }
    let _ = reader.take(&["far"]);
    let mut region: Option<Region> = None;
    while let Some(next) = reader.peek().and_then(side) {
        region = Some(match region {
            Some(known) => Region { x: known.x + next.x, y: known.y + next.y },
            None => next,
        });
        reader.at += 1;
    }
    let region = region?;
    let _ = reader.take_one(&["side", "edge", "end", "corner", "half", "part"]);
    if reader.take(&["of"]) {
        let _ = reader.take(&["the"]);
        let table = reader.peek().is_some_and(|word| vocabulary().is_table(word));
        reader.at += 1;
        return table.then_some(Qualifier::In(region));
    }
    Some(Qualifier::In(region))
}

fn side(word: &str) -> Option<Region> {
    Some(match word {
        "left" | "lefthand" => Region { x: -1, y: 0 },
        "right" | "righthand" => Region { x: 1, y: 0 },
        "front" => Region { x: 0, y: -1 },
        "back" | "rear" => Region { x: 0, y: 1 },
        "middle" | "center" | "centre" => Region { x: 0, y: 0 },
        _ => return None,
    })
}
