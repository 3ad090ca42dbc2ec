//! Benchmarks of the pipeline against what is known of painted scenes.
//!
//! `pictures` ([`pictures`]): painted pictures whose truth is withheld are read, and the reading is compared.
//!
//! `layout` ([`layout`]): 78 painted scenes ([`scenes`]) go through the pipeline's own stages up to
//! `place` ([`tabletopgen::pipeline::Rotated`]), as they are or spoiled ([`noise`]); the layout is compared with the truth
//! ([`score`]) modulo yaws that look the same ([`look_alikes`]), and collisions are counted with stages taken out ([`ablation`]).
//! No stage reads the truth: what the stages see goes through ports that stand before the real ones ([`painted`],
//! [`watched_meshes`], [`jittered_boxes`]).
//!
//! Guarantees: the same binary and settings give the same scores with any number of threads.

pub mod scenes;
pub mod noise;
pub mod painted;
pub mod watched_meshes;
pub mod jittered_boxes;
pub mod layout;
pub mod look_alikes;
pub mod true_world;
pub mod score;
pub mod ablation;
pub mod statistics;
pub mod report;
pub mod pictures;
