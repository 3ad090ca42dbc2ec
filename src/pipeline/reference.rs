//! Stage 1: the reference picture. A text is described by the analyst and painted by the painter; a
//! picture of the user's is the reference picture itself.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, carry};
use imaging::codec::decode_photograph;
use imaging::{Image, Mask};
use ports::{
    Adapter, CompletedBy, Completion, KnownPicture, KnownTop, PaintingAside, Ports, Reference, TopPicture,
};
use render::overlay::fitted;
use scene::request::RequestOptions;
use scene::{Input, InstanceId, SceneRequest};
use store::Digest;

pub const STAGE: Stage = Stage { name: "reference", version: 5 };

/// Largest side of the reference picture, pixels; larger pictures are reduced, smaller ones stay.
const MAX_SIDE_PX: u32 = 1280;

/// Most pixels of a picture that is decoded; the HTTP interface has its own, lower limit.
const MAX_DECODED_PX: u64 = 100_000_000;

/// What decides the reference picture.
#[derive(Serialize)]
pub struct Inputs {
    input: Input,
    seed: u64,
    options: RequestOptions,
    analyst: Adapter,
    painter: Adapter,
}

/// The reference picture and, where its painter is a program, what that knows.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub picture: ArtifactRef,
    pub known: Option<ArtifactRef>,
    pub alone: Vec<AloneRef>,
    pub top: Option<TopRef>,
    /// Words of the text that mean a thing nobody here knows.
    pub unrecognized_terms: Vec<String>,
}

/// An object drawn alone.
#[derive(Clone, Serialize, Deserialize)]
pub struct AloneRef {
    pub id: InstanceId,
    pub completion: CompletionRef,
}

/// A [`Completion`] whose picture lies in the store.
#[derive(Clone, Serialize, Deserialize)]
pub struct CompletionRef {
    pub picture: ArtifactRef,
    pub shown_px: [f64; 4],
    pub silhouette: Mask,
    pub completed_share: f64,
    #[serde(default)]
    pub completed_by: Vec<CompletedBy>,
}

/// A [`TopPicture`] that lies in the store.
#[derive(Clone, Serialize, Deserialize)]
pub struct TopRef {
    pub picture: ArtifactRef,
    pub known: Option<ArtifactRef>,
}

impl Inputs {
    pub fn new(request: &SceneRequest, ports: &Ports) -> Self {
        Self {
            input: request.input.clone(),
            seed: request.seed,
            options: shaping_options(request),
            analyst: ports.analyst.adapter(),
            painter: ports.painter.adapter(),
        }
    }
}

/// The request's options without `set`, which is in the resolved settings already.
pub(super) fn shaping_options(request: &SceneRequest) -> RequestOptions {
    RequestOptions { set: Default::default(), ..request.options.clone() }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    match &inputs.input {
        Input::Text { text } => painted(&context, &inputs, text).await,
        Input::Image { sha256, .. } => given(&context, sha256).await,
    }
}

async fn painted(context: &Context, inputs: &Inputs, text: &str) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let description =
        ports.analyst.describe(&call, text.to_owned(), inputs.seed, inputs.options.clone()).await?;
    context.put_json("description.json", &description).await?;
    let unrecognized_terms = description.unrecognized_terms.clone();
    let painting = ports.painter.reference(&call, Arc::new(description), inputs.seed).await?;
    let picture = carry::put_picture(context, "reference.png", painting.picture).await?;
    let mut output = Output { picture, known: None, alone: Vec::new(), top: None, unrecognized_terms };
    if let Some(PaintingAside { known, truth, alone, top }) = painting.aside {
        output.known = Some(context.put_json("known.json", &known).await?);
        // Nothing reads it again: it is not part of the output, so no stage can take it as input.
        context.put_json("truth.json", &truth).await?;
        let stored = alone.into_iter().map(|drawn| async move {
            let name = format!("alone/{}.png", drawn.id);
            let completion = put_completion(context, &name, drawn.completion).await?;
            Ok::<_, StageError>(AloneRef { id: drawn.id, completion })
        });
        let (alone, top) = futures::try_join!(futures::future::try_join_all(stored), put_top(context, top))?;
        (output.alone, output.top) = (alone, Some(top));
    }
    Ok(output)
}

