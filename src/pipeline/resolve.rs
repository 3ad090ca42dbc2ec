//! Stage 10: from the aligned poses to poses that hold, then gravity; the rest pose is the scene's.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::place::{self, PlacedInstance};
use super::{Context, Settings, carry};
use crate::catalog::{PhysicalProperties, physical_properties};
use crate::geometry::mesh_solid::MeshSolid;
use crate::geometry::{ConvexHull, Outline, Pose, TexturedMesh};
use crate::physics::resolve::SupportedBy;
use crate::physics::{
    Body, CertifySettings, ResolveError, ResolveProblem, ResolveSettings, Resolved, SettleSettings,
};
use crate::scene::{Recognition, RecognizedObject};

pub const STAGE: Stage = Stage { name: "resolve", version: 4 };

#[derive(Serialize)]
pub struct Inputs {
    /// The table first.
    bodies: Vec<Part>,
    outline_m: Outline,
    resolve: ResolveSettings,
    settle: SettleSettings,
    certify: CertifySettings,
}

/// One body to be resolved.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Part {
    pub name: String,
    pub category: String,
    pub material: Option<String>,
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    /// `world_from_object` wanted.
    pub aligned: Pose,
    /// Index of the supporter and whether this stands in it; `None` for the table.
    pub support: Option<(usize, bool)>,
}

/// Rest poses and what the bodies are made of; the table first.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub bodies: Vec<ResolvedBody>,
    /// Rounds it took.
    pub rounds: usize,
    /// What was done, one sentence each.
    pub log: Vec<String>,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct ResolvedBody {
    pub name: String,
    pub aligned: Pose,
    /// `world_from_object` before gravity: dropped and pushed apart.
    pub planned: Pose,
    /// `world_from_object` at rest.
    pub settled: Pose,
    /// From aligned to settled: horizontal distance, meters, and angle, radians.
    pub displacement_m: f64,
    pub rotation_rad: f64,
    pub physical: PhysicalProperties,
}

impl Inputs {
    pub fn new(recognition: &Recognition, layout: &place::Output, settings: &Settings) -> Self {
        let table = Part {
            name: "table".into(),
            category: "table".into(),
            material: recognition.table.material.clone(),
            mesh: layout.table.mesh.clone(),
            hulls: layout.table.hulls.clone(),
            aligned: Pose::IDENTITY,
            support: None,
        };
        let of = |(index, (object, placed)): (usize, (&RecognizedObject, &PlacedInstance))| Part {
            name: placed.id.to_string(),
            category: object.category.clone(),
            material: object.material.clone(),
            mesh: placed.mesh.clone(),
            hulls: placed.hulls.clone(),
            aligned: placed.world_from_object,
            support: Some(layout.support_of(index)),
        };
        let objects = recognition.objects.iter().zip(&layout.instances).enumerate().map(of);
        Self {
            bodies: std::iter::once(table).chain(objects).collect(),
            outline_m: layout.table.outline_m.clone(),
            resolve: settings.resolve.clone(),
            settle: settings.settle.clone(),
            certify: settings.certify.clone(),
        }
    }
}

/// Geometry of one body, loaded.
pub(super) struct Loaded {
    pub mesh: Arc<TexturedMesh>,
    pub solid: Arc<MeshSolid>,
    pub hulls: Vec<ConvexHull>,
}

pub(super) async fn load(
    context: &Context,
    name: &str,
    mesh: &ArtifactRef,
    hulls: &ArtifactRef,
) -> Result<Loaded, StageError> {
    let solid = carry::solid(context, mesh).await?;
    let no_solid = |error| StageError::permanent("no_solid", format!("{name}: {error}"));
    Ok(Loaded {
        mesh: carry::mesh(context, mesh).await?,
        solid: solid.map_err(no_solid)?,
        hulls: carry::hulls(context, hulls).await?,
    })
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let parts = inputs.bodies.iter().map(|part| load(&context, &part.name, &part.mesh, &part.hulls));
    let loaded = futures::future::try_join_all(parts).await?;
    let (given, interrupt) = (inputs.clone(), context.interrupt().clone());
    let solved = context.cpu(move || solve(&given, &loaded, &interrupt)).await??;
    context.put_json("poses.json", &solved).await?;
    Ok(solved)
}

fn solve(
    inputs: &Inputs,
    loaded: &[Loaded],
    interrupt: &crate::geometry::Interrupt,
) -> Result<Output, StageError> {
    let mut bodies = Vec::with_capacity(loaded.len());
    let mut physical = Vec::with_capacity(loaded.len());
    for (part, geometry) in inputs.bodies.iter().zip(loaded) {
        let failed = |error: String| {
            StageError::permanent("no_physical_properties", format!("resolving {}: {error}", part.name))
        };
        let properties = physical_properties(&geometry.mesh, &part.category, part.material.as_deref())
            .map_err(|error| failed(error.to_string()))?;
        bodies.push(body(&part.name, geometry, part.aligned, &properties, part.support.is_none()));
        physical.push(properties);
    }
    let supports: Vec<Option<SupportedBy>> = inputs
        .bodies
        .iter()
        .map(|part| part.support.map(|(parent, inside)| SupportedBy { parent, inside }))
        .collect();
    let solids: Vec<&MeshSolid> = loaded.iter().map(|geometry| &*geometry.solid).collect();
    let problem =
        ResolveProblem { bodies: &bodies, solids: &solids, supports: &supports, outline: &inputs.outline_m };
    let Resolved { poses, planned, displacements_m, rotations_rad, rounds, log } =
        crate::physics::resolve(problem, &inputs.resolve, &inputs.settle, &inputs.certify, interrupt)
            .map_err(|error| match error {
                ResolveError::Interrupted(interrupted) => interrupted.into(),
                ResolveError::NoRoom { .. } => StageError::permanent("no_room", error.to_string()),
                other => StageError::permanent("unresolved", other.to_string()),
            })?;
    let bodies = inputs
        .bodies
        .iter()
        .zip(physical)
        .enumerate()
        .map(|(index, (part, physical))| ResolvedBody {
            name: part.name.clone(),
            aligned: part.aligned,
            planned: planned[index],
            settled: poses[index],
            displacement_m: displacements_m[index],
            rotation_rad: rotations_rad[index],
            physical,
        })
        .collect();
    Ok(Output { bodies, rounds, log })
}

/// A body as the simulation wants it.
pub(super) fn body(
    name: &str,
    geometry: &Loaded,
    world_from_object: Pose,
    physical: &PhysicalProperties,
    fixed: bool,
) -> Body {
    Body {
        name: name.to_owned(),
        hulls: geometry.hulls.clone(),
        world_from_object,
        mass: physical.mass,
        friction: physical.friction,
        restitution: physical.restitution,
        rolling_friction_m: physical.rolling_friction_m,
        fixed,
    }
}
