//! Separation of bodies along the shortest horizontal direction, and back inside the table's outline.
//!
//! Pairs are handled one after the other (Gauss-Seidel): a pair that comes closer than the clearance is moved apart
//! along the direction of minimum translation, half each. Only whole branches of the support tree move, so supported
//! bodies move with their supporter. If the passes do not converge, bodies are laid out again one by one, largest
//! first, each at the free position nearest to its wanted one.

use std::f64::consts::TAU;

use glam::DVec2;

use super::level::{carries_beside, depth_over_parent_m};
use super::tree::TABLE;
use super::{ResolveError, Scene, inside};
use geometry::Pose;
use geometry::drop_cast::{are_closer, slide_distance};
use runtime::CancelFlag;

/// Moves below this do not count, meters.
const SMALL_M: f64 = 2e-6;

/// Separates all bodies; returns whether any moved. Body k keeps `insets_m[k]` more than the margin from the edge.
pub(super) fn push_apart(
    scene: &Scene,
    poses: &mut [Pose],
    clearance_m: f64,
    insets_m: &[f64],
    log: &mut Vec<String>,
    cancel: &CancelFlag,
) -> Result<bool, ResolveError> {
    let before = poses.to_vec();
    let mut settled = false;
    for _ in 0..scene.settings.separation_passes {
        let apart = push_pairs(scene, poses, clearance_m, cancel)?;
        let inside = push_inside(scene, poses, insets_m);
        if apart.max(inside) < SMALL_M {
            settled = true;
            break;
        }
    }
    if !settled {
        poses.copy_from_slice(&before);
        lay_out_again(scene, poses, clearance_m, insets_m, cancel)?;
    }
    let mut moved = false;
    for body in scene.tree.order() {
        let way_m = (poses[body].translation_m - before[body].translation_m).length();
        moved |= way_m > SMALL_M;
        if way_m > 0.001 {
            log.push(format!("{} moved {:.0} mm to stand clear", scene.name(body), 1e3 * way_m));
        }
    }
    Ok(moved)
}

/// Moves a body and everything it carries.
fn shift(scene: &Scene, poses: &mut [Pose], body: usize, by: DVec2) {
    for other in scene.tree.branch(body) {
        poses[other].translation_m += by.extend(0.0);
    }
}

/// Branches whose members must keep apart: not those that share a container.
fn keep_apart(scene: &Scene, a: usize, b: usize) -> Option<(usize, usize)> {
    let (x, y) = scene.tree.branches(a, b)?;
    let contained = [x, y].iter().all(|&k| scene.tree.is_contained(k));
    (!contained).then_some((x, y))
}

/// Whether one of the bodies stands on an object and lies above the other one, or is carried by it too, as in a
/// pyramid: it may touch both.
fn is_carried_too(scene: &Scene, poses: &[Pose], a: usize, b: usize) -> bool {
    const MAX_SINK_M: f64 = 0.001;
    let is_above = |upper: usize, lower: usize| {
        let is_carried = !scene.tree.is_contained(upper) && scene.tree.parent(upper) != TABLE;
        let bottom_m = scene.shapes[upper].bounds(&poses[upper]).0.z;
        is_carried
            && (bottom_m > scene.shapes[lower].bounds(&poses[lower]).1.z - MAX_SINK_M
                || carries_beside(scene, lower, upper, poses))
    };
    is_above(a, b) || is_above(b, a)
}

fn push_pairs(
    scene: &Scene,
    poses: &mut [Pose],
    clearance_m: f64,
    cancel: &CancelFlag,
) -> Result<f64, ResolveError> {
    let mut largest: f64 = 0.0;
    for a in (0..poses.len()).filter(|&k| k != TABLE) {
        cancel.check()?;
        for b in (0..a).filter(|&k| k != TABLE) {
            let Some((x, y)) = keep_apart(scene, a, b) else { continue };
            let (here, there) = (scene.placed(a, poses), scene.placed(b, poses));
            if !are_closer(&here, &there, clearance_m) || is_carried_too(scene, poses, a, b) {
                continue;
            }
            let between = (poses[a].translation_m - poses[b].translation_m).truncate();
            let first = between.try_normalize().unwrap_or(DVec2::X);
            let count = scene.settings.directions.max(1);
            let (direction, way_m) = (0..count)
                .map(|k| first.rotate(DVec2::from_angle(TAU * k as f64 / count as f64)))
                .map(|direction| (direction, slide_distance(&here, &there, direction, clearance_m)))
                // Of equal distances the first counts, along the line between the origins, so that rounding does not
                // choose the direction.
                .fold((first, f64::INFINITY), |best, next| if next.1 < best.1 - 1e-9 { next } else { best });
            if way_m < SMALL_M {
                continue;
            }
            // Slightly more than half, since rounding would otherwise keep the pair too close.
            let half = direction * (0.5 * way_m + SMALL_M);
            shift(scene, poses, x, half);
            shift(scene, poses, y, -half);
            largest = largest.max(way_m);
        }
    }
    Ok(largest)
}

