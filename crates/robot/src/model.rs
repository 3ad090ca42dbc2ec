//! What a robot is: its links, joints, limits and shapes, as read from a file, and the views that others compute with.

pub mod limits;
pub mod sphere_model;
