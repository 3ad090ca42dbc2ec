//! The measurements of the certificate, and the verdict.

use rayon::prelude::*;

use super::Inputs;
use crate::geometry::collide::PlacedSolid;
use crate::geometry::{Interrupt, Pose};
use crate::physics::settle::SettleError;
use crate::physics::{Body, Collisions, Stability, SupportFinding, collisions, stability, support};
use crate::pipeline::error::StageError;
use crate::pipeline::resolve::{Loaded, body};
use crate::pipeline::rotate;
use crate::scene::InstanceId;
use crate::scene::certificate::{
    Appearance, Certificate, Collision, Fidelity, Metrics, ObjectCertificate, RotationFinding, Thresholds,
    Verdict,
};

/// How far a footprint may reach over the outline before the object counts as outside, meters.
const OUTLINE_TOLERANCE_M: f64 = 0.001;

/// What physics and geometry say of the scene; bodies in order, the table first.
pub(super) struct Measured {
    watertight: Vec<bool>,
    from_shipped: Stability,
    from_aligned: Stability,
    found: Collisions,
    /// Of the objects.
    supports: Vec<SupportFinding>,
}

/// Collisions, support, and stability from the shipped and from the aligned poses.
pub(super) fn measure(
    inputs: &Inputs,
    loaded: &[Loaded],
    interrupt: &Interrupt,
) -> Result<Measured, StageError> {
    let placed: Vec<PlacedSolid> = loaded
        .iter()
        .zip(&inputs.bodies)
        .map(|(geometry, body)| PlacedSolid {
            solid: &geometry.solid,
            world_from_object: body.resolved.settled,
        })
        .collect();
    let shipped = bodies(inputs, loaded, |body| body.resolved.settled);
    let aligned = bodies(inputs, loaded, |body| body.resolved.aligned);
    let ((from_shipped, from_aligned), (found, supports)) = rayon::join(
        || rayon::join(|| still(inputs, &shipped, interrupt), || still(inputs, &aligned, interrupt)),
        || {
            rayon::join(
                || collisions(&placed, &inputs.certify, interrupt),
                || supports(inputs, &placed, &shipped, interrupt),
            )
        },
    );
    Ok(Measured {
        watertight: loaded.iter().map(|geometry| geometry.solid.is_watertight()).collect(),
        from_shipped: from_shipped?,
        from_aligned: from_aligned?,
        found: found?,
        supports: supports?,
    })
}

/// The certificate; `silhouette_ious` are those of the objects, in order.
pub(super) fn certificate(
    inputs: &Inputs,
    loaded: &[Loaded],
    measured: &Measured,
    silhouette_ious: &[f64],
    appearance: Appearance,
) -> Result<Certificate, StageError> {
    let Measured { watertight, from_shipped, from_aligned, found, supports } = measured;
    let supported = supports.iter().filter(|finding| finding.is_supported()).count();
    let metrics = Metrics {
        col_o: found.col_o(),
        col_s: found.col_s(),
        ss: if supports.is_empty() { 1.0 } else { supported as f64 / supports.len() as f64 },
        dss_aligned: from_aligned.dss,
        dss_shipped: from_shipped.dss,
    };
    let name_of = |index: usize| inputs.bodies[index].resolved.name.clone();
    let collisions: Vec<Collision> = found
        .colliding
        .iter()
        .map(|pair| Collision { a: name_of(pair.a), b: name_of(pair.b), depth_m: pair.depth_m })
        .collect();
    let mut objects = Vec::with_capacity(supports.len());
    for (index, finding) in supports.iter().enumerate() {
        let (body, geometry) = (&inputs.bodies[index + 1], &loaded[index + 1]);
        let movement = from_shipped.movements[index + 1];
        let name = InstanceId::new(&body.resolved.name)
            .map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
        objects.push(ObjectCertificate {
            name,
            support_margin_m: finding.margin_m.is_finite().then_some(finding.margin_m),
            settle_displacement_m: movement.displacement_m,
            settle_rotation_rad: movement.rotation_rad,
            displacement_from_aligned_m: (body.resolved.settled.translation_m
                - body.resolved.aligned.translation_m)
                .length(),
            rotation_from_aligned_rad: body.resolved.rotation_rad,
            inside_outline: is_inside(inputs, geometry, &body.resolved.settled),
            watertight: watertight[index + 1],
            hulls: u32::try_from(geometry.hulls.len()).unwrap_or(u32::MAX),
            hull_excess_m: body.hull_excess_m,
            silhouette_iou: silhouette_ious[index],
            rotation: rotation_finding(&inputs.yaws[index]),
        });
    }
    let mean = silhouette_ious.iter().sum::<f64>() / silhouette_ious.len().max(1) as f64;
    let fidelity = Fidelity { silhouette_iou: mean, appearance };
    let reasons = reasons(inputs, &collisions, supports, from_shipped, &objects, &fidelity);
    Ok(Certificate {
        verdict: if reasons.is_empty() { Verdict::Pass } else { Verdict::Quarantine },
        reasons,
        metrics,
        fidelity,
        thresholds: Thresholds {
            penetration_m: inputs.certify.penetration_m,
            contact_gap_m: inputs.certify.contact_gap_m,
            support_dilation_m: inputs.certify.support_dilation_m,
            dss_displacement_m: inputs.certify.dss_displacement_m,
            dss_rotation_rad: inputs.certify.dss_rotation_rad,
            dss_duration_s: inputs.certify.dss_duration_s,
            silhouette_iou: inputs.fidelity.least_silhouette_iou,
        },
        objects,
        scale_error: inputs.scale_error,
        collisions,
    })
}

