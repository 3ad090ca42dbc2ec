//! A segmenter that perturbs the boxes on the top view.

use std::sync::Arc;

use futures::FutureExt;
use rand::RngExt;

use super::noise::Noise;
use imaging::Mask;
use ports::{Adapter, Answer, Call, ReferenceImage, Segmentation, Segmenter, TopBoxes, TopViewImage};
use runtime::seed::{Rng, child_rng};
use scene::Recognition;

/// Wraps `segmenter`; masks are unchanged.
pub struct JitteringSegmenter {
    pub segmenter: Arc<dyn Segmenter>,
    pub noise: Noise,
    /// Seed of the scene; each box uses a child seed.
    pub seed: u64,
}

impl Segmenter for JitteringSegmenter {
    fn adapter(&self) -> Adapter {
        let inner = self.segmenter.adapter();
        Adapter::new("evaluate/jittered", &inner.model, &(inner.settings, self.noise, self.seed))
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        self.segmenter.segment(call, reference, recognition)
    }

    fn table<'a>(&'a self, call: &'a Call, reference: ReferenceImage) -> Answer<'a, Option<Mask>> {
        self.segmenter.table(call, reference)
    }

    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopViewImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        async move {
            let mut boxes = self.segmenter.top_boxes(call, top, recognition).await?;
            let rng = |name: &str| child_rng(self.seed, &format!("box {name}"));
            let share = self.noise.box_share;
            boxes.table_px = jittered(boxes.table_px, share, &mut rng("table"));
            for found in &mut boxes.objects {
                found.box_px = jittered(found.box_px, share, &mut rng(found.id.as_str()));
            }
            Ok(boxes)
        }
        .boxed()
    }
}

/// Moves each side uniformly by at most `share` of the box extent across it.
fn jittered([x0, y0, x1, y1]: [f64; 4], share: f64, rng: &mut Rng) -> [f64; 4] {
    let mut moved = |at: f64, extent: f64| at + share * extent * rng.random_range(-1.0..1.0);
    let (width, height) = (x1 - x0, y1 - y0);
    [moved(x0, width), moved(y0, height), moved(x1, width), moved(y1, height)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jittered_sides_move_by_at_most_their_share() {
        let mut rng = child_rng(1, "box");
        for _ in 0..200 {
            let [x0, y0, x1, y1] = jittered([100.0, 50.0, 300.0, 150.0], 0.03, &mut rng);
            let off = [(x0 - 100.0) / 200.0, (y0 - 50.0) / 100.0, (x1 - 300.0) / 200.0, (y1 - 150.0) / 100.0];
            assert!(off.iter().all(|share: &f64| share.abs() <= 0.03), "{off:?}");
        }
    }
}
