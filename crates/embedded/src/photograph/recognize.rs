//! Camera, table and things of a picture, with sizes at a commonsense scale, and names where a category is likely enough.

use glam::DVec3;

use scene::UNNAMED_CATEGORY;

use super::{PhotographSettings, PictureReader};
use catalog::{OUTLINED_TABLE, TableModel, category, table_models};
use geometry::{Outline, Rgb};
use imaging::Image;
use ports::{Port, ProviderError};
use runtime::Interrupt;
use runtime::seed::child_seed;
use scene::request::RequestOptions;
use scene::{
    CameraKnowledge, CategoryStance, InstanceId, Recognition, RecognizedObject, RecognizedTable, StandsOn,
    TableShape,
};
use vision::category_fit;
use vision::category_fit::Named;
use vision::{ObjectReading, PictureReading, TopShape};

/// Depth over width from which a rectangle is taken for a square.
const SQUARE_FROM: f64 = 0.88;

/// Usual widths of tables that are no model, meters.
const USUAL_WIDTH_M: [f64; 2] = [0.8, 1.6];

/// How much less than the simple solid's a category's outline may overlap with the pixels and still give the shape: a solid
/// takes any outline, a category has its own.
const SHAPE_DOUBT: f64 = 0.06;

/// Logarithm of a scale's correction below which nothing is corrected.
const LEAST_CORRECTION: f64 = 0.1;

/// Recognizes the picture. The scale is, in this order: the request's table size, the request's metric
/// anchor where it names the table, what several named things agree on, a table of usual height where the feet show,
/// the usual width of such tables.
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
    let settings = &reader.settings.naming;
    let evidence = category_fit::evidence(picture, &reading, settings, interrupt)?;
    let naming = category_fit::names(&evidence, settings, |_, _| true);
    let correction =
        naming.scale.filter(|scale| !scale_is_given(options) && scale.ln().abs() > LEAST_CORRECTION);
    let correction = correction.unwrap_or(1.0);
    let size_m = DVec3::new(correction * size_m.x, correction * size_m.y, size_m.z);
    let reading = reading.scaled(correction);
    let color = reading.table.color;
    let ids = ids(&naming.things);
    let seen = reading.objects.iter().zip(&ids).zip(&naming.things).enumerate();
    let objects = seen
        .map(|(index, ((object, id), named))| {
            let nearer = reading.nearer(index);
            let category = named.as_ref().and_then(|named| category(named.look.category));
            let seen_like = named.as_ref().and_then(|named| stance(named, object, correction));
            let extents_m = seen_like.as_ref().map_or(object.solid.size, |like| like.size_m);
            RecognizedObject {
                id: id.clone(),
                label: category.map_or(UNNAMED_CATEGORY, |category| &category.label).to_owned(),
                category: category.map_or(UNNAMED_CATEGORY, |category| &category.name).to_owned(),
                size_m: (nearer * extents_m).max(DVec3::splat(0.002)),
                color: Some(object.color),
                material: None,
                seed: child_seed(seed, id.as_str()),
                stands_on: object.stands_on.map_or(StandsOn::Table, |k| StandsOn::On(ids[k].clone())),
                seen_px: None,
                seen_as: Some(object.solid.clone()),
                seen_like,
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

/// Whether the request says how large the table is.
fn scale_is_given(options: &RequestOptions) -> bool {
    let anchored = options.metric_anchor.as_ref().is_some_and(|anchor| anchor.object == "table");
    anchored || options.table.as_ref().is_some_and(|table| table.size_m.is_some())
}

/// Each category counts its own things.
fn ids(things: &[Option<Named>]) -> Vec<InstanceId> {
    let stem = |named: &Option<Named>| named.as_ref().map_or(UNNAMED_CATEGORY, |named| named.look.category);
    let number =
        |index: usize| things[..=index].iter().filter(|other| stem(other) == stem(&things[index])).count();
    (0..things.len()).map(|index| InstanceId::numbered(stem(&things[index]), number(index))).collect()
}

/// The category's mesh as the thing was seen, if its outline is about as good as the solid's.
fn stance(named: &Named, object: &ObjectReading, correction: f64) -> Option<CategoryStance> {
    let look = &named.look;
    (look.overlap >= object.solid.overlap - SHAPE_DOUBT).then(|| CategoryStance {
        variant: look.variant,
        center: correction * look.center,
        yaw_rad: look.yaw_rad,
        size_m: correction * look.size_m,
        overlap: look.overlap,
    })
}

/// The reading in meters, at the scale that a request without wishes has; as it is where no table is like it.
pub fn at_usual_scale(reading: &PictureReading, settings: &PhotographSettings) -> PictureReading {
    let options = RequestOptions::default();
    let width_m =
        table_model(reading, &options).map_or(1.0, |built| table_size(reading, &built, &options, settings).x);
    reading.clone().scaled(width_m)
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
