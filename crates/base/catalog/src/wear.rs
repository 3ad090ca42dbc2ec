//! Traces of use: scratches, stains, rings of cups and dust, drawn onto the textures of a mesh.
//!
//! Method: every kind of mark has a density on the surface, marks for each square meter, and a size in meters. The
//! scale of a texture is the mean length that it covers on the triangles that show it, so that a scratch of 20 mm has
//! 20 mm on a tabletop and on a carton alike. Marks wrap around the edges of the image, since textures repeat.
//!
//! Left as they are: food, glass, cloth, ceramics, screens, surfaces without a texture, and textures that repeat on an
//! object, where each mark would be seen many times. The shape never changes.

mod marks;

use geometry::{Material, Rgb, TexturedMesh};
use glam::{DVec2, DVec3};
use imaging::{Image, Texture};
use rand::RngExt;
use runtime::seed::{Rng, child_rng};

use self::marks::Canvas;
use crate::tables::{TOPS, grain::METERS_PER_REPEAT};
use crate::{made_of, texture::Noise};

/// Size of the image of a top of one color, pixels along and across.
const ONE_COLOR_PX: [u32; 2] = [768, 512];
/// Most marks of one kind on one texture.
const MAX_MARKS: usize = 400;
/// Repeats of a texture on an object from which marks would be seen to repeat.
const MAX_REPEATS: f64 = 1.3;

/// Marks that a substance gets.
#[derive(Clone, Copy)]
struct Marks {
    /// For each square meter of a surface that is worn as far as possible.
    scratches: f64,
    scratch_m: (f64, f64),
    stains: f64,
    rings: f64,
    /// Share of the color that dust may take.
    dust: f32,
    /// Contrast of a scratch and of a stain.
    scratch_contrast: f32,
    stain_contrast: f32,
}

impl Marks {
    /// Marks of a tabletop with this finish.
    fn of_top(finish: &str) -> Self {
        let usual = Self {
            scratches: 90.0,
            scratch_m: (0.012, 0.12),
            stains: 14.0,
            rings: 6.0,
            dust: 0.08,
            scratch_contrast: 0.3,
            stain_contrast: 0.13,
        };
        match finish {
            "paint" => Self { scratch_contrast: 0.22, stain_contrast: 0.1, ..usual },
            "marble" | "granite" | "terrazzo" | "concrete" | "tile" => {
                Self { scratches: 12.0, rings: 3.0, scratch_contrast: 0.12, stain_contrast: 0.09, ..usual }
            }
            "steel" => Self { scratches: 240.0, rings: 2.0, scratch_contrast: 0.14, ..usual },
            _ => usual,
        }
    }

    /// Marks of an object of this substance; `None` where use leaves no marks that a texture could show.
    fn of_substance(name: &str) -> Option<Self> {
        let small = Self {
            scratches: 500.0,
            scratch_m: (0.004, 0.03),
            stains: 60.0,
            rings: 0.0,
            dust: 0.06,
            scratch_contrast: 0.3,
            stain_contrast: 0.12,
        };
        match name {
            "wood" | "plywood" | "leather" => Some(small),
            "paper" | "cardboard" | "plastic" | "hard_plastic" => {
                Some(Self { scratches: 350.0, scratch_contrast: 0.24, stain_contrast: 0.08, ..small })
            }
            "steel" | "aluminum" | "brass" | "cast_iron" => {
                Some(Self { scratches: 900.0, stains: 20.0, scratch_contrast: 0.16, ..small })
            }
            _ => None,
        }
    }
}

/// The mesh of an object of the category after use: `wear` from 0, as new, to 1. `material` as in [`made_of`]. Meters;
/// the same seed gives the same marks.
pub fn worn_object(
    mut mesh: TexturedMesh,
    category_name: &str,
    material: Option<&str>,
    wear: f64,
    seed: u64,
) -> TexturedMesh {
    let Some(marks) = Marks::of_substance(made_of(category_name, material)).filter(|_| wear > 0.0) else {
        return mesh;
    };
    for index in 0..mesh.materials.len() {
        let Some(scale) = Scale::of(&mesh, index).filter(|scale| scale.repeats.max_element() < MAX_REPEATS)
        else {
            continue;
        };
        let known = &mesh.materials[index];
        let Some(texture) = known.base_color_texture.as_ref().filter(|_| known.opacity >= 1.0) else {
            continue;
        };
        let rng = &mut child_rng(seed, &format!("wear of {}", known.name));
        let texture = marked(texture, scale.meters_per_repeat, marks, wear, rng);
        mesh.materials[index].base_color_texture = Some(texture);
    }
    mesh
}

