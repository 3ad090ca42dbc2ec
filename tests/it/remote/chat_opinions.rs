//! Opinions of the chat analyst on meshes and on finished scenes: its questions, the accepted answers, and the evidence
//! of the image.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use catalog::{Recipe, build, category};
use geometry::{Camera, Pose};
use glam::{DQuat, DVec3};
use imaging::Image;
use imaging::codec::decode_png;
use ports::ledger::OnUnknown;
use ports::{
    Completion, Judgement, MadeAfter, ProviderError, SceneAnalyst, TaskObject, TaskQuestion, Upright,
    UprightQuestion,
};
use remote::chat::ChatAnalyst;
use render::{Background, Lighting, RenderObject, RenderScene, View, render};
use scene::appraisal::{Criterion, ModelResponse, ProposedTask, Rating, TaskKind};
use scene::instance::SupportRelation;
use scene::{InstanceId, RecognizedObject, StandsOn};
use serde_json::{Value, json};

use crate::harness::server::settings;
use crate::remote::bench::class;
use crate::remote::chat::{Bench, endpoint, quick};
use crate::remote::chat_server::{Answers, ChatServer, Fault, KEY};

/// A wine glass as an image generator shows it.
static GLASS: LazyLock<UprightQuestion> = LazyLock::new(|| {
    let config = settings(&[]).config;
    let size_m = category("wine_glass").unwrap().size.typical_m();
    let recipe = Recipe { category: "wine_glass".into(), size_m, color: None, material: None, seed: 5 };
    let mesh = build(&recipe).unwrap();
    let camera = Camera::orbit(320, 240, 0.61, DVec3::ZERO, 0.1, 0.6, 0.9);
    let scene = RenderScene {
        objects: vec![RenderObject {
            mesh: &mesh,
            world_from_object: Pose::upright(DVec3::ZERO, 0.3),
            id: 1,
        }],
        lighting: Lighting::studio(-0.5, 0.9, 0.4),
        background: Background::light(),
    };
    let seen = render(&scene, &View::Perspective(camera), &config.render);
    let silhouette = seen.mask(1);
    let mut image = seen.color.clone();
    for y in 0..240 {
        for x in 0..320 {
            if !silhouette.contains(x, y) {
                image.set_pixel(x, y, [0; 4]);
            }
        }
    }
    UprightQuestion {
        raw_mesh: Arc::new(mesh),
        object: RecognizedObject {
            id: InstanceId::new("wine_glass_1").unwrap(),
            label: "wine glass".into(),
            category: "object".into(),
            size_m,
            tipped: None,
            color: None,
            material: None,
            seed: 9,
            stands_on: StandsOn::Table,
            seen_px: None,
            seen_as: None,
            seen_like: None,
            mass_kg: None,
            stand_in: None,
        },
        camera,
        completion: Completion {
            image,
            crop_px: [0.0, 0.0, 320.0, 240.0],
            silhouette,
            completed_share: 0.0,
            completed_by: Vec::new(),
        },
        canonicalize: config.canonicalize,
        dro: config.dro,
    }
});

/// The glass, its mesh turned like this.
fn turned(raw_from_canonical: DQuat) -> UprightQuestion {
    let raw_mesh = Arc::new((*GLASS.raw_mesh).clone().rotated(raw_from_canonical));
    UprightQuestion { raw_mesh, ..GLASS.clone() }
}

fn scene_after(after: MadeAfter) -> Judgement {
    Judgement { after, scene_view: Arc::new(Image::filled(64, 48, [180, 180, 180, 255])), seed: 7 }
}

fn objects() -> Vec<TaskObject> {
    let object = |name: &str, label: &str| TaskObject {
        name: InstanceId::new(name).unwrap(),
        label: label.into(),
        material: None,
        size_m: [0.05, 0.05, 0.05],
        mass_kg: 0.2,
        relation: SupportRelation::On,
        carried_by: "table".into(),
    };
    vec![object("apple_1", "red apple"), object("plate_1", "plate"), object("fork_1", "fork")]
}

impl Bench {
    pub async fn upright(&self) -> Result<Upright, ProviderError> {
        in_time(self.analyst.upright(&self.call, GLASS.clone())).await
    }

