//! Parity with the reference implementation on the small random network of
//! `tabletopgen_checks.golden.object_recognizer`, and rejection of unfit files.

use candle_core::DType;
use candle_core::safetensors::BufferedSafetensors;

use super::*;

const WEIGHTS: &[u8] = include_bytes!("../../../../../tests/golden/object_recognizer/weights.safetensors");
const GOLDEN: &[u8] = include_bytes!("../../../../../tests/golden/object_recognizer/golden.safetensors");

/// Maximum difference of probabilities from the reference.
const TOLERANCE: f64 = 1e-4;

fn golden(name: &str) -> Tensor {
    let file = BufferedSafetensors::new(GOLDEN.to_vec()).expect("golden.safetensors");
    file.load(name, &Device::Cpu).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn values(name: &str) -> Vec<f32> {
    golden(name).to_dtype(DType::F32).expect("numbers").flatten_all().expect("flat").to_vec1().expect("f32")
}

/// The image of the golden file and its mask.
fn image_and_mask(number: usize) -> (Image, Mask) {
    let colors = golden(&format!("{number}.colors"));
    let (height, width, _) = colors.dims3().expect("rows, columns, channels");
    let (colors, inside) = (values(&format!("{number}.colors")), values(&format!("{number}.mask")));
    let mut image = Image::filled(width as u32, height as u32, [0, 0, 0, 255]);
    for (index, color) in colors.chunks_exact(3).enumerate() {
        let [r, g, b] = [0, 1, 2].map(|k| color[k] as u8);
        image.set_pixel((index % width) as u32, (index / width) as u32, [r, g, b, 255]);
    }
    let bits = inside.iter().map(|value| *value > 0.5).collect();
    (image, Mask::from_bits(width as u32, height as u32, bits))
}

#[test]
fn probabilities_match_reference() {
    let recognizer = ObjectRecognizer::read(WEIGHTS.to_vec()).expect("the golden network");
    for number in 0..3 {
        let (image, mask) = image_and_mask(number);
        let square = square_crop(&image, &mask, recognizer.input_px).expect("not empty");
        let expected = values(&format!("{number}.square"));
        let apart = square.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // One level of 255: both round after resizing.
        assert!(apart < 0.02, "square {number}: {apart}");
        let found = recognizer.probabilities(&expected).expect("probabilities");
        let expected = values(&format!("{number}.probabilities"));
        assert_eq!(found.len(), expected.len());
        let apart = found.iter().zip(&expected).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        assert!(apart < TOLERANCE, "image {number}: {apart:e}");
        assert!(expected.iter().any(|p| *p > 0.3) && expected.iter().any(|p| *p < 0.2), "{expected:?}");
    }
}

#[test]
fn guesses_are_sorted_and_leave_unknown_out() {
    let recognizer = ObjectRecognizer::read(WEIGHTS.to_vec()).expect("the golden network");
    let (image, mask) = image_and_mask(0);
    let empty = Mask::empty(mask.width_px(), mask.height_px());
    let found = recognizer.recognize(&image, &[&mask, &empty], &CancelFlag::default()).expect("guesses");
    let names: Vec<&str> = found[0].iter().map(|guess| guess.category.name.as_str()).collect();
    assert!(
        !names.is_empty() && names.iter().all(|name| ["mug", "banana", "laptop"].contains(name)),
        "{names:?}"
    );
    assert!(found[0].windows(2).all(|pair| pair[0].probability >= pair[1].probability));
    let sum: f64 = found[0].iter().map(|guess| guess.probability).sum();
    assert!(sum < 1.0 - MIN_PROBABILITY, "nothing is left for unknown: {sum}");
    assert!(found[1].is_empty());
    let stopped = CancelFlag::default();
    stopped.cancel();
    assert!(matches!(recognizer.recognize(&image, &[&mask], &stopped), Err(NetworkError::Cancelled(_))));
}

#[test]
fn unfit_files_are_rejected_with_tensor() {
    let refused = |bytes: Vec<u8>| ObjectRecognizer::read(bytes).err().expect("refused").to_string();
    assert!(refused(b"no tensors".to_vec()).contains("safetensors"));
    let mut bytes = WEIGHTS.to_vec();
    let at = WEIGHTS.windows(13).position(|w| w == b"\"classes.bias").expect("the name");
    bytes[at + 9] = b'B';
    assert!(refused(bytes).contains("no tensor classes.bias"));
}
