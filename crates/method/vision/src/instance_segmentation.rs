//! Reading an image of a table with the [`table_network`](super::table_network): instance segmentation, camera and
//! shapes.
//!
//! The network predicts twice: for the whole image, which alone determines the camera, then for the crop around
//! the table. Its maps hold per cell the class, the outline of the whole top, center votes of objects, and the
//! camera.
//!
//! The top becomes a rectangle, a circle or its outline as is, and corrects the camera. Cells with a common center
//! vote and no border between them form an object. What does not stand on the table is left out ([`bare_top`]). The
//! mask of an object is regrown to the edges in the image. Each object becomes the best-fitting primitive near the
//! predicted footprint and height.

mod region_score;
mod bare_top;
mod camera_fit;
mod candidates;
mod ellipse;
mod instances;
mod merge_tree;
mod watershed;
mod settings;
mod surfaces;
mod joint_estimate;
mod known_camera;
mod table_top;
mod table_region;
mod unread;

pub use candidates::{CandidateRegion, CandidateRegions, candidate_regions};
pub use known_camera::KnownCamera;
pub use region_score::RegionFeatures;
pub use settings::NetworkReadingSettings;

use glam::DVec2;

use self::bare_top::BareTop;
use self::instances::DetectedObject;
use self::joint_estimate::{JointEstimate, Solid};
use self::known_camera::Measured;
use self::table_top::{TableTop, TopObservation};
use super::VisionError;
use super::mask_repair;
use super::morphology;
use super::pixels::Pixels;
use super::reading::{
    ImageReading, ObjectReading, SupportEstimate, TableReading, TopShape, assign_supports, mean_color,
    whole_image,
};
use super::shape_fit::{self, InnerEdges};
use super::table_network::DensePredictor;
use super::table_network::frame::ImageCrop;
use super::table_network::maps::{Maps, PixelClass};
use imaging::codec::MIN_SCENE_SIDE_PX;
use imaging::{Image, Mask};
use runtime::CancelFlag;

/// Reads an image with the network. Deterministic. Cost: about a second on one core with the default settings.
/// `known` states intrinsics of its camera and depths of its pixels, if there are any.
///
/// # Errors
///
/// A [`VisionError`] names what was not found; [`VisionError::Cancelled`] if `cancel` was set.
pub fn read_with_network(
    image: &Image,
    network: &impl DensePredictor,
    known: &KnownCamera,
    settings: &NetworkReadingSettings,
    cancel: &CancelFlag,
) -> Result<ImageReading, VisionError> {
    let (width_px, height_px) = (image.width_px(), image.height_px());
    if width_px.min(height_px) < MIN_SCENE_SIDE_PX {
        return Err(VisionError::TooSmall { width_px, height_px });
    }
    let [whole, maps] = predict_both(image, network, settings, cancel)?;
    let pixels = Pixels::new(image, settings.work_px);
    cancel.check()?;
    let bare_top = BareTop::of(&maps, &pixels);
    if let Some(bare_top) = &bare_top {
        bare_top.check_single(&maps)?;
    }
    let found = instances::find(&maps, [width_px, height_px], settings, cancel)
        .map(|found| Carried::new(found, bare_top.as_ref(), &maps, &pixels, settings));
    let own = found.as_ref().map_or(&[][..], |found| &found.masks[..]);
    let beyond = beyond_top(bare_top.as_ref(), own, &maps, &pixels);
    let on_top = shows_top(bare_top.as_ref(), &maps, &pixels);
    let measured = Measured::new(known, &on_top, own, &pixels);
    // Of an image without a top, the missing top is the error.
    let top_observation = TopObservation::new(&maps, &pixels, &beyond, &measured.shows_plane, settings)?;
    cancel.check()?;
    let Carried { objects: detected, masks, left_out } = found?;
    if detected.is_empty() {
        return Err(VisionError::NoObjects);
    }
    let expected = known.expected(&whole, measured.plane(), [width_px, height_px], &pixels);
    let edges = InnerEdges::new(&pixels);
    let in_front = occluder_masks(&masks);
    let silhouettes: Vec<Vec<usize>> = masks
        .iter()
        .map(|mask| shape_fit::without_holes(&indices(mask), pixels.width, pixels.height))
        .collect();
    let joint = JointEstimate {
        objects: &detected,
        silhouettes: &silhouettes,
        in_front: &in_front,
        heights: &measured.heights,
        edges: &edges,
        maps: &maps,
        pixels: &pixels,
        cancel,
    };
    let (top, solids) = joint.solve(&top_observation, &expected)?;
    let without_solid = masks.iter().zip(&solids).filter(|(_, solid)| solid.is_none()).map(|(mask, _)| mask);
    let unread = match &bare_top {
        Some(bare_top) => {
            let known = masks.iter().chain(&left_out);
            unread::pixels(bare_top, known, without_solid, &maps, &pixels, settings)
        }
        None => vec![false; pixels.len()],
    };
    let read = masks.iter().zip(&detected).zip(solids).filter_map(|((mask, detection), solid)| {
        let Solid { fit, support } = solid?;
        let object = ObjectReading {
            mask: pixels.upscale_mask(mask.bits(), width_px, height_px),
            solid: fit,
            color: mean_color(&pixels, &indices(mask)),
            stands_on: None,
        };
        Some((object, SupportEstimate { base_px: maps.in_image(detection.base), height: support }))
    });
    let (mut objects, stands): (Vec<ObjectReading>, Vec<SupportEstimate>) = read.unzip();
    if objects.is_empty() {
        return Err(VisionError::NoObjects);
    }
    let camera = whole_image(&top.found.camera, known.center_px(), [width_px, height_px], pixels.scale);
    assign_supports(&mut objects, &camera, Some(&stands));
    let whole_mask = |bits: &[bool]| pixels.upscale_mask(bits, width_px, height_px);
    let left_out = left_out.iter().map(|mask| whole_mask(mask.bits())).collect();
    let table = table(&top, &whole, &pixels);
    let (bare_top, unread) = (whole_mask(&on_top), whole_mask(&unread));
    let depth = measured.depth_use(&top.found.camera);
    Ok(ImageReading { camera, table, objects, left_out, unread, bare_top, depth })
}

