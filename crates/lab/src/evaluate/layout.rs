//! The layout benchmark on one scene: paint, spoil, run the stages, compare.
//!
//! The evaluator paints the scene itself and keeps the truth. The stages get the painting through a painter that has
//! painted already ([`super::painted`]), spoiled where the difficulty says so, and never see the truth: it is neither
//! in what the ports know nor in any stage's inputs.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use glam::DQuat;
use serde::{Deserialize, Serialize};

use super::ablation::{self, Ablation, Colliding, Instead};
use super::jittered_boxes::JitteredBoxes;
use super::look_alikes::LookAlikes;
use super::noise::Noise;
use super::painted::PaintedAlready;
use super::scenes::{BenchmarkScene, Family, Outline};
use super::score::{Compared, ObjectScore};
use super::true_world::{Look, TrueWorld};
use super::watched_meshes::WatchedMeshes;
use embedded;
use embedded::EmbeddedSettings;
use geometry::Camera;
use geometry::pose::wrap_angle_rad;
use ports::{Call, MeshGenerator, Painting, PaintingAside, Ports, Segmenter, Truth};
use runtime::seed::child_seed;
use scene::{InstanceId, Recognition, SceneRequest};
use tabletopgen::pipeline::checkpoint::Checkpoints;
use tabletopgen::pipeline::error::StageError;
use tabletopgen::pipeline::{Rotated, Settings, place, rotate, rotate_all};

/// Paintings of one scene until the difficulty's least visible share is given up.
const MAX_PAINTINGS: u32 = 12;

/// How hard the stages' task is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Difficulty {
    /// Exact masks, boxes, sizes, meshes and camera.
    Clean,
    /// [`Noise::NOISY`].
    Noisy,
    /// [`Noise::NOISY_EXACT_CAMERA`].
    NoisyExactCamera,
}

/// Settings of the adapters and of the stages, as `generate` has them.
#[derive(Clone)]
pub struct LayoutBench {
    pub embedded: EmbeddedSettings,
    pub stages: Arc<Settings>,
}

/// What came of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneScore {
    pub scene: String,
    pub family: Family,
    pub outline: Outline,
    pub text: String,
    pub seed: u64,
    /// The object that set the scale.
    pub anchor: Option<InstanceId>,
    pub camera: CameraScore,
    /// How often the scene was painted until nothing was hidden by more than the difficulty allows.
    pub paintings: u32,
    pub objects: Vec<ObjectScore>,
    pub ablation: Ablation,
}

/// Angles of the camera less the true ones, degrees: as recognized, and as the later stages had them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraScore {
    pub given_elevation_deg: f64,
    pub given_azimuth_deg: f64,
    pub elevation_deg: f64,
    pub azimuth_deg: f64,
}

impl CameraScore {
    fn new(truth: &Camera, given: &Camera, refined: &Camera) -> Self {
        let elevation = |camera: &Camera| (camera.elevation_rad() - truth.elevation_rad()).to_degrees();
        let azimuth =
            |camera: &Camera| wrap_angle_rad(camera.azimuth_rad() - truth.azimuth_rad()).to_degrees();
        Self {
            given_elevation_deg: elevation(given),
            given_azimuth_deg: azimuth(given),
            elevation_deg: elevation(refined),
            azimuth_deg: azimuth(refined),
        }
    }
}

impl Difficulty {
    pub fn noise(self) -> Option<Noise> {
        match self {
            Self::Clean => None,
            Self::Noisy => Some(Noise::NOISY),
            Self::NoisyExactCamera => Some(Noise::NOISY_EXACT_CAMERA),
        }
    }

    /// As tables name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Noisy => "noisy",
            Self::NoisyExactCamera => "noisy, camera exact",
        }
    }
}

