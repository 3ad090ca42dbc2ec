//! A pipeline of three stages that does what a test tells it: wait, fail, panic, pass.
//!
//! `alpha` works on the whole scene, `beta` on two instances, `omega` packs a bundle.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Cursor, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use scene::{InstanceId, SceneRequest};
use serde::{Deserialize, Serialize};
use store::artifacts::{ArchiveRow, FileRow};
use tabletopgen::pipeline::checkpoint::{ArtifactRef, Stage, StageContext};
use tabletopgen::pipeline::error::StageError;
use tabletopgen::worker::{BuildScene, BuiltScene, JobContext};
use tokio::sync::Semaphore;

pub const ALPHA: Stage = Stage { name: "alpha", version: 1 };
pub const BETA: Stage = Stage { name: "beta", version: 1 };
pub const OMEGA: Stage = Stage { name: "omega", version: 1 };

/// Behavior of the next run of a stage.
#[derive(Clone, Debug)]
pub enum Act {
    /// Waits for [`Script::open_gate`], or for the interrupt.
    Wait,
    /// Computes for a minute, whatever it is asked.
    Ignore,
    Panic,
    Transient,
    Permanent,
}

/// The plan, and what happened.
pub struct Script {
    plan: Mutex<BTreeMap<&'static str, VecDeque<Act>>>,
    runs: Mutex<Vec<String>>,
    gate: Semaphore,
    /// `false` certifies quarantine.
    pub passes: bool,
}

impl Script {
    pub fn new(plan: &[(&'static str, &[Act])]) -> Arc<Self> {
        Arc::new(Self::plain(plan, true))
    }

    pub fn quarantining() -> Arc<Self> {
        Arc::new(Self::plain(&[], false))
    }

    fn plain(plan: &[(&'static str, &[Act])], passes: bool) -> Self {
        let plan = plan.iter().map(|(stage, acts)| (*stage, acts.iter().cloned().collect())).collect();
        Self { plan: Mutex::new(plan), runs: Mutex::default(), gate: Semaphore::new(0), passes }
    }

    /// Plans the next run of a stage, after those planned before.
    pub fn next(&self, stage: &'static str, act: Act) {
        self.plan.lock().unwrap().entry(stage).or_default().push_back(act);
    }

    /// Lets everything that waits, and will wait, go on.
    pub fn open_gate(&self) {
        self.gate.add_permits(1000);
    }

    /// Computed stages, in order: `alpha`, `beta/mug_1`, ...
    pub fn runs(&self) -> Vec<String> {
        self.runs.lock().unwrap().clone()
    }

    /// Returns when a stage has begun to run.
    pub async fn reaches(&self, run: &str) {
        let reached = async {
            while !self.runs().iter().any(|seen| seen == run) {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        };
        tokio::time::timeout(Duration::from_secs(20), reached).await.expect("the stage is reached");
    }

    /// As the worker takes it.
    pub fn build(self: &Arc<Self>) -> BuildScene {
        let script = self.clone();
        Arc::new(move |context| Box::pin(build(context, script.clone())))
    }
}

#[derive(Serialize)]
struct Inputs {
    request: SceneRequest,
    before: Vec<Output>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Output {
    artifacts: Vec<ArtifactRef>,
}

async fn build(context: JobContext, script: Arc<Script>) -> Result<BuiltScene, StageError> {
    let passed = script.passes;
    let stages = context.checkpoints.for_stages(&[ALPHA.name, BETA.name, OMEGA.name], script);
    let request = context.request;
    let inputs = |before: Vec<Output>| Inputs { request: request.clone(), before };
    let alpha = stages.run(ALPHA, inputs(vec![]), put_note).await?;
    let mugs = ["mug_1", "mug_2"]
        .map(|name| (InstanceId::new(name).expect("is a name"), inputs(vec![alpha.clone()])));
    let betas = stages.run_each(BETA, mugs.into(), put_note).await?;
    let omega = stages.run(OMEGA, inputs(betas), pack).await?;
    let files = omega.artifacts.iter().map(|artifact| FileRow {
        name: artifact.name.trim_start_matches("omega/").to_owned(),
        digest: artifact.digest.clone(),
        media_type: artifact.media_type.clone(),
        size: artifact.size,
    });
    let (archives, files): (Vec<_>, Vec<_>) = files.partition(|file| file.name.ends_with(".zip"));
    Ok(BuiltScene {
        archive: ArchiveRow { digest: archives[0].digest.clone(), size: archives[0].size },
        files,
        passed,
        reasons: if passed { vec![] } else { vec!["mug_1 floats".into()] },
        summary: serde_json::json!({ "objects": 2, "categories": ["bowl", "mug"] }),
        metrics: serde_json::json!({ "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_shipped": 1.0 }),
    })
}

/// First part of every stage: the planned behavior.
async fn act(context: &StageContext<Script>) -> Result<(), StageError> {
    let script = context.services();
    let stage = context.stage_name();
    script.runs.lock().unwrap().push(run_of(context));
    let next = script.plan.lock().unwrap().get_mut(stage).and_then(VecDeque::pop_front);
    match next {
        None => Ok(()),
        Some(Act::Wait) => loop {
            context.cancel().check()?;
            let wait = tokio::time::timeout(Duration::from_millis(5), script.gate.acquire()).await;
            if let Ok(Ok(permit)) = wait {
                permit.forget();
                return Ok(());
            }
        },
        Some(Act::Ignore) => context.cpu(|| std::thread::sleep(Duration::from_secs(60))).await,
        Some(Act::Panic) => panic!("the script says so"),
        Some(Act::Transient) => Err(StageError::transient("flaky", "it did not work this time")),
        Some(Act::Permanent) => Err(StageError::permanent("hopeless", "it never works; change the text")),
    }
}

/// `alpha`, `beta/mug_1`.
fn run_of(context: &StageContext<Script>) -> String {
    let stage = context.stage_name();
    context.instance().map_or(stage.to_owned(), |instance| format!("{stage}/{instance}"))
}

async fn put_note(context: StageContext<Script>, _: Arc<Inputs>) -> Result<Output, StageError> {
    act(&context).await?;
    let about = format!("{} was here", run_of(&context));
    Ok(Output { artifacts: vec![context.put("note.txt", "text/plain", about).await?] })
}

async fn pack(context: StageContext<Script>, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    act(&context).await?;
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut artifacts = Vec::new();
    for (name, text) in [
        ("scene.json", format!("{{ \"id\": \"5ce9e{}\" }}", inputs.request.seed)),
        ("mjcf/scene.xml", "<mujoco model=\"scene\"/>".to_owned()),
        ("usd/scene.usda", "#usda 1.0\n".repeat(2000)),
    ] {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(format!("scene-5ce9e/{name}"), options).expect("starts");
        archive.write_all(text.as_bytes()).expect("writes");
        artifacts.push(context.put(name, "text/plain", text).await?);
    }
    let bytes = archive.finish().expect("finishes").into_inner();
    artifacts.push(context.put("all.zip", "application/zip", bytes).await?);
    Ok(Output { artifacts })
}
