//! Embedded adapters of the ports: real algorithms that need no key, no network and no GPU. All but [`dinov2`], which
//! wants weights, are always there.

pub mod analyst;
pub mod layout;
pub mod painter;
pub mod photograph;
pub mod orientation;
pub mod scene_analyst;
pub mod segmenter;
pub mod mesh_generator;
pub mod descriptor;
pub mod dinov2;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Ports;
use crate::geometry::decompose::DecomposeSettings;
use crate::physics::{CertifySettings, ResolveSettings, SettleSettings};
use crate::render::RenderSettings;
use crate::vision::descriptor::DescriptorSettings;

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

/// An embedded adapter for every port, of those that need no weights.
pub fn ports(settings: &EmbeddedSettings) -> Ports {
    let settings = settings.clone();
    Ports {
        analyst: Arc::new(scene_analyst::EmbeddedAnalyst {
            settings: settings.analyst,
            photograph: settings.photograph.clone(),
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
        segmenter: Arc::new(segmenter::EmbeddedSegmenter { photograph: settings.photograph.clone() }),
        mesh_generator: Arc::new(mesh_generator::EmbeddedMeshGenerator {
            photograph: settings.photograph.clone(),
        }),
        feature_extractor: Arc::new(descriptor::EmbeddedFeatureExtractor { settings: settings.descriptor }),
    }
}
