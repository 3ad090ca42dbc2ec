//! The stage `edit`: the operations, carried out in order on the parent scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::draft::{Draft, load as load_geometry};
use super::error::EditError;
use super::operations::{NewTable, OperationInputs, carry_out, color_named, material_named};
use super::{Additions, Words, account, refused, view};
use crate::pipeline::checkpoint::Stage;
use crate::pipeline::composition::Composition;
use crate::pipeline::error::StageError;
use crate::pipeline::preview::PreviewSettings;
use crate::pipeline::resolve::{Loaded, load};
use crate::pipeline::{Context, Settings, artifact_io, task_scene};
use editing::RestSettings;
use physics::{CertifySettings, SettleSettings};
use ports::{Adapter, Ports, TableRequest};
use render::RenderSettings;
use runtime::seed::child_seed;
use scene::edit::{EditAccount, OperationResult};
use scene::{EditOperation, InstanceId, SupportRelation};

pub const STAGE: Stage = Stage { name: "edit", version: 11 };

/// Plan of a change of the parent.
#[derive(Serialize)]
pub struct Plan {
    /// Id of the parent in its `scene.json`.
    pub parent_id: String,
    pub operations: Vec<EditOperation>,
    #[serde(flatten)]
    pub words: Words,
    pub(super) additions: Additions,
    /// Whether a seed drew the operations: one that cannot be carried out is left out then.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_drawn: bool,
    pub seed: u64,
}

#[derive(Serialize)]
pub struct Inputs {
    parent: Composition,
    #[serde(flatten)]
    plan: Plan,
    settle: SettleSettings,
    certify: CertifySettings,
    render: RenderSettings,
    preview: PreviewSettings,
    mesh_generator: Adapter,
}

