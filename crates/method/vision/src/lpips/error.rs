//! Errors of reading weights and of comparing images.

use super::MIN_SIDE_PX;
use crate::network_weights::NetworkWeightsError;
use runtime::Cancelled;

/// Reason why a model is rejected; the caller adds the file names.
#[derive(Debug, thiserror::Error)]
pub enum LpipsWeightsError {
    #[error("the backbone's file does not hold the state dict of torchvision's {network}: {source}")]
    Backbone { network: &'static str, source: NetworkWeightsError },
    #[error("the file of linear layers is not that of LPIPS 0.1 for the backbone {network}: {source}")]
    LinearLayers { network: &'static str, source: NetworkWeightsError },
}

/// Reason why a comparison failed.
#[derive(Debug, thiserror::Error)]
pub enum LpipsError {
    #[error(
        "comparing images by LPIPS: {width_px} x {height_px} pixels are too few; resize both images to at least \
         {MIN_SIDE_PX} pixels a side"
    )]
    TooSmall { width_px: u32, height_px: u32 },
    #[error(
        "comparing images by LPIPS: one has {} x {} pixels, the other {} x {}; resize one to the size of the other",
        a[0], a[1], b[0], b[1]
    )]
    SizesDiffer { a: [u32; 2], b: [u32; 2] },
    #[error("comparing images by LPIPS: the maps are of another network; compute both with this one")]
    NetworksDiffer,
    #[error("the distance is not finite; these weights are of no use for these images")]
    NotFinite,
    #[error("a tensor operation failed: {0}")]
    Computation(#[from] candle_core::Error),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
