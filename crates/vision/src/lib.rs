//! Reading a picture nobody here painted, by classical means: colors, lines, ellipses, one camera model.
//!
//! [`read_picture`] walks these steps, each in its own file: the plain backdrop is learned from the border;
//! the table top is the evenest large surface before it, its edge a quadrilateral or an ellipse; the
//! camera is the one that sees a level rectangle or circle there; what is neither bare top nor shadow nor
//! the table's own rim and legs is a thing; each thing becomes the simplest solid with its outline. It is
//! made for product pictures (plain light backdrop, level camera, whole table) and refuses rather than
//! guesses: [`VisionError`] says what was not found. [`descriptor`] is the classical form of `Phi`, [`dinov2`] the
//! learned one, which is given its weights. [`mask_repair`] mends masks that a network drew, [`cut_out`] takes a
//! thing off a plain backdrop, [`hidden_within`] tells what others hide of one, [`placement`] finds where a redrawn thing
//! lies, [`fidelity`] compares a picture with one of the scene made from it. [`network`] looks at frames with weights that
//! `training/` wrote; [`read_with_network`] reads by them, and [`category_fit`] names what was read.
//!
//! Vision knows pictures and geometry, neither jobs nor ports; nothing here is random.

mod settings;
mod error;
mod pixels;
mod regions;
mod polygon;
mod minimize;
mod backdrop;
mod surface;
mod outline;
mod camera_fit;
mod instances;
mod contour;
mod silhouette;
pub mod solid_fit;
mod hidden;
pub mod mask_repair;
pub mod cut_out;
pub mod placement;
pub mod fidelity;
mod reading;
mod learned;
pub mod category_fit;
pub mod descriptor;
pub mod dinov2;
pub mod network;

pub use error::VisionError;
pub use hidden::{attached, bitten_off, hidden_within};
pub use learned::{
    CandidateRegion, CandidateRegions, Measures, NetworkReadingSettings, candidate_regions, read_with_network,
};
pub use reading::{ObjectReading, PictureReading, TableReading, TopShape, read_picture};
pub use settings::VisionSettings;
pub use solid_fit::{Expected, ExpectedBase, Posture, SolidFit, SolidKind, fit_solid};

#[cfg(any(test, feature = "test-images"))]
pub mod tests;
