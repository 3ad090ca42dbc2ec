//! Shares of bodies that other bodies hide, in the hero view and from above.

use rayon::prelude::*;

use super::{HERO_AZIMUTHS_RAD, Studio};
use render::{RenderObject, View, silhouette};

/// Width of the images in which pixels are counted, and of those by which a direction is chosen.
const WIDTH_PX: u32 = 320;
const SMALL_WIDTH_PX: u32 = 120;

/// Hidden share of an object up to which it is seen well.
const SEEN_WELL: f64 = 0.25;

/// Shares of one body's pixels that other bodies hide, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HiddenShares {
    pub in_hero: f64,
    pub from_above: f64,
}

impl Studio<'_> {
    /// Of each body, in order, always by the CPU. Nothing is hidden of a body that is out of the frame.
    pub fn hidden_shares(&self) -> Vec<HiddenShares> {
        let views = [
            View::Perspective(self.hero_camera(self.hero_azimuth_rad, WIDTH_PX)),
            View::Orthographic(self.top_view(WIDTH_PX)),
        ];
        let [in_hero, from_above] = views.map(|view| self.hidden_in(&view));
        let both = in_hero.into_iter().zip(from_above);
        both.map(|(in_hero, from_above)| HiddenShares { in_hero, from_above }).collect()
    }

    /// The first direction of the hero image from which every object is seen well, or else the one from which the most
    /// hidden object is hidden least.
    pub(super) fn clearest_azimuth_rad(&self) -> f64 {
        let mut best = (f64::INFINITY, self.hero_azimuth_rad);
        for azimuth_rad in HERO_AZIMUTHS_RAD {
            let view = View::Perspective(self.hero_camera(azimuth_rad, SMALL_WIDTH_PX));
            // The table is never hidden as a whole.
            let hidden = self.hidden_in(&view).into_iter().skip(1).fold(0.0, f64::max);
            if hidden <= SEEN_WELL {
                return azimuth_rad;
            }
            if hidden < best.0 - 0.05 {
                best = (hidden, azimuth_rad);
            }
        }
        best.1
    }

    fn hidden_in(&self, view: &View) -> Vec<f64> {
        let seen = self.scene_cache.measure(view);
        let mut visible = vec![0_usize; self.bodies.len() + 1];
        seen.ids.iter().for_each(|id| visible[*id as usize] += 1);
        self.bodies
            .par_iter()
            .enumerate()
            .map(|(index, body)| {
                let id = index as u32 + 1;
                let object = RenderObject { mesh: body.mesh, world_from_object: body.world_from_object, id };
                let whole = silhouette(object, view).area_px();
                1.0 - visible[id as usize] as f64 / whole.max(1).max(visible[id as usize]) as f64
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::pipeline::preview::PreviewBody;
    use geometry::shapes::block;
    use geometry::{Material, Pose, Rgb, Solid, TexturedMesh};
    use render::RenderSettings;

    fn mesh(solid: Solid) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        mesh
    }

    #[test]
    fn a_board_over_half_of_a_block_hides_half_of_it_from_above() {
        let table = mesh(block(DVec3::new(1.0, 1.0, 0.05)).translated(DVec3::new(0.0, 0.0, -0.05)));
        let (low, board) = (mesh(block(DVec3::splat(0.2))), mesh(block(DVec3::new(0.3, 0.3, 0.02))));
        let at = |x: f64, z: f64| Pose::upright(DVec3::new(x, 0.0, z), 0.0);
        let bodies = [(&table, Pose::IDENTITY), (&low, at(0.0, 0.0)), (&board, at(0.15, 0.2))]
            .map(|(mesh, world_from_object)| PreviewBody { mesh, world_from_object });
        let quality =
            RenderSettings { supersampling: 1, shadow_map_px: 64, sky_directions: 4, sky_map_px: 16 };
        let found = Studio::new(&bodies, &quality).hidden_shares();
        assert!((found[1].from_above - 0.5).abs() < 0.05, "{found:?}");
        assert_eq!(found[2], HiddenShares { in_hero: 0.0, from_above: 0.0 });
        assert!(found[1].in_hero < found[1].from_above, "{found:?}");
    }

    #[test]
    fn the_hero_image_is_from_where_a_small_block_is_seen_past_a_tall_one() {
        let table = mesh(block(DVec3::new(1.0, 1.0, 0.05)).translated(DVec3::new(0.0, 0.0, -0.05)));
        let (low, tall) = (mesh(block(DVec3::splat(0.05))), mesh(block(DVec3::new(0.12, 0.12, 0.3))));
        let usual = HERO_AZIMUTHS_RAD[0];
        // The tall block stands between the small one and the usual viewer.
        let toward = DVec3::new(usual.sin(), -usual.cos(), 0.0);
        let bodies = [(&table, DVec3::ZERO), (&low, DVec3::ZERO), (&tall, 0.12 * toward)]
            .map(|(mesh, at)| PreviewBody { mesh, world_from_object: Pose::upright(at, usual) });
        let quality =
            RenderSettings { supersampling: 1, shadow_map_px: 64, sky_directions: 4, sky_map_px: 16 };
        assert_eq!(Studio::new(&bodies, &quality).hero_azimuth_rad, usual);
        let studio = Studio::with_room(&bodies, &quality, 1);
        assert_ne!(studio.hero_azimuth_rad, usual);
        assert!(studio.hidden_shares()[1].in_hero <= SEEN_WELL);
    }
}
