//! Shapes described by data: the `[category.shape]` tables of `config/catalog/*.toml`.
//!
//! A shape is a list of parts. Each part is a form (a box, a body of revolution, an extruded outline, a lofted body, a
//! tube, an inflated silhouette) with a placement and a surface. Lengths are meters at the category's typical size; the
//! finished mesh is scaled to the extents of the recipe. Front toward -y, +z up. Parts overlap by half a millimeter
//! or more and do not share a face plane. A shape may also be `like` that of another category, with its own
//! surfaces.
//!
//! Deserialization refuses a part with two forms or too few points, an unknown finish and an unknown key;
//! [`Shape::check`] refuses forms that are no solids and surfaces that do not exist.

mod alternatives;
mod faces;
mod form;
mod forms;
mod surface;
mod table_error;
mod part;
mod skins;
mod stored_shape;
mod placement;

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use crate::{Order, category};
use alternatives::Alternatives;
use form::rested;
use geometry::{Material, TexturedMesh};
use part::Part;
pub use stored_shape::StoredShape;
use surface::{Finish, Surface};

/// Ratio of the scales of width and depth up to which a round shape stays round.
const ROUND_RATIO: f64 = 1.12;

/// A shape as its table defines it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// The category whose parts and surfaces this shape has. Its own parts are added to them; its own surfaces replace
    /// those of the same name.
    #[serde(default)]
    like: Option<String>,
    #[serde(default)]
    part: Vec<Part>,
    /// Number of variants; an object has the parts of one of them, drawn by its random stream.
    #[serde(default = "one")]
    variants: u32,
    /// Finish of the surface `main`, which has the object's color, and the requested material if there is one.
    #[serde(default)]
    finish: Option<Finish>,
    #[serde(default)]
    surface: BTreeMap<String, Alternatives>,
    /// Printed on labels; a made-up brand where it is absent.
    #[serde(default)]
    word: Option<String>,
    /// Whatever lies below this height is pressed up to it, so that the object has a facet to rest on.
    #[serde(default)]
    rest_m: f64,
}

const fn one() -> u32 {
    1
}

/// Reason why a shape cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShapeError {
    #[error("the shape has no parts; list them or name a category that it is like")]
    NoParts,
    /// The category that it is like is unknown, has no shape of its own, or is itself like another one.
    #[error("the shape cannot be like `{0}`, which has no parts of its own")]
    NotLike(String),
    #[error("no surface `{0}`: define it below `[category.shape.surface]`")]
    UnknownSurface(String),
    /// No part is in the variant with this number.
    #[error("variant {0} has no parts")]
    EmptyVariant(u32),
    /// The surface of the part with this number is open, or it encloses no volume.
    #[error("part {0} is no solid: its surface is open, inverted or encloses nothing")]
    NoSolid(usize),
}

impl Shape {
    /// The shape with the parts.
    fn origin(&self) -> Result<&Shape, ShapeError> {
        let Some(name) = &self.like else { return Ok(self) };
        let origin = category(name).and_then(|category| category.shape.as_ref()).map(StoredShape::get);
        origin.filter(|shape| shape.like.is_none()).ok_or_else(|| ShapeError::NotLike(name.clone()))
    }

    /// The parts of the shape that it is like, and its own.
    fn parts<'a>(&'a self, origin: &'a Shape) -> impl Iterator<Item = &'a Part> {
        let own = if self.like.is_some() { &self.part[..] } else { &[] };
        origin.part.iter().chain(own)
    }

    /// Checks that the shape has parts and every part is a solid with a surface. Builds the parts; the tests of the
    /// catalog check every shape.
    pub fn check(&self) -> Result<(), ShapeError> {
        let origin = self.origin()?;
        if origin.part.is_empty() {
            return Err(ShapeError::NoParts);
        }
        let known = |name: &str| {
            name == surface::MAIN
                || self.surface.contains_key(name)
                || origin.surface.contains_key(name)
                || surface::common(name).is_some()
        };
        if let Some(name) = self.parts(origin).flat_map(Part::surfaces).find(|name| !known(name)) {
            return Err(ShapeError::UnknownSurface(name.to_owned()));
        }
        let is_empty = |variant: &u32| !self.parts(origin).any(|part| part.is_in(*variant));
        if let Some(empty) = (1..=origin.variants.max(1)).find(is_empty) {
            return Err(ShapeError::EmptyVariant(empty));
        }
        match self.parts(origin).position(|part| !part.is_solid()) {
            Some(number) => Err(ShapeError::NoSolid(number)),
            None => Ok(()),
        }
    }

    /// The parts in meters at the typical size, not yet scaled to the order's extents.
    fn assembled(&self, order: &mut Order) -> TexturedMesh {
        let Ok(origin) = self.origin() else { return TexturedMesh::default() };
        let word = self.word.as_ref().or(origin.word.as_ref()).map_or("", String::as_str);
        let variant = if origin.variants > 1 { order.pick(origin.variants as usize) as u32 + 1 } else { 1 };
        let mut dressed: BTreeMap<&str, (Surface, Material)> = BTreeMap::new();
        let mut mesh = TexturedMesh::default();
        for part in self.parts(origin).filter(|part| part.is_in(variant)) {
            for (name, solid) in part.pieces(order) {
                let (surface, material) = dressed.entry(name).or_insert_with(|| {
                    let own = self.surface.get(name).or_else(|| origin.surface.get(name));
                    let own = own.and_then(|surfaces| surfaces.drawn(order)).cloned();
                    let finish = self.finish.or(origin.finish).unwrap_or_default();
                    let surface =
                        own.or_else(|| surface::common(name)).unwrap_or_else(|| Surface::main(finish));
                    let surface = surface.with_requested_material(name, order);
                    let material = surface.material(name, word, order);
                    (surface, material)
                });
                let solid = if origin.rest_m > 0.0 { rested(solid, origin.rest_m) } else { solid };
                mesh.add(surface.mapped(solid), material);
            }
        }
        mesh
    }
}

/// Builds the shape of the order's category in the order's extents; `None` if the category has no shape.
pub(crate) fn from_shape(order: &mut Order) -> Option<TexturedMesh> {
    let category = order.category;
    let mesh = category.shape.as_ref()?.get().assembled(order);
    let mut scale = order.size_m / mesh.size_m().max(DVec3::splat(1e-9));
    let round = !matches!(category.symmetry_order, 1 | 2);
    if round && (1.0 / ROUND_RATIO..ROUND_RATIO).contains(&(scale.x / scale.y)) {
        let across = 0.5 * (scale.x + scale.y);
        scale = DVec3::new(across, across, scale.z);
    }
    Some(mesh.seated().scaled(scale))
}

#[cfg(test)]
mod tests;
