//! The embedded mesh generator: parametric catalog meshes for images of the embedded image generator, single-view
//! reconstruction for other images.
//!
//! Meshes match the output of remote generators: unit-sized, in one of the 24 axis-aligned orientations, selected by
//! the seed. The canonicalization stage restores the upright orientation.

use serde::{Deserialize, Serialize};

use catalog::wear::{worn_object, worn_table};
use ports::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
    TableRequest,
};
use scene::ReconstructionMethod;

use super::orientation::randomly_oriented;
use super::recognized_table;
use super::requested_pose::rendered_mesh;
use super::single_view_reconstruction::{self, SingleViewSettings, with_photographed_top};
use super::with_catalog;

/// Answers the mesh port from the catalog or from a single view.
pub struct EmbeddedMeshGenerator {
    pub photograph: SingleViewSettings,
    pub meshes: MeshSettings,
}

/// Section `[mesh_generator]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct MeshSettings {
    /// Traces of use on tabletops and objects of the catalog, 0 (as new) to 1. Meshes of photographs have what the
    /// photograph shows.
    pub wear: f64,
}

/// All settings of the adapter.
#[derive(Serialize)]
struct Settings<'a> {
    #[serde(flatten)]
    photograph: &'a SingleViewSettings,
    meshes: &'a MeshSettings,
}

const CATALOG: &str = "embedded/catalog";

/// License of meshes of the embedded generators.
const LICENCE: &str = "CC0-1.0";

impl MeshGenerator for EmbeddedMeshGenerator {
    fn adapter(&self) -> Adapter {
        let settings = Settings { photograph: &self.photograph, meshes: &self.meshes };
        with_catalog(Adapter::new("embedded/mesh_generator", "9", &settings))
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        let (settings, wear) = (self.photograph.clone(), self.meshes.wear);
        Box::pin(call.compute(Port::MeshGenerator, move |cancel| {
            if !request.rendered {
                return single_view_reconstruction::reconstruct(&request, &settings, cancel);
            }
            let object = &request.object;
            let mesh = rendered_mesh(object).ok_or_else(|| ProviderError::Unsupported {
                port: Port::MeshGenerator,
                adapter: CATALOG.into(),
                reason: format!("the catalog has no {:?} in the requested pose", object.category),
            })?;
            let mesh = worn_object(mesh, &object.category, object.material.as_deref(), wear, object.seed);
            Ok(RawMesh {
                mesh: randomly_oriented(mesh, request.seed),
                method: ReconstructionMethod::Category,
                made_by: CATALOG.into(),
                licence: LICENCE.into(),
                notes: Vec::new(),
            })
        }))
    }

    fn table<'a>(&'a self, call: &'a Call, request: TableRequest) -> Answer<'a, RawTable> {
        let (wear, longer_px) = (self.meshes.wear, self.photograph.sizes.top_view_px);
        Box::pin(call.compute(Port::MeshGenerator, move |cancel| {
            let TableRequest { table, photograph } = request;
            let built = recognized_table::built(&table).ok_or_else(|| ProviderError::Unsupported {
                port: Port::MeshGenerator,
                adapter: CATALOG.into(),
                reason: format!("{:?} is no table model of the catalog", table.model),
            })?;
            let photographed = match &photograph {
                Some(photograph) => with_photographed_top(&built, photograph, longer_px, cancel)?,
                None => None,
            };
            if let Some(mesh) = photographed {
                return Ok(RawTable {
                    mesh,
                    outline_m: built.outline_m.clone(),
                    made_by: "embedded/photograph".into(),
                    licence: "CC0-1.0 AND LicenseRef-input-image".into(),
                });
            }
            Ok(RawTable {
                mesh: worn_table(built.mesh.clone(), wear, table.seed),
                outline_m: built.outline_m.clone(),
                made_by: CATALOG.into(),
                licence: LICENCE.into(),
            })
        }))
    }
}
