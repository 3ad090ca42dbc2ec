//! Domain-randomized pictures of one table with things on it, and the exact truth about each: what a network that
//! reads pictures is trained on and what readers are scored on.
//!
//! [`paint`] turns a split and a number into a [`Painting`]: a table of any shape and finish ([`table`]), up to
//! seventeen things from the catalog or made up of primitives ([`thing`], [`composite`]), set side by side, on and
//! in each other ([`arrangement`]), seen by some camera ([`viewpoint`]) before some backdrop ([`backdrop`]) in some
//! light ([`studio`]), developed well or badly ([`darkroom`]). Varied and believable enough is the aim, not beautiful: who
//! learns from these must find any thing on any top.
//!
//! Nothing is simulated: things stand where their undersides meet what is below, none overlaps another by more than
//! a convex footprint allows, and some lean on air where a carrier's top is uneven by less than a few millimeters.
//!
//! Training, validation and test pictures share no category of thing, no composite, no finish of a top and no
//! backdrop ([`split`]); outlines of tops, legs, cameras and lights come from the same draws in all three.
//!
//! Guarantees: the same split, number and width give the same bytes, on any day and with any number of threads.
//! Frames and units as everywhere: meters, radians, world = table top, pixel centers at +0.5. Cost: about 0.11 s of
//! one core for a picture 512 pixels wide.

pub mod split;
mod draw;
mod shape;
mod finish;
mod pattern;
mod legs;
mod table;
mod composite;
mod thing;
mod relief;
mod arrangement;
mod viewpoint;
mod studio;
mod backdrop;
mod darkroom;
mod truth;
mod painting;

pub use painting::{Painting, paint};
pub use shape::TableShape;
pub use split::Split;
pub use truth::{Labels, ObjectTruth, PictureTruth, TableTruth};

#[cfg(test)]
mod tests;
