//! Camera, table and things of a picture, with sizes at a commonsense scale.

use glam::DVec3;

use super::{PhotographSettings, PictureReader, UNNAMED_CATEGORY};
use crate::catalog::{OUTLINED_TABLE, TableModel, table_models};
use crate::geometry::seed::child_seed;
use crate::geometry::{Image, Interrupt, Outline, Rgb};
use crate::provider::{Port, ProviderError};
use crate::scene::request::RequestOptions;
use crate::scene::{
    CameraKnowledge, InstanceId, Recognition, RecognizedObject, RecognizedTable, StandsOn, TableShape,
};
use crate::vision::{PictureReading, TopShape};

/// Depth over width from which a rectangle is taken for a square.
const SQUARE_FROM: f64 = 0.88;

/// Usual widths of tables that are no model, meters.
const USUAL_WIDTH_M: [f64; 2] = [0.8, 1.6];

/// Recognizes the picture. The scale is, in this order: the request's table size, the request's metric
/// anchor where it names the table, a table of usual height where the feet show, the usual width of such
/// tables.
pub fn recognize(
    picture: &Image,
    seed: u64,
    options: &RequestOptions,
    reader: &PictureReader,
    interrupt: &Interrupt,
) -> Result<Recognition, ProviderError> {
    let reading = reader.read(picture, Port::Analyst, interrupt)?;
    let limit = options.max_objects.unwrap_or(64) as usize;
    if reading.objects.len() > limit {
        return Err(ProviderError::Rejected {
            port: Port::Analyst,
            code: "too_many_objects",
            reason: format!(
                "the picture shows {} things, the request allows {limit}; raise max_objects or send a picture \
                 with fewer",
                reading.objects.len()
            ),
        });
    }
    let built = table_model(&reading, options)?;
    let size_m = table_size(&reading, &built, options, &reader.settings);
    let reading = (*reading).clone().scaled(size_m.x);
    let color = reading.table.color;
    let ids: Vec<InstanceId> =
        (1..=reading.objects.len()).map(|n| InstanceId::numbered(UNNAMED_CATEGORY, n)).collect();
    let eye_m = reading.camera.world_from_camera.translation_m.z;
    let objects = reading
        .objects
        .iter()
        .zip(&ids)
        .map(|(object, id)| {
            // What stands higher is nearer to the camera, hence smaller than on the table.
            let raised_m = lifted_by(&reading, object.stands_on);
            let nearer = ((eye_m - raised_m) / eye_m).clamp(0.2, 1.0);
            RecognizedObject {
                id: id.clone(),
                label: UNNAMED_CATEGORY.to_owned(),
                category: UNNAMED_CATEGORY.to_owned(),
                size_m: (nearer * object.solid.size).max(DVec3::splat(0.002)),
                color: Some(object.color),
                material: None,
                seed: child_seed(seed, id.as_str()),
                stands_on: object.stands_on.map_or(StandsOn::Table, |k| StandsOn::On(ids[k].clone())),
                seen_px: None,
                seen_as: Some(object.solid.clone()),
            }
        })
        .collect();
    Ok(Recognition {
        camera: reading.camera,
        camera_is: CameraKnowledge::Measured,
        table: RecognizedTable {
            label: built.label.to_owned(),
            shape: built.shape,
            model: built.model.map_or(OUTLINED_TABLE, |model| model.name).to_owned(),
            outline_m: match built.model {
                Some(_) => None,
                None => Outline::new(reading.table.outline.clone()).ok(),
            },
            size_m,
            color: Some(color),
            material: options.table.as_ref().and_then(|t| t.material.clone()).or(wood_of(color)),
            seed: child_seed(seed, "table"),
        },
        objects,
    })
}

/// Height of what carries a thing, however many are below it.
pub(super) fn lifted_by(reading: &PictureReading, support: Option<usize>) -> f64 {
    let (mut at, mut height) = (support, 0.0);
    for _ in 0..reading.objects.len() {
        let Some(k) = at else { break };
        height += reading.objects[k].solid.size.z;
        at = reading.objects[k].stands_on;
    }
    height
}

