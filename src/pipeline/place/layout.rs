//! From boxes to poses: scale, places, and heights by letting each object down onto what carries it.

use glam::{DVec2, DVec3};

use super::{Inputs, Output, PlacedInstance, PlacedTable};
use crate::pipeline::checkpoint::ArtifactRef;
use crate::pipeline::error::StageError;
use crate::pipeline::{Context, artifact_io};
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::{PosedShape, drop_height};
use geometry::{ConvexHull, Outline, Pose, TexturedMesh};
use ports::TopBoxes;
use pose_estimation::contained;
use pose_estimation::contained::ContainedObject;
use pose_estimation::top_view_layout::{
    BoxFromAbove, TopViewInstance, TopViewProblem, align_top_view, footprint,
};

/// Yaws surer than this may set the scene's scale.
const ANCHOR_CONFIDENCE: f64 = 0.05;

/// The layout of the boxes, with meshes and hulls at their final size.
pub(super) async fn lay_out(
    context: &Context,
    inputs: &Inputs,
    boxes: &TopBoxes,
    top_view: ArtifactRef,
) -> Result<Output, StageError> {
    let mut footprints = Vec::with_capacity(inputs.instances.len());
    for instance in &inputs.instances {
        let mesh = artifact_io::mesh(context, &instance.mesh).await?;
        let yaw_rad = instance.yaw_rad;
        footprints.push(context.cpu(move || footprint(&mesh, yaw_rad)).await?);
    }
    let instances = inputs
        .instances
        .iter()
        .zip(&boxes.objects)
        .zip(&footprints)
        .enumerate()
        .map(|(index, ((instance, found), &footprint))| TopViewInstance {
            box_px: found.box_px,
            footprint,
            // What leans in a container shows another footprint than its upright mesh.
            may_anchor: instance.confidence >= ANCHOR_CONFIDENCE
                && !inputs.supports.supporter(index).is_container(),
            seen_m: instance.seen_m.map(|origin_m| origin_m + 0.5 * (footprint.low_m + footprint.high_m)),
        })
        .collect();
    let problem = TopViewProblem {
        table_box_px: boxes.table_px,
        table_size_m: inputs.table.size_m.truncate(),
        instances,
        meters_per_px: given_scale(inputs, boxes)?,
    };
    let found = align_top_view(&problem, &inputs.tsa)
        .map_err(|error| StageError::permanent("no_layout", error.to_string()))?;
    let table = place_table(context, inputs, found.table_rescaled.then_some(found.table_size_m)).await?;

    let mut placed = Vec::with_capacity(inputs.instances.len());
    for (index, ((instance, layout), &rma_score)) in
        inputs.instances.iter().zip(&found.instances).zip(&found.rma_scores).enumerate()
    {
        let leans = inputs.supports.supporter(index).is_container();
        // Of what carries others little is visible. In a rendered image its size is known, so that a box that differs
        // says that the yaw is wrong.
        let carries = inputs.supports.children(Some(index)).next().is_some();
        let scale = if leans || (carries && inputs.knows_sizes()) { 1.0 } else { layout.scale };
        let (mesh, hulls) = resized(
            context,
            &instance.mesh,
            &instance.hulls,
            DVec3::splat(scale),
            instance.object.id.as_str(),
        )
        .await?;
        placed.push(PlacedInstance {
            id: instance.object.id.clone(),
            mesh,
            hulls,
            size_m: scale * instance.size_m,
            scale,
            world_from_object: Pose::upright(layout.xy_m.extend(0.0), instance.yaw_rad),
            seen_from_above: layout.seen,
            rma_score,
        });
    }
    let anchor = found.anchor.map(|index| inputs.instances[index].object.id.clone());
    let mut output = Output {
        alpha_m_per_px: found.alpha_m_per_px,
        anchor,
        consensus: found.consensus,
        registered: found.registered,
        table,
        instances: placed,
        supports: inputs.supports.clone(),
        top_view,
    };
    let_down(context, &mut output).await?;
    Ok(output)
}

/// The scale that the request's known length gives, if it names one.
fn given_scale(inputs: &Inputs, boxes: &TopBoxes) -> Result<Option<f64>, StageError> {
    let Some(anchor) = &inputs.metric_anchor else { return Ok(None) };
    if anchor.object == "table" {
        let width_px = boxes.table_px[2] - boxes.table_px[0];
        return Ok(Some(anchor.width_m / width_px.max(1e-9)));
    }
    let named = |name: &str, label: &str| name == anchor.object || label.eq_ignore_ascii_case(&anchor.object);
    let at = inputs
        .instances
        .iter()
        .position(|instance| named(instance.object.id.as_str(), &instance.object.label))
        .ok_or_else(|| {
            let names: Vec<&str> = inputs.instances.iter().map(|i| i.object.label.as_str()).collect();
            StageError::permanent(
                "metric_anchor_unknown",
                format!(
                    "the metric anchor {:?} is none of the objects: name one of {}, or `table`",
                    anchor.object,
                    names.join(", ")
                ),
            )
        })?;
    let (instance, found) = (&inputs.instances[at], &boxes.objects[at]);
    // The box's sides are the turned footprint's; its area scales with the square of the known length.
    let (sin, cos) = instance.yaw_rad.sin_cos();
    let (w, d) = (instance.size_m.x, instance.size_m.y);
    let turned = DVec2::new(w * cos.abs() + d * sin.abs(), w * sin.abs() + d * cos.abs());
    let area_px = (found.box_px[2] - found.box_px[0]) * (found.box_px[3] - found.box_px[1]);
    let factor = anchor.width_m / instance.size_m.x.max(1e-9);
    Ok(Some(factor * (turned.x * turned.y / area_px.max(1e-9)).sqrt()))
}

