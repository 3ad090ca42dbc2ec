//! A picture of a table, read: camera, top, things.

use glam::DVec2;
use rayon::prelude::*;

use super::outline::{self, Hypothesis, Seen};
use super::pixels::Pixels;
use super::solid_fit::{self, InnerEdges, SolidFit, SolidKind, Surroundings};
use super::surface::{self, Candidate};
use super::{VisionError, VisionSettings, backdrop, camera_fit, instances};
use geometry::{Camera, Pose, Rgb};
use imaging::{Image, Mask};
use runtime::{Interrupt, Interrupted};

/// What a picture shows; lengths in widths of the table top, frame as everywhere (origin at the middle of
/// the top, +z up, +x to the right and +y away from somebody at the front edge).
#[derive(Clone, Debug)]
pub struct PictureReading {
    /// Of the whole picture.
    pub camera: Camera,
    pub table: TableReading,
    /// Farthest first.
    pub objects: Vec<ObjectReading>,
}

/// Outline a table top was read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopShape {
    Rectangle,
    Circle,
    Oval,
    /// Three corners, rounded.
    Triangle,
    /// Anything else, and what is left of a top that the picture cuts off.
    Irregular,
}

/// The table top.
#[derive(Clone, Debug)]
pub struct TableReading {
    pub shape: TopShape,
    /// Depth in widths; 1 for a circle.
    pub depth: f64,
    /// Edge of the top, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// The same in pixels of the picture, in the order of growing angle.
    pub outline_px: Vec<DVec2>,
    /// Mean color of the bare top.
    pub color: Rgb,
    /// Height above the floor in widths, where the feet show.
    pub height: Option<f64>,
    /// Overlap of the bare top's hull with the shape, 0..1.
    pub fit: f64,
}

/// One thing on the table.
#[derive(Clone, Debug)]
pub struct ObjectReading {
    /// Pixels where it shows, as large as the picture.
    pub mask: Mask,
    /// The solid it is read as; where it stands on another thing, as if it stood on the table along the
    /// same rays.
    pub solid: SolidFit,
    /// Mean color.
    pub color: Rgb,
    /// What it stands on, an index of [`PictureReading::objects`]; `None` = the table.
    pub stands_on: Option<usize>,
}

/// Reads a picture; see the module for how, and [`VisionError`] for why not. Deterministic. Cost: about
/// 0.3 s on one core at the usual settings.
pub fn read_picture(
    picture: &Image,
    settings: &VisionSettings,
    interrupt: &Interrupt,
) -> Result<PictureReading, VisionError> {
    let (width_px, height_px) = (picture.width_px(), picture.height_px());
    if width_px.min(height_px) < 160 {
        return Err(VisionError::TooSmall { width_px, height_px });
    }
    let pixels = Pixels::new(picture, settings.work_px);
    interrupt.check()?;
    let foreground = backdrop::foreground(&pixels, settings)?;
    interrupt.check()?;
    let Top { candidate, hypothesis, found } = table_top(&pixels, &foreground, settings, interrupt)?;
    let polygon = hypothesis.seen.polygon();
    let surface = &candidate.surface;
    let things = instances::find(&pixels, &foreground, surface, &polygon, settings)?;
    let edges = InnerEdges::new(&pixels);
    let read = things
        .par_iter()
        .map(|thing| {
            interrupt.check()?;
            let whole = solid_fit::without_holes(thing, pixels.width, pixels.height);
            let Some(solid) =
                solid_fit::fit(&whole, &found.camera, Some(&edges), None, &Surroundings::default())
                    .map(|(fit, _)| fit)
            else {
                return Ok(None);
            };
            let mut bits = vec![false; pixels.len()];
            thing.iter().for_each(|&index| bits[index] = true);
            Ok(Some(ObjectReading {
                mask: pixels.enlarged(&bits, width_px, height_px),
                solid,
                color: mean_color(&pixels, thing),
                stands_on: None,
            }))
        })
        .collect::<Result<Vec<_>, Interrupted>>()?;
    let mut objects: Vec<ObjectReading> = read.into_iter().flatten().collect();
    if objects.is_empty() {
        return Err(VisionError::NoObjects);
    }
    let height = table_height(&pixels, &foreground, &found, &hypothesis.seen);
    let camera = whole_picture(&found.camera, width_px, height_px, pixels.scale);
    stacking(&mut objects, &camera, None);
    Ok(PictureReading {
        camera,
        table: TableReading {
            shape: match hypothesis.seen {
                Seen::Quad(_) => TopShape::Rectangle,
                Seen::Ellipse(_) => TopShape::Circle,
            },
            depth: found.depth,
            outline: outline(&hypothesis.seen, found.depth),
            outline_px: polygon.iter().map(|p| *p / pixels.scale).collect(),
            color: mean_color(&pixels, &candidate.bare),
            height,
            fit: hypothesis.fit,
        },
        objects,
    })
}

