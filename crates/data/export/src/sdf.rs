//! `sdf/`: the scene as one SDFormat 1.9 world, and each body in a model folder of its own.
//!
//! World frame of the scene. Every hull is a `<collision>`: a mesh, or the box, cylinder, sphere or capsule that it
//! stands for; visual meshes have none. Inertia is the solid's full tensor about its center of mass. Friction is the
//! dynamic coefficient in both directions; resistance to spinning is given as a patch whose radius is that length, with
//! the coefficient that makes the torque radius times normal force. Mesh paths are relative to the file that names
//! them.
//!
//! A stand-in is marked by attributes of its `<model>` (`tabletopgen:stand_in`). Drake accepts it, and warns of
//! elements of a foreign namespace.
//!
//! Drake reads its own elements (`drake:proximity_properties`) beside these: objects are compliant and the table is
//! rigid in its hydroelastic contact, without which flat objects sink by millimeters a second.

use rayon::prelude::*;

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use scene::Scene;

use super::number::spaced;
use super::sun::Sun;
use super::urdf::LABEL_NAMESPACE;
use super::urdf::origin;
use super::wavefront::{Wavefront, hull_file, visual_file};
use super::{Body, BundleFile, ExportSettings};
use markup::xml::XmlDocument;

const VERSION: &str = "1.9";

/// Torque of a contact patch over radius, coefficient and normal force is 3 pi / 16 (Gazebo's torsional model).
const PATCH_COEFFICIENT: f64 = 16.0 / (3.0 * std::f64::consts::PI);

/// Namespace of Drake's elements, which other programs ignore.
pub const DRAKE_NAMESPACE: &str = "http://drake.mit.edu";

/// Elastic modulus of objects in Drake's hydroelastic contact, Pa: objects sink by less than a tenth of a millimeter.
const DRAKE_MODULUS_PA: f64 = 1e7;
/// Dissipation of Drake's contacts, s/m: less lets stacked books jump at steps of 5 ms.
const DRAKE_DISSIPATION_S_M: f64 = 50.0;
/// Edge length of the mesh that Drake makes of what is round, share of the radius: 25 sides.
const DRAKE_ROUND_SHARE: f64 = 0.25;

/// All files under `sdf/`.
pub fn write(
    scene: &Scene,
    bodies: &[Body],
    wavefronts: &[Wavefront],
    settings: &ExportSettings,
) -> Vec<BundleFile> {
    let both = bodies.par_iter().zip(wavefronts);
    let mut files: Vec<BundleFile> =
        both.flat_map_iter(|(body, obj)| model_files(body, obj, settings)).collect();
    let text = world(scene, bodies, settings);
    files.push(BundleFile::text("sdf/world.sdf", text, "sdf_world", "application/xml"));
    files
}

fn model_files(body: &Body, wavefront: &Wavefront, settings: &ExportSettings) -> Vec<BundleFile> {
    let folder = format!("sdf/models/{}", body.name);
    let mut document = XmlDocument::new();
    open_sdf(&mut document, body.stand_in.is_some());
    write_model(&mut document, body, &Pose::IDENTITY, "");
    let mut files = vec![
        BundleFile::text(format!("{folder}/model.sdf"), document.finish(), "sdf_model", "application/xml"),
        BundleFile::text(
            format!("{folder}/model.config"),
            config(body, settings),
            "sdf_model",
            "application/xml",
        ),
    ];
    files.extend(wavefront.files(body, &folder, "sdf", body.mesh_hulls()));
    files
}

/// `model.config`, the index file of a model folder. It holds the user's label of the body.
fn config(body: &Body, settings: &ExportSettings) -> String {
    let mut document = XmlDocument::new();
    document.open("model", &[]);
    document.text_element("name", &body.name);
    document.text_element("version", "1.0");
    document.text_element_with("sdf", &[("version", VERSION)], "model.sdf");
    document.open("author", &[]);
    document.text_element("name", &settings.author);
    document.close();
    document.text_element("description", &body.label);
    document.finish()
}

fn open_sdf(document: &mut XmlDocument, has_stand_ins: bool) {
    let mut attributes = vec![("version", VERSION), ("xmlns:drake", DRAKE_NAMESPACE)];
    if has_stand_ins {
        attributes.push(("xmlns:tabletopgen", LABEL_NAMESPACE));
    }
    document.open("sdf", &attributes);
}

fn world(scene: &Scene, bodies: &[Body], settings: &ExportSettings) -> String {
    let mut document = XmlDocument::new();
    open_sdf(&mut document, bodies.iter().any(|body| body.stand_in.is_some()));
    document.open("world", &[("name", &format!("scene_{}", scene.id))]);
    document.text_element("gravity", &spaced(&[0.0, 0.0, -settings.gravity_m_s2]));
    document.open("light", &[("name", "sun"), ("type", "directional")]);
    let Sun { position_m, direction, brightness } = Sun::of(scene, 0.8);
    document.text_element("pose", &format!("{position_m} 0 0 0"));
    document.text_element("direction", &direction);
    document.text_element("diffuse", &format!("{brightness} 1"));
    document.text_element("cast_shadows", "true");
    document.close();
    write_floor(&mut document, scene);
    for body in bodies {
        let folder = format!("models/{}/", body.name);
        write_model(&mut document, body, &body.world_from_object, &folder);
    }
    document.finish()
}

fn write_floor(document: &mut XmlDocument, scene: &Scene) {
    document.open("model", &[("name", "floor")]);
    document.text_element("static", "true");
    document.text_element("pose", &spaced(&[0.0, 0.0, -scene.table.height_m, 0.0, 0.0, 0.0]));
    document.open("link", &[("name", "floor")]);
    for element in ["collision", "visual"] {
        document.open(element, &[("name", element)]);
        document.open("geometry", &[]);
        document.open("plane", &[]);
        document.text_element("normal", "0 0 1");
        document.text_element("size", "10 10");
        document.close();
        document.close();
        document.close();
    }
    document.close();
    document.close();
}

