//! Images with the knowledge of the embedded ports, from generation or analysis.

use imaging::{Image, Mask};
use ports::{Completion, TopViewImage};
use scene::{InstanceMask, Recognition};

use super::image_fingerprint::Fingerprint;

/// An image and its content.
pub struct RecognizedImage {
    pub image: Image,
    pub recognition: Recognition,
    /// In the order of `recognition.objects`.
    pub masks: Vec<InstanceMask>,
    /// Table pixels, if known.
    pub table: Option<Mask>,
    /// Each object alone and complete, in the same order.
    pub alone: Vec<Completion>,
    /// The top view, if the image was generated here.
    pub top: Option<TopViewImage>,
    /// Whether it was generated here, so that labels are catalog categories.
    pub rendered: bool,
    pub seed: u64,
}

/// An image with the fingerprints of its parts, to recognize them in requests.
pub struct FingerprintedImage {
    pub recognized: RecognizedImage,
    pub whole: Fingerprint,
    /// Per object, of its visible pixels; `None` if it is hidden.
    pub visible: Vec<Option<Fingerprint>>,
    /// Per object, of its complete image.
    pub alone: Vec<Option<Fingerprint>>,
}

impl FingerprintedImage {
    /// `None` if the image is transparent.
    pub fn new(recognized: RecognizedImage) -> Option<Self> {
        let whole = Fingerprint::of(&recognized.image)?;
        let visible = recognized
            .masks
            .iter()
            .map(|mask| Fingerprint::masked(&recognized.image, &mask.visible))
            .collect();
        let alone = recognized.alone.iter().map(|alone| Fingerprint::of(&alone.image)).collect();
        Some(Self { recognized, whole, visible, alone })
    }
}

impl RecognizedImage {
    /// Boxes around the visible pixels of each object, shares of the image's width and height; `None` if it is
    /// hidden.
    pub fn boxes(&self) -> Vec<Option<[f64; 4]>> {
        let (width, height) = (f64::from(self.image.width_px()), f64::from(self.image.height_px()));
        let share = |[x0, y0, x1, y1]: [f64; 4]| [x0 / width, y0 / height, x1 / width, y1 / height];
        self.masks
            .iter()
            .map(|mask| mask.visible.bbox_px().map(|corners| share(corners.map(f64::from))))
            .collect()
    }

    /// The object whose box is closest to this one, shares of the image.
    pub fn object_at(&self, place: [f64; 4]) -> Option<usize> {
        let apart = |other: [f64; 4]| -> f64 { place.iter().zip(other).map(|(a, b)| (a - b).abs()).sum() };
        let boxes = self.boxes();
        let distances = boxes.iter().enumerate().filter_map(|(index, place)| Some((index, apart((*place)?))));
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    /// Resamples a mask of this image to another size, nearest pixels.
    pub fn scaled(mask: &Mask, width_px: u32, height_px: u32) -> Mask {
        if (mask.width_px(), mask.height_px()) == (width_px, height_px) {
            return mask.clone();
        }
        let across = f64::from(mask.width_px()) / f64::from(width_px.max(1));
        let down = f64::from(mask.height_px()) / f64::from(height_px.max(1));
        let at = |place: u32, factor: f64| ((f64::from(place) + 0.5) * factor) as u32;
        Mask::from_fn(width_px, height_px, |x, y| mask.contains(at(x, across), at(y, down)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_masks_keep_relative_position() {
        let mask = Mask::from_fn(40, 20, |x, y| (10..20).contains(&x) && y < 5);
        assert_eq!(RecognizedImage::scaled(&mask, 80, 40).bbox_px(), Some([20, 0, 40, 10]));
        assert_eq!(RecognizedImage::scaled(&mask, 20, 10).bbox_px(), Some([5, 0, 10, 2]));
        assert_eq!(RecognizedImage::scaled(&mask, 40, 20), mask);
    }
}
