//! `mjcf/scene.xml`: the scene for MuJoCo, and `mjcf/<name>/<name>.xml`: each object for loaders of robosuite's kind.
//!
//! World frame of the scene (table top at z = 0, floor plane at -height). Every movable body has a free joint and an
//! explicit inertial frame; collision shapes are in geom group 3, visual meshes in group 2 without contact. Hulls are
//! files, as Drake's reader of MJCF ignores lists of vertices; what is a box, cylinder, sphere or capsule is one.
//! Friction is sliding (the dynamic coefficient), torsional and rolling, so contacts have six dimensions; the cone is
//! elliptic and several contact points per pair are on, without which cups creep by a centimeter in seconds. They are
//! those of libccd: of MuJoCo's own, version 3.3.0 loses some between flat faces, and coins and coasters slide away.
//! Contacts are the stiffest that the step allows ([`CONTACT_STEPS`]).
//!
//! The file of an object holds the body `object` without a joint, which loaders add, and beside it the sites that they
//! place it by: `bottom_site`, `top_site` and `horizontal_radius_site`. Its collision shapes are in group 0, its visual
//! meshes in group 1, as such loaders expect. Paths are relative to the file. The file of a stand-in also holds its
//! texts.

use rayon::prelude::*;

use glam::{DQuat, DVec3};

use geometry::{Material, Pose, SimpleSolid, SimpleSolidKind};
use scene::Scene;

use super::number::spaced;
use super::sun::Sun;
use super::wavefront::Wavefront;
use super::{Body, BundleFile, ExportSettings};
use markup::xml::XmlDocument;

/// Name prefix of the text entries that hold the user's labels.
pub const LABEL_PREFIX: &str = "label_";

/// Time constant of contacts in steps; MuJoCo accepts no fewer. An object sinks by gravity times the square of that
/// time, times the number of objects that it carries: a sixth of a millimeter each at 2 ms, less than a tenth of a
/// coin. With MuJoCo's default of 20 ms, the coins of a stack sink by 12 mm into each other and towers fall.
const CONTACT_STEPS: f64 = 2.0;

/// `mjcf/scene.xml` and its meshes and textures under `mjcf/assets/`.
pub fn write(
    scene: &Scene,
    bodies: &[Body],
    wavefronts: &[Wavefront],
    settings: &ExportSettings,
) -> Vec<BundleFile> {
    let both = bodies.par_iter().zip(wavefronts);
    let mut files: Vec<BundleFile> = both.flat_map_iter(|(body, obj)| asset_files(body, obj)).collect();
    files.extend(bodies.iter().filter(|body| body.movable).map(|body| object_file(body, settings)));
    let text = scene_xml(scene, bodies, settings);
    files.push(BundleFile::text("mjcf/scene.xml", text, "mjcf_scene", "application/xml"));
    files
}

fn asset_files(body: &Body, wavefront: &Wavefront) -> Vec<BundleFile> {
    let mut files = Vec::new();
    for (k, group) in body.visual.groups.iter().enumerate() {
        let material = &body.visual.materials[group.material];
        let path = format!("mjcf/assets/{}", mesh_file(body, material));
        files.push(BundleFile::text(path, wavefront.plain_visual(k), "mjcf_visual", "model/obj"));
        if let Some(png) = wavefront.texture(group.material) {
            let path = format!("mjcf/assets/{}", texture_file(body, material));
            files.push(BundleFile::png(path, png.to_vec(), "mjcf_texture"));
        }
    }
    for k in body.mesh_hulls() {
        let path = format!("mjcf/assets/{}", hull_file(body, k));
        files.push(BundleFile::text(path, wavefront.hull(k).to_owned(), "mjcf_hull", "model/obj"));
    }
    files
}

fn mesh_file(body: &Body, material: &Material) -> String {
    format!("{}_{}.obj", body.name, material.name)
}

fn hull_file(body: &Body, k: usize) -> String {
    format!("hulls/{}_{k:02}.obj", body.name)
}

fn texture_file(body: &Body, material: &Material) -> String {
    format!("{}_{}.png", body.name, material.name)
}

/// The file of one object, its frame that of the object.
fn object_file(body: &Body, settings: &ExportSettings) -> BundleFile {
    let mut document = XmlDocument::new();
    document.open("mujoco", &[("model", &body.name)]);
    document.empty("compiler", &[("angle", "radian")]);
    if body.stand_in.is_some() {
        document.open("custom", &[]);
        write_texts(&mut document, body);
        document.close();
    }
    document.open("asset", &[]);
    write_assets(&mut document, body, "../assets/");
    document.close();
    document.open("worldbody", &[]);
    document.open("body", &[]);
    document.open("body", &[("name", "object")]);
    write_shapes(&mut document, body, Groups { visual: "1", hulls: "0" }, settings);
    document.close();
    let (low, high) = body.visual.bounds();
    let radius_m = body.visual.positions.iter().map(|p| p.truncate().length()).fold(0.0, f64::max);
    for (name, position) in [
        ("bottom_site", DVec3::new(0.0, 0.0, low.z)),
        ("top_site", DVec3::new(0.0, 0.0, high.z)),
        ("horizontal_radius_site", DVec3::new(radius_m, 0.0, 0.0)),
    ] {
        let position = spaced(&position.to_array());
        document.empty("site", &[("name", name), ("pos", &position), ("size", "0.005"), ("rgba", "0 0 0 0")]);
    }
    let path = format!("mjcf/{0}/{0}.xml", body.name);
    BundleFile::text(path, document.finish(), "mjcf_object", "application/xml")
}

