//! Stage `place`: the metric layout. The top view gives one box per object; the alignment turns boxes, yaws and
//! commonsense sizes into places and scales; each object is then let down onto what carries it, what is in a container
//! as its box says that it leans.

pub mod layout;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, PreparedObjects, artifact_io, reconstruct, reference, rotate};
use geometry::{Outline, Pose};
use imaging::Image;
use ports::{Adapter, TopBoxes, TopCheck, TopVerdict, TopViewImage, TopViewRequest};
use pose_estimation::top_view_layout::{BoxFromAbove, Consensus, Registration, TopViewSettings};
use render::annotate::{distinct_color, draw_box, draw_text};
use scene::request::MetricAnchor;
use scene::{InstanceId, InstanceMask, Recognition, RecognizedObject, SupportTree};

pub const STAGE: Stage = Stage { name: "place", version: 9 };

/// Most top views that are checked before the stage gives up, whatever the image generator would go on drawing.
const MAX_DRAWINGS: usize = 8;

#[derive(Serialize)]
pub struct Inputs {
    image: ArtifactRef,
    known: Option<ArtifactRef>,
    rendered: Option<reference::TopRef>,
    recognition: Arc<Recognition>,
    masks: Arc<Vec<InstanceMask>>,
    instances: Vec<Instance>,
    supports: SupportTree,
    table: Table,
    metric_anchor: Option<MetricAnchor>,
    tsa: TopViewSettings,
    seed: u64,
    image_generator: Adapter,
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
    /// Origin of the object as the reference camera sees it, world, meters.
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

/// Layout before any repair.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub alpha_m_per_px: f64,
    /// The object that set the scale; `None` where it was given, where all voted, or where the table did.
    pub anchor: Option<InstanceId>,
    /// Scale on which the objects agreed; `None` where they did not vote.
    pub consensus: Option<Consensus>,
    /// Registration of the boxes with the view of the reference camera; `None` where there was none.
    pub registered: Option<Registration>,
    pub table: PlacedTable,
    /// In the order of the recognized objects.
    pub instances: Vec<PlacedInstance>,
    /// Of the instances.
    pub supports: SupportTree,
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
    /// Box of the object on the top view.
    pub seen_from_above: BoxFromAbove,
    /// `A_px / (1 + (e / tau)^2)`, square pixels.
    pub rma_score: f64,
}

impl Inputs {
    /// Inputs of the layout, with one yaw per object in order.
    ///
    /// # Errors
    ///
    /// `table_missing`, where no table was reconstructed.
    pub fn new(objects: &PreparedObjects, yaws: &[rotate::Output]) -> Result<Self, StageError> {
        let PreparedObjects { request, ports, settings, reference, recognition, masks, .. } = objects;
        let PreparedObjects { supports, raw_meshes, canonical_meshes, hulls, .. } = objects;
        let table = reconstruct::of_table(recognition, raw_meshes);
        let (table, table_hulls) =
            table.zip(reconstruct::of_table(recognition, hulls)).ok_or_else(no_table)?;
        let instances = recognition
            .objects
            .iter()
            .zip(canonical_meshes)
            .zip(hulls)
            .zip(yaws)
            .enumerate()
            .map(|(index, (((object, canonical), hulls), yaw))| Instance {
                object: object.clone(),
                mesh: canonical.mesh.clone(),
                size_m: canonical.size_m,
                hulls: hulls.hulls.clone(),
                yaw_rad: yaw.yaw_rad,
                confidence: yaw.confidence,
                seen_m: yaw.seen_m.filter(|_| !supports.supporter(index).is_container()),
            })
            .collect();
        Ok(Self {
            image: reference.image.clone(),
            known: reference.known.clone(),
            rendered: reference.top.clone(),
            recognition: recognition.clone(),
            masks: Arc::new(masks.masks.clone()),
            instances,
            supports: supports.clone(),
            table: Table {
                mesh: table.mesh.clone(),
                hulls: table_hulls.hulls.clone(),
                outline_m: table.outline_m.clone().ok_or_else(no_table)?,
                size_m: recognition.table.size_m,
            },
            metric_anchor: request.options.metric_anchor.clone(),
            tsa: settings.tsa.clone(),
            seed: request.seed,
            image_generator: ports.image_generator.adapter(),
            analyst: ports.analyst.adapter(),
            segmenter: ports.segmenter.adapter(),
        })
    }
}

