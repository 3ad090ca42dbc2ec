//! Stage 8, for each instance: its yaw, by the rotation optimizer.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, Settings, canonicalize, carry, reference, segment};
use crate::align::dro::{DroError, DroSettings, RotationEstimate, RotationProblem, estimate_yaw};
use crate::geometry::{Camera, Mask};
use crate::render::overlay::{Curve, plot_curves};
use crate::scene::{InstanceId, Recognition};

pub const STAGE: Stage = Stage { name: "rotate", version: 2 };

#[derive(Serialize)]
pub struct Inputs {
    mesh: ArtifactRef,
    picture: ArtifactRef,
    camera: Camera,
    visible: Mask,
    others: Mask,
    dro: DroSettings,
}

/// The yaw and how sure it is.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub yaw_rad: f64,
    pub loss: f64,
    /// 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// 0..1.
    pub confidence: f64,
}

/// `yaw.json`: the output with what it was chosen from.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    output: &'a Output,
    /// (yaw in radians, loss), refined, best first.
    candidates: &'a [(f64, f64)],
    /// (yaw in radians, loss) of the coarse search.
    curve: &'a [(f64, f64)],
}

/// One entry per recognized object, in order.
pub fn inputs(
    reference: &reference::Output,
    recognition: &Recognition,
    masks: &segment::Output,
    canonical: &[canonicalize::Output],
    settings: &Settings,
) -> Vec<(InstanceId, Inputs)> {
    recognition
        .objects
        .iter()
        .zip(canonical)
        .zip(&masks.masks)
        .zip(masks.others())
        .map(|(((object, canonical), mask), others)| {
            let inputs = Inputs {
                mesh: canonical.mesh.clone(),
                picture: reference.picture.clone(),
                camera: recognition.camera,
                visible: mask.visible.clone(),
                others,
                dro: settings.dro.clone(),
            };
            (object.id.clone(), inputs)
        })
        .collect()
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let mesh = carry::mesh(&context, &inputs.mesh).await?;
    let picture = carry::picture(&context, &inputs.picture).await?;
    let interrupt = context.interrupt().clone();
    let given = inputs.clone();
    let estimate = context
        .cpu(move || {
            let problem = RotationProblem {
                mesh: &mesh,
                camera: &given.camera,
                mask: &given.visible,
                unknown: &given.others,
                picture: Some(&picture),
            };
            estimate_yaw(&problem, &given.dro, &interrupt)
        })
        .await?;
    let name = context.instance().map_or_else(String::new, ToString::to_string);
    let estimate = estimate.map_err(|error| match error {
        DroError::Interrupted(interrupted) => interrupted.into(),
        other => StageError::permanent("no_yaw", format!("{name}: {other}")),
    })?;
    let output = Output {
        yaw_rad: estimate.yaw_rad,
        loss: estimate.loss,
        symmetry_order: estimate.symmetry_order,
        confidence: estimate.confidence,
    };
    let told = Told { output: &output, candidates: &estimate.top, curve: &estimate.curve };
    context.put_json("yaw.json", &told).await?;
    let drawn = context.cpu(move || curve_of(&name, &estimate)).await?;
    carry::put_picture(&context, "loss_curve.png", drawn).await?;
    Ok(output)
}

/// Loss over yaw in degrees, the chosen yaw marked.
fn curve_of(name: &str, estimate: &RotationEstimate) -> crate::geometry::Image {
    let degrees = |(yaw_rad, loss): (f64, f64)| (yaw_rad.to_degrees(), loss);
    let points: Vec<(f64, f64)> = estimate.curve.iter().copied().map(degrees).collect();
    let chosen = (estimate.yaw_rad.to_degrees().rem_euclid(360.0), estimate.loss);
    let title = format!(
        "{name}: {:.1} deg, loss {:.4}, symmetry {}, confidence {:.2}",
        estimate.yaw_rad.to_degrees(),
        estimate.loss,
        estimate.symmetry_order,
        estimate.confidence
    );
    let curve = Curve { points: &points, marks: &[chosen], color: [30, 90, 200, 255] };
    plot_curves(480, 240, &title, &[curve])
}
