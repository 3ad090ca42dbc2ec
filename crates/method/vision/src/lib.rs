//! Computer vision for images of tables: instance segmentation, shape fitting, classification, features and masks.
//!
//! [`read_with_network`] reads an image: the [`table_network`] predicts dense maps, instance segmentation turns them
//! into camera, table top and objects, and [`shape_fit`] fits a primitive to each object. [`category_fit`] assigns
//! catalog categories, with the guesses of the [`object_recognizer`]. [`VisionError`] names what was not found.
//!
//! Features of images: [`descriptor`] is the classical form of `Phi`, [`dinov2`] the learned one with given weights.
//! [`image_similarity`] compares a scene with its reference image. [`lpips`] is the perceptual distance of two images,
//! [`clip`] gives features of what an image means, both with given weights.
//!
//! Masks: [`mask_repair`] regrows eroded masks, [`occluded_by_shape`] and [`occluded_by_convexity`] complete occluded
//! ones, [`chroma_key`] removes uniform backgrounds, [`mask_registration`] aligns a regenerated object with its visible
//! pixels.
//!
//! All results are deterministic. The crate must not depend on the ports, the scene description, the store or the
//! server.
//!
//! ```
//! use geometry::{Camera, DVec3};
//! use imaging::Mask;
//!
//! let camera = Camera::orbit(320, 240, 0.5, DVec3::ZERO, 0.0, 0.6, 1.2);
//! let mask = Mask::from_fn(320, 240, |x, y| (140..180).contains(&x) && (90..140).contains(&y));
//! let primitive = vision::fit_solid(&mask, &camera, None, None).expect("the mask meets the table plane");
//! assert!(primitive.overlap > 0.8);
//! ```

mod error;
mod intrinsics;
mod measured_depth;
mod pixels;
mod morphology;
mod polygon;
mod contour;
mod silhouette;
pub mod shape_fit;
mod occlusion;
pub mod mask_repair;
pub mod chroma_key;
pub mod mask_registration;
pub mod image_similarity;
mod reading;
mod instance_segmentation;
pub mod category_fit;
pub mod descriptor;
mod network_weights;
mod unit_length;
mod bicubic;
mod resized_image;
mod patch_projection;
mod attention;
mod config_json;
pub mod dinov2;
pub mod clip;
pub mod lpips;
mod image_encoder;
pub mod table_network;
pub mod object_recognizer;
#[cfg(test)]
mod golden;

pub use error::VisionError;
pub use image_encoder::ImageEncoder;
pub use instance_segmentation::{
    CandidateRegion, CandidateRegions, KnownCamera, NetworkReadingSettings, RegionFeatures,
    candidate_regions, read_with_network,
};
pub use intrinsics::Intrinsics;
pub use measured_depth::{DepthDoubt, DepthUse};
pub use network_weights::{NetworkError, NetworkWeightsError};
pub use occlusion::{attached_component, occluded_by_convexity, occluded_by_shape};
pub use reading::{ImageReading, ObjectReading, TableReading, TopShape};
pub use resized_image::resized;
pub use shape_fit::{BasePrior, PosedPrimitive, Posture, PrimitiveKind, ShapePrior, fit_solid};
