//! The surface of a part: a finish and its colors.

use serde::Deserialize;

use super::table_error::TableError;
use crate::Order;
use crate::texture::print::{Mapping, Print, PrintOrder, print};
use crate::texture::{
    is_finish, mapped_from_above, mapped_from_front, mapped_from_side, mapped_on_box, material_finish,
    wrapped_around,
};
use geometry::{Material, Rgb, Solid, Vec2};

/// The surface of parts that name none: the object's color and the requested material.
pub(super) const MAIN: &str = "main";

/// One repeat of a woven, grained or speckled surface, meters.
const REPEAT_M: f64 = 0.12;

/// A surface as its table defines it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Surface {
    #[serde(default)]
    finish: Finish,
    #[serde(default)]
    color: Tint,
    /// Second color of patterns and labels; `main` is the object's, the others follow from the surface's.
    #[serde(default = "Tint::contrasting")]
    second: Tint,
    /// Printed on a label, in place of the shape's word.
    #[serde(default)]
    word: Option<String>,
    /// Number of stripes, squares or sprinkles.
    #[serde(default)]
    count: Option<u32>,
    /// Share of light that the surface lets through.
    #[serde(default)]
    transparency: f32,
    /// In place of those of the finish.
    roughness: Option<f32>,
    metalness: Option<f32>,
    /// Whether it becomes of the material that was asked for, as `main` does.
    #[serde(default)]
    takes_material: bool,
    map: Option<Mapping>,
    /// Number of times that an image repeats along u and v.
    repeat: Option<Vec2>,
}

/// Rule by which a color follows from the object's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(super) enum Tint {
    #[default]
    Same,
    Lighter,
    Darker,
    /// Light beside a dark color and dark beside a light one.
    Contrasting,
    Fixed(Rgb),
}

impl Tint {
    fn contrasting() -> Self {
        Self::Contrasting
    }

    fn of(self, main: Rgb) -> Rgb {
        let [r, g, b] = main.0;
        match self {
            Self::Same => main,
            Self::Lighter => main.mix(Rgb([1.0; 3]), 0.45),
            Self::Darker => main.scaled(0.62),
            Self::Contrasting if 0.3 * r + 0.6 * g + 0.1 * b > 0.55 => main.scaled(0.35),
            Self::Contrasting => main.mix(Rgb([1.0, 0.98, 0.93]), 0.82),
            Self::Fixed(color) => color,
        }
    }
}

impl TryFrom<String> for Tint {
    type Error = TableError;

    fn try_from(text: String) -> Result<Self, TableError> {
        match text.as_str() {
            "main" => Ok(Self::Same),
            "lighter" => Ok(Self::Lighter),
            "darker" => Ok(Self::Darker),
            "contrasting" => Ok(Self::Contrasting),
            _ => {
                let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
                let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
                number.map(|number| Self::Fixed(Rgb::hex(number))).ok_or(TableError::UnknownColor(text))
            }
        }
    }
}

/// One of [`MATERIALS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MaterialName(&'static str);

/// The kind of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(super) enum Finish {
    /// Smooth plastic.
    #[default]
    Plastic,
    Gloss,
    Matte,
    /// A material that [`material_finish`] knows.
    Material(MaterialName),
    /// An image that [`print`] knows.
    Print(&'static Print),
}

/// Names of [`Finish::Material`]s, which need a static lifetime.
const MATERIALS: &[&str] = &[
    "oak",
    "walnut",
    "pine",
    "birch",
    "beech",
    "maple",
    "bamboo",
    "wood",
    "steel",
    "cast_iron",
    "aluminum",
    "chrome",
    "copper",
    "brass",
    "gold",
    "glass",
    "ceramic",
    "porcelain",
    "stoneware",
    "terracotta",
    "rubber",
    "leather",
    "fabric",
    "cork",
    "paper",
    "cardboard",
    "stone",
    "marble",
    "wicker",
];

impl TryFrom<String> for Finish {
    type Error = TableError;

    fn try_from(text: String) -> Result<Self, TableError> {
        let finish = match text.as_str() {
            "plastic" => Self::Plastic,
            "gloss" => Self::Gloss,
            "matte" => Self::Matte,
            _ => match (MATERIALS.iter().find(|name| **name == text), print(&text)) {
                (Some(material), _) => Self::Material(MaterialName(material)),
                (None, Some(print)) => Self::Print(print),
                (None, None) => return Err(TableError::UnknownFinish(text)),
            },
        };
        Ok(finish)
    }
}

