//! Faults planted in a sound scene and in sound files: this program's own checks name each of them before there
//! is a bundle.

use glam::DVec3;

use super::parity::read_back;
use super::specimen::{files, files_with, settings, specimen};
use super::*;

/// What the scene or its assets are refused for.
fn code_of(plant: impl FnOnce(&mut Scene, &mut Assets)) -> &'static str {
    let (mut scene, certificate, mut assets, pictures) = specimen();
    plant(&mut scene, &mut assets);
    let refused = write_formats(&scene, &certificate, &assets, &pictures, &settings(UsdForm::Usdc));
    refused.expect_err("a fault was planted").code()
}

#[test]
fn no_simulator_gets_a_body_that_cannot_be() {
    assert_eq!(code_of(|scene, _| scene.instances[0].mass.mass_kg = -0.3), "mass_not_positive");
    assert_eq!(code_of(|scene, _| scene.instances[0].mass.mass_kg = f64::NAN), "mass_not_positive");
    // One moment is larger than the other two together.
    assert_eq!(
        code_of(|scene, _| scene.instances[0].mass.inertia_diagonal_kg_m2.x = 1e-3),
        "impossible_inertia"
    );
    // The unit matrix that a careless exporter writes for everything.
    assert_eq!(
        code_of(|scene, _| scene.instances[1].mass.inertia_diagonal_kg_m2 = DVec3::ONE),
        "impossible_inertia"
    );
    assert_eq!(
        code_of(|scene, _| scene.instances[1].mass.center_of_mass_m.z = 0.5),
        "center_of_mass_outside"
    );
    let no_hull = |scene: &mut Scene, assets: &mut Assets| {
        scene.instances[1].hulls = 0;
        assets.instances[1].hulls.clear();
    };
    assert_eq!(code_of(no_hull), "missing_collider");
    assert_eq!(code_of(|_, assets| drop(assets.instances[0].hulls.pop())), "export_failed");
    assert_eq!(
        code_of(|scene, _| scene.instances[0].friction.dynamic_coefficient = 0.9),
        "impossible_friction"
    );
    assert_eq!(code_of(|scene, _| scene.instances[0].restitution = -0.1), "impossible_friction");
    assert_eq!(
        code_of(|scene, _| scene.instances[0].world_from_object.translation_m.x = f64::INFINITY),
        "pose_not_finite"
    );
}

/// A change to one file of the bundle: path, what is replaced, and by what.
struct Plant {
    what: &'static str,
    path: &'static str,
    from: &'static str,
    to: &'static str,
}

const fn plant(what: &'static str, path: &'static str, from: &'static str, to: &'static str) -> Plant {
    Plant { what, path, from, to }
}

const MJCF: &str = "mjcf/scene.xml";
const URDF: &str = "urdf/mug_1/mug_1.urdf";
const SDF: &str = "sdf/world.sdf";
const USD: &str = "usd/assets/mug_1/simready_usd/mug_1.usda";
const STAGE: &str = "usd/scene.usda";
const NEWTON: &str = "usd/assets/mug_1/simready_usd/runnables/physics/newton.usda";
const MUJOCO: &str = "usd/assets/mug_1/simready_usd/runnables/physics/mujoco.usda";
const PHYSX: &str = "usd/assets/mug_1/simready_usd/runnables/physics/physx.usda";

