//! Which pixels are things on the table: neither bare top nor its shadow nor backdrop nor the table's own
//! rim and legs, split into connected parts.
//!
//! Things rise above the top, so they are looked for inside its outline and above it, never below its
//! lower edge, where rim and legs are. A thing outside the outline must hang together with the top's
//! region. Known limits: things of the top's color are eaten as bare top, things that touch in the picture are
//! one thing, dark things may be taken for shadows.

use glam::DVec2;

use super::pixels::Pixels;
use super::polygon::contains;
use super::regions::{closed, filled, grown, opened, parts};
use super::surface::Surface;
use super::{VisionError, VisionSettings};
use imaging::distance_transform::distance_transform;

/// Width of the rim's highlight and of blur along the outline, pixels of the copy.
const EDGE_BAND_PX: f32 = 3.0;

/// Pixels of each thing, farthest (highest lowest pixel) first.
pub(crate) fn find(
    pixels: &Pixels,
    foreground: &[bool],
    surface: &Surface,
    outline: &[DVec2],
    settings: &VisionSettings,
) -> Result<Vec<Vec<usize>>, VisionError> {
    let (w, h) = (pixels.width, pixels.height);
    let center = |index: usize| {
        let (x, y) = pixels.place(index);
        DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
    };
    let top: Vec<bool> = (0..pixels.len()).map(|index| contains(outline, center(index))).collect();
    let lowest = lowest_rows(&top, w, h);
    // Backdrop inside the outline (a corner read too far out) is no thing; white things are holes in it.
    let in_front = filled(foreground, w, h, usize::MAX);
    let differs: Vec<bool> = (0..pixels.len())
        .map(|index| {
            let (x, y) = pixels.place(index);
            if top[index] {
                in_front[index]
                    && surface.distance(pixels, index) > settings.surface_sigmas
                    && !surface.is_shadow(pixels, index, settings)
            } else {
                foreground[index] && (y as f64) < lowest[x]
            }
        })
        .collect();
    // The band along the outline holds rim highlights and blur: it joins only what reaches it.
    let edge: Vec<bool> = (0..pixels.len())
        .map(|index| {
            let (x, y) = pixels.place(index);
            let other = |u: usize, v: usize| top[v * w + u] != top[index];
            (x > 0 && other(x - 1, y))
                || (x + 1 < w && other(x + 1, y))
                || (y > 0 && other(x, y - 1))
                || (y + 1 < h && other(x, y + 1))
        })
        .collect();
    let from_edge = distance_transform(&edge, w, h);
    let core: Vec<bool> = (0..pixels.len()).map(|k| differs[k] && from_edge[k] > EDGE_BAND_PX).collect();
    let core = opened(&core, w, h, 1.0);
    let near_core = grown(&core, w, h, EDGE_BAND_PX + 1.5);
    let all: Vec<bool> = (0..pixels.len()).map(|k| differs[k] && (core[k] || near_core[k])).collect();
    let cleaned = opened(&closed(&all, w, h, 1.5), w, h, 1.0);
    let hole = (0.004 * pixels.len() as f64) as usize;
    let cleaned = filled(&cleaned, w, h, hole);

    let smallest = (settings.min_object_share * pixels.len() as f64).max(12.0) as usize;
    let top_area = top.iter().filter(|&&t| t).count().max(1);
    let mut things: Vec<Vec<usize>> = Vec::new();
    for part in parts(&cleaned, w, h) {
        let within = part.iter().filter(|&&index| top[index] || from_edge[index] <= 2.0).count();
        // What hangs in the room behind the table is not on it.
        if part.len() < smallest || within * 25 < part.len() {
            continue;
        }
        let share = within as f64 / top_area as f64;
        if share > settings.max_object_share {
            return Err(VisionError::ObjectsNotSeparated { percent: 100.0 * share });
        }
        things.push(part);
    }
    if things.is_empty() {
        return Err(VisionError::NoObjects);
    }
    if things.len() > settings.max_objects as usize {
        return Err(VisionError::TooManyObjects { count: things.len() });
    }
    let bottom = |part: &Vec<usize>| part.iter().map(|index| index / w).max().unwrap_or(0);
    things.sort_by_key(|part| (bottom(part), part[0]));
    Ok(things)
}

/// Per column the row below which only rim, legs and floor can be; columns beside the top take that of
/// its outermost corner.
fn lowest_rows(top: &[bool], w: usize, h: usize) -> Vec<f64> {
    let rows: Vec<Option<usize>> = (0..w).map(|x| (0..h).rev().find(|&y| top[y * w + x])).collect();
    let first = rows.iter().position(Option::is_some).unwrap_or(0);
    let last = rows.iter().rposition(Option::is_some).unwrap_or(0);
    (0..w).map(|x| rows[x.clamp(first, last)].map_or(0.0, |y| y as f64 + 0.5)).collect()
}
