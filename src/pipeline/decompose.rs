//! Stage `decompose`, for each instance and the table: convex hulls that cover the mesh and leave its cavities open.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, Settings, artifact_io, canonicalize, reconstruct};
use geometry::decompose::{DecomposeError, DecomposeSettings, HullFit, decompose_and_fit};
use geometry::repair::Repair;
use scene::{InstanceId, Recognition};

pub const STAGE: Stage = Stage { name: "decompose", version: 14 };

#[derive(Serialize)]
pub struct Inputs {
    mesh: ArtifactRef,
    decompose: DecomposeSettings,
}

/// The collision geometry of one mesh.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub hulls: ArtifactRef,
    pub count: u32,
    /// Largest distance by which a hull sticks out of the mesh, meters.
    pub max_excess_m: f64,
    /// Sum of the hulls' volumes (overlaps count twice) and of the mesh's shells, m^3.
    pub hull_volume_m3: f64,
    pub mesh_volume_m3: f64,
    /// Whether the mesh was closed as it came.
    pub watertight: bool,
    /// Repair of the mesh before its decomposition.
    pub repair: Repair,
    /// Fit of the hulls to the mesh.
    pub fit: HullFit,
}

/// The objects in the order of recognition, then the table where there is one.
pub fn inputs(
    recognition: &Recognition,
    raw: &[reconstruct::Output],
    canonical: &[canonicalize::Output],
    settings: &Settings,
) -> Result<Vec<(InstanceId, Inputs)>, StageError> {
    let of = |mesh: &ArtifactRef| Inputs { mesh: mesh.clone(), decompose: settings.decompose.clone() };
    let table = reconstruct::of_table(recognition, raw);
    let table_id =
        InstanceId::new("table").map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
    Ok(recognition
        .objects
        .iter()
        .zip(canonical)
        .map(|(object, canonical)| (object.id.clone(), of(&canonical.mesh)))
        .chain(table.map(|table| (table_id, of(&table.mesh))))
        .collect())
}

impl Inputs {
    /// Grows with the time it takes.
    pub fn effort(&self) -> u64 {
        self.mesh.size
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let mesh = artifact_io::mesh(&context, &inputs.mesh).await?;
    let (settings, cancel) = (inputs.decompose.clone(), context.cancel().clone());
    let name = context.instance().map_or_else(String::new, ToString::to_string);
    let measured = context.cpu(move || decompose_and_fit(&mesh, &settings, &cancel)).await?;
    let (found, fit) = measured.map_err(|error| match error {
        DecomposeError::Cancelled(cancelled) => cancelled.into(),
        other => StageError::permanent("no_collision_geometry", format!("{name}: {other}")),
    })?;
    let output = Output {
        hulls: artifact_io::put_hulls(&context, &found.hulls).await?,
        count: u32::try_from(found.hulls.len()).unwrap_or(u32::MAX),
        max_excess_m: found.max_excess_m,
        hull_volume_m3: found.hull_volume_m3,
        mesh_volume_m3: found.mesh_volume_m3,
        watertight: found.watertight,
        repair: found.repair,
        fit,
    };
    context.put_json("report.json", &output).await?;
    Ok(output)
}
