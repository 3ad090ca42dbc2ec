//! A part of a shape: a form, where it is placed, and its surface.

use serde::Deserialize;

use super::faces::{Faces, split};
use super::form::Form;
use super::forms::{Ball, Block, Cylinder, Extrusion, Hoop, Loft, Revolution, Silhouette, Torus, Tube};
use super::placement::{Circle, Mirror, Placement, Row};
use super::surface::MAIN;
use super::table_error::TableError;
use crate::Order;
use geometry::{DVec3, Solid};

/// One part, possibly repeated.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "PartTable")]
pub(super) struct Part {
    form: Form,
    placement: Placement,
    /// Amplitude of irregular bumps, share of the distance from the part's center.
    lumpy: f64,
    /// `main`, a surface of the shape, or a common surface.
    surface: String,
    /// Faces with another surface.
    faces: Vec<Faces>,
    /// Variants that have the part; every variant where it is empty.
    only_in: Vec<u32>,
}

/// A part as it stands in the file: exactly one of the forms is given.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartTable {
    #[serde(rename = "box")]
    block: Option<Block>,
    cylinder: Option<Cylinder>,
    ball: Option<Ball>,
    turned: Option<Revolution>,
    hoop: Option<Hoop>,
    ring: Option<Torus>,
    tube: Option<Tube>,
    plate: Option<Extrusion>,
    loft: Option<Loft>,
    inflated: Option<Silhouette>,
    #[serde(default)]
    at: DVec3,
    /// Rotations about x, then y, then z, degrees, about the form's own origin.
    #[serde(default)]
    turn: DVec3,
    mirror: Option<Mirror>,
    #[serde(default)]
    rows: Vec<Row>,
    circle: Option<Circle>,
    #[serde(default)]
    lumpy: f64,
    surface: Option<String>,
    #[serde(default)]
    faces: Vec<Faces>,
    #[serde(default)]
    only_in: Vec<u32>,
}

impl TryFrom<PartTable> for Part {
    type Error = TableError;

    fn try_from(table: PartTable) -> Result<Self, TableError> {
        let forms = [
            table.block.map(Form::Block),
            table.cylinder.map(Form::Cylinder),
            table.ball.map(Form::Ball),
            table.turned.map(Form::Revolution),
            table.hoop.map(Form::Hoop),
            table.ring.map(Form::Torus),
            table.tube.map(Form::Tube),
            table.plate.map(Form::Extrusion),
            table.loft.map(Form::Loft),
            table.inflated.map(Form::Silhouette),
        ];
        let mut given = forms.into_iter().flatten();
        let (Some(form), None) = (given.next(), given.next()) else {
            return Err(TableError::FormCount);
        };
        form.check_points()?;
        if !(0.0..0.5).contains(&table.lumpy) {
            return Err(TableError::Lumpy(table.lumpy));
        }
        let placement = Placement {
            at_m: table.at,
            turn_deg: table.turn,
            mirror: table.mirror,
            rows: table.rows,
            circle: table.circle,
        };
        let surface = table.surface.unwrap_or_else(|| MAIN.to_owned());
        let (faces, only_in) = (table.faces, table.only_in);
        Ok(Self { form, placement, lumpy: table.lumpy, surface, faces, only_in })
    }
}

impl Part {
    /// Whether its form is a closed solid.
    pub fn is_solid(&self) -> bool {
        self.form.is_solid()
    }

    /// Whether the variant with this number, from 1, has the part.
    pub fn is_in(&self, variant: u32) -> bool {
        self.only_in.is_empty() || self.only_in.contains(&variant)
    }

    /// Names of its surfaces.
    pub fn surfaces(&self) -> impl Iterator<Item = &str> {
        [&self.surface].into_iter().chain(self.faces.iter().map(|faces| &faces.surface)).map(String::as_str)
    }

    /// The solids of all copies in the shape's frame, meters, in pieces of one surface: its name and the piece. The
    /// pieces of a copy together are closed.
    pub fn pieces(&self, order: &mut Order) -> Vec<(&str, Solid)> {
        let solid = self.form.solid();
        let solid = if self.lumpy > 0.0 { super::form::bumpy(solid, self.lumpy, order) } else { solid };
        let pieces = split(solid, &self.surface, &self.faces);
        let placed =
            |(surface, piece)| self.placement.copies(&piece).into_iter().map(move |solid| (surface, solid));
        pieces.into_iter().flat_map(placed).collect()
    }
}
