//! Stage 9: the metric layout. The top view gives one box per object; the alignment turns boxes, yaws and
//! commonsense sizes into places and scales; each object is then let down onto what carries it, what is in a container as its
//! box says that it leans.

pub mod layout;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, Settings, canonicalize, carry, decompose, reconstruct, reference, rotate, segment};
use geometry::{Outline, Pose};
use imaging::Image;
use ports::{Adapter, Ports, TopBoxes, TopCheck, TopPicture, TopVerdict, TopViewRequest};
use pose_estimation::tsa::{BoxFromAbove, Consensus, Registered, TsaSettings};
use render::overlay::{distinct_color, draw_box, draw_text};
use scene::request::MetricAnchor;
use scene::{InstanceId, InstanceMask, Recognition, RecognizedObject, SceneRequest, StandsOn};

pub const STAGE: Stage = Stage { name: "place", version: 7 };

/// Most drawings that anybody looks at, whatever a painter would go on drawing.
const MOST_DRAWINGS: usize = 8;

#[derive(Serialize)]
pub struct Inputs {
    picture: ArtifactRef,
    known: Option<ArtifactRef>,
    painted: Option<reference::TopRef>,
    recognition: Arc<Recognition>,
    masks: Arc<Vec<InstanceMask>>,
    instances: Vec<Instance>,
    table: Table,
    metric_anchor: Option<MetricAnchor>,
    tsa: TsaSettings,
    seed: u64,
    painter: Adapter,
    analyst: Adapter,
    segmenter: Adapter,
}

/// One object, as far as it is known.
#[derive(Clone, Serialize)]
pub(super) struct Instance {
    pub object: RecognizedObject,
    pub mesh: ArtifactRef,
    pub size_m: DVec3,
    pub hulls: ArtifactRef,
    pub yaw_rad: f64,
    pub confidence: f64,
    /// Where the reference camera sees its origin, world, meters.
    pub seen_m: Option<DVec2>,
}

#[derive(Clone, Serialize)]
pub(super) struct Table {
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    pub outline_m: Outline,
    /// Width and depth of the top, height above the floor.
    pub size_m: DVec3,
}