fn scene_xml(scene: &Scene, bodies: &[Body], settings: &ExportSettings) -> String {
    let mut document = XmlDocument::new();
    document.open("mujoco", &[("model", &format!("scene_{}", scene.id))]);
    document.empty("compiler", &[("angle", "radian"), ("meshdir", "assets"), ("texturedir", "assets")]);
    document.open(
        "option",
        &[
            ("timestep", &spaced(&[settings.mujoco_timestep_s])),
            ("gravity", &spaced(&[0.0, 0.0, -settings.gravity_m_s2])),
            ("integrator", "implicitfast"),
            ("cone", "elliptic"),
            ("impratio", &spaced(&[settings.mujoco_impratio])),
        ],
    );
    document.empty("flag", &[("multiccd", "enable"), ("nativeccd", "disable")]);
    document.close();
    let extent_m = scene.table.size_m.truncate().length();
    document.empty("statistic", &[("center", "0 0 0.1"), ("extent", &spaced(&[extent_m]))]);
    document.open("visual", &[]);
    document.empty(
        "global",
        &[
            ("offwidth", &scene.camera.width_px.to_string()),
            ("offheight", &scene.camera.height_px.to_string()),
        ],
    );
    document.empty("headlight", &[("ambient", "0.35 0.35 0.35"), ("diffuse", "0.35 0.35 0.35")]);
    document.close();
    document.open("custom", &[]);
    for body in bodies {
        write_texts(&mut document, body);
    }
    document.close();
    document.open("asset", &[]);
    for body in bodies {
        write_assets(&mut document, body, "");
    }
    document.close();
    document.open("worldbody", &[]);
    let Sun { position_m, direction, brightness } = Sun::of(scene, 0.6);
    let sun = [("name", "sun"), ("pos", &*position_m), ("dir", &*direction), ("diffuse", &*brightness)];
    document.empty("light", &sun);
    write_camera(&mut document, scene);
    let floor = spaced(&[0.0, 0.0, -scene.table.height_m]);
    document.empty(
        "geom",
        &[
            ("name", "floor"),
            ("type", "plane"),
            ("pos", &floor),
            ("size", "5 5 0.1"),
            ("condim", "6"),
            ("solref", &solref(settings)),
            ("rgba", "0.82 0.82 0.8 1"),
        ],
    );
    for body in bodies {
        write_body(&mut document, body, settings);
    }
    document.finish()
}

/// Time constant and damping ratio of contacts; 1 is critical.
fn solref(settings: &ExportSettings) -> String {
    spaced(&[CONTACT_STEPS * settings.mujoco_timestep_s, 1.0])
}

/// The label, or the name if the label is empty, as MuJoCo rejects empty text; and the mark of a stand-in.
fn write_texts(document: &mut XmlDocument, body: &Body) {
    let label = if body.label.is_empty() { &body.name } else { &body.label };
    document.empty("text", &[("name", &format!("{LABEL_PREFIX}{}", body.name)), ("data", label)]);
    for (mark, value) in body.marks() {
        document.empty("text", &[("name", &format!("{mark}_{}", body.name)), ("data", value)]);
    }
}

/// Materials, meshes and hulls; files lie in `folder`, which is empty where the document's mesh directory is theirs.
fn write_assets(document: &mut XmlDocument, body: &Body, folder: &str) {
    for material in &body.visual.materials {
        let name = format!("{}_{}", body.name, material.name);
        if material.base_color_texture.is_some() {
            let file = format!("{folder}{}", texture_file(body, material));
            document.empty("texture", &[("name", &name), ("type", "2d"), ("file", &file)]);
        }
        let [r, g, b] = material.base_color.0.map(f64::from);
        let rgba = spaced(&[r, g, b, f64::from(material.opacity)]);
        let gloss = f64::from(1.0 - material.roughness);
        let specular = spaced(&[gloss * 0.5 + 0.3 * f64::from(material.metalness) * gloss]);
        let shininess = spaced(&[gloss * gloss]);
        let mut attributes = vec![
            ("name", name.as_str()),
            ("rgba", &rgba),
            ("specular", &specular),
            ("shininess", &shininess),
        ];
        if material.base_color_texture.is_some() {
            attributes.push(("texture", &name));
        }
        document.empty("material", &attributes);
    }
    for group in &body.visual.groups {
        let material = &body.visual.materials[group.material];
        let name = format!("{}_visual_{}", body.name, material.name);
        // The inertia of meshes is not used; shells need not enclose a volume.
        let file = format!("{folder}{}", mesh_file(body, material));
        document.empty("mesh", &[("name", &name), ("inertia", "shell"), ("file", &file)]);
    }
    for k in body.mesh_hulls() {
        let name = format!("{}_hull_{k:02}", body.name);
        let file = format!("{folder}{}", hull_file(body, k));
        document.empty("mesh", &[("name", &name), ("inertia", "shell"), ("file", &file)]);
    }
}

