//! The scene of a bundle as tasks see it: `scene.json` with the hulls and colors of its objects.

use std::sync::Arc;

use super::composition::{self, StoredComposition};
use super::edit::main_color;
use super::error::StageError;
use catalog::{Affordance, category};
use export::archive::wanted_files;
use mesh_io::gltf::read_mesh_glb;
use scene::Scene;
use tasks::{ObjectAppearance, ObjectShape, TaskScene};

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
        let is_graspable =
            category(&instance.category).is_none_or(|category| category.affords(Affordance::Graspable));
        let shape = ObjectShape::new(
            hulls.clone(),
            instance.mass.center_of_mass_m,
            instance.mass.mass_kg,
            is_graspable,
        )
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

fn unreadable(why: impl std::fmt::Display) -> StageError {
    StageError::permanent(
        "bundle_unreadable",
        format!("reading the scene's bundle: {why}; make the scene again with this version"),
    )
}
