//! The embedded painter: it arranges the catalog's things on a table, lets them settle, and renders them.
//!
//! `reference` builds every mesh of a description, lays them out ([`super::layout`]), resolves the layout
//! into poses that hold ([`physics::resolve`]), looks for a camera from which every object shows, and
//! paints a product picture. Since the painter is a program it also hands out what it knows: labels, masks,
//! camera (`known`), the poses (`truth`), each object drawn alone, and the view from above. Pictures it
//! did not paint are completed and seen from above by [`super::photograph`].
//!
//! Guarantees: same description, seed and settings, same bytes; the recognized sizes, colors, materials and
//! seeds build exactly the painted meshes. Cost: for twelve objects see the stage `reference` in
//! `docs/results/generate_time.md`; what lies in containers may take several arrangements.

mod table;
mod props;
mod arrangement;
mod view;
mod stage;
mod alone;
mod overhead;
mod known;
mod error;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use futures::FutureExt;
use serde::{Deserialize, Serialize};

use super::layout::LayoutSettings;
use super::photograph::{self, PhotographSettings};
use geometry::decompose::DecomposeSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, Painter, Painting, PaintingAside, Port,
    ProviderError, TopPicture, TopViewRequest,
};
use render::RenderSettings;
use runtime::Interrupt;
use runtime::seed::child_seed;
use scene::SceneDescription;
pub use table::{PaintedTable, paint_table};

use self::arrangement::Arrangement;
use self::props::Prop;
use self::view::Viewpoint;

/// Section `[painter]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PainterSettings {
    /// Width of the reference picture, pixels, 64..4096. More: finer masks, time in proportion.
    pub width_px: u32,
    /// Its height, pixels, 64..4096.
    pub height_px: u32,
    /// Horizontal field of view, radians, 0.2..1.5. More: stronger perspective.
    pub fov_x_rad: f64,
    /// Lowest and highest elevation of the camera, radians, 0.3..1.5. Lower shows more sides and hides more.
    pub elevation_rad: [f64; 2],
    /// The camera stands at most this far from the front's middle, radians, 0..1.
    pub azimuth_rad: f64,
    /// Share of the picture left free on each side, 0..0.3.
    pub frame_margin: f64,
    /// Cameras tried before the arrangement is given up, 1..64. More: less hidden.
    pub views: u32,
    /// Every object must show at least this share of its silhouette, 0..1. More: fewer overlaps in the
    /// picture, more tries.
    pub least_visible_share: f64,
    /// Arrangements tried before giving up, 1..32.
    pub arrangements: u32,
    /// Longer side of an object drawn alone, pixels, 64..1024; larger where it is larger in the picture.
    pub alone_px: u32,
    /// Longer side of the view from above, pixels, 64..4096.
    pub top_px: u32,
}

/// Things are let go for at most this long before they are painted, seconds.
const LONGEST_SETTLING_S: f64 = 2.0;

/// Adapter `embedded/painter`.
pub struct EmbeddedPainter {
    pub photograph: PhotographSettings,
    pub layout: LayoutSettings,
    pub painter: PainterSettings,
    pub render: RenderSettings,
    pub decompose: DecomposeSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub certify: CertifySettings,
}

impl EmbeddedPainter {
    const NAME: &str = "embedded/painter";
    const MODEL: &str = "2";

    fn settings(&self) -> Settings {
        Settings {
            layout: self.layout.clone(),
            painter: self.painter.clone(),
            render: self.render.clone(),
            decompose: self.decompose.clone(),
            settle: SettleSettings {
                duration_s: self.settle.duration_s.min(LONGEST_SETTLING_S),
                ..self.settle.clone()
            },
            // A picture is taken of the first rest pose; whether it lasts is for the finished scene to show.
            resolve: ResolveSettings { settles: 0, ..self.resolve.clone() },
            certify: self.certify.clone(),
            photograph: self.photograph.clone(),
        }
    }
}

/// Everything that decides a painting besides description and seed.
#[derive(Clone, Debug, Serialize, PartialEq)]
struct Settings {
    layout: LayoutSettings,
    painter: PainterSettings,
    render: RenderSettings,
    decompose: DecomposeSettings,
    settle: SettleSettings,
    resolve: ResolveSettings,
    certify: CertifySettings,
    photograph: PhotographSettings,
}

