//! Embedded adapters of the ports: real algorithms that need no key, no network and no GPU. All but [`dinov2`], which
//! wants weights of somebody else's, are always there.

pub mod analyst;
pub mod layout;
pub mod painter;
pub mod photograph;
pub mod orientation;
mod recognized_table;
pub mod scene_analyst;
pub mod segmenter;
pub mod mesh_generator;
pub mod descriptor;
pub mod dinov2;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use geometry::decompose::DecomposeSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::Ports;
use render::RenderSettings;
use vision::descriptor::DescriptorSettings;

/// Settings of all embedded adapters.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct EmbeddedSettings {
    pub analyst: analyst::Settings,
    pub layout: layout::LayoutSettings,
    pub painter: painter::PainterSettings,
    pub photograph: photograph::PhotographSettings,
    pub descriptor: DescriptorSettings,
    pub render: RenderSettings,
    pub decompose: DecomposeSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub certify: CertifySettings,
}

/// An embedded adapter for every port; pictures nobody here painted are read by the network, if there is one.
pub fn ports(settings: &EmbeddedSettings, network: Option<Arc<photograph::ReadingNetwork>>) -> Ports {
    let settings = settings.clone();
    let reader = photograph::PictureReader::new(network, settings.photograph.clone());
    Ports {
        analyst: Arc::new(scene_analyst::EmbeddedAnalyst {
            settings: settings.analyst,
            photograph: reader.clone(),
        }),
        painter: Arc::new(painter::EmbeddedPainter {
            photograph: settings.photograph.clone(),
            layout: settings.layout,
            painter: settings.painter,
            render: settings.render,
            decompose: settings.decompose,
            settle: settings.settle,
            resolve: settings.resolve,
            certify: settings.certify,
        }),
        segmenter: Arc::new(segmenter::EmbeddedSegmenter { photograph: reader }),
        mesh_generator: Arc::new(mesh_generator::EmbeddedMeshGenerator {
            photograph: settings.photograph.clone(),
        }),
        feature_extractor: Arc::new(descriptor::EmbeddedFeatureExtractor { settings: settings.descriptor }),
    }
}
