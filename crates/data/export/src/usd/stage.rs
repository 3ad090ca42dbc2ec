//! The stage: gravity, lights, the reference camera, the floor, and every prop at its pose.

use glam::{DQuat, DVec3};

use crate::{Body, ExportSettings};
use geometry::Camera;
use scene::Scene;

use super::layer::{Layer, Prim};
use super::value::{Dictionary, Value};

/// Width of the USD camera's film in tenths of a scene unit. A pinhole camera depends only on its ratio to the focal
/// length.
const FILM_WIDTH: f64 = 20.955;

/// The layer of the scene. `prop_path` returns the path of a body's layer, relative to this one.
pub fn stage(
    scene: &Scene,
    bodies: &[Body],
    settings: &ExportSettings,
    prop_path: impl Fn(&str) -> String,
) -> Layer {
    let mut world = Prim::new("Xform", "World");
    world.kind = Some("assembly");
    let mut physics = Prim::new("PhysicsScene", "physics_scene");
    physics.set("physics:gravityDirection", Value::Vector3f([0.0, 0.0, -1.0]));
    physics.set("physics:gravityMagnitude", Value::Float(settings.gravity_m_s2 as f32));
    world.add(physics);
    for body in bodies {
        world.add(placed(body, &prop_path(&body.name)));
    }
    world.add(floor(scene));
    let mut sky = Prim::new("DomeLight", "sky");
    sky.set("inputs:intensity", Value::Float(settings.usd_dome_intensity as f32));
    world.add(sky);
    let mut sun = Prim::new("DistantLight", "sun");
    sun.set("inputs:angle", Value::Float(2.0));
    let brightness = scene.light.map_or(1.0, |light| light.intensity);
    sun.set("inputs:intensity", Value::Float((brightness * settings.usd_sun_intensity) as f32));
    // A distant light shines along its -z axis.
    let rotation = match &scene.light {
        Some(light) => DQuat::from_rotation_arc(DVec3::Z, light.toward_light()),
        None => DQuat::from_rotation_y(0.35) * DQuat::from_rotation_x(0.5),
    };
    set_pose(&mut sun, DVec3::ZERO, rotation);
    world.add(sun);
    world.add(reference_camera(&scene.camera));
    Layer { custom_data: Dictionary::default().with("scene", Value::string(&scene.id)), root: world }
}

fn placed(body: &Body, prop_path: &str) -> Prim {
    let mut prim = Prim::new("Xform", &body.name);
    prim.reference = Some(prop_path.into());
    if !body.movable {
        prim.set("physics:rigidBodyEnabled", Value::Bool(false));
    }
    set_pose(&mut prim, body.world_from_object.translation_m, body.world_from_object.rotation);
    prim
}

fn set_pose(prim: &mut Prim, translation_m: DVec3, rotation: DQuat) {
    prim.set("xformOp:orient", Value::Quatd(rotation.into()));
    prim.set("xformOp:translate", Value::Double3(translation_m.to_array()));
    prim.set_uniform("xformOpOrder", Value::tokens(&["xformOp:translate", "xformOp:orient"]));
}

fn floor(scene: &Scene) -> Prim {
    let schemas = ["PhysicsCollisionAPI", "SemanticsLabelsAPI:class"];
    let mut prim = Prim::new("Plane", "floor").with_schemas(&schemas);
    prim.set_uniform("purpose", Value::token("guide"));
    prim.set_uniform("axis", Value::token("Z"));
    prim.set("width", Value::Double(10.0));
    prim.set("length", Value::Double(10.0));
    prim.set("extent", Value::Float3s(vec![[-5.0, -5.0, 0.0], [5.0, 5.0, 0.0]]));
    prim.set("semantics:labels:class", Value::tokens(&["floor"]));
    set_pose(&mut prim, DVec3::new(0.0, 0.0, -scene.table.height_m), DQuat::IDENTITY);
    prim
}

fn reference_camera(camera: &Camera) -> Prim {
    // USD cameras view along -z with +y up; ours view along +z with +y down.
    let rotation = camera.world_from_camera.rotation * DQuat::from_rotation_x(std::f64::consts::PI);
    let (width, height) = (f64::from(camera.width_px), f64::from(camera.height_px));
    let per_pixel_x = FILM_WIDTH / width;
    let per_pixel_y = per_pixel_x * camera.fx / camera.fy;
    let mut prim = Prim::new("Camera", "reference_camera");
    let mut set = |name: &str, value: f64| prim.set(name, Value::Float(value as f32));
    set("focalLength", camera.fx * per_pixel_x);
    set("horizontalAperture", FILM_WIDTH);
    set("verticalAperture", height * per_pixel_y);
    set("horizontalApertureOffset", (0.5 * width - camera.cx) * per_pixel_x);
    set("verticalApertureOffset", (camera.cy - 0.5 * height) * per_pixel_y);
    prim.set("clippingRange", Value::Float2([0.01, 100.0]));
    set_pose(&mut prim, camera.world_from_camera.translation_m, rotation.normalize());
    prim
}
