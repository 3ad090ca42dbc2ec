//! Images of a demonstration: table, objects and robot in the light that was drawn.

use geometry::{Camera, DVec3, Pose, Rgb, TexturedMesh, Vec3};
use imaging::Image;
use manipulation::frames::{to_isometry, to_pose};
use manipulation::link_meshes::{floor_m, stand_mesh};
use render::{Background, Lighting, RenderObject, RenderSettings, SceneCache, View};
use robot::kinematics::{link_poses, tool_pose};

use crate::sample::Sample;
use crate::setup::{Setup, Work};

/// Without the sky's shadows, which cost most.
const QUALITY: RenderSettings =
    RenderSettings { supersampling: 2, shadow_map_px: 512, sky_directions: 0, sky_map_px: 32 };
/// Nothing is written that is farther away, meters.
const FAR_M: f32 = episodes::description::MAX_DEPTH_M;

/// What one camera sees.
pub(crate) struct CameraView {
    pub image: Image,
    /// Along the optical axis, meters; 0 where nothing is in sight. Empty if it is not recorded, as are the ids.
    pub depth_m: Vec<f32>,
    pub ids: Vec<u32>,
    pub intrinsics: [f64; 9],
    pub world_from_camera: [f64; 16],
}

/// What is shown of one demonstration.
pub(crate) struct Stage<'a> {
    setup: &'a Setup,
    work: &'a Work,
    sample: &'a Sample,
    /// The table first, then the objects, in their drawn colors.
    meshes: Vec<TexturedMesh>,
    stand: TexturedMesh,
    lighting: Lighting,
    background: Background,
    /// Whether depth or ids are wanted.
    measures: bool,
}

impl<'a> Stage<'a> {
    pub fn new(setup: &'a Setup, work: &'a Work, sample: &'a Sample) -> Self {
        let tints = std::iter::once(sample.table_tint).chain(sample.objects.iter().map(|object| object.tint));
        let meshes: Vec<TexturedMesh> =
            setup.meshes.iter().zip(tints).map(|(mesh, tint)| tinted(mesh, tint)).collect();
        let stand = stand_mesh(&meshes[0], &work.world_from_base);
        let base_m = work.world_from_base.translation_m;
        // From behind the cameras, which stand opposite to the robot.
        let facing_rad = (-base_m.x).atan2(base_m.y);
        let light = &sample.light;
        let elevation_rad = (0.95 + light.raise_rad).clamp(0.3, 1.5);
        let mut lighting = Lighting::studio(facing_rad - 0.7 + light.turn_rad, elevation_rad, 0.6);
        lighting.exposure = light.brightness_factor as f32;
        let mut background = Background::light_with_floor(floor_m(&meshes[0]));
        let tint: Vec3 = sample.backdrop_tint.into();
        background.top_color *= tint;
        background.bottom_color *= tint;
        let measures =
            setup.description.cameras().iter().any(|camera| camera.depth || camera.instance_ids.is_some());
        Self { setup, work, sample, meshes, stand, lighting, background, measures }
    }

    /// One image of each camera. `objects` are the names and poses of those present.
    pub fn images(
        &self,
        joint_positions_rad: &[f64],
        opening_m: f64,
        objects: &[(&str, Pose)],
    ) -> Vec<CameraView> {
        let setup = self.setup;
        if setup.cameras.is_empty() {
            return Vec::new();
        }
        let base = to_isometry(&self.work.world_from_base);
        let links = link_poses(&setup.robot, joint_positions_rad, opening_m);
        let robot_id = setup.scene.objects.len() as u32 + 2;
        let table = std::iter::once((&self.meshes[0], Pose::IDENTITY, 1));
        let posed = objects.iter().filter_map(|(name, pose)| {
            let index = setup.scene.index(name)?;
            Some((&self.meshes[index + 1], *pose, index as u32 + 2))
        });
        let arm = setup
            .link_meshes
            .iter()
            .zip(&links)
            .map(|(mesh, pose)| (mesh, to_pose(&(base * pose)), robot_id));
        let shown = table.chain(posed).chain([(&self.stand, Pose::IDENTITY, robot_id)]).chain(arm);
        let shown = shown.filter(|(mesh, ..)| !mesh.positions.is_empty());
        let shown = shown.map(|(mesh, world_from_object, id)| RenderObject { mesh, world_from_object, id });
        let cache = SceneCache::new(shown.collect(), &QUALITY);
        let world_from_tool = to_pose(&(base * tool_pose(&setup.robot, joint_positions_rad)));
        let cameras = setup.cameras.iter().zip(&self.sample.cameras);
        cameras
            .map(|(spec, sample)| {
                let camera = spec.posed(sample, &world_from_tool);
                let view = View::Perspective(camera);
                let (image, depth_m, ids) = match self.measures {
                    true => {
                        let frame = cache.render(self.lighting, self.background, &view);
                        (frame.color, frame.depth_m.iter().map(in_sight_m).collect(), frame.ids)
                    }
                    false => (cache.color(self.lighting, self.background, &view), Vec::new(), Vec::new()),
                };
                let world_from_camera = matrix(&camera.world_from_camera);
                CameraView { image, depth_m, ids, intrinsics: intrinsics(&camera), world_from_camera }
            })
            .collect()
    }
}

/// Depth, or 0 where nothing is in sight.
fn in_sight_m(depth_m: &f32) -> f32 {
    if *depth_m <= FAR_M { *depth_m } else { 0.0 }
}

fn tinted(mesh: &TexturedMesh, tint: [f32; 3]) -> TexturedMesh {
    let mut tinted = mesh.clone();
    for material in &mut tinted.materials {
        let Rgb(color) = material.base_color;
        material.base_color =
            Rgb(std::array::from_fn(|channel| (color[channel] * tint[channel]).clamp(0.0, 1.0)));
    }
    tinted
}

fn intrinsics(camera: &Camera) -> [f64; 9] {
    [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
}

fn matrix(pose: &Pose) -> [f64; 16] {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| pose.transform_vector(axis));
    let t = pose.translation_m;
    [x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z, 0.0, 0.0, 0.0, 1.0]
}
