//! Why a picture was not read.

use super::network::NetworkError;
use runtime::Interrupted;

/// What was not found in a picture, and what to send instead. Nothing is made up in its place.
#[derive(Debug, thiserror::Error)]
pub enum VisionError {
    #[error(
        "reading the picture: {width_px} x {height_px} pixels are too few to tell things apart; send one \
         of at least 160 pixels a side"
    )]
    TooSmall { width_px: u32, height_px: u32 },
    #[error(
        "reading the picture: no table top could be told from the background, because only {percent:.0} % \
         of the border shows one plain backdrop; send a picture of the whole table before a plain light wall"
    )]
    BackdropNotPlain { percent: f64 },
    #[error(
        "reading the picture: no table top could be told from the background: no even surface fills at \
         least {percent:.0} % of it; send a picture that shows the whole table, before a backdrop of \
         another color"
    )]
    NoTop { percent: f64 },
    #[error(
        "reading the picture: the surface found is neither a rectangle nor a circle (it covers {percent:.0} \
         % of the nearer of the two); send a rectangular or round table whose edge shows all around"
    )]
    OutlineUnclear { percent: f64 },
    #[error(
        "reading the picture: no camera shows a level rectangular or round table with the outline found \
         ({residual_px:.0} pixels off); hold the camera level and show the whole table"
    )]
    CameraUnclear { residual_px: f64 },
    #[error(
        "reading the picture: nothing that stands on a table top could be told apart in it; send a picture of one whole \
         table, seen somewhat from above, with things on it that differ from the top"
    )]
    NoObjects,
    #[error(
        "reading the picture: what stands on the table could not be told apart: one outline covers \
         {percent:.0} % of the top; set the objects apart, or use a top of another color than theirs"
    )]
    ObjectsNotSeparated { percent: f64 },
    #[error(
        "reading the picture: {count} separate things were found on the table, more than can be believed \
         (a patterned top?); use a plain top or fewer objects"
    )]
    TooManyObjects { count: usize },
    #[error(
        "reading the picture: no table top fills at least {percent:.0} % of it; send a picture that shows the whole \
         table"
    )]
    NoTopSeen { percent: f64 },
    #[error(
        "reading the picture: a table top was found, but no camera above it shows it with this outline; hold the camera \
         level and show the whole table"
    )]
    NoCamera,
    #[error("reading the picture: {0}")]
    Network(NetworkError),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl VisionError {
    /// Stable name of the reason, `[a-z_]+`.
    pub fn code(&self) -> &'static str {
        match self {
            Self::TooSmall { .. } => "picture_too_small",
            Self::BackdropNotPlain { .. } => "backdrop_not_plain",
            Self::NoTop { .. } | Self::NoTopSeen { .. } => "no_table_top",
            Self::OutlineUnclear { .. } => "table_outline_unclear",
            Self::CameraUnclear { .. } | Self::NoCamera => "camera_unclear",
            Self::NoObjects => "no_objects",
            Self::ObjectsNotSeparated { .. } => "objects_not_separated",
            Self::TooManyObjects { .. } => "too_many_objects",
            Self::Network(_) => "network_failed",
            Self::Interrupted(_) => "interrupted",
        }
    }
}

impl From<NetworkError> for VisionError {
    fn from(error: NetworkError) -> Self {
        match error {
            NetworkError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            other => Self::Network(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_says_what_to_do() {
        let refusals = [
            VisionError::TooSmall { width_px: 9, height_px: 9 },
            VisionError::BackdropNotPlain { percent: 20.0 },
            VisionError::NoTop { percent: 6.0 },
            VisionError::OutlineUnclear { percent: 70.0 },
            VisionError::CameraUnclear { residual_px: 9.0 },
            VisionError::NoObjects,
            VisionError::ObjectsNotSeparated { percent: 60.0 },
            VisionError::TooManyObjects { count: 99 },
            VisionError::NoTopSeen { percent: 3.0 },
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
