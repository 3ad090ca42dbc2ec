//! One body as every writer sees it: checked once, so that writers need no error paths.

use std::collections::BTreeSet;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::geometry::{ConvexHull, Friction, MassProperties, Pose, TexturedMesh};
use crate::scene::Scene;

use super::surface::printable_surface;
use super::{Assets, BodyAsset, ExportError};

/// A body of the scene: the table (which never moves) or an instance. Its mesh has single-precision
/// positions, unit normals, no empty group and no degenerate triangle; its hulls have positive volume;
/// its mass properties are physical.
#[derive(Clone, Debug)]
pub struct Body {
    pub name: String,
    pub label: String,
    pub category: String,
    pub movable: bool,
    pub world_from_object: Pose,
    pub visual: TexturedMesh,
    pub hulls: Vec<ConvexHull>,
    pub mass: MassProperties,
    pub friction: Friction,
    pub restitution: f64,
    pub rolling_friction_m: f64,
    pub torsional_friction_m: f64,
}

impl Body {
    /// Inertia tensor about the center of mass along the object's axes, kg m^2.
    pub fn inertia_tensor_kg_m2(&self) -> DMat3 {
        let axes = DMat3::from_quat(self.mass.principal_axes_xyzw.normalize());
        axes * DMat3::from_diagonal(self.mass.inertia_diagonal_kg_m2) * axes.transpose()
    }
}

/// Names that files of the bundle use themselves.
const RESERVED_NAMES: [&str; 3] = ["scene", "world", "floor"];

/// The table first, then the instances in scene order.
pub fn bodies(scene: &Scene, assets: &Assets) -> Result<Vec<Body>, ExportError> {
    if scene.instances.len() != assets.instances.len() {
        let (wanted, got) = (scene.instances.len(), assets.instances.len());
        return Err(ExportError::AssetsMismatch(format!("{wanted} instances but {got} assets")));
    }
    let table = &scene.table;
    let mut names = BTreeSet::new();
    let all_names = scene.instances.iter().map(|instance| instance.name.as_str());
    for name in all_names.chain([table.name.as_str()]) {
        let safe = name.starts_with(|c: char| c.is_ascii_lowercase())
            && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if !safe || RESERVED_NAMES.contains(&name) || !names.insert(name) {
            return Err(ExportError::NameTaken(name.to_owned()));
        }
    }
    let table_facts = Facts {
        name: &table.name,
        label: &table.label,
        movable: false,
        world_from_object: Pose::IDENTITY,
        mass: table.mass,
        friction: table.friction,
        restitution: table.restitution,
        hulls: table.hulls,
    };
    let instances = scene.instances.iter().map(|instance| Facts {
        name: instance.name.as_str(),
        label: &instance.label,
        movable: true,
        world_from_object: instance.world_from_object,
        mass: instance.mass,
        friction: instance.friction,
        restitution: instance.restitution,
        hulls: instance.hulls,
    });
    let facts: Vec<Facts<'_>> = std::iter::once(table_facts).chain(instances).collect();
    let geometry: Vec<&BodyAsset> = std::iter::once(&assets.table).chain(&assets.instances).collect();
    facts.par_iter().zip(geometry).map(|(facts, asset)| checked_body(facts, asset)).collect()
}

/// What the scene says about a body, whether table or instance.
struct Facts<'a> {
    name: &'a str,
    label: &'a str,
    movable: bool,
    world_from_object: Pose,
    mass: MassProperties,
    friction: Friction,
    restitution: f64,
    hulls: u32,
}

fn checked_body(facts: &Facts<'_>, asset: &BodyAsset) -> Result<Body, ExportError> {
    let unusable = |reason: String| ExportError::UnusableBody { body: facts.name.to_owned(), reason };
    if asset.name != facts.name {
        let (wanted, got) = (facts.name, &asset.name);
        return Err(ExportError::AssetsMismatch(format!("expected the asset of {wanted}, got {got}")));
    }
    if asset.hulls.len() != facts.hulls as usize {
        let (wanted, got) = (facts.hulls, asset.hulls.len());
        return Err(ExportError::AssetsMismatch(format!("{}: {wanted} hulls told, {got} given", facts.name)));
    }
    check_hulls(&asset.hulls).map_err(unusable)?;
    check_mass(&facts.mass).map_err(unusable)?;
    let pose = facts.world_from_object;
    if !pose.translation_m.is_finite() || !pose.rotation.is_finite() || pose.rotation.length() < 1e-6 {
        return Err(unusable("its pose is not finite".to_owned()));
    }
    let surface_numbers = [
        facts.friction.static_coefficient,
        facts.friction.dynamic_coefficient,
        facts.restitution,
        asset.rolling_friction_m,
        asset.torsional_friction_m,
    ];
    if surface_numbers.iter().any(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(unusable("a friction or restitution is negative or not finite".to_owned()));
    }
    Ok(Body {
        name: facts.name.to_owned(),
        label: facts.label.to_owned(),
        category: asset.category.clone(),
        movable: facts.movable,
        world_from_object: Pose { translation_m: pose.translation_m, rotation: pose.rotation.normalize() },
        visual: printable_surface(&asset.visual).map_err(unusable)?,
        hulls: asset.hulls.clone(),
        mass: facts.mass,
        friction: facts.friction,
        restitution: facts.restitution,
        rolling_friction_m: asset.rolling_friction_m,
        torsional_friction_m: asset.torsional_friction_m,
    })
}

fn check_hulls(hulls: &[ConvexHull]) -> Result<(), String> {
    if hulls.is_empty() {
        return Err("it has no collision hull".to_owned());
    }
    for (k, hull) in hulls.iter().enumerate() {
        let corners = hull.points.len();
        if corners < 4 || hull.points.iter().any(|p| !p.is_finite()) {
            return Err(format!("hull {k} has fewer than four finite corners"));
        }
        if hull.triangles.iter().flatten().any(|&v| v as usize >= corners) {
            return Err(format!("hull {k} names a corner it does not have"));
        }
        if hull.volume_m3() <= 0.0 {
            return Err(format!("hull {k} encloses no volume or is inside out"));
        }
    }
    Ok(())
}

fn check_mass(mass: &MassProperties) -> Result<(), String> {
    let moments = mass.inertia_diagonal_kg_m2;
    if !(mass.mass_kg.is_finite() && mass.mass_kg > 0.0) {
        return Err(format!("its mass is {} kg", mass.mass_kg));
    }
    let finite = mass.center_of_mass_m.is_finite() && moments.is_finite();
    if !finite || moments.min_element() <= 0.0 {
        return Err("its center of mass or inertia is not finite and positive".to_owned());
    }
    if moments.max_element() > (moments.element_sum() - moments.max_element()) * (1.0 + 1e-6) {
        return Err(format!("its principal moments {moments} break the triangle inequality"));
    }
    let axes = mass.principal_axes_xyzw;
    if !axes.is_finite() || (axes.length() - 1.0).abs() > 1e-3 || !(axes * DVec3::X).is_finite() {
        return Err("its principal axes are no rotation".to_owned());
    }
    Ok(())
}
