//! The embedded ports behind the protocols, and what they have painted and looked at so far. Pictures are remembered, as a
//! model remembers nothing: what a question shows is compared with them.

use std::sync::Arc;

use glam::DQuat;
use tokio::sync::Mutex;

use super::likeness::Look;
use super::refusal::Refusal;
use super::sight::{KnownSight, Sight};
use geometry::TexturedMesh;
use imaging::{Image, Mask};
use ports::{
    Call, Completion, CompletionRequest, KnownTop, Painting, Port, Ports, ReconstructionRequest, Reference,
    TopPicture, TopViewRequest, UprightQuestion,
};
use pose_estimation::canonicalize::CanonicalizeSettings;
use pose_estimation::dro::DroSettings;
use runtime::seed::child_seed;
use scene::request::RequestOptions;
use scene::{InstanceId, InstanceMask, MaskEdges, SceneDescription};
use vision::mask_repair;

/// Distance of looks up to which two pictures are the same.
const SAME_PICTURE: f64 = 0.015;

/// Distance of looks up to which two cut-outs show the same thing.
const SAME_THING: f64 = 0.25;

/// Most pictures that are remembered; the oldest go first.
const REMEMBERED: usize = 64;

/// The embedded ports at work.
pub struct Studio {
    ports: Ports,
    /// How the embedded analyst stands meshes up.
    turning: (CanonicalizeSettings, DroSettings),
    call: Call,
    /// For questions that bring none.
    seed: u64,
    memory: Mutex<Memory>,
}

#[derive(Default)]
struct Memory {
    sights: Vec<Arc<KnownSight>>,
    tops: Vec<Arc<KnownTopView>>,
    paintings: Vec<(Wish, Arc<Described>)>,
}

/// A view from above that was drawn here, of a sight.
pub struct KnownTopView {
    pub of: Arc<KnownSight>,
    pub picture: Image,
    pub look: Look,
    /// Where things are on it.
    pub known: KnownTop,
}

/// A wish as it was asked.
#[derive(Clone, Debug, PartialEq)]
struct Wish {
    text: String,
    seed: u64,
    options: RequestOptions,
}

/// A wish as it was described and painted.
pub struct Described {
    pub description: SceneDescription,
    pub painted: Arc<KnownSight>,
}

impl Studio {
    pub fn new(ports: Ports, turning: (CanonicalizeSettings, DroSettings), call: Call, seed: u64) -> Self {
        Self { ports, turning, call, seed, memory: Mutex::default() }
    }

    /// Describes a wish, and paints it: the painter's choice of a table is part of the description.
    pub(super) async fn described(
        &self,
        text: &str,
        seed: Option<u64>,
        options: RequestOptions,
    ) -> Result<Arc<Described>, Refusal> {
        let wish = Wish { text: text.to_owned(), seed: seed.unwrap_or(self.seed), options };
        let mut memory = self.memory.lock().await;
        if let Some((_, known)) = memory.paintings.iter().find(|(known, _)| *known == wish) {
            return Ok(known.clone());
        }
        let described =
            self.ports.analyst.describe(&self.call, wish.text.clone(), wish.seed, wish.options.clone());
        let description = described.await?;
        let painter = &self.ports.painter;
        let painting = painter.reference(&self.call, Arc::new(description.clone()), wish.seed).await?;
        let painted = known(painted(painting, wish.seed)?)?;
        let described = Arc::new(Described { description, painted: painted.clone() });
        memory.keep(painted);
        memory.paintings.push((wish, described.clone()));
        if memory.paintings.len() > REMEMBERED {
            memory.paintings.remove(0);
        }
        Ok(described)
    }

    /// The painting of the description whose words stand in a prompt.
    pub(super) async fn painting(&self, prompt: &str) -> Result<Arc<KnownSight>, Refusal> {
        let memory = self.memory.lock().await;
        let wanted = |known: &Described| {
            let words = known.description.prose.trim();
            !words.is_empty() && prompt.contains(words)
        };
        let found = memory.paintings.iter().rev().find(|(_, known)| wanted(known));
        found
            .map(|(_, known)| known.painted.clone())
            .ok_or_else(|| Refusal::Unable("only what was described here before can be painted here".into()))
    }

