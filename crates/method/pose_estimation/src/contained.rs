//! Poses of objects in a container: pens that lean in a holder, a spoon in a mug, apples in a bowl.
//!
//! The paper's alignment rotates objects about the vertical only and would lay a pen across its holder. The box of a
//! leaning object in the top view determines its tilt and, up to a mirror image, its direction. Of the poses with such
//! a box the container admits few that go deep. All tilts are therefore scored by the difference between their box and
//! the detected one and by their height above the container's bottom after a drop, and the best is refined. The box
//! does not determine which end is up: the heavy end is down.
//!
//! World frame, meters, radians. Deterministic. Some eight milliseconds for a long object.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};

use super::top_view_layout::BoxFromAbove;
use geometry::Pose;
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::{PosedShape, drop_height, slid_in_height};

/// Objects with a smaller ratio of longest to second-longest extent do not lean; they keep their upright rotation.
const SLENDER: f64 = 2.2;

/// Numbers of directions and of tilts that are compared.
const AZIMUTHS: u32 = 48;
const LEANS: u32 = 22;

/// Weight of the height above the bottom, relative to the difference between the boxes. A box is accurate to about a
/// pixel, and depth carries little information: a meter of height weighs as a fifth of a meter.
const HEIGHT_WEIGHT: f64 = 0.2;

/// Number of tilts, per quarter of the compass and lower end, that are dropped.
const LET_DOWN: usize = 4;

/// Inward shifts of the box that are tried, meters: contact with a wall is exact to the millimeter, the detected box
/// is not.
const SHIFTS_M: [f64; 4] = [0.0, 0.003, 0.006, 0.01];

/// Refinement ends when steps are smaller than this, radians; position steps begin with this, meters.
const FINE_RAD: f64 = 0.004;
const SHIFT_STEP_M: f64 = 0.004;

/// Minimum cost advantage of leaning over lying, and of the light end down over the heavy end down, meters.
const LEANS_BY_M: f64 = 0.005;
const EITHER_END_M: f64 = 0.001;

/// Clearance around an object that is slid in below a handle, meters.
const SLIDING_GAP_M: f64 = 0.0005;

/// Factor on the boxes of objects in one container, so that boxes detected too large do not collide.
const SLIM: f64 = 0.9;

/// An object in a container.
#[derive(Clone, Copy)]
pub struct ContainedObject<'a> {
    pub shape: &'a CollisionShape,
    /// Rotation of the upright mesh by the object's yaw alone.
    pub upright: DQuat,
    pub seen: BoxFromAbove,
}

/// `world_from_object` of all objects in a container, in the order of the objects. `None` for an object whose box lies
/// beside the container.
pub fn lie(objects: &[ContainedObject], container: PosedShape) -> Vec<Option<Pose>> {
    let bottom_m = container.shape.bounds(&container.world_from_object).0.z;
    let mut found: Vec<Option<Pose>> =
        objects.iter().map(|object| DroppedObject { object, container, bottom_m }.pose()).collect();
    // Leaning objects cross each other. Lying objects may lie on others where there is room deep in the container's
    // center, so they come last.
    let lies = |k: usize| found[k].filter(|pose| pose.rotation == objects[k].upright);
    let lowest_m = |k: usize, pose: &Pose| objects[k].shape.bounds(pose).0.z;
    let mut heap: Vec<(f64, usize, Pose)> =
        (0..objects.len()).filter_map(|k| lies(k).map(|pose| (lowest_m(k, &pose), k, pose))).collect();
    heap.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut below: Vec<PosedShape> = Vec::with_capacity(heap.len());
    for (_, k, mut pose) in heap {
        let slim = objects[k].shape.slimmer(SLIM);
        if let Some(z_m) = drop_height(&slim, pose.rotation, pose.translation_m.truncate(), &below) {
            pose.translation_m.z = pose.translation_m.z.max(z_m);
        }
        found[k] = Some(pose);
        below.push(PosedShape { shape: objects[k].shape, world_from_object: pose });
    }
    found
}

/// Tilt of a long object: its upper end points `lean_rad` away from the vertical toward `azimuth_rad`, and its box's
/// center is shifted from the detected one.
#[derive(Clone, Copy, Debug)]
struct Tilt {
    lean_rad: f64,
    azimuth_rad: f64,
    shift_m: DVec2,
}

/// An object to be dropped into a container with no other contents.
struct DroppedObject<'a> {
    object: &'a ContainedObject<'a>,
    container: PosedShape<'a>,
    /// Lowest point of the container.
    bottom_m: f64,
}