/// Edge of the top on the table.
fn outline(seen: &Seen, depth: f64) -> Vec<DVec2> {
    match seen {
        Seen::Quad(_) => [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(x, y)| DVec2::new(x, y * depth))
            .to_vec(),
        Seen::Ellipse(_) => {
            (0..96).map(|k| 0.5 * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 96.0)).collect()
        }
    }
}

impl PictureReading {
    /// By how much a thing is nearer to the camera, and hence smaller, than if it stood on the table: 1 for what does.
    pub fn nearer(&self, index: usize) -> f64 {
        let (mut at, mut height) = (self.objects[index].stands_on, 0.0);
        for _ in 0..self.objects.len() {
            let Some(k) = at else { break };
            height += self.objects[k].solid.size.z;
            at = self.objects[k].stands_on;
        }
        let eye = self.camera.world_from_camera.translation_m.z;
        ((eye - height) / eye).clamp(0.2, 1.0)
    }

    /// The same reading with all lengths multiplied, as by the width of the top in meters.
    pub fn scaled(mut self, factor: f64) -> Self {
        let pose = &mut self.camera.world_from_camera;
        *pose = Pose { translation_m: factor * pose.translation_m, rotation: pose.rotation };
        self.table.height = self.table.height.map(|h| factor * h);
        self.table.outline.iter_mut().for_each(|p| *p *= factor);
        self.objects.iter_mut().for_each(|object| object.solid = object.solid.scaled(factor));
        self
    }
}

/// A way to read the picture's top.
struct Top {
    candidate: Candidate,
    hypothesis: Hypothesis,
    found: camera_fit::Found,
}

/// Radii by which bare parts are opened before their outline is read, as shares of the copy's width: legs and
/// aprons of the top's color hang on by less than the top is wide.
const OPENINGS: [f64; 3] = [0.0, 0.03, 0.06];

/// The reading whose outline is cleanest and largest, among those that some camera sees.
fn table_top(
    pixels: &Pixels,
    foreground: &[bool],
    settings: &VisionSettings,
    interrupt: &Interrupt,
) -> Result<Top, VisionError> {
    let percent = 100.0 * settings.min_table_share;
    let smallest = settings.min_table_share * pixels.len() as f64;
    let limit_px = settings.max_outline_residual * pixels.width.max(pixels.height) as f64;
    let mut refusal = VisionError::NoTop { percent };
    let mut best: Option<(f64, Top)> = None;
    for candidate in surface::candidates(pixels, foreground, settings, interrupt)? {
        for share in OPENINGS {
            interrupt.check()?;
            let Some(candidate) = candidate.opened(pixels, (share * pixels.width as f64) as f32) else {
                continue;
            };
            let Some(hypothesis) = outline::read(pixels, &candidate, settings) else { continue };
            if hypothesis.area < smallest || covered(pixels, foreground, &hypothesis.seen) < LEAST_COVERED {
                continue;
            }
            if hypothesis.fit < settings.min_outline_fit {
                refusal = VisionError::OutlineUnclear { percent: 100.0 * hypothesis.fit };
                continue;
            }
            let seen = &hypothesis.seen;
            let Some(found) = camera_fit::fit(seen, pixels.width, pixels.height, settings.fov_x_rad)
                .filter(|found| found.residual_px <= limit_px)
            else {
                refusal = VisionError::CameraUnclear { residual_px: limit_px };
                continue;
            };
            let doubt = (found.residual_px / limit_px).powi(2);
            let value = hypothesis.clean * hypothesis.fit * hypothesis.area / (1.0 + doubt);
            if best.as_ref().is_none_or(|(most, _)| value > *most) {
                best = Some((value, Top { candidate, hypothesis, found }));
            }
        }
    }
    best.map(|(_, top)| top).ok_or(refusal)
}