/// The objects on the table with their masks in the working copy, and the masks of all others.
struct Carried {
    objects: Vec<DetectedObject>,
    masks: Vec<Mask>,
    left_out: Vec<Mask>,
}

impl Carried {
    fn new(
        found: Vec<DetectedObject>,
        bare_top: Option<&BareTop>,
        maps: &Maps,
        pixels: &Pixels,
        settings: &NetworkReadingSettings,
    ) -> Self {
        // All of them, as masks grow until they meet.
        let masks = masks(&found, maps, pixels, settings);
        let carried = bare_top.map_or(vec![true; found.len()], |top| top.carries(&found, maps));
        let mut all = Self { objects: Vec::new(), masks: Vec::new(), left_out: Vec::new() };
        for ((object, mask), is_carried) in found.into_iter().zip(masks).zip(carried) {
            if is_carried {
                all.objects.push(object);
                all.masks.push(mask);
            } else {
                all.left_out.push(mask);
            }
        }
        all
    }
}

/// Pixels of the copy that show the bare top.
fn shows_top(bare_top: Option<&BareTop>, maps: &Maps, pixels: &Pixels) -> Vec<bool> {
    let Some(bare_top) = bare_top else { return vec![false; pixels.len()] };
    let cells = bare_top.cells(maps);
    (0..pixels.len()).map(|index| cell_at(maps, pixels, index).is_some_and(|cell| cells[cell])).collect()
}

/// Pixels of the copy that show an object or another surface beyond the bare top, and none of the objects on the table
/// (`own`).
fn beyond_top(bare_top: Option<&BareTop>, own: &[Mask], maps: &Maps, pixels: &Pixels) -> Vec<bool> {
    let Some(bare_top) = bare_top else { return vec![false; pixels.len()] };
    let cells = bare_top.beyond(maps);
    let is_beyond = |index: usize| {
        cell_at(maps, pixels, index).is_some_and(|cell| cells[cell])
            && !own.iter().any(|mask| mask.bits()[index])
    };
    (0..pixels.len()).map(is_beyond).collect()
}

/// The map's cell at a pixel of the copy; `None` outside the crop.
fn cell_at(maps: &Maps, pixels: &Pixels, index: usize) -> Option<usize> {
    let (x, y) = pixels.xy(index);
    let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
    maps.shows(p).then(|| {
        let x = (p.x as usize).min(maps.width() - 1);
        (p.y as usize).min(maps.height() - 1) * maps.width() + x
    })
}