impl DroppedObject<'_> {
    /// The pose that explains its box best; `None` if it does not touch the container.
    fn pose(&self) -> Option<Pose> {
        let flat = self.let_down(self.object.upright, DVec2::ZERO).map(|flat| self.slid_in(flat));
        let Some((axis, heavy_end)) = long_axis(self.object.shape) else { return flat.map(|(_, pose)| pose) };
        // Either end may be up; at equal cost the heavy one is down.
        let leaning = [-heavy_end, heavy_end].into_iter().filter_map(|up| self.best_lean(up * axis));
        let leaning = leaning.reduce(|best, next| if next.0 + EITHER_END_M < best.0 { next } else { best });
        let best = match (flat, leaning) {
            (Some(flat), Some(leaning)) if leaning.0 + LEANS_BY_M >= flat.0 => Some(flat),
            (flat, leaning) => leaning.or(flat),
        };
        best.map(|(_, pose)| pose)
    }

    /// Cost and pose of the rotated object after a drop, with its box's center shifted from the detected one.
    fn let_down(&self, rotation: DQuat, shift_m: DVec2) -> Option<(f64, Pose)> {
        let (low, high) = self.object.shape.bounds(&Pose { translation_m: DVec3::ZERO, rotation });
        let xy_m = self.object.seen.center_m + shift_m - 0.5 * (low + high).truncate();
        let z_m = drop_height(self.object.shape, rotation, xy_m, &[self.container])?;
        let height_m = (low.z + z_m - self.bottom_m).max(0.0);
        let cost_m = self.misfit_m(rotation) + shift_m.length() + HEIGHT_WEIGHT * height_m;
        Some((cost_m, Pose { translation_m: xy_m.extend(z_m), rotation }))
    }

    /// The dropped pose, or a deeper one if only a handle held the object up.
    fn slid_in(&self, (cost_m, mut pose): (f64, Pose)) -> (f64, Pose) {
        let (bottom, top) = self.container.shape.bounds(&self.container.world_from_object);
        let within = (bottom.z, top.z);
        let shape = self.object.shape;
        let Some(z_m) = slid_in_height(shape, &pose, within, &[self.container], SLIDING_GAP_M) else {
            return (cost_m, pose);
        };
        let down_m = pose.translation_m.z - z_m;
        pose.translation_m.z = z_m;
        (cost_m - HEIGHT_WEIGHT * down_m, pose)
    }

    /// Difference between the sides of the rotated object's box and of the detected one, meters.
    fn misfit_m(&self, rotation: DQuat) -> f64 {
        let (low, high) = self.object.shape.bounds(&Pose { translation_m: DVec3::ZERO, rotation });
        ((high - low).truncate() - self.object.seen.extent_m).abs().element_sum()
    }

    /// The cheapest tilt with that axis (of the object's frame) up.
    fn best_lean(&self, up: DVec3) -> Option<(f64, Pose)> {
        let rotation = |lean: &Tilt| turned(self.object.upright, up, lean);
        let tried = |lean: Tilt| {
            self.let_down(rotation(&lean), lean.shift_m).map(|(cost_m, pose)| (cost_m, pose, lean))
        };
        let (low, high) = self.container.shape.bounds(&self.container.world_from_object);
        let inward = (0.5 * (low + high).truncate() - self.object.seen.center_m).normalize_or_zero();
        let (azimuth_step, lean_step) = (TAU / f64::from(AZIMUTHS), 0.5 * PI / f64::from(LEANS));
        let promising = (0..4).flat_map(|quarter| {
            let azimuths = (0..AZIMUTHS / 4).map(|k| azimuth_step * f64::from(quarter * AZIMUTHS / 4 + k));
            let mut leans: Vec<(f64, Tilt)> = azimuths
                .flat_map(|azimuth_rad| (0..LEANS).map(move |k| (lean_step * f64::from(k), azimuth_rad)))
                .map(|(lean_rad, azimuth_rad)| Tilt { lean_rad, azimuth_rad, shift_m: DVec2::ZERO })
                .map(|lean| (self.misfit_m(rotation(&lean)), lean))
                .collect();
            leans.sort_by(|a, b| a.0.total_cmp(&b.0));
            leans.into_iter().take(LET_DOWN).map(|(_, lean)| lean)
        });
        let shifted =
            promising.flat_map(|lean| SHIFTS_M.map(|way_m| Tilt { shift_m: way_m * inward, ..lean }));
        let (mut cost_m, mut pose, mut lean) =
            shifted.filter_map(tried).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut share = 0.5;
        while share * lean_step.max(azimuth_step) > FINE_RAD {
            let steps = [
                (share * lean_step, 0.0, DVec2::ZERO),
                (0.0, share * azimuth_step, DVec2::ZERO),
                (0.0, 0.0, share * SHIFT_STEP_M * DVec2::X),
                (0.0, 0.0, share * SHIFT_STEP_M * DVec2::Y),
            ];
            let around = steps.into_iter().flat_map(|(steeper, farther, shift)| {
                [1.0, -1.0].map(|way| Tilt {
                    lean_rad: lean.lean_rad + way * steeper,
                    azimuth_rad: lean.azimuth_rad + way * farther,
                    shift_m: lean.shift_m + way * shift,
                })
            });
            let next = around.filter_map(tried).min_by(|a, b| a.0.total_cmp(&b.0));
            match next.filter(|(next_m, ..)| *next_m < cost_m) {
                Some(better) => (cost_m, pose, lean) = better,
                None => share *= 0.5,
            }
        }
        Some((cost_m, pose))
    }
}

