//! The fast check: does an arm in eight configurations, or on its way along an edge, touch anything?

use super::arm::{Arm, MAX_BODIES, MAX_JOINTS};
use super::lane_arm::{Configuration, LaneArm, LaneBody, LaneFrame, ROUNDING_MARGIN_M};
use super::lane_world::{LaneObstacle, LaneWorld};
use super::lanes::{Backend, LANE_COUNT, LaneTask, Lanes};
use super::obstacle::Obstacle;

/// An arm among obstacles, ready for fast checks.
///
/// A configuration that it calls free is free: radii are larger than the arm's by the padding and by
/// [`ROUNDING_MARGIN_M`], which is more than the rounding errors.
#[derive(Clone, Debug)]
pub struct Checker {
    arm: LaneArm,
    world: LaneWorld,
    backend: Backend,
    /// The base, which does not move, touches an obstacle.
    base_hit: bool,
}

impl Checker {
    /// A checker that keeps all spheres of `arm` at least `padding_m` away from `obstacles` and half of it from each
    /// other.
    pub fn new(arm: &Arm, obstacles: &[Obstacle], padding_m: f64) -> Self {
        Self::with_backend(arm, obstacles, padding_m, Backend::fastest())
    }

    /// The same with chosen instructions; the answers do not depend on them.
    pub fn with_backend(arm: &Arm, obstacles: &[Obstacle], padding_m: f64, backend: Backend) -> Self {
        let padding_m = padding_m.max(0.0);
        let fixed = arm.bodies().iter().filter(|body| body.frame == 0).flat_map(|body| &body.spheres);
        let base_hit = fixed.clone().any(|sphere| {
            obstacles.iter().any(|o| o.signed_distance_m(&sphere.center_m) < sphere.radius_m + padding_m + ROUNDING_MARGIN_M)
        });
        Self { arm: LaneArm::new(arm, padding_m), world: LaneWorld::new(obstacles), backend, base_hit }
    }

    /// The number of joints of the arm.
    pub fn dof(&self) -> usize {
        self.arm.dof()
    }

    /// The instructions that it uses.
    pub fn backend(&self) -> Backend {
        self.backend
    }

    /// Which of eight configurations are in collision: bit `k` belongs to `configurations[k]`.
    pub fn colliding(&self, configurations: &[Configuration; LANE_COUNT]) -> u8 {
        if !self.base_hit && !self.backend.run(Block { checker: self, configurations }) {
            return 0;
        }
        (0..LANE_COUNT).filter(|&k| !self.is_free(&configurations[k])).fold(0, |bits, k| bits | 1 << k)
    }

    /// Whether the arm touches nothing in a configuration.
    pub fn is_free(&self, configuration: &Configuration) -> bool {
        !self.base_hit && !self.backend.run(Block { checker: self, configurations: &[*configuration; LANE_COUNT] })
    }

    /// Whether the arm touches nothing on the straight way from `from`, which is not itself checked, to `to`.
    ///
    /// It is checked at `checks_per_unit` points, at least eight, for each unit of the distance in joint space. They
    /// are spread evenly over the whole edge at first and then moved back together, so that a collision is found early.
    pub fn edge_is_free(&self, from: &Configuration, to: &Configuration, checks_per_unit: f32) -> bool {
        !self.base_hit && !self.backend.run(Edge { checker: self, from, to, checks_per_unit })
    }
}

struct Block<'a> {
    checker: &'a Checker,
    configurations: &'a [Configuration; LANE_COUNT],
}

impl LaneTask for Block<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> bool {
        let row = |joint: usize| L::from_array(token, std::array::from_fn(|k| self.configurations[k][joint]));
        touches(self.checker, token, &std::array::from_fn(row))
    }
}

struct Edge<'a> {
    checker: &'a Checker,
    from: &'a Configuration,
    to: &'a Configuration,
    checks_per_unit: f32,
}

