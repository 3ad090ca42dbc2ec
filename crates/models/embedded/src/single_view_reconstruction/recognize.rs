//! Recognition: camera, table and objects of an image, with sizes at a commonsense scale and category names.

use std::collections::BTreeSet;

use glam::DVec3;

use scene::UNNAMED_CATEGORY;

use super::text_naming::{ObjectNames, name_objects, state_supports};
use super::{ImageReader, SingleViewSettings};
use catalog::{OUTLINED_TABLE, TableModel, category, table_models};
use geometry::{Outline, Rgb};
use imaging::{Image, Mask};
use ports::{NamedObject, Port, ProviderError, RecognitionHints, ReferenceImage};
use runtime::CancelFlag;
use runtime::seed::child_seed;
use scene::instance::SupportRelation;
use scene::request::RequestOptions;
use scene::{
    CameraKnowledge, CategoryStance, DepthAccount, InstanceId, Recognition, RecognizedObject,
    RecognizedTable, StandsOn, TableShape,
};
use vision::category_fit::CategoryAssignment;
use vision::{DepthUse, ImageReading, ObjectReading, TopShape};

/// Ratio of depth to width from which a rectangle counts as a square.
const SQUARE_FROM: f64 = 0.88;

/// Typical widths of tables without a catalog model, meters.
const USUAL_WIDTH_M: [f64; 2] = [0.8, 1.6];

/// Maximum deficit of a category's overlap relative to the primitive's. A primitive adapts to any outline; a
/// category does not.
const SHAPE_DOUBT: f64 = 0.06;

/// Minimum logarithm of an applied scale correction.
const MIN_CORRECTION: f64 = 0.1;

/// Recognizes the image. The scale comes from the first available source: the request's table size, the request's
/// metric anchor for the table, a depth image, the agreement of several categorized objects, a table of standard height
/// with visible feet, the typical width of such tables. `hints` are what a text says is in the image; the sizes that it
/// states come before the agreement of categories.
///
/// # Errors
///
/// [`ProviderError::Rejected`] with a stable code if the image cannot be read or contradicts the request.
pub fn recognize(
    reference: &ReferenceImage,
    seed: u64,
    options: &RequestOptions,
    hints: Option<&RecognitionHints>,
    reader: &ImageReader,
    cancel: &CancelFlag,
) -> Result<Recognition, ProviderError> {
    let image: &Image = &reference.image;
    let reading = reader.read(reference, Port::Analyst, cancel)?;
    let limit = options.max_objects.unwrap_or(64) as usize;
    if reading.objects.len() > limit {
        return Err(ProviderError::Rejected {
            port: Port::Analyst,
            code: "too_many_objects",
            reason: format!(
                "the image shows {} objects, the request allows {limit}; raise max_objects or send an image \
                 with fewer",
                reading.objects.len()
            ),
        });
    }
    let built = table_model(&reading, options)?;
    let size_m = table_size(&reading, &built, options, &reader.settings);
    let reading = (*reading).clone().scaled(size_m.x);
    let guesses = reader.guesses(image, &reading, cancel)?;
    let naming = name_objects(image, &reading, &guesses, hints, &reader.settings.naming, cancel)?;
    let correction = scale_correction(naming.scale, naming.scale_is_stated, options, &reading);
    let size_m = DVec3::new(correction * size_m.x, correction * size_m.y, size_m.z);
    let mut reading = reading.scaled(correction);
    let relations = hints.map(|hints| state_supports(&mut reading, hints, &naming.named));
    let color = reading.table.color;
    let ids = ids(&naming, hints);
    let seen = reading.objects.iter().zip(&ids).zip(&naming.categories).enumerate();
    let objects = seen
        .map(|(index, ((object, id), named))| {
            let nearer = reading.support_scale(index);
            let category = named.as_ref().and_then(|named| category(named.category_match.category));
            let seen_like = named.as_ref().and_then(|named| stance(named, object, correction));
            let is_inside = relations.as_ref().is_some_and(|all| all[index] == SupportRelation::In);
            let carried: fn(InstanceId) -> StandsOn = if is_inside { StandsOn::In } else { StandsOn::On };
            let extents_m = seen_like.as_ref().map_or(object.solid.size, |like| like.size_m);
            RecognizedObject {
                id: id.clone(),
                label: category.map_or(UNNAMED_CATEGORY, |category| &category.label).to_owned(),
                category: category.map_or(UNNAMED_CATEGORY, |category| &category.name).to_owned(),
                size_m: (nearer * extents_m).max(DVec3::splat(0.002)),
                tipped: None,
                color: Some(object.color),
                material: None,
                seed: child_seed(seed, id.as_str()),
                stands_on: object.stands_on.map_or(StandsOn::Table, |k| carried(ids[k].clone())),
                seen_px: None,
                seen_as: Some(object.solid.clone()),
                seen_like,
                mass_kg: None,
                stand_in: None,
            }
        })
        .collect();
    let mut recognition = Recognition {
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
        left_out_px: reading.left_out.iter().filter_map(Mask::bbox_px).collect(),
        depth: reading.depth.as_ref().map(depth_account),
    };
    if let Some(hints) = hints {
        hints.apply(&mut recognition);
    }
    Ok(recognition)
}

