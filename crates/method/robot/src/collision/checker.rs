//! The fast check: does an arm in eight configurations, or on its way along an edge, touch anything?

use super::arm::{Arm, MAX_BODIES, MAX_JOINTS};
use super::lane_arm::{Configuration, LaneArm, LaneBody, LaneFrame, ROUNDING_MARGIN_M};
use super::lane_vector::LaneVector;
use super::lane_world::LaneWorld;
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

    /// A checker with chosen instructions; the answers do not depend on them.
    pub fn with_backend(arm: &Arm, obstacles: &[Obstacle], padding_m: f64, backend: Backend) -> Self {
        let padding_m = padding_m.max(0.0);
        let fixed = arm.bodies().iter().filter(|body| body.frame == 0).flat_map(|body| &body.spheres);
        let base_hit = fixed.clone().any(|sphere| {
            obstacles.iter().any(|o| {
                o.signed_distance_m(&sphere.center_m) < sphere.radius_m + padding_m + ROUNDING_MARGIN_M
            })
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

    /// Tests eight configurations for collisions: bit `k` is set if `configurations[k]` collides.
    pub fn colliding(&self, configurations: &[Configuration; LANE_COUNT]) -> u8 {
        if !self.base_hit && !self.backend.run(Block { checker: self, configurations }) {
            return 0;
        }
        (0..LANE_COUNT).filter(|&k| !self.is_free(&configurations[k])).fold(0, |bits, k| bits | 1 << k)
    }

    /// Whether the arm touches nothing in a configuration.
    pub fn is_free(&self, configuration: &Configuration) -> bool {
        !self.base_hit
            && !self.backend.run(Block { checker: self, configurations: &[*configuration; LANE_COUNT] })
    }

    /// Whether the arm touches nothing on the straight way from `from`, which is not itself checked, to `to`.
    ///
    /// It is checked at `checks_per_unit` points for each unit of the distance in joint space, and at least at eight.
    /// Eight are spread over the whole edge and then moved back together, so that a collision is found early.
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
        let mut positions = [L::splat(token, 0.0); MAX_JOINTS];
        for joint in 0..MAX_JOINTS {
            let mut lanes = [0.0; LANE_COUNT];
            for (lane, configuration) in lanes.iter_mut().zip(self.configurations) {
                *lane = configuration[joint];
            }
            positions[joint] = L::from_array(token, lanes);
        }
        let mut scratch = Scratch::new(token);
        touches(self.checker, &positions, &mut scratch)
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
        let share = L::from_array(token, SHARES);
        let (mut change, mut square) = ([0.0; MAX_JOINTS], 0.0);
        for (change, (from, to)) in change.iter_mut().zip(self.from.iter().zip(self.to)) {
            *change = to - from;
            square += *change * *change;
        }
        let blocks = (square.sqrt() * self.checks_per_unit / LANE_COUNT as f32).ceil().max(1.0);
        let (mut positions, mut back) = ([share; MAX_JOINTS], [share; MAX_JOINTS]);
        for joint in 0..MAX_JOINTS {
            positions[joint] = share.like(self.from[joint]) + share.like(change[joint]) * share;
            back[joint] = share.like(change[joint] / (LANE_COUNT as f32 * blocks));
        }
        let mut scratch = Scratch::new(token);
        for _ in 0..blocks as usize {
            if touches(self.checker, &positions, &mut scratch) {
                return true;
            }
            for joint in 0..MAX_JOINTS {
                positions[joint] = positions[joint] - back[joint];
            }
        }
        false
    }
}

/// Positions of the first eight points of an edge, as shares of its length.
const SHARES: [f32; LANE_COUNT] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// Positions of frames and bounding spheres. One is made for each edge, as filling it takes as long as a part of a
/// check.
struct Scratch<L> {
    frames: [LaneFrame<L>; MAX_JOINTS + 1],
    centers_m: [LaneVector<L>; MAX_BODIES],
}

impl<L: Lanes> Scratch<L> {
    #[inline(always)]
    fn new(token: L::Token) -> Self {
        let frames = [LaneFrame::base(token); MAX_JOINTS + 1];
        Self { frames, centers_m: [LaneVector::splat(token, [0.0; 3]); MAX_BODIES] }
    }
}

/// Whether the arm touches anything in any of eight configurations.
#[inline(always)]
fn touches<L: Lanes>(checker: &Checker, positions: &[L; MAX_JOINTS], scratch: &mut Scratch<L>) -> bool {
    let arm = &checker.arm;
    arm.place_frames(positions, &mut scratch.frames);
    let Scratch { frames, centers_m } = scratch;
    for (index, body) in arm.bodies.iter().enumerate() {
        let frame = &frames[body.frame];
        let center_m = frame.place(body.bounding.center_m);
        centers_m[index] = center_m;
        if body.frame > 0 && touches_world(&checker.world, body, frame, center_m) {
            return true;
        }
    }
    for &(a, b) in &arm.pairs {
        let (first, second) = (&arm.bodies[a], &arm.bodies[b]);
        if meet(centers_m[a], first.bounding.radius_m, centers_m[b], second.bounding.radius_m)
            && bodies_touch(first, &frames[first.frame], second, &frames[second.frame], centers_m[b])
        {
            return true;
        }
    }
    false
}

/// Whether a body, whose bounding sphere has its center at `center_m`, touches an obstacle in any lane.
#[inline(always)]
fn touches_world<L: Lanes>(
    world: &LaneWorld,
    body: &LaneBody,
    frame: &LaneFrame<L>,
    center_m: LaneVector<L>,
) -> bool {
    let token = center_m.x.token();
    let reach_m = body.bounding.radius_m;
    let LaneVector { x, y, z } = center_m;
    let low = LaneVector::<L>::splat(
        token,
        [x.min_lane() - reach_m, y.min_lane() - reach_m, z.min_lane() - reach_m],
    );
    let high = LaneVector::<L>::splat(
        token,
        [x.max_lane() + reach_m, y.max_lane() + reach_m, z.max_lane() + reach_m],
    );
    for group in 0..world.group_count() {
        let mut near = world.near(group, low, high);
        while near != 0 {
            let obstacle = &world.obstacles[LANE_COUNT * group + near.trailing_zeros() as usize];
            if obstacle.hits(center_m, reach_m) != 0 {
                for sphere in &body.spheres {
                    if obstacle.hits(frame.place(sphere.center_m), sphere.radius_m) != 0 {
                        return true;
                    }
                }
            }
            near &= near - 1;
        }
    }
    false
}

/// Whether spheres of two bodies meet in any lane.
#[inline(always)]
fn bodies_touch<L: Lanes>(
    first: &LaneBody,
    first_frame: &LaneFrame<L>,
    second: &LaneBody,
    second_frame: &LaneFrame<L>,
    second_center_m: LaneVector<L>,
) -> bool {
    for a in &first.spheres {
        let center_m = first_frame.place(a.center_m);
        if meet(center_m, a.radius_m, second_center_m, second.bounding.radius_m) {
            for b in &second.spheres {
                if meet(center_m, a.radius_m, second_frame.place(b.center_m), b.radius_m) {
                    return true;
                }
            }
        }
    }
    false
}

/// Whether two spheres meet in any lane.
#[inline(always)]
fn meet<L: Lanes>(a_m: LaneVector<L>, a_radius_m: f32, b_m: LaneVector<L>, b_radius_m: f32) -> bool {
    let reach_m = a_radius_m + b_radius_m;
    (a_m - b_m).square().below(a_m.x.like(reach_m * reach_m)) != 0
}
