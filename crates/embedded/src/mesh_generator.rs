//! The embedded mesh generator: the parametric catalog for pictures our own painter painted, reconstruction
//! from one view for photographs.
//!
//! Meshes come as a remote generator's would: unit-sized, in a seeded one of the 24 axis-aligned
//! orientations. Whoever wants them upright has to find out how.

use catalog;
use catalog::Recipe;
use ports::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use scene::{RecognizedTable, ReconstructionMethod};

use super::orientation::turned;
use super::photograph::{self, PhotographSettings};
use super::recognized_table;

/// Answers from the catalog, or from the one view there is.
pub struct EmbeddedMeshGenerator {
    pub photograph: PhotographSettings,
}

const CATALOG: &str = "embedded/catalog";

/// Licence of meshes made by our own generators.
const LICENCE: &str = "CC0-1.0";

impl MeshGenerator for EmbeddedMeshGenerator {
    fn adapter(&self) -> Adapter {
        Adapter::new("embedded/mesh_generator", env!("CARGO_PKG_VERSION"), &self.photograph)
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        let settings = self.photograph.clone();
        Box::pin(call.compute(Port::MeshGenerator, move |interrupt| {
            if !request.painted {
                return photograph::reconstruct(&request, &settings, interrupt);
            }
            let object = &request.object;
            let recipe = Recipe {
                category: object.category.clone(),
                size_m: object.size_m,
                color: object.color,
                material: object.material.clone(),
                seed: object.seed,
            };
            let mesh = catalog::stocked(&recipe).ok_or_else(|| ProviderError::Unsupported {
                port: Port::MeshGenerator,
                adapter: CATALOG.into(),
                reason: format!("{:?} is no category of the catalog", object.category),
            })?;
            Ok(RawMesh {
                mesh: turned((*mesh).clone(), request.seed),
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
