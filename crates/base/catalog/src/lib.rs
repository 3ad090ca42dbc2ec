//! The parametric object catalog: names, sizes, materials and shapes of object categories, and the meshes built from
//! them.
//!
//! Data live in `config/catalog/*.toml` and `config/materials.toml` and are compiled in by `include_str!`; a program
//! may add categories of the user ([`add_categories`]). Each category has a shape, which the module `kit` builds.
//! Tables, whose proportions are free, are built by functions.
//! Building is deterministic: the same recipe gives the same mesh. The crate must not depend on rendering, scenes,
//! models or file formats.
//!
//! ```
//! use catalog::{Recipe, build};
//!
//! let recipe = Recipe::typical("mug", None, None).expect("a category of the catalog");
//! let mesh = build(&recipe).expect("every category has a shape");
//! assert!((mesh.size_m() - recipe.size_m).length() < 0.01);
//! ```

mod category;
mod added;
mod recipe;
mod kit;
mod mesh_cache;
pub mod checks;
pub mod color;
pub mod substance;
mod wikidata;
pub mod stand_in;
pub mod physical;
pub mod texture;
pub mod tables;
pub mod wear;

pub use added::{CategoryError, CategoryFault, add_categories, added_digest, read_categories};
pub use category::{
    Affordance, Category, Facing, SizeRange, State, Zone, categories, category, category_called,
};
pub use kit::{ShapeError, StoredShape};
pub use physical::{PhysicalProperties, made_of, physical_properties};
pub use recipe::{Order, Recipe, build, build_cached};
pub use substance::{Substance, substance};
pub use tables::{
    BuiltTable, OUTLINED_TABLE, TableModel, build_cached_table, build_outlined_table, build_table,
    table_models,
};
pub use wikidata::wikidata_item;