async fn given(context: &Context, sha256: &str) -> Result<Output, StageError> {
    let unreadable = |cause: String| {
        StageError::permanent(
            "image_unreadable",
            format!("the picture cannot be read ({cause}); send another"),
        )
    };
    let digest = Digest::parse(sha256).map_err(|error| unreadable(error.to_string()))?;
    let bytes = context.blob(&digest, "the picture of the request").await?;
    let decoded = context
        .cpu(move || {
            let picture = decode_photograph(&bytes, MAX_DECODED_PX)?;
            Ok(on_white(fitted_down(picture)))
        })
        .await?;
    let picture = decoded.map_err(|error: imaging::codec::PictureError| unreadable(error.to_string()))?;
    let picture = carry::put_picture(context, "reference.png", picture).await?;
    Ok(Output { picture, known: None, alone: Vec::new(), top: None, unrecognized_terms: Vec::new() })
}

fn fitted_down(picture: Image) -> Image {
    if picture.width_px().max(picture.height_px()) <= MAX_SIDE_PX {
        picture
    } else {
        fitted(&picture, MAX_SIDE_PX, MAX_SIDE_PX)
    }
}

/// Product pictures are often cut out; what is transparent is shown on white, as viewers do.
fn on_white(mut picture: Image) -> Image {
    for pixel in picture.as_rgba_mut().chunks_exact_mut(4) {
        let alpha = u32::from(pixel[3]);
        for channel in &mut pixel[..3] {
            *channel = ((u32::from(*channel) * alpha + 255 * (255 - alpha) + 127) / 255) as u8;
        }
        pixel[3] = 255;
    }
    picture
}

/// Stores a completion.
pub(super) async fn put_completion(
    context: &Context,
    name: &str,
    completion: Completion,
) -> Result<CompletionRef, StageError> {
    Ok(CompletionRef {
        picture: carry::put_picture(context, name, completion.picture).await?,
        shown_px: completion.shown_px,
        silhouette: completion.silhouette,
        completed_share: completion.completed_share,
        completed_by: completion.completed_by,
    })
}

/// A stored completion.
pub(super) async fn completion(context: &Context, stored: &CompletionRef) -> Result<Completion, StageError> {
    Ok(Completion {
        picture: (*carry::picture(context, &stored.picture).await?).clone(),
        shown_px: stored.shown_px,
        silhouette: stored.silhouette.clone(),
        completed_share: stored.completed_share,
        completed_by: stored.completed_by.clone(),
    })
}

async fn put_top(context: &Context, top: TopPicture) -> Result<TopRef, StageError> {
    let picture = carry::put_picture(context, "top.png", top.picture).await?;
    let known = match &top.known {
        Some(known) => Some(context.put_json("top_known.json", known).await?),
        None => None,
    };
    Ok(TopRef { picture, known })
}

/// The stored top view.
pub(super) async fn top(context: &Context, stored: &TopRef) -> Result<TopPicture, StageError> {
    let known: Option<KnownTop> = match &stored.known {
        Some(artifact) => Some(context.get_json(artifact).await?),
        None => None,
    };
    Ok(TopPicture { picture: (*carry::picture(context, &stored.picture).await?).clone(), known })
}

/// The stored reference picture as ports see it.
pub(super) async fn seen(
    context: &Context,
    picture: &ArtifactRef,
    known: Option<&ArtifactRef>,
) -> Result<Reference, StageError> {
    let known = match known {
        Some(artifact) => Some(known_picture(context, artifact).await?),
        None => None,
    };
    Ok(Reference { picture: carry::picture(context, picture).await?, known })
}

async fn known_picture(context: &Context, artifact: &ArtifactRef) -> Result<Arc<KnownPicture>, StageError> {
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
        let mut picture = Image::filled(4, 1, [200, 100, 0, 255]);
        picture.set_pixel(1, 0, [200, 100, 0, 0]);
        picture.set_pixel(2, 0, [200, 100, 0, 51]);
        let shown = on_white(picture);
        let pixels = [0, 1, 2].map(|x| shown.pixel(x, 0));
        assert_eq!(pixels, [[200, 100, 0, 255], [255; 4], [244, 224, 204, 255]]);
    }

    #[test]
    fn large_pictures_are_reduced_and_keep_their_proportions() {
        let reduced = fitted_down(Image::filled(2 * MAX_SIDE_PX, MAX_SIDE_PX, [9, 9, 9, 255]));
        assert_eq!((reduced.width_px(), reduced.height_px()), (MAX_SIDE_PX, MAX_SIDE_PX / 2));
    }
}