    pub async fn judge(&self) -> Result<ModelResponse<Vec<Rating>>, ProviderError> {
        let after = MadeAfter::Text("an apple on a plate and a fork".into());
        in_time(self.analyst.judge(&self.call, scene_after(after))).await
    }

    pub async fn judge_after_image(&self) -> Result<ModelResponse<Vec<Rating>>, ProviderError> {
        let image = Arc::new(Image::filled(64, 48, [90, 80, 70, 255]));
        in_time(self.analyst.judge(&self.call, scene_after(MadeAfter::Image(image)))).await
    }

    pub async fn tasks(&self) -> Result<ModelResponse<Vec<ProposedTask>>, ProviderError> {
        let question = TaskQuestion { objects: objects(), count: 2, seed: 7 };
        in_time(self.analyst.propose_tasks(&self.call, question)).await
    }

    /// The same, with a server that gives these answers to its questions, one after the other and then the
    /// last one again.
    async fn saying(answers: Vec<Value>) -> Self {
        let asked = Arc::new(AtomicUsize::new(0));
        let answers: Answers = Arc::new(move |_, _| {
            let at = asked.fetch_add(1, Ordering::Relaxed).min(answers.len() - 1);
            let answer = answers[at].clone();
            Box::pin(async move { answer })
        });
        let server = ChatServer::start(answers).await;
        let chat = quick(&server);
        let endpoint = Arc::new(endpoint(&chat, KEY, OnUnknown::Resend));
        Bench { server, analyst: ChatAnalyst { settings: chat, endpoint }, ..Bench::new().await }
    }
}

async fn in_time<T>(asked: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
}

fn said(top: &str, front: &str) -> Value {
    json!({ "top": top, "front": front })
}

