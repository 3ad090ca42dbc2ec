//! How far the layout lies from what was painted, object by object.
//!
//! Compared is the layout of `place`, before anything is repaired, with the settled poses of the painting:
//!
//! - *yaw*: the rotation that takes the painted pose to the placed one, its twist about world +z, as a distance to the
//!   nearest yaw that looks the same in the true picture ([`super::look_alikes`]). Where the mesh was stood on another
//!   side than the painted one stands on, the yaws are those of the mesh as it was stood (a nut looks the same upside
//!   down), and 180 degrees where none looks the same;
//! - *position*: horizontal distance between the origins of the two objects' frames (the center of the bottom face of
//!   the mesh's own box), world frame, meters;
//! - *scale*: `|s - 1|` with `s` the cube root of the ratio of the volumes of the placed and the painted mesh's box.
//!
//! Not every object has a yaw, or one that could be known: see [`Standing`]. What leans has no position of its own
//! either, since the stages place what they take to stand upright; its scale counts.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::look_alikes::LookAlikes;
use ports::TruthInstance;
use scene::{InstanceId, StandsOn};
use tabletopgen::pipeline::canonicalize;
use tabletopgen::pipeline::place::PlacedInstance;
use tabletopgen::pipeline::rotate;

/// An object leans where its own vertical is farther than this from the world's, radians.
pub const LEANING_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// A mesh stands on another side where its vertical is farther than this from the painted one's, radians.
const WRONG_SIDE_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Whether an object's yaw is scored, or why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    Scored,
    /// Its kind has rotational symmetry of order 0: any yaw is right.
    OrderZero,
    /// It leans or lies tilted (a pen in a holder), so that its pose is not a yaw.
    Leaning,
    /// Its kind has a front, but every yaw looks the same in the true picture.
    AnyLooksTheSame,
    /// Nothing but pictures on it tells its yaw to within 10 degrees (a printed coaster, a labeled bottle): once every
    /// material has one color, other yaws look the same; and the mesh that the stages get wears other pictures.
    OnlyPicturesTell,
}

/// One object of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectScore {
    pub name: InstanceId,
    pub category: String,
    /// Whether it lies or stands in a container, or on another object.
    pub contained: bool,
    pub stacked: bool,
    /// Of its own vertical from the world's as it was painted, degrees.
    pub tilt_deg: f64,
    pub standing: Standing,
    /// Where scored, or where only pictures tell it; degrees.
    pub yaw_error_deg: Option<f64>,
    /// Twist from the painted to the placed pose, degrees in (-180, 180], before look-alikes.
    pub turn_deg: f64,
    pub wrong_side: bool,
    /// Unless it leans, meters.
    pub position_error_m: Option<f64>,
    pub scale_error: f64,
    /// Pixels it shows, and their share of its whole silhouette.
    pub visible_px: usize,
    pub visible_share: f64,
    /// Separate stretches of yaws that look the same.
    pub look_alikes: usize,
    /// What the rotation optimizer said.
    pub estimated_order: u32,
    pub confidence: f64,
    pub loss: f64,
    /// How clearly its rotation to upright stood out.
    pub upright_confidence: f64,
}

/// Everything known of one object.
pub struct Compared<'a> {
    pub category: &'a str,
    pub truth: &'a TruthInstance,
    pub placed: &'a PlacedInstance,
    pub canonical: &'a canonicalize::Output,
    pub yaw: &'a rotate::Output,
    /// `raw_from_painted`.
    pub turned: DQuat,
    /// Turns from [`Self::look_from`].
    pub look_alikes: LookAlikes,
    /// Whether the mesh wears other pictures than what was painted and nothing else tells the yaw.
    pub only_pictures_tell: bool,
    pub visible_px: usize,
    pub visible_share: f64,
}

