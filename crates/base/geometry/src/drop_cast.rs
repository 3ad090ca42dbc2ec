//! Vertical drop: casts the convex hulls of an object straight down onto the hulls below, and related clearance
//! queries.
//!
//! Every pair of convex parts whose boxes overlap in the xy plane is cast along -z with parry's linear shape cast (a
//! GJK ray cast on the Minkowski difference). A spoon thus comes to rest *in* the cup and an apple in the bowl. World
//! frame, meters. Results err by at most [`TOLERANCE_M`] upward. Cost: a few microseconds per pair that overlaps in
//! xy.

use glam::{DQuat, DVec2, DVec3};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::{ShapeCastOptions, cast_shapes, distance};

use super::collision_shape::{CollisionShape, Part, to_parry};
use super::{ConvexHull, Pose};

/// Largest error of [`drop_height`], meters.
pub const TOLERANCE_M: f64 = 1e-6;

/// A collision shape in its pose.
#[derive(Clone, Copy)]
pub struct PosedShape<'a> {
    pub shape: &'a CollisionShape,
    pub world_from_object: Pose,
}

/// Height of the object's origin at first contact with a supporter. The object has orientation `rotation` and moves
/// straight down at `xy_m`, starting above all supporters. `None` without contact.
pub fn drop_height(
    object: &CollisionShape,
    rotation: DQuat,
    xy_m: DVec2,
    supporters: &[PosedShape],
) -> Option<f64> {
    let at_zero = Pose { translation_m: xy_m.extend(0.0), rotation };
    let boxes = object.part_boxes(&at_zero);
    let supporter_boxes: Vec<_> =
        supporters.iter().map(|s| s.shape.part_boxes(&s.world_from_object)).collect();
    let lowest = boxes.iter().map(|b| b.0.z).fold(f64::INFINITY, f64::min);
    let top = supporter_boxes.iter().flatten().map(|b| b.1.z).fold(f64::NEG_INFINITY, f64::max);
    if !lowest.is_finite() || !top.is_finite() {
        return None;
    }
    // Clear of all supporters: a cast that begins in contact hits at once.
    let start_z = top - lowest + 0.01;
    let mut best_z = f64::NEG_INFINITY;
    for (supporter, under) in supporters.iter().zip(&supporter_boxes) {
        let pose = to_parry(&supporter.world_from_object);
        for (part, low_high) in object.parts().iter().zip(&boxes) {
            for (below, (low, high)) in supporter.shape.parts().iter().zip(under) {
                let apart = low_high.0.x > high.x
                    || low.x > low_high.1.x
                    || low_high.0.y > high.y
                    || low.y > low_high.1.y;
                // Even their boxes would touch below the highest contact so far.
                if apart || high.z - low_high.0.z <= best_z {
                    continue;
                }
                let start = Pose { translation_m: xy_m.extend(start_z), rotation };
                let options = ShapeCastOptions {
                    // A hit below the highest one so far, or below this part, has no effect.
                    max_time_of_impact: start_z - best_z.max(low.z - low_high.1.z - 0.01),
                    ..ShapeCastOptions::default()
                };
                let hit = cast_shapes(
                    &to_parry(&start),
                    -DVec3::Z,
                    part.polyhedron.as_ref(),
                    &pose,
                    DVec3::ZERO,
                    below.polyhedron.as_ref(),
                    options,
                );
                if let Ok(Some(hit)) = hit {
                    best_z = best_z.max(start_z - hit.time_of_impact);
                }
            }
        }
    }
    best_z.is_finite().then_some(best_z)
}