/// Faults of a writer, in each format that can have them. What only a USD reader sees stands with the layers.
const PLANTS: &[Plant] = &[
    plant("negative mass", MJCF, "mass=\"0.3\"", "mass=\"-0.3\""),
    plant("negative mass", URDF, "<mass value=\"0.3\"", "<mass value=\"-0.3\""),
    plant("negative mass", USD, "physics:mass = 0.3", "physics:mass = -0.3"),
    plant("no body", USD, "\"PhysicsRigidBodyAPI\", ", ""),
    plant("negative mass", SDF, "<mass>0.3</mass>", "<mass>-0.3</mass>"),
    plant("impossible inertia", MJCF, "diaginertia=\"0.00031 ", "diaginertia=\"1 "),
    plant("impossible inertia", URDF, "ixx=\"0.000", "ixx=\"1.000"),
    plant("impossible inertia", SDF, "<ixx>0.000", "<ixx>1.000"),
    plant(
        "missing collider",
        MJCF,
        "name=\"box_1_hull_00\" type=\"mesh\"",
        "name=\"box_1_hull_00\" contype=\"0\"",
    ),
    plant("missing collider", URDF, "hull_03.obj", "hull_99.obj"),
    plant("missing collider", USD, "[\"PhysicsCollisionAPI\", ", "["),
    plant("missing collider", USD, "physics:collisionEnabled = 1", "physics:collisionEnabled = 0"),
    plant("missing collider", NEWTON, "[\"NewtonCollisionAPI\", ", "["),
    plant("missing collider", PHYSX, "over \"hull_00\"", "over \"hull_99\""),
    plant("missing collider", SDF, "models/mug_1/hull_03.obj", "models/mug_1/hull_99.obj"),
    plant("open mesh", "urdf/mug_1/visual_00.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    plant("open mesh", "mjcf/assets/mug_1_glaze.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    plant("open mesh", "sdf/models/mug_1/visual_00.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    plant("open mesh", USD, "faceVertexCounts = [3, ", "faceVertexCounts = ["),
    plant("broken hull", "urdf/box_1/hull_00.obj", "f 4 3 2", "f 4 3 99"),
    plant("swapped units", "urdf/mug_1/hull_00.obj", "v 0.0", "v 0"),
    plant("swapped units", URDF, "scale=\"1 1 1\"", "scale=\"0.001 0.001 0.001\""),
    plant(
        "swapped units",
        SDF,
        "<uri>models/mug_1/hull_00.obj</uri>",
        "<uri>models/mug_1/hull_00.obj</uri><scale>1000 1000 1000</scale>",
    ),
    plant("swapped units", USD, "metersPerUnit = 1", "metersPerUnit = 0.01"),
    plant("swapped units", STAGE, "metersPerUnit = 1", "metersPerUnit = 0.01"),
    plant("swapped units", STAGE, "kilogramsPerUnit = 1", "kilogramsPerUnit = 0.001"),
    plant("other axis up", USD, "upAxis = \"Z\"", "upAxis = \"Y\""),
    plant("swapped units", MJCF, "inertia=\"shell\"", "inertia=\"shell\" scale=\"1000 1000 1000\""),
    plant("wrong friction", MJCF, "friction=\"0.5 ", "friction=\"0.05 "),
    plant("wrong friction", URDF, "<lateral_friction value=\"0.5\"", "<lateral_friction value=\"0.6\""),
    plant("wrong friction", SDF, "<mu>0.5</mu>", "<mu>0.6</mu>"),
    plant("wrong friction", USD, "physics:dynamicFriction = 0.5", "physics:dynamicFriction = 0.6"),
    plant("wrong friction", USD, "physics:staticFriction = 0.6", "physics:staticFriction = 0.7"),
    plant("wrong friction", URDF, "<mu1>0.5</mu1>", "<mu1>0.6</mu1>"),
    plant("wrong friction", SDF, "<friction>0.5</friction>", "<friction>0.6</friction>"),
    plant("wrong rolling friction", MJCF, "friction=\"0.5 0.003 0.0005\"", "friction=\"0.5 0.003 0.005\""),
    plant(
        "wrong rolling friction",
        URDF,
        "<rolling_friction value=\"0.0005\"",
        "<rolling_friction value=\"5\"",
    ),
    plant("wrong rolling friction", SDF, "<rolling_friction>0.0005<", "<rolling_friction>0.005<"),
    plant("wrong rolling friction", NEWTON, "rollingFriction = 0.0005", "rollingFriction = 0.005"),
    plant("wrong torsional friction", SDF, "<patch_radius>0.003<", "<patch_radius>0.03<"),
    plant("wrong torsional friction", MUJOCO, "torsionalfriction = 0.003", "torsionalfriction = 0.03"),
    plant("wrong restitution", URDF, "<restitution value=\"0.1\"", "<restitution value=\"0.9\""),
    plant("wrong restitution", SDF, "<restitution_coefficient>0.1<", "<restitution_coefficient>0.9<"),
    plant("wrong restitution", USD, "physics:restitution = 0.1", "physics:restitution = 0.9"),
    plant(
        "unbound friction",
        USD,
        "physics = </mug_1/Looks/Physics_material>",
        "physics = </mug_1/Looks/glaze>",
    ),
    plant("unbound friction", USD, "[\"PhysicsMaterialAPI\", ", "["),
    plant("moved body", MJCF, "pos=\"-0.1 0.05 0\"", "pos=\"-0.1 0.05 0.001\""),
    plant("moved body", STAGE, "translate = (-0.1, 0.05, 0)", "translate = (-0.1, 0.05, 0.001)"),
    plant("moved body", "urdf/scene.urdf", "xyz=\"-0.1 0.05 0\"", "xyz=\"0.05 -0.1 0\""),
    plant("moved body", SDF, "<pose>-0.1 0.05 0 0 0 0.7", "<pose>-0.1 0.05 0 0 0 -0.7"),
    plant(
        "freed table",
        SDF,
        "<static>true</static>\n      <pose>0 0 0 ",
        "<static>false</static>\n      <pose>0 0 0 ",
    ),
    plant("other words", USD, "displayName = \"a ", "displayName = \"the "),
    plant("other words", USD, "semantics:labels:class = [\"mug\"]", "semantics:labels:class = [\"jug\"]"),
    plant("other words", USD, "wikidata_qcode = [\"Q223557\"]", "wikidata_qcode = [\"Q42\"]"),
    plant("other words", URDF, "a &quot;red&quot;", "a &quot;blue&quot;"),
    plant("other words", MJCF, "a &quot;red&quot;", "a &quot;blue&quot;"),
];

#[test]
fn no_bundle_holds_a_format_that_tells_another_scene() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    // USD as text, so that faults can be planted by words.
    let sound = files_with(UsdForm::Usda);
    read_back(&bodies, &sound).expect("nothing was planted yet");
    for Plant { what, path, from, to } in PLANTS {
        let mut files = sound.clone();
        let file = files.iter_mut().find(|file| file.path == *path).unwrap_or_else(|| panic!("no {path}"));
        let before = String::from_utf8(file.bytes.clone()).expect("text");
        assert!(before.contains(from), "{path} has no {from} for {what}");
        file.bytes = before.replacen(from, to, 1).into_bytes();
        let refused = read_back(&bodies, &files).expect_err(&format!("{what} in {path} passes"));
        assert_eq!(refused.code(), "formats_disagree", "{what} in {path}: {refused}");
    }
}

#[test]
fn a_glb_whose_node_moved_or_grew_is_refused() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let changes = [
        ("moved body", "\"translation\":[-0.1,0.05,0.0]", "\"translation\":[-0.1,0.06,0.0]"),
        ("swapped names", "\"name\":\"mug_1\",\"mesh\"", "\"name\":\"mug_2\",\"mesh\""),
        ("other words", "a \\\"red\\\"", "a \\\"RED\\\""),
    ];
    for (what, from, to) in changes {
        let mut files = files();
        let file = files.iter_mut().find(|file| file.path == "glb/scene.glb").expect("written");
        let at = file.bytes.windows(from.len()).position(|bytes| bytes == from.as_bytes());
        let at = at.unwrap_or_else(|| panic!("scene.glb has no {from} for {what}"));
        file.bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        let refused = read_back(&bodies, &files).expect_err(what);
        assert_eq!(refused.code(), "formats_disagree", "{what}: {refused}");
    }
}
