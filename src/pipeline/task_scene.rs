//! A finished scene as tasks see it: of a bundle (`scene.json` with the hulls and colors of its objects), or as the
//! stages have it.

use std::sync::Arc;

use super::composition::{self, BodyParts, Composition, StoredComposition};
use super::edit::main_color;
use super::error::StageError;
use super::resolve::Loaded;
use catalog::{Affordance, category};
use editing::EditableObject;
use export::archive::wanted_files;
use geometry::collision_shape::BrokenHull;
use geometry::{ConvexHull, MassProperties};
use manipulation::execution::TaskScene as SimulatedScene;
use mesh_io::gltf::read_mesh_glb;
use physics::Body;
use scene::{InstanceId, Scene};
use tasks::{ObjectAppearance, ObjectShape, PosedObject, TaskScene};

/// Path of the scene in a bundle.
const SCENE: &str = "scene.json";

/// A finished scene, read for tasks.
pub struct BundleScene {
    pub scene: Scene,
    pub stored: StoredComposition,
    pub tasks: TaskScene,
}

/// Reads a bundle's archive. Takes some ten milliseconds an object.
///
/// # Errors
///
/// `bundle_unreadable` for an archive that is no bundle, or one of a version without `composition.json`.
pub fn of_archive(archive: &[u8]) -> Result<BundleScene, StageError> {
    let is_wanted = |path: &str| {
        path == SCENE || path == composition::PATH || (path.starts_with("glb/") && path != "glb/scene.glb")
    };
    let mut files = wanted_files(archive, is_wanted).map_err(unreadable)?;
    let mut taken = |path: &str| files.remove(path).ok_or_else(|| unreadable(format!("it has no {path}")));
    let scene: Scene = serde_json::from_slice(&taken(SCENE)?).map_err(unreadable)?;
    let stored = StoredComposition::read(&taken(composition::PATH)?).map_err(unreadable)?;
    let objects = &stored.composition.recognition.objects;
    if objects.len() != scene.instances.len() {
        return Err(unreadable("scene.json and composition.json are of different scenes"));
    }
    let mut appearances = Vec::with_capacity(objects.len());
    for ((instance, recognized), hulls) in scene.instances.iter().zip(objects).zip(&stored.hulls[1..]) {
        let mesh = read_mesh_glb(&taken(&format!("glb/{}.glb", instance.name))?).map_err(unreadable)?;
        let shape = shape(hulls, &instance.mass, &instance.category)
            .map_err(|error| unreadable(format!("{} has a broken hull ({error})", instance.name)))?;
        appearances.push(ObjectAppearance {
            shape: Arc::new(shape),
            color: main_color(&mesh),
            material: recognized.material.clone(),
        });
    }
    let tasks = TaskScene::of_scene(&scene, &appearances).map_err(unreadable)?;
    Ok(BundleScene { scene, stored, tasks })
}

/// Whether objects of a category are for grippers; those that the catalog does not have are.
pub(super) fn is_graspable(category_name: &str) -> bool {
    category(category_name).is_none_or(|category| category.affords(Affordance::Graspable))
}

fn shape(
    hulls: &[ConvexHull],
    mass: &MassProperties,
    category_name: &str,
) -> Result<ObjectShape, BrokenHull> {
    ObjectShape::new(hulls.to_vec(), mass.center_of_mass_m, mass.mass_kg, is_graspable(category_name))
}

/// The objects of a composition in the frames of the bundle, with their geometry, the table's first.
///
/// # Errors
///
/// `not_rehearsed` for an object with a broken hull.
pub(super) fn described(composition: &Composition, loaded: &[Loaded]) -> Result<TaskScene, StageError> {
    let broken = |why: String| StageError::permanent("not_rehearsed", format!("rehearsing the scene: {why}"));
    let recognized = composition.recognition.objects.iter();
    let objects = recognized.zip(&composition.bodies[1..]).zip(&loaded[1..]).enumerate();
    let objects = objects.map(|(index, ((recognized, body), geometry))| {
        let resolved = &body.resolved;
        let name = InstanceId::new(&resolved.name).map_err(|error| broken(error.to_string()))?;
        let shape = shape(&geometry.hulls, &resolved.physical.mass, &recognized.category)
            .map_err(|error| broken(format!("{name} has a broken hull ({error})")))?;
        let posed = PosedObject::new(name.clone(), Arc::new(shape), resolved.settled);
        let described = EditableObject {
            name,
            label: recognized.label.clone(),
            category: recognized.category.clone(),
            stand_in: recognized.stand_in.is_some(),
            color: main_color(&geometry.mesh),
            material: recognized.material.clone(),
            size_m: geometry.mesh.size_m(),
            footprint: posed.footprint(),
            supporter: composition.supports.supporter(index),
        };
        Ok((posed, described))
    });
    let (posed, described) = objects.collect::<Result<Vec<_>, StageError>>()?.into_iter().unzip();
    let scene = TaskScene::new(composition.outline().clone(), posed, described);
    scene.map_err(|error| broken(error.to_string()))
}

/// Table and objects as the simulation of a robot has them, with the hulls of each, the table's first; `None` without a
/// table.
pub fn simulated<'a>(
    composition: &Composition,
    hulls: impl Iterator<Item = &'a Vec<ConvexHull>>,
) -> Option<SimulatedScene> {
    let body = |(index, (parts, hulls)): (usize, (&BodyParts, &Vec<ConvexHull>))| {
        let physical = &parts.resolved.physical;
        Body {
            name: parts.resolved.name.clone(),
            hulls: hulls.clone(),
            world_from_object: parts.resolved.settled,
            mass: physical.mass,
            friction: physical.friction,
            restitution: physical.restitution,
            rolling_friction_m: physical.rolling_friction_m,
            fixed: index == 0,
        }
    };
    let mut bodies = composition.bodies.iter().zip(hulls).enumerate().map(body);
    let table = bodies.next()?;
    Some(SimulatedScene { table, outline: composition.outline().clone(), objects: bodies.collect() })
}

fn unreadable(why: impl std::fmt::Display) -> StageError {
    StageError::permanent(
        "bundle_unreadable",
        format!("reading the scene's bundle: {why}; make the scene again with this version"),
    )
}