/// Least share of a top that is not backdrop; gray things on it may look like shadows on the backdrop.
const LEAST_COVERED: f64 = 0.85;

/// Share of the outline's inside that is not backdrop.
fn covered(pixels: &Pixels, foreground: &[bool], seen: &Seen) -> f64 {
    let polygon = seen.polygon();
    let (mut inside, mut covered) = (0_usize, 0_usize);
    for (index, in_front) in foreground.iter().enumerate() {
        let (x, y) = pixels.place(index);
        if super::polygon::contains(&polygon, DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) {
            inside += 1;
            covered += usize::from(*in_front);
        }
    }
    covered as f64 / inside.max(1) as f64
}

/// The camera of the reduced copy, for the picture itself.
pub(crate) fn whole_picture(camera: &Camera, width_px: u32, height_px: u32, scale: f64) -> Camera {
    Camera {
        width_px,
        height_px,
        fx: camera.fx / scale,
        fy: camera.fy / scale,
        cx: 0.5 * f64::from(width_px),
        cy: 0.5 * f64::from(height_px),
        world_from_camera: camera.world_from_camera,
    }
}

/// Height of the top above the floor: the lowest foreground pixel is taken for a foot near the front edge.
fn table_height(pixels: &Pixels, foreground: &[bool], found: &camera_fit::Found, seen: &Seen) -> Option<f64> {
    let w = pixels.width;
    let row = |y: usize| foreground[y * w..(y + 1) * w].iter().filter(|&&f| f).count();
    let lowest = (0..pixels.height).rev().find(|&y| row(y) >= 3)?;
    if lowest + 3 >= pixels.height {
        return None;
    }
    let feet: Vec<DVec2> = match seen {
        Seen::Quad(_) => [-1.0, 1.0].map(|s| DVec2::new(0.45 * s, -0.45 * found.depth)).to_vec(),
        // A pedestal's foot reaches about two thirds out; legs a little farther.
        Seen::Ellipse(_) => vec![DVec2::new(0.0, -0.4)],
    };
    let row_at = |height: f64| {
        let rows = feet.iter().filter_map(|f| found.camera.project(f.extend(-height)));
        rows.map(|(p, _)| p.y).fold(f64::NEG_INFINITY, f64::max)
    };
    let target = lowest as f64 + 1.0;
    let (mut low, mut high) = (0.0, 3.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if row_at(middle) < target { low = middle } else { high = middle }
    }
    (low > 0.1 && low < 2.5).then_some(low)
}

/// What is said of where a thing stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stand {
    /// Middle of its footprint in the picture.
    pub base_px: DVec2,
    /// Height above the table of what carries it; 0 = the table.
    pub height: f64,
}

/// Share of a carrier's height at which a thing must be said to stand to stand on it or in it, and the largest.
const STANDS_AT: [f64; 2] = [0.35, 2.5];

