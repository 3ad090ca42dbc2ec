//! Stages against scenes whose truth is known.

mod truth;
mod features;
