//! Stage `resolve`: from the aligned poses to poses that hold, then gravity; the rest pose is the scene's.

mod relaxation;

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::place::layout::resized;
use super::place::{self, PlacedInstance};
use super::{Context, Settings, artifact_io};
use catalog::{PhysicalProperties, physical_properties};
use certificate::Relaxation;
use geometry::solid_query::MeshSolid;
use geometry::{ConvexHull, Outline, Pose, TexturedMesh};
use physics::{
    Body, CertifySettings, ResolveError, ResolveProblem, ResolveSettings, ResolvedLayout, SettleSettings,
};
use scene::{Recognition, RecognizedObject, SupportTree};

use relaxation::{Attempt, Infeasible};
pub use relaxation::{NoSpaceSettings, OnNoSpace};

pub const STAGE: Stage = Stage { name: "resolve", version: 12 };

#[derive(Serialize)]
pub struct Inputs {
    /// The table first.
    bodies: Vec<Part>,
    /// Of the bodies after the table.
    supports: SupportTree,
    outline_m: Outline,
    resolve: ResolveSettings,
    settle: SettleSettings,
    certify: CertifySettings,
    no_room: NoSpaceSettings,
}

/// One body to be resolved.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Part {
    pub name: String,
    pub category: String,
    pub material: Option<String>,
    /// The mass that the text states.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    /// `world_from_object` wanted.
    pub aligned: Pose,
}

/// Rest poses and what the bodies are made of; the table first.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub bodies: Vec<ResolvedBody>,
    /// Of the bodies after the table: those of the layout, unless an object was moved to the table.
    pub supports: SupportTree,
    /// Rounds it took.
    pub rounds: usize,
    /// Changes made to the layout, one sentence each.
    pub log: Vec<String>,
    /// Concessions because there was no room.
    pub gave_way: Vec<Relaxation>,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct ResolvedBody {
    pub name: String,
    /// Mesh of the layout, unless the body was made smaller.
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    /// Factor on the size that the layout gave; 1 unless there was no room.
    pub scale: f64,
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
            mass_kg: None,
            mesh: layout.table.mesh.clone(),
            hulls: layout.table.hulls.clone(),
            aligned: Pose::IDENTITY,
        };
        let of = |(object, placed): (&RecognizedObject, &PlacedInstance)| Part {
            name: placed.id.to_string(),
            category: object.category.clone(),
            material: object.material.clone(),
            mass_kg: object.mass_kg,
            mesh: placed.mesh.clone(),
            hulls: placed.hulls.clone(),
            aligned: placed.world_from_object,
        };
        let objects = recognition.objects.iter().zip(&layout.instances).map(of);
        Self {
            bodies: std::iter::once(table).chain(objects).collect(),
            supports: layout.supports.clone(),
            outline_m: layout.table.outline_m.clone(),
            resolve: settings.resolve.clone(),
            settle: settings.settle.clone(),
            certify: settings.certify.clone(),
            no_room: settings.no_room.clone(),
        }
    }
}

/// Geometry of one body, loaded.
#[derive(Clone)]
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
    let solid = artifact_io::solid(context, mesh).await?;
    let no_solid = |error| StageError::permanent("no_solid", format!("{name}: {error}"));
    Ok(Loaded {
        mesh: artifact_io::mesh(context, mesh).await?,
        solid: solid.map_err(no_solid)?,
        hulls: artifact_io::hulls(context, hulls).await?,
    })
}