/// Maps of the whole image, then of the crop around the table.
fn predict_both(
    image: &Image,
    network: &impl DensePredictor,
    settings: &NetworkReadingSettings,
    cancel: &CancelFlag,
) -> Result<[Maps; 2], VisionError> {
    let image_px = [image.width_px(), image.height_px()];
    let whole = network.maps(image, ImageCrop::whole(image_px), cancel)?;
    let Some((low, high)) = instances::table_box(&whole) else {
        return Err(VisionError::NoTableTop { percent: 100.0 * settings.min_table_share });
    };
    let maps = network.maps(image, ImageCrop::closer(image_px, low, high), cancel)?;
    Ok([whole, maps])
}

/// Masks of the objects in the working copy, regrown to the edges in the image.
fn masks(
    detected: &[DetectedObject],
    maps: &Maps,
    pixels: &Pixels,
    settings: &NetworkReadingSettings,
) -> Vec<Mask> {
    let (width, height) = (pixels.width, pixels.height);
    let rough: Vec<Mask> = instances::pixels_of(detected, maps, pixels)
        .into_iter()
        .map(|own| {
            let mut bits = vec![false; pixels.len()];
            own.into_iter().for_each(|index| bits[index] = true);
            let radius = (settings.mask_rim * maps.pixel_px() * pixels.scale) as f32;
            let inner = morphology::erode(&bits, width, height, radius);
            // Erosion would delete thin objects.
            let kept =
                if inner.iter().filter(|bit| **bit).count() * 3 > bits.iter().filter(|bit| **bit).count() {
                    inner
                } else {
                    bits
                };
            Mask::from_bits(width as u32, height as u32, kept)
        })
        .collect();
    mask_repair::repair(&pixels.copy, &rough)
}

/// For each object the pixels of the later ones, which are nearer to the camera.
fn occluder_masks(masks: &[Mask]) -> Vec<Mask> {
    let Some(first) = masks.first() else { return Vec::new() };
    let mut nearer = Mask::empty(first.width_px(), first.height_px());
    let mut all = Vec::with_capacity(masks.len());
    for mask in masks.iter().rev() {
        all.push(nearer.clone());
        nearer.unite(mask);
    }
    all.reverse();
    all
}

fn indices(mask: &Mask) -> Vec<usize> {
    mask.bits().iter().enumerate().filter(|(_, inside)| **inside).map(|(index, _)| index).collect()
}

fn table(top: &TableTop, maps: &Maps, pixels: &Pixels) -> TableReading {
    let is_bare = |cell: usize| maps.class(cell) == PixelClass::Top;
    let bare: Vec<usize> =
        (0..pixels.len()).filter(|&index| cell_at(maps, pixels, index).is_some_and(is_bare)).collect();
    TableReading {
        shape: top.shape,
        depth: top.found.depth,
        outline: top.outline.clone(),
        outline_px: top.outline_px.iter().map(|p| *p / pixels.scale).collect(),
        color: mean_color(pixels, &bare),
        height: table_height(maps, pixels, top),
        fit: top.fit,
    }
}

/// Height of the top above the floor. The lowest cell of the table's frame is taken as a foot near the front edge.
fn table_height(maps: &Maps, pixels: &Pixels, top: &TableTop) -> Option<f64> {
    let w = maps.width();
    let is_frame = |index: usize| maps.shows_image(index) && maps.class(index) == PixelClass::TableFrame;
    let row = |y: usize| (y * w..(y + 1) * w).filter(|&index| is_frame(index)).count();
    let lowest = (0..maps.height()).rev().find(|&y| row(y) >= 2)?;
    let target_px = pixels.scale * maps.in_image(DVec2::new(0.0, lowest as f64 + 1.0)).y;
    if target_px > 0.985 * pixels.height as f64 {
        return None;
    }
    // Legs stand near the corners; the foot of a pedestal reaches about two thirds of the radius.
    let feet: Vec<DVec2> = match top.shape {
        TopShape::Circle | TopShape::Oval => vec![DVec2::new(0.0, -0.4 * top.found.depth)],
        _ => top.outline.iter().map(|p| 0.9 * *p).collect(),
    };
    let row_at = |height: f64| {
        let rows = feet.iter().filter_map(|foot| top.found.camera.project(foot.extend(-height)));
        rows.map(|(p, _)| p.y).fold(f64::NEG_INFINITY, f64::max)
    };
    let (mut low, mut high) = (0.0, 3.0);
    for _ in 0..40 {
        let center = 0.5 * (low + high);
        if row_at(center) < target_px { low = center } else { high = center }
    }
    (low > 0.1 && low < 2.5).then_some(low)
}
