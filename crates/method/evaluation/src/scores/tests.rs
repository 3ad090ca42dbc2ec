//! Selection of best views by hand, and scores by the small random models of `tests/golden/`.

use super::*;
use crate::perceptual_models::{PerceptualModels, WeightsFile};
use std::sync::atomic::{AtomicUsize, Ordering};
use vision::lpips::LpipsNetwork;

macro_rules! golden {
    ($path:literal) => {
        include_bytes!(concat!("../../../../../tests/golden/", $path)).to_vec()
    };
}

/// Models of the golden files, without those that are left out.
fn models(left_out: &[WeightsFile]) -> PerceptualModels {
    PerceptualModels::read(LpipsNetwork::AlexNet, |file| {
        if left_out.contains(&file) {
            return Err(std::io::ErrorKind::NotFound.into());
        }
        Ok(match file {
            WeightsFile::LpipsBackbone => golden!("lpips/alexnet/backbone.safetensors"),
            WeightsFile::LpipsLinearLayers => golden!("lpips/alexnet/linear_layers.safetensors"),
            WeightsFile::Dinov2Config => golden!("dinov2/mlp/config.json"),
            WeightsFile::Dinov2Model => golden!("dinov2/mlp/model.safetensors"),
            WeightsFile::ClipConfig => golden!("clip/patch14/config.json"),
            WeightsFile::ClipModel => golden!("clip/patch14/model.safetensors"),
        })
    })
    .expect("the golden models")
}

/// An image whose left part of that width is red, the rest gray.
fn barred(width_px: u32) -> Image {
    let mut image = Image::filled(64, 8, [120, 120, 120, 255]);
    for y in 0..8 {
        (0..width_px).for_each(|x| image.set_pixel(x, y, [200, 20, 20, 255]));
    }
    vision::resized(&image, 512, 64)
}

#[test]
fn best_is_lowest_distance_or_highest_cosine_and_first_of_equals() {
    let views: Vec<SweepView> = Sweep::views().take(4).collect();
    let scored: Vec<_> = views.iter().copied().zip([0.5, 0.25, 0.75, 0.25]).collect();
    let of = |metric| MetricScores::of(metric, &scored).expect("has views");
    let lpips = of(Metric::Lpips);
    assert_eq!((lpips.best.view, lpips.best.score), (views[1], 0.25));
    assert_eq!((lpips.mean, lpips.views), (0.4375, vec![0.5, 0.25, 0.75, 0.25]));
    for metric in [Metric::Dinov2, Metric::Clip] {
        assert_eq!((of(metric).best.view, of(metric).best.score), (views[2], 0.75));
    }
    assert_eq!(MetricScores::of(Metric::Lpips, &[]), None);
}

#[test]
fn view_that_equals_reference_is_best_by_every_metric() {
    let models = models(&[]);
    let same = SweepView { elevation_deg: 20, distance_radii: 1.8 };
    let image_of = |view: &SweepView| match *view == same {
        true => barred(20),
        false => barred(view.elevation_deg / 3 + (10.0 * view.distance_radii) as u32 % 10 + 22),
    };
    let scores = score_views(&models, &barred(20), image_of, &CancelFlag::default()).expect("scores");
    for metric in Metric::ALL {
        let found = scores.of(metric).measured().expect("has weights");
        let exact = if metric == Metric::Lpips { 0.0 } else { 1.0 };
        assert_eq!(found.best.view, same, "{metric:?}");
        assert!((found.best.score - exact).abs() < 1e-5, "{metric:?}: {}", found.best.score);
        assert_eq!(found.views.len(), 160);
        let mean = found.views.iter().sum::<f64>() / 160.0;
        assert!((found.mean - mean).abs() < 1e-12 && (found.mean - exact).abs() > 1e-4, "{metric:?}");
    }
}

#[test]
fn missing_weights_give_the_file_and_no_number() {
    let rendered = AtomicUsize::new(0);
    let image_of = |_: &SweepView| {
        rendered.fetch_add(1, Ordering::Relaxed);
        barred(5)
    };
    let all = [WeightsFile::LpipsBackbone, WeightsFile::Dinov2Model, WeightsFile::ClipConfig];
    let cancel = CancelFlag::default();
    let none = score_views(&models(&all), &barred(20), image_of, &cancel).expect("no scores");
    let missing = |file: &str| MetricOutcome::MissingWeights(MissingWeights { file: file.to_owned() });
    assert_eq!(none.lpips, missing("lpips/backbone.safetensors"));
    assert_eq!(none.dinov2, missing("dinov2/model.safetensors"));
    assert_eq!(none.clip, missing("clip/config.json"));
    assert_eq!(rendered.load(Ordering::Relaxed), 0, "nothing is rendered for nothing");
    let some = score_views(&models(&all[..2]), &barred(20), image_of, &cancel).expect("scores");
    assert_eq!(some.lpips, none.lpips);
    assert!(some.clip.measured().is_some());
    assert_eq!(rendered.load(Ordering::Relaxed), 160);
    let json = serde_json::to_value(&none).expect("JSON");
    assert_eq!(json["clip"], serde_json::json!({ "status": "missing_weights", "file": "clip/config.json" }));
}

#[test]
fn cancelled_scoring_and_views_of_another_size_are_errors() {
    let models = models(&[WeightsFile::Dinov2Model, WeightsFile::ClipModel]);
    let cancel = CancelFlag::default();
    let error = score_views(&models, &barred(20), |_| Image::filled(64, 64, [9; 4]), &cancel);
    let text = error.expect_err("sizes differ").to_string();
    assert!(
        text.contains("by LPIPS failed") && text.contains("512 x 64 pixels, the other 64 x 64"),
        "{text}"
    );
    cancel.cancel();
    let error = score_views(&models, &barred(20), |_| barred(3), &cancel);
    assert!(matches!(error, Err(ScoreError::Cancelled(_))));
}
