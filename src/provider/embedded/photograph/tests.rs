//! A painted picture, taken for a photograph, all the way to meshes.
