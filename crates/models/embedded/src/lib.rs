//! Embedded adapters of the ports: classical algorithms and bundled networks that run without API keys, network access
//! or a GPU.
//!
//! [`text_parser`] converts texts to scene descriptions, [`instruction_reader`] instructions to programs, [`layout`]
//! arranges objects on a table, [`image_generator`]
//! renders reference images, and [`single_view_reconstruction`] handles images from other sources. [`ports()`]
//! assembles them. Every adapter is always available except [`dinov2`], which needs external weights.
//!
//! The crate depends on `ports`, `vision`, `pose_estimation`, `physics`, `render`, `catalog` and the crates below
//! them. It must not depend on the remote adapters, the store, the pipeline or the API, and it opens no network
//! connections.
//!
//! ```
//! use embedded::text_parser::{DescribeOptions, TextParserSettings, describe};
//!
//! let settings = TextParserSettings {
//!     max_text_chars: 4000,
//!     fewest_objects: 8,
//!     default_max_objects: 15,
//!     table_area_per_footprint: 3.0,
//! };
//! let options = DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() };
//! let scene = describe("a desk with two mugs", 7, &options, &settings)?;
//! assert_eq!(scene.objects.iter().filter(|object| object.requested).count(), 2);
//! # Ok::<(), embedded::text_parser::DescribeError>(())
//! ```

pub mod analyst;
pub mod layout;
pub mod image_generator;
pub mod single_view_reconstruction;
pub mod orientation;
pub mod requested_pose;
mod recognized_table;
pub mod text_parser;
pub mod instruction_reader;
pub mod segmenter;
pub mod mesh_generator;
pub mod descriptor;
pub mod dinov2;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use geometry::decompose::DecomposeSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::{Adapter, Ports};
use render::RenderSettings;
use vision::descriptor::DescriptorSettings;

/// Settings of all embedded adapters.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct EmbeddedSettings {
    pub analyst: text_parser::TextParserSettings,
    pub layout: layout::LayoutSettings,
    pub image_generator: image_generator::ImageGeneratorSettings,
    pub mesh_generator: mesh_generator::MeshSettings,
    pub photograph: single_view_reconstruction::SingleViewSettings,
    pub descriptor: DescriptorSettings,
    pub render: RenderSettings,
    pub decompose: DecomposeSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub certify: CertifySettings,
}

/// The identity of an adapter whose answers depend on the catalog: the categories of the user are part of it.
fn with_catalog(adapter: Adapter) -> Adapter {
    match catalog::added_digest() {
        Some(digest) => Adapter { model: format!("{} catalog:{digest}", adapter.model), ..adapter },
        None => adapter,
    }
}

/// An embedded adapter for every port. `network` reads images without ground truth.
pub fn ports(settings: &EmbeddedSettings, network: Arc<single_view_reconstruction::ReadingNetwork>) -> Ports {
    let settings = settings.clone();
    let reader = single_view_reconstruction::ImageReader::new(network, settings.photograph.clone());
    Ports {
        analyst: Arc::new(analyst::EmbeddedAnalyst {
            settings: settings.analyst,
            photograph: reader.clone(),
        }),
        image_generator: Arc::new(image_generator::EmbeddedImageGenerator {
            photograph: settings.photograph.clone(),
            layout: settings.layout,
            image_generator: settings.image_generator,
            render: settings.render,
            decompose: settings.decompose,
            settle: settings.settle,
            resolve: settings.resolve,
            certify: settings.certify,
        }),
        segmenter: Arc::new(segmenter::EmbeddedSegmenter { photograph: reader }),
        mesh_generator: Arc::new(mesh_generator::EmbeddedMeshGenerator {
            photograph: settings.photograph.clone(),
            meshes: settings.mesh_generator,
        }),
        feature_extractor: Arc::new(descriptor::EmbeddedFeatureExtractor { settings: settings.descriptor }),
    }
}