impl Inputs {
    pub fn new(parent: Composition, plan: Plan, ports: &Ports, settings: &Settings) -> Self {
        Self {
            parent,
            plan,
            settle: settings.settle.clone(),
            certify: settings.certify.clone(),
            render: settings.render.clone(),
            preview: settings.preview.clone(),
            mesh_generator: ports.mesh_generator.adapter(),
        }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Composition, StageError> {
    let bodies = &inputs.parent.bodies;
    let parts = bodies.iter().map(|body| load(&context, &body.resolved.name, &body.mesh, &body.hulls));
    let loaded: Vec<Loaded> = futures::future::try_join_all(parts).await?;
    let mut additions: BTreeMap<usize, Vec<Loaded>> = BTreeMap::new();
    for (index, objects) in &inputs.plan.additions {
        let parts = objects
            .iter()
            .map(|new| load(&context, new.recognized.id.as_str(), &new.canonical.mesh, &new.hulls.hulls));
        additions.insert(*index, futures::future::try_join_all(parts).await?);
    }
    let tables = tables(&context, &inputs).await?;

    let (given, cancel) = (inputs.clone(), context.cancel().clone());
    let edited = context.cpu(move || carry_out_all(&given, loaded, additions, tables, cancel)).await??;
    let Edited { mut composition, loaded, changed } = edited;
    for (body, geometry) in composition.bodies.iter_mut().zip(&loaded) {
        let name = body.resolved.name.clone();
        if changed.contains(&name) {
            body.mesh =
                artifact_io::put_mesh(&context, &format!("{name}.glb"), (*geometry.mesh).clone()).await?;
            body.hulls = context.put_json(&format!("{name}_hulls.json"), &geometry.hulls).await?;
            (body.resolved.mesh, body.resolved.hulls) = (body.mesh.clone(), body.hulls.clone());
        }
    }
    (composition.table.mesh, composition.table.hulls) =
        (composition.bodies[0].mesh.clone(), composition.bodies[0].hulls.clone());

    let given = inputs.clone();
    let (composition, image, masks) = context
        .cpu(move || {
            let rendered = view::rendered(&composition, &loaded, &given.render, &given.preview);
            rendered.map(|(image, masks)| (composition, image, masks))
        })
        .await?
        .map_err(|error| {
            StageError::transient("gpu_failed", format!("rendering the edited scene: {error}"))
        })?;
    let mut composition = composition;
    composition.image = artifact_io::put_image(&context, "reference.png", image).await?;
    // They are of the parent's image.
    let recognition = Arc::make_mut(&mut composition.recognition);
    recognition.left_out_px.clear();
    recognition.depth = None;
    composition.unread = None;
    composition.masks = masks;
    context.put_json("account.json", &composition.edit).await?;
    Ok(composition)
}

/// Tables with another color or material, by index of the operation.
async fn tables(context: &Context, inputs: &Inputs) -> Result<BTreeMap<usize, NewTable>, StageError> {
    let mut tables = BTreeMap::new();
    let mut recognized = inputs.parent.recognition.table.clone();
    for (index, operation) in inputs.plan.operations.iter().enumerate() {
        let EditOperation::RestyleTable { material, color } = operation else { continue };
        let refuse = |why: EditError| refused(index, operation, &why);
        let color = color.as_deref().map(color_named).transpose().map_err(refuse)?;
        let material =
            material.as_deref().map(|words| material_named(words, true)).transpose().map_err(refuse)?;
        recognized.color = color.or(recognized.color);
        recognized.material = material.or(recognized.material);
        let generator = &context.services().ports.mesh_generator;
        let request = TableRequest { table: recognized.clone(), photograph: None };
        let raw = generator.table(&context.call(), request).await?;
        let same = raw.outline_m == inputs.parent.table.outline_m;
        if !same && inputs.plan.is_drawn {
            continue;
        }
        if !same {
            return Err(refuse(EditError::OtherTableTop));
        }
        let hulls = artifact_io::hulls(context, &inputs.parent.bodies[0].hulls).await?;
        let loaded = context.cpu(move || load_geometry(raw.mesh, hulls)).await?.map_err(refuse)?;
        tables.insert(index, NewTable { loaded, material: recognized.material.clone(), color });
    }
    Ok(tables)
}

/// The account of a drawn operation that the scene has no room for.
fn left_out(operation: &EditOperation, why: &EditError) -> OperationResult {
    let op = operation.name().to_owned();
    let sentence = format!("left {op} out: {why}");
    OperationResult { op, objects: Vec::new(), sentence, words: None }
}

struct Edited {
    composition: Composition,
    loaded: Vec<Loaded>,
    /// Names of the bodies with other geometry.
    changed: std::collections::BTreeSet<String>,
}

/// Supporter and relation of each object, which a text may state.
fn supports(draft: &Draft) -> BTreeMap<InstanceId, (Option<InstanceId>, SupportRelation)> {
    let support = |object: usize| {
        let supporter = draft.supporter(object);
        (draft.id(object), (supporter.parent.map(|parent| draft.id(parent)), supporter.relation))
    };
    (0..draft.len()).map(support).collect()
}

fn carry_out_all(
    inputs: &Inputs,
    loaded: Vec<Loaded>,
    mut additions: BTreeMap<usize, Vec<Loaded>>,
    mut tables: BTreeMap<usize, NewTable>,
    cancel: runtime::CancelFlag,
) -> Result<Edited, StageError> {
    let rest = RestSettings { settle: &inputs.settle, certify: &inputs.certify, may_roll: false };
    let unusable =
        |why: EditError| StageError::permanent("no_collision_geometry", format!("editing the parent: {why}"));
    let mut draft = Draft::new(inputs.parent.clone(), loaded, rest, cancel.clone()).map_err(unusable)?;
    let mut results: Vec<OperationResult> = Vec::with_capacity(inputs.plan.operations.len());
    for (index, operation) in inputs.plan.operations.iter().enumerate() {
        cancel.check()?;
        let new = inputs.plan.additions.get(&index).into_iter().flatten();
        let given = OperationInputs {
            additions: new.zip(additions.remove(&index).into_iter().flatten()).collect(),
            table: tables.remove(&index),
            seed: child_seed(inputs.plan.seed, &format!("edit {index}")),
        };
        let before = inputs.plan.is_drawn.then(|| draft.clone());
        let seen_before = account::Before::of(&draft);
        let done = carry_out(&mut draft, operation, given).and_then(|done| match &before {
            Some(before) if supports(before) != supports(&draft) => Err(EditError::OtherSupports),
            _ => Ok(done),
        });
        // A cancelled simulation is no refusal.
        cancel.check()?;
        match (done, before) {
            (Ok(done), _) => {
                let text = draft.composition.account.take();
                draft.composition.account =
                    text.map(|text| account::after(text, operation, &done, &seen_before, &draft));
                results.push(done);
            }
            (Err(why), Some(before)) => {
                draft = before;
                results.push(left_out(operation, &why));
            }
            (Err(why), None) => return Err(refused(index, operation, &why)),
        }
    }
    let settled = draft.settle_containers();
    cancel.check()?;
    settled.map_err(|why| {
        StageError::permanent("edit_refused", format!("after all operations {why}; nothing was changed"))
    })?;
    let (mut composition, loaded, changed, moved) = draft.finish();
    if let Some(mut text) = composition.account.take() {
        text.of_scene.get_or_insert_with(|| inputs.plan.parent_id.clone());
        let has_goal = text.goal.is_some();
        composition.account = Some(match task_scene::described(&composition, &loaded) {
            Ok(scene) if has_goal => account::without_reached_goal(text, &scene),
            _ => text,
        });
    }
    for (done, words) in results.iter_mut().zip(&inputs.plan.words.words) {
        done.words = Some(words.clone());
    }
    composition.edit = Some(EditAccount {
        parent: inputs.plan.parent_id.clone(),
        operations: results,
        asides: inputs.plan.words.asides.clone(),
        moved,
    });
    composition.resolve = certificate::ResolveFinding {
        rounds: 1,
        log: composition
            .edit
            .iter()
            .flat_map(|edit| &edit.operations)
            .map(|done| done.sentence.clone())
            .collect(),
        gave_way: Vec::new(),
    };
    Ok(Edited { composition, loaded, changed })
}
