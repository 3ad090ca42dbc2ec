//! The embedded image generator: arranges catalog objects on a table, settles them and renders them.
//!
//! `reference` builds every mesh of a description and lays the meshes out ([`super::layout`]). It resolves the
//! layout into stable poses ([`physics::resolve()`]), selects a camera that shows every object, and renders the
//! reference image. The ground truth is returned with the image: labels, masks and camera (`known`), poses
//! (`truth`), an isolated view of each object, and the top view. Images from other sources are completed and
//! viewed from above by [`super::single_view_reconstruction`].
//!
//! Guarantees: the same description, seed and settings give the same bytes. The recognized sizes, colors,
//! materials and seeds build exactly the rendered meshes. Cost: for twelve objects see the stage `reference` in
//! `docs/results/generate_time.md`; objects in containers may take several arrangements.

mod table;
mod objects;
mod arrangement_supports;
mod arrangement;
mod table_growth;
mod viewpoint;
mod render_scene;
mod isolated_views;
mod top_view;
mod ground_truth;
mod error;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod stated_layout_tests;

use std::sync::Arc;

use futures::FutureExt;
use serde::{Deserialize, Serialize};

use super::layout::{LayoutSettings, posed_footprint};
use super::single_view_reconstruction::{self, SingleViewSettings};
use super::with_catalog;
use geometry::decompose::DecomposeSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, Port,
    ProviderError, SyntheticGroundTruth, TopViewImage, TopViewRequest,
};
use render::RenderSettings;
use runtime::CancelFlag;
use scene::SceneDescription;
use scene::predicates::unmet;
pub use table::{SceneTable, build_scene_table};

use self::table_growth::ArrangedTable;

/// Section `[image_generator]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ImageGeneratorSettings {
    /// Width of the reference image, pixels, 64..4096. Higher: finer masks, time in proportion.
    pub width_px: u32,
    /// Height of the reference image, pixels, 64..4096.
    pub height_px: u32,
    /// Horizontal field of view, radians, 0.2..1.5. Higher: stronger perspective.
    pub fov_x_rad: f64,
    /// Minimum and maximum elevation of the camera, radians, 0.3..1.5. Lower: more sides visible, more occlusion.
    pub elevation_rad: [f64; 2],
    /// Maximum azimuth of the camera to either side of the front direction, radians, 0..1.
    pub azimuth_rad: f64,
    /// Share of the image left free on each side, 0..0.3.
    pub frame_margin: f64,
    /// Cameras tried for each arrangement, 1..64. Higher: less occlusion.
    pub views: u32,
    /// Minimum visible share of every object's silhouette, 0..1. Higher: fewer overlaps in the image, more
    /// attempts.
    pub min_visible_share: f64,
    /// Maximum number of arrangements tried, 1..32.
    pub arrangements: u32,
    /// Minimum longer side of an isolated view, pixels, 64..1024. An object larger in the image keeps its size.
    pub alone_px: u32,
    /// Longer side of the top view, pixels, 64..4096.
    pub top_px: u32,
}

/// Maximum simulated settling time before rendering, seconds.
const MAX_SETTLING_S: f64 = 2.0;

/// Adapter `embedded/image_generator`.
pub struct EmbeddedImageGenerator {
    pub photograph: SingleViewSettings,
    pub layout: LayoutSettings,
    pub image_generator: ImageGeneratorSettings,
    pub render: RenderSettings,
    pub decompose: DecomposeSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub certify: CertifySettings,
}

impl EmbeddedImageGenerator {
    const NAME: &str = "embedded/painter";
    const MODEL: &str = "10";

    fn settings(&self) -> Settings {
        Settings {
            layout: self.layout.clone(),
            image_generator: self.image_generator.clone(),
            render: self.render.clone(),
            decompose: self.decompose.clone(),
            settle: SettleSettings {
                duration_s: self.settle.duration_s.min(MAX_SETTLING_S),
                ..self.settle.clone()
            },
            // The first rest pose is rendered; the finished scene is tested for stability in a later stage.
            resolve: ResolveSettings { settles: 0, ..self.resolve.clone() },
            certify: self.certify.clone(),
            photograph: self.photograph.clone(),
        }
    }
}

/// All inputs of a rendering besides description and seed.
#[derive(Clone, Debug, Serialize, PartialEq)]
struct Settings {
    layout: LayoutSettings,
    image_generator: ImageGeneratorSettings,
    render: RenderSettings,
    decompose: DecomposeSettings,
    settle: SettleSettings,
    resolve: ResolveSettings,
    certify: CertifySettings,
    photograph: SingleViewSettings,
}

