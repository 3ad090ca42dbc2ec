//! Parity with the reference implementation on the narrow random models of `tests/judges/perceptual/reference.py`, and
//! rejection of unfit files.

use std::path::PathBuf;
use std::time::Instant;

use super::*;
use crate::golden::{Golden, apart, bytes_of, tensor_names};

const GOLDEN: &[u8] = include_bytes!("../../../../../tests/golden/lpips/golden.safetensors");
const ALEXNET: [&[u8]; 2] = [
    include_bytes!("../../../../../tests/golden/lpips/alexnet/backbone.safetensors"),
    include_bytes!("../../../../../tests/golden/lpips/alexnet/linear_layers.safetensors"),
];
const VGG16: [&[u8]; 2] = [
    include_bytes!("../../../../../tests/golden/lpips/vgg16/backbone.safetensors"),
    include_bytes!("../../../../../tests/golden/lpips/vgg16/linear_layers.safetensors"),
];
const NETWORKS: [(LpipsNetwork, [&[u8]; 2]); 2] =
    [(LpipsNetwork::AlexNet, ALEXNET), (LpipsNetwork::Vgg16, VGG16)];

/// Maximum difference from the reference; distances are 0.2 to 0.8.
const TOLERANCE: f32 = 1e-5;

fn model(network: LpipsNetwork, [backbone, linear]: [&[u8]; 2]) -> Lpips {
    Lpips::read(network, backbone.to_vec(), linear.to_vec()).expect("the golden model")
}

fn distance(model: &Lpips, a: &Image, b: &Image) -> f64 {
    let features = |image: &Image| model.features(image, &CancelFlag::default()).expect("features");
    model.distance(&features(a), &features(b)).expect("a distance")
}

fn pair(golden: &Golden, index: usize) -> [Image; 2] {
    ["a", "b"].map(|side| golden.image(&format!("pair.{index}.{side}")))
}

/// Differences from the reference are printed, for documents.
fn compare(golden: &Golden, model: &Lpips) {
    let network = model.network().name();
    for index in 0..2 {
        let [a, b] = pair(golden, index);
        let started = Instant::now();
        let found = distance(model, &a, &b) as f32;
        let seconds = started.elapsed().as_secs_f64();
        let difference = apart(&[found], &golden.values(&format!("{network}.pair.{index}.distance")));
        eprintln!("{network}, pair {index}: {found} is {difference:e} apart, {seconds:.3} s for two images");
        assert!(difference < TOLERANCE, "{network}, pair {index}: {found}, {difference} apart");
    }
}

#[test]
fn distances_match_reference() {
    let golden = Golden::open(GOLDEN);
    for (network, files) in NETWORKS {
        compare(&golden, &model(network, files));
    }
}

#[test]
#[ignore = "needs the models of full size that the script writes"]
fn distances_of_full_size_match_reference() {
    let folder = std::env::var_os("TABLETOPGEN_PERCEPTUAL_REFERENCE").map(PathBuf::from);
    let folder = folder.expect("TABLETOPGEN_PERCEPTUAL_REFERENCE names the folder").join("lpips");
    let read = |path: PathBuf| std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let golden = Golden::open(&read(folder.join("golden.safetensors")));
    for (network, _) in NETWORKS {
        let own = folder.join(network.name());
        let [backbone, linear] =
            ["backbone", "linear_layers"].map(|file| read(own.join(format!("{file}.safetensors"))));
        compare(&golden, &Lpips::read(network, backbone, linear).expect("the full model"));
    }
}

#[test]
fn distance_is_zero_for_equal_images_and_symmetric() {
    let [a, b] = pair(&Golden::open(GOLDEN), 0);
    for (network, files) in NETWORKS {
        let model = model(network, files);
        assert_eq!(distance(&model, &a, &a), 0.0);
        assert_eq!(distance(&model, &a, &b), distance(&model, &b, &a));
        let mut transparent = a.clone();
        transparent.as_rgba_mut().chunks_exact_mut(4).for_each(|pixel| pixel[3] = 7);
        assert_eq!(distance(&model, &a, &transparent), 0.0, "alpha is ignored");
    }
}

#[test]
fn every_tensor_affects_distance() {
    let golden = Golden::open(GOLDEN);
    let pairs = [pair(&golden, 0), pair(&golden, 1)];
    for (network, files) in NETWORKS {
        let distances =
            |model: &Lpips| [0, 1].map(|k: usize| distance(model, &pairs[k][0], &pairs[k][1]) as f32);
        let expected = distances(&model(network, files));
        let mut without_effect = Vec::new();
        for file in 0..2 {
            for name in tensor_names(files[file]) {
                let mut broken = files.map(<[u8]>::to_vec);
                bytes_of(&mut broken[file], &name).fill(0);
                let [backbone, linear] = broken;
                let broken = Lpips::read(network, backbone, linear).expect("zeros are finite");
                if apart(&distances(&broken), &expected) < 10.0 * TOLERANCE {
                    without_effect.push(name);
                }
            }
        }
        assert!(without_effect.is_empty(), "{}: {without_effect:?}", network.name());
    }
}

#[test]
fn images_that_cannot_be_compared_are_refused() {
    let alexnet = model(LpipsNetwork::AlexNet, ALEXNET);
    let features = |side_px: u32| {
        let image = Image::filled(side_px, 40, [90, 20, 30, 255]);
        alexnet.features(&image, &CancelFlag::default())
    };
    let (small, wide) = (features(32).expect("features"), features(50).expect("features"));
    let error = alexnet.distance(&small, &wide).expect_err("sizes differ").to_string();
    assert!(error.contains("one has 32 x 40 pixels, the other 50 x 40"), "{error}");
    let error = features(31).err().expect("too small").to_string();
    assert!(error.contains("31 x 40 pixels are too few"), "{error}");
    let error = model(LpipsNetwork::Vgg16, VGG16).distance(&small, &small);
    assert!(matches!(error, Err(LpipsError::NetworksDiffer)));
    let cancel = CancelFlag::default();
    cancel.cancel();
    let image = Image::filled(40, 40, [9, 9, 9, 255]);
    assert!(matches!(alexnet.features(&image, &cancel), Err(LpipsError::Cancelled(_))));
}

#[test]
fn unfit_files_are_rejected_with_file_and_tensor() {
    let refused = |network: LpipsNetwork, backbone: &[u8], linear: &[u8]| {
        Lpips::read(network, backbone.to_vec(), linear.to_vec()).err().expect("is refused").to_string()
    };
    let [backbone, linear] = ALEXNET;
    let text = refused(LpipsNetwork::Vgg16, backbone, linear);
    assert!(text.contains("state dict of torchvision's vgg16: tensor features.0.weight has shape"), "{text}");
    assert!(text.contains("(any number, 3, 3, 3) is wanted"), "{text}");
    let text = refused(LpipsNetwork::AlexNet, backbone, VGG16[1]);
    assert!(
        text.contains("LPIPS 0.1 for the backbone alexnet: tensor lin0.model.1.weight has shape"),
        "{text}"
    );
    let text = refused(LpipsNetwork::AlexNet, linear, backbone);
    assert!(text.contains("there is no tensor features.0.weight"), "{text}");
    let text = refused(LpipsNetwork::AlexNet, backbone, b"");
    assert!(text.contains("not a safetensors file"), "{text}");
    let mut damaged = backbone.to_vec();
    bytes_of(&mut damaged, "features.8.bias")[..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let text = refused(LpipsNetwork::AlexNet, &damaged, linear);
    assert!(text.contains("tensor features.8.bias holds values that are not finite"), "{text}");
}
