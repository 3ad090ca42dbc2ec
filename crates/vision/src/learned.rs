//! Reading a picture with the [`network`](super::network): any table, any backdrop.
//!
//! The network looks twice: at the whole picture, which alone tells the camera, then closer at the part with the top and
//! what stands on it. It says of every place what is in front there, where the whole top's edge runs, where objects have
//! their middles, and how the camera stands. The top becomes a rectangle, a circle or the outline as it is, and corrects
//! the camera; places that vote for the same middle become a thing as far as no border runs between them, its mask
//! regrown to the edges in the picture; each thing becomes the simplest solid with its outline that stands about where
//! the network sees it stand and is about as high.

mod belief;
mod camera_fit;
mod candidates;
mod ellipse;
mod instances;
mod merge_tree;
mod partition;
mod settings;
mod standing;
mod top;
mod top_area;

pub use belief::Measures;
pub use candidates::{CandidateRegion, CandidateRegions, candidate_regions};
pub use settings::NetworkReadingSettings;

use glam::DVec2;

use self::instances::Thing;
use self::standing::{Solid, Standing};
use self::top::{SeenTop, Top};
use super::VisionError;
use super::mask_repair;
use super::network::Looks;
use super::network::frame::Look;
use super::network::maps::{Kind, Maps};
use super::pixels::Pixels;
use super::reading::{
    ObjectReading, PictureReading, Stand, TableReading, TopShape, mean_color, stacking, whole_picture,
};
use super::regions;
use super::solid_fit::{self, InnerEdges};
use imaging::{Image, Mask};
use runtime::Interrupt;

/// Reads a picture with the network; see the module for how, and [`VisionError`] for why not. Deterministic. Cost: about
/// a second on one core at the usual settings.
pub fn read_with_network(
    picture: &Image,
    network: &impl Looks,
    settings: &NetworkReadingSettings,
    interrupt: &Interrupt,
) -> Result<PictureReading, VisionError> {
    let (width_px, height_px) = (picture.width_px(), picture.height_px());
    if width_px.min(height_px) < 160 {
        return Err(VisionError::TooSmall { width_px, height_px });
    }
    let [whole, maps] = looks(picture, network, settings, interrupt)?;
    let pixels = Pixels::new(picture, settings.work_px);
    interrupt.check()?;
    let seen_top = SeenTop::new(&maps, &pixels, settings)?;
    interrupt.check()?;
    let things = instances::find(&maps, [width_px, height_px], settings, interrupt)?;
    let masks = masks(&things, &maps, &pixels, settings);
    let edges = InnerEdges::new(&pixels);
    let in_front = nearer_ones(&masks);
    let silhouettes: Vec<Vec<usize>> = masks
        .iter()
        .map(|mask| solid_fit::without_holes(&indices(mask), pixels.width, pixels.height))
        .collect();
    let standing = Standing {
        things: &things,
        silhouettes: &silhouettes,
        in_front: &in_front,
        edges: &edges,
        maps: &maps,
        pixels: &pixels,
        interrupt,
    };
    let (top, solids) = standing.best(&seen_top, whole.camera())?;
    let read = masks.iter().zip(&things).zip(solids).filter_map(|((mask, thing), solid)| {
        let Solid { fit, support } = solid?;
        let object = ObjectReading {
            mask: pixels.enlarged(mask.bits(), width_px, height_px),
            solid: fit,
            color: mean_color(&pixels, &indices(mask)),
            stands_on: None,
        };
        Some((object, Stand { base_px: maps.in_picture(thing.base), height: support }))
    });
    let (mut objects, stands): (Vec<ObjectReading>, Vec<Stand>) = read.unzip();
    if objects.is_empty() {
        return Err(VisionError::NoObjects);
    }
    let camera = whole_picture(&top.found.camera, width_px, height_px, pixels.scale);
    stacking(&mut objects, &camera, Some(&stands));
    Ok(PictureReading { camera, table: table(&top, &whole, &pixels), objects })
}

/// Maps of the whole picture, then of its part with the top.
fn looks(
    picture: &Image,
    network: &impl Looks,
    settings: &NetworkReadingSettings,
    interrupt: &Interrupt,
) -> Result<[Maps; 2], VisionError> {
    let picture_px = [picture.width_px(), picture.height_px()];
    let whole = network.maps(picture, Look::whole(picture_px), interrupt)?;
    let Some((low, high)) = instances::shown_box(&whole) else {
        return Err(VisionError::NoTopSeen { percent: 100.0 * settings.min_table_share });
    };
    let maps = network.maps(picture, Look::closer(picture_px, low, high), interrupt)?;
    Ok([whole, maps])
}

/// Pixels of each thing in the copy, regrown to the edges it shows.
fn masks(things: &[Thing], maps: &Maps, pixels: &Pixels, settings: &NetworkReadingSettings) -> Vec<Mask> {
    let (width, height) = (pixels.width, pixels.height);
    let rough: Vec<Mask> = instances::pixels_of(things, maps, pixels)
        .into_iter()
        .map(|own| {
            let mut bits = vec![false; pixels.len()];
            own.into_iter().for_each(|index| bits[index] = true);
            let radius = (settings.mask_rim * maps.pixel_px() * pixels.scale) as f32;
            let inner = regions::shrunk(&bits, width, height, radius);
            // What is thin would vanish.
            let kept =
                if inner.iter().filter(|bit| **bit).count() * 3 > bits.iter().filter(|bit| **bit).count() {
                    inner
                } else {
                    bits
                };
            Mask::from_bits(width as u32, height as u32, kept)
        })
        .collect();
    mask_repair::repaired(&pixels.copy, &rough)
}

/// For each thing the pixels of those that come after it, which stand nearer to the camera.
fn nearer_ones(masks: &[Mask]) -> Vec<Mask> {
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

fn table(top: &Top, maps: &Maps, pixels: &Pixels) -> TableReading {
    let kind_at = |index: usize| {
        let (x, y) = pixels.place(index);
        let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
        let x = (p.x as usize).min(maps.width() - 1);
        maps.kind((p.y as usize).min(maps.height() - 1) * maps.width() + x)
    };
    let bare: Vec<usize> = (0..pixels.len()).filter(|&index| kind_at(index) == Kind::Top).collect();
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

/// Height of the top above the floor: the lowest place of the frame is taken for a foot near the front edge.
fn table_height(maps: &Maps, pixels: &Pixels, top: &Top) -> Option<f64> {
    let w = maps.width();
    let is_frame = |index: usize| maps.shows_picture(index) && maps.kind(index) == Kind::TableFrame;
    let row = |y: usize| (y * w..(y + 1) * w).filter(|&index| is_frame(index)).count();
    let lowest = (0..maps.height()).rev().find(|&y| row(y) >= 2)?;
    let target_px = pixels.scale * maps.in_picture(DVec2::new(0.0, lowest as f64 + 1.0)).y;
    if target_px > 0.985 * pixels.height as f64 {
        return None;
    }
    // Legs stand near the corners; a pedestal's foot reaches about two thirds out.
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
        let middle = 0.5 * (low + high);
        if row_at(middle) < target_px { low = middle } else { high = middle }
    }
    (low > 0.1 && low < 2.5).then_some(low)
}