impl ImageGenerator for EmbeddedImageGenerator {
    fn adapter(&self) -> Adapter {
        with_catalog(Adapter::new(Self::NAME, Self::MODEL, &self.settings()))
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        let settings = self.settings();
        let work = move |cancel: &CancelFlag| render(&description, seed, &settings, Wanted::Scene, cancel);
        call.compute(Port::ImageGenerator, work).boxed()
    }

    fn reference_of_objects<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        let mut settings = self.settings();
        // Isolated views keep their resolution.
        let shared = &mut settings.image_generator;
        (shared.width_px, shared.height_px) = (shared.width_px / 2, shared.height_px / 2);
        let work = move |cancel: &CancelFlag| render(&description, seed, &settings, Wanted::Objects, cancel);
        call.compute(Port::ImageGenerator, work).boxed()
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        let work = move |cancel: &CancelFlag| match request.alone {
            Some(alone) => Ok(alone),
            None => single_view_reconstruction::complete(&request, cancel),
        };
        call.compute(Port::ImageGenerator, work).boxed()
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopViewImage> {
        let settings = self.photograph.clone();
        let work = move |cancel: &CancelFlag| match request.rendered {
            Some(rendered) => Ok(rendered),
            None => single_view_reconstruction::top_view(&request, &settings, cancel),
        };
        call.compute(Port::ImageGenerator, work).boxed()
    }
}

/// Purpose of a rendered image.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Scene,
    /// The objects alone, without the view from above.
    Objects,
}

/// Renders a description, all steps in order.
fn render(
    description: &SceneDescription,
    seed: u64,
    settings: &Settings,
    wanted: Wanted,
    cancel: &CancelFlag,
) -> Result<GeneratedReference, ProviderError> {
    let supported = arrangement_supports::with_supports(description);
    match render_as_described(&supported, seed, settings, wanted, cancel) {
        // What cannot be stacked (a pyramid of balls) stands on the table, and the arrangement is reported as unmet.
        Err(error @ ProviderError::Rejected { .. }) if supported != *description => {
            tracing::debug!(%error, "the supports of an arrangement do not hold");
            render_as_described(description, seed, settings, wanted, cancel)
        }
        rendered => rendered,
    }
}

/// As [`render`], without supports that arrangements imply.
fn render_as_described(
    description: &SceneDescription,
    seed: u64,
    settings: &Settings,
    wanted: Wanted,
    cancel: &CancelFlag,
) -> Result<GeneratedReference, ProviderError> {
    let objects = timed("meshes", || objects::build(&description.objects))?;
    let arranged = table_growth::arrange_on_sufficient_table(description, &objects, seed, settings, cancel)?;
    let ArrangedTable { table, arrangement, viewpoint } = arranged;
    let scene = render_scene::RenderScene::new(&table, &objects, &arrangement, &viewpoint, &settings.render);
    cancel.check()?;
    let (views, top) = rayon::join(
        || {
            let frame = timed("picture", || scene.render());
            cancel.check()?;
            let masks = ground_truth::masks(&frame, &objects);
            let alone =
                timed("alone", || isolated_views::render(&scene, &objects, &masks, settings, cancel))?;
            Ok::<_, ProviderError>((frame, masks, alone))
        },
        || {
            let top = || timed("top view", || top_view::render(&scene, &objects, &table, settings, cancel));
            (wanted == Wanted::Scene).then(top).transpose()
        },
    );
    let ((frame, masks, alone), top) = (views?, top?);
    let posed = objects.iter().zip(&arrangement.poses);
    let footprints: Vec<_> = posed.map(|(object, pose)| posed_footprint(&object.mesh, pose)).collect();
    let stated = arrangement_supports::without_layers(description);
    Ok(GeneratedReference {
        unmet: unmet(&stated, &footprints, &table.outline),
        ground_truth: Some(SyntheticGroundTruth {
            stated,
            known: ground_truth::image(&table, &objects, &viewpoint, &frame, masks),
            truth: ground_truth::truth(&objects, &arrangement),
            alone,
            top,
        }),
        image: frame.color,
    })
}

/// Runs a step and logs its duration at debug level.
fn timed<T>(step: &str, run: impl FnOnce() -> T) -> T {
    let start = std::time::Instant::now();
    let result = run();
    tracing::debug!(step, milliseconds = 1e3 * start.elapsed().as_secs_f64(), "painted");
    result
}