impl Inputs {
    /// Whether the sizes are those of the meshes in the image: it was rendered here and recognized here, and no stated
    /// width corrects them.
    fn knows_sizes(&self) -> bool {
        let is_embedded = self.analyst.name.starts_with("embedded/");
        self.rendered.is_some() && self.known.is_some() && is_embedded && self.metric_anchor.is_none()
    }
}

fn no_table() -> StageError {
    StageError::permanent("table_missing", "placing: no table was reconstructed; run again")
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let rendered = match &inputs.rendered {
        Some(stored) => Some(reference::top(&context, stored).await?),
        None => None,
    };
    let request = TopViewRequest {
        reference: reference::seen(&context, &inputs.image, inputs.known.as_ref(), None).await?,
        recognition: inputs.recognition.clone(),
        masks: inputs.masks.clone(),
        rendered,
        refused: Vec::new(),
    };
    let top = top_view(&context, &inputs, request).await?;
    let boxes = ports.segmenter.top_boxes(&call, top.clone(), inputs.recognition.clone()).await?;
    let rendered = inputs.rendered.as_ref().map(|top| &top.image);
    let top_view = artifact_io::put_input_image(&context, "top.png", top.image.clone(), rendered).await?;
    let output = layout::lay_out(&context, &inputs, &boxes, top_view).await?;
    let drawn = {
        let (image, output) = (top.image, output.clone());
        context.cpu(move || annotated(image, &boxes, &output)).await?
    };
    artifact_io::put_image(&context, "top_annotated.png", drawn).await?;
    context.put_json("layout.json", &output).await?;
    context.put_json("support_tree.json", &support_tree(&output)).await?;
    Ok(output)
}

/// The top view. A computed view has exact boxes. A generated view is checked by the analyst and generated again
/// with the analyst's feedback, until the analyst accepts it or the image generator gives up.
async fn top_view(
    context: &Context,
    inputs: &Inputs,
    mut request: TopViewRequest,
) -> Result<TopViewImage, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let mut verdicts: Vec<TopVerdict> = Vec::new();
    loop {
        let top = ports.image_generator.top_view(&call, request.clone()).await?;
        if top.known.is_some() {
            break Ok(top);
        }
        let question = TopCheck {
            reference: request.reference.clone(),
            recognition: request.recognition.clone(),
            top: Arc::new(top.image.clone()),
            seed: inputs.seed,
        };
        let verdict = ports.analyst.check_top_view(&call, question).await?;
        let (holds, message) = (verdict.holds(), verdict.feedback.clone());
        verdicts.push(verdict);
        context.put_json("top_verdicts.json", &verdicts).await?;
        if holds {
            break Ok(top);
        }
        artifact_io::put_image(context, &format!("top_refused_{}.png", verdicts.len()), top.image).await?;
        if verdicts.len() >= MAX_DRAWINGS {
            let message = format!(
                "placing: none of {MAX_DRAWINGS} drawn views from above holds ({message}); run again"
            );
            break Err(StageError::permanent("top_view_refused", message));
        }
        request.refused.push(message);
    }
}

/// The top view with every box, the anchor's thick.
fn annotated(mut image: Image, boxes: &TopBoxes, output: &Output) -> Image {
    let rounded = |b: [f64; 4]| b.map(|side| side.round().max(0.0) as u32);
    draw_box(&mut image, rounded(boxes.table_px), [90, 90, 96, 255], 2);
    for (index, (found, placed)) in boxes.objects.iter().zip(&output.instances).enumerate() {
        let thick = if output.anchor.as_ref() == Some(&placed.id) { 4 } else { 1 };
        draw_box(&mut image, rounded(found.box_px), distinct_color(index), thick);
        let at = DVec2::new(found.box_px[0], found.box_px[1] - 10.0);
        draw_text(&mut image, at.x as i64, at.y as i64, placed.id.as_str(), 1, [20, 20, 24, 255]);
    }
    image
}

/// Support tree with the table at the root: `{"table": [{"mug_1": []}, ...]}` as nested lists.
fn support_tree(output: &Output) -> serde_json::Value {
    fn carried_by(output: &Output, parent: Option<usize>) -> Vec<serde_json::Value> {
        let carried = output.supports.children(parent);
        carried
            .map(|index| {
                serde_json::json!({
                    "name": output.instances[index].id,
                    "relation": output.supports.supporter(index).relation,
                    "carries": carried_by(output, Some(index)),
                })
            })
            .collect()
    }
    serde_json::json!({ "name": "table", "carries": carried_by(output, None) })
}