/// A painting and what the stages get to see of it.
struct Painted {
    truth: Truth,
    /// As it was painted, not as the stages see it.
    recognition: Recognition,
    /// Of each object, its visible pixels, and their share of its whole silhouette.
    visible: Vec<(usize, f64)>,
    /// As the stages get to see it.
    given: Camera,
    /// How often it was painted.
    paintings: u32,
    seen: Arc<Painting>,
}

impl LayoutBench {
    /// The request the stages are run for.
    pub fn request(scene: &BenchmarkScene) -> SceneRequest {
        SceneRequest {
            version: SceneRequest::VERSION,
            input: scene::Input::Text { text: scene.text.to_owned() },
            seed: scene.seed,
            options: scene.options(),
        }
    }

    /// Scores a scene; `checkpoints` are those of a job with [`Self::request`].
    pub async fn score(
        &self,
        scene: &BenchmarkScene,
        difficulty: Difficulty,
        checkpoints: Checkpoints,
        call: &Call,
    ) -> Result<SceneScore, StageError> {
        let noise = difficulty.noise();
        let mut settings = self.embedded.clone();
        if let Some(noise) = noise {
            settings.painter = noise.painter(&settings.painter);
        }
        let ports = embedded::ports(&settings, None);
        let painted = self.paint(scene, noise, &ports, call).await?;
        let turned = Arc::new(Mutex::new(BTreeMap::new()));
        let ports = watched(ports, &painted, noise, scene.seed, &turned);
        let rotated = rotate_all(Self::request(scene), checkpoints, ports, self.stages.clone()).await?;
        let layout = rotated.placed(&rotated.yaws).await?;
        let turned = turned.lock().map(|known| known.clone()).unwrap_or_default();
        let mut compared = compare(&painted, &rotated, &layout, &turned)?;
        find_look_alikes(&painted, &mut compared, noise.is_some(), call).await?;
        let ablation = self.ablate(scene, &rotated, &layout, &compared).await?;
        Ok(SceneScore {
            scene: scene.name.clone(),
            family: scene.family,
            outline: scene.outline,
            text: scene.text.to_owned(),
            seed: scene.seed,
            anchor: layout.anchor.clone(),
            camera: CameraScore::new(
                &painted.recognition.camera,
                &painted.given,
                &rotated.recognition.camera,
            ),
            paintings: painted.paintings,
            objects: compared.iter().map(Compared::score).collect(),
            ablation,
        })
    }

    async fn paint(
        &self,
        scene: &BenchmarkScene,
        noise: Option<Noise>,
        ports: &Ports,
        call: &Call,
    ) -> Result<Painted, StageError> {
        let options = scene.options();
        let description = ports.analyst.describe(call, scene.text.to_owned(), scene.seed, options).await?;
        let description = Arc::new(description);
        let mut painting = ports.painter.reference(call, description.clone(), scene.seed).await?;
        let mut paintings = 1;
        let enough = noise.map_or(0.0, |noise| noise.least_visible_share);
        // The painter takes the best of the views it tried, which may hide more: things are arranged anew then.
        while least_visible_share(&painting) < enough && paintings < MAX_PAINTINGS {
            let seed = child_seed(scene.seed, &format!("painting {paintings}"));
            paintings += 1;
            let another = ports.painter.reference(call, description.clone(), seed).await;
            // An arrangement may fail where the first did not; the next one is tried.
            if let Some(better) =
                another.ok().filter(|p| least_visible_share(p) > least_visible_share(&painting))
            {
                painting = better;
            }
        }
        let seen = Arc::new(noise.map_or_else(|| painting.clone(), |n| n.spoiled(&painting, scene.seed)));
        let truth = || unscored(scene, "its painter tells no truth");
        let aside = painting.aside.as_ref().ok_or_else(truth)?;
        let given = seen.aside.as_ref().ok_or_else(truth)?.known.recognition.camera;
        Ok(Painted {
            truth: aside.truth.clone(),
            recognition: aside.known.recognition.clone(),
            visible: visible(aside).collect(),
            given,
            paintings,
            seen,
        })
    }

