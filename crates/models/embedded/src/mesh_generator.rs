//! The embedded mesh generator: parametric catalog meshes for images of the embedded image generator, single-view
//! reconstruction for other images.
//!
//! Meshes match the output of remote generators: unit-sized, in one of the 24 axis-aligned orientations, selected by
//! the seed. The canonicalization stage restores the upright orientation.

use ports::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use scene::{RecognizedTable, ReconstructionMethod};

use super::orientation::randomly_oriented;
use super::recognized_table;
use super::requested_pose::rendered_mesh;
use super::single_view_reconstruction::{self, SingleViewSettings};
use super::with_catalog;

/// Answers the mesh port from the catalog or from a single view.
pub struct EmbeddedMeshGenerator {
    pub photograph: SingleViewSettings,
}

const CATALOG: &str = "embedded/catalog";

/// License of meshes of the embedded generators.
const LICENCE: &str = "CC0-1.0";

impl MeshGenerator for EmbeddedMeshGenerator {
    fn adapter(&self) -> Adapter {
        with_catalog(Adapter::new("embedded/mesh_generator", "6", &self.photograph))
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        let settings = self.photograph.clone();
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
            Ok(RawMesh {
                mesh: randomly_oriented(mesh, request.seed),
                method: ReconstructionMethod::Category,
                made_by: CATALOG.into(),
                licence: LICENCE.into(),
                notes: Vec::new(),
            })
        }))
    }

    fn table<'a>(&'a self, call: &'a Call, table: RecognizedTable) -> Answer<'a, RawTable> {
        Box::pin(call.compute(Port::MeshGenerator, move |_| {
            let built = recognized_table::built(&table).ok_or_else(|| ProviderError::Unsupported {
                port: Port::MeshGenerator,
                adapter: CATALOG.into(),
                reason: format!("{:?} is no table model of the catalog", table.model),
            })?;
            Ok(RawTable {
                mesh: built.mesh.clone(),
                outline_m: built.outline_m.clone(),
                made_by: CATALOG.into(),
                licence: LICENCE.into(),
            })
        }))
    }
}