fn rotation_finding(yaw: &rotate::Output) -> RotationFinding {
    RotationFinding {
        yaw_rad: yaw.yaw_rad,
        representative_yaw_rad: yaw.representative_yaw_rad,
        symmetry_order: yaw.symmetry_order,
        shape_symmetry_order: yaw.shape_symmetry.order,
        symmetry_axis_m: yaw.shape_symmetry.axis_m.to_array(),
        confidence: yaw.confidence,
        candidates: yaw.candidates.clone(),
    }
}

fn bodies(inputs: &Inputs, loaded: &[Loaded], pose: impl Fn(&super::BodyParts) -> Pose) -> Vec<Body> {
    inputs
        .bodies
        .iter()
        .zip(loaded)
        .map(|(parts, geometry)| {
            let (name, physical) = (&parts.resolved.name, &parts.resolved.physical);
            body(name, geometry, pose(parts), physical, parts.support.is_none())
        })
        .collect()
}

/// DSS; a scene that explodes when gravity starts has nothing that stays.
fn still(inputs: &Inputs, bodies: &[Body], interrupt: &Interrupt) -> Result<Stability, StageError> {
    use crate::physics::metrics::Movement;
    match stability(bodies, &inputs.certify, &inputs.settle, interrupt) {
        Ok(found) => Ok(found),
        Err(SettleError::Interrupted(interrupted)) => Err(interrupted.into()),
        Err(SettleError::Diverged { .. }) => {
            let lost =
                Movement { displacement_m: f64::MAX, rotation_rad: std::f64::consts::PI, stable: false };
            Ok(Stability { movements: vec![lost; bodies.len()], dss: 0.0 })
        }
        Err(other) => Err(StageError::permanent("not_simulated", other.to_string())),
    }
}

fn supports(
    inputs: &Inputs,
    placed: &[PlacedSolid],
    bodies: &[Body],
    interrupt: &Interrupt,
) -> Result<Vec<SupportFinding>, StageError> {
    (1..placed.len())
        .into_par_iter()
        .map(|index| {
            let carriers = carriers(inputs, index);
            Ok(support(placed, bodies, index, &carriers, &inputs.certify, interrupt)?)
        })
        .collect()
}

/// What an object stands on or in, and what lies in the same container.
fn carriers(inputs: &Inputs, index: usize) -> Vec<usize> {
    let Some(support) = inputs.bodies[index].support else { return Vec::new() };
    let shares = |other: usize| support.1 && other != index && inputs.bodies[other].support == Some(support);
    (0..inputs.bodies.len()).filter(|&other| other == support.0 || shares(other)).collect()
}

fn is_inside(inputs: &Inputs, geometry: &Loaded, world_from_object: &Pose) -> bool {
    let mut points = geometry.hulls.iter().flat_map(|hull| &hull.points);
    points.all(|point| {
        let xy_m = world_from_object.transform_point(*point).truncate();
        inputs.outline().depth_inside_m(xy_m) >= -OUTLINE_TOLERANCE_M
    })
}

/// One sentence per failed check.
fn reasons(
    inputs: &Inputs,
    collisions: &[Collision],
    supports: &[SupportFinding],
    shipped: &Stability,
    objects: &[ObjectCertificate],
    fidelity: &Fidelity,
) -> Vec<String> {
    let mut reasons = Vec::new();
    for c in collisions {
        reasons.push(format!("{} and {} collide, {:.1} mm deep", c.a, c.b, 1e3 * c.depth_m));
    }
    for (object, finding) in objects.iter().zip(supports) {
        if !finding.is_supported() {
            let how = match object.support_margin_m {
                Some(margin_m) => format!("its center of mass lies {:.1} mm outside", -1e3 * margin_m),
                None => "it touches nothing".into(),
            };
            reasons.push(format!("{} is not supported: {how}", object.name));
        }
    }
    for (object, movement) in objects.iter().zip(&shipped.movements[1..]) {
        if !movement.stable {
            let (mm, degrees) = (1e3 * movement.displacement_m, movement.rotation_rad.to_degrees());
            reasons.push(format!("{} moves {mm:.0} mm and turns {degrees:.0} degrees", object.name));
        }
    }
    for object in objects.iter().filter(|object| !object.inside_outline) {
        reasons.push(format!("{} reaches over the table's edge", object.name));
    }
    for object in objects.iter().filter(|object| !object.watertight) {
        reasons.push(format!("the mesh of {} is not watertight", object.name));
    }
    let least = inputs.fidelity.least_silhouette_iou;
    if fidelity.silhouette_iou < least {
        reasons.push(format!(
            "the scene does not look like the picture: mean silhouette IoU {:.2}, at least {least:.2} is asked",
            fidelity.silhouette_iou
        ));
    }
    reasons
}
