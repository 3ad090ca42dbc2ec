//! Stage `rotate`, for each instance: its yaw, by the rotation optimizer.

use std::sync::Arc;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, Settings, artifact_io, canonicalize, reference, segment};
use geometry::Camera;
use geometry::rotational_symmetry::RotationalSymmetry;
use imaging::Mask;
use pose_estimation::beside::beside;
use pose_estimation::yaw::{YawError, YawEstimate, YawProblem, YawSettings, estimate_yaw, support_height_m};
use render::annotate::{Curve, plot_curves};
use scene::{InstanceId, InstanceMask, Recognition, SupportTree};

pub const STAGE: Stage = Stage { name: "rotate", version: 9 };

#[derive(Serialize)]
pub struct Inputs {
    mesh: ArtifactRef,
    image: ArtifactRef,
    camera: Camera,
    visible: Mask,
    /// Pixels of the instances that may hide it.
    hiders: Mask,
    /// Meshes of everything below it, nearest first.
    below: Vec<ArtifactRef>,
    /// Yaw that the text states, of an object that the image generator names.
    #[serde(skip_serializing_if = "Option::is_none")]
    stated_yaw_rad: Option<f64>,
    dro: YawSettings,
}

/// The yaw and how sure it is.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub yaw_rad: f64,
    /// The yaw that is canonical for the symmetry: another pose with the same appearance, within half a period of 0.
    pub representative_yaw_rad: f64,
    /// Origin of the object as the camera of the reference image sees it, world, meters; `None` where it cannot be
    /// measured.
    pub seen_m: Option<DVec2>,
    pub loss: f64,
    /// 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Of the shape alone, with its axis in the object's frame.
    pub shape_symmetry: RotationalSymmetry,
    /// 0..1.
    pub confidence: f64,
    /// (yaw in radians, loss), refined, best first.
    pub candidates: Vec<(f64, f64)>,
}

/// `yaw.json`: the output with what it was chosen from.
#[derive(Serialize)]
struct Message<'a> {
    #[serde(flatten)]
    output: &'a Output,
    /// (yaw in radians, loss) of the coarse search.
    curve: &'a [(f64, f64)],
}

/// One entry per recognized object, in order.
pub fn inputs(
    reference: &reference::Output,
    recognition: &Recognition,
    supports: &SupportTree,
    masks: &segment::Output,
    canonical_meshes: &[canonicalize::Output],
    settings: &Settings,
) -> Vec<(InstanceId, Inputs)> {
    let instances_at = instances_at(&masks.masks);
    recognition
        .objects
        .iter()
        .zip(canonical_meshes)
        .zip(&masks.masks)
        .enumerate()
        .map(|(index, ((object, canonical), mask))| {
            let inputs = Inputs {
                mesh: canonical.mesh.clone(),
                image: reference.image.clone(),
                camera: recognition.camera,
                visible: mask.visible.clone(),
                hiders: hiders(&masks.masks, &instances_at, index, supports),
                below: supports.ancestors(index).map(|below| canonical_meshes[below].mesh.clone()).collect(),
                stated_yaw_rad: reference.stated_yaw_rad(&object.id),
                dro: settings.dro.clone(),
            };
            (object.id.clone(), inputs)
        })
        .collect()
}

/// Number of instances that each pixel belongs to.
pub(in crate::pipeline) fn instances_at(masks: &[InstanceMask]) -> Vec<u16> {
    let pixels = masks.first().map_or(0, |first| first.visible.bits().len());
    let mut counts = vec![0; pixels];
    for mask in masks {
        counts.iter_mut().zip(mask.visible.bits()).for_each(|(count, bit)| *count += u16::from(*bit));
    }
    counts
}

/// Pixels of instances other than the one at `index`, less those it stands on: what is below is not in front. A
/// container is both.
pub(in crate::pipeline) fn hiders(
    masks: &[InstanceMask],
    instances_at: &[u16],
    index: usize,
    supports: &SupportTree,
) -> Mask {
    let Some(first) = masks.first() else { return Mask::empty(0, 0) };
    let mut others = instances_at.to_vec();
    for counted in std::iter::once(index).chain(supports.ancestors_on(index)) {
        let mask = &masks[counted].visible;
        others.iter_mut().zip(mask.bits()).for_each(|(count, bit)| *count -= u16::from(*bit));
    }
    let hidden = others.into_iter().map(|count| count > 0).collect();
    Mask::from_bits(first.visible.width_px(), first.visible.height_px(), hidden)
}

impl Inputs {
    /// Grows with the time it takes.
    pub fn effort(&self) -> u64 {
        self.mesh.size
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let mesh = artifact_io::mesh(&context, &inputs.mesh).await?;
    let image = artifact_io::image(&context, &inputs.image).await?;
    let mut below = Vec::with_capacity(inputs.below.len());
    for supporter in &inputs.below {
        below.push(artifact_io::mesh(&context, supporter).await?);
    }
    let cancel = context.cancel().clone();
    let given = inputs.clone();
    let estimate = context
        .cpu(move || {
            let problem = YawProblem {
                mesh: &mesh,
                camera: &given.camera,
                mask: &given.visible,
                unknown: &given.hiders,
                support_height_m: support_height_m(below.iter().map(AsRef::as_ref)),
                image: Some(&image),
                stated_yaw_rad: given.stated_yaw_rad,
            };
            let estimate = estimate_yaw(&problem, &given.dro, &cancel)?;
            let sheet = beside(&problem, &estimate, &given.dro);
            Ok((estimate, sheet))
        })
        .await?;
    let name = context.instance().map_or_else(String::new, ToString::to_string);
    let (estimate, sheet) = estimate.map_err(|error| match error {
        YawError::Cancelled(cancelled) => cancelled.into(),
        other => StageError::permanent("no_yaw", format!("{name}: {other}")),
    })?;
    let output = Output {
        yaw_rad: estimate.yaw_rad,
        representative_yaw_rad: estimate.representative_yaw_rad,
        seen_m: estimate.seen_m,
        loss: estimate.loss,
        symmetry_order: estimate.symmetry_order,
        shape_symmetry: estimate.shape_symmetry,
        confidence: estimate.confidence,
        candidates: estimate.top.clone(),
    };
    let message = Message { output: &output, curve: &estimate.curve };
    context.put_json("yaw.json", &message).await?;
    let drawn = context.cpu(move || curve_of(&name, &estimate)).await?;
    artifact_io::put_image(&context, "loss_curve.png", drawn).await?;
    if let Some(sheet) = sheet {
        artifact_io::put_image(&context, "beside.png", sheet).await?;
    }
    Ok(output)
}

/// Loss over yaw in degrees, the chosen yaw marked.
fn curve_of(name: &str, estimate: &YawEstimate) -> imaging::Image {
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

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Supporter;

    #[test]
    fn what_it_stands_on_does_not_hide_it_and_a_container_may() {
        let mask = |name: &str, column: u32| InstanceMask {
            id: InstanceId::new(name).expect("a name"),
            visible: Mask::from_fn(4, 1, |x, _| x == column),
        };
        let masks = [mask("mug_1", 0), mask("coaster_1", 1), mask("tray_1", 2), mask("vase_1", 3)];
        let supporters = vec![Supporter::on(1), Supporter::containing(2), Supporter::TABLE, Supporter::TABLE];
        let supports = SupportTree::new(supporters).expect("a tree");
        let hidden = hiders(&masks, &instances_at(&masks), 0, &supports);
        assert_eq!(hidden.bits(), [false, false, true, true]);
    }
}
