//! The reference image of a description.

use serde_json::json;

use super::super::endpoint::Question;
use super::prompts::prompts;
use super::{DrawingRefused, NAME, OpenAiImageGenerator, decoded, not_taken, wire};
use imaging::Image;
use ports::{Call, Port, ProviderError};
use render::annotate::fitted;
use runtime::seed::child_seed;
use scene::{ObjectSpec, RelationKind, SceneDescription};

/// Maximum side of the kept image, pixels; later stages need no more.
const KEPT_PX: u32 = 1280;

/// Minimum side of an image on which objects can be distinguished, pixels.
pub(crate) const MIN_PX: u32 = 256;

/// Viewing directions from which the seed chooses.
const SIDES: [&str; 5] = [
    "straight from the front",
    "from the front, a little to the left",
    "from the front, a little to the right",
    "from the front, 20 degrees to the left",
    "from the front, 20 degrees to the right",
];

/// Generates the reference image.
pub(super) async fn render(
    image_generator: &OpenAiImageGenerator,
    call: &Call,
    description: &SceneDescription,
    seed: u64,
) -> Result<Image, ProviderError> {
    let settings = &image_generator.settings;
    let prompt = prompt_of(description, seed);
    let mut reason = String::new();
    for _ in 0..=settings.redraws {
        let question = Question {
            operation: "paint",
            path: "/images/generations",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::generation(settings, &prompt).to_string().into(),
            reserved: wire::max_cost(settings, &prompt, 0),
        };
        let file = image_generator.endpoint.ask(call, &question, |reply| wire::read(settings, reply)).await?;
        match decoded(call, file).await? {
            Ok(image) if image.width_px().min(image.height_px()) < MIN_PX => {
                let (width_px, height_px) = (image.width_px(), image.height_px());
                reason = DrawingRefused::TooSmall { width_px, height_px }.to_string();
            }
            Ok(image) => return call.compute(Port::ImageGenerator, move |_| Ok(kept(image))).await,
            Err(refused) => reason = refused.to_string(),
        }
    }
    Err(not_taken(NAME, reason, settings.redraws + 1))
}

/// The image composited over white and reduced to [`KEPT_PX`].
pub(crate) fn kept(mut image: Image) -> Image {
    for pixel in image.as_rgba_mut().chunks_exact_mut(4) {
        let alpha = u32::from(pixel[3]);
        for channel in &mut pixel[..3] {
            *channel = ((u32::from(*channel) * alpha + 255 * (255 - alpha) + 127) / 255) as u8;
        }
        pixel[3] = 255;
    }
    match image.width_px().max(image.height_px()) > KEPT_PX {
        true => fitted(&image, KEPT_PX, KEPT_PX),
        false => image,
    }
}

/// The prompt: style, content and viewing direction.
pub(crate) fn prompt_of(description: &SceneDescription, seed: u64) -> String {
    let side = SIDES[(child_seed(seed, "side") % SIDES.len() as u64) as usize];
    let mut message = vec![
        prompts().render.text.to_owned(),
        String::new(),
        format!("The table is seen {side}. {}", description.prose.trim()),
        String::new(),
        format!("The table: {}.", table_words(description)),
        "On it:".to_owned(),
    ];
    message
        .extend(description.objects.iter().map(|object| format!("- {}", object_words(object, description))));
    message.join("\n")
}

fn table_words(description: &SceneDescription) -> String {
    let table = &description.table;
    let mut words: Vec<String> = Vec::new();
    words.extend(table.color.clone());
    words.extend(table.material.clone());
    words.extend(table.shape.map(|shape| json!(shape).as_str().unwrap_or_default().to_owned()));
    words.push(table.model.as_deref().unwrap_or("table").replace('_', " "));
    let mut message = words.join(", ");
    if let Some(size) = table.size_m {
        message.push_str(&format!(
            ", {:.0} x {:.0} x {:.0} cm",
            100.0 * size.x,
            100.0 * size.y,
            100.0 * size.z
        ));
    }
    message
}

fn object_words(object: &ObjectSpec, description: &SceneDescription) -> String {
    let size = 100.0 * object.size_m;
    let mut message = format!(
        "{}: {}, {:.1} cm wide, {:.1} deep, {:.1} high",
        object.id, object.label, size.x, size.y, size.z
    );
    if let Some(material) = &object.material {
        message.push_str(&format!(", {material}"));
    }
    if let Some(color) = object.color {
        message.push_str(&format!(", {}", color.to_hex()));
    }
    for relation in &object.relations {
        let target = relation.target.as_ref();
        let known = target.filter(|id| description.objects.iter().any(|other| other.id == **id));
        message.push_str(&format!(", {}", relation_words(relation.kind)));
        if let Some(target) = known {
            message.push_str(&format!(" {target}"));
        }
    }
    message
}