impl Painter for EmbeddedPainter {
    fn adapter(&self) -> Adapter {
        Adapter::new(Self::NAME, Self::MODEL, &self.settings())
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, Painting> {
        let settings = self.settings();
        call.compute(Port::Painter, move |interrupt| paint(&description, seed, &settings, interrupt)).boxed()
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        let work = move |interrupt: &Interrupt| match request.alone {
            Some(alone) => Ok(alone),
            None => photograph::complete(&request, interrupt),
        };
        call.compute(Port::Painter, work).boxed()
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture> {
        let settings = self.photograph.clone();
        let work = move |interrupt: &Interrupt| match request.painted {
            Some(painted) => Ok(painted),
            None => photograph::top_view(&request, &settings, interrupt),
        };
        call.compute(Port::Painter, work).boxed()
    }
}

/// Paints a description: every step in order.
fn paint(
    description: &SceneDescription,
    seed: u64,
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<Painting, ProviderError> {
    let table = timed("table", || paint_table(&description.table, seed))?;
    let props = timed("meshes", || props::build(&description.objects))?;
    let bodies = timed("bodies", || props::bodies(&table, &props, &settings.decompose, interrupt))?;
    let (arrangement, viewpoint) = arrange(&table, &props, &bodies, seed, settings, interrupt)?;
    let stage = stage::Stage::new(&table, &props, &arrangement, &viewpoint, &settings.render);
    interrupt.check()?;
    let (seen, top) = rayon::join(
        || {
            let frame = timed("picture", || stage.paint());
            interrupt.check()?;
            let masks = known::masks(&frame, &props);
            let alone = timed("alone", || alone::draw(&stage, &props, &masks, settings, interrupt))?;
            Ok::<_, ProviderError>((frame, masks, alone))
        },
        || timed("top view", || overhead::paint(&stage, &props, &table, settings, interrupt)),
    );
    let ((frame, masks, alone), top) = (seen?, top?);
    Ok(Painting {
        aside: Some(PaintingAside {
            known: known::picture(&table, &props, &viewpoint, &frame, masks),
            truth: known::truth(&props, &arrangement),
            alone,
            top,
        }),
        picture: frame.color,
    })
}

/// An arrangement that holds and a camera from which everything in it shows.
fn arrange(
    table: &PaintedTable,
    props: &[Prop],
    bodies: &props::Bodies,
    seed: u64,
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<(Arrangement, Viewpoint), ProviderError> {
    let mut refusal: Option<ProviderError> = None;
    let mut best: Option<(Arrangement, Viewpoint)> = None;
    for number in 0..settings.painter.arrangements.max(1) {
        let seed = child_seed(seed, &format!("arrangement {number}"));
        let found =
            timed("arrangement", || arrangement::arrange(table, props, bodies, seed, settings, interrupt));
        let arrangement = match found {
            Ok(arrangement) => arrangement,
            Err(ProviderError::Interrupted(interrupted)) => return Err(interrupted.into()),
            Err(error) => {
                tracing::debug!(%error, number, "an arrangement did not hold");
                refusal = Some(error);
                continue;
            }
        };
        let viewpoint = timed("viewpoint", || {
            view::choose(table, props, &arrangement, seed, &settings.painter, interrupt)
        })?;
        let enough = viewpoint.least_visible_share >= settings.painter.least_visible_share;
        let better =
            best.as_ref().is_none_or(|(_, known)| viewpoint.least_visible_share > known.least_visible_share);
        if better {
            best = Some((arrangement, viewpoint));
        }
        if enough {
            break;
        }
    }
    match best {
        Some((_, viewpoint)) if viewpoint.least_visible_share <= 0.0 => Err(error::hidden(&viewpoint.hidden)),
        Some(found) => Ok(found),
        None => Err(refusal.unwrap_or_else(|| error::hidden(&[]))),
    }
}

/// Runs a step and says at debug level how long it took.
fn timed<T>(step: &str, work: impl FnOnce() -> T) -> T {
    let start = std::time::Instant::now();
    let result = work();
    tracing::debug!(step, milliseconds = 1e3 * start.elapsed().as_secs_f64(), "painted");
    result
}