/// Surfaces that every shape may use.
pub(super) fn common(name: &str) -> Option<Surface> {
    let surface =
        |finish: Finish, color: u32| Surface { color: Tint::Fixed(Rgb::hex(color)), ..Surface::main(finish) };
    let derived = |color: Tint| Surface { color, ..Surface::main(Finish::Plastic) };
    let surface = match name {
        "steel" => surface(Finish::Material(MaterialName("steel")), 0xc9_cb_cd),
        "chrome" => surface(Finish::Material(MaterialName("chrome")), 0xdd_de_e0),
        "brass" => surface(Finish::Material(MaterialName("brass")), 0xc9_a2_4c),
        "gold" => surface(Finish::Material(MaterialName("gold")), 0xe0_b9_4e),
        "wood" => surface(Finish::Material(MaterialName("beech")), 0xcf_a4_70),
        "paper" => surface(Finish::Matte, 0xf2_ee_e4),
        "cardboard" => surface(Finish::Matte, 0xb8_92_62),
        "glass" => Surface { transparency: 0.6, ..surface(Finish::Gloss, 0xdc_ea_ee) },
        "black" => surface(Finish::Matte, 0x24_25_28),
        "dark" => surface(Finish::Matte, 0x3c_3f_45),
        "gray" => surface(Finish::Plastic, 0x8d_91_96),
        "white" => surface(Finish::Plastic, 0xf2_f1_ec),
        "cream" => surface(Finish::Plastic, 0xef_e4_c8),
        "red" => surface(Finish::Plastic, 0xc0_30_2a),
        "orange" => surface(Finish::Plastic, 0xe8_84_26),
        "yellow" => surface(Finish::Plastic, 0xf0_c8_30),
        "green" => surface(Finish::Plastic, 0x3a_8f_4a),
        "blue" => surface(Finish::Plastic, 0x2f_63_b5),
        "purple" => surface(Finish::Plastic, 0x6f_47_9c),
        "pink" => surface(Finish::Plastic, 0xe6_9a_b0),
        "brown" => surface(Finish::Matte, 0x6e_47_2c),
        "leaf" => surface(Finish::Matte, 0x4d_84_36),
        "stem" => surface(Finish::Matte, 0x77_71_3c),
        "lighter" => derived(Tint::Lighter),
        "darker" => derived(Tint::Darker),
        "contrasting" => derived(Tint::Contrasting),
        _ => return None,
    };
    Some(surface)
}

impl Surface {
    /// The object's color with this finish.
    pub fn main(finish: Finish) -> Self {
        Self {
            finish,
            color: Tint::Same,
            second: Tint::Contrasting,
            word: None,
            count: None,
            transparency: 0.0,
            roughness: None,
            metalness: None,
            takes_material: false,
            map: None,
            repeat: None,
        }
    }

    /// The material that was asked for, if the surface of this name takes it.
    fn requested<'a>(&self, name: &str, order: &Order<'a>) -> Option<&'a str> {
        order.material.filter(|material| (name == MAIN || self.takes_material) && is_finish(material))
    }

    /// The surface with the material that was asked for, which repeats, in place of a print.
    pub fn with_requested_material(self, name: &str, order: &Order) -> Self {
        let printed = matches!(self.finish, Finish::Print(_));
        match self.requested(name, order) {
            Some(_) if printed => Self { map: Some(Mapping::Tiled), repeat: None, ..self },
            _ => self,
        }
    }

    /// The material, called `name`. `word` is the shape's.
    pub fn material(&self, name: &str, word: &str, order: &mut Order) -> Material {
        let color = self.color.of(order.color);
        let word = self.word.as_deref().unwrap_or(word);
        let asked = self.requested(name, order);
        let ink = if self.second == Tint::Same { order.color } else { self.second.of(color) };
        let rng = &mut order.rng;
        let material = match (asked, self.finish) {
            (Some(asked), _) => material_finish(asked, color, rng),
            (None, Finish::Plastic) => Material::plain(name, color, 0.38),
            (None, Finish::Gloss) => Material::plain(name, color, 0.14),
            (None, Finish::Matte) => Material::plain(name, color, 0.8),
            (None, Finish::Material(material)) => material_finish(material.0, color, rng),
            (None, Finish::Print(print)) => {
                let image =
                    (print.draw)(&mut PrintOrder { ground: color, ink, word, count: self.count, rng });
                Material::textured(name, image, print.roughness)
            }
        };
        let own = if asked.is_none() { (self.roughness, self.metalness) } else { (None, None) };
        Material {
            name: name.to_owned(),
            opacity: material.opacity * (1.0 - self.transparency),
            roughness: own.0.unwrap_or(material.roughness),
            metalness: own.1.unwrap_or(material.metalness),
            ..material
        }
    }

    /// The solid with texture coordinates for this finish.
    pub fn mapped(&self, solid: Solid) -> Solid {
        let usual = match self.finish {
            Finish::Material(_) => Mapping::Tiled,
            Finish::Print(print) => print.mapping,
            Finish::Plastic | Finish::Gloss | Finish::Matte => Mapping::Own,
        };
        let mut solid = match self.map.unwrap_or(usual) {
            Mapping::Front => mapped_from_front(solid),
            Mapping::Top => mapped_from_above(solid),
            Mapping::Side => mapped_from_side(solid),
            Mapping::Around => wrapped_around(solid),
            Mapping::Box => mapped_on_box(solid),
            Mapping::Tiled => solid.with_box_uvs(REPEAT_M),
            Mapping::Own => solid,
        };
        if let Some(repeat) = self.repeat {
            solid.uvs.iter_mut().for_each(|uv| *uv *= repeat);
        }
        solid
    }
}