/// The account of the use of a depth image.
fn depth_account(depth: &DepthUse) -> DepthAccount {
    match depth {
        DepthUse::Used { plane_rms_m, .. } => DepthAccount {
            is_used: true,
            note: format!(
                "camera, scale and heights are from the depth image; the table top is even to {:.1} mm",
                1e3 * plane_rms_m
            ),
        },
        DepthUse::Unused(doubt) => DepthAccount {
            is_used: false,
            note: format!(
                "the depth image contradicts the image, which alone was used: {doubt}; check that its pixels are those \
                 of the image, its unit millimeters, and the intrinsics those of its camera"
            ),
        },
    }
}

/// Factor on the scale of a reading by the agreement of its named objects, whose sizes a text may state: 1 where the
/// scale is given, or about right.
pub fn scale_correction(
    agreed: Option<f64>,
    is_stated: bool,
    options: &RequestOptions,
    reading: &ImageReading,
) -> f64 {
    let is_large = |scale: &f64| scale.ln().abs() > MIN_CORRECTION;
    let applied = agreed.filter(|scale| !scale_is_given(options, reading) && (is_stated || is_large(scale)));
    applied.unwrap_or(1.0)
}

/// Whether the request or a depth image determines the size of the table.
fn scale_is_given(options: &RequestOptions, reading: &ImageReading) -> bool {
    let anchored = options.metric_anchor.as_ref().is_some_and(|anchor| anchor.object == "table");
    anchored
        || reading.measured_meters_per_unit().is_some()
        || options.table.as_ref().is_some_and(|table| table.size_m.is_some())
}

/// Instance ids: those of the text, others numbered per category.
fn ids(names: &ObjectNames, hints: Option<&RecognitionHints>) -> Vec<InstanceId> {
    let of_text: &[NamedObject] = hints.map_or(&[], RecognitionHints::named);
    let mut taken: BTreeSet<InstanceId> = of_text.iter().map(|named| named.id.clone()).collect();
    let objects = names.named.iter().zip(&names.categories);
    objects
        .map(|(named, category)| match named {
            Some(named) => of_text[*named].id.clone(),
            None => {
                let stem = category.as_ref().map_or(UNNAMED_CATEGORY, |found| found.category_match.category);
                let mut numbers = (1..).map(|number| InstanceId::numbered(stem, number));
                let free = numbers.find(|id| taken.insert(id.clone()));
                free.unwrap_or_else(|| InstanceId::numbered(stem, 0))
            }
        })
        .collect()
}

/// The stance of the category's mesh, if its outline fits about as well as the primitive.
fn stance(named: &CategoryAssignment, object: &ObjectReading, correction: f64) -> Option<CategoryStance> {
    let found = &named.category_match;
    (found.is_fitted && !found.is_lying && found.overlap >= object.solid.overlap - SHAPE_DOUBT).then(|| {
        CategoryStance {
            variant: found.variant,
            center: correction * found.center,
            yaw_rad: found.yaw_rad,
            size_m: correction * found.size_m,
            overlap: found.overlap,
        }
    })
}

/// The reading in meters, at the scale of a request without options; unchanged if no table model matches.
pub fn at_usual_scale(reading: &ImageReading, settings: &SingleViewSettings) -> ImageReading {
    let options = RequestOptions::default();
    let width_m =
        table_model(reading, &options).map_or(1.0, |built| table_size(reading, &built, &options, settings).x);
    reading.clone().scaled(width_m)
}

/// Selected model of the table.
struct Built {
    label: &'static str,
    shape: TableShape,
    /// Catalog model; `None` = a top of the outline in the image.
    model: Option<&'static TableModel>,
    /// Range of typical widths, meters.
    usual_m: [f64; 2],
}

/// The request's model, or the default of the shape in the image.
fn table_model(reading: &ImageReading, options: &RequestOptions) -> Result<Built, ProviderError> {
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
            "the request asks for {what}, but the image shows a {} table top; leave the table out of the \
             request or send another image",
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
    reading: &ImageReading,
    built: &Built,
    options: &RequestOptions,
    settings: &SingleViewSettings,
) -> DVec3 {
    let wanted = options.table.as_ref().and_then(|table| table.size_m);
    let anchor = options.metric_anchor.as_ref().filter(|anchor| anchor.object == "table");
    let [narrow_m, wide_m] = built.usual_m;
    let usual_m = 0.5 * (narrow_m + wide_m);
    let by_feet_m = reading.table.height.map(|height| settings.sizes.table_height_m / height);
    let width_m = wanted
        .map(|size| size.x)
        .or(anchor.map(|anchor| anchor.width_m))
        .or(reading.measured_meters_per_unit())
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

/// A top of a brown, yellow or orange hue counts as wood, in its own color.
fn wood_of(color: Rgb) -> Option<String> {
    let [r, g, b] = color.0;
    let (highest, lowest) = (r.max(g).max(b), r.min(g).min(b));
    let brown =
        r >= g && g >= b && highest - lowest > 0.12 && highest - lowest < 0.6 && (g - b) > 0.25 * (r - b);
    brown.then(|| "oak".to_owned())
}