fn write_body(document: &mut XmlDocument, body: &Body, settings: &ExportSettings) {
    let pose = &body.world_from_object;
    let position = spaced(&pose.translation_m.to_array());
    document.open("body", &[("name", &body.name), ("pos", &position), ("quat", &quaternion(pose.rotation))]);
    if body.movable {
        document.empty("freejoint", &[("name", &format!("{}_free", body.name))]);
    }
    write_shapes(document, body, Groups { visual: "2", hulls: "3" }, settings);
    document.close();
}

/// Groups of geoms.
struct Groups {
    visual: &'static str,
    hulls: &'static str,
}

/// Inertia, visual meshes and collision shapes of the open body.
fn write_shapes(document: &mut XmlDocument, body: &Body, groups: Groups, settings: &ExportSettings) {
    document.empty(
        "inertial",
        &[
            ("pos", &spaced(&body.mass.center_of_mass_m.to_array())),
            ("quat", &quaternion(body.mass.principal_axes_xyzw.normalize())),
            ("mass", &spaced(&[body.mass.mass_kg])),
            ("diaginertia", &spaced(&body.mass.inertia_diagonal_kg_m2.to_array())),
        ],
    );
    for group in &body.visual.groups {
        let material = &body.visual.materials[group.material].name;
        document.empty(
            "geom",
            &[
                ("name", &format!("{}_visual_{material}", body.name)),
                ("type", "mesh"),
                ("mesh", &format!("{}_visual_{material}", body.name)),
                ("material", &format!("{}_{material}", body.name)),
                ("group", groups.visual),
                ("contype", "0"),
                ("conaffinity", "0"),
                ("mass", "0"),
            ],
        );
    }
    let friction =
        spaced(&[body.friction.dynamic_coefficient, body.torsional_friction_m, body.rolling_friction_m]);
    let solref = solref(settings);
    for (k, solid) in body.solids.iter().enumerate() {
        let name = format!("{}_hull_{k:02}", body.name);
        let shape = solid.as_ref().map_or_else(
            || vec![("type", "mesh".to_owned()), ("mesh", name.clone())],
            |solid| solid_attributes(solid).into(),
        );
        let mut attributes = vec![("name", name.as_str())];
        attributes.extend(shape.iter().map(|(key, value)| (*key, value.as_str())));
        attributes.extend([
            ("group", groups.hulls),
            ("condim", "6"),
            ("friction", friction.as_str()),
            ("solref", solref.as_str()),
            ("rgba", "0.2 0.7 0.3 0.4"),
        ]);
        document.empty("geom", &attributes);
    }
}

/// Type, size and place of a geom that is no mesh.
fn solid_attributes(solid: &SimpleSolid) -> [(&'static str, String); 4] {
    let (kind, size) = match solid.kind {
        SimpleSolidKind::Box { half_m } => ("box", spaced(&half_m.to_array())),
        SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
            ("cylinder", spaced(&[radius_m, half_length_m]))
        }
        SimpleSolidKind::Sphere { radius_m } => ("sphere", spaced(&[radius_m])),
        SimpleSolidKind::Capsule { radius_m, half_length_m } => {
            ("capsule", spaced(&[radius_m, half_length_m]))
        }
    };
    let Pose { translation_m, rotation } = solid.object_from_solid;
    [
        ("type", kind.to_owned()),
        ("size", size),
        ("pos", spaced(&translation_m.to_array())),
        ("quat", quaternion(rotation)),
    ]
}

fn write_camera(document: &mut XmlDocument, scene: &Scene) {
    let camera = &scene.camera;
    // MuJoCo cameras view along -z with +y up; ours view along +z with +y down.
    let rotation = camera.world_from_camera.rotation * DQuat::from_rotation_x(std::f64::consts::PI);
    // `fovy` is in degrees, independent of the compiler element.
    let fov_y_rad = 2.0 * (0.5 * f64::from(camera.height_px) / camera.fy).atan();
    let position: DVec3 = camera.world_from_camera.translation_m;
    document.empty(
        "camera",
        &[
            ("name", "reference_camera"),
            ("pos", &spaced(&position.to_array())),
            ("quat", &quaternion(rotation.normalize())),
            ("fovy", &spaced(&[fov_y_rad.to_degrees()])),
        ],
    );
}

/// A quaternion in MuJoCo's order: w, x, y, z.
fn quaternion(q: DQuat) -> String {
    spaced(&[q.w, q.x, q.y, q.z])
}
