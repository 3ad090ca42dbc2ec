//! The last readings of pictures, so that the port that is asked for masks does not read what the port before it read.
//!
//! A reading is a function of the picture and of the reader, so that this changes no result.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use sha2::{Digest as _, Sha256};

use imaging::Image;
use vision::PictureReading;

/// Readings that are kept; each holds a byte a pixel for every thing it found.
const KEPT: usize = 3;

#[derive(Default)]
pub(super) struct RecentReadings(Mutex<VecDeque<(PictureKey, Arc<PictureReading>)>>);

/// Width, height and digest of the pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PictureKey([u32; 2], [u8; 32]);

impl PictureKey {
    pub(super) fn of(picture: &Image) -> Self {
        let digest = Sha256::digest(picture.as_rgba());
        Self([picture.width_px(), picture.height_px()], digest.into())
    }
}

impl RecentReadings {
    pub(super) fn find(&self, key: &PictureKey) -> Option<Arc<PictureReading>> {
        let readings = self.0.lock().ok()?;
        readings.iter().find(|(of, _)| of == key).map(|(_, reading)| reading.clone())
    }

    pub(super) fn keep(&self, key: PictureKey, reading: &Arc<PictureReading>) {
        if let Ok(mut readings) = self.0.lock() {
            readings.truncate(KEPT - 1);
            readings.push_front((key, reading.clone()));
        }
    }
}