impl LaneTask for Edge<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> bool {
        let share = L::from_array(token, std::array::from_fn(|k| (k + 1) as f32 / LANE_COUNT as f32));
        let change: Configuration = std::array::from_fn(|joint| self.to[joint] - self.from[joint]);
        let length = change.iter().map(|c| c * c).sum::<f32>().sqrt();
        let blocks = (length * self.checks_per_unit / LANE_COUNT as f32).ceil().max(1.0);
        let back = change.map(|c| L::splat(token, c / (LANE_COUNT as f32 * blocks)));
        let mut positions: [L; MAX_JOINTS] = std::array::from_fn(|joint| {
            L::splat(token, self.from[joint]) + L::splat(token, change[joint]) * share
        });
        for _ in 0..blocks as usize {
            if touches(self.checker, token, &positions) {
                return true;
            }
            positions = std::array::from_fn(|joint| positions[joint] - back[joint]);
        }
        false
    }
}

/// Whether the arm touches anything in any of eight configurations.
#[inline(always)]
fn touches<L: Lanes>(checker: &Checker, token: L::Token, positions: &[L; MAX_JOINTS]) -> bool {
    let arm = &checker.arm;
    let frames = arm.frames(token, positions);
    let mut centers_m = [[L::splat(token, 0.0); 3]; MAX_BODIES];
    for (body, center_m) in arm.bodies.iter().zip(&mut centers_m) {
        let frame = &frames[body.frame];
        *center_m = frame.place(body.bounding.center_m);
        if body.frame > 0 && touches_world(&checker.world, token, body, frame, *center_m) {
            return true;
        }
    }
    arm.pairs.iter().any(|&(a, b)| {
        let (first, second) = (&arm.bodies[a], &arm.bodies[b]);
        meet(centers_m[a], first.bounding.radius_m, centers_m[b], second.bounding.radius_m)
            && bodies_touch(first, &frames[first.frame], second, &frames[second.frame], centers_m[b])
    })
}

/// Whether a body, whose bounding sphere has its center at `center_m`, touches an obstacle in any lane.
#[inline(always)]
fn touches_world<L: Lanes>(
    world: &LaneWorld,
    token: L::Token,
    body: &LaneBody,
    frame: &LaneFrame<L>,
    center_m: [L; 3],
) -> bool {
    let reach_m = body.bounding.radius_m;
    let low_m = center_m.map(|part| part.min_lane() - reach_m);
    let high_m = center_m.map(|part| part.max_lane() + reach_m);
    let touched = |obstacle: &LaneObstacle| {
        obstacle.hits(center_m, reach_m) != 0
            && body.spheres.iter().any(|s| obstacle.hits(frame.place(s.center_m), s.radius_m) != 0)
    };
    world.any_near::<L>(token, low_m, high_m, touched)
}

/// Whether spheres of two bodies meet in any lane.
#[inline(always)]
fn bodies_touch<L: Lanes>(
    first: &LaneBody,
    first_frame: &LaneFrame<L>,
    second: &LaneBody,
    second_frame: &LaneFrame<L>,
    second_center_m: [L; 3],
) -> bool {
    first.spheres.iter().any(|a| {
        let center_m = first_frame.place(a.center_m);
        meet(center_m, a.radius_m, second_center_m, second.bounding.radius_m)
            && second.spheres.iter().any(|b| meet(center_m, a.radius_m, second_frame.place(b.center_m), b.radius_m))
    })
}

/// Whether two spheres meet in any lane.
#[inline(always)]
fn meet<L: Lanes>(a_m: [L; 3], a_radius_m: f32, b_m: [L; 3], b_radius_m: f32) -> bool {
    let [x, y, z]: [L; 3] = std::array::from_fn(|row| a_m[row] - b_m[row]);
    let reach_m = a_radius_m + b_radius_m;
    (x * x + y * y + z * z).below(x.like(reach_m * reach_m)) != 0
}
