//! The light of one image as the kernels read it: the key light's maps and the light on the backdrop's floor.

use super::words::Words;
use crate::forward::backdrop::furnishing::Furnishing;
use crate::forward::backdrop::{Backdrop, Sunspot};
use crate::forward::environment::Environment;
use crate::forward::environment_map::SIDES;
use crate::forward::light_map::glass::{GlassShadow, NEAR_LEVEL};
use crate::forward::room_light::RoomLight;

/// Offsets of the lists in the buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightLayout {
    pub coarse_at: u32,
    pub fine_at: u32,
    pub floor_at: u32,
    pub room_at: u32,
    /// 0: there is no glass.
    pub glass_at: u32,
}

/// Lighting of one image.
pub struct ImageLight<'a> {
    pub environment: Environment<'a>,
    pub backdrop: Backdrop,
}

/// The buffer's content: the map's keys, its blocks, its glass, the floor's nodes, the room with its environment map.
pub fn light_words(light: &ImageLight) -> (Words, LightLayout) {
    let mut words = Words::default();
    let mut layout = LightLayout::default();
    if let Some(map) = &light.environment.key_map {
        words.push_keys(&map.keys);
        layout.coarse_at = words.count();
        words.push_keys(&map.coarse);
        layout.fine_at = words.count();
        words.push_keys(&map.fine);
        if let Some(glass) = &map.glass {
            layout.glass_at = push_glass(&mut words, glass);
        }
    }
    layout.floor_at = words.count();
    if let Some(floor) = &light.backdrop.floor_light {
        words.push_floats(floor.nodes.iter().flat_map(|node| node.to_array()));
    }
    let Backdrop { sunspot, furnishing, .. } = &light.backdrop;
    if let (Some(room), Some(sunspot), Some(furnishing)) = (&light.environment.room, sunspot, furnishing) {
        push_room(&mut words, &mut layout, room, sunspot, furnishing);
    }
    (words, layout)
}

/// The texels of all levels and the highest keys; then where the latter lie, their number each way, and of each level
/// its first word, width and height: where that table lies. Never 0, since the map's keys come first.
fn push_glass(words: &mut Words, glass: &GlassShadow) -> u32 {
    let mut table = Vec::new();
    for level in &glass.levels {
        table.extend([words.count(), level.width as u32, level.height as u32]);
        words.push_floats(level.texels.iter().flat_map(|texel| texel.to_array()));
    }
    let near_at = words.count();
    words.push_keys(&glass.near);
    let at = words.count();
    let coarse = &glass.levels[NEAR_LEVEL];
    words.push([near_at, coarse.width as u32, coarse.height as u32]);
    words.push(table);
    at
}

/// The maps' texels, then the room in the order in which room_light.wgsl and backdrop.wgsl read it.
fn push_room(
    words: &mut Words,
    layout: &mut LightLayout,
    light: &RoomLight,
    sunspot: &Sunspot,
    furnishing: &Furnishing,
) {
    let map = light.map;
    let patches_at = furnishing.walls.each_ref().map(|patches| {
        let at = words.count();
        for patch in patches {
            words.push_floats([patch.center.x, patch.center.y, patch.half.x, patch.half.y]);
            words.push_vector(patch.color, patch.cover);
            words.push_floats([patch.blur]);
        }
        [at, patches.len() as u32]
    });
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
    words.push_floats(sunspot.half_m.to_array().into_iter().chain(sunspot.panes.to_array()));
    words.push_floats([sunspot.bar_m, sunspot.penumbra_m, sunspot.slats_m, sunspot.curtain_m]);
    words.push_floats([sunspot.curtain_side, sunspot.leaves, sunspot.strength]);
    words.push([sunspot.seed]);
    words.push(patches_at.into_iter().flatten());
}
