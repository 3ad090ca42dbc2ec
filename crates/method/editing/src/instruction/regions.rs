//! Parts of the table and displacements: "in the front left corner", "5 cm from the left edge", "10 cm to the left".

use glam::DVec2;

use super::Reason;
use super::cursor::{Cursor, Outcome};
use scene::EditPlace;
use scene::RelationKind::{
    AtBack, AtBackLeft, AtBackRight, AtCenter, AtFront, AtFrontLeft, AtFrontRight, AtLeft, AtRight,
    FromBackEdge, FromFrontEdge, FromLeftEdge, FromRightEdge,
};

const TABLE_SUFFIXES: &[&str] = &[
    "of the table top",
    "of the table",
    "of the desk",
    "of the tabletop",
    "of my desk",
    "of the counter",
    "on the table",
];

impl Cursor {
    /// "10 cm to the left", "back by 5 cm".
    pub fn offset(&mut self, before_m: Option<f64>) -> Outcome<Option<EditPlace>> {
        let start = self.at;
        let directions: [(&[&str], DVec2); 4] = [
            (&["to the left", "left", "leftwards", "towards the left", "toward the left"], -DVec2::X),
            (&["to the right", "right", "rightwards", "towards the right", "toward the right"], DVec2::X),
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
                ],
                -DVec2::Y,
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
                ],
                DVec2::Y,
            ),
        ];
        let found = directions.into_iter().find_map(|(patterns, direction)| {
            self.length_of_any(self.at, patterns).map(|length| (direction, length))
        });
        let Some((direction, length)) = found else { return Ok(None) };
        let next = self.at + length;
        let after = if self.is_at(next, "by") { self.distance_at(next + 1) } else { None };
        let (distance_m, end) = match (before_m, after) {
            (None, Some((distance_m, length))) => (distance_m, next + 1 + length),
            (Some(distance_m), None) => (distance_m, next),
            _ => return Ok(None),
        };
        let more = if self.is_at(end, "edge") || self.is_at(end, "side") { 1 } else { 0 };
        if !self.is_boundary(end + more) || (before_m.is_some() && more > 0) {
            self.at = start;
            return Ok(None);
        }
        self.at = end;
        let offset_m = Some(direction * distance_m + DVec2::ZERO);
        Ok(Some(EditPlace { offset_m, ..EditPlace::default() }))
    }

    /// A region of the table, whether it is an edge, and the index after it.
    pub fn region_at(&self, index: usize) -> Option<((i8, i8), bool, usize)> {
        let prepositions =
            ["at", "in", "on", "to", "into", "toward", "towards", "near", "from", "along", "away from"];
        let length = self.length_of_any(index, &prepositions).filter(|_| index < self.tokens.len())?;
        let mut at = index + length;
        at += usize::from(self.is_at(at, "the"));
        at += usize::from(matches!(self.word(at), "very"));
        let mut region: Option<(i8, i8)> = None;
        while let Some((x, y)) = side(self.word(at)) {
            let (known_x, known_y) = region.unwrap_or((0, 0));
            region = Some((known_x + x, known_y + y));
            at += 1;
        }
        let region = region?;
        let is_edge = matches!(self.word(at), "edge" | "border");
        if is_edge || matches!(self.word(at), "side" | "corner" | "end" | "half" | "part" | "area") {
            at += 1;
        }
        let of_table = self.length_of_any(at, TABLE_SUFFIXES);
        at += of_table.unwrap_or(0);
        let noun_follows = of_table.is_none() && !self.is_boundary(at) && self.preposition_at(at).is_none();
        let of_object = self.is_at(at, "of");
        (!of_object && !noun_follows).then_some((region, is_edge, at))
    }

    pub fn region(
        &self,
        start: usize,
        region: (i8, i8),
        is_edge: bool,
        distance_m: Option<f64>,
    ) -> Outcome<EditPlace> {
        let edge = match region {
            (-1, 0) => Some(FromLeftEdge),
            (1, 0) => Some(FromRightEdge),
            (0, -1) => Some(FromFrontEdge),
            (0, 1) => Some(FromBackEdge),
            _ => None,
        };
        if is_edge || distance_m.is_some() {
            let Some(edge) = edge else {
                return Err(self.error(start, self.at, Reason::NotUnderstood("name one edge of the table")));
            };
            return Ok(EditPlace { distance_m, ..EditPlace::at(edge) });
        }
        let whole = self.text(start, self.at).to_lowercase();
        if matches!(whole.as_str(), "to the left" | "to the right") {
            return Err(self.error(start, self.at, Reason::HowFar));
        }
        let kind = match region {
            (0, 0) => AtCenter,
            (-1, 0) => AtLeft,
            (1, 0) => AtRight,
            (0, -1) => AtFront,
            (0, 1) => AtBack,
            (-1, -1) => AtFrontLeft,
            (1, -1) => AtFrontRight,
            (-1, 1) => AtBackLeft,
            (1, 1) => AtBackRight,
            _ => return Err(self.error(start, self.at, Reason::NotUnderstood("name one part of the table"))),
        };
        Ok(EditPlace::at(kind))
    }
}

fn side(word: &str) -> Option<(i8, i8)> {
    Some(match word {
        "left" | "left-hand" => (-1, 0),
        "right" | "right-hand" => (1, 0),
        "front" => (0, -1),
        "back" | "rear" => (0, 1),
        "front-left" => (-1, -1),
        "front-right" => (1, -1),
        "back-left" => (-1, 1),
        "back-right" => (1, 1),
        "middle" | "center" | "centre" => (0, 0),
        _ => return None,
    })
}