/// What the table is built as.
struct Built {
    label: &'static str,
    shape: TableShape,
    /// Of the catalog; `None` = a top of the outline that was seen.
    model: Option<&'static TableModel>,
    /// Range of usual widths, meters.
    usual_m: [f64; 2],
}

/// The request's model, or the plainest of the shape seen.
fn table_model(reading: &PictureReading, options: &RequestOptions) -> Result<Built, ProviderError> {
    let depth = reading.table.depth;
    let is_square = (SQUARE_FROM..=1.0 / SQUARE_FROM).contains(&depth);
    let (seen, usual, shape): (&[&str], _, _) = match reading.table.shape {
        TopShape::Circle => (&["round"], Some("round_table"), TableShape::Round),
        TopShape::Rectangle if is_square => {
            (&["rectangular", "square"], Some("square_table"), TableShape::Square)
        }
        TopShape::Rectangle => (&["rectangular", "square"], Some("dining_table"), TableShape::Rectangular),
        TopShape::Oval => (&["oval"], None, TableShape::Oval),
        TopShape::Triangle => (&["triangular"], None, TableShape::Triangular),
        TopShape::Irregular => (&["irregular"], None, TableShape::Irregular),
    };
    let wanted = options.table.as_ref();
    let differs = |what: String| ProviderError::Rejected {
        port: Port::Analyst,
        code: "table_differs",
        reason: format!(
            "the request asks for {what}, but the picture shows a {} table top; leave the table out of the \
             request or send another picture",
            seen[0]
        ),
    };
    if let Some(asked) = wanted.and_then(|table| table.shape).filter(|asked| !seen.contains(&word_of(*asked)))
    {
        return Err(differs(format!("a {} table", word_of(asked))));
    }
    let named = wanted.and_then(|table| table.model.as_deref());
    let Some(name) = named.or(usual) else {
        return Ok(Built { label: "table", shape, model: None, usual_m: USUAL_WIDTH_M });
    };
    let model = table_models()
        .iter()
        .find(|model| model.name == name && seen.contains(&model.shape))
        .ok_or_else(|| differs(format!("the table model {name}")))?;
    let usual_m = [model.low_m.x, model.high_m.x];
    Ok(Built { label: model.label, shape: shape_of(model), model: Some(model), usual_m })
}

/// Width, depth, height in meters.
fn table_size(
    reading: &PictureReading,
    built: &Built,
    options: &RequestOptions,
    settings: &PhotographSettings,
) -> DVec3 {
    let wanted = options.table.as_ref().and_then(|table| table.size_m);
    let anchor = options.metric_anchor.as_ref().filter(|anchor| anchor.object == "table");
    let [narrow_m, wide_m] = built.usual_m;
    let usual_m = 0.5 * (narrow_m + wide_m);
    let by_feet_m = reading.table.height.map(|height| settings.sizes.table_height_m / height);
    let width_m = wanted
        .map(|size| size.x)
        .or(anchor.map(|anchor| anchor.width_m))
        .or(by_feet_m.map(|width| width.clamp(0.75 * narrow_m, 1.25 * wide_m)))
        .unwrap_or(usual_m);
    let height_m = wanted.map_or(settings.sizes.table_height_m, |size| size.z);
    DVec3::new(width_m, width_m * reading.table.depth, height_m)
}

fn shape_of(model: &TableModel) -> TableShape {
    match model.shape {
        "square" => TableShape::Square,
        "round" => TableShape::Round,
        "oval" => TableShape::Oval,
        "triangular" => TableShape::Triangular,
        "irregular" => TableShape::Irregular,
        _ => TableShape::Rectangular,
    }
}

fn word_of(shape: TableShape) -> &'static str {
    match shape {
        TableShape::Rectangular => "rectangular",
        TableShape::Square => "square",
        TableShape::Round => "round",
        TableShape::Oval => "oval",
        TableShape::Triangular => "triangular",
        TableShape::Irregular => "irregular",
    }
}

/// A top of a brown, yellow or orange hue is taken for wood, in its own color.
fn wood_of(color: Rgb) -> Option<String> {
    let [r, g, b] = color.0;
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let brown = r >= g && g >= b && most - least > 0.12 && most - least < 0.6 && (g - b) > 0.25 * (r - b);
    brown.then(|| "oak".to_owned())
}