fn relation_words(kind: RelationKind) -> &'static str {
    match kind {
        RelationKind::On => "standing on",
        RelationKind::In => "standing in",
        RelationKind::LeftOf => "to the left of",
        RelationKind::RightOf => "to the right of",
        RelationKind::InFrontOf => "in front of",
        RelationKind::Behind => "behind",
        RelationKind::NextTo => "next to",
        RelationKind::Around => "one of several around",
        RelationKind::StackedOn => "stacked on",
        RelationKind::AtCenter => "at the middle of the table",
        RelationKind::AtBack => "at the back of the table",
        RelationKind::AtFront => "at the front of the table",
        RelationKind::AtLeft => "at the left of the table",
        RelationKind::AtRight => "at the right of the table",
        RelationKind::AtBackLeft => "at the back left of the table",
        RelationKind::AtBackRight => "at the back right of the table",
        RelationKind::AtFrontLeft => "at the front left of the table",
        RelationKind::AtFrontRight => "at the front right of the table",
        RelationKind::FromLeftEdge => "at a distance from the left edge of the table",
        RelationKind::FromRightEdge => "at a distance from the right edge of the table",
        RelationKind::FromFrontEdge => "at a distance from the front edge of the table",
        RelationKind::FromBackEdge => "at a distance from the back edge of the table",
        RelationKind::Between => "between another object and",
        RelationKind::Facing => "turned to",
        RelationKind::ParallelTo => "parallel to",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Rgb;
    use glam::DVec3;
    use scene::{InstanceId, Relation, TableSpec};

    fn object(id: &str, relations: Vec<Relation>) -> ObjectSpec {
        ObjectSpec {
            id: InstanceId::new(id).expect("a name"),
            label: "red mug".into(),
            category: "mug".into(),
            size_m: DVec3::new(0.12, 0.08, 0.095),
            color: Some(Rgb([1.0, 0.0, 0.0])),
            material: Some("ceramic".into()),
            seed: 1,
            requested: true,
            stand_in: None,
            pose: scene::RequestedPose::Upright,
            yaw_rad: None,
            position_m: None,
            state: None,
            mass_kg: None,
            relations,
        }
    }

    #[test]
    fn prompt_lists_every_object_with_size_and_relations() {
        let plate = InstanceId::new("plate_1").expect("a name");
        let description = SceneDescription {
            theme: "t".into(),
            family: "dining_kitchen".into(),
            table_size_is_stated: false,
            table: TableSpec {
                model: Some("dining_table".into()),
                size_m: Some(DVec3::new(1.4, 0.8, 0.74)),
                ..TableSpec::default()
            },
            objects: vec![
                object("plate_1", vec![Relation::new(RelationKind::AtFront, None)]),
                object("mug_1", vec![Relation::new(RelationKind::On, Some(plate))]),
            ],
            arrangements: Vec::new(),
            goal: None,
            excluded_categories: Vec::new(),
            understood: Vec::new(),
            unrecognized: Vec::new(),
            prose: "A mug on a plate.".into(),
        };
        let prompt = prompt_of(&description, 3);
        for part in [
            "A mug on a plate.",
            "The table: dining table, 140 x 80 x 74 cm.",
            "- plate_1: red mug, 12.0 cm wide, 8.0 deep, 9.5 high, ceramic, #ff0000, at the front of the table",
            "- mug_1: red mug, 12.0 cm wide, 8.0 deep, 9.5 high, ceramic, #ff0000, standing on plate_1",
        ] {
            assert!(prompt.contains(part), "{part}\n{prompt}");
        }
        assert_eq!(prompt, prompt_of(&description, 3));
        let sides: std::collections::BTreeSet<String> =
            (0..40).map(|seed| prompt_of(&description, seed)).collect();
        assert_eq!(sides.len(), SIDES.len());
    }

    #[test]
    fn kept_reduces_large_images_and_makes_them_opaque() {
        let image = kept(Image::filled(1536, 1024, [10, 20, 30, 0]));
        assert_eq!((image.width_px(), image.height_px()), (1280, 853));
        assert_eq!(image.pixel(5, 5), [255; 4]);
        assert_eq!(kept(Image::filled(640, 480, [10, 20, 30, 255])).pixel(0, 0), [10, 20, 30, 255]);
    }
}
