//! Cache of the last readings, so that the segmenter does not repeat the analyst's reading.
//!
//! A reading is a function of the image and the reader, so the cache changes no result.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use sha2::{Digest as _, Sha256};

use imaging::{DepthImage, Image};
use vision::ImageReading;

/// Capacity; a reading holds a byte a pixel for every object.
const KEPT: usize = 3;

#[derive(Default)]
pub(super) struct ReadingCache(Mutex<VecDeque<(ImageKey, Arc<ImageReading>)>>);

/// Width, height and digest of the pixels and their depths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ImageKey([u32; 2], [u8; 32]);

impl ImageKey {
    pub(super) fn of(image: &Image, depth: Option<&DepthImage>) -> Self {
        let mut digest = Sha256::new_with_prefix(image.as_rgba());
        if let Some(depth) = depth {
            digest.update(depth.width_px().to_le_bytes());
            depth.depths_mm().iter().for_each(|depth_mm| digest.update(depth_mm.to_le_bytes()));
        }
        Self([image.width_px(), image.height_px()], digest.finalize().into())
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