/// The table, stretched in the plane where the top view overruled its size.
async fn place_table(
    context: &Context,
    inputs: &Inputs,
    measured_m: Option<DVec2>,
) -> Result<PlacedTable, StageError> {
    let table = &inputs.table;
    let stretch = measured_m.map_or(DVec2::ONE, |size| size / table.size_m.truncate());
    let (mesh, hulls) = resized(context, &table.mesh, &table.hulls, stretch.extend(1.0), "table").await?;
    let corners = table.outline_m.corners().iter().map(|corner| *corner * stretch).collect();
    let outline_m = Outline::new(corners).map_err(|error| {
        StageError::permanent("table_outline", format!("placing the table: {error}; give its size"))
    })?;
    let size_m = table.size_m * stretch.extend(1.0);
    Ok(PlacedTable { mesh, hulls, outline_m, size_m, rescaled: measured_m.is_some() })
}

/// Mesh and hulls scaled about the object's origin; the same artifacts where the scale is 1.
pub async fn resized(
    context: &Context,
    mesh: &ArtifactRef,
    hulls: &ArtifactRef,
    scale: DVec3,
    name: &str,
) -> Result<(ArtifactRef, ArtifactRef), StageError> {
    if scale == DVec3::ONE {
        return Ok((mesh.clone(), hulls.clone()));
    }
    let original = artifact_io::mesh(context, mesh).await?;
    let larger: TexturedMesh = context.cpu(move || (*original).clone().scaled(scale)).await?;
    let mut parts: Vec<ConvexHull> = artifact_io::hulls(context, hulls).await?;
    parts.iter_mut().flat_map(|hull| &mut hull.points).for_each(|point| *point *= scale);
    let mesh = artifact_io::put_mesh(context, &format!("resized/{name}.glb"), larger).await?;
    let hulls = context.put_json(&format!("resized/{name}_hulls.json"), &parts).await?;
    Ok((mesh, hulls))
}

/// `t_z`: supporters first, each object straight down onto what carries it; how objects lie in a container their boxes
/// tell.
pub async fn let_down(context: &Context, output: &mut Output) -> Result<(), StageError> {
    let broken = |what: &str, error: String| {
        StageError::permanent("no_collision_geometry", format!("placing {what}: {error}"))
    };
    let table_hulls = artifact_io::hulls(context, &output.table.hulls).await?;
    let table = CollisionShape::new(&table_hulls).map_err(|e| broken("the table", e.to_string()))?;
    let mut shapes = Vec::with_capacity(output.instances.len());
    for instance in &output.instances {
        let hulls = artifact_io::hulls(context, &instance.hulls).await?;
        let shape = CollisionShape::new(&hulls).map_err(|e| broken(instance.id.as_str(), e.to_string()))?;
        shapes.push(shape);
    }
    let supports = output.supports.clone();
    let seen: Vec<BoxFromAbove> = output.instances.iter().map(|i| i.seen_from_above).collect();
    let mut poses: Vec<Pose> = output.instances.iter().map(|i| i.world_from_object).collect();
    let poses = context
        .cpu(move || {
            let mut is_down = vec![false; poses.len()];
            let mut is_container_checked = vec![false; poses.len()];
            for &index in supports.order() {
                let supporter = supports.supporter(index);
                let below = match supporter.parent {
                    Some(parent) => PosedShape { shape: &shapes[parent], world_from_object: poses[parent] },
                    None => PosedShape { shape: &table, world_from_object: Pose::IDENTITY },
                };
                let container = supporter.parent.filter(|_| supporter.is_container());
                let is_unchecked =
                    |container: usize| !std::mem::replace(&mut is_container_checked[container], true);
                if container.is_some_and(is_unchecked) {
                    let together: Vec<usize> = supports.supported_by(supporter).collect();
                    let objects: Vec<ContainedObject> = together
                        .iter()
                        .map(|&k| ContainedObject {
                            shape: &shapes[k],
                            upright: poses[k].rotation,
                            seen: seen[k],
                        })
                        .collect();
                    for (&k, pose) in together.iter().zip(contained::lie(&objects, below)) {
                        is_down[k] = pose.is_some();
                        poses[k] = pose.unwrap_or(poses[k]);
                    }
                }
                if !is_down[index] {
                    let (xy_m, rotation) = (poses[index].translation_m.truncate(), poses[index].rotation);
                    // Beside its supporter (a box misread by a few pixels) it is left at the table's height;
                    // resolving moves it back.
                    let z_m = drop_height(&shapes[index], rotation, xy_m, &[below]).unwrap_or(0.0);
                    poses[index].translation_m.z = z_m;
                }
            }
            poses
        })
        .await?;
    for (instance, pose) in output.instances.iter_mut().zip(poses) {
        instance.world_from_object = pose;
    }
    Ok(())
}
