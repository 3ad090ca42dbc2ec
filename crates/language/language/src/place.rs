//! Places: relations to objects, parts of the table, distances from its edges, displacements, where something comes
//! from.

use std::ops::Range;

use glam::DVec2;
use scene::RelationKind;

use crate::chart::{Chart, Span, cheapest};
use crate::lexicon::{begins_with, split};
use crate::measures::length_at;
use crate::nominal::{NounPhrase, Quantity, Reference};
use crate::vocabulary::vocabulary;

/// A place and its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub kind: PlaceKind,
    pub tokens: Range<usize>,
    /// Whether the first word says that something goes there ("to", "onto", "into").
    pub is_goal: bool,
}

/// Kinds of places. Directions are as seen from the front edge: x to the right, y to the back.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceKind {
    Related {
        relation: RelationKind,
        landmarks: Vec<NounPhrase>,
        distance_m: Option<f64>,
    },
    Between(Vec<NounPhrase>),
    /// A part of the table, by the signs of x and y.
    Region {
        x: i8,
        y: i8,
        is_edge: bool,
        distance_m: Option<f64>,
    },
    /// A displacement, meters.
    Offset(DVec2),
    /// A displacement without a distance.
    Direction(DVec2),
    /// Away from an object that carries or contains it.
    Source {
        landmarks: Vec<NounPhrase>,
        is_inside: bool,
    },
    /// Farther from objects, without a distance.
    Away(Vec<NounPhrase>),
    /// The top of the table.
    Table,
    /// Away from the table.
    OffTable,
    Anywhere,
    /// "there": the last place that was named.
    There,
    /// "closer", without a distance.
    Closer,
}

/// Groups of relations in the lexicon.
const RELATIONS: &[(&str, RelationKind)] = &[
    ("left_of", RelationKind::LeftOf),
    ("right_of", RelationKind::RightOf),
    ("in_front_of", RelationKind::InFrontOf),
    ("behind", RelationKind::Behind),
    ("next_to", RelationKind::NextTo),
    ("on", RelationKind::On),
    ("in", RelationKind::In),
];

/// Words of displacements, with their directions.
const DIRECTIONS: &[(&[&str], DVec2)] = &[
    (
        &[
            "to the left",
            "left",
            "leftwards",
            "leftward",
            "towards the left",
            "toward the left",
            "farther left",
            "further left",
            "further to the left",
            "more to the left",
        ],
        DVec2::NEG_X,
    ),
    (
        &[
            "to the right",
            "right",
            "rightwards",
            "rightward",
            "towards the right",
            "toward the right",
            "farther right",
            "further right",
            "further to the right",
            "more to the right",
        ],
        DVec2::X,
    ),
    (
        &[
            "to the front",
            "forwards",
            "forward",
            "toward me",
            "towards me",
            "toward the viewer",
            "towards the viewer",
            "toward the front",
            "towards the front",
            "closer to me",
            "nearer to me",
            "toward us",
            "towards us",
            "toward the front edge",
            "towards the front edge",
            "closer to the front",
        ],
        DVec2::NEG_Y,
    ),
    (
        &[
            "to the back",
            "backwards",
            "backward",
            "back",
            "away from me",
            "toward the back",
            "towards the back",
            "further back",
            "farther back",
            "away from us",
            "away from the viewer",
            "toward the back edge",
            "towards the back edge",
            "to the rear",
        ],
        DVec2::Y,
    ),
];

/// Beginnings that say that something goes there.
const GOALS: &[&str] = &["to", "onto", "into", "over", "towards", "toward", "back", "up"];

/// Arrangements, at which nothing can be: "in a circle".
const SHAPES: &[&str] =
    &["circle", "ring", "semicircle", "triangle", "grid", "pyramid", "single row", "single line"];

/// Words of "next to" that are rarely that: a place is meant where nothing else fits.
const WEAK: &[&str] = &["at", "to", "over", "by", "up"];

/// Parts of a table, which are no objects.
const PARTS: &[&str] = &[
    "side", "edge", "corner", "center", "centre", "middle", "half", "end", "part", "left", "right", "front",
    "back", "rear", "border",
];

