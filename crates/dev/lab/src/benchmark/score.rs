//! Layout errors against the ground truth, per object.
//!
//! The layout of `place`, before any repair, is compared with the settled poses of the rendered scene:
//!
//! - *yaw*: twist about world +z of the rotation from the true to the placed pose, as a distance to the nearest yaw
//!   that is indistinguishable in the true image ([`super::indistinguishable_yaws`]). If the mesh stands on another
//!   side than the true one, the yaws are those of the mesh on that side (a nut is indistinguishable upside down); the
//!   error is 180 degrees if no yaw is indistinguishable;
//! - *position*: horizontal distance between the object frame origins (center of the bottom face of the mesh's own
//!   box), world frame, meters;
//! - *scale*: `|s - 1|` where `s` is the cube root of the ratio of placed to true box volume.
//!
//! Not every object has a yaw that can be determined: see [`YawStatus`]. A leaning object has no position error
//! either, because the stages place objects upright; its scale counts.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::indistinguishable_yaws::IndistinguishableYaws;
use ports::TruthInstance;
use scene::{InstanceId, Supporter};
use tabletopgen::pipeline::canonicalize;
use tabletopgen::pipeline::place::PlacedInstance;
use tabletopgen::pipeline::rotate;

/// An object leans if its vertical axis deviates from the world's by more than this, radians.
pub const LEANING_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// A mesh stands on another side if its vertical axis deviates from the true one by more than this, radians.
const WRONG_SIDE_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Status of an object's yaw in the score: scored, or the reason why it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum YawStatus {
    Scored,
    /// The category has rotational symmetry of order 0: any yaw is correct.
    OrderZero,
    /// The object leans or lies tilted (a pen in a holder), so its pose is not a yaw.
    Leaning,
    /// The category has a front, but all yaws are indistinguishable in the true image.
    AnyIndistinguishable,
    /// Only textures determine the yaw to within 10 degrees (a printed coaster, a labeled bottle): with one color
    /// per material, other yaws become indistinguishable, and the stages' mesh has other textures.
    OnlyTextureTells,
}

/// Scores of one object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectScore {
    pub name: InstanceId,
    pub category: String,
    /// Whether it rests in a container, or on another object.
    pub contained: bool,
    pub stacked: bool,
    /// Angle between the true vertical axis of the object and the world's, degrees.
    pub tilt_deg: f64,
    pub yaw_status: YawStatus,
    /// Present if scored or if only the texture determines the yaw; degrees.
    pub yaw_error_deg: Option<f64>,
    /// Twist from the true to the placed pose, degrees in (-180, 180], ignoring indistinguishable yaws.
    pub turn_deg: f64,
    pub wrong_side: bool,
    /// Absent if the object leans; meters.
    pub position_error_m: Option<f64>,
    pub scale_error: f64,
    /// Number of visible pixels, and their share of the complete silhouette.
    pub visible_px: usize,
    pub visible_share: f64,
    /// Number of separate intervals of indistinguishable yaws.
    pub indistinguishable: usize,
    /// Result of the rotation optimizer.
    pub estimated_order: u32,
    pub confidence: f64,
    pub loss: f64,
    /// Confidence of the upright rotation.
    pub upright_confidence: f64,
}

/// Ground truth and estimates of one object.
pub struct Compared<'a> {
    pub category: &'a str,
    pub truth: &'a TruthInstance,
    pub placed: &'a PlacedInstance,
    pub supporter: Supporter,
    pub canonical: &'a canonicalize::Output,
    pub yaw: &'a rotate::Output,
    pub raw_from_rendered: DQuat,
    /// Rotations from [`Self::query_rotation`].
    pub indistinguishable: IndistinguishableYaws,
    /// Whether the stages' mesh has other textures than the true one and nothing else determines the yaw.
    pub only_texture_tells: bool,
    pub visible_px: usize,
    pub visible_share: f64,
}

