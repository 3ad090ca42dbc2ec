//! Table model and size: from the request, then from the text, then from the theme.

use glam::DVec3;
use rand::RngExt;

use super::grammar::ParsedText;
use super::lexicon::Lexicon;
use super::measures::Axis;
use super::themes::Theme;
use super::{DescribeError, TextParserSettings};
use catalog::TableModel;
use runtime::seed::child_rng;
use scene::{ObjectSpec, TableShape, TableSpec};

/// Wood materials of "a wooden table".
const WOODS: &[&str] = &["oak", "walnut", "pine", "birch"];

/// A complete specification: model, shape and size, with material and color if they are stated.
pub(super) fn choose(
    lexicon: &Lexicon,
    parsed: &ParsedText,
    wanted: Option<&TableSpec>,
    theme: &Theme,
    objects: &[ObjectSpec],
    seed: u64,
    settings: &TextParserSettings,
) -> Result<TableSpec, DescribeError> {
    let mut rng = child_rng(seed, "table");
    let wanted = wanted.cloned().unwrap_or_default();
    let attributes = parsed.table.as_ref().map(|(_, attributes)| attributes);
    let stated_shape = attributes
        .and_then(|attributes| attributes.shape.as_ref())
        .and_then(|word| lexicon.vocabulary.shapes.get(word));
    let (shape_word, shape_model) =
        match stated_shape.map(|shape| shape.split_once(':').unwrap_or((shape, ""))) {
            Some((shape, model)) => (shape_of(shape), (!model.is_empty()).then(|| model.to_owned())),
            None => (None, None),
        };
    let shape = wanted.shape.or(if wanted.model.is_some() { None } else { shape_word });
    let named = wanted.model.clone().or(shape_model).or(parsed.table.as_ref().and_then(|(m, _)| m.clone()));
    let find = |name: &str| lexicon.tables.iter().find(|model| model.name == name);
    if let Some(model) = &wanted.model
        && find(model).is_none()
    {
        return Err(DescribeError::UnknownTableModel {
            model: model.clone(),
            known: lexicon.tables.iter().map(|model| model.name.to_owned()).collect(),
        });
    }
    let fits = |model: &&TableModel| shape.is_none_or(|shape| shape_of(model.shape) == Some(shape));
    // "a round dining table": the stated shape has precedence over the model name.
    let model =
        named.as_deref().and_then(find).filter(|model| wanted.model.is_some() || fits(model)).or_else(|| {
            let mut pool: Vec<&TableModel> =
                theme.tables.iter().filter_map(|name| find(name)).filter(fits).collect();
            if pool.is_empty() {
                pool = lexicon.tables.iter().filter(fits).collect();
                let at_home: Vec<&TableModel> =
                    pool.iter().copied().filter(|m| m.families.contains(&theme.family.as_str())).collect();
                if !at_home.is_empty() {
                    pool = at_home;
                }
            }
            (!pool.is_empty()).then(|| pool[rng.random_range(0..pool.len())])
        });
    let finish = attributes.and_then(|attributes| attributes.table_finish.clone()).map(|finish| {
        if finish == "any_wood" { WOODS[rng.random_range(0..WOODS.len())].to_owned() } else { finish }
    });
    let color = attributes.and_then(|attributes| attributes.color_words.first().cloned());
    let size_m = model.map(|model| {
        let size = size_for(model, objects, settings, &mut rng);
        match attributes {
            Some(attributes) => sized_by_words(size, attributes, model),
            None => size,
        }
    });
    Ok(TableSpec {
        shape: model.and_then(|model| shape_of(model.shape)).or(shape),
        size_m: wanted.size_m.or(size_m),
        model: model.map(|model| model.name.to_owned()).or(wanted.model),
        material: wanted.material.or(finish),
        color: wanted.color.or(color),
    })
}