/// Where everything stands, before anything is repaired.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub alpha_m_per_px: f64,
    /// The object that set the scale; `None` where it was given, where all voted, or where the table did.
    pub anchor: Option<InstanceId>,
    /// What the objects agreed on; `None` where they did not vote.
    pub consensus: Option<Consensus>,
    /// How the boxes were laid on what the reference camera saw; `None` where they were not.
    pub registered: Option<Registered>,
    pub table: PlacedTable,
    /// In the order of the recognized objects.
    pub instances: Vec<PlacedInstance>,
    /// The table from above, without marks.
    pub top_view: ArtifactRef,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct PlacedTable {
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    pub outline_m: Outline,
    pub size_m: DVec3,
    /// Whether the top view overruled its commonsense size.
    pub rescaled: bool,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct PlacedInstance {
    pub id: InstanceId,
    /// With the scale baked in.
    pub mesh: ArtifactRef,
    pub hulls: ArtifactRef,
    pub size_m: DVec3,
    /// Factor on the commonsense size; 1 unless the top view knows better.
    pub scale: f64,
    pub world_from_object: Pose,
    /// Its box on the top view.
    pub seen_from_above: BoxFromAbove,
    pub stands_on: StandsOn,
    /// `A_px / (1 + (e / tau)^2)`, square pixels.
    pub rma_score: f64,
}

impl Inputs {
    #[expect(clippy::too_many_arguments, reason = "the layout is where all earlier stages meet")]
    pub fn new(
        request: &SceneRequest,
        reference: &reference::Output,
        recognition: &Arc<Recognition>,
        masks: &segment::Output,
        raw: &[reconstruct::Output],
        canonical: &[canonicalize::Output],
        hulls: &[decompose::Output],
        yaws: &[rotate::Output],
        ports: &Ports,
        settings: &Settings,
    ) -> Result<Self, StageError> {
        let (table, table_hulls) = raw.last().zip(hulls.last()).ok_or_else(no_table)?;
        let instances = recognition
            .objects
            .iter()
            .zip(canonical)
            .zip(hulls)
            .zip(yaws)
            .map(|(((object, canonical), hulls), yaw)| Instance {
                object: object.clone(),
                mesh: canonical.mesh.clone(),
                size_m: canonical.size_m,
                hulls: hulls.hulls.clone(),
                yaw_rad: yaw.yaw_rad,
                confidence: yaw.confidence,
                seen_m: yaw.seen_m.filter(|_| !matches!(object.stands_on, StandsOn::In(_))),
            })
            .collect();
        Ok(Self {
            picture: reference.picture.clone(),
            known: reference.known.clone(),
            painted: reference.top.clone(),
            recognition: recognition.clone(),
            masks: Arc::new(masks.masks.clone()),
            instances,
            table: Table {
                mesh: table.mesh.clone(),
                hulls: table_hulls.hulls.clone(),
                outline_m: table.outline_m.clone().ok_or_else(no_table)?,
                size_m: recognition.table.size_m,
            },
            metric_anchor: request.options.metric_anchor.clone(),
            tsa: settings.tsa.clone(),
            seed: request.seed,
            painter: ports.painter.adapter(),
            analyst: ports.analyst.adapter(),
            segmenter: ports.segmenter.adapter(),
        })
    }
}

impl Output {
    /// What carries the instance at `index`, counted with the table first, and whether it stands in it.
    pub fn support_of(&self, index: usize) -> (usize, bool) {
        let stands_on = &self.instances[index].stands_on;
        let parent = stands_on.object().and_then(|id| self.instances.iter().position(|i| &i.id == id));
        (parent.map_or(0, |parent| parent + 1), matches!(stands_on, StandsOn::In(_)))
    }
}

fn no_table() -> StageError {
    StageError::permanent("table_missing", "placing: no table was reconstructed; run again")
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let painted = match &inputs.painted {
        Some(stored) => Some(reference::top(&context, stored).await?),
        None => None,
    };
    let request = TopViewRequest {
        reference: reference::seen(&context, &inputs.picture, inputs.known.as_ref()).await?,
        recognition: inputs.recognition.clone(),
        masks: inputs.masks.clone(),
        painted,
        refused: Vec::new(),
    };
    let top = top_view(&context, &inputs, request).await?;
    let boxes = ports.segmenter.top_boxes(&call, top.clone(), inputs.recognition.clone()).await?;
    let top_view = carry::put_picture(&context, "top.png", top.picture.clone()).await?;
    let output = layout::lay_out(&context, &inputs, &boxes, top_view).await?;
    let drawn = {
        let (picture, output) = (top.picture, output.clone());
        context.cpu(move || annotated(picture, &boxes, &output)).await?
    };
    carry::put_picture(&context, "top_annotated.png", drawn).await?;
    context.put_json("layout.json", &output).await?;
    context.put_json("support_tree.json", &support_tree(&output)).await?;
    Ok(output)
}

/// The view from above. One that was computed knows where everything is; one that was drawn is looked at first, and drawn
/// again with what was wrong, until somebody says that it holds or the painter gives up.
async fn top_view(
    context: &Context,
    inputs: &Inputs,
    mut request: TopViewRequest,
) -> Result<TopPicture, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let mut verdicts: Vec<TopVerdict> = Vec::new();
    loop {
        let top = ports.painter.top_view(&call, request.clone()).await?;
        if top.known.is_some() {
            break Ok(top);
        }
        let question = TopCheck {
            reference: request.reference.clone(),
            recognition: request.recognition.clone(),
            top: Arc::new(top.picture.clone()),
            seed: inputs.seed,
        };
        let verdict = ports.analyst.check_top_view(&call, question).await?;
        let (holds, told) = (verdict.holds(), verdict.told.clone());
        verdicts.push(verdict);
        context.put_json("top_verdicts.json", &verdicts).await?;
        if holds {
            break Ok(top);
        }
        carry::put_picture(context, &format!("top_refused_{}.png", verdicts.len()), top.picture).await?;
        if verdicts.len() >= MOST_DRAWINGS {
            let told =
                format!("placing: none of {MOST_DRAWINGS} drawn views from above holds ({told}); run again");
            break Err(StageError::permanent("top_view_refused", told));
        }
        request.refused.push(told);
    }
}

/// The top view with every box, the anchor's thick.
fn annotated(mut picture: Image, boxes: &TopBoxes, output: &Output) -> Image {
    let rounded = |b: [f64; 4]| b.map(|side| side.round().max(0.0) as u32);
    draw_box(&mut picture, rounded(boxes.table_px), [90, 90, 96, 255], 2);
    for (index, (found, placed)) in boxes.objects.iter().zip(&output.instances).enumerate() {
        let thick = if output.anchor.as_ref() == Some(&placed.id) { 4 } else { 1 };
        draw_box(&mut picture, rounded(found.box_px), distinct_color(index), thick);
        let at = DVec2::new(found.box_px[0], found.box_px[1] - 10.0);
        draw_text(&mut picture, at.x as i64, at.y as i64, placed.id.as_str(), 1, [20, 20, 24, 255]);
    }
    picture
}

/// Who carries whom, the table at the root: `{"table": [{"mug_1": []}, ...]}` as nested lists.
fn support_tree(output: &Output) -> serde_json::Value {
    fn carried_by(output: &Output, parent: Option<&InstanceId>) -> Vec<serde_json::Value> {
        let carried = output.instances.iter().filter(|i| i.stands_on.object() == parent);
        carried
            .map(|instance| {
                let relation = match &instance.stands_on {
                    StandsOn::In(_) => "in",
                    StandsOn::On(_) | StandsOn::Table => "on",
                };
                serde_json::json!({
                    "name": instance.id,
                    "relation": relation,
                    "carries": carried_by(output, Some(&instance.id)),
                })
            })
            .collect()
    }
    serde_json::json!({ "name": "table", "carries": carried_by(output, None) })
}
