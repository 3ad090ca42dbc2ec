//! Fault injection: each fault planted in a valid scene or in valid files must be reported before a bundle exists.

use glam::DVec3;

use super::specimen::{files, files_with, settings, specimen};
use crate::round_trip::read_back;
use crate::*;

/// The error code for a scene or assets with the planted fault.
fn code_of(plant: impl FnOnce(&mut Scene, &mut Assets)) -> &'static str {
    let (mut scene, certificate, mut assets, images) = specimen();
    plant(&mut scene, &mut assets);
    let refused = write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(UsdForm::Usdc));
    refused.expect_err("a fault was planted").code()
}

#[test]
fn export_rejects_unphysical_bodies() {
    assert_eq!(code_of(|scene, _| scene.instances[0].mass.mass_kg = -0.3), "mass_not_positive");
    assert_eq!(code_of(|scene, _| scene.instances[0].mass.mass_kg = f64::NAN), "mass_not_positive");
    // One moment is larger than the sum of the other two.
    assert_eq!(
        code_of(|scene, _| scene.instances[0].mass.inertia_diagonal_kg_m2.x = 1e-3),
        "impossible_inertia"
    );
    // The unit matrix, a common placeholder of exporters.
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

/// A fault in one file of the bundle: its description, the path, the replaced text and the replacement.
struct Fault {
    what: &'static str,
    path: &'static str,
    from: &'static str,
    to: &'static str,
}

const fn fault(what: &'static str, path: &'static str, from: &'static str, to: &'static str) -> Fault {
    Fault { what, path, from, to }
}

const MJCF: &str = "mjcf/scene.xml";
const MJCF_OBJECT: &str = "mjcf/mug_1/mug_1.xml";
const URDF: &str = "urdf/mug_1/mug_1.urdf";
const SDF: &str = "sdf/world.sdf";
const USD: &str = "usd/assets/mug_1/simready_usd/mug_1.usda";
const BOX_USD: &str = "usd/assets/box_1/simready_usd/box_1.usda";
const STAGE: &str = "usd/scene.usda";
const NEWTON: &str = "usd/assets/mug_1/simready_usd/runnables/physics/newton.usda";
const MUJOCO: &str = "usd/assets/mug_1/simready_usd/runnables/physics/mujoco.usda";
const PHYSX: &str = "usd/assets/mug_1/simready_usd/runnables/physics/physx.usda";

/// Faults of a writer, for each format that can have them. The tests of the layers cover faults of USD syntax.
const FAULTS: &[Fault] = &[
    fault("negative mass", MJCF, "mass=\"0.3\"", "mass=\"-0.3\""),
    fault("negative mass", URDF, "<mass value=\"0.3\"", "<mass value=\"-0.3\""),
    fault("negative mass", USD, "physics:mass = 0.3", "physics:mass = -0.3"),
    fault("no body", USD, "\"PhysicsRigidBodyAPI\", ", ""),
    fault("negative mass", SDF, "<mass>0.3</mass>", "<mass>-0.3</mass>"),
    fault("impossible inertia", MJCF, "diaginertia=\"0.00031 ", "diaginertia=\"1 "),
    fault("impossible inertia", URDF, "ixx=\"0.000", "ixx=\"1.000"),
    fault("impossible inertia", SDF, "<ixx>0.000", "<ixx>1.000"),
    fault(
        "missing collider",
        MJCF,
        "name=\"box_1_hull_00\" type=\"box\"",
        "name=\"box_1_hull_00\" contype=\"0\"",
    ),
    fault("negative mass", MJCF_OBJECT, "mass=\"0.3\"", "mass=\"-0.3\""),
    fault("contacts at a distance", NEWTON, "contactGap = 0", "contactGap = 0.1"),
    fault("larger box", MJCF, "size=\"0.06 0.04 0.025\"", "size=\"0.06 0.04 0.026\""),
    fault("larger box", "urdf/box_1/box_1.urdf", "size=\"0.12 0.08 0.05\"", "size=\"0.06 0.04 0.025\""),
    fault("larger box", SDF, "<size>0.12 0.08 0.05</size>", "<size>0.12 0.05 0.08</size>"),
    fault("larger box", BOX_USD, "scale = (0.12, 0.08, 0.05)", "scale = (0.06, 0.04, 0.025)"),
    fault("moved box", BOX_USD, "translate = (0, 0, 0.025)", "translate = (0, 0, 0)"),
    fault("other solid", BOX_USD, "def Cube", "def Sphere"),
    fault("soft contacts", MJCF, "solref=\"0.004 1\" rgba=\"0.2", "solref=\"0.02 1\" rgba=\"0.2"),
    fault("soft contacts", MJCF_OBJECT, "solref=\"0.004 1\"", "solref=\"0.02 1\""),
    fault("missing collider", MJCF, "hulls/mug_1_03.obj", "hulls/mug_1_99.obj"),
    fault("missing site", MJCF_OBJECT, "bottom_site", "lower_site"),
    fault("missing mesh", MJCF_OBJECT, "../assets/", "assets/"),
    fault(
        "impossible friction",
        SDF,
        "<drake:mu_static>0.6</drake:mu_static>",
        "<drake:mu_static>9</drake:mu_static>",
    ),
    fault("missing collider", SDF, "<drake:compliant_hydroelastic/>", "<drake:rigid_hydroelastic/>"),
    fault("missing collider", URDF, "hull_03.obj", "hull_99.obj"),
    fault("missing collider", USD, "[\"PhysicsCollisionAPI\", ", "["),
    fault("missing collider", USD, "physics:collisionEnabled = 1", "physics:collisionEnabled = 0"),
    fault("missing collider", NEWTON, "[\"NewtonCollisionAPI\", ", "["),
    fault("missing collider", PHYSX, "over \"hull_00\"", "over \"hull_99\""),
    fault("missing collider", SDF, "models/mug_1/hull_03.obj", "models/mug_1/hull_99.obj"),
    fault("open mesh", "urdf/mug_1/visual_00.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    fault("open mesh", "mjcf/assets/mug_1_glaze.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    fault("open mesh", "sdf/models/mug_1/visual_00.obj", "f 1/1/1 2/2/2 3/3/3\n", ""),
    fault("open mesh", USD, "faceVertexCounts = [3, ", "faceVertexCounts = ["),
    fault("broken hull", "urdf/mug_1/hull_00.obj", "f 4 3 2", "f 4 3 99"),
    fault("swapped units", "urdf/mug_1/hull_00.obj", "v 0.0", "v 0"),
    fault("swapped units", URDF, "scale=\"1 1 1\"", "scale=\"0.001 0.001 0.001\""),
    fault(
        "swapped units",
        SDF,
        "<uri>models/mug_1/hull_00.obj</uri>",
        "<uri>models/mug_1/hull_00.obj</uri><scale>1000 1000 1000</scale>",
    ),
    fault("swapped units", USD, "metersPerUnit = 1", "metersPerUnit = 0.01"),
    fault("swapped units", STAGE, "metersPerUnit = 1", "metersPerUnit = 0.01"),
    fault("swapped units", STAGE, "kilogramsPerUnit = 1", "kilogramsPerUnit = 0.001"),
    fault("other axis up", USD, "upAxis = \"Z\"", "upAxis = \"Y\""),
    fault("swapped units", MJCF, "inertia=\"shell\"", "inertia=\"shell\" scale=\"1000 1000 1000\""),
    fault("wrong friction", MJCF, "friction=\"0.5 ", "friction=\"0.05 "),
    fault("wrong friction", URDF, "<lateral_friction value=\"0.5\"", "<lateral_friction value=\"0.6\""),
    fault("wrong friction", SDF, "<mu>0.5</mu>", "<mu>0.6</mu>"),
    fault("wrong friction", USD, "physics:dynamicFriction = 0.5", "physics:dynamicFriction = 0.6"),
    fault("wrong friction", USD, "physics:staticFriction = 0.6", "physics:staticFriction = 0.7"),
    fault("wrong friction", URDF, "<mu1>0.5</mu1>", "<mu1>0.6</mu1>"),
    fault("wrong friction", SDF, "<friction>0.5</friction>", "<friction>0.6</friction>"),
    fault("wrong rolling friction", MJCF, "friction=\"0.5 0.003 0.0005\"", "friction=\"0.5 0.003 0.005\""),
    fault(
        "wrong rolling friction",
        URDF,
        "<rolling_friction value=\"0.0005\"",
        "<rolling_friction value=\"5\"",
    ),
    fault("wrong rolling friction", SDF, "<rolling_friction>0.0005<", "<rolling_friction>0.005<"),
    fault("wrong rolling friction", NEWTON, "rollingFriction = 0.0005", "rollingFriction = 0.005"),
    fault("wrong torsional friction", SDF, "<patch_radius>0.003<", "<patch_radius>0.03<"),
    fault("wrong torsional friction", MUJOCO, "torsionalfriction = 0.003", "torsionalfriction = 0.03"),
    fault("wrong restitution", URDF, "<restitution value=\"0.1\"", "<restitution value=\"0.9\""),
    fault("wrong restitution", SDF, "<restitution_coefficient>0.1<", "<restitution_coefficient>0.9<"),
    fault("wrong restitution", USD, "physics:restitution = 0.1", "physics:restitution = 0.9"),
    fault(
        "unbound friction",
        USD,
        "physics = </mug_1/Looks/Physics_material>",
        "physics = </mug_1/Looks/glaze>",
    ),
    fault("unbound friction", USD, "[\"PhysicsMaterialAPI\", ", "["),
    fault("moved body", MJCF, "pos=\"-0.1 0.05 0\"", "pos=\"-0.1 0.05 0.001\""),
    fault("moved body", STAGE, "translate = (-0.1, 0.05, 0)", "translate = (-0.1, 0.05, 0.001)"),
    fault("moved body", "urdf/scene.urdf", "xyz=\"-0.1 0.05 0\"", "xyz=\"0.05 -0.1 0\""),
    fault("moved body", SDF, "<pose>-0.1 0.05 0 0 0 0.7", "<pose>-0.1 0.05 0 0 0 -0.7"),
    fault(
        "freed table",
        SDF,
        "<static>true</static>\n      <pose>0 0 0 ",
        "<static>false</static>\n      <pose>0 0 0 ",
    ),
    fault("other words", USD, "displayName = \"a ", "displayName = \"the "),
    fault("other words", USD, "semantics:labels:class = [\"mug\"]", "semantics:labels:class = [\"jug\"]"),
    fault("other words", USD, "wikidata_qcode = [\"Q223557\"]", "wikidata_qcode = [\"Q42\"]"),
    fault("other words", URDF, "a &quot;red&quot;", "a &quot;blue&quot;"),
    fault("other words", MJCF, "a &quot;red&quot;", "a &quot;blue&quot;"),
];

#[test]
fn read_back_rejects_every_planted_fault() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    // USD as text, so that faults can be planted by words.
    let sound = files_with(UsdForm::Usda);
    read_back(&bodies, &sound).expect("nothing was planted yet");
    for Fault { what, path, from, to } in FAULTS {
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
fn read_back_rejects_changed_glb_nodes() {
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
