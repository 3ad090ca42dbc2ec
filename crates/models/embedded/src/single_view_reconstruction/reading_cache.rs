//! Cache of the last readings, so that the segmenter does not repeat the analyst's reading.
//!
//! A reading is a function of the image and the reader, so the cache changes no result.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use sha2::{Digest as _, Sha256};

use imaging::Image;
use vision::ImageReading;

/// Capacity; a reading holds a byte a pixel for every object.
const KEPT: usize = 3;

#[derive(Default)]
pub(super) struct ReadingCache(Mutex<VecDeque<(ImageKey, Arc<ImageReading>)>>);

/// Width, height and digest of the pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ImageKey([u32; 2], [u8; 32]);

impl ImageKey {
    pub(super) fn of(image: &Image) -> Self {
        let digest = Sha256::digest(image.as_rgba());
        Self([image.width_px(), image.height_px()], digest.into())
    }
}

impl ReadingCache {
    pub(super) fn find(&self, key: &ImageKey) -> Option<Arc<ImageReading>> {
        let readings = self.0.lock().ok()?;
        readings.iter().find(|(of, _)| of == key).map(|(_, reading)| reading.clone())
    }

    pub(super) fn keep(&self, key: ImageKey, reading: &Arc<ImageReading>) {
        if let Ok(mut readings) = self.0.lock() {
            readings.truncate(KEPT - 1);
            readings.push_front((key, reading.clone()));
        }
    }
}
