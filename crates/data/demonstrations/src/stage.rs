//! Images of a demonstration: table, objects and robot in the light that was drawn.

use geometry::{Camera, DVec3, Pose, Rgb, TexturedMesh, Vec3};
use imaging::Image;
use manipulation::execution::{Frame, Recording};
use manipulation::frames::{to_isometry, to_pose};
use manipulation::link_meshes::{floor_m, stand_mesh};
use nalgebra::Isometry3;
use render::sequence::StillLayer;
use render::{Background, ImageSequence, Lighting, RenderObject, RenderSettings, View};
use robot::kinematics::{link_poses, tool_pose};

use crate::camera::Mount;
use crate::finish::{refinished_object, refinished_table};
use crate::sample::Sample;
use crate::setup::{Setup, Work};

/// Objects that move by less during a demonstration are shown at rest, meters and radians.
const STILL_M: f64 = 1e-4;
const STILL_RAD: f64 = 2e-3;
/// Largest depth that is written, meters.
const FAR_M: f32 = episodes::description::MAX_DEPTH_M;

/// Image and measurements of one camera.
pub(crate) struct CameraView {
    pub image: Image,
    /// Along the optical axis, meters; 0 where nothing is in sight. Empty if it is not recorded, as are the ids.
    pub depth_m: Vec<f32>,
    pub ids: Vec<u32>,
    pub intrinsics: [f64; 9],
    pub world_from_camera: [f64; 16],
}

/// Visible content of one demonstration: the scene in its drawn colors, and the light.
pub(crate) struct Props {
    /// The table first, then the objects.
    meshes: Vec<TexturedMesh>,
    stand: TexturedMesh,
    lighting: Lighting,
    background: Background,
}

impl Props {
    pub fn new(setup: &Setup, work: &Work, sample: &Sample) -> Self {
        let table = refinished_table(setup.meshes[0].clone(), sample.table_finish.as_ref());
        let objects = setup.meshes[1..].iter().zip(&sample.objects).map(|(mesh, drawn)| {
            let finish = drawn.finish.as_ref().filter(|_| drawn.present);
            tinted(refinished_object(mesh.clone(), finish), drawn.tint)
        });
        let meshes: Vec<TexturedMesh> =
            std::iter::once(tinted(table, sample.table_tint)).chain(objects).collect();
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
        Self { meshes, stand, lighting, background }
    }
}

/// The cameras of one demonstration and what they see, frame by frame.
pub(crate) struct Stage<'a> {
    setup: &'a Setup,
    sample: &'a Sample,
    world_from_base: Isometry3<f64>,
    sequence: ImageSequence<'a>,
    /// Indices of the moving ones of [`Stage::parts`], in the order of the sequence.
    moving: Vec<usize>,
    /// Of each camera that is fixed to the world.
    layers: Vec<Option<StillLayer>>,
    /// Whether depth, ids or points are wanted.
    measures: bool,
}

/// An object or a link of the robot at a time.
struct Part<'a> {
    mesh: &'a TexturedMesh,
    world_from_part: Pose,
    id: u32,
}

