//! Stage `reference`: the reference image. A text is described by the analyst and rendered by the image generator; an
//! image of the user's is the reference image itself, reduced where it is large.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, artifact_io};
use imaging::codec::decode_oriented_image;
use imaging::{DepthImage, Image, Mask};
use ports::{
    Adapter, CompletedBy, Completion, ImageAnnotations, Ports, ReferenceImage, SyntheticGroundTruth,
    TopViewAnnotations, TopViewImage,
};
use render::annotate::fitted;
use scene::request::RequestOptions;
use scene::text_account::TextAccount;
use scene::{Input, InstanceId, SceneDescription, SceneRequest};
use store::Digest;

pub const STAGE: Stage = Stage { name: "reference", version: 16 };

/// Largest side of the reference image, pixels; larger images are reduced, smaller ones stay.
const MAX_SIDE_PX: u32 = 1280;

/// Most pixels of an image that is decoded; the HTTP interface has its own, lower limit.
const MAX_DECODED_PX: u64 = 100_000_000;

/// Inputs of the reference image.
#[derive(Serialize)]
pub struct Inputs {
    input: Input,
    seed: u64,
    options: RequestOptions,
    analyst: Adapter,
    image_generator: Adapter,
    /// Whether the image is only there to take its objects from.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    of_objects_alone: bool,
}

/// The reference image and, where its image generator is a program, what that knows.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub image: ArtifactRef,
    pub known: Option<ArtifactRef>,
    /// Depths of the pixels, in the size of the image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<ArtifactRef>,
    pub alone: Vec<AloneRef>,
    pub top: Option<TopRef>,
    /// The account of the text; `None` for an image.
    pub account: Option<TextAccount>,
    /// The demands of the text, where the image generator knows which object of the image is which of the text.
    pub stated: Option<Arc<SceneDescription>>,
}

impl Output {
    /// The yaw that the text states for an object.
    pub fn stated_yaw_rad(&self, object: &InstanceId) -> Option<f64> {
        self.stated.as_ref()?.objects.iter().find(|stated| stated.id == *object)?.yaw_rad
    }
}

/// An object drawn alone.
#[derive(Clone, Serialize, Deserialize)]
pub struct AloneRef {
    pub id: InstanceId,
    pub completion: CompletionRef,
}

/// A [`Completion`] whose image lies in the store.
#[derive(Clone, Serialize, Deserialize)]
pub struct CompletionRef {
    pub image: ArtifactRef,
    pub crop_px: [f64; 4],
    pub silhouette: Mask,
    pub completed_share: f64,
    #[serde(default)]
    pub completed_by: Vec<CompletedBy>,
}

/// A [`TopViewImage`] that lies in the store.
#[derive(Clone, Serialize, Deserialize)]
pub struct TopRef {
    pub image: ArtifactRef,
    pub known: Option<ArtifactRef>,
}

impl Inputs {
    pub fn new(request: &SceneRequest, ports: &Ports, of_objects_alone: bool) -> Self {
        Self {
            input: request.input.of_reference(),
            seed: request.seed,
            options: options_for_key(request),
            analyst: ports.analyst.adapter(),
            image_generator: ports.image_generator.adapter(),
            of_objects_alone,
        }
    }
}

/// The request's options without `set`, which is in the resolved settings already, and without the robot and the
/// clutter, which come when the objects are placed.
pub(super) fn options_for_key(request: &SceneRequest) -> RequestOptions {
    RequestOptions { set: Default::default(), robot: None, clutter: None, ..request.options.clone() }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    match &inputs.input {
        Input::Text { text } => rendered(&context, &inputs, text).await,
        Input::Image { sha256, depth_sha256, .. } => given(&context, sha256, depth_sha256.as_deref()).await,
        Input::Edit { .. } | Input::Variant { .. } => Err(StageError::permanent(
            "not_a_reference",
            "making a reference image: an edit starts from its parent, which has one",
        )),
    }
}