impl Compared<'_> {
    /// Rotation of the placed object's painted frame in the world.
    fn placed_rotation(&self) -> DQuat {
        self.placed.world_from_object.rotation * self.canonical_from_painted()
    }

    fn canonical_from_painted(&self) -> DQuat {
        self.canonical.rotation_xyzw * self.turned
    }

    /// World rotation from the painted to the placed pose.
    fn placed_from_painted(&self) -> DQuat {
        self.placed_rotation() * self.truth.rotation_xyzw.inverse()
    }

    /// Whether it stands on another side than it was painted on.
    pub fn wrong_side(&self) -> bool {
        (self.placed_from_painted() * DVec3::Z).angle_between(DVec3::Z) > WRONG_SIDE_RAD
    }

    /// `world_from_painted` from which turns are counted: the true one, or, stood on another side, that side in the
    /// true heading.
    pub fn look_from(&self) -> DQuat {
        let painted = self.truth.rotation_xyzw;
        if self.wrong_side() { in_heading_of(painted, self.canonical_from_painted()) } else { painted }
    }

    /// The yaw that `rotate` should have found: that of the canonical frame, radians.
    pub fn true_yaw_rad(&self) -> f64 {
        twist_rad(self.truth.rotation_xyzw * self.canonical_from_painted().inverse())
    }

    /// Placed over painted size, the cube root of the ratio of the boxes' volumes.
    pub fn scale(&self) -> f64 {
        (self.placed.size_m.element_product() / self.truth.size_m.element_product().max(1e-30)).cbrt()
    }

    /// The scores of the object.
    pub fn score(&self) -> ObjectScore {
        let tilt_rad = (self.truth.rotation_xyzw * DVec3::Z).angle_between(DVec3::Z);
        let wrong_side = self.wrong_side();
        let turn_deg = twist_rad(self.placed_from_painted()).to_degrees();
        let standing = match () {
            () if self.truth.symmetry_order == 0 => Standing::OrderZero,
            () if tilt_rad > LEANING_RAD => Standing::Leaning,
            () if self.look_alikes.is_any() => Standing::AnyLooksTheSame,
            () if self.only_pictures_tell => Standing::OnlyPicturesTell,
            () => Standing::Scored,
        };
        let looked_from_deg = twist_rad(self.placed_rotation() * self.look_from().inverse()).to_degrees();
        let yaw_error_deg = self.look_alikes.distance_deg(looked_from_deg);
        let has_yaw = matches!(standing, Standing::Scored | Standing::OnlyPicturesTell);
        let off_m = self.placed.world_from_object.translation_m - self.truth.translation_m;
        ObjectScore {
            name: self.truth.name.clone(),
            category: self.category.to_owned(),
            contained: matches!(self.placed.stands_on, StandsOn::In(_)),
            stacked: matches!(self.placed.stands_on, StandsOn::On(_)),
            tilt_deg: tilt_rad.to_degrees(),
            standing,
            yaw_error_deg: has_yaw.then_some(yaw_error_deg),
            turn_deg,
            wrong_side,
            position_error_m: (tilt_rad <= LEANING_RAD).then(|| off_m.truncate().length()),
            scale_error: (self.scale() - 1.0).abs(),
            visible_px: self.visible_px,
            visible_share: self.visible_share,
            look_alikes: self.look_alikes.stretches(),
            estimated_order: self.yaw.symmetry_order,
            confidence: self.yaw.confidence,
            loss: self.yaw.loss,
            upright_confidence: self.canonical.confidence,
        }
    }
}

/// An object stood on the side that `canonical_from_painted` turns down, its frame in the heading of `painted`: yaws that
/// look the same are then whole degrees away for what is the same from both sides.
fn in_heading_of(painted: DQuat, canonical_from_painted: DQuat) -> DQuat {
    DQuat::from_rotation_z(twist_rad(painted)) * canonical_from_painted
}

/// Twist about +z, in (-pi, pi].
fn twist_rad(rotation: DQuat) -> f64 {
    geometry::pose::wrap_angle_rad(2.0 * rotation.z.atan2(rotation.w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::look_alikes::{TrueScene, look_alikes};
    use catalog::{Recipe, build, build_table, category};
    use geometry::{Camera, Pose};
    use render::RenderObject;
    use runtime::Interrupt;

    #[test]
    fn a_nut_upside_down_looks_like_itself_at_every_sixth_of_a_turn() {
        // Turned on in whole degrees from where it was placed, half a degree off, none looked the same.
        let size_m = category("nut").expect("known").size.typical_m();
        let recipe = Recipe { category: "nut".into(), size_m, color: None, material: None, seed: 5 };
        let nut = build(&recipe).expect("builds");
        let table = build_table("desk", DVec3::new(1.0, 0.6, 0.74), None, None, 1).expect("a desk").mesh;
        let painted = Pose::upright(DVec3::new(0.1, 0.05, 0.0), 0.4321);
        let objects = vec![
            RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 },
            RenderObject { mesh: &nut, world_from_object: painted, id: 2 },
        ];
        let camera = Camera::orbit(960, 720, 0.61, DVec3::ZERO, 0.1, 0.8, 1.6);
        let upside_down = DQuat::from_rotation_x(std::f64::consts::PI);
        let rotation = in_heading_of(painted.rotation, upside_down);
        let lift_m = nut.size_m().z * DVec3::Z;
        let start = Pose { translation_m: painted.translation_m + lift_m, rotation };
        let scene = TrueScene { camera, objects };
        let alikes = look_alikes(&scene, 1, start, &Interrupt::default()).expect("not interrupted");
        assert_eq!(alikes.stretches(), 6);
        assert!((0..6).all(|sixth| alikes.distance_deg(60.0 * f64::from(sixth)) <= 1.0));
    }
}