impl<'a> Stage<'a> {
    /// A stage for these frames of a recording. Objects that hardly move in them are shown where they are at first.
    pub fn new(
        setup: &'a Setup,
        work: &Work,
        sample: &'a Sample,
        props: &'a Props,
        recording: &Recording,
        frames: &[Frame],
    ) -> Self {
        let world_from_base = to_isometry(&work.world_from_base);
        let of_frame = |frame: &Frame| parts(setup, props, &world_from_base, recording, frame);
        let first = frames.first().map(of_frame).unwrap_or_default();
        let mut moves = vec![false; first.len()];
        for frame in frames {
            for ((moves, part), now) in moves.iter_mut().zip(&first).zip(of_frame(frame)) {
                *moves |= is_elsewhere(&part.world_from_part, &now.world_from_part);
            }
        }
        let shown = |part: &Part<'a>| RenderObject {
            mesh: part.mesh,
            world_from_object: part.world_from_part,
            id: part.id,
        };
        let of = |wanted: bool| {
            moves.iter().enumerate().filter(move |(_, moves)| **moves == wanted).map(|(k, _)| k)
        };
        let table = RenderObject { mesh: &props.meshes[0], world_from_object: Pose::IDENTITY, id: 1 };
        let stand =
            RenderObject { mesh: &props.stand, world_from_object: Pose::IDENTITY, id: robot_id(setup) };
        let still = [table, stand].into_iter().chain(of(false).map(|index| shown(&first[index])));
        let still = still.filter(|object| !object.mesh.positions.is_empty()).collect();
        let moving: Vec<usize> = of(true).collect();
        let moved = moving.iter().map(|index| shown(&first[*index])).collect();
        let side_px = setup.cameras.iter().map(|camera| camera.width_px.max(camera.height_px)).max();
        // Finer shadows than pixels would not show.
        let shadow_map_px = RenderSettings::MOTION.shadow_map_px.min(side_px.unwrap_or_default());
        let settings = RenderSettings { shadow_map_px, ..RenderSettings::MOTION };
        let sequence = ImageSequence::new(still, moved, props.lighting, props.background, &settings);
        let layers = setup.cameras.iter().zip(&sample.cameras).map(|(camera, sample)| {
            let is_fixed = camera.mount == Mount::World;
            is_fixed.then(|| sequence.still_layer(&View::Perspective(camera.posed(sample, &Pose::IDENTITY))))
        });
        let layers = layers.collect();
        let description = &setup.description;
        let measures = description.points().is_some()
            || description.cameras().iter().any(|camera| camera.depth || camera.instance_ids.is_some());
        Self { setup, sample, world_from_base, sequence, moving, layers, measures }
    }

    /// One image of each camera at a frame.
    pub fn images(&mut self, props: &Props, recording: &Recording, frame: &Frame) -> Vec<CameraView> {
        let Self { setup, sample, world_from_base, .. } = self;
        let parts = parts(setup, props, world_from_base, recording, frame);
        let poses: Vec<Pose> = self.moving.iter().map(|index| parts[*index].world_from_part).collect();
        self.sequence.move_to(&poses);
        let world_from_tool = to_pose(&(*world_from_base * tool_pose(&setup.robot, &frame.joint_positions)));
        let cameras = setup.cameras.iter().zip(&sample.cameras).zip(&mut self.layers);
        let views = cameras.map(|((spec, sample), layer)| {
            let camera = spec.posed(sample, &world_from_tool);
            let view = View::Perspective(camera);
            let sequence = &self.sequence;
            let (image, depth_m, ids) = match (self.measures, layer) {
                (false, Some(layer)) => (sequence.color_over(layer), Vec::new(), Vec::new()),
                (false, None) => (sequence.color(&view), Vec::new(), Vec::new()),
                (true, layer) => {
                    let frame = match layer {
                        Some(layer) => sequence.render_over(layer),
                        None => sequence.render(&view),
                    };
                    (frame.color, frame.depth_m.iter().map(in_sight_m).collect(), frame.ids)
                }
            };
            let world_from_camera = matrix(&camera.world_from_camera);
            CameraView { image, depth_m, ids, intrinsics: intrinsics(&camera), world_from_camera }
        });
        views.collect()
    }
}

/// The objects that are present and the links of the robot, in an order that is the same in all frames.
fn parts<'a>(
    setup: &'a Setup,
    props: &'a Props,
    world_from_base: &Isometry3<f64>,
    recording: &Recording,
    frame: &Frame,
) -> Vec<Part<'a>> {
    let objects = recording.objects.iter().zip(&frame.object_poses).filter_map(|(name, pose)| {
        let index = setup.scene.index(name)?;
        Some(Part { mesh: &props.meshes[index + 1], world_from_part: *pose, id: index as u32 + 2 })
    });
    let links = link_poses(&setup.robot, &frame.joint_positions, frame.opening_m);
    let links = setup.link_meshes.iter().zip(links).map(|(mesh, base_from_link)| {
        let world_from_part = to_pose(&(world_from_base * base_from_link));
        Part { mesh, world_from_part, id: robot_id(setup) }
    });
    objects.chain(links).filter(|part| !part.mesh.positions.is_empty()).collect()
}

fn robot_id(setup: &Setup) -> u32 {
    setup.scene.objects.len() as u32 + 2
}

/// Whether a pose is more than a hair's breadth from another.
fn is_elsewhere(a: &Pose, b: &Pose) -> bool {
    a.translation_m.distance(b.translation_m) > STILL_M || a.rotation.angle_between(b.rotation) > STILL_RAD
}

/// Depth, or 0 where nothing is in sight.
fn in_sight_m(depth_m: &f32) -> f32 {
    if *depth_m <= FAR_M { *depth_m } else { 0.0 }
}

fn tinted(mut mesh: TexturedMesh, tint: [f32; 3]) -> TexturedMesh {
    for material in &mut mesh.materials {
        let Rgb(color) = material.base_color;
        material.base_color =
            Rgb(std::array::from_fn(|channel| (color[channel] * tint[channel]).clamp(0.0, 1.0)));
    }
    mesh
}

fn intrinsics(camera: &Camera) -> [f64; 9] {
    [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
}

fn matrix(pose: &Pose) -> [f64; 16] {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| pose.transform_vector(axis));
    let t = pose.translation_m;
    [x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z, 0.0, 0.0, 0.0, 1.0]
}
