//! Parity with the reference implementation on the small random network of `tabletopgen_checks.golden.table_network`,
//! and rejection of unfit files.

use candle_core::DType;
use candle_core::safetensors::BufferedSafetensors;

use super::*;

const ENCODER: &[u8] = include_bytes!("../../../../../tests/golden/table_network/encoder.safetensors");
const WEIGHTS: &[u8] = include_bytes!("../../../../../tests/golden/table_network/weights.safetensors");
const GOLDEN: &[u8] = include_bytes!("../../../../../tests/golden/table_network/golden.safetensors");

/// Maximum difference from the reference; values of maps are about 10.
const TOLERANCE: f32 = 1e-4;

fn network_of(weights: Vec<u8>) -> Result<TableNetwork, NetworkWeightsError> {
    let encoder = ImageEncoder::read(&NetworkWeights::read(ENCODER.to_vec()).expect("encoder.safetensors"));
    TableNetwork::read(weights, Arc::new(encoder.expect("the golden encoder")))
}

fn golden(name: &str) -> Tensor {
    let file = BufferedSafetensors::new(GOLDEN.to_vec()).expect("golden.safetensors");
    file.load(name, &Device::Cpu).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn values(name: &str) -> Vec<f32> {
    golden(name).to_dtype(DType::F32).expect("numbers").flatten_all().expect("flat").to_vec1().expect("f32")
}

fn answer(network: &TableNetwork, key: &str) -> RawMaps {
    let (_, height, width) = golden(&format!("{key}.input")).dims3().expect("channels, rows, columns");
    let rgb: Vec<f32> = values(&format!("{key}.input")).into_iter().map(|byte| byte / 127.5 - 1.0).collect();
    network.answer(&rgb, width, height, &CancelFlag::default()).expect("an answer")
}

fn apart(found: &[f32], golden: &[f32]) -> f32 {
    assert_eq!(found.len(), golden.len());
    found.iter().zip(golden).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn maps_match_reference() {
    let network = network_of(WEIGHTS.to_vec()).expect("the golden network");
    assert_eq!(network.granularity_px(), 8);
    for key in ["32x48", "64x24"] {
        let found = answer(&network, key);
        let maps = apart(&found.maps, &values(&format!("{key}.maps")));
        eprintln!("{key}: maps {maps:e} apart");
        assert!(maps < TOLERANCE, "{key}: {maps}");
        assert_eq!(found.maps.len(), MAP_CHANNELS * found.width * found.height);
    }
}

#[test]
fn mirrored_image_yields_mirrored_maps() {
    let network = network_of(WEIGHTS.to_vec()).expect("the golden network");
    // The random weights of the golden network are asymmetric; an image of the frame's size is not resampled.
    const LIKE: f64 = 1e-6;
    let mut image = Image::filled(320, 256, [200, 190, 180, 255]);
    (60..160)
        .for_each(|x| (30..120 + x / 4).for_each(|y| image.set_pixel(x, y, [x as u8, y as u8, 90, 255])));
    let mut turned = image.clone();
    (0..320).for_each(|x| (0..256).for_each(|y| turned.set_pixel(319 - x, y, image.pixel(x, y))));
    let read = |image: &Image| {
        network.maps(image, ImageCrop::whole([320, 256]), &CancelFlag::default()).expect("maps")
    };
    let (maps, other) = (read(&image), read(&turned));
    let (width, mut off_the_center) = (maps.width(), 0);
    for index in 0..maps.count() {
        let opposite = index - index % width + width - 1 - index % width;
        let across = |p: glam::DVec2| glam::DVec2::new(width as f64 - p.x, p.y);
        assert!((maps.outline(index) - other.outline(opposite)).abs() < LIKE);
        assert!((maps.voted_center(index) - across(other.voted_center(opposite))).length() < LIKE);
        assert!((maps.base(index) - across(other.base(opposite))).length() < LIKE);
        assert!((maps.top_row(index) - other.top_row(opposite)).abs() < LIKE);
        off_the_center += usize::from((maps.voted_center(index).x - maps.pixel_center(index).x).abs() > 1e-3);
    }
    assert!(off_the_center > maps.count() / 2, "{off_the_center}");
}

/// The file with one value of a tensor changed to `value`.
fn changed(tensor: &str, value: f32) -> Vec<u8> {
    let mut bytes = WEIGHTS.to_vec();
    let header = u64::from_le_bytes(bytes[..8].try_into().expect("eight")) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[8..8 + header]).expect("a header");
    let from = json[tensor]["data_offsets"][0].as_u64().expect("an offset") as usize;
    bytes[8 + header + from..][..4].copy_from_slice(&value.to_le_bytes());
    bytes
}

#[test]
fn every_tensor_affects_maps() {
    let header = u64::from_le_bytes(WEIGHTS[..8].try_into().expect("eight")) as usize;
    let json: serde_json::Value = serde_json::from_slice(&WEIGHTS[8..8 + header]).expect("a header");
    let names: Vec<String> =
        json.as_object().expect("names").keys().filter(|n| *n != "__metadata__").cloned().collect();
    assert!(names.len() > 20, "{names:?}");
    let expected = answer(&network_of(WEIGHTS.to_vec()).expect("the golden network"), "32x48");
    for name in names.into_iter().filter(|name| name != "known.blocks") {
        let found = answer(&network_of(changed(&name, 30.0)).expect("finite"), "32x48");
        let difference = apart(&found.maps, &expected.maps);
        assert!(difference > 10.0 * TOLERANCE, "{name} has no effect");
    }
}

#[test]
fn unfit_files_are_rejected_with_tensor() {
    let refused = |bytes: Vec<u8>| network_of(bytes).err().expect("refused").to_string();
    assert!(refused(b"no tensors".to_vec()).contains("safetensors"));
    let damaged = refused(changed("up.0.widen.weight", f32::NAN));
    assert!(damaged.contains("up.0.widen.weight") && damaged.contains("not finite"), "{damaged}");
    let mut bytes = WEIGHTS.to_vec();
    let at = WEIGHTS.windows(13).position(|w| w == b"\"spread.bias\"").expect("the name");
    bytes[at + 8] = b'B';
    assert!(refused(bytes).contains("no tensor spread.bias"));
    let foreign = refused(changed("known.blocks", 9.0));
    assert!(foreign.contains("known.blocks") && foreign.contains("ascending order"), "{foreign}");
}
