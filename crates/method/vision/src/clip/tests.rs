//! Parity with the reference implementation on the small random models of `tests/judges/perceptual/reference.py`, and
//! rejection of unfit files.

use std::path::PathBuf;
use std::time::Instant;

use serde_json::Value;

use super::*;
use crate::golden::{Golden, apart, bytes_of, tensor_names};
use crate::resized;

const GOLDEN: &[u8] = include_bytes!("../../../../../tests/golden/clip/golden.safetensors");
/// A tower alone, with the activation of OpenAI's weights.
const PATCH14: [&[u8]; 2] = [
    include_bytes!("../../../../../tests/golden/clip/patch14/config.json"),
    include_bytes!("../../../../../tests/golden/clip/patch14/model.safetensors"),
];
/// A file of both towers.
const GELU: [&[u8]; 2] = [
    include_bytes!("../../../../../tests/golden/clip/gelu/config.json"),
    include_bytes!("../../../../../tests/golden/clip/gelu/model.safetensors"),
];
const MODELS: [(&str, [&[u8]; 2]); 2] = [("patch14", PATCH14), ("gelu", GELU)];

/// Maximum difference from the reference; values of embeddings are about 1.
const TOLERANCE: f32 = 1e-4;

fn tower([config, weights]: [&[u8]; 2]) -> ClipImageTower {
    ClipImageTower::read(config, weights.to_vec()).expect("the golden model")
}

fn embedding(tower: &ClipImageTower, image: &Image) -> Vec<f32> {
    let pixels = super::input::pixels(image, tower.architecture.image_size);
    tower.embedding(&pixels, &CancelFlag::default()).expect("an embedding")
}

/// Differences from the reference are printed, for documents.
fn compare(golden: &Golden, name: &str, tower: &ClipImageTower, images: usize) {
    for index in 0..images {
        let image = golden.image(&format!("image.{index}.rgb"));
        let pixels = super::input::pixels(&image, tower.architecture.image_size).rgb;
        let of_pixels = apart(&pixels, &golden.values(&format!("{name}.image.{index}.pixels")));
        let started = Instant::now();
        let found = embedding(tower, &image);
        let seconds = started.elapsed().as_secs_f64();
        let difference = apart(&found, &golden.values(&format!("{name}.image.{index}.embedding")));
        eprintln!(
            "{name}, image {index}: pixels {of_pixels:e}, embedding {difference:e} apart, {seconds:.3} s"
        );
        assert!(of_pixels < 1e-5, "{name}, image {index}: pixels {of_pixels} apart");
        assert!(difference < TOLERANCE, "{name}, image {index}: {difference}");
    }
}

#[test]
fn embeddings_match_reference() {
    let golden = Golden::open(GOLDEN);
    for (name, files) in MODELS {
        compare(&golden, name, &tower(files), 3);
    }
}

#[test]
#[ignore = "needs the model of full size that the script writes"]
fn embeddings_of_full_size_match_reference() {
    let folder = std::env::var_os("TABLETOPGEN_PERCEPTUAL_REFERENCE").map(PathBuf::from);
    let folder = folder.expect("TABLETOPGEN_PERCEPTUAL_REFERENCE names the folder").join("clip");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let tower = ClipImageTower::read(&read("base/config.json"), read("base/model.safetensors"));
    compare(&Golden::open(&read("golden.safetensors")), "base", &tower.expect("the full model"), 1);
}

#[test]
fn resizing_matches_pillow() {
    let golden = Golden::open(GOLDEN);
    for index in 0..3 {
        let expected = golden.image(&format!("resized.{index}"));
        let image = golden.image(&format!("image.{index}.rgb"));
        assert_eq!(resized(&image, expected.width_px(), expected.height_px()), expected, "image {index}");
    }
}

#[test]
fn every_tensor_of_tower_affects_embedding() {
    let image = Golden::open(GOLDEN).image("image.0.rgb");
    for (name, [config, weights]) in MODELS {
        let expected = embedding(&tower([config, weights]), &image);
        let mut without_effect = Vec::new();
        for tensor in tensor_names(weights) {
            let mut broken = weights.to_vec();
            bytes_of(&mut broken, &tensor).fill(0);
            let broken = ClipImageTower::read(config, broken).expect("zeros are finite");
            if apart(&embedding(&broken, &image), &expected) < 10.0 * TOLERANCE {
                without_effect.push(tensor);
            }
        }
        // A key's bias adds the same to all scores of a query, so the softmax cancels it. The text tower is ignored.
        let is_other = |tensor: &str| tensor.starts_with("text_") || tensor == "logit_scale";
        without_effect.retain(|tensor| !tensor.ends_with("k_proj.bias") && !is_other(tensor));
        assert!(without_effect.is_empty(), "{name}: {without_effect:?}");
    }
}

#[test]
fn features_have_unit_length_and_ignore_alpha() {
    let tower = tower(PATCH14);
    let image = Golden::open(GOLDEN).image("image.0.rgb");
    let features = tower.features(&image, &CancelFlag::default()).expect("features");
    assert_eq!(features.len(), 10);
    assert!((features.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
    let mut transparent = image.clone();
    transparent.as_rgba_mut().chunks_exact_mut(4).for_each(|pixel| pixel[3] = 0);
    assert_eq!(tower.features(&transparent, &CancelFlag::default()).expect("features"), features);
    let cancel = CancelFlag::default();
    cancel.cancel();
    assert!(matches!(tower.features(&image, &cancel), Err(NetworkError::Cancelled(_))));
}

#[test]
fn unfit_files_are_rejected_with_key_and_tensor() {
    let refused = |config: &[u8], weights: &[u8]| {
        ClipImageTower::read(config, weights.to_vec()).err().expect("is refused").to_string()
    };
    let [config, weights] = PATCH14;
    for (key, value, says) in [
        (
            "model_type",
            Value::from("siglip_vision_model"),
            "only \"clip\" and \"clip_vision_model\" are known",
        ),
        ("hidden_act", Value::from("relu"), "unknown variant `relu`"),
        ("num_attention_heads", Value::from(5), "cannot be shared by num_attention_heads = 5"),
        ("patch_size", Value::from(0), "patch_size is 0, outside 1 to 42"),
        ("patch_size", Value::from(16), "image_size = 42 is no multiple of patch_size = 16"),
        ("layer_norm_eps", Value::from(2.0), "layer_norm_eps is 2"),
        ("num_hidden_layers", Value::from(4), "no tensor vision_model.encoder.layers.3.layer_norm1.weight"),
        ("image_size", Value::from(56), "position_embedding.weight has shape [10, 24]"),
        ("projection_dim", Value::from(11), "visual_projection.weight has shape [10, 24]"),
        ("hidden_size", Value::from(28), "but [28, 3, 14, 14] is wanted"),
    ] {
        let mut changed: Value = serde_json::from_slice(config).expect("JSON");
        changed[key] = value;
        let text = refused(changed.to_string().as_bytes(), weights);
        assert!(text.contains(says), "{key}: {text}");
    }
    assert!(refused(br#"{"model_type": "clip"}"#, weights).contains("describes no image tower"));
    assert!(refused(br#"{"model_type": "clip_vision_model"}"#, weights).contains("missing field"));
    assert!(refused(config, b"").contains("not a safetensors file"));
}
