//! The light of one image as the kernels read it: the key light's map and the light on the backdrop's floor.

use super::words::Words;
use crate::forward::backdrop::{Backdrop, Sunspot};
use crate::forward::environment::Environment;
use crate::forward::environment_map::SIDES;
use crate::forward::room_light::RoomLight;

/// Offsets of the lists in the buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightLayout {
    pub coarse_at: u32,
    pub fine_at: u32,
    pub floor_at: u32,
    pub room_at: u32,
}

/// Lighting of one image.
pub struct ImageLight<'a> {
    pub environment: Environment<'a>,
    pub backdrop: Backdrop,
}

/// The buffer's content: the map's keys, its blocks, the floor's nodes, the room with its environment map.
pub fn light_words(light: &ImageLight) -> (Words, LightLayout) {
    let mut words = Words::default();
    let mut layout = LightLayout::default();
    if let Some(map) = &light.environment.key_map {
        words.push_keys(&map.keys);
        layout.coarse_at = words.count();
        words.push_keys(&map.coarse);
        layout.fine_at = words.count();
        words.push_keys(&map.fine);
    }
    layout.floor_at = words.count();
    if let Some(floor) = &light.backdrop.floor_light {
        words.push_floats(floor.nodes.iter().flat_map(|node| node.to_array()));
    }
    if let (Some(room), Some(sunspot)) = (&light.environment.room, &light.backdrop.sunspot) {
        push_room(&mut words, &mut layout, room, sunspot);
    }
    (words, layout)
}

/// The maps' texels, then the room in the order in which room_light.wgsl and backdrop.wgsl read it.
fn push_room(words: &mut Words, layout: &mut LightLayout, light: &RoomLight, sunspot: &Sunspot) {
    let map = light.map;
    let texels_at = words.count();
    words.push_floats(map.texels.iter().flat_map(|shares| shares.to_array()));
    layout.room_at = words.count();
    let (room, decor) = (&light.room, &light.room.decor);
    let tabletop = &room.tabletop;
    let (top_low, top_high) = (tabletop.low_m.as_vec2(), tabletop.high_m.as_vec2());
    let (low, high) = (room.low_m.as_vec2(), room.high_m.as_vec2());
    words.push_vector(light.window, light.toward_window.x);
    words.push_vector(light.wall, light.toward_window.y);
    words.push_vector(light.ceiling, tabletop.z_m as f32);
    words.push_vector(light.open_floor, 0.0);
    words.push_vector(light.open_tabletop, top_low.x);
    words.push_vector(decor.floor_colors[0], top_low.y);
    words.push_vector(decor.floor_colors[1], top_high.x);
    words.push_vector(decor.wall_color, top_high.y);
    words.push_vector(decor.skirting_color, low.x);
    words.push_vector(sunspot.right.into(), low.y);
    words.push_vector(sunspot.up.into(), high.x);
    words.push_floats(sunspot.center.to_array());
    words.push([room.seed, decor.floor as u32]);
    words.push_floats([high.y]);
    words.push(
        SIDES.iter().zip(map.starts).flat_map(|(side, start)| [*side as u32, texels_at + 4 * start as u32]),
    );
    words.push_floats(light.mirrored_tabletop.to_array());
}
