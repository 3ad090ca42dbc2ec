//! Procedural textures: wood grain, labels, pages, ceramics.
