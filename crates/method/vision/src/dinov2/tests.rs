//! Parity with the reference implementation on the small random models of `tabletopgen_checks.golden.dinov2`, and
//! rejection of unfit files.

use serde_json::Value;

use super::*;
use crate::golden::{Golden, apart, bytes_of, tensor_names};

const MLP_CONFIG: &[u8] = include_bytes!("../../../../../tests/golden/dinov2/mlp/config.json");
const MLP_WEIGHTS: &[u8] = include_bytes!("../../../../../tests/golden/dinov2/mlp/model.safetensors");
const SWIGLU_CONFIG: &[u8] = include_bytes!("../../../../../tests/golden/dinov2/swiglu/config.json");
const SWIGLU_WEIGHTS: &[u8] = include_bytes!("../../../../../tests/golden/dinov2/swiglu/model.safetensors");
const GOLDEN: &[u8] = include_bytes!("../../../../../tests/golden/dinov2/golden.safetensors");

/// Maximum difference from the reference; values of class tokens are about 1.
const TOLERANCE: f32 = 1e-5;

fn golden() -> Golden {
    Golden::open(GOLDEN)
}

fn input(golden: &Golden, key: &str) -> Pixels {
    let name = format!("{key}.input");
    let (_, height_px, width_px) = golden.tensor(&name).dims3().expect("channels, rows, columns");
    let rgb = golden.values(&name).into_iter().map(|byte| byte / 64.0 - 2.0).collect();
    Pixels { rgb, height_px, width_px }
}

fn image(index: usize) -> Image {
    golden().image(&format!("picture.{index}.rgba"))
}

fn mlp() -> Dinov2 {
    Dinov2::read(MLP_CONFIG, MLP_WEIGHTS.to_vec()).expect("the golden model")
}