/// Height of the object's origin in the lowest position straight below `above` with a clearance of `gap_m` to all
/// supporters. The object's lowest point is between `bottom_m` and `top_m`, and not above its current height: in a
/// basket with a handle, the position is under the handle. Searched in forty steps.
pub fn slid_in_height(
    object: &CollisionShape,
    above: &Pose,
    (bottom_m, top_m): (f64, f64),
    supporters: &[PosedShape],
    gap_m: f64,
) -> Option<f64> {
    const STEPS: u32 = 40;
    /// A part of the object above a part of a supporter that it may meet, with their boxes.
    struct Pair<'a> {
        part: &'a Part,
        own: (DVec3, DVec3),
        other: &'a Part,
        other_pose: ParryPose,
        box_of_other: (DVec3, DVec3),
    }
    let boxes = object.part_boxes(above);
    let low_m = boxes.iter().map(|(low, _)| low.z).fold(f64::INFINITY, f64::min);
    let mut pairs: Vec<Pair> = Vec::new();
    for supporter in supporters {
        let other_pose = to_parry(&supporter.world_from_object);
        let others = supporter.shape.part_boxes(&supporter.world_from_object);
        for (other, box_of_other) in supporter.shape.parts().iter().zip(others) {
            pairs.extend(object.parts().iter().zip(&boxes).filter_map(|(part, &own)| {
                let gap = (own.0 - box_of_other.1).max(box_of_other.0 - own.1).truncate().max_element();
                (gap < gap_m).then_some(Pair { part, own, other, other_pose, box_of_other })
            }));
        }
    }
    // The pair that blocked the last step most likely blocks the next one.
    let mut in_the_way = 0;
    (0..STEPS).find_map(|step| {
        let lowest_m = bottom_m + (top_m - bottom_m) * f64::from(step) / f64::from(STEPS);
        let up_m = (lowest_m - low_m).min(0.0);
        let mut pose = *above;
        pose.translation_m.z += up_m;
        let own_pose = to_parry(&pose);
        let is_close = |pair: &Pair| {
            let ((low, high), (other_low, other_high)) = (pair.own, pair.box_of_other);
            (low.z + up_m - other_high.z).max(other_low.z - high.z - up_m) < gap_m
                && distance(
                    &own_pose,
                    pair.part.polyhedron.as_ref(),
                    &pair.other_pose,
                    pair.other.polyhedron.as_ref(),
                )
                .is_ok_and(|found| found.distance < gap_m)
        };
        if pairs.get(in_the_way).is_some_and(is_close) {
            return None;
        }
        match pairs.iter().position(is_close) {
            Some(pair) => {
                in_the_way = pair;
                None
            }
            None => Some(pose.translation_m.z),
        }
    })
}

/// Shortest displacement along the horizontal unit vector `direction` after which `object` keeps `clearance_m` from
/// `other`, as if it had been slid in from far away along the opposite direction. 0 if it is clear already. The result
/// is never inside a cavity.
pub fn slide_distance(object: &PosedShape, other: &PosedShape, direction: DVec2, clearance_m: f64) -> f64 {
    let along = direction.extend(0.0);
    let boxes = object.shape.part_boxes(&object.world_from_object);
    let other_boxes = other.shape.part_boxes(&other.world_from_object);
    let pose = to_parry(&other.world_from_object);
    let across = direction.perp();
    let span = |b: &(DVec3, DVec3), axis: DVec2| {
        let center = 0.5 * (b.0 + b.1).truncate().dot(axis);
        let half = 0.5 * (b.1 - b.0).truncate().dot(axis.abs());
        (center - half, center + half)
    };
    let mut far = 0.0_f64;
    for (part, low_high) in object.shape.parts().iter().zip(&boxes) {
        let (own_start, _) = span(low_high, direction);
        let own_across = span(low_high, across);
        for (obstacle, other_box) in other.shape.parts().iter().zip(&other_boxes) {
            let (_, other_end) = span(other_box, direction);
            let other_across = span(other_box, across);
            let needed = other_end - own_start + clearance_m;
            let passes = low_high.0.z > other_box.1.z + clearance_m
                || other_box.0.z > low_high.1.z + clearance_m
                || own_across.0 > other_across.1 + clearance_m
                || other_across.0 > own_across.1 + clearance_m;
            if passes || needed <= far {
                continue;
            }
            // Clear of the obstacle: a cast that begins in contact hits at once.
            let start_m = needed + 0.01;
            let start = Pose {
                translation_m: object.world_from_object.translation_m + start_m * along,
                rotation: object.world_from_object.rotation,
            };
            let options = ShapeCastOptions {
                max_time_of_impact: start_m - far,
                target_distance: clearance_m,
                ..ShapeCastOptions::default()
            };
            let hit = cast_shapes(
                &to_parry(&start),
                -along,
                part.polyhedron.as_ref(),
                &pose,
                DVec3::ZERO,
                obstacle.polyhedron.as_ref(),
                options,
            );
            if let Ok(Some(hit)) = hit {
                far = far.max(start_m - hit.time_of_impact);
            }
        }
    }
    far
}

