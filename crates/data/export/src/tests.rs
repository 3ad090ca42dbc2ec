//! Tests across the formats of a bundle.

mod specimen;
mod bundle;
mod planted_faults;
mod label_round_trip;
mod stand_ins;
mod statements;
