//! Batches: many scenes from one file.
//!
//! A batch is a file of requests, one JSON object per line ([`lines`]), or a recipe that expands to requests
//! ([`recipe`]). [`duplicates`] finds requests that are the same before anything is computed. [`counts`], [`pace`] and
//! [`budget`] follow the progress; [`output`] is the form of the results.
//!
//! The crate computes only: bytes come from any reader, times and costs are arguments. It opens no file, reads no clock
//! and knows no store.
//!
//! ```
//! use batches::Recipe;
//!
//! let recipe = r#"{"templates": ["a {color} mug"], "slots": {"color": ["red", "blue"]},
//!                  "seeds": {"first": 0, "count": 2}}"#;
//! let requests: Vec<_> = Recipe::parse(recipe.as_bytes())?.requests().collect();
//! assert_eq!(requests.len(), 4);
//! assert_eq!(requests[3].custom_id, "t0_blue_s1");
//! assert_eq!(requests[3].body.text.as_deref(), Some("a blue mug"));
//! # Ok::<(), batches::RecipeErrors>(())
//! ```

pub mod request;
mod json_error;
pub mod lines;
pub mod recipe;
pub mod duplicates;
pub mod counts;
pub mod state;
pub mod pace;
pub mod budget;
pub mod output;

pub use budget::{BatchBudget, Grant};
pub use counts::{RequestCounts, RequestState};
pub use duplicates::{Admission, Registry};
pub use lines::{Line, LineReader, MAX_LINE_BYTES};
pub use output::{OutputError, OutputLine};
pub use pace::Pace;
pub use recipe::{Recipe, RecipeError, RecipeErrors};
pub use request::{BatchRequest, ImageFile, MAX_REQUESTS, RequestBody, RequestDigest};
pub use state::BatchState;
