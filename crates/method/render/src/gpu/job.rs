//! The uniform of all passes: view, strip, light, layouts. Fields and order are those of job.wgsl.

use glam::{Affine3A, Vec3, Vec3A};

use super::light_words::{ImageLight, LightLayout};
use super::scene_words::SceneLayout;
use super::words::Words;
use crate::forward::floor_light;
use crate::forward::projection::Projection;
use crate::forward::scene_buffers::TriangleFilter;

/// Output of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Keys = 0,
    Fronts = 1,
    Layers = 2,
}

/// Rows of an image that are drawn at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strip {
    pub first_row_px: usize,
    pub rows_px: usize,
}

/// An image to be drawn. `projection` has the size in samples.
pub struct Job<'a> {
    pub projection: &'a Projection,
    /// Samples along each side of a pixel.
    pub samples: usize,
    pub scene: SceneLayout,
    /// With the layout of its buffer; `None` where no color is wanted.
    pub light: Option<(&'a ImageLight<'a>, LightLayout)>,
    pub layer_capacity: u32,
}

impl Job<'_> {
    pub fn width_px(&self) -> usize {
        self.projection.width_px / self.samples
    }

    /// The uniform of one pass over one strip.
    pub fn bytes(&self, strip: Strip, phase: Phase, kept: TriangleFilter) -> Words {
        let mut words = Words::default();
        let Projection { lens, height_px, .. } = self.projection;
        words.push_rows(self.projection.camera_from_world.as_affine3a());
        words.push_rows(self.projection.world_from_camera());
        let map = self.light.and_then(|(light, _)| light.environment.key_map.as_ref());
        words.push_rows(map.map_or(Affine3A::IDENTITY, |map| map.light_from_world));
        words.push_floats([lens.scale_x, lens.scale_y, lens.center_x, lens.center_y]);
        let [texels_per_m, texel_m, reach, spread] =
            map.map_or([0.0; 4], |map| [map.texels_per_m, map.texel_m, map.reach, map.spread]);
        let floor = self.light.and_then(|(light, _)| light.backdrop.floor_light.as_ref());
        let nodes_per_m = floor.map_or(0.0, |floor| floor.nodes_per_m);
        match self.light {
            Some((light, _)) => {
                let (environment, backdrop) = (&light.environment, &light.backdrop);
                let background = &backdrop.background;
                let lighting = &environment.lighting;
                let vector = |v: Vec3A| Vec3::from(v);
                words.push_vector(vector(environment.toward_key), lighting.key_radius_rad as f32);
                words.push_vector(lighting.key_color, lighting.exposure);
                words.push_vector(lighting.sky_color, background.floor_z_m().unwrap_or(0.0) as f32);
                words.push_vector(lighting.ground_color, nodes_per_m);
                words.push_vector(vector(environment.side_box), texels_per_m);
                words.push_vector(vector(environment.rim_box), texel_m);
                words.push_vector(background.top_color, reach);
                words.push_vector(background.bottom_color, spread);
                words.push_floats(backdrop.per_light.to_array());
            }
            None => words.push([0; 8 * 4 + 3]),
        }
        words.push([if floor.is_some() { floor_light::SIDE as u32 } else { 0 }]);
        words.push_floats(floor.map_or([0.0; 2], |floor| floor.low.to_array()));
        words.push([u32::from(lens.perspective), (self.samples * self.samples) as u32]);
        words.push([self.width_px() as u32, (height_px / self.samples) as u32]);
        words.push([strip.first_row_px as u32, strip.rows_px as u32, self.scene.triangles]);
        let has_room = self.light.is_some_and(|(light, _)| light.environment.room.is_some());
        let sky = if has_room { self.scene.sky_of_rooms } else { self.scene.sky };
        words.push([phase as u32, kept as u32, self.layer_capacity, sky.directions]);
        let SceneLayout { triangles_at, materials_at, disks_at, linear_of_srgb_at, .. } = self.scene;
        words.push([triangles_at, materials_at, sky.directions_at, disks_at, linear_of_srgb_at]);
        let [width, height, coarse_width, coarse_height] = map.map_or([0; 4], |map| {
            [map.width, map.height, map.coarse_width, map.coarse.len() / map.coarse_width]
        });
        words.push([width, height, coarse_width, coarse_height].map(|n| n as u32));
        let layout = self.light.map(|(_, layout)| layout).unwrap_or_default();
        words.push([layout.coarse_at, layout.fine_at, layout.floor_at, u32::from(has_room), layout.room_at]);
        words.push([layout.glass_at]);
        words.fill_quadruple();
        words
    }
}
