//! Benchmarks of the pipeline against synthetic ground truth.
//!
//! [`images`]: reads synthetic images without access to their truth and compares the estimate with it.
//!
//! [`layout`]: runs 78 synthetic scenes ([`scenes`]) through the pipeline's own stages up to `place`
//! ([`tabletopgen::pipeline::PreparedObjects`]), with exact or noisy inputs ([`noise`]). The layout is compared
//! with the truth ([`score`]) modulo indistinguishable yaws ([`indistinguishable_yaws`]). Collisions are counted
//! with stages removed ([`ablation`]). No stage reads the truth: the inputs of the stages pass through wrappers of
//! the ports ([`prerendered_reference`], [`recording_mesh_generator`], [`jittering_segmenter`]).
//!
//! [`persistent_planner`]: tells whether a motion problem can be solved at all.
//!
//! Guarantees: the same binary and settings give the same scores with any number of threads.

pub mod scenes;
pub mod noise;
pub mod prerendered_reference;
pub mod recording_mesh_generator;
pub mod jittering_segmenter;
pub mod layout;
pub mod indistinguishable_yaws;
pub mod ground_truth_scene;
pub mod score;
pub mod ablation;
pub mod statistics;
pub mod report;
pub mod images;
pub mod persistent_planner;
