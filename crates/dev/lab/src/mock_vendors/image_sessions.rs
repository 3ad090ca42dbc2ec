//! The embedded ports behind the protocols, and the images of the current session. Vendors' models are stateless;
//! this server compares the images of a request with those it generated or analyzed before.

use std::sync::Arc;

use glam::DQuat;
use tokio::sync::Mutex;

use super::error_response::VendorError;
use super::image_fingerprint::Fingerprint;
use super::recognized_image::{FingerprintedImage, RecognizedImage};
use geometry::TexturedMesh;
use imaging::{Image, Mask};
use ports::{
    Call, Completion, CompletionRequest, GeneratedReference, Port, Ports, ReconstructionRequest,
    ReferenceImage, TopViewAnnotations, TopViewImage, TopViewRequest, UprightQuestion,
};
use pose_estimation::upright::UprightSettings;
use pose_estimation::yaw::YawSettings;
use runtime::seed::child_seed;
use scene::request::RequestOptions;
use scene::{InstanceId, InstanceMask, MaskEdges, SceneDescription};
use vision::mask_repair;

/// Maximum fingerprint distance of equal images.
const SAME_IMAGE: f64 = 0.015;

/// Maximum fingerprint distance of crops of the same object.
const SAME_OBJECT: f64 = 0.25;

/// Maximum number of remembered images; the oldest are dropped first.
const REMEMBERED: usize = 64;

/// The embedded ports with their sessions.
pub struct ImageSessions {
    ports: Ports,
    /// Settings with which the embedded analyst finds upright rotations.
    upright_settings: (UprightSettings, YawSettings),
    call: Call,
    /// Seed of requests without one.
    seed: u64,
    memory: Mutex<Memory>,
}

#[derive(Default)]
struct Memory {
    images: Vec<Arc<FingerprintedImage>>,
    tops: Vec<Arc<KnownTopView>>,
    descriptions: Vec<(DescribeRequest, Arc<DescribedScene>)>,
}

/// A top view generated here.
pub struct KnownTopView {
    pub of: Arc<FingerprintedImage>,
    pub image: Image,
    pub fingerprint: Fingerprint,
    /// Object boxes and masks of the view.
    pub known: TopViewAnnotations,
}

/// A description request.
#[derive(Clone, Debug, PartialEq)]
struct DescribeRequest {
    text: String,
    seed: u64,
    options: RequestOptions,
}

/// A description with its reference image.
pub struct DescribedScene {
    pub description: SceneDescription,
    pub reference: Arc<FingerprintedImage>,
}

impl ImageSessions {
    pub fn new(
        ports: Ports,
        upright_settings: (UprightSettings, YawSettings),
        call: Call,
        seed: u64,
    ) -> Self {
        Self { ports, upright_settings, call, seed, memory: Mutex::default() }
    }

    /// Describes a text and renders it: the generator's choice of a table is part of the description.
    pub(super) async fn described(
        &self,
        text: &str,
        seed: Option<u64>,
        options: RequestOptions,
    ) -> Result<Arc<DescribedScene>, VendorError> {
        let request = DescribeRequest { text: text.to_owned(), seed: seed.unwrap_or(self.seed), options };
        let mut memory = self.memory.lock().await;
        if let Some((_, known)) = memory.descriptions.iter().find(|(known, _)| *known == request) {
            return Ok(known.clone());
        }
        let described = self.ports.analyst.describe(
            &self.call,
            request.text.clone(),
            request.seed,
            request.options.clone(),
        );
        let description = described.await?;
        let image_generator = &self.ports.image_generator;
        let generated =
            image_generator.reference(&self.call, Arc::new(description.clone()), request.seed).await?;
        let reference = known(from_generated(generated, request.seed)?)?;
        let described = Arc::new(DescribedScene { description, reference: reference.clone() });
        memory.keep(reference);
        memory.descriptions.push((request, described.clone()));
        if memory.descriptions.len() > REMEMBERED {
            memory.descriptions.remove(0);
        }
        Ok(described)
    }

    /// The reference image of the description whose prose occurs in a prompt.
    pub(super) async fn reference_for_prompt(
        &self,
        prompt: &str,
    ) -> Result<Arc<FingerprintedImage>, VendorError> {
        let memory = self.memory.lock().await;
        let wanted = |known: &DescribedScene| {
            let words = known.description.prose.trim();
            !words.is_empty() && prompt.contains(words)
        };
        let found = memory.descriptions.iter().rev().find(|(_, known)| wanted(known));
        found
            .map(|(_, known)| known.reference.clone())
            .ok_or_else(|| VendorError::Unsupported("only described scenes can be rendered".into()))
    }