/// The sheet of views that was sent.
fn sheet(request: &Value) -> Image {
    let url = request["messages"][1]["content"][2]["image_url"]["url"].as_str().unwrap();
    let png = STANDARD.decode(url.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
    decode_png(&png).unwrap()
}

/// Mean difference of two images of one size, of 255.
fn apart(one: &Image, other: &Image) -> f64 {
    let (one, other) = (one.as_rgba(), other.as_rgba());
    assert_eq!(one.len(), other.len());
    let sum: f64 = one.iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / one.len() as f64
}

/// Angle between two rotations that may differ by a turn about the vertical, radians.
fn tilt(one: DQuat, other: DQuat) -> f64 {
    (one.conjugate() * DVec3::Z).angle_between(other.conjugate() * DVec3::Z)
}

#[tokio::test]
async fn upright_mesh_is_inspected_once() {
    let bench = Bench::saying(vec![said("top", "front")]).await;
    let Upright { pose, views } = bench.upright().await.unwrap();
    assert_eq!(bench.server.requests().len(), 1);
    assert_eq!((views.len(), views[0].top.as_str()), (1, "top"));
    assert!(pose.rotation.abs_diff_eq(DQuat::IDENTITY, 1e-9) && pose.confidence > 0.3, "{pose:?}");
}

#[tokio::test]
async fn rotated_mesh_is_inspected_again_in_its_new_pose() {
    // Its mouth shows on the left, its foot on the right.
    let raw_from_canonical = DQuat::from_rotation_y(-FRAC_PI_2);
    let bench = Bench::saying(vec![said("left", "front"), said("top", "front")]).await;
    let upright = bench.analyst.upright(&bench.call, turned(raw_from_canonical)).await.unwrap();
    let [first, second] = &bench.server.requests()[..] else { panic!("two views") };
    let as_it_was = Bench::saying(vec![said("top", "front")]).await;
    as_it_was.upright().await.unwrap();
    let standing = sheet(&as_it_was.server.requests()[0]);
    assert!(apart(&sheet(first), &standing) > 2.0, "the first look is at the mesh as it came");
    assert!(apart(&sheet(second), &standing) < 0.1, "the second as it belongs");
    assert!((upright.pose.rotation * raw_from_canonical).abs_diff_eq(DQuat::IDENTITY, 1e-6), "{upright:?}");
    assert_eq!(upright.views.len(), 2);
    assert_eq!(upright.views[0].rotation_xyzw, upright.views[1].rotation_xyzw);
}

#[tokio::test]
async fn image_evidence_overrules_the_model() {
    // It says, twice, that the glass stands on its mouth.
    let bench = Bench::saying(vec![said("bottom", "front"), said("top", "front")]).await;
    let Upright { pose, views } = bench.upright().await.unwrap();
    assert!(tilt(views[1].rotation_xyzw, DQuat::from_rotation_x(PI)) < 1e-6, "{views:?}");
    assert!(tilt(pose.rotation, DQuat::IDENTITY) < 1e-6, "{pose:?}");
    // A model that says another object each time is asked twice and no more.
    let bench = Bench::saying(vec![said("left", "front"), said("right", "back"), said("back", "top")]).await;
    let Upright { pose, .. } = bench.upright().await.unwrap();
    assert_eq!(bench.server.requests().len(), 2);
    assert!(tilt(pose.rotation, DQuat::IDENTITY) < 1e-6, "{pose:?}");
}

#[tokio::test]
async fn a_front_on_top_is_corrected_once_and_then_no_answer() {
    let bench = Bench::saying(vec![said("top", "bottom"), said("top", "front")]).await;
    assert_eq!(bench.upright().await.unwrap().views.len(), 1);
    let complaint = bench.server.requests()[1]["messages"][3].to_string();
    assert!(complaint.contains("neither the view named in top"), "{complaint}");
    let bench = Bench::saying(vec![said("top", "bottom")]).await;
    assert_eq!(class(&bench.upright().await.unwrap_err()), "transient provider_bad_answer");
}

#[tokio::test]
async fn scenes_are_rated_by_what_they_were_made_after() {
    let bench = Bench::new().await;
    let after_text = bench.judge().await.unwrap();
    assert_eq!((after_text.by.as_str(), after_text.prompt.as_str()), ("openai/chat", "judge_text 1"));
    let criteria: Vec<Criterion> = after_text.said.iter().map(|rating| rating.criterion).collect();
    assert_eq!(criteria, Criterion::OF_TEXT);
    let after_image = bench.judge_after_image().await.unwrap();
    let scores: Vec<u8> = after_image.said.iter().map(|rating| rating.score).collect();
    assert_eq!((after_image.prompt.as_str(), scores), ("judge_picture 1", vec![6, 5, 7]));
    let images = |request: &Value| request["messages"][1]["content"].as_array().unwrap().len() - 1;
    assert_eq!(bench.server.requests().iter().map(images).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(bench.book.outcomes(), [Some("answered"); 2]);
}

#[tokio::test]
async fn invalid_scores_are_rejected() {
    for (pointer, value) in [
        ("/object_quality/score", json!(0)),
        ("/object_quality/score", json!(7.5)),
        ("/object_quality/score", json!("seven")),
        ("/object_quality/why", json!("")),
    ] {
        let bench = Bench::new().await;
        bench.server.script([Fault::Spoiled(pointer, value.clone())]);
        assert_eq!(bench.judge().await.unwrap().said.len(), 4);
        assert_eq!(bench.server.requests().len(), 2, "{value} is asked about again");
        bench.server.script([Fault::Spoiled(pointer, value.clone()), Fault::Spoiled(pointer, value)]);
        assert_eq!(class(&bench.judge().await.unwrap_err()), "transient provider_bad_answer");
    }
}

#[tokio::test]
async fn tasks_name_objects_of_the_scene() {
    let bench = Bench::new().await;
    let tasks = bench.tasks().await.unwrap();
    assert_eq!((tasks.said.len(), tasks.said[1].kind), (2, TaskKind::Swap));
    let sent = bench.server.requests()[0]["messages"][1]["content"][0]["text"].as_str().unwrap().to_owned();
    let sent: Value = serde_json::from_str(&sent).unwrap();
    assert_eq!((&sent["count"], &sent["things"][0]["label"]), (&json!(2), &json!("red apple")));
    for (pointer, value) in [
        ("/tasks/0/objects/0", json!("giraffe_1")),
        ("/tasks/0/objects", json!([])),
        ("/tasks/1", json!({ "instruction": "Dance.", "kind": "dance", "objects": ["apple_1"] })),
        ("/tasks", json!([])),
    ] {
        let bench = Bench::new().await;
        bench.server.script([Fault::Spoiled(pointer, value.clone()), Fault::Spoiled(pointer, value)]);
        assert_eq!(class(&bench.tasks().await.unwrap_err()), "transient provider_bad_answer", "{pointer}");
    }
}
