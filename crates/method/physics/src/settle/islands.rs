//! Simulation islands: bodies that cannot meet are simulated apart and in parallel.
//!
//! Movable bodies whose boxes, widened by a margin, overlap form an island. Every island is simulated with the fixed
//! bodies and without the others, which is exact while every body stays in its widened box. If a body leaves its box,
//! islands are formed again with a wider margin, and at last all bodies are simulated together. Unchanged islands are
//! not simulated twice. The split depends on the input alone, so any number of threads gives the same bytes.

use glam::DVec3;
use rayon::prelude::*;

use super::world::{Run, run};
use super::{SettleError, SettleSettings, SettledPoses, angle_between_rad};
use crate::Body;
use runtime::CancelFlag;

/// Margins of the boxes, meters, tried in turn; the last puts all bodies into one island. A settling body
/// moves by less than the first one as a rule, a leaning or toppling one by the second.
pub(super) const MARGINS_M: [f64; 3] = [0.005, 0.03, f64::INFINITY];

/// An island with its outcome.
struct Known {
    members: Vec<usize>,
    run: Run,
}

pub(super) fn simulate(
    bodies: &[Body],
    settings: &SettleSettings,
    may_end_early: bool,
    margins_m: &[f64],
    cancel: &CancelFlag,
) -> Result<SettledPoses, SettleError> {
    let fixed: Vec<usize> = (0..bodies.len()).filter(|&k| bodies[k].fixed).collect();
    let boxes: Vec<(DVec3, DVec3)> = bodies.iter().map(world_box).collect();
    let mut known: Vec<Known> = Vec::new();
    for &margin_m in margins_m {
        let islands = islands(bodies, &boxes, margin_m);
        let (kept, new): (Vec<_>, Vec<_>) =
            islands.into_iter().partition(|members| known.iter().any(|k| k.members == *members));
        known.retain(|k| kept.contains(&k.members));
        let runs: Vec<Known> = new
            .into_par_iter()
            .map(|members| {
                let with_fixed: Vec<&Body> = fixed.iter().chain(&members).map(|&k| &bodies[k]).collect();
                let run = run(&with_fixed, settings, may_end_early, cancel)?;
                Ok(Known { members, run })
            })
            .collect::<Result<_, SettleError>>()?;
        known.extend(runs);
        if known.iter().all(|k| k.run.excursion_m <= margin_m) {
            break;
        }
    }
    let mut poses: Vec<_> = bodies.iter().map(|b| b.world_from_object).collect();
    let mut track: Vec<_> = poses.iter().map(|pose| vec![*pose]).collect();
    let (mut at_rest, mut simulated_s) = (true, 0.0_f64);
    for island in known {
        for (&k, pose) in island.members.iter().zip(&island.run.poses[fixed.len()..]) {
            poses[k] = *pose;
        }
        for (&k, poses) in island.members.iter().zip(island.run.track.into_iter().skip(fixed.len())) {
            track[k] = poses;
        }
        at_rest &= island.run.at_rest;
        simulated_s = simulated_s.max(island.run.simulated_s);
    }
    let from = |k: usize| &bodies[k].world_from_object;
    Ok(SettledPoses {
        displacements_m: (0..bodies.len())
            .map(|k| (poses[k].translation_m - from(k).translation_m).length())
            .collect(),
        rotations_rad: (0..bodies.len()).map(|k| angle_between_rad(&poses[k], from(k))).collect(),
        poses,
        at_rest,
        simulated_s,
        track,
    })
}

fn world_box(body: &Body) -> (DVec3, DVec3) {
    body.hulls
        .iter()
        .flat_map(|h| &h.points)
        .map(|&p| body.world_from_object.transform_point(p))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Groups of movable bodies, each in ascending order.
fn islands(bodies: &[Body], boxes: &[(DVec3, DVec3)], margin_m: f64) -> Vec<Vec<usize>> {
    let mut islands: Vec<Vec<usize>> = Vec::new();
    for body in (0..bodies.len()).filter(|&k| !bodies[k].fixed) {
        let meets = |other: &usize| {
            let apart = (boxes[body].0 - boxes[*other].1).max(boxes[*other].0 - boxes[body].1);
            // Both boxes are widened by the margin.
            margin_m.is_infinite() || apart.max_element() <= 2.0 * margin_m
        };
        let (touched, mut rest): (Vec<_>, Vec<_>) =
            islands.into_iter().partition(|island| island.iter().any(meets));
        let mut joined: Vec<usize> = touched.into_iter().flatten().collect();
        joined.push(body);
        joined.sort_unstable();
        rest.push(joined);
        islands = rest;
    }
    islands
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bodies::{body, settle_settings, table};
    use geometry::Pose;
    use geometry::shapes::block;

    fn cube(name: &str, x: f64, z: f64) -> Body {
        body(name, block(DVec3::splat(0.05)), Pose::upright(DVec3::new(x, 0.0, z), 0.0))
    }

    #[test]
    fn islands_join_neighbors_only() {
        let bodies = [table(), cube("a", 0.0, 0.0), cube("b", 0.2, 0.0), cube("c", 0.055, 0.0)];
        let boxes: Vec<_> = bodies.iter().map(world_box).collect();
        assert_eq!(islands(&bodies, &boxes, 0.005), [vec![2], vec![1, 3]]);
        assert_eq!(islands(&bodies, &boxes, 0.2), [vec![1, 2, 3]]);
    }

    #[test]
    fn islands_merge_on_falling_body() {
        // Stands on its lower left edge and falls over onto the other cube.
        let mut falling = cube("falling", 0.0, 0.0);
        falling.world_from_object.rotation = glam::DQuat::from_rotation_y(0.9);
        falling.world_from_object.translation_m.z = 0.03;
        let bodies = [table(), falling, cube("near", 0.085, 0.0), cube("far", 0.5, 0.0)];
        let settled =
            simulate(&bodies, &settle_settings(), true, &MARGINS_M, &CancelFlag::default()).expect("a fall");
        let gap = settled.poses[2].translation_m.x - settled.poses[1].translation_m.x;
        assert!(settled.displacements_m[1] > 0.01 && gap > 0.03, "{settled:?}");
        assert!(settled.displacements_m[3] < 1e-4);
    }

    #[test]
    fn settle_bytes_do_not_depend_on_thread_count() {
        let bodies = [table(), cube("a", 0.0, 0.004), cube("b", 0.2, 0.01), cube("c", -0.3, 0.02)];
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| simulate(&bodies, &settle_settings(), false, &MARGINS_M, &CancelFlag::default()))
        };
        assert_eq!(with(1).expect("cubes"), with(3).expect("cubes"));
    }
}