    /// The latest reference image of this text.
    pub(super) async fn reference_for_text(
        &self,
        words: &str,
    ) -> Result<Arc<FingerprintedImage>, VendorError> {
        let memory = self.memory.lock().await;
        let found = memory.descriptions.iter().rev().find(|(request, _)| request.text == words);
        found
            .map(|(_, known)| known.reference.clone())
            .ok_or_else(|| VendorError::Unsupported("no image was rendered for these words".into()))
    }

    /// Recognition of a whole image; an unknown image is analyzed.
    pub(super) async fn recognize(&self, image: Image) -> Result<Arc<FingerprintedImage>, VendorError> {
        let fingerprint = Fingerprint::of(&image).ok_or_else(transparent)?;
        let mut memory = self.memory.lock().await;
        let known_ones = memory.images.iter().map(|known| (known.whole.distance(&fingerprint), known));
        if let Some((distance, found)) = known_ones.min_by(|a, b| a.0.total_cmp(&b.0))
            && distance <= SAME_IMAGE
        {
            return Ok(found.clone());
        }
        let recognized = known(self.analyze(image).await?)?;
        memory.keep(recognized.clone());
        Ok(recognized)
    }

    /// The top view of an image.
    pub(super) async fn top_view(&self, image: Image) -> Result<Arc<KnownTopView>, VendorError> {
        let of = self.recognize(image).await?;
        let mut memory = self.memory.lock().await;
        if let Some(known) = memory.tops.iter().find(|known| Arc::ptr_eq(&known.of, &of)) {
            return Ok(known.clone());
        }
        let request = TopViewRequest {
            reference: ReferenceImage {
                image: Arc::new(of.recognized.image.clone()),
                known: None,
                depth: None,
            },
            recognition: Arc::new(of.recognized.recognition.clone()),
            masks: Arc::new(of.recognized.masks.clone()),
            rendered: of.recognized.top.clone(),
            refused: Vec::new(),
        };
        let TopViewImage { image, known } = self.ports.image_generator.top_view(&self.call, request).await?;
        let fingerprint = Fingerprint::of(&image).ok_or_else(transparent)?;
        let known = known.ok_or_else(|| VendorError::Unsupported("its objects are not known".into()))?;
        let drawn = Arc::new(KnownTopView { of, image, fingerprint, known });
        memory.tops.push(drawn.clone());
        if memory.tops.len() > REMEMBERED {
            memory.tops.remove(0);
        }
        Ok(drawn)
    }

    /// The top view that an image is, if it was generated here.
    pub(super) async fn known_top_view(&self, image: &Image) -> Option<Arc<KnownTopView>> {
        let fingerprint = Fingerprint::of(image)?;
        let memory = self.memory.lock().await;
        memory.tops.iter().find(|known| known.fingerprint.distance(&fingerprint) <= SAME_IMAGE).cloned()
    }

    /// The object that a crop of visible pixels shows, and its image.
    pub(super) async fn visible_object(
        &self,
        cut_out: &Image,
    ) -> Result<(Arc<FingerprintedImage>, usize), VendorError> {
        self.object(cut_out, |known| &known.visible).await
    }

    /// The object that an image of a complete object shows, and its image.
    pub(super) async fn whole_object(
        &self,
        drawing: &Image,
    ) -> Result<(Arc<FingerprintedImage>, usize), VendorError> {
        self.object(drawing, |known| &known.alone).await
    }

    /// The mesh of an object, in any orientation.
    pub(super) async fn mesh(
        &self,
        recognized: &RecognizedImage,
        index: usize,
    ) -> Result<TexturedMesh, VendorError> {
        let object = recognized.recognition.objects[index].clone();
        let seed = child_seed(child_seed(recognized.seed, "reconstruct"), object.id.as_str());
        let request = ReconstructionRequest {
            object,
            completion: recognized.alone[index].clone(),
            camera: recognized.recognition.camera,
            rendered: recognized.rendered,
            seed,
        };
        Ok(self.ports.mesh_generator.reconstruct(&self.call, request).await?.mesh)
    }

    /// The upright rotation of an object's mesh: `canonical_from_mesh`.
    pub(super) async fn upright(
        &self,
        recognized: &RecognizedImage,
        index: usize,
        mesh: &TexturedMesh,
    ) -> Result<DQuat, VendorError> {
        let (canonicalize, dro) = self.upright_settings.clone();
        let question = UprightQuestion {
            raw_mesh: Arc::new(mesh.clone()),
            object: recognized.recognition.objects[index].clone(),
            camera: recognized.recognition.camera,
            completion: recognized.alone[index].clone(),
            canonicalize,
            dro,
        };
        Ok(self.ports.analyst.upright(&self.call, question).await?.pose.rotation)
    }

