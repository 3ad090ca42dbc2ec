//! Embedded adapters of the ports: real algorithms that need no key, no network and no GPU.

pub mod analyst;
pub mod layout;
pub mod painter;
pub mod orientation;
pub mod scene_analyst;
pub mod known_segmenter;
pub mod mesh_generator;