/// Shift that moves a branch inside the outline with the margin: that of the worst member.
fn way_inside(scene: &Scene, poses: &[Pose], body: usize, insets_m: &[f64]) -> DVec2 {
    let outline = scene.problem.outline;
    let of = |member: usize| {
        let margin_m = scene.settings.outline_margin_m + insets_m[member];
        inside::missing(outline, &scene.footprint(member, poses), margin_m)
    };
    let members = scene.tree.branch(body).map(of);
    members.fold((0.0, DVec2::ZERO), |worst, next| if next.0 > worst.0 { next } else { worst }).1
}

fn push_inside(scene: &Scene, poses: &mut [Pose], insets_m: &[f64]) -> f64 {
    let mut largest: f64 = 0.0;
    for body in scene.tree.order() {
        let parent = scene.tree.parent(body);
        if parent == TABLE {
            let way = way_inside(scene, poses, body, insets_m);
            shift(scene, poses, body, way);
            largest = largest.max(way.length());
        } else if !scene.tree.is_contained(body) {
            let missing = 0.001 - depth_over_parent_m(scene, body, parent, poses);
            if missing > 0.0 {
                let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
                let center = 0.5 * (low + high).truncate();
                let way = (center - poses[body].translation_m.truncate()).normalize_or_zero() * missing;
                shift(scene, poses, body, way);
                largest = largest.max(way.length());
            }
        }
    }
    largest
}

/// Greedy layout: branches on the table by size, each at the nearest free position; an error without one.
fn lay_out_again(
    scene: &Scene,
    poses: &mut [Pose],
    clearance_m: f64,
    insets_m: &[f64],
    cancel: &CancelFlag,
) -> Result<(), ResolveError> {
    let area = |body: usize| {
        let (low, high) = scene.shapes[body].bounds(&scene.problem.bodies[body].world_from_object);
        (high - low).truncate().element_product()
    };
    let mut waiting: Vec<usize> =
        (0..poses.len()).filter(|&k| k != TABLE && scene.tree.parent(k) == TABLE).collect();
    waiting.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
    let (low, high) = scene.problem.outline.bounds();
    let rings = ((high - low).length() / 0.008).ceil() as u32;
    let mut standing: Vec<usize> = Vec::new();
    let mut unplaced: Vec<String> = Vec::new();
    for &body in &waiting {
        let members: Vec<usize> = scene.tree.branch(body).collect();
        let start = poses.to_vec();
        let mut found = false;
        // Rings of growing radius: the first free position is the nearest one to within the step of 8 mm.
        'search: for ring in 0..rings {
            cancel.check()?;
            let count = if ring == 0 { 1 } else { 8 + 2 * ring.min(20) };
            for k in 0..count {
                let way =
                    DVec2::from_angle(TAU * f64::from(k) / f64::from(count)) * (0.008 * f64::from(ring));
                poses.copy_from_slice(&start);
                shift(scene, poses, body, way);
                let inside = way_inside(scene, poses, body, insets_m) == DVec2::ZERO;
                if inside
                    && members.iter().all(|&m| {
                        standing.iter().all(|&s| {
                            !are_closer(&scene.placed(m, poses), &scene.placed(s, poses), clearance_m)
                        })
                    })
                {
                    found = true;
                    break 'search;
                }
            }
        }
        if !found {
            poses.copy_from_slice(&start);
            unplaced.push(scene.name(body).to_owned());
        }
        standing.extend(members);
    }
    if unplaced.is_empty() { Ok(()) } else { Err(ResolveError::NoSpace { names: unplaced }) }
}