/// Tries to make room before the job fails.
const MAX_TRIES: usize = 8;

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let mut attempt = Attempt::new(inputs.bodies.clone(), inputs.supports.clone());
    for _ in 0..MAX_TRIES {
        for (k, part) in attempt.parts.iter_mut().enumerate() {
            let (original, scale) = (&inputs.bodies[k], DVec3::splat(attempt.scales[k]));
            (part.mesh, part.hulls) =
                resized(&context, &original.mesh, &original.hulls, scale, &part.name).await?;
        }
        let loaded = attempt.parts.iter().map(|part| load(&context, &part.name, &part.mesh, &part.hulls));
        let loaded = Arc::new(futures::future::try_join_all(loaded).await?);
        let (given, geometry, cancel) = (inputs.clone(), loaded.clone(), context.cancel().clone());
        let (parts, supports) = (attempt.parts.clone(), attempt.supports.clone());
        let solved = context.cpu(move || solve(&given, &parts, supports, &geometry, &cancel)).await?;
        let failed = match solved {
            Ok(solved) => {
                let solved = solved.conceded(&attempt);
                context.put_json("poses.json", &solved).await?;
                return Ok(solved);
            }
            Err(failed) => failed,
        };
        let hulls: Vec<&[ConvexHull]> = loaded.iter().map(|geometry| &geometry.hulls[..]).collect();
        let yields = |stuck| attempt.give_way(&stuck, &inputs.no_room, &hulls, &inputs.outline_m);
        if !failed.stuck.is_some_and(yields) {
            return Err(failed.error);
        }
    }
    Err(StageError::permanent(
        "no_room",
        format!("resolving: no room after {MAX_TRIES} concessions; use a larger table or fewer objects"),
    ))
}

impl Output {
    /// Returns the output with the earlier concessions.
    fn conceded(mut self, attempt: &Attempt) -> Self {
        self.bodies.iter_mut().zip(&attempt.scales).for_each(|(body, scale)| body.scale = *scale);
        self.gave_way = attempt.gave_way();
        self
    }
}

/// A scene that is not resolved, and whether conceding something may help.
struct Failed {
    error: StageError,
    stuck: Option<Infeasible>,
}

impl From<StageError> for Failed {
    fn from(error: StageError) -> Self {
        Self { error, stuck: None }
    }
}

impl From<ResolveError> for Failed {
    fn from(error: ResolveError) -> Self {
        let names = error.names().to_vec();
        let message = error.to_string();
        match error {
            ResolveError::Cancelled(cancelled) => StageError::from(cancelled).into(),
            ResolveError::NoSpace { .. } => Self {
                error: StageError::permanent("no_room", message),
                stuck: Some(Infeasible { names, crowded: true }),
            },
            ResolveError::Unresolved { .. } => Self {
                error: StageError::permanent("unresolved", message),
                stuck: Some(Infeasible { names, crowded: false }),
            },
            _ => StageError::permanent("unresolved", message).into(),
        }
    }
}

fn solve(
    inputs: &Inputs,
    parts: &[Part],
    supports: SupportTree,
    loaded: &[Loaded],
    cancel: &runtime::CancelFlag,
) -> Result<Output, Failed> {
    let mut bodies = Vec::with_capacity(loaded.len());
    let mut physical = Vec::with_capacity(loaded.len());
    for (index, (part, geometry)) in parts.iter().zip(loaded).enumerate() {
        let failed = |error: String| {
            StageError::permanent("no_physical_properties", format!("resolving {}: {error}", part.name))
        };
        let mut properties = physical_properties(&geometry.mesh, &part.category, part.material.as_deref())
            .map_err(|error| failed(error.to_string()))?;
        if let Some(mass_kg) = part.mass_kg {
            properties.mass = properties.mass.with_mass(mass_kg);
        }
        bodies.push(body(&part.name, geometry, part.aligned, &properties, index == 0));
        physical.push(properties);
    }
    let solids: Vec<&MeshSolid> = loaded.iter().map(|geometry| &*geometry.solid).collect();
    let problem =
        ResolveProblem { bodies: &bodies, solids: &solids, supports: &supports, outline: &inputs.outline_m };
    let ResolvedLayout { poses, planned, displacements_m, rotations_rad, rounds, log } =
        physics::resolve(problem, &inputs.resolve, &inputs.settle, &inputs.certify, cancel)?;
    let bodies = parts
        .iter()
        .zip(physical)
        .enumerate()
        .map(|(index, (part, physical))| ResolvedBody {
            name: part.name.clone(),
            mesh: part.mesh.clone(),
            hulls: part.hulls.clone(),
            scale: 1.0,
            aligned: part.aligned,
            planned: planned[index],
            settled: poses[index],
            displacement_m: displacements_m[index],
            rotation_rad: rotations_rad[index],
            physical,
        })
        .collect();
    Ok(Output { bodies, supports, rounds, log, gave_way: Vec::new() })
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

#[cfg(test)]
mod tests;
