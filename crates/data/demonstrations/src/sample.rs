//! Values that the randomization drew for one demonstration.

use geometry::{DVec3, Pose};
use rand::RngExt as _;
use runtime::seed::child_rng;
use serde::{Deserialize, Serialize};

use crate::arrangement;
use crate::distractors;
use crate::finish::{self, FinishSample};
use crate::randomization::Randomization;
use crate::setup::{Setup, Work};
use crate::spread::{factor, spread, tint};

/// Everything that was drawn; it is stated in the episode's record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// In the order of the scene's objects; the distractors after them.
    pub objects: Vec<ObjectSample>,
    /// Factors of the table's color.
    pub table_tint: [f32; 3],
    /// Another material of its top.
    pub table_finish: Option<FinishSample>,
    pub light: LightSample,
    /// Factors of the backdrop's color.
    pub backdrop_tint: [f32; 3],
    /// The joints of the arm at the start, radians.
    pub joint_positions_rad: Vec<f64>,
    /// In the order of the cameras.
    pub cameras: Vec<CameraSample>,
}

/// One object of a demonstration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectSample {
    pub name: String,
    pub present: bool,
    pub world_from_object: Pose,
    pub mass_factor: f64,
    pub friction_factor: f64,
    /// Factors of its color.
    pub tint: [f32; 3],
    /// Another material of most of it.
    pub finish: Option<FinishSample>,
}

/// The light of a demonstration, about its azimuth and elevation in [`render::Lighting::studio`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightSample {
    pub turn_rad: f64,
    pub raise_rad: f64,
    pub brightness_factor: f64,
}

/// Deviation of a camera, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraSample {
    pub offset_m: DVec3,
    /// A rotation vector.
    pub turn_rad: DVec3,
    pub focal_factor: f64,
}

impl Sample {
    /// Draws a sample; `None` if no free places were found for the objects.
    pub(crate) fn draw(setup: &Setup, work: &Work, ranges: &Randomization, seed: u64) -> Option<Self> {
        let rng = |axis: &str| child_rng(seed, axis);
        let mut present = {
            let mut rng = rng("absent_distractors");
            let absent: Vec<bool> =
                (0..setup.own_objects()).map(|_| rng.random::<f64>() < ranges.absent_distractors).collect();
            arrangement::present(setup, work, &absent)
        };
        let mut poses = arrangement::poses(setup, &present, ranges, &mut rng("position"))?;
        {
            let mut rng = rng("added_distractors");
            let count = distractors::count(&mut rng, ranges.added_distractors);
            let added = distractors::places(setup, work, &present, &poses, count, &mut rng);
            present.extend(added.iter().map(Option::is_some));
            poses.extend(added.into_iter().map(|pose| pose.unwrap_or(Pose::IDENTITY)));
        }
        let mut material = rng("object_material");
        let (mut mass, mut friction, mut color) = (rng("mass"), rng("friction"), rng("object_color"));
        let objects = setup.scene.objects.iter().zip(present).zip(poses);
        let objects = objects.zip(&setup.is_of_one_color);
        let objects = objects.map(|(((object, present), world_from_object), is_of_one_color)| ObjectSample {
            name: object.name.clone(),
            present,
            world_from_object,
            mass_factor: factor(&mut mass, ranges.mass),
            friction_factor: factor(&mut friction, ranges.friction),
            tint: tint(&mut color, ranges.object_color),
            finish: finish::of_object(&mut material, ranges.object_material).filter(|_| *is_of_one_color),
        });
        let objects = objects.collect();
        let light = {
            let mut rng = rng("light");
            LightSample {
                turn_rad: spread(&mut rng, ranges.light_direction_rad),
                raise_rad: spread(&mut rng, 0.5 * ranges.light_direction_rad),
                brightness_factor: factor(&mut rng, ranges.light_brightness),
            }
        };
        let cameras = setup.cameras.iter().map(|camera| {
            let mut rng = rng(&format!("camera {}", camera.name));
            let mut vector = |amplitude| {
                let [x, y, z] = [(); 3].map(|()| spread(&mut rng, amplitude));
                DVec3::new(x, y, z)
            };
            let (offset_m, turn_rad) = (vector(ranges.camera_position_m), vector(ranges.camera_angle_rad));
            CameraSample { offset_m, turn_rad, focal_factor: factor(&mut rng, ranges.focal_length) }
        });
        let cameras = cameras.collect();
        let mut start = rng("start");
        let joints = setup.robot.home().positions.iter().zip(setup.robot.limits());
        let joints = joints.map(|(home, limits)| {
            let drawn_rad = home + spread(&mut start, ranges.start_rad);
            drawn_rad.clamp(limits.min_position, limits.max_position)
        });
        Some(Self {
            objects,
            table_tint: tint(&mut rng("table_color"), ranges.table_color),
            table_finish: finish::of_table(&mut rng("table_material"), ranges.table_material)
                .filter(|_| setup.is_table_of_catalog),
            light,
            backdrop_tint: tint(&mut rng("backdrop"), ranges.backdrop_color),
            joint_positions_rad: joints.collect(),
            cameras,
        })
    }
}