/// Gives a table without a stated finish one of the place that the text names, if it names one.
pub(super) fn finish_by_place(table: &mut TableSpec, lexicon: &Lexicon, text: &str, seed: u64) {
    let materials = lexicon.themes.table_materials(text);
    if table.material.is_none() && table.color.is_none() && !materials.is_empty() {
        let mut rng = child_rng(seed, "finish of the table");
        table.material = Some(materials[rng.random_range(0..materials.len())].clone());
    }
}

/// Whether the text or the request states the extents of the table top.
pub(super) fn size_is_stated(parsed: &ParsedText, wanted: Option<&TableSpec>) -> bool {
    let measures = parsed.table.iter().flat_map(|(_, attributes)| &attributes.measures);
    wanted.is_some_and(|table| table.size_m.is_some())
        || measures.into_iter().any(|measure| measure.axis != Axis::Height)
}

pub(crate) fn shape_of(word: &str) -> Option<TableShape> {
    Some(match word {
        "rectangular" => TableShape::Rectangular,
        "square" => TableShape::Square,
        "round" => TableShape::Round,
        "oval" => TableShape::Oval,
        "triangular" => TableShape::Triangular,
        "irregular" => TableShape::Irregular,
        _ => return None,
    })
}

/// The size within the model's limits at which the objects cover the requested share of the table top.
fn size_for(
    model: &TableModel,
    objects: &[ObjectSpec],
    settings: &TextParserSettings,
    rng: &mut runtime::seed::Rng,
) -> DVec3 {
    let covered: f64 = objects
        .iter()
        .filter(|object| object.supporter().is_none())
        // Each object has a margin of one centimeter.
        .map(|object| (object.size_m.x + 0.02) * (object.size_m.y + 0.02))
        .sum();
    let usable = match model.shape {
        "round" | "oval" => 0.70,
        "triangular" => 0.45,
        "irregular" => 0.68,
        _ => 1.0,
    };
    let area = settings.table_area_per_footprint * covered / usable;
    // The margin along the edge stays empty.
    let widest: f64 = objects
        .iter()
        .filter(|object| object.supporter().is_none())
        .map(|object| object.size_m.truncate().max_element())
        .fold(0.0, f64::max);
    let mut fraction: f64 = 1.0;
    for step in 0..=20 {
        let f = f64::from(step) / 20.0;
        let size = model.low_m + f * (model.high_m - model.low_m);
        if size.x * size.y >= area && size.x.min(size.y) > 1.3 * widest {
            fraction = f;
            break;
        }
    }
    let request = fraction + rng.random_range(0.0..0.25);
    let mut size = model.low_m + request.min(1.0) * (model.high_m - model.low_m);
    size.z = model.low_m.z + rng.random_range(0.0..1.0) * (model.high_m.z - model.low_m.z);
    size
}

/// The size after the words of the text ("a 1.2 m wide desk", "a long table"); never below the minimum of a table.
fn sized_by_words(size: DVec3, attributes: &super::phrase::Attributes, model: &TableModel) -> DVec3 {
    let mut size = size;
    if attributes.scale < 0.999 {
        size = 0.5 * (size + model.low_m);
    } else if attributes.scale > 1.001 {
        size = 0.3 * size + 0.7 * model.high_m;
    }
    for &(axis, factor) in &attributes.stretches {
        match axis {
            'x' | 'l' => size.x *= factor,
            'y' => size.y *= factor,
            _ => size.z *= factor,
        }
    }
    for measure in &attributes.measures {
        match measure.axis {
            Axis::Depth => size.y = measure.meters,
            Axis::Height => size.z = measure.meters,
            Axis::Diameter => (size.x, size.y) = (measure.meters, measure.meters),
            Axis::Width | Axis::Length | Axis::Unspecified => {
                let ratio = size.y / size.x;
                size.x = measure.meters;
                if attributes.measures.len() == 1 {
                    size.y = (ratio * measure.meters).max(0.8 * model.low_m.y.min(measure.meters));
                }
            }
        }
    }
    let smallest = DVec3::new(0.5, 0.4, 0.35).min(model.low_m);
    size.clamp(smallest, 1.6 * model.high_m)
}
