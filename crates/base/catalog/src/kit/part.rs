//! A part of a shape: a form, where it is placed, and its surface.

use serde::Deserialize;

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
    pub surface: String,
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
        Ok(Self { form, placement, lumpy: table.lumpy, surface })
    }
}

impl Part {
    /// Whether its form is a closed solid.
    pub fn is_solid(&self) -> bool {
        self.form.is_solid()
    }

    /// The closed solids of all copies, in the shape's frame, meters.
    pub fn solids(&self, order: &mut Order) -> Vec<Solid> {
        let solid = self.form.solid();
        let solid = if self.lumpy > 0.0 { super::form::bumpy(solid, self.lumpy, order) } else { solid };
        self.placement.copies(&solid)
    }
}
