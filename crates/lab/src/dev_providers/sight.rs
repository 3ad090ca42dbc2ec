//! A picture with all that the embedded ports know of it: painted here, or looked at here.

use imaging::{Image, Mask};
use ports::{Completion, TopPicture};
use scene::{InstanceMask, Recognition};

use super::likeness::Look;

/// A picture and what is on it.
pub struct Sight {
    pub picture: Image,
    pub recognition: Recognition,
    /// In the order of `recognition.objects`.
    pub masks: Vec<InstanceMask>,
    /// Pixels of the table, where they are known.
    pub table: Option<Mask>,
    /// Each object alone and whole, in the same order.
    pub alone: Vec<Completion>,
    /// The view from above, of a picture that was painted here.
    pub top: Option<TopPicture>,
    /// Painted here, so that labels name categories of the catalog.
    pub painted: bool,
    pub seed: u64,
}

/// A sight with what its parts look like, so that they are known when they are seen again.
pub struct KnownSight {
    pub sight: Sight,
    pub whole: Look,
    /// Of what shows of each object; `None` for what is hidden.
    pub visible: Vec<Option<Look>>,
    /// Of each object alone.
    pub alone: Vec<Option<Look>>,
}

impl KnownSight {
    /// `None` where the picture is transparent.
    pub fn new(sight: Sight) -> Option<Self> {
        let whole = Look::of(&sight.picture)?;
        let visible = sight.masks.iter().map(|mask| Look::masked(&sight.picture, &mask.visible)).collect();
        let alone = sight.alone.iter().map(|alone| Look::of(&alone.picture)).collect();
        Some(Self { sight, whole, visible, alone })
    }
}

impl Sight {
    /// Boxes around what shows of each object, shares of the picture's width and height; `None` for what is hidden.
    pub fn boxes(&self) -> Vec<Option<[f64; 4]>> {
        let (width, height) = (f64::from(self.picture.width_px()), f64::from(self.picture.height_px()));
        let share = |[x0, y0, x1, y1]: [f64; 4]| [x0 / width, y0 / height, x1 / width, y1 / height];
        self.masks
            .iter()
            .map(|mask| mask.visible.bbox_px().map(|corners| share(corners.map(f64::from))))
            .collect()
    }

    /// The object whose box is nearest to this one, shares of the picture.
    pub fn object_at(&self, place: [f64; 4]) -> Option<usize> {
        let apart = |other: [f64; 4]| -> f64 { place.iter().zip(other).map(|(a, b)| (a - b).abs()).sum() };
        let boxes = self.boxes();
        let seen = boxes.iter().enumerate().filter_map(|(index, place)| Some((index, apart((*place)?))));
        seen.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    /// A mask of this picture on a copy of another size, nearest pixels.
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
    fn masks_keep_their_place_when_they_are_scaled() {
        let mask = Mask::from_fn(40, 20, |x, y| (10..20).contains(&x) && y < 5);
        assert_eq!(Sight::scaled(&mask, 80, 40).bbox_px(), Some([20, 0, 40, 10]));
        assert_eq!(Sight::scaled(&mask, 20, 10).bbox_px(), Some([5, 0, 10, 2]));
        assert_eq!(Sight::scaled(&mask, 40, 20), mask);
    }
}
