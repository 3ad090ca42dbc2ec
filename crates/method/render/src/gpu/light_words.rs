//! The light of one image as the kernels read it: the key light's map and the light on the backdrop's floor.

use super::words::Words;
use crate::forward::environment::Environment;
use crate::forward::floor_light::FloorLight;
use crate::lighting::Background;

/// Offsets of the lists in the buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightLayout {
    pub coarse_at: u32,
    pub fine_at: u32,
    pub floor_at: u32,
}

/// Lighting of one image.
pub struct ImageLight<'a> {
    pub environment: Environment<'a>,
    pub floor: Option<FloorLight>,
    pub background: Background,
}

/// The buffer's content: the map's keys, its blocks, the floor's nodes.
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
    if let Some(floor) = &light.floor {
        words.push_floats(floor.nodes.iter().flat_map(|node| node.to_array()));
    }
    (words, layout)
}