impl Place {
    /// Whether it is relative to several objects, one at a time.
    pub(crate) fn has_several_landmarks(&self) -> bool {
        match &self.kind {
            PlaceKind::Related { landmarks, .. } => {
                landmarks.iter().any(|landmark| landmark.quantity.is_plural() && !landmark.is_choice)
            }
            _ => false,
        }
    }

    /// The phrases of the objects that it is relative to.
    pub fn phrases(&self) -> &[NounPhrase] {
        match &self.kind {
            PlaceKind::Related { landmarks, .. }
            | PlaceKind::Between(landmarks)
            | PlaceKind::Away(landmarks)
            | PlaceKind::Source { landmarks, .. } => landmarks,
            _ => &[],
        }
    }

    /// Whether it says where something comes from.
    pub(crate) fn is_source(&self) -> bool {
        matches!(self.kind, PlaceKind::Source { .. } | PlaceKind::OffTable)
    }

    /// The cost of taking it for a part of the phrase before it; `None` where it cannot be one.
    pub(crate) fn attachment(&self) -> Option<f64> {
        match &self.kind {
            PlaceKind::Related { relation, distance_m: None, .. } => Some(match relation {
                _ if self.is_goal => 1.6,
                RelationKind::On | RelationKind::In => 0.6,
                _ => 0.7,
            }),
            PlaceKind::Related { .. } => None,
            PlaceKind::Between(_) => Some(0.7),
            PlaceKind::Region { distance_m: None, .. } => Some(if self.is_goal { 1.8 } else { 0.8 }),
            PlaceKind::Table => Some(if self.is_goal { 1.8 } else { 0.4 }),
            _ => None,
        }
    }
}

/// The relation of what goes "to" an object: into a container, onto what carries others, else next to it.
pub(crate) fn destination(noun: &str) -> RelationKind {
    const CARRIERS: &[&str] = &[
        "plate", "tray", "board", "coaster", "mat", "saucer", "placemat", "napkin", "towel", "cloth",
        "shelf", "rack", "stand", "platter", "dish", "pad",
    ];
    let noun =
        vocabulary().singular_of(noun).filter(|one| crate::nouns::is_noun(one)).unwrap_or(noun.to_owned());
    let last = noun.rsplit(' ').next().unwrap_or_default();
    if CARRIERS.contains(&last) {
        return RelationKind::On;
    }
    let category = catalog::categories().iter().find(|category| crate::nouns::is_name(category, &noun));
    match category.is_some_and(|category| category.affords(catalog::Affordance::Container)) {
        true => RelationKind::In,
        false => RelationKind::NextTo,
    }
}