/// Whether any two parts are closer than `clearance_m` (0 = overlap or touch).
pub fn are_closer(a: &PosedShape, b: &PosedShape, clearance_m: f64) -> bool {
    let (a_boxes, b_boxes) =
        (a.shape.part_boxes(&a.world_from_object), b.shape.part_boxes(&b.world_from_object));
    let (a_pose, b_pose) = (to_parry(&a.world_from_object), to_parry(&b.world_from_object));
    a.shape.parts().iter().zip(&a_boxes).any(|(x, x_box)| {
        b.shape.parts().iter().zip(&b_boxes).any(|(y, y_box)| {
            let gap = (x_box.0 - y_box.1).max(y_box.0 - x_box.1).max_element();
            gap < clearance_m
                && distance(&a_pose, x.polyhedron.as_ref(), &b_pose, y.polyhedron.as_ref())
                    .is_ok_and(|found| found.distance < clearance_m)
        })
    })
}

/// A square slab under z = 0, which represents a plain table top for casts.
pub fn floor_hull(half_width_m: f64, thickness_m: f64) -> ConvexHull {
    let corner = |k: usize| {
        DVec3::new(
            if k & 1 == 0 { -half_width_m } else { half_width_m },
            if k & 2 == 0 { -half_width_m } else { half_width_m },
            if k & 4 == 0 { -thickness_m } else { 0.0 },
        )
    };
    ConvexHull {
        points: (0..8).map(corner).collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Solid;
    use crate::convex_hull::convex_hull;
    use crate::shapes::{block, sphere};
    use proptest::prelude::*;

    fn shape(solids: &[Solid]) -> CollisionShape {
        let hulls: Vec<ConvexHull> =
            solids.iter().map(|s| convex_hull(&s.positions, 255, 0.001).expect("a solid")).collect();
        CollisionShape::new(&hulls).expect("sound hulls")
    }

    fn table() -> CollisionShape {
        CollisionShape::new(&[floor_hull(1.0, 0.03)]).expect("a slab")
    }

    /// An open box: floor 1 cm, walls 1 cm, 20 cm wide, 15 cm high.
    fn open_box() -> CollisionShape {
        let wall =
            |x: f64, y: f64, w: f64, d: f64| block(DVec3::new(w, d, 0.15)).translated(DVec3::new(x, y, 0.0));
        shape(&[
            block(DVec3::new(0.2, 0.2, 0.01)),
            wall(-0.095, 0.0, 0.01, 0.2),
            wall(0.095, 0.0, 0.01, 0.2),
            wall(0.0, -0.095, 0.2, 0.01),
            wall(0.0, 0.095, 0.2, 0.01),
        ])
    }

    #[test]
    fn drop_height_is_the_table_top_and_none_beside_it() {
        let (table, cube) = (table(), shape(&[block(DVec3::splat(0.1))]));
        let on = [PosedShape { shape: &table, world_from_object: Pose::IDENTITY }];
        let z = drop_height(&cube, DQuat::IDENTITY, DVec2::new(0.3, -0.2), &on).expect("the table is there");
        assert!(z.abs() <= TOLERANCE_M, "{z}");
        let edge = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4);
        let z = drop_height(&cube, edge, DVec2::ZERO, &on).expect("the table is there");
        // The origin is the center of the bottom face, half a side up along the slope.
        assert!((z - 0.05 * 0.5_f64.sqrt()).abs() <= TOLERANCE_M, "standing on its edge {z}");
        assert_eq!(drop_height(&cube, DQuat::IDENTITY, DVec2::new(1.2, 0.0), &on), None);
    }

    #[test]
    fn drop_height_of_a_ball_is_the_box_floor_or_its_rim() {
        let (open_box, ball) = (open_box(), shape(&[sphere(0.05, 48)]));
        let on = [PosedShape {
            shape: &open_box,
            world_from_object: Pose::upright(DVec3::new(0.5, 0.0, 0.2), 0.3),
        }];
        let inside = drop_height(&ball, DQuat::IDENTITY, DVec2::new(0.5, 0.0), &on).expect("the box");
        assert!((inside - 0.21).abs() < 1e-4, "{inside}");
        let along = DQuat::from_rotation_z(0.3) * DVec3::new(0.095, 0.0, 0.0);
        let rim = drop_height(&ball, DQuat::IDENTITY, DVec2::new(0.5, 0.0) + along.truncate(), &on);
        let rim = rim.expect("the rim");
        assert!((rim - 0.35).abs() < 5e-4, "{rim}");
    }

    #[test]
    fn slide_distance_clears_the_shape_and_its_cavity() {
        let (open_box, ball) = (open_box(), shape(&[sphere(0.03, 48)]));
        let obstacle = PosedShape { shape: &open_box, world_from_object: Pose::IDENTITY };
        let at = |x: f64, z: f64| PosedShape {
            shape: &ball,
            world_from_object: Pose::upright(DVec3::new(x, 0.0, z), 0.0),
        };
        // From inside the cavity it must move out completely: half the box plus its radius.
        let out = slide_distance(&at(0.0, 0.05), &obstacle, DVec2::X, 0.001);
        assert!((out - 0.131).abs() < 2e-4, "{out}");
        assert!(!are_closer(&at(out, 0.05), &obstacle, 0.0009));
        assert!(are_closer(&at(out - 0.001, 0.05), &obstacle, 0.0009));
        assert_eq!(slide_distance(&at(0.0, 0.152), &obstacle, DVec2::X, 0.001), 0.0);
        assert_eq!(slide_distance(&at(0.2, 0.05), &obstacle, DVec2::X, 0.001), 0.0);
    }

    proptest! {
        #[test]
        fn drop_height_gives_contact_without_overlap(
            x in -0.12..0.12_f64, y in -0.12..0.12_f64, yaw in -3.0..3.0_f64, tilt in -1.0..1.0_f64,
        ) {
            let (open_box, block) = (open_box(), shape(&[block(DVec3::new(0.06, 0.03, 0.02))]));
            let floor = table();
            let on = [
                PosedShape { shape: &open_box, world_from_object: Pose::IDENTITY },
                PosedShape { shape: &floor, world_from_object: Pose::IDENTITY },
            ];
            let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(tilt);
            let z = drop_height(&block, rotation, DVec2::new(x, y), &on).expect("the floor is below");
            let distance_at = |z: f64| {
                let pose = to_parry(&Pose { translation_m: DVec3::new(x, y, z), rotation });
                on.iter()
                    .flat_map(|s| s.shape.parts())
                    .map(|part| {
                        let below = to_parry(&Pose::IDENTITY);
                        let block = block.parts()[0].polyhedron.as_ref();
                        parry3d_f64::query::contact(&pose, block, &below, part.polyhedron.as_ref(), 1.0)
                            .expect("convex shapes")
                            .map_or(f64::INFINITY, |contact| contact.dist)
                    })
                    .fold(f64::INFINITY, f64::min)
            };
            prop_assert!(distance_at(z).abs() < 1e-5, "gap {}", distance_at(z));
            prop_assert!(distance_at(z + 0.002) > 0.0);
        }
    }
}