    async fn ablate(
        &self,
        scene: &BenchmarkScene,
        rotated: &Rotated,
        full: &place::Output,
        compared: &[Compared<'_>],
    ) -> Result<Ablation, StageError> {
        let seed = child_seed(scene.seed, "ablation");
        let guessed: Vec<rotate::Output> = compared
            .iter()
            .map(|object| rotate::Output {
                yaw_rad: ablation::guessed_yaw_rad(object.true_yaw_rad(), seed, &object.truth.name),
                seen_m: None,
                ..object.yaw.clone()
            })
            .collect();
        let without_dro = rotated.placed(&guessed).await?;
        let instead: Vec<Instead> = compared
            .iter()
            .map(|object| {
                let true_xy_m = object.truth.translation_m.truncate();
                ablation::guessed_place(true_xy_m, object.scale(), seed, &object.truth.name)
            })
            .collect();
        let without_tsa = moved(rotated, full, instead.clone()).await?;
        // The sizes the alignment gave with guessed yaws are not those it gave with its own.
        let both =
            instead.iter().zip(&full.instances).zip(&without_dro.instances).map(|((place, a), b)| Instead {
                factor: place.factor * (a.size_m.element_product() / b.size_m.element_product()).cbrt(),
                ..*place
            });
        let without_both = moved(rotated, &without_dro, both.collect()).await?;
        Ok(Ablation {
            full: self.colliding(rotated, full.clone()).await?,
            without_dro: self.colliding(rotated, without_dro).await?,
            without_tsa: self.colliding(rotated, without_tsa).await?,
            without_both: self.colliding(rotated, without_both).await?,
        })
    }

    async fn colliding(&self, rotated: &Rotated, layout: place::Output) -> Result<Colliding, StageError> {
        let inputs = ablation::Overlaps { layout, certify: self.stages.certify.clone() };
        rotated.stages().run(ablation::COLLIDE, inputs, ablation::colliding).await
    }
}

/// Of each object, its visible pixels, and their share of its whole silhouette.
fn visible(aside: &PaintingAside) -> impl Iterator<Item = (usize, f64)> {
    let drawn = aside.known.masks.iter().zip(&aside.alone);
    drawn.map(|(mask, drawn)| (mask.visible.area_px(), 1.0 - drawn.completion.completed_share))
}

/// Of the object that is hidden most.
fn least_visible_share(painting: &Painting) -> f64 {
    let shares = painting.aside.iter().flat_map(|aside| visible(aside).map(|(_, share)| share));
    shares.fold(1.0, f64::min)
}

async fn moved(
    rotated: &Rotated,
    layout: &place::Output,
    instead: Vec<Instead>,
) -> Result<place::Output, StageError> {
    let moves = ablation::Moves { layout: layout.clone(), instead };
    rotated.stages().run(ablation::MOVE, moves, ablation::moved).await
}

/// The ports that the stages ask.
fn watched(
    ports: Ports,
    painted: &Painted,
    noise: Option<Noise>,
    scene_seed: u64,
    turned: &Arc<Mutex<BTreeMap<InstanceId, DQuat>>>,
) -> Ports {
    let seed = child_seed(scene_seed, "noise");
    let objects = painted.recognition.objects.iter().map(|object| (object.id.clone(), object.clone()));
    let generator: Arc<dyn MeshGenerator> = Arc::new(WatchedMeshes {
        generator: ports.mesh_generator,
        painted: objects.collect(),
        noise,
        seed,
        turned: turned.clone(),
    });
    let segmenter: Arc<dyn Segmenter> = match noise {
        Some(noise) => Arc::new(JitteredBoxes { segmenter: ports.segmenter, noise, seed }),
        None => ports.segmenter,
    };
    let painter = PaintedAlready { painter: ports.painter, painting: painted.seen.clone(), noise };
    Ports { painter: Arc::new(painter), segmenter, mesh_generator: generator, ..ports }
}

/// Looks at every object whose yaw is scored: turned on from its true pose, or, where its mesh was stood on another side,
/// from the pose it was given. `repictured`: the stages' meshes wear other pictures than the painted ones.
async fn find_look_alikes(
    painted: &Painted,
    compared: &mut [Compared<'_>],
    repictured: bool,
    call: &Call,
) -> Result<(), StageError> {
    let world = Arc::new(TrueWorld::new(&painted.recognition, &painted.truth)?);
    let looks: Vec<Look> = compared
        .iter()
        .enumerate()
        .filter(|(_, object)| object.truth.symmetry_order != 0)
        .map(|(index, object)| Look { object: index, rotation: object.look_from() })
        .collect();
    let found = world.look(looks.clone(), call).await?;
    looks.iter().zip(found).for_each(|(look, alikes)| compared[look.object].look_alikes = alikes);
    if repictured {
        find_what_only_pictures_tell(&world, &looks, compared, call).await?;
    }
    Ok(())
}

/// Yaws are ambiguous to people who see no pictures where they look the same and lie farther apart than this, degrees.
const AMBIGUOUS_DEG: f64 = 10.0;

/// Looks at the same objects once more, turned on from their true poses and without the pictures on them.
async fn find_what_only_pictures_tell(
    world: &Arc<TrueWorld>,
    looks: &[Look],
    compared: &mut [Compared<'_>],
    call: &Call,
) -> Result<(), StageError> {
    let as_painted = |look: &Look| Look { rotation: compared[look.object].truth.rotation_xyzw, ..*look };
    let on_its_side: Vec<Look> = looks.iter().map(as_painted).collect();
    let wrong = |look: &&Look| compared[look.object].wrong_side();
    let not_looked_at: Vec<Look> = on_its_side.iter().filter(wrong).copied().collect();
    let mut pictured: BTreeMap<usize, LookAlikes> =
        looks.iter().map(|look| (look.object, compared[look.object].look_alikes.clone())).collect();
    let found = world.look(not_looked_at.clone(), call).await?;
    pictured.extend(not_looked_at.iter().map(|look| look.object).zip(found));
    let plain = Arc::new(world.without_pictures()).look(on_its_side, call).await?;
    for (look, plain) in looks.iter().zip(plain) {
        compared[look.object].only_pictures_tell = !plain.are_near(&pictured[&look.object], AMBIGUOUS_DEG);
    }
    Ok(())
}

fn compare<'a>(
    painted: &'a Painted,
    rotated: &'a Rotated,
    layout: &'a place::Output,
    turned: &BTreeMap<InstanceId, DQuat>,
) -> Result<Vec<Compared<'a>>, StageError> {
    let lost = |id: &InstanceId, what: &str| {
        StageError::permanent("not_compared", format!("evaluating {id}: {what}; a bug of the evaluation"))
    };
    let mut compared = Vec::with_capacity(painted.truth.instances.len());
    for (index, truth) in painted.truth.instances.iter().enumerate() {
        let found = |id: &InstanceId| *id == truth.name;
        let (placed, object) = (&layout.instances[index], &painted.recognition.objects[index]);
        if !found(&placed.id) || !found(&object.id) {
            return Err(lost(&truth.name, "the layout is in another order"));
        }
        let turned = *turned.get(&truth.name).ok_or_else(|| lost(&truth.name, "no mesh was asked for"))?;
        compared.push(Compared {
            category: &object.category,
            truth,
            placed,
            canonical: &rotated.canonical[index],
            yaw: &rotated.yaws[index],
            turned,
            look_alikes: LookAlikes::only_itself(),
            only_pictures_tell: false,
            visible_px: painted.visible[index].0,
            visible_share: painted.visible[index].1,
        });
    }
    Ok(compared)
}

fn unscored(scene: &BenchmarkScene, what: &str) -> StageError {
    StageError::permanent("not_scored", format!("evaluating {}: {what}", scene.name))
}