    /// What was painted last after these words.
    pub(super) async fn painting_after(&self, words: &str) -> Result<Arc<KnownSight>, Refusal> {
        let memory = self.memory.lock().await;
        let found = memory.paintings.iter().rev().find(|(wish, _)| wish.text == words);
        found
            .map(|(_, known)| known.painted.clone())
            .ok_or_else(|| Refusal::Unable("nothing was painted here after these words".into()))
    }

    /// What a whole picture shows; one that is not known is looked at.
    pub(super) async fn sight(&self, picture: Image) -> Result<Arc<KnownSight>, Refusal> {
        let look = Look::of(&picture).ok_or_else(transparent)?;
        let mut memory = self.memory.lock().await;
        let known_ones = memory.sights.iter().map(|known| (known.whole.distance(&look), known));
        if let Some((distance, found)) = known_ones.min_by(|a, b| a.0.total_cmp(&b.0))
            && distance <= SAME_PICTURE
        {
            return Ok(found.clone());
        }
        let seen = known(self.looked_at(picture).await?)?;
        memory.keep(seen.clone());
        Ok(seen)
    }

    /// The view from above of what a picture shows.
    pub(super) async fn top_view(&self, picture: Image) -> Result<Arc<KnownTopView>, Refusal> {
        let of = self.sight(picture).await?;
        let mut memory = self.memory.lock().await;
        if let Some(known) = memory.tops.iter().find(|known| Arc::ptr_eq(&known.of, &of)) {
            return Ok(known.clone());
        }
        let request = TopViewRequest {
            reference: Reference { picture: Arc::new(of.sight.picture.clone()), known: None },
            recognition: Arc::new(of.sight.recognition.clone()),
            masks: Arc::new(of.sight.masks.clone()),
            painted: of.sight.top.clone(),
            refused: Vec::new(),
        };
        let TopPicture { picture, known } = self.ports.painter.top_view(&self.call, request).await?;
        let look = Look::of(&picture).ok_or_else(transparent)?;
        let known = known.ok_or_else(|| Refusal::Unable("nobody knows what is where on it".into()))?;
        let drawn = Arc::new(KnownTopView { of, picture, look, known });
        memory.tops.push(drawn.clone());
        if memory.tops.len() > REMEMBERED {
            memory.tops.remove(0);
        }
        Ok(drawn)
    }

    /// The view from above that a picture is, if it was drawn here.
    pub(super) async fn seen_from_above(&self, picture: &Image) -> Option<Arc<KnownTopView>> {
        let look = Look::of(picture)?;
        let memory = self.memory.lock().await;
        memory.tops.iter().find(|known| known.look.distance(&look) <= SAME_PICTURE).cloned()
    }

    /// Which object of which picture a cut-out of visible pixels shows.
    pub(super) async fn visible_thing(&self, cut_out: &Image) -> Result<(Arc<KnownSight>, usize), Refusal> {
        self.thing(cut_out, |known| &known.visible).await
    }

    /// Which object of which picture a drawing of a whole thing shows.
    pub(super) async fn whole_thing(&self, drawing: &Image) -> Result<(Arc<KnownSight>, usize), Refusal> {
        self.thing(drawing, |known| &known.alone).await
    }

    /// The mesh of an object, in any orientation.
    pub(super) async fn mesh(&self, sight: &Sight, index: usize) -> Result<TexturedMesh, Refusal> {
        let object = sight.recognition.objects[index].clone();
        let seed = child_seed(child_seed(sight.seed, "reconstruct"), object.id.as_str());
        let request = ReconstructionRequest {
            object,
            completion: sight.alone[index].clone(),
            camera: sight.recognition.camera,
            painted: sight.painted,
            seed,
        };
        Ok(self.ports.mesh_generator.reconstruct(&self.call, request).await?.mesh)
    }

