//! Stage `clutter`: objects without a stated place are dropped onto each other, for a request that asks for it.
//!
//! The stage takes the scene as `resolve` leaves it and gives it back with other poses and supports, so another density
//! repeats nothing before. Who is dropped is decided in [`mod@roles`]. World frame, meters.

mod roles;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::Stage;
use super::error::StageError;
use super::resolve::{self, Loaded, body, load};
use super::{Context, PreparedObjects, Settings, place};
use catalog::{Affordance, category};
use geometry::Outline;
use geometry::solid_query::MeshSolid;
use physics::clutter::supporters;
use physics::settle::angle_between_rad;
use physics::{
    Body, CertifySettings, ClutterError, ClutterProblem, ClutterSettings, DropRole, DroppedLayout,
    ResolveSettings, SettleSettings, drop_clutter,
};
use runtime::CancelFlag;
use scene::InstanceId;
use scene::clutter::{Clutter, ClutterPlacement};

pub const STAGE: Stage = Stage { name: "clutter", version: 2 };

#[derive(Serialize)]
pub struct Inputs {
    clutter: Clutter,
    seed: u64,
    resolved: resolve::Output,
    /// Of the objects, in order.
    roles: Vec<DropRole>,
    /// Whether each object can contain others.
    containers: Vec<bool>,
    outline_m: Outline,
    resolve: ResolveSettings,
    settle: SettleSettings,
    certify: CertifySettings,
}

/// The scene after the drop.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub resolved: resolve::Output,
    pub heap: Heap,
}

/// Clutter of a scene as it was made; the certificate measures it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heap {
    pub density: f64,
    /// The objects that were dropped, by name, also those that were set down upright in the end.
    pub dropped: Vec<InstanceId>,
    /// The dropped objects that were set down upright.
    pub set_down: Vec<InstanceId>,
}

impl Inputs {
    /// Inputs of the stage; `None` where the request asks for no clutter.
    pub fn new(
        objects: &PreparedObjects,
        layout: &place::Output,
        resolved: &resolve::Output,
    ) -> Option<Self> {
        let PreparedObjects { request, reference, recognition, settings, .. } = objects;
        let Settings { resolve, settle, certify, .. } = &**settings;
        let can_contain = |name: &str| category(name).is_some_and(|kind| kind.affords(Affordance::Container));
        Some(Self {
            clutter: request.options.clutter?,
            seed: request.seed,
            resolved: resolved.clone(),
            roles: roles::of_objects(recognition, reference.stated.as_deref(), layout, resolved),
            containers: recognition.objects.iter().map(|object| can_contain(&object.category)).collect(),
            outline_m: layout.table.outline_m.clone(),
            resolve: resolve.clone(),
            settle: settle.clone(),
            certify: certify.clone(),
        })
    }
}

/// The scene after the drop, with what was dropped; the scene itself where the request asks for no clutter.
///
/// # Errors
///
/// The error of the stage.
pub(super) async fn after(
    objects: &PreparedObjects,
    layout: &place::Output,
    resolved: resolve::Output,
) -> Result<(resolve::Output, Option<Heap>), StageError> {
    let Some(inputs) = Inputs::new(objects, layout, &resolved) else { return Ok((resolved, None)) };
    let Output { resolved, heap } = objects.stages().run(STAGE, inputs, run).await?;
    Ok((resolved, Some(heap)))
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let bodies = &inputs.resolved.bodies;
    let loaded = bodies.iter().map(|body| load(&context, &body.name, &body.mesh, &body.hulls));
    let loaded: Vec<Loaded> = futures::future::try_join_all(loaded).await?;
    let (given, cancel) = (inputs.clone(), context.cancel().clone());
    let output = context.cpu(move || dropped(&given, &loaded, &cancel)).await??;
    context.put_json("poses.json", &output).await?;
    Ok(output)
}