    /// Runs a computation on the CPU pool.
    pub(super) async fn compute<T: Send + 'static>(
        &self,
        compute: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, VendorError> {
        Ok(self.call.compute(Port::Analyst, move |_| Ok(compute())).await?)
    }

    async fn object(
        &self,
        shown: &Image,
        fingerprints_of: impl Fn(&FingerprintedImage) -> &[Option<Fingerprint>],
    ) -> Result<(Arc<FingerprintedImage>, usize), VendorError> {
        let fingerprint = Fingerprint::of(shown).ok_or_else(transparent)?;
        let memory = self.memory.lock().await;
        let candidates = memory.images.iter().flat_map(|known| {
            let candidates = fingerprints_of(known).iter().enumerate();
            candidates
                .filter_map(|(index, other)| Some((other.as_ref()?.distance(&fingerprint), known, index)))
                .collect::<Vec<_>>()
        });
        let best =
            candidates.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(distance, ..)| *distance <= SAME_OBJECT);
        best.map(|(_, known, index)| (known.clone(), index))
            .ok_or_else(|| VendorError::Unsupported("it shows nothing of an image that was seen here".into()))
    }

    async fn analyze(&self, image: Image) -> Result<RecognizedImage, VendorError> {
        let Ports { analyst, segmenter, image_generator, .. } = &self.ports;
        let reference = ReferenceImage { image: Arc::new(image.clone()), known: None, depth: None };
        let options = RequestOptions::default();
        let recognition = analyst.recognize(&self.call, reference.clone(), self.seed, options, None).await?;
        let recognition_of = Arc::new(recognition.clone());
        let found = segmenter.segment(&self.call, reference.clone(), recognition_of).await?;
        let masks = match found.edges {
            MaskEdges::Sharp => found.masks,
            MaskEdges::Rough => repaired(&image, found.masks),
        };
        let table = segmenter.table(&self.call, reference.clone()).await?;
        let mut alone: Vec<Completion> = Vec::new();
        for (index, object) in recognition.objects.iter().enumerate() {
            let mut others = Mask::empty(image.width_px(), image.height_px());
            masks.iter().enumerate().filter(|(other, _)| *other != index).for_each(|(_, mask)| {
                others.unite(&mask.visible);
            });
            let request = CompletionRequest {
                reference: reference.clone(),
                object: object.clone(),
                visible: masks[index].visible.clone(),
                others,
                camera: Some(recognition.camera),
                alone: None,
            };
            alone.push(image_generator.complete(&self.call, request).await?);
        }
        let (top, rendered, seed) = (None, false, self.seed);
        Ok(RecognizedImage { image, recognition, masks, table, alone, top, rendered, seed })
    }
}

fn transparent() -> VendorError {
    VendorError::Invalid("the image is transparent".into())
}

fn known(recognized: RecognizedImage) -> Result<Arc<FingerprintedImage>, VendorError> {
    FingerprintedImage::new(recognized).map(Arc::new).ok_or_else(transparent)
}

impl Memory {
    fn keep(&mut self, recognized: Arc<FingerprintedImage>) {
        self.images.push(recognized);
        if self.images.len() > REMEMBERED {
            self.images.remove(0);
        }
    }
}

/// A generated image with its ground truth.
fn from_generated(generated: GeneratedReference, seed: u64) -> Result<RecognizedImage, VendorError> {
    let ground_truth = generated
        .ground_truth
        .ok_or_else(|| VendorError::Unsupported("its image generator gives no ground truth".into()))?;
    Ok(RecognizedImage {
        image: generated.image,
        recognition: ground_truth.known.recognition,
        masks: ground_truth.known.masks,
        table: Some(ground_truth.known.table_mask),
        alone: ground_truth.alone.into_iter().map(|alone| alone.completion).collect(),
        top: ground_truth.top,
        rendered: true,
        seed,
    })
}

fn repaired(image: &Image, masks: Vec<InstanceMask>) -> Vec<InstanceMask> {
    let (ids, visible): (Vec<InstanceId>, Vec<Mask>) =
        masks.into_iter().map(|mask| (mask.id, mask.visible)).unzip();
    let repaired = mask_repair::repair(image, &visible);
    ids.into_iter().zip(repaired).map(|(id, visible)| InstanceMask { id, visible }).collect()
}