/// The mesh of a table of the catalog after use, likewise: its top. A top of one color gets a texture.
pub fn worn_table(mut mesh: TexturedMesh, wear: f64, seed: u64) -> TexturedMesh {
    let is_top = |known: &&mut Material| TOPS.contains(&known.name.as_str()) && known.opacity >= 1.0;
    if let Some(top) = mesh.materials.iter_mut().find(is_top).filter(|_| wear > 0.0) {
        let rng = &mut child_rng(seed, "wear of the top");
        let texture = top.base_color_texture.take().unwrap_or_else(|| rolled(top.base_color, rng));
        let marks = Marks::of_top(&top.name);
        top.base_color_texture = Some(marked(&texture, METERS_PER_REPEAT, marks, wear, rng));
        top.base_color = Rgb([1.0; 3]);
    }
    mesh
}

/// One color as a roller leaves it: it varies by about a hundredth.
fn rolled(color: Rgb, rng: &mut Rng) -> Texture {
    let [broad, fine] = [(7, 5), (160, 110)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let [width, height] = ONE_COLOR_PX;
    crate::texture::draw_texture(width, height, |u, v| {
        color.scaled(1.0 + 0.014 * (broad.at(u, v) - 0.5) + 0.012 * (fine.at(u, v) - 0.5))
    })
}

/// Scale of a texture on a mesh.
struct Scale {
    /// Along u and v.
    meters_per_repeat: DVec2,
    /// Number of repeats that the mesh shows, along u and v.
    repeats: DVec2,
}

impl Scale {
    /// Mean over the triangles of a material, weighted by area; `None` if they have no extent in the image.
    fn of(mesh: &TexturedMesh, material: usize) -> Option<Self> {
        let groups = mesh.groups.iter().filter(|group| group.material == material);
        let (mut lengths, mut area) = (DVec2::ZERO, 0.0);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corners in groups.flat_map(|group| &group.triangles) {
            let [a, b, c] = corners.map(|k| mesh.positions[k as usize]);
            let [ta, tb, tc] = corners.map(|k| mesh.uvs[k as usize].as_dvec2());
            for t in [ta, tb, tc] {
                (low, high) = (low.min(t), high.max(t));
            }
            let ([p, q], [s, t]) = ([b - a, c - a], [tb - ta, tc - ta]);
            let turn = s.perp_dot(t);
            if turn.abs() < 1e-12 {
                continue;
            }
            let along_u: DVec3 = (p * t.y - q * s.y) / turn;
            let along_v: DVec3 = (q * s.x - p * t.x) / turn;
            let weight = p.cross(q).length();
            lengths += weight * DVec2::new(along_u.length(), along_v.length());
            area += weight;
        }
        (area > 0.0).then(|| Self { meters_per_repeat: lengths / area, repeats: high - low })
    }
}

/// The texture with marks of a surface that is worn by `wear`, 0..=1.
fn marked(texture: &Texture, meters_per_repeat: DVec2, marks: Marks, wear: f64, rng: &mut Rng) -> Texture {
    let mut canvas = Canvas::new(Image::clone(texture), meters_per_repeat.as_vec2());
    let area_m2 = meters_per_repeat.x * meters_per_repeat.y;
    let number = |density: f64, rng: &mut Rng| {
        let expected = wear * density * area_m2;
        ((expected + rng.random_range(0.0..1.0)) as usize).min(MAX_MARKS)
    };
    let strength = 0.55 + 0.45 * wear as f32;
    canvas.dust(marks.dust * wear as f32, rng);
    for _ in 0..number(marks.stains, rng) {
        canvas.stain(strength * marks.stain_contrast, rng);
    }
    for _ in 0..number(marks.rings, rng) {
        canvas.ring(strength * marks.stain_contrast, rng);
    }
    for _ in 0..number(marks.scratches, rng) {
        canvas.scratch(marks.scratch_m, strength * marks.scratch_contrast, rng);
    }
    Texture::new(canvas.image)
}

#[cfg(test)]
mod tests;