async fn rendered(context: &Context, inputs: &Inputs, text: &str) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let description =
        ports.analyst.describe(&call, text.to_owned(), inputs.seed, inputs.options.clone()).await?;
    context.put_json("description.json", &description).await?;
    let account = description.account();
    let (generator, description) = (&ports.image_generator, Arc::new(description));
    let generated = if inputs.of_objects_alone {
        generator.reference_of_objects(&call, description, inputs.seed).await?
    } else {
        generator.reference(&call, description, inputs.seed).await?
    };
    let account = Some(TextAccount { unmet: generated.unmet, ..account });
    let image = artifact_io::put_input_image(context, "reference.png", generated.image, None).await?;
    let mut output =
        Output { image, known: None, depth: None, alone: Vec::new(), top: None, account, stated: None };
    if let Some(SyntheticGroundTruth { known, stated, truth, alone, top }) = generated.ground_truth {
        output.known = Some(context.put_json("known.json", &known).await?);
        output.stated = Some(Arc::new(stated));
        // Nothing reads it again: it is not part of the output, so no stage can take it as input.
        context.put_json("truth.json", &truth).await?;
        let stored = alone.into_iter().map(|drawn| async move {
            let name = format!("alone/{}.png", drawn.id);
            let completion = put_completion(context, &name, drawn.completion, None).await?;
            Ok::<_, StageError>(AloneRef { id: drawn.id, completion })
        });
        output.alone = futures::future::try_join_all(stored).await?;
        if let Some(top) = top {
            output.top = Some(put_top(context, top).await?);
        }
    }
    Ok(output)
}

async fn given(context: &Context, sha256: &str, depth_sha256: Option<&str>) -> Result<Output, StageError> {
    let unreadable = |cause: String| {
        StageError::permanent("image_unreadable", format!("the image cannot be read ({cause}); send another"))
    };
    let digest = Digest::parse(sha256).map_err(|error| unreadable(error.to_string()))?;
    let bytes = context.blob(&digest, "the image of the request").await?;
    let decoded = context
        .cpu(move || {
            let image = decode_oriented_image(&bytes, MAX_DECODED_PX)?;
            Ok(on_white(fitted_down(image)))
        })
        .await?;
    let image = decoded.map_err(|error: imaging::codec::CodecError| unreadable(error.to_string()))?;
    let size_px = [image.width_px(), image.height_px()];
    let image = artifact_io::put_input_image(context, "reference.png", image, None).await?;
    let depth = match depth_sha256 {
        Some(sha256) => Some(given_depth(context, sha256, size_px).await?),
        None => None,
    };
    Ok(Output { image, known: None, depth, alone: Vec::new(), top: None, account: None, stated: None })
}

/// Stores the depths of a request in the size of the reference image.
async fn given_depth(
    context: &Context,
    sha256: &str,
    [width_px, height_px]: [u32; 2],
) -> Result<ArtifactRef, StageError> {
    let unreadable = |cause: String| {
        let advice = "send another, or the image alone";
        StageError::permanent(
            "depth_unreadable",
            format!("the depth image cannot be read ({cause}); {advice}"),
        )
    };
    let digest = Digest::parse(sha256).map_err(|error| unreadable(error.to_string()))?;
    let bytes = context.blob(&digest, "the depth image of the request").await?;
    let resampled = move || {
        DepthImage::decode_png(&bytes, MAX_DECODED_PX).map(|depth| depth.resampled(width_px, height_px))
    };
    let depth = context.cpu(resampled).await?.map_err(|error| unreadable(error.to_string()))?;
    artifact_io::put_depth(context, "depth.png", depth).await
}

fn fitted_down(image: Image) -> Image {
    if image.width_px().max(image.height_px()) <= MAX_SIDE_PX {
        image
    } else {
        fitted(&image, MAX_SIDE_PX, MAX_SIDE_PX)
    }
}

