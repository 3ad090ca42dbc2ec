//! The shapes of a gripper in the frame of its tool, for any opening.

use geometry::{ConvexHull, DVec3};
use nalgebra::{Isometry3, Point3};
use robot::model::Robot;

use crate::frames::{from_vector, to_vector};
use crate::mechanism::Mechanism;

/// Collision geometry of a hand, in the frame of the tool.
#[derive(Clone, Debug)]
pub struct HandShape {
    /// The part that carries the fingers.
    pub palm: Vec<Vec<DVec3>>,
    pub fingers: Vec<FingerShape>,
    pub max_opening_m: f64,
    /// Half the extent of a pad across the closing line (x of the tool) and along the approach (z).
    pub pad_half_m: [f64; 2],
    /// The coefficient of friction of the pads.
    pub friction: f64,
}

/// A finger when the pads touch each other, and how far it moves for each meter of the opening.
#[derive(Clone, Debug)]
pub struct FingerShape {
    /// Without the pads.
    pub body: Vec<Vec<DVec3>>,
    pub pads: Vec<Vec<DVec3>>,
    pub way_per_opening: DVec3,
}

impl HandShape {
    pub fn new(robot: &Robot) -> Self {
        let mechanism = Mechanism::of_robot(robot);
        let rest = vec![0.0; robot.dof()];
        let tool_from_parts = |opening_m: f64| -> Vec<Isometry3<f64>> {
            let poses = mechanism.base_from_parts(&rest, robot.gripper_position(opening_m));
            let tool_from_base = (poses[mechanism.tool_part] * mechanism.part_from_tool).inverse();
            poses.iter().map(|base_from_part| tool_from_base * base_from_part).collect()
        };
        let (closed, opened) = (tool_from_parts(0.0), tool_from_parts(1.0));
        let placed = |part: usize, hulls: &[ConvexHull]| -> Vec<Vec<DVec3>> {
            let place = |p: &DVec3| to_vector(&(closed[part] * Point3::from(from_vector(*p))).coords);
            hulls.iter().map(|hull| hull.points.iter().map(place).collect()).collect()
        };
        let fingers: Vec<FingerShape> = mechanism
            .fingers()
            .map(|part| FingerShape {
                body: placed(part, &mechanism.parts[part].hulls),
                pads: placed(part, &mechanism.parts[part].pads),
                way_per_opening: to_vector(
                    &(opened[part].translation.vector - closed[part].translation.vector),
                ),
            })
            .collect();
        let pads = || fingers.iter().flat_map(|finger| finger.pads.iter().flatten());
        let reach = |of: fn(&DVec3) -> f64| pads().map(|p| of(p).abs()).fold(0.0, f64::max);
        let pad_half_m = [reach(|p| p.x), reach(|p| p.z)];
        Self {
            palm: placed(mechanism.tool_part, &mechanism.parts[mechanism.tool_part].hulls),
            pad_half_m,
            max_opening_m: robot.gripper().max_opening_m,
            friction: robot.gripper().pad_friction,
            fingers,
        }
    }

    /// All solids with the pads `opening_m` apart, each as its corners: the palm, the fingers and, if asked, the pads.
    pub fn solids(&self, opening_m: f64, with_pads: bool) -> Vec<Vec<DVec3>> {
        let mut solids = self.palm.clone();
        for finger in &self.fingers {
            let way = finger.way_per_opening * opening_m;
            let pads = with_pads.then_some(&finger.pads).into_iter().flatten();
            solids.extend(finger.body.iter().chain(pads).map(|s| s.iter().map(|p| *p + way).collect()));
        }
        solids
    }
}