/// The rotation `upright`, followed by the shortest rotation that takes the axis `up` of the object's frame to the
/// tilted direction.
fn turned(upright: DQuat, up: DVec3, lean: &Tilt) -> DQuat {
    let (sin, cos) = lean.lean_rad.sin_cos();
    let target = (sin * DVec2::from_angle(lean.azimuth_rad)).extend(cos);
    (DQuat::from_rotation_arc(upright * up, target) * upright).normalize()
}

/// The longest axis of a slender object, and toward which end of it (1 or -1) it is heavy.
fn long_axis(object: &CollisionShape) -> Option<(DVec3, f64)> {
    let (low, high) = object.bounds(&Pose::IDENTITY);
    let size = high - low;
    let longest = size.max_position();
    let axis = DVec3::AXES[longest];
    let second = (size - size * axis).max_element();
    let heavy = (object.center_of_volume_m() - 0.5 * (low + high)).dot(axis);
    (size[longest] > SLENDER * second).then_some((axis, if heavy < 0.0 { -1.0 } else { 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Solid;
    use geometry::convex_hull::convex_hull;
    use geometry::shapes::{block, sphere};

    fn shape(solids: &[Solid]) -> CollisionShape {
        let hulls: Vec<_> =
            solids.iter().map(|s| convex_hull(&s.positions, 255, 0.001).expect("a solid")).collect();
        CollisionShape::new(&hulls).expect("sound hulls")
    }

    fn bar(low: DVec3, high: DVec3) -> Solid {
        block(high - low).translated((0.5 * (low + high)).with_z(low.z))
    }

    /// An open box: inside 70 mm square, 100 mm deep, walls of 3 mm, its center at the origin.
    fn holder() -> CollisionShape {
        shape(&holder_walls())
    }

    fn holder_walls() -> Vec<Solid> {
        let (inner, outer, floor, rim) = (0.035, 0.038, 0.003, 0.1);
        let walls = [
            (DVec3::new(-outer, -outer, 0.0), DVec3::new(outer, outer, floor)),
            (DVec3::new(-outer, -outer, 0.0), DVec3::new(-inner, outer, rim)),
            (DVec3::new(inner, -outer, 0.0), DVec3::new(outer, outer, rim)),
            (DVec3::new(-outer, -outer, 0.0), DVec3::new(outer, -inner, rim)),
            (DVec3::new(-outer, inner, 0.0), DVec3::new(outer, outer, rim)),
        ];
        walls.map(|(low, high)| bar(low, high)).to_vec()
    }

    /// 140 mm along x and 8 mm thick, the end at +x twice as thick and so the heavy one; its head lies on z = 0.
    fn brush() -> CollisionShape {
        let handle = bar(DVec3::new(-0.07, -0.004, 0.004), DVec3::new(0.05, 0.004, 0.012));
        let head = bar(DVec3::new(0.05, -0.008, 0.0), DVec3::new(0.07, 0.008, 0.016));
        shape(&[handle, head])
    }

    fn seen(object: &CollisionShape, pose: &Pose) -> BoxFromAbove {
        let (low, high) = object.bounds(pose);
        BoxFromAbove { center_m: 0.5 * (low + high).truncate(), extent_m: (high - low).truncate() }
    }

    fn lies(
        shape: &CollisionShape,
        upright: DQuat,
        seen: BoxFromAbove,
        container: PosedShape,
    ) -> Option<Pose> {
        lie(&[ContainedObject { shape, upright, seen }], container)[0]
    }

    #[test]
    fn lie_recovers_leaning_brush() {
        let (holder, brush) = (holder(), brush());
        let container = PosedShape { shape: &holder, world_from_object: Pose::IDENTITY };
        for azimuth_deg in [20.0_f64, 115.0, 200.0, 290.0] {
            let azimuth_rad = azimuth_deg.to_radians();
            let rotation = turned(
                DQuat::IDENTITY,
                -DVec3::X,
                &Tilt { lean_rad: 0.38, azimuth_rad, shift_m: DVec2::ZERO },
            );
            // Its foot stands opposite to where it leans.
            let (low, high) = brush.bounds(&Pose { translation_m: DVec3::ZERO, rotation });
            let xy_m = 0.004 * DVec2::from_angle(azimuth_rad) - 0.5 * (low + high).truncate();
            let z_m = drop_height(&brush, rotation, xy_m, &[container]).expect("below it is the holder");
            let truth = Pose { translation_m: xy_m.extend(z_m), rotation };
            let yaw = DQuat::from_rotation_z(1.0);
            let found = lies(&brush, yaw, seen(&brush, &truth), container).expect("a pose");
            // The box does not determine the rotation about the axis, and the origin lies at the underside.
            let center = |pose: &Pose| pose.transform_point(DVec3::new(0.0, 0.0, 0.008));
            let off_m = (center(&found) - center(&truth)).length();
            assert!(off_m < 0.006, "{azimuth_deg} degrees: {:.1} mm off", 1e3 * off_m);
            // Its wide head hides part of the tilt.
            let axes = [found, truth].map(|pose| pose.rotation * DVec3::X);
            let between_deg = axes[0].angle_between(axes[1]).to_degrees();
            assert!(between_deg < 18.0, "{azimuth_deg} degrees: leans {between_deg:.1} degrees elsewhere");
        }
    }

    #[test]
    fn lie_keeps_object_across_rim() {
        let (holder, brush) = (holder(), brush());
        let container = PosedShape { shape: &holder, world_from_object: Pose::IDENTITY };
        let upright = DQuat::from_rotation_z(0.3);
        let z_m = drop_height(&brush, upright, DVec2::ZERO, &[container]).expect("below it is the holder");
        let truth = Pose { translation_m: DVec3::Z * z_m, rotation: upright };
        let found = lies(&brush, upright, seen(&brush, &truth), container).expect("a pose");
        let turned_rad = 2.0 * (found.rotation * truth.rotation.inverse()).w.abs().min(1.0).acos();
        assert!(
            (found.translation_m - truth.translation_m).length() < 0.002 && turned_rad < 0.05,
            "{found:?}"
        );
    }

    #[test]
    fn lie_slides_object_below_handle() {
        let mut solids = holder_walls();
        solids.push(bar(DVec3::new(-0.038, -0.004, 0.15), DVec3::new(0.038, 0.004, 0.155)));
        for x in [-0.0365, 0.0365] {
            solids.push(bar(DVec3::new(x - 0.0015, -0.004, 0.1), DVec3::new(x + 0.0015, 0.004, 0.15)));
        }
        let basket = shape(&solids);
        let container = PosedShape { shape: &basket, world_from_object: Pose::IDENTITY };
        let ball = shape(&[sphere(0.02, 24)]);
        let seen = BoxFromAbove { center_m: DVec2::ZERO, extent_m: DVec2::splat(0.04) };
        let found = lies(&ball, DQuat::IDENTITY, seen, container).expect("a pose");
        let lowest_m = ball.bounds(&found).0.z;
        assert!((0.003..0.01).contains(&lowest_m), "{lowest_m}");
    }

    #[test]
    fn lie_stacks_fourth_ball_on_three() {
        let holder = holder();
        let ball = shape(&[sphere(0.016, 24)]);
        let container = PosedShape { shape: &holder, world_from_object: Pose::IDENTITY };
        // Three on the bottom, slightly nearer to each other than possible; the fourth over the gap between them.
        let around = (0..3).map(|k| 0.0182 * DVec2::from_angle(TAU * f64::from(k) / 3.0));
        let objects: Vec<ContainedObject> = [DVec2::ZERO]
            .into_iter()
            .chain(around)
            .map(|center_m| BoxFromAbove { center_m, extent_m: DVec2::splat(0.032) })
            .map(|seen| ContainedObject { shape: &ball, upright: DQuat::IDENTITY, seen })
            .collect();
        let lowest =
            lie(&objects, container).into_iter().map(|pose| ball.bounds(&pose.expect("in the holder")).0.z);
        let lowest: Vec<f64> = lowest.collect();
        assert!(lowest[1..].iter().all(|z_m| (z_m - 0.003).abs() < 1e-4), "{lowest:?}");
        assert!(lowest[0] > 0.015 && lowest[0] < 0.035, "{lowest:?}");
        let beside = BoxFromAbove { center_m: DVec2::new(1.0, 0.0), ..objects[0].seen };
        assert_eq!(lies(&ball, DQuat::IDENTITY, beside, container), None);
    }

    #[test]
    fn long_axis_rejects_cube() {
        assert!(long_axis(&shape(&[block(DVec3::new(0.05, 0.04, 0.04))])).is_none());
        assert_eq!(long_axis(&brush()).map(|(axis, _)| axis), Some(DVec3::X));
    }
}