impl Compared<'_> {
    /// Rotation of the placed object's true frame in the world.
    fn placed_rotation(&self) -> DQuat {
        self.placed.world_from_object.rotation * self.canonical_from_rendered()
    }

    fn canonical_from_rendered(&self) -> DQuat {
        self.canonical.rotation_xyzw * self.raw_from_rendered
    }

    /// World rotation from the true to the placed pose.
    fn placed_from_rendered(&self) -> DQuat {
        self.placed_rotation() * self.truth.rotation_xyzw.inverse()
    }

    /// Whether it stands on another side than in the ground truth.
    pub fn wrong_side(&self) -> bool {
        (self.placed_from_rendered() * DVec3::Z).angle_between(DVec3::Z) > WRONG_SIDE_RAD
    }

    /// `world_from_rendered` from which rotations are counted: the true one, or the placed side in the true heading
    /// if the object stands on another side.
    pub fn query_rotation(&self) -> DQuat {
        let rendered = self.truth.rotation_xyzw;
        if self.wrong_side() { in_heading_of(rendered, self.canonical_from_rendered()) } else { rendered }
    }

    /// The correct result of `rotate`: yaw of the canonical frame, radians.
    pub fn true_yaw_rad(&self) -> f64 {
        twist_rad(self.truth.rotation_xyzw * self.canonical_from_rendered().inverse())
    }

    /// Ratio of placed to true size: cube root of the ratio of the box volumes.
    pub fn scale(&self) -> f64 {
        (self.placed.size_m.element_product() / self.truth.size_m.element_product().max(1e-30)).cbrt()
    }

    /// The scores of the object.
    pub fn score(&self) -> ObjectScore {
        let tilt_rad = (self.truth.rotation_xyzw * DVec3::Z).angle_between(DVec3::Z);
        let wrong_side = self.wrong_side();
        let turn_deg = twist_rad(self.placed_from_rendered()).to_degrees();
        let yaw_status = match () {
            () if self.truth.symmetry_order == 0 => YawStatus::OrderZero,
            () if tilt_rad > LEANING_RAD => YawStatus::Leaning,
            () if self.indistinguishable.is_any() => YawStatus::AnyIndistinguishable,
            () if self.only_texture_tells => YawStatus::OnlyTextureTells,
            () => YawStatus::Scored,
        };
        let placed_turn_deg =
            twist_rad(self.placed_rotation() * self.query_rotation().inverse()).to_degrees();
        let yaw_error_deg = self.indistinguishable.distance_deg(placed_turn_deg);
        let has_yaw = matches!(yaw_status, YawStatus::Scored | YawStatus::OnlyTextureTells);
        let off_m = self.placed.world_from_object.translation_m - self.truth.translation_m;
        ObjectScore {
            name: self.truth.name.clone(),
            category: self.category.to_owned(),
            contained: self.supporter.is_container(),
            stacked: self.supporter.parent.is_some() && !self.supporter.is_container(),
            tilt_deg: tilt_rad.to_degrees(),
            yaw_status,
            yaw_error_deg: has_yaw.then_some(yaw_error_deg),
            turn_deg,
            wrong_side,
            position_error_m: (tilt_rad <= LEANING_RAD).then(|| off_m.truncate().length()),
            scale_error: (self.scale() - 1.0).abs(),
            visible_px: self.visible_px,
            visible_share: self.visible_share,
            indistinguishable: self.indistinguishable.intervals(),
            estimated_order: self.yaw.symmetry_order,
            confidence: self.yaw.confidence,
            loss: self.yaw.loss,
            upright_confidence: self.canonical.confidence,
        }
    }
}

/// Rotation of an object that stands on the side given by `canonical_from_rendered`, with its frame in the heading
/// of `rendered`. Indistinguishable yaws are then whole degrees apart for objects that appear equal from both
/// sides.
fn in_heading_of(rendered: DQuat, canonical_from_rendered: DQuat) -> DQuat {
    DQuat::from_rotation_z(twist_rad(rendered)) * canonical_from_rendered
}

/// Twist about +z, in (-pi, pi].
fn twist_rad(rotation: DQuat) -> f64 {
    geometry::pose::wrap_angle_rad(2.0 * rotation.z.atan2(rotation.w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::indistinguishable_yaws::{RenderedScene, indistinguishable_yaws};
    use catalog::{Recipe, build, build_table, category};
    use geometry::{Camera, Pose};
    use render::RenderObject;
    use runtime::CancelFlag;

    #[test]
    fn upside_down_nut_is_indistinguishable_every_sixty_degrees() {
        // Regression: with whole-degree steps from the placed yaw, half a degree off, no yaw matched.
        let size_m = category("nut").expect("known").size.typical_m();
        let recipe = Recipe { category: "nut".into(), size_m, color: None, material: None, seed: 5 };
        let nut = build(&recipe).expect("builds");
        let table = build_table("desk", DVec3::new(1.0, 0.6, 0.74), None, None, 1).expect("a desk").mesh;
        let rendered = Pose::upright(DVec3::new(0.1, 0.05, 0.0), 0.4321);
        let objects = vec![
            RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 },
            RenderObject { mesh: &nut, world_from_object: rendered, id: 2 },
        ];
        let camera = Camera::orbit(960, 720, 0.61, DVec3::ZERO, 0.1, 0.8, 1.6);
        let upside_down = DQuat::from_rotation_x(std::f64::consts::PI);
        let rotation = in_heading_of(rendered.rotation, upside_down);
        let lift_m = nut.size_m().z * DVec3::Z;
        let start = Pose { translation_m: rendered.translation_m + lift_m, rotation };
        let scene = RenderedScene { camera, objects };
        let yaws = indistinguishable_yaws(&scene, 1, start, &CancelFlag::default()).expect("not interrupted");
        assert_eq!(yaws.intervals(), 6);
        assert!((0..6).all(|sixth| yaws.distance_deg(60.0 * f64::from(sixth)) <= 1.0));
    }
}
