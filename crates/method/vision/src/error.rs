//! Errors of the image reader.

use super::network_weights::NetworkError;
use imaging::codec::MIN_SCENE_SIDE_PX;
use runtime::Cancelled;

/// Reason why an image cannot be read, with advice. The reader refuses; it never substitutes missing parts.
#[derive(Debug, thiserror::Error)]
pub enum VisionError {
    #[error(
        "reading the image: {width_px} x {height_px} pixels are too few to tell objects apart; send one \
         of at least {MIN_SCENE_SIDE_PX} pixels a side"
    )]
    TooSmall { width_px: u32, height_px: u32 },
    #[error(
        "reading the image: no object that stands on a table top was found in it; send an image of one whole \
         table, seen somewhat from above, with objects on it that differ from the top"
    )]
    NoObjects,
    #[error(
        "reading the image: {count} separate objects were found on the table, which is not plausible \
         (a patterned top?); use a plain top or fewer objects"
    )]
    TooManyObjects { count: usize },
    #[error(
        "reading the image: no table top fills at least {percent:.0} % of it; send an image that shows the whole \
         table"
    )]
    NoTableTop { percent: f64 },
    #[error(
        "reading the image: what may be its table top lies in pieces without a clear outline, the largest \
         {largest_percent:.0} % of them, like the floor of a room; send an image that one table fills for the most \
         part, seen somewhat from above"
    )]
    NoSingleTop { largest_percent: f64 },
    #[error(
        "reading the image: a table top was found, but no camera above it shows it with this outline; hold the camera \
         level and show the whole table"
    )]
    NoCamera,
    #[error("reading the image: {0}")]
    Network(NetworkError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl VisionError {
    /// Stable error code, `[a-z_]+`.
    pub fn code(&self) -> &'static str {
        match self {
            Self::TooSmall { .. } => "image_too_small",
            Self::NoTableTop { .. } | Self::NoSingleTop { .. } => "no_table_top",
            Self::NoCamera => "camera_unclear",
            Self::NoObjects => "no_objects",
            Self::TooManyObjects { .. } => "too_many_objects",
            Self::Network(_) => "network_failed",
            Self::Cancelled(_) => "interrupted",
        }
    }
}

impl From<NetworkError> for VisionError {
    fn from(error: NetworkError) -> Self {
        match error {
            NetworkError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Network(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_message_gives_advice() {
        let refusals = [
            VisionError::TooSmall { width_px: 9, height_px: 9 },
            VisionError::NoObjects,
            VisionError::TooManyObjects { count: 99 },
            VisionError::NoTableTop { percent: 3.0 },
            VisionError::NoSingleTop { largest_percent: 40.0 },
            VisionError::NoCamera,
        ];
        for refusal in refusals {
            let words = refusal.to_string();
            let advice = words.split_once("; ").map_or("", |(_, advice)| advice);
            let begins = ["send ", "hold ", "set ", "use "];
            assert!(begins.iter().any(|word| advice.starts_with(word)), "{}: {words}", refusal.code());
        }
    }
}