    /// The rotation that stands a mesh of an object up: `canonical_from_mesh`.
    pub(super) async fn upright(
        &self,
        sight: &Sight,
        index: usize,
        mesh: &TexturedMesh,
    ) -> Result<DQuat, Refusal> {
        let (canonicalize, dro) = self.turning.clone();
        let question = UprightQuestion {
            raw_mesh: Arc::new(mesh.clone()),
            object: sight.recognition.objects[index].clone(),
            camera: sight.recognition.camera,
            completion: sight.alone[index].clone(),
            canonicalize,
            dro,
        };
        Ok(self.ports.analyst.upright(&self.call, question).await?.pose.rotation)
    }

    /// What a computation comes to, off the threads that answer.
    pub(super) async fn computed<T: Send + 'static>(
        &self,
        compute: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Refusal> {
        Ok(self.call.compute(Port::Analyst, move |_| Ok(compute())).await?)
    }

    async fn thing(
        &self,
        shown: &Image,
        looks_of: impl Fn(&KnownSight) -> &[Option<Look>],
    ) -> Result<(Arc<KnownSight>, usize), Refusal> {
        let look = Look::of(shown).ok_or_else(transparent)?;
        let memory = self.memory.lock().await;
        let looks = memory.sights.iter().flat_map(|known| {
            let looks = looks_of(known).iter().enumerate();
            looks
                .filter_map(|(index, other)| Some((other.as_ref()?.distance(&look), known, index)))
                .collect::<Vec<_>>()
        });
        let best = looks.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(distance, ..)| *distance <= SAME_THING);
        best.map(|(_, known, index)| (known.clone(), index))
            .ok_or_else(|| Refusal::Unable("it shows nothing of a picture that was seen here".into()))
    }

    async fn looked_at(&self, picture: Image) -> Result<Sight, Refusal> {
        let Ports { analyst, segmenter, painter, .. } = &self.ports;
        let reference = Reference { picture: Arc::new(picture.clone()), known: None };
        let options = RequestOptions::default();
        let recognition = analyst.recognize(&self.call, reference.clone(), self.seed, options).await?;
        let seen = Arc::new(recognition.clone());
        let found = segmenter.segment(&self.call, reference.clone(), seen).await?;
        let masks = match found.edges {
            MaskEdges::Sharp => found.masks,
            MaskEdges::Rough => repaired(&picture, found.masks),
        };
        let table = segmenter.table(&self.call, reference.clone()).await?;
        let mut alone: Vec<Completion> = Vec::new();
        for (index, object) in recognition.objects.iter().enumerate() {
            let mut others = Mask::empty(picture.width_px(), picture.height_px());
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
            alone.push(painter.complete(&self.call, request).await?);
        }
        let (top, painted, seed) = (None, false, self.seed);
        Ok(Sight { picture, recognition, masks, table, alone, top, painted, seed })
    }
}

fn transparent() -> Refusal {
    Refusal::Wrong("the picture is transparent".into())
}

fn known(sight: Sight) -> Result<Arc<KnownSight>, Refusal> {
    KnownSight::new(sight).map(Arc::new).ok_or_else(transparent)
}

impl Memory {
    fn keep(&mut self, sight: Arc<KnownSight>) {
        self.sights.push(sight);
        if self.sights.len() > REMEMBERED {
            self.sights.remove(0);
        }
    }
}

/// A painting with what its painter knows.
fn painted(painting: Painting, seed: u64) -> Result<Sight, Refusal> {
    let aside = painting.aside.ok_or_else(|| Refusal::Unable("its painter knows nothing of it".into()))?;
    Ok(Sight {
        picture: painting.picture,
        recognition: aside.known.recognition,
        masks: aside.known.masks,
        table: Some(aside.known.table_mask),
        alone: aside.alone.into_iter().map(|alone| alone.completion).collect(),
        top: Some(aside.top),
        painted: true,
        seed,
    })
}

fn repaired(picture: &Image, masks: Vec<InstanceMask>) -> Vec<InstanceMask> {
    let (ids, visible): (Vec<InstanceId>, Vec<Mask>) =
        masks.into_iter().map(|mask| (mask.id, mask.visible)).unzip();
    let repaired = mask_repair::repaired(picture, &visible);
    ids.into_iter().zip(repaired).map(|(id, visible)| InstanceMask { id, visible }).collect()
}
