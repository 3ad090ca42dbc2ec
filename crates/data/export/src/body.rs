//! The validated body that all writers take as input, so that writers need no error paths.

use std::collections::BTreeSet;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use geometry::parallel_grasp::ParallelGrasp;
use geometry::{ConvexHull, Friction, MassProperties, Pose, SimpleSolid, TexturedMesh};
use scene::{Scene, StandIn};

use super::surface::{SurfaceFault, printable_surface};
use super::{Assets, BodyAsset, ExportError};

/// The reason why a body is unphysical or unusable in a simulator.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyFault {
    #[error("it has no collision hull")]
    NoHull,
    #[error("hull {hull} {reason}")]
    BrokenHull { hull: usize, reason: &'static str },
    #[error("its mass is {mass_kg} kg; it must be positive")]
    Mass { mass_kg: f64 },
    #[error("its center of mass lies {outside_m} m outside its own box")]
    CenterOfMass { outside_m: f64 },
    #[error("its principal moments {moments_kg_m2} kg m^2 {reason}")]
    Inertia { moments_kg_m2: DVec3, reason: &'static str },
    #[error("its pose is not finite")]
    Pose,
    #[error("its {what} is {value}; it must lie between 0 and {highest}")]
    Contact { what: &'static str, value: f64, highest: f64 },
    #[error("its dynamic friction {dynamic_coefficient} exceeds its static friction {static_coefficient}")]
    Friction { static_coefficient: f64, dynamic_coefficient: f64 },
    #[error(transparent)]
    Surface(SurfaceFault),
}

impl BodyFault {
    /// Stable error code for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoHull => "missing_collider",
            Self::BrokenHull { .. } => "broken_collider",
            Self::Mass { .. } => "mass_not_positive",
            Self::CenterOfMass { .. } => "center_of_mass_outside",
            Self::Inertia { .. } => "impossible_inertia",
            Self::Pose => "pose_not_finite",
            Self::Contact { .. } | Self::Friction { .. } => "impossible_friction",
            Self::Surface(_) => "broken_mesh",
        }
    }
}

/// A body of the scene: the table (which never moves) or an instance. Its mesh has single-precision
/// positions, unit normals, no empty group and no degenerate triangle; its hulls have positive volume;
/// its mass properties are physical.
#[derive(Clone, Debug)]
pub struct Body {
    pub name: String,
    pub label: String,
    pub category: String,
    /// As [`BodyAsset::wikidata_item`].
    pub wikidata_item: String,
    /// As [`BodyAsset::substance`].
    pub substance: String,
    pub grasp: Option<ParallelGrasp>,
    /// As [`scene::Instance::stand_in`].
    pub stand_in: Option<StandIn>,
    pub movable: bool,
    pub world_from_object: Pose,
    pub visual: TexturedMesh,
    pub hulls: Vec<ConvexHull>,
    /// For each hull, the box, cylinder, sphere or capsule that it stands for; formats hold that in its place.
    pub solids: Vec<Option<SimpleSolid>>,
    pub mass: MassProperties,
    pub friction: Friction,
    pub restitution: f64,
    pub rolling_friction_m: f64,
    pub torsional_friction_m: f64,
}

impl Body {
    /// Numbers of the hulls that stand for no simple solid.
    pub fn mesh_hulls(&self) -> impl Iterator<Item = usize> {
        (0..self.hulls.len()).filter(move |&k| self.solids[k].is_none())
    }

    /// Inertia tensor about the center of mass along the object's axes, kg m^2.
    pub fn inertia_tensor_kg_m2(&self) -> DMat3 {
        let axes = DMat3::from_quat(self.mass.principal_axes_xyzw.normalize());
        axes * DMat3::from_diagonal(self.mass.inertia_diagonal_kg_m2) * axes.transpose()
    }

    /// Names and values of the mark of a stand-in, as every format has them; empty for other bodies.
    pub fn marks(&self) -> Vec<(&'static str, &str)> {
        let Some(StandIn { stands_for, shown_as }) = &self.stand_in else { return Vec::new() };
        let marks = [(STAND_IN, "true"), (STANDS_FOR, stands_for), (SHOWN_AS, shown_as)];
        // MuJoCo rejects empty text.
        marks.into_iter().filter(|(_, value)| !value.is_empty()).collect()
    }
}

/// Names of the parts of a stand-in's mark.
pub const STAND_IN: &str = "stand_in";
pub const STANDS_FOR: &str = "stands_for";
pub const SHOWN_AS: &str = "shown_as";

/// Names reserved for files of the bundle.
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
        stand_in: None,
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
        stand_in: instance.stand_in.as_ref(),
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

/// The properties of a body in the scene, for the table and for instances.
struct Facts<'a> {
    name: &'a str,
    label: &'a str,
    stand_in: Option<&'a StandIn>,
    movable: bool,
    world_from_object: Pose,
    mass: MassProperties,
    friction: Friction,
    restitution: f64,
    hulls: u32,
}