/// A model named as the body, its only link named likewise; mesh paths start with `prefix`.
fn write_model(document: &mut XmlDocument, body: &Body, world_from_object: &Pose, prefix: &str) {
    let marks = body.marks().into_iter().map(|(mark, value)| (format!("tabletopgen:{mark}"), value));
    let marks: Vec<(String, &str)> = marks.collect();
    let name = std::iter::once(("name", body.name.as_str()));
    let attributes: Vec<_> = name.chain(marks.iter().map(|(mark, value)| (mark.as_str(), *value))).collect();
    document.open("model", &attributes);
    document.text_element("static", if body.movable { "false" } else { "true" });
    let (position, angles) = origin(world_from_object);
    document.text_element("pose", &spaced(&[position.to_array(), angles.to_array()].concat()));
    document.open("link", &[("name", &body.name)]);
    let center = body.mass.center_of_mass_m;
    document.open("inertial", &[]);
    document.text_element("pose", &spaced(&[center.x, center.y, center.z, 0.0, 0.0, 0.0]));
    document.text_element("mass", &spaced(&[body.mass.mass_kg]));
    document.open("inertia", &[]);
    let tensor = body.inertia_tensor_kg_m2();
    for (name, row, column) in
        [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
    {
        document.text_element(name, &spaced(&[0.5 * (tensor.col(column)[row] + tensor.col(row)[column])]));
    }
    document.close();
    document.close();
    for k in 0..body.visual.groups.len() {
        document.open("visual", &[("name", &format!("visual_{k:02}"))]);
        write_mesh(document, &format!("{prefix}{}", visual_file(k)));
        document.close();
    }
    for (k, solid) in body.solids.iter().enumerate() {
        document.open("collision", &[("name", &format!("hull_{k:02}"))]);
        match solid {
            Some(solid) => write_solid(document, solid),
            None => write_mesh(document, &format!("{prefix}{}", hull_file(k))),
        }
        write_surface(document, body);
        write_proximity(document, body, solid.as_ref());
        document.close();
    }
    document.close();
    document.close();
}

/// Drake's contact properties: <https://drake.mit.edu/doxygen_cxx/group__multibody__parsing.html>.
fn write_proximity(document: &mut XmlDocument, body: &Body, solid: Option<&SimpleSolid>) {
    document.open("drake:proximity_properties", &[]);
    if let Some(solid) = solid.filter(|solid| !matches!(solid.kind, SimpleSolidKind::Box { .. })) {
        let edge_m = DRAKE_ROUND_SHARE * solid.half_size_m().x;
        document.text_element("drake:mesh_resolution_hint", &spaced(&[edge_m]));
    }
    if body.movable {
        document.empty("drake:compliant_hydroelastic", &[]);
        document.text_element("drake:hydroelastic_modulus", &spaced(&[DRAKE_MODULUS_PA]));
    } else {
        document.empty("drake:rigid_hydroelastic", &[]);
    }
    document.text_element("drake:hunt_crossley_dissipation", &spaced(&[DRAKE_DISSIPATION_S_M]));
    document.text_element("drake:mu_dynamic", &spaced(&[body.friction.dynamic_coefficient]));
    document.text_element("drake:mu_static", &spaced(&[body.friction.static_coefficient]));
    document.close();
}

fn write_mesh(document: &mut XmlDocument, uri: &str) {
    document.open("geometry", &[]);
    document.open("mesh", &[]);
    document.text_element("uri", uri);
    document.close();
    document.close();
}

fn write_solid(document: &mut XmlDocument, solid: &SimpleSolid) {
    let (position, angles) = origin(&solid.object_from_solid);
    document.text_element("pose", &spaced(&[position.to_array(), angles.to_array()].concat()));
    document.open("geometry", &[]);
    match solid.kind {
        SimpleSolidKind::Box { half_m } => {
            document.open("box", &[]);
            document.text_element("size", &spaced(&(2.0 * half_m).to_array()));
        }
        SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
            document.open("cylinder", &[]);
            document.text_element("radius", &spaced(&[radius_m]));
            document.text_element("length", &spaced(&[2.0 * half_length_m]));
        }
        SimpleSolidKind::Sphere { radius_m } => {
            document.open("sphere", &[]);
            document.text_element("radius", &spaced(&[radius_m]));
        }
        SimpleSolidKind::Capsule { radius_m, half_length_m } => {
            document.open("capsule", &[]);
            document.text_element("radius", &spaced(&[radius_m]));
            document.text_element("length", &spaced(&[2.0 * half_length_m]));
        }
    }
    document.close();
    document.close();
}

fn write_surface(document: &mut XmlDocument, body: &Body) {
    let friction = spaced(&[body.friction.dynamic_coefficient]);
    document.open("surface", &[]);
    document.open("bounce", &[]);
    document.text_element("restitution_coefficient", &spaced(&[body.restitution]));
    document.close();
    document.open("friction", &[]);
    document.open("ode", &[]);
    document.text_element("mu", &friction);
    document.text_element("mu2", &friction);
    document.close();
    document.open("bullet", &[]);
    document.text_element("friction", &friction);
    document.text_element("friction2", &friction);
    document.text_element("rolling_friction", &spaced(&[body.rolling_friction_m]));
    document.close();
    document.open("torsional", &[]);
    document.text_element("coefficient", &spaced(&[PATCH_COEFFICIENT]));
    document.text_element("use_patch_radius", "true");
    document.text_element("patch_radius", &spaced(&[body.torsional_friction_m]));
    document.close();
    document.close();
    document.close();
}