fn dropped(inputs: &Inputs, loaded: &[Loaded], cancel: &CancelFlag) -> Result<Output, StageError> {
    let bodies: Vec<Body> = inputs
        .resolved
        .bodies
        .iter()
        .zip(loaded)
        .enumerate()
        .map(|(index, (part, geometry))| body(&part.name, geometry, part.settled, &part.physical, index == 0))
        .collect();
    let solids: Vec<&MeshSolid> = loaded.iter().map(|geometry| &*geometry.solid).collect();
    let problem = ClutterProblem {
        bodies: &bodies,
        solids: &solids,
        roles: &inputs.roles,
        outline: &inputs.outline_m,
        density: inputs.clutter.density,
        seed: inputs.seed,
    };
    let settings =
        ClutterSettings { settle: &inputs.settle, resolve: &inputs.resolve, certify: &inputs.certify };
    let layout = drop_clutter(problem, settings, cancel)?;
    finished(inputs, bodies, layout)
}

/// The scene with the poses and supports after the drop.
fn finished(inputs: &Inputs, mut bodies: Vec<Body>, layout: DroppedLayout) -> Result<Output, StageError> {
    let is_dropped: Vec<bool> =
        std::iter::once(false).chain(inputs.roles.iter().map(|role| *role != DropRole::Kept)).collect();
    let containers: Vec<bool> = std::iter::once(false).chain(inputs.containers.iter().copied()).collect();
    bodies.iter_mut().zip(&layout.poses).for_each(|(body, pose)| body.world_from_object = *pose);
    let mut resolved = inputs.resolved.clone();
    let gap_m = inputs.certify.contact_gap_m;
    resolved.supports = supporters(&bodies, &resolved.supports, &is_dropped, &containers, gap_m);
    let named = |body: &Body| {
        InstanceId::new(&body.name).map_err(|error| StageError::permanent("invalid_name", error.to_string()))
    };
    let mut heap = Heap { density: inputs.clutter.density, dropped: Vec::new(), set_down: Vec::new() };
    for (index, part) in resolved.bodies.iter_mut().enumerate().skip(1) {
        part.settled = layout.poses[index];
        if is_dropped[index] {
            part.planned = layout.starts[index];
            heap.dropped.push(named(&bodies[index])?);
        }
        if layout.set_down.contains(&index) {
            heap.set_down.push(named(&bodies[index])?);
        }
        let moved = part.settled.translation_m - part.aligned.translation_m;
        part.displacement_m = moved.truncate().length();
        part.rotation_rad = angle_between_rad(&part.settled, &part.aligned);
    }
    let (count, drops) = (heap.dropped.len(), layout.drops);
    resolved.log.push(format!("{count} objects were dropped, with {drops} drops"));
    let upright = heap
        .set_down
        .iter()
        .map(|name| format!("{name} was set down upright, as it did not rest where it fell"));
    resolved.log.extend(upright.chain(layout.faults));
    Ok(Output { resolved, heap })
}

impl Heap {
    /// Whether the object of a name was dropped, or set down after that.
    pub fn has_dropped(&self, name: &str) -> bool {
        self.dropped.iter().any(|other| other.as_str() == name)
    }

    /// Keeps only the objects whose names are accepted.
    pub fn retain(&mut self, is_kept: impl Fn(&str) -> bool) {
        self.dropped.retain(|name| is_kept(name.as_str()));
        self.set_down.retain(|name| is_kept(name.as_str()));
    }

    /// Origin of the place of an object.
    pub fn placement(&self, name: &str) -> ClutterPlacement {
        let is_set_down = self.set_down.iter().any(|other| other.as_str() == name);
        match (is_set_down, self.has_dropped(name)) {
            (true, _) => ClutterPlacement::SetDown,
            (false, true) => ClutterPlacement::Dropped,
            (false, false) => ClutterPlacement::Kept,
        }
    }
}

impl From<ClutterError> for StageError {
    fn from(error: ClutterError) -> Self {
        match error {
            ClutterError::Cancelled(cancelled) => cancelled.into(),
            ClutterError::Settle(physics::SettleError::Cancelled(cancelled)) => cancelled.into(),
            error @ ClutterError::NoRegion => Self::permanent("no_room", error.to_string()),
            error => Self::permanent("not_dropped", error.to_string()),
        }
    }
}