impl Chart<'_> {
    pub(crate) fn read_places(&self, at: usize) -> Vec<Span<Place>> {
        let mut found = self.plain_places(at, None, at);
        for length in self.lengths("emphasis", at) {
            let inner = self.plain_places(at, None, at + length);
            found.extend(inner.into_iter().map(|span| Span { cost: span.cost + 0.1, ..span }));
        }
        if let Some((distance_m, length)) = length_at(&self.tokens, at) {
            found.extend(self.plain_places(at, Some(distance_m), at + length));
            for emphasis in self.lengths("emphasis", at + length) {
                let inner = self.plain_places(at, Some(distance_m), at + length + emphasis);
                found.extend(inner.into_iter().map(|span| Span { cost: span.cost + 0.1, ..span }));
            }
        }
        // "on the table to the left of the tray".
        let tables: Vec<Span<Place>> =
            found.iter().filter(|span| span.value.kind == PlaceKind::Table).cloned().collect();
        for table in tables {
            for span in self.plain_places(at, None, table.end) {
                if matches!(
                    span.value.kind,
                    PlaceKind::Related { .. } | PlaceKind::Region { .. } | PlaceKind::Between(_)
                ) {
                    found.push(Span { cost: span.cost + table.cost, ..span });
                }
            }
        }
        cheapest(found)
    }

    /// Places whose preposition stands at `from`, after a distance if there is one.
    fn plain_places(&self, start: usize, distance_m: Option<f64>, from: usize) -> Vec<Span<Place>> {
        let mut found = self.relations(start, distance_m, from);
        found.extend(self.regions(start, distance_m, from));
        found.extend(self.offsets(start, distance_m, from));
        if distance_m.is_none() {
            found.extend(self.betweens(start, from));
            found.extend(self.sources(start, from));
            found.extend(self.fixed(start, from));
        }
        found
    }

    fn place(&self, start: usize, from: usize, end: usize, cost: f64, kind: PlaceKind) -> Span<Place> {
        let is_goal = GOALS.contains(&self.word(from)) || (from > start && GOALS.contains(&self.word(start)));
        Span { end, cost, value: Place { kind, tokens: start..end, is_goal } }
    }

    fn relations(&self, start: usize, distance_m: Option<f64>, from: usize) -> Vec<Span<Place>> {
        let mut found = Vec::new();
        for (class, relation) in RELATIONS {
            for length in self.lengths(class, from) {
                let weak = *relation == RelationKind::NextTo && WEAK.contains(&self.word(from + length - 1));
                let price = if weak { 0.9 } else { 0.0 };
                let is_shape = |phrase: &NounPhrase| {
                    phrase.reference == Reference::Indefinite
                        && SHAPES.contains(&self.words(phrase.body.clone()).as_str())
                };
                for span in self.lists_at(from + length).iter() {
                    if span.value.iter().any(is_shape) {
                        continue;
                    }
                    let is_part =
                        |phrase: &NounPhrase| PARTS.contains(&phrase.noun.rsplit(' ').next().unwrap_or(""));
                    let several = if span.value.len() > 1 { 1.0 } else { 0.0 };
                    let several = several + if span.value.iter().any(is_part) { 3.0 } else { 0.0 };
                    let to = weak
                        && matches!(self.word(from), "to" | "over" | "up")
                        && self.word(from + length - 1) == "to";
                    let destination =
                        span.value.first().filter(|_| to).map(|phrase| destination(&phrase.noun));
                    let relation = destination.unwrap_or(*relation);
                    let kind = PlaceKind::Related { relation, landmarks: span.value.clone(), distance_m };
                    found.push(self.place(start, from, span.end, span.cost + price + several, kind));
                }
            }
        }
        found.extend(self.own_sides(start, distance_m, from));
        // "5 cm from the lamp"
        if distance_m.is_some() {
            for length in self.lengths("from", from) {
                let is_part = |span: &&Span<Vec<NounPhrase>>| {
                    span.value
                        .iter()
                        .any(|phrase| PARTS.contains(&phrase.noun.rsplit(' ').next().unwrap_or("")))
                };
                for span in self.lists_at(from + length).iter().filter(|span| !is_part(span)) {
                    let relation = RelationKind::NextTo;
                    let kind = PlaceKind::Related { relation, landmarks: span.value.clone(), distance_m };
                    found.push(self.place(start, from, span.end, span.cost, kind));
                }
            }
        }
        found
    }

    /// "on its left", "to their right side".
    fn own_sides(&self, start: usize, distance_m: Option<f64>, from: usize) -> Option<Span<Place>> {
        if !matches!(self.word(from), "on" | "to" | "at") || !matches!(self.word(from + 1), "its" | "their") {
            return None;
        }
        let relation = match self.word(from + 2) {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            _ => return None,
        };
        let hand = usize::from(self.word(from + 3) == "hand");
        let end = from + 3 + hand + usize::from(self.word(from + 3 + hand) == "side");
        let quantity = if self.word(from + 1) == "its" { Quantity::One } else { Quantity::All };
        let landmarks = vec![self.bare(from + 1..from + 2, Reference::Pronoun, quantity)];
        Some(self.place(start, from, end, -0.3, PlaceKind::Related { relation, landmarks, distance_m }))
    }

    fn betweens(&self, start: usize, from: usize) -> Vec<Span<Place>> {
        let mut found = Vec::new();
        for length in self.lengths("between", from) {
            for span in self.lists_at(from + length).iter() {
                let is_two =
                    span.value.len() == 2 || (span.value.len() == 1 && span.value[0].quantity.is_plural());
                if is_two {
                    // The "and" of two landmarks is no list of objects.
                    let kind = PlaceKind::Between(span.value.clone());
                    found.push(self.place(start, from, span.end, span.cost - 0.3, kind));
                }
            }
        }
        found
    }

    fn sources(&self, start: usize, from: usize) -> Vec<Span<Place>> {
        let mut found = Vec::new();
        for (class, is_inside) in [("from", false), ("out_of", true)] {
            for length in self.lengths(class, from) {
                for table in
                    ["the table", "the desk", "the tabletop", "the workbench", "the scene", "it all", "here"]
                {
                    let words = split(table);
                    if begins_with(&self.tokens, from + length, &words) {
                        let end = from + length + words.len();
                        found.push(self.place(start, from, end, -0.2, PlaceKind::OffTable));
                    }
                }
                let is_away = self.word(from) == "away";
                for span in self.lists_at(from + length).iter().filter(|_| is_away) {
                    let kind = PlaceKind::Away(span.value.clone());
                    found.push(self.place(start, from, span.end, span.cost, kind));
                }
                for span in self.lists_at(from + length).iter().filter(|_| !is_away) {
                    let kind = PlaceKind::Source { landmarks: span.value.clone(), is_inside };
                    found.push(self.place(start, from, span.end, span.cost, kind));
                }
            }
        }
        found
    }

    /// Places that are fixed words.
    fn fixed(&self, start: usize, from: usize) -> Vec<Span<Place>> {
        const FIXED: &[(&str, PlaceKind)] = &[
            ("there", PlaceKind::There),
            ("where it was", PlaceKind::There),
            ("where they were", PlaceKind::There),
            ("where it used to be", PlaceKind::There),
            ("in its place", PlaceKind::There),
            ("in their place", PlaceKind::There),
            ("to the same place", PlaceKind::There),
            ("at the same place", PlaceKind::There),
            ("in the same place", PlaceKind::There),
            ("anywhere", PlaceKind::Anywhere),
            ("somewhere", PlaceKind::Anywhere),
            ("anywhere on the table", PlaceKind::Anywhere),
            ("somewhere on the table", PlaceKind::Anywhere),
            ("wherever there is room", PlaceKind::Anywhere),
            ("somewhere else", PlaceKind::Anywhere),
            ("closer", PlaceKind::Closer),
            ("closer to the edge", PlaceKind::Closer),
            ("nearer", PlaceKind::Closer),
            ("nearer to the edge", PlaceKind::Closer),
            ("closer together", PlaceKind::Closer),
            ("farther away", PlaceKind::Closer),
            ("further away", PlaceKind::Closer),
            ("away", PlaceKind::OffTable),
        ];
        let mut found = Vec::new();
        for (pattern, kind) in FIXED {
            let words = split(pattern);
            if begins_with(&self.tokens, from, &words) {
                found.push(self.place(start, from, from + words.len(), 0.0, kind.clone()));
            }
        }
        let prepositions =
            ["on", "onto", "to", "on to", "back on", "back onto", "back to", "down on", "upon", "at"];
        let tables = [
            "the table",
            "the desk",
            "the tabletop",
            "the table top",
            "the workbench",
            "my desk",
            "the bench",
            "the surface of the table",
            "the counter",
        ];
        for preposition in prepositions {
            for table in tables {
                let words = split(&format!("{preposition} {table}"));
                if begins_with(&self.tokens, from, &words) {
                    found.push(self.place(start, from, from + words.len(), -0.2, PlaceKind::Table));
                }
            }
        }
        found
    }

    /// "in the front left corner", "to the back right of the table", "5 cm from the left edge".
    fn regions(&self, start: usize, distance_m: Option<f64>, from: usize) -> Vec<Span<Place>> {
        const PREPOSITIONS: &[&str] = &[
            "at",
            "in",
            "on",
            "to",
            "into",
            "onto",
            "toward",
            "towards",
            "near",
            "from",
            "along",
            "away from",
            "in from",
            "against",
            "over to",
            "up to",
            "close to",
            "right at",
            "next to",
            "all the way to",
            "by",
        ];
        let mut found = Vec::new();
        for preposition in PREPOSITIONS {
            let words = split(preposition);
            if !begins_with(&self.tokens, from, &words) {
                continue;
            }
            let mut at = from + words.len();
            at += usize::from(self.longest("definite", at).is_some());
            let before = at;
            while matches!(self.word(at), "very" | "exact" | "outer" | "own")
                || (self.word(at) == "far" && !self.is_far_corner(at))
            {
                at += 1;
            }
            // "to the far left" is a place.
            let is_far = at > before;
            let Some(((x, y), sides)) = self.sides(at) else { continue };
            at += sides;
            let is_edge = matches!(self.word(at), "edge" | "border" | "rim" | "edges");
            let is_part = matches!(
                self.word(at),
                "side" | "corner" | "end" | "half" | "part" | "area" | "row" | "third" | "sides"
            );
            at += usize::from(is_edge || is_part);
            let of_table = self.of_table(at);
            at += of_table;
            // "to the left" alone is a displacement without a distance.
            let is_open = (x, y) != (0, 0)
                && matches!(*preposition, "to" | "toward" | "towards")
                && !is_edge
                && !is_part
                && !is_far;
            if distance_m.is_some() && !is_edge && !matches!(*preposition, "from" | "away from" | "in from") {
                continue;
            }
            let is_side = self.word(at - 1) == "table" || self.word(at - 1) == "desk";
            if is_open && !is_side && sides == 1 && distance_m.is_none() {
                let direction = DVec2::new(f64::from(x), f64::from(y));
                found.push(self.place(start, from, at, 0.1, PlaceKind::Direction(direction)));
                continue;
            }
            let kind = PlaceKind::Region { x, y, is_edge, distance_m };
            // "on the left side of the table" is on it.
            let cost = if of_table > 0 { -0.2 } else { 0.0 };
            found.push(self.place(start, from, at, cost, kind));
        }
        found
    }

    /// "far left corner": far from the viewer, unlike in "the far left".
    fn is_far_corner(&self, at: usize) -> bool {
        let hand = usize::from(self.word(at + 2) == "hand");
        self.word(at) == "far"
            && matches!(self.word(at + 1), "left" | "right")
            && self.word(at + 2 + hand) == "corner"
    }

    /// The number of tokens of "of the table".
    fn of_table(&self, at: usize) -> usize {
        let phrases = [
            "of the table top",
            "of the table",
            "of the desk",
            "of the tabletop",
            "of my desk",
            "of the counter",
            "on the table",
            "of the workbench",
            "of the scene",
            "of this table",
            "of the bench",
            "of the surface",
        ];
        let length = |phrase: &&str| {
            let words = split(phrase);
            begins_with(&self.tokens, at, &words).then_some(words.len())
        };
        phrases.iter().filter_map(length).max().unwrap_or(0)
    }

    /// Signs of x and y of words such as "front left", and their number.
    fn sides(&self, at: usize) -> Option<((i8, i8), usize)> {
        let side = |word: &str| match word {
            "left" | "lefthand" => Some((-1, 0)),
            "right" | "righthand" => Some((1, 0)),
            "front" | "near" => Some((0, -1)),
            "back" | "rear" => Some((0, 1)),
            // Elsewhere "far" is no side.
            "far" => Some((0, 1)),
            "middle" | "center" | "centre" => Some((0, 0)),
            _ => None,
        };
        let (mut x, mut y) =
            side(self.word(at)).filter(|_| self.word(at) != "far" || self.is_far_corner(at))?;
        let mut length = 1;
        loop {
            length += usize::from(self.word(at + length) == "hand");
            let and = usize::from(self.word(at + length) == "and");
            let Some((more_x, more_y)) = side(self.word(at + length + and)) else { break };
            (x, y) = (x + more_x, y + more_y);
            length += and + 1;
        }
        ((-1..=1).contains(&x) && (-1..=1).contains(&y)).then_some(((x, y), length))
    }

    /// "10 cm to the left", "back by 5 cm", "forward".
    fn offsets(&self, start: usize, before_m: Option<f64>, from: usize) -> Vec<Span<Place>> {
        let mut found = Vec::new();
        for (patterns, direction) in DIRECTIONS {
            for pattern in *patterns {
                let words = split(pattern);
                if !begins_with(&self.tokens, from, &words) {
                    continue;
                }
                let end = from + words.len();
                let by = usize::from(self.word(end) == "by");
                let after = length_at(&self.tokens, end + by).filter(|_| before_m.is_none());
                let displaced = |distance_m: f64| PlaceKind::Offset(*direction * distance_m + DVec2::ZERO);
                match (before_m, after) {
                    (Some(distance_m), _) => {
                        found.push(self.place(start, from, end, 0.0, displaced(distance_m)))
                    }
                    (None, Some((distance_m, length))) => {
                        found.push(self.place(start, from, end + by + length, 0.0, displaced(distance_m)));
                    }
                    (None, None) => {
                        found.push(self.place(start, from, end, 0.5, PlaceKind::Direction(*direction)));
                    }
                }
            }
        }
        found
    }
}
