//! `scene.usda`: gravity, lights, the reference camera, the floor, and every prop at its pose.

use glam::{DQuat, DVec3};

use crate::export::{Body, ExportSettings};
use crate::geometry::Camera;
use crate::scene::Scene;

use super::asset_path;
use super::layer::{Layer, quoted, tuple};

/// Width of the USD camera's film in tenths of a scene unit; only its ratio to the focal length matters
/// to a pinhole.
const FILM_WIDTH: f64 = 20.955;

/// The text of `usd/scene.usda`.
pub fn write_stage(scene: &Scene, bodies: &[Body], settings: &ExportSettings) -> String {
    let mut layer = Layer::new("World", |layer| {
        layer.block("customLayerData", |layer| {
            layer.line(&format!("string scene = {}", quoted(&scene.id)));
        });
    });
    layer.prim("Xform", "World", &["kind = \"assembly\""], |layer| {
        layer.prim("PhysicsScene", "physics_scene", &[], |layer| {
            layer.line("vector3f physics:gravityDirection = (0, 0, -1)");
            layer.line(&format!("float physics:gravityMagnitude = {}", settings.gravity_m_s2));
        });
        for body in bodies {
            write_reference(layer, body);
        }
        write_floor(layer, scene);
        layer.prim("DomeLight", "sky", &[], |layer| {
            layer.line(&format!("float inputs:intensity = {}", settings.usd_dome_intensity));
        });
        layer.prim("DistantLight", "sun", &[], |layer| {
            layer.line("float inputs:angle = 2");
            layer.line(&format!("float inputs:intensity = {}", settings.usd_sun_intensity));
            write_pose(layer, DVec3::ZERO, DQuat::from_rotation_y(0.35) * DQuat::from_rotation_x(0.5));
        });
        write_camera(layer, &scene.camera);
    });
    layer.finish()
}

fn write_reference(layer: &mut Layer, body: &Body) {
    let reference = format!("prepend references = @./{}@", asset_path(&body.name));
    layer.prim("Xform", &body.name, &[&reference], |layer| {
        if !body.movable {
            layer.line("bool physics:rigidBodyEnabled = 0");
        }
        write_pose(layer, body.world_from_object.translation_m, body.world_from_object.rotation);
    });
}

fn write_pose(layer: &mut Layer, translation_m: DVec3, rotation: DQuat) {
    layer.line(&format!(
        "quatd xformOp:orient = {}",
        tuple(&[rotation.w, rotation.x, rotation.y, rotation.z])
    ));
    layer.line(&format!("double3 xformOp:translate = {}", tuple(&translation_m.to_array())));
    layer.line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]");
}

fn write_floor(layer: &mut Layer, scene: &Scene) {
    let metadata = ["prepend apiSchemas = [\"PhysicsCollisionAPI\", \"SemanticsLabelsAPI:class\"]"];
    layer.prim("Plane", "floor", &metadata, |layer| {
        layer.line("uniform token purpose = \"guide\"");
        layer.line("uniform token axis = \"Z\"");
        layer.line("double width = 10");
        layer.line("double length = 10");
        layer.line("float3[] extent = [(-5, -5, 0), (5, 5, 0)]");
        layer.line("token[] semantics:labels:class = [\"floor\"]");
        write_pose(layer, DVec3::new(0.0, 0.0, -scene.table.height_m), DQuat::IDENTITY);
    });
}

fn write_camera(layer: &mut Layer, camera: &Camera) {
    // USD cameras look along -z with +y up; ours along +z with +y down.
    let rotation = camera.world_from_camera.rotation * DQuat::from_rotation_x(std::f64::consts::PI);
    let (width, height) = (f64::from(camera.width_px), f64::from(camera.height_px));
    let per_pixel_x = FILM_WIDTH / width;
    let per_pixel_y = per_pixel_x * camera.fx / camera.fy;
    layer.prim("Camera", "reference_camera", &[], |layer| {
        layer.line("float2 clippingRange = (0.01, 100)");
        layer.line(&format!("float focalLength = {}", (camera.fx * per_pixel_x) as f32));
        layer.line(&format!("float horizontalAperture = {}", FILM_WIDTH as f32));
        layer.line(&format!("float verticalAperture = {}", (height * per_pixel_y) as f32));
        let offset_x = (0.5 * width - camera.cx) * per_pixel_x;
        let offset_y = (camera.cy - 0.5 * height) * per_pixel_y;
        layer.line(&format!("float horizontalApertureOffset = {}", (offset_x + 0.0) as f32));
        layer.line(&format!("float verticalApertureOffset = {}", (offset_y + 0.0) as f32));
        write_pose(layer, camera.world_from_camera.translation_m, rotation.normalize());
    });
}