fn checked_body(facts: &Facts<'_>, asset: &BodyAsset) -> Result<Body, ExportError> {
    let unusable = |fault: BodyFault| ExportError::UnusableBody { body: facts.name.to_owned(), fault };
    if asset.name != facts.name {
        let (wanted, got) = (facts.name, &asset.name);
        return Err(ExportError::AssetsMismatch(format!("expected the asset of {wanted}, got {got}")));
    }
    if asset.hulls.len() != facts.hulls as usize {
        let (wanted, got) = (facts.hulls, asset.hulls.len());
        return Err(ExportError::AssetsMismatch(format!(
            "{}: {wanted} hulls expected, {got} given",
            facts.name
        )));
    }
    let pose = facts.world_from_object;
    if !pose.translation_m.is_finite() || !pose.rotation.is_finite() || pose.rotation.length() < 1e-6 {
        return Err(unusable(BodyFault::Pose));
    }
    let visual = printable_surface(&asset.visual).map_err(|why| unusable(BodyFault::Surface(why)))?;
    check_solid(&asset.visual, &asset.hulls, &facts.mass).map_err(unusable)?;
    let contact = Contact {
        friction: facts.friction,
        restitution: facts.restitution,
        rolling_friction_m: asset.rolling_friction_m,
        torsional_friction_m: asset.torsional_friction_m,
    };
    contact.check().map_err(unusable)?;
    Ok(Body {
        name: facts.name.to_owned(),
        label: facts.label.to_owned(),
        category: asset.category.clone(),
        wikidata_item: asset.wikidata_item.clone(),
        substance: asset.substance.clone(),
        grasp: asset.grasp,
        stand_in: facts.stand_in.cloned(),
        movable: facts.movable,
        world_from_object: Pose { translation_m: pose.translation_m, rotation: pose.rotation.normalize() },
        visual,
        hulls: asset.hulls.clone(),
        solids: asset.hulls.iter().map(SimpleSolid::of_hull).collect(),
        mass: facts.mass,
        friction: facts.friction,
        restitution: facts.restitution,
        rolling_friction_m: asset.rolling_friction_m,
        torsional_friction_m: asset.torsional_friction_m,
    })
}

/// Checks that mass and inertia are physical for these shapes and that the hulls are closed and have volume.
pub fn check_solid(
    visual: &TexturedMesh,
    hulls: &[ConvexHull],
    mass: &MassProperties,
) -> Result<(), BodyFault> {
    check_hulls(hulls)?;
    let corners = || visual.positions.iter().chain(hulls.iter().flat_map(|hull| &hull.points));
    check_mass(mass, corners)
}

/// Contact parameters of a body.
pub struct Contact {
    pub friction: Friction,
    pub restitution: f64,
    pub rolling_friction_m: f64,
    pub torsional_friction_m: f64,
}

impl Contact {
    /// Checks that the parameters are physical.
    pub fn check(&self) -> Result<(), BodyFault> {
        let Friction { static_coefficient, dynamic_coefficient } = self.friction;
        let limits = [
            ("static friction", static_coefficient, 10.0),
            ("dynamic friction", dynamic_coefficient, 10.0),
            ("restitution", self.restitution, 1.0),
            ("rolling friction (m)", self.rolling_friction_m, 1.0),
            ("torsional friction (m)", self.torsional_friction_m, 1.0),
        ];
        for (what, value, highest) in limits {
            if !(0.0..=highest).contains(&value) {
                return Err(BodyFault::Contact { what, value, highest });
            }
        }
        if dynamic_coefficient > static_coefficient {
            return Err(BodyFault::Friction { static_coefficient, dynamic_coefficient });
        }
        Ok(())
    }
}

fn check_hulls(hulls: &[ConvexHull]) -> Result<(), BodyFault> {
    if hulls.is_empty() {
        return Err(BodyFault::NoHull);
    }
    for (k, hull) in hulls.iter().enumerate() {
        let broken = |reason| Err(BodyFault::BrokenHull { hull: k, reason });
        let corners = hull.points.len();
        if corners < 4 || hull.points.iter().any(|p| !p.is_finite()) {
            return broken("has fewer than four finite corners");
        }
        if hull.triangles.iter().flatten().any(|&v| v as usize >= corners) {
            return broken("names a corner it does not have");
        }
        if hull.volume_m3() <= 0.0 {
            return broken("encloses no volume or is inside out");
        }
    }
    Ok(())
}

/// Tolerance for a center of mass outside its body's box, meters: the mass of thin shells is on their surface.
const OUTSIDE_BOX_M: f64 = 1e-3;

fn check_mass<'a, I: Iterator<Item = &'a DVec3>>(
    mass: &MassProperties,
    corners: impl Fn() -> I,
) -> Result<(), BodyFault> {
    let moments = mass.inertia_diagonal_kg_m2;
    if !(mass.mass_kg.is_finite() && mass.mass_kg > 0.0) {
        return Err(BodyFault::Mass { mass_kg: mass.mass_kg });
    }
    let impossible = |reason| Err(BodyFault::Inertia { moments_kg_m2: moments, reason });
    if !moments.is_finite() || moments.min_element() <= 0.0 {
        return impossible("are not finite and positive");
    }
    if moments.max_element() > (moments.element_sum() - moments.max_element()) * (1.0 + 1e-6) {
        return impossible("break the triangle inequality");
    }
    let axes = mass.principal_axes_xyzw;
    if !axes.is_finite() || (axes.length() - 1.0).abs() > 1e-3 {
        return impossible("have axes that are no rotation");
    }
    let center = mass.center_of_mass_m;
    let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| {
        (low.min(*corner), high.max(*corner))
    });
    let outside_m = (low - center).max(center - high).max_element();
    if outside_m.is_nan() || outside_m > OUTSIDE_BOX_M {
        return Err(BodyFault::CenterOfMass { outside_m });
    }
    // Upper bound: no part of the body is farther from an axis than its farthest corner is from the center.
    let farthest_m = corners().map(|corner| corner.distance(center)).fold(0.0, f64::max);
    if moments.max_element() > mass.mass_kg * farthest_m * farthest_m {
        return impossible("are larger than its mass at its farthest corner would have");
    }
    Ok(())
}
