//! The paper's quantitative evaluation (Sec. Experiments and "Details of Experiments"): finished scenes against the
//! images that they were made from.
//!
//! [`Sweep`] places the 160 cameras of the protocol around a scene, and [`SweepRenderer`] renders what they see.
//! [`PerceptualModels`] holds LPIPS, DINOv2 and CLIP, as far as their weights are there, and [`score_views`] gives the
//! best and the mean score of each. [`PhysicalRates`] gathers collisions and stability from certificates.
//! [`EvaluationTable`] is the result as a document, as CSV and as a page.
//!
//! Ratings by language models and by people are not part of it. All results are deterministic on one processor. The
//! crate reads no files: weights, images and meshes come from the caller.
//!
//! ```
//! use evaluation::{SweptScene, Sweep};
//! use geometry::{DVec3, Material, Pose, Rgb, TexturedMesh, shapes};
//! use imaging::Image;
//!
//! let mut top = TexturedMesh::default();
//! top.add(shapes::block(DVec3::new(1.2, 0.6, 0.02)), &Material::plain("oak", Rgb::hex(0xa08060), 0.5));
//! let meshes = [(top, Pose::IDENTITY)];
//! let scene = SweptScene::of(&meshes).expect("a table");
//! let sweep = Sweep::around(&scene)?;
//! assert_eq!(Sweep::views().count(), 160);
//! let first = Sweep::views().next().expect("a view");
//! let camera = sweep.camera(&first, Sweep::size_px(&Image::filled(800, 600, [0; 4])));
//! assert!((camera.elevation_rad().to_degrees() - 90.0).abs() < 1e-9);
//! # Ok::<(), evaluation::SweepError>(())
//! ```

mod sweep;
mod sweep_renderer;
mod perceptual_models;
mod scores;
mod physical;
mod table;

pub use perceptual_models::{Metric, MissingWeights, Model, PerceptualModels, WeightsError, WeightsFile};
pub use physical::{PhysicalRates, ScenePhysics};
pub use scores::{BestView, MetricOutcome, MetricScores, SceneScores, ScoreError, score_views};
pub use sweep::{BoundingSphere, Sweep, SweepError, SweepView, SweptScene};
pub use sweep_renderer::SweepRenderer;
pub use table::{EvaluationTable, MetricMeans, SceneRow, UsedWeights};