/// Product images are often cut out; what is transparent is shown on white, as viewers do.
fn on_white(mut image: Image) -> Image {
    for pixel in image.as_rgba_mut().chunks_exact_mut(4) {
        let alpha = u32::from(pixel[3]);
        for channel in &mut pixel[..3] {
            *channel = ((u32::from(*channel) * alpha + 255 * (255 - alpha) + 127) / 255) as u8;
        }
        pixel[3] = 255;
    }
    image
}

/// Stores a completion; `earlier` is the artifact of an image that may be the same.
pub(super) async fn put_completion(
    context: &Context,
    name: &str,
    completion: Completion,
    earlier: Option<&ArtifactRef>,
) -> Result<CompletionRef, StageError> {
    Ok(CompletionRef {
        image: artifact_io::put_input_image(context, name, completion.image, earlier).await?,
        crop_px: completion.crop_px,
        silhouette: completion.silhouette,
        completed_share: completion.completed_share,
        completed_by: completion.completed_by,
    })
}

/// A stored completion.
pub(super) async fn completion(context: &Context, stored: &CompletionRef) -> Result<Completion, StageError> {
    Ok(Completion {
        image: (*artifact_io::image(context, &stored.image).await?).clone(),
        crop_px: stored.crop_px,
        silhouette: stored.silhouette.clone(),
        completed_share: stored.completed_share,
        completed_by: stored.completed_by.clone(),
    })
}

async fn put_top(context: &Context, top: TopViewImage) -> Result<TopRef, StageError> {
    let image = artifact_io::put_input_image(context, "top.png", top.image, None).await?;
    let known = match &top.known {
        Some(known) => Some(context.put_json("top_known.json", known).await?),
        None => None,
    };
    Ok(TopRef { image, known })
}

/// The stored top view.
pub(super) async fn top(context: &Context, stored: &TopRef) -> Result<TopViewImage, StageError> {
    let known: Option<TopViewAnnotations> = match &stored.known {
        Some(artifact) => Some(context.get_json(artifact).await?),
        None => None,
    };
    Ok(TopViewImage { image: (*artifact_io::image(context, &stored.image).await?).clone(), known })
}

/// The stored reference image as ports see it. `depth` is `None` for ports that do not measure.
pub(super) async fn seen(
    context: &Context,
    image: &ArtifactRef,
    known: Option<&ArtifactRef>,
    depth: Option<&ArtifactRef>,
) -> Result<ReferenceImage, StageError> {
    let known = match known {
        Some(artifact) => Some(image_annotations(context, artifact).await?),
        None => None,
    };
    let depth = match depth {
        Some(artifact) => Some(artifact_io::depth(context, artifact).await?),
        None => None,
    };
    Ok(ReferenceImage { image: artifact_io::image(context, image).await?, known, depth })
}

async fn image_annotations(
    context: &Context,
    artifact: &ArtifactRef,
) -> Result<Arc<ImageAnnotations>, StageError> {
    let decoded = &context.services().decoded.known;
    if let Some(known) = decoded.find(&artifact.digest) {
        return Ok(known);
    }
    let known = Arc::new(context.get_json(artifact).await?);
    decoded.keep(&artifact.digest, &known);
    Ok(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_transparent_is_shown_on_white() {
        let mut image = Image::filled(4, 1, [200, 100, 0, 255]);
        image.set_pixel(1, 0, [200, 100, 0, 0]);
        image.set_pixel(2, 0, [200, 100, 0, 51]);
        let shown = on_white(image);
        let pixels = [0, 1, 2].map(|x| shown.pixel(x, 0));
        assert_eq!(pixels, [[200, 100, 0, 255], [255; 4], [244, 224, 204, 255]]);
    }

    #[test]
    fn large_images_are_reduced_and_keep_their_proportions() {
        let reduced = fitted_down(Image::filled(2 * MAX_SIDE_PX, MAX_SIDE_PX, [9, 9, 9, 255]));
        assert_eq!((reduced.width_px(), reduced.height_px()), (MAX_SIDE_PX, MAX_SIDE_PX / 2));
    }
}
