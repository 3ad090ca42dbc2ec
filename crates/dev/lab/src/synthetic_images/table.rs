//! Random tables: a top of some outline and finish on legs.

use glam::{DQuat, DVec2, DVec3};

use super::Split;
use super::finish::{Finish, Mapping, Top, frame_finish};
use super::legs::{self, LegSpace};
use super::sampling::{chance, pick, uniform, weighted};
use super::shape::{self, TableShape};
use catalog::build_outlined_table;
use geometry::shapes::{inset, slab};
use geometry::{Material, Outline, Pose, Rgb, TexturedMesh};
use imaging::srgb::encode_srgb;
use rand::RngExt;
use render::{RenderObject, Tabletop};
use runtime::seed::Rng;

/// A table in the world frame: top surface at z = 0, feet at -`height_m`.
pub(super) struct Table {
    pub shape: TableShape,
    pub finish: Finish,
    pub mesh: TexturedMesh,
    /// Edge of the flat part of the top.
    pub outline: Outline,
    pub height_m: f64,
    /// Average color of the top.
    pub color: Rgb,
    /// Reflectivity of the top for the objects on it, 0..1.
    pub mirror_share: f64,
}

/// Samples a table of the split.
pub(super) fn draw(split: Split, rng: &mut Rng) -> Table {
    loop {
        let (shape, edge) = shape::draw(rng);
        let finish = Finish::draw(split, rng);
        if let Some(table) = of_catalog(shape, &edge, finish, rng) {
            return table;
        }
        let top = Top::new(finish, rng);
        let thickness_m =
            weighted(rng, &[(0.012, 1.0), (0.022, 2.0), (0.032, 3.0), (0.05, 1.0)]) * uniform(rng, 0.8, 1.2);
        let eased_m = uniform(rng, 0.001, 0.4 * thickness_m).min(0.012);
        let Ok(outline) = Outline::new(inset(&edge, eased_m)) else { continue };
        let height_m = height_m(rng);
        let mut mesh = TexturedMesh::default();
        let solid =
            slab(&edge, thickness_m, eased_m).with_flat_ends().translated(DVec3::new(0.0, 0.0, -thickness_m));
        mesh.add(mapped(solid, top.mapping, &outline, rng), &top.material);
        let frame = frame_finish(&top, rng);
        if chance(rng, 0.1) {
            add_edge_band(&mut mesh, &edge, thickness_m, eased_m, &frame);
        }
        let under = LegSpace { shape, outline: &outline, underside_m: -thickness_m, floor_m: -height_m };
        legs::add(&mut mesh, &under, &frame, rng);
        let mirror_share = if finish.is_glossy() && chance(rng, 0.8) {
            uniform(rng, 0.15, 0.7)
        } else if chance(rng, 0.08) {
            uniform(rng, 0.05, 0.3)
        } else {
            0.0
        };
        return Table { shape, finish, mesh, outline, height_m, color: top.color, mirror_share };
    }
}

fn height_m(rng: &mut Rng) -> f64 {
    if chance(rng, 0.2) { uniform(rng, 0.3, 0.55) } else { uniform(rng, 0.55, 0.95) }
}

/// The catalog's table with that edge and finish, as in scenes.
fn of_catalog(shape: TableShape, edge: &[DVec2], finish: Finish, rng: &mut Rng) -> Option<Table> {
    let materials = finish.of_catalog();
    if materials.is_empty() {
        return None;
    }
    let (height_m, legs, material) = (height_m(rng), rng.random_range(3..=4), pick(rng, materials));
    let edge = Outline::new(edge.to_vec()).ok()?;
    let built = build_outlined_table(&edge, height_m, legs, None, Some(material), rng.random())?;
    let top = Tabletop::of(&RenderObject { mesh: &built.mesh, world_from_object: Pose::IDENTITY, id: 1 });
    let color = Rgb(top.color.to_array().map(|linear| f32::from(encode_srgb(linear)) / 255.0));
    Some(Table {
        shape,
        finish,
        mesh: built.mesh,
        outline: built.outline_m,
        height_m,
        color,
        mirror_share: 0.0,
    })
}

/// Maps the texture onto the slab, with straight or slanted grain.
pub(super) fn mapped(
    mut solid: geometry::Solid,
    mapping: Mapping,
    outline: &Outline,
    rng: &mut Rng,
) -> geometry::Solid {
    match mapping {
        Mapping::Repeated { meters } => {
            let turn = weighted(rng, &[(0.0, 6.0), (0.25, 2.0), (0.125, 1.0)]) * std::f64::consts::TAU;
            let offset = DVec3::new(uniform(rng, 0.0, 9.0), uniform(rng, 0.0, 9.0), 0.0);
            let there = DQuat::from_rotation_z(turn);
            solid = solid.rotated(there).translated(offset).with_box_uvs(meters);
            solid.translated(-offset).rotated(there.conjugate())
        }
        Mapping::Once => {
            let (low, high) = outline.bounds();
            for (uv, p) in solid.uvs.iter_mut().zip(&solid.positions) {
                *uv = ((p.truncate() - low) / (high - low))
                    .clamp(DVec2::splat(0.002), DVec2::splat(0.998))
                    .as_vec2();
            }
            solid
        }
    }
}

/// Adds a band of another material around the edge, just outside the slab.
fn add_edge_band(
    mesh: &mut TexturedMesh,
    edge: &[DVec2],
    thickness_m: f64,
    eased_m: f64,
    material: &Material,
) {
    let height = thickness_m - 2.0 * eased_m;
    if height > 0.004 {
        let band = geometry::shapes::prism(&inset(edge, -0.0015), height);
        mesh.add(band.translated(DVec3::new(0.0, 0.0, eased_m - thickness_m)), material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn table_top_is_at_zero_and_feet_reach_floor() {
        for seed in 0..80 {
            let table = draw(Split::Training, &mut child_rng(seed, "table"));
            let (low, high) = table.mesh.bounds();
            let context = format!("{seed} {:?} {low} {high} {}", table.shape, table.height_m);
            assert!(high.z.abs() < 1e-9, "{context}");
            assert!((low.z + table.height_m).abs() < 0.03, "{context}");
            let (inner, outer) = table.outline.bounds();
            assert!(inner.x > low.x - 1e-9 && outer.x < high.x + 1e-9, "{context}");
            let sound = table.mesh.positions.iter().all(|p| p.is_finite())
                && table.mesh.uvs.iter().all(|uv| uv.is_finite());
            assert!(sound, "{context}");
        }
    }
}
