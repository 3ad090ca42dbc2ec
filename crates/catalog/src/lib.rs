//! The parametric object catalog: what things are called, how large they are, what they are made of,
//! and functions that build their meshes.
//!
//! Data live in `config/catalog/*.toml` and `config/materials.toml` and enter the binary by
//! `include_str!`; each category names a generator in one of the family modules below. Same recipe,
//! same mesh, on any day.

mod category;
mod recipe;
mod assembly;
mod stock;
pub mod substance;
mod wikidata;
pub mod physical;
pub mod texture;
pub mod dining;
pub mod office;
pub mod workbench;
pub mod crafting;
pub mod tables;

pub use category::{Affordance, Category, Facing, SizeRange, Zone, categories, category};
pub use physical::{PhysicalProperties, made_of, physical_properties};
pub use recipe::{Generator, Order, Recipe, build, stocked};
pub use substance::{Substance, substance};
pub use tables::{
    BuiltTable, OUTLINED_TABLE, TableModel, build_outlined_table, build_table, stocked_table, table_models,
};
pub use wikidata::wikidata_item;