/// Who stands on whom: a thing whose contact lies on the top face of another's solid. Where it is said how high things
/// stand (one [`Stand`] an object) they must stand at about that face's height, and the middle of the footprint may lie
/// there instead.
pub(crate) fn stacking(objects: &mut [ObjectReading], camera: &Camera, stands: Option<&[Stand]>) {
    let contacts: Vec<Option<DVec2>> = objects
        .iter()
        .map(|object| {
            let [x0, _, x1, y1] = object.mask.bbox_px()?;
            let lowest = (x0..x1).filter(|&x| object.mask.contains(x, y1 - 1)).collect::<Vec<_>>();
            let middle = *lowest.get(lowest.len() / 2)?;
            Some(DVec2::new(f64::from(middle) + 0.5, f64::from(y1)))
        })
        .collect();
    let tops: Vec<Vec<DVec2>> = objects.iter().map(|object| top_face(&object.solid, camera)).collect();
    let supports: Vec<Option<usize>> = (0..objects.len())
        .map(|i| {
            let carries = |j: usize, p: DVec2| {
                tops[j].len() > 2
                    && super::polygon::contains(&tops[j], p)
                    && objects[j].mask.area_px() > objects[i].mask.area_px() / 3
            };
            let others = (0..objects.len()).filter(|&j| j != i);
            let Some(stand) = stands.map(|stands| stands[i]) else {
                let contact = contacts[i]?;
                return others.into_iter().find(|&j| carries(j, contact));
            };
            let share = |j: usize| stand.height / objects[j].solid.size.z.max(1e-9);
            let [least, most] = STANDS_AT;
            others
                .filter(|&j| {
                    carries(j, stand.base_px) || contacts[i].is_some_and(|contact| carries(j, contact))
                })
                .filter(|&j| (least..=most).contains(&share(j)))
                .min_by(|&a, &b| share(a).ln().abs().total_cmp(&share(b).ln().abs()))
        })
        .collect();
    for (object, support) in objects.iter_mut().zip(supports) {
        object.stands_on = support;
    }
    // Two things cannot carry each other: the smaller one lies on top.
    for i in 0..objects.len() {
        if let Some(j) = objects[i].stands_on
            && objects[j].stands_on.is_some()
            && objects[j].mask.area_px() >= objects[i].mask.area_px()
        {
            objects[j].stands_on = None;
        }
    }
    for i in 0..objects.len() {
        let mut at = i;
        for _ in 0..objects.len() {
            match objects[at].stands_on {
                Some(next) => at = next,
                None => break,
            }
        }
        if objects[at].stands_on.is_some() {
            objects[i].stands_on = None;
        }
    }
}

/// Outline of a solid's top face in the picture; empty where nothing could stand on it.
fn top_face(solid: &SolidFit, camera: &Camera) -> Vec<DVec2> {
    if matches!(solid.kind, SolidKind::Upright { .. } | SolidKind::Inflated { .. }) {
        return Vec::new();
    }
    let corners = solid.footprint();
    let corners = corners.iter().map(|p| camera.project(p.extend(solid.size.z)).map(|(pixel, _)| pixel));
    let corners: Option<Vec<DVec2>> = corners.collect();
    super::polygon::convex_hull(&corners.unwrap_or_default())
}

/// Mean in linear light, as sRGB.
pub(crate) fn mean_color(pixels: &Pixels, indices: &[usize]) -> Rgb {
    let mut sum = [0.0_f64; 3];
    for &index in indices {
        (0..3).for_each(|c| sum[c] += f64::from(pixels.log_light[index][c].exp()));
    }
    Rgb(sum.map(|s| {
        let light = (s / indices.len().max(1) as f64) as f32;
        if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
    }))
}

/// The picture with the outline that was found drawn on it, for looking at refusals.
#[cfg(test)]
pub(crate) fn outlined(picture: &Image, settings: &VisionSettings) -> Image {
    let mut image = picture.clone();
    let pixels = Pixels::new(picture, settings.work_px);
    let Ok(foreground) = backdrop::foreground(&pixels, settings) else { return image };
    let stop = Interrupt::default();
    let all = surface::candidates(&pixels, &foreground, settings, &stop).unwrap_or_default();
    let opened = all.iter().flat_map(|candidate| {
        OPENINGS.iter().filter_map(|share| candidate.opened(&pixels, (share * pixels.width as f64) as f32))
    });
    for candidate in opened {
        let mut bare = vec![false; pixels.len()];
        candidate.bare.iter().for_each(|&k| bare[k] = true);
        let mask = pixels.enlarged(&bare, picture.width_px(), picture.height_px());
        render::overlay::tint_mask(&mut image, &mask, [0, 255, 255, 255], 0.3);
        if let Some(found) = outline::read(&pixels, &candidate, settings) {
            let polygon: Vec<DVec2> = found.seen.polygon().iter().map(|p| *p / pixels.scale).collect();
            render::overlay::draw_polyline(&mut image, &polygon, true, [255, 0, 0, 255], 2.0);
            let text = format!("fit {:.3} clean {:.3}", found.fit, found.clean);
            let at = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
            render::overlay::draw_text(&mut image, at.x as i64, at.y as i64, &text, 2, [255, 0, 0, 255]);
        }
    }
    image
}