/// The golden model of this name, and the keys of its inputs.
fn models() -> [(Dinov2, Vec<&'static str>); 2] {
    let swiglu = Dinov2::read(SWIGLU_CONFIG, SWIGLU_WEIGHTS.to_vec()).expect("the golden model");
    [(mlp(), vec!["mlp.70x70", "mlp.56x56", "mlp.42x98"]), (swiglu, vec!["swiglu.56x56", "swiglu.84x42"])]
}

#[test]
fn class_tokens_match_reference() {
    let golden = golden();
    for (model, keys) in models() {
        for key in keys {
            let found =
                model.class_token(&input(&golden, key), &CancelFlag::default()).expect("a class token");
            let difference = apart(&found, &golden.values(&format!("{key}.class_token")));
            eprintln!("{key}: class token {difference:e} apart");
            assert!(difference < TOLERANCE, "{key}: {difference}");
        }
    }
}

#[test]
fn position_embeddings_match_reference() {
    let golden = golden();
    for (model, keys) in models() {
        for key in keys {
            let input = input(&golden, key);
            let found = model.positions(input.height_px / 14, input.width_px / 14);
            let difference = apart(&found, &golden.values(&format!("{key}.positions")));
            eprintln!("{key}: positions {difference:e} apart");
            assert!(difference < TOLERANCE, "{key}: {difference}");
        }
    }
}

#[test]
fn image_resizing_matches_reference() {
    let golden = golden();
    for index in 0..2 {
        let found = input::pixels(&image(index), 28).expect("is opaque somewhere").rgb;
        let difference = apart(&found, &golden.values(&format!("picture.{index}.pixels")));
        eprintln!("picture {index}: {difference:e} apart");
        assert!(difference < TOLERANCE, "picture {index}: {difference}");
    }
}

#[test]
fn every_tensor_affects_class_token() {
    let golden = golden();
    for (config, weights, key) in
        [(MLP_CONFIG, MLP_WEIGHTS, "mlp.42x98"), (SWIGLU_CONFIG, SWIGLU_WEIGHTS, "swiglu.84x42")]
    {
        let (input, expected) = (input(&golden, key), golden.values(&format!("{key}.class_token")));
        let mut without_effect = Vec::new();
        for name in tensor_names(weights) {
            let mut broken = weights.to_vec();
            bytes_of(&mut broken, &name).fill(0);
            let found = Dinov2::read(config, broken).expect("zeros are finite");
            let found = found.class_token(&input, &CancelFlag::default()).expect("a class token");
            if apart(&found, &expected) < 100.0 * TOLERANCE {
                without_effect.push(name);
            }
        }
        // A key's bias adds the same to all scores of a query, so the softmax cancels it.
        without_effect.retain(|name| !name.ends_with("key.bias"));
        assert_eq!(without_effect, ["embeddings.mask_token"]);
    }
}

#[test]
fn features_have_unit_length_and_ignore_transparent_pixels() {
    let model = mlp();
    assert_eq!(model.side_px(), 224);
    let features = |image: &Image| model.features(image, &CancelFlag::default()).expect("features");
    let first = image(0);
    let seen = features(&first);
    assert!((seen.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
    let mut recolored = first.clone();
    for pixel in recolored.as_rgba_mut().chunks_exact_mut(4).filter(|pixel| pixel[3] == 0) {
        pixel[..3].copy_from_slice(&[1, 200, 3]);
    }
    assert_eq!(features(&recolored), seen);
    assert_ne!(features(&image(1)), seen);
    assert!(features(&Image::filled(9, 9, [10, 10, 10, 0])).iter().all(|v| *v == 0.0));
    let cancel = CancelFlag::default();
    cancel.cancel();
    assert!(matches!(model.features(&first, &cancel), Err(Dinov2Error::Cancelled(_))));
}

#[test]
fn resizing_keeps_color_of_uniform_image() {
    let pixels = input::pixels(&Image::filled(60, 20, [255, 0, 0, 255]), 28).expect("is opaque");
    let at = |channel: usize, y: usize, x: usize| pixels.rgb[(channel * 28 + y) * 28 + x];
    assert!((at(0, 14, 14) - (1.0 - 0.485) / 0.229).abs() < 1e-5);
    assert!((at(1, 14, 14) + 0.456 / 0.224).abs() < 1e-5);
    assert!(at(0, 2, 14).abs() < 1e-5, "padding is the mean");
}

#[test]
fn unfit_files_are_rejected_with_key_and_tensor() {
    let refused = |config: &[u8], weights: &[u8]| match Dinov2::read(config, weights.to_vec()) {
        Ok(_) => panic!("is taken"),
        Err(error) => error.to_string(),
    };
    let with = |key: &str, value: Value| {
        let mut config: Value = serde_json::from_slice(MLP_CONFIG).expect("JSON");
        config[key] = value;
        refused(config.to_string().as_bytes(), MLP_WEIGHTS)
    };
    for (key, value, says) in [
        ("model_type", Value::from("dinov2_with_registers"), "only \"dinov2\" is known"),
        ("hidden_act", Value::from("relu"), "only \"gelu\" is known"),
        ("num_attention_heads", Value::from(5), "cannot be shared by num_attention_heads = 5"),
        ("patch_size", Value::from(0), "patch_size is 0, outside 1 to 224"),
        ("mlp_ratio", Value::from(-1.0), "mlp_ratio is -1"),
        ("layer_norm_eps", Value::from(2.0), "layer_norm_eps is 2"),
        ("hidden_size", Value::from("wide"), "config.json describes no DINOv2"),
        ("num_hidden_layers", Value::from(4), "no tensor encoder.layer.3.norm1.weight"),
        ("image_size", Value::from(56), "embeddings.position_embeddings has shape [1, 26, 24]"),
        ("hidden_size", Value::from(28), "but [28, 3, 14, 14] is wanted"),
        ("use_swiglu_ffn", Value::from(true), "no tensor encoder.layer.0.mlp.weights_in.weight"),
    ] {
        let text = with(key, value);
        assert!(text.contains(says), "{key}: {text}");
    }
    assert!(refused(b"{}", MLP_WEIGHTS).contains("missing field `model_type`"));
    assert!(refused(MLP_CONFIG, b"").contains("not a safetensors file"));
    assert!(refused(MLP_CONFIG, &MLP_WEIGHTS[..9000]).contains("not a safetensors file"));

    let mut damaged = MLP_WEIGHTS.to_vec();
    bytes_of(&mut damaged, "layernorm.weight")[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let text = refused(MLP_CONFIG, &damaged);
    assert!(text.contains("tensor layernorm.weight holds values that are not finite"), "{text}");

    let at = MLP_WEIGHTS.windows(7).position(|bytes| bytes == b"\"dtype\"").expect("a header");
    let mut integers = MLP_WEIGHTS.to_vec();
    integers[at + 9] = b'I';
    let text = refused(MLP_CONFIG, &integers);
    assert!(text.contains("embeddings.cls_token holds I32 numbers"), "{text}");
}
