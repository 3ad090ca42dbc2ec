//! The measurements of the certificate, and the verdict.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::track::Tracks;
use super::{FidelitySettings, Inputs, plausibility};
use crate::pipeline::composition::BodyParts;
use crate::pipeline::error::StageError;
use crate::pipeline::resolve::{Loaded, body};
use crate::pipeline::rotate;
use certificate::{
    Appearance, BodyHealth, Certificate, Collision, Displacement, Displacements, Fidelity, MethodShare,
    ObjectCertificate, Reason, ReasonCode, Region, Regions, RotationFinding, Thresholds, Verdict,
};
use export::body::{Contact, check_solid};
use geometry::Pose;
use geometry::collide::PlacedSolid;
use physics::metrics::Movement;
use physics::settle::{SettleError, angle_between_rad};
use physics::{Body, Collisions, Stability, SupportFinding, carriers, collisions, stability, support};
use runtime::CancelFlag;
use scene::{Input, InstanceId, Metrics, ReconstructionMethod};
use vision::image_similarity::{MismatchRegion, MismatchRegions, SceneSimilarity};

/// Maximum distance that a footprint may reach over the outline before the object counts as outside, meters.
const OUTLINE_TOLERANCE_M: f64 = 0.001;

/// Displacement above which a body has left the world, or the simulation has exploded, meters.
const LOST_M: f64 = 100.0;

/// Results of physics and geometry; bodies in order, the table first.
pub(super) struct Measured {
    health: Vec<BodyHealth>,
    from_shipped: Stability,
    /// Absent where the shipped poses are the aligned ones.
    from_aligned: Option<Stability>,
    found: Collisions,
    /// Of the objects.
    supports: Vec<SupportFinding>,
}

impl Measured {
    /// Tracks of the bodies in the simulations from the shipped and from the aligned poses.
    pub(super) fn tracks<'a>(&self, inputs: &'a Inputs) -> Tracks<'a> {
        let names: Vec<&str> =
            inputs.composition.bodies.iter().map(|body| body.resolved.name.as_str()).collect();
        let from_aligned = self.from_aligned.as_ref();
        Tracks::new(&names, inputs.certify.dss_duration_s, &self.from_shipped, from_aligned)
    }
}

/// No simulation can tell anything of a body that cannot be.
fn check_bodies(inputs: &Inputs, loaded: &[Loaded]) -> Result<(), StageError> {
    for (geometry, body) in loaded.iter().zip(&inputs.composition.bodies) {
        let physical = &body.resolved.physical;
        plausibility::check_size(&body.resolved.name, &geometry.mesh, &inputs.health)?;
        let contact = Contact {
            friction: physical.friction,
            restitution: physical.restitution,
            rolling_friction_m: physical.rolling_friction_m,
            torsional_friction_m: physical.torsional_friction_m,
        };
        check_solid(&geometry.mesh, &geometry.hulls, &physical.mass).and_then(|()| contact.check()).map_err(
            |fault| {
                StageError::permanent(fault.code(), format!("certifying {}: {fault}", body.resolved.name))
            },
        )?;
    }
    Ok(())
}

/// Collisions, support, and stability from the shipped and from the aligned poses.
pub(super) fn measure(
    inputs: &Inputs,
    loaded: &[Loaded],
    cancel: &CancelFlag,
) -> Result<Measured, StageError> {
    check_bodies(inputs, loaded)?;
    let placed: Vec<PlacedSolid> = loaded
        .iter()
        .zip(&inputs.composition.bodies)
        .map(|(geometry, body)| PlacedSolid {
            solid: &geometry.solid,
            world_from_object: body.resolved.settled,
        })
        .collect();
    let shipped = bodies(inputs, loaded, |body| body.resolved.settled);
    let aligned = bodies(inputs, loaded, |body| body.resolved.aligned);
    // An edited scene has no poses but those that it ships.
    let same = shipped.iter().zip(&aligned).all(|(a, b)| a.world_from_object == b.world_from_object);
    let still_aligned = || if same { None } else { Some(still(inputs, &aligned, cancel)) };
    let ((from_shipped, from_aligned), (found, supports)) = rayon::join(
        || rayon::join(|| still(inputs, &shipped, cancel), still_aligned),
        || {
            rayon::join(
                || collisions(&placed, &inputs.certify, cancel),
                || supports(inputs, &placed, &shipped, cancel),
            )
        },
    );
    let from_shipped = from_shipped?;
    Ok(Measured {
        health: plausibility::health(inputs, loaded),
        from_aligned: from_aligned.transpose()?,
        from_shipped,
        found: found?,
        supports: supports?,
    })
}

/// The certificate.
pub(super) fn certificate(
    inputs: &Inputs,
    loaded: &[Loaded],
    measured: &Measured,
    likeness: &SceneSimilarity,
    appearance: Appearance,
) -> Result<Certificate, StageError> {
    let Measured { health, from_shipped, from_aligned, found, supports } = measured;
    let from_aligned = from_aligned.as_ref().unwrap_or(from_shipped);
    let supported = supports.iter().filter(|finding| finding.is_supported()).count();
    let metrics = Metrics {
        col_o: found.col_o(),
        col_s: found.col_s(),
        ss: if supports.is_empty() { 1.0 } else { supported as f64 / supports.len() as f64 },
        dss_aligned: from_aligned.dss,
        dss_shipped: from_shipped.dss,
    };
    let name_of = |index: usize| inputs.composition.bodies[index].resolved.name.clone();
    let collisions: Vec<Collision> = found
        .colliding
        .iter()
        .map(|pair| Collision { a: name_of(pair.a), b: name_of(pair.b), depth_m: pair.depth_m })
        .collect();
    let mut objects = Vec::with_capacity(supports.len());
    for (index, finding) in supports.iter().enumerate() {
        let (body, geometry) = (&inputs.composition.bodies[index + 1], &loaded[index + 1]);
        let name = InstanceId::new(&body.resolved.name)
            .map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
        let poses = &body.resolved;
        let outline_margin_m = outline_margin_m(inputs, geometry, &poses.settled);
        objects.push(ObjectCertificate {
            name,
            support_margin_m: finding.margin_m.is_finite().then_some(finding.margin_m),
            moved: Displacements {
                by_resolve: displacement(&poses.aligned, &poses.planned),
                by_settling: displacement(&poses.planned, &poses.settled),
                from_aligned: displacement(&poses.aligned, &poses.settled),
                after_shipping: movement(&from_shipped.movements[index + 1]),
                after_aligning: movement(&from_aligned.movements[index + 1]),
            },
            rest_limit_m: from_shipped.movements[index + 1].limit_m,
            overlap_m: from_shipped.movements[index + 1].overlap_m,
            outline_margin_m,
            inside_outline: outline_margin_m >= -OUTLINE_TOLERANCE_M,
            silhouette_iou: likeness.objects[index].overlap,
            color_difference: likeness.objects[index].color_distance,
            method: inputs.composition.methods[index],
            rotation: rotation_finding(&inputs.composition.yaws[index]),
        });
    }
    let fidelity = fidelity(inputs, &objects, likeness, appearance)?;
    let mut reasons = reasons(inputs, &collisions, supports, from_shipped, &objects, &fidelity);
    for (found, body) in health.iter().zip(&inputs.composition.bodies) {
        reasons.extend(plausibility::reasons(found, &body.resolved.physical.friction, &inputs.health));
    }
    Ok(Certificate {
        verdict: if reasons.is_empty() { Verdict::Pass } else { Verdict::Quarantine },
        summary: summary(inputs, found.pairs, &reasons),
        reasons,
        pairs: found.pairs,
        metrics,
        fidelity,
        thresholds: Thresholds {
            penetration_m: inputs.certify.penetration_m,
            wall_share: inputs.certify.wall_share,
            contact_gap_m: inputs.certify.contact_gap_m,
            support_dilation_m: inputs.certify.support_dilation_m,
            dss_displacement_m: inputs.certify.dss_displacement_m,
            dss_rotation_rad: inputs.certify.dss_rotation_rad,
            dss_duration_s: inputs.certify.dss_duration_s,
            rest_side_share: inputs.certify.rest_side_share,
            rest_rotation_rad: inputs.certify.rest_rotation_rad,
            outline_m: OUTLINE_TOLERANCE_M,
            silhouette_iou: inputs.fidelity.min_silhouette_iou,
            missed_share: inputs.fidelity.max_missed_share,
            invented_share: inputs.fidelity.max_invented_share,
            health: inputs.health.thresholds(),
        },
        objects,
        bodies: health.clone(),
        scale_error: inputs.composition.scale_error,
        collisions,
        resolve: inputs.composition.resolve.clone(),
        // Filled in later by the rating model.
        appraisal: None,
        robot: None,
        clutter: None,
        made_with: inputs.identity.made_with.clone(),
    })
}

fn fidelity(
    inputs: &Inputs,
    objects: &[ObjectCertificate],
    likeness: &SceneSimilarity,
    appearance: Appearance,
) -> Result<Fidelity, StageError> {
    let table =
        InstanceId::new("table").map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
    let count = objects.len().max(1) as f64;
    let regions = |found: &MismatchRegions| {
        let region = |region: &MismatchRegion| Region {
            body: region.object.map_or(&table, |object| &objects[object].name).clone(),
            bbox_px: region.box_px,
            image_share: region.image_share,
        };
        Regions { share: found.share, largest: found.largest.iter().map(region).collect() }
    };
    let mut methods = BTreeMap::<ReconstructionMethod, usize>::new();
    inputs.composition.methods.iter().for_each(|method| *methods.entry(*method).or_default() += 1);
    Ok(Fidelity {
        is_judged: is_judged(inputs),
        left_out_px: inputs.composition.recognition.left_out_px.clone(),
        depth: inputs.composition.recognition.depth.clone(),
        silhouette_iou: objects.iter().map(|object| object.silhouette_iou).sum::<f64>() / count,
        color_difference: likeness.color_distance,
        missed: regions(&likeness.missed),
        invented: regions(&likeness.invented),
        methods: methods
            .into_iter()
            .map(|(method, objects)| MethodShare { method, objects, share: objects as f64 / count })
            .collect(),
        appearance,
    })
}

fn displacement(from: &Pose, to: &Pose) -> Displacement {
    Displacement {
        distance_m: (to.translation_m - from.translation_m).length(),
        angle_rad: angle_between_rad(from, to),
    }
}

fn movement(found: &Movement) -> Displacement {
    Displacement { distance_m: found.displacement_m, angle_rad: found.rotation_rad }
}

/// Reason of the verdict, in one sentence.
fn summary(inputs: &Inputs, pairs: usize, reasons: &[Reason]) -> String {
    let objects = inputs.composition.bodies.len().saturating_sub(1);
    let verdict = match reasons {
        [] if objects == 0 => "The table is sound, and nothing stands on it.".to_owned(),
        [] => format!(
            "{}: none of {pairs} pairs collides, everything is carried from below and stays where it is for {} s \
             of gravity, and every mesh is closed and covered by its hulls.",
            counted(objects, "object"),
            inputs.certify.dss_duration_s,
        ),
        [only] => format!("The scene must not be used: {}.", only.sentence),
        [first, rest @ ..] => {
            let more = counted(rest.len(), "more reason");
            format!("The scene must not be used: {}, and {more}.", first.sentence)
        }
    };
    let marked = inputs.composition.recognition.objects.iter().filter(|object| object.stand_in.is_some());
    match marked.count() {
        0 => verdict,
        1 => format!("{verdict} 1 of {} is a stand-in.", counted(objects, "object")),
        marked => format!("{verdict} {marked} of {} are stand-ins.", counted(objects, "object")),
    }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
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

fn bodies(inputs: &Inputs, loaded: &[Loaded], pose: impl Fn(&BodyParts) -> Pose) -> Vec<Body> {
    inputs
        .composition
        .bodies
        .iter()
        .zip(loaded)
        .enumerate()
        .map(|(index, (parts, geometry))| {
            let (name, physical) = (&parts.resolved.name, &parts.resolved.physical);
            body(name, geometry, pose(parts), physical, index == 0)
        })
        .collect()
}

/// DSS; a scene that explodes when gravity starts has nothing that stays.
fn still(inputs: &Inputs, bodies: &[Body], cancel: &CancelFlag) -> Result<Stability, StageError> {
    match stability(bodies, &inputs.certify, &inputs.settle, cancel) {
        Ok(found) => Ok(found),
        Err(SettleError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(SettleError::Diverged { .. }) => {
            let lost = Movement {
                displacement_m: f64::MAX,
                rotation_rad: std::f64::consts::PI,
                stable: false,
                overlap_m: 0.0,
                limit_m: 0.0,
                at_rest: false,
            };
            Ok(Stability { movements: vec![lost; bodies.len()], dss: 0.0, track: Vec::new() })
        }
        Err(other) => Err(StageError::permanent("not_simulated", other.to_string())),
    }
}

fn supports(
    inputs: &Inputs,
    placed: &[PlacedSolid],
    bodies: &[Body],
    cancel: &CancelFlag,
) -> Result<Vec<SupportFinding>, StageError> {
    let everything: Vec<usize> = (0..placed.len()).collect();
    (1..placed.len())
        .into_par_iter()
        .map(|index| {
            let heap = inputs.composition.clutter.as_ref();
            // What was dropped leans on whatever it touches, as contents of a container do.
            let carriers = match heap.is_some_and(|heap| heap.has_dropped(&bodies[index].name)) {
                true => everything.clone(),
                false => carriers(&inputs.composition.supports, index),
            };
            Ok(support(placed, bodies, index, &carriers, &inputs.certify, cancel)?)
        })
        .collect()
}

/// Depth of the hulls' farthest corner inside the table's outline; negative outside.
fn outline_margin_m(inputs: &Inputs, geometry: &Loaded, world_from_object: &Pose) -> f64 {
    let corners = geometry.hulls.iter().flat_map(|hull| &hull.points);
    let depth_m = |corner| {
        inputs.composition.outline().depth_inside_m(world_from_object.transform_point(corner).truncate())
    };
    corners.map(|corner| depth_m(*corner)).fold(f64::INFINITY, f64::min)
}

/// Describes the motion of an object that does not rest.
fn not_at_rest(inputs: &Inputs, name: &str, movement: &Movement) -> String {
    let limit_mm = 1e3 * movement.limit_m;
    let Movement { displacement_m, rotation_rad, overlap_m, .. } = *movement;
    let highest_rad = inputs.certify.rest_rotation_rad;
    if displacement_m < movement.limit_m && rotation_rad < highest_rad {
        let overlap_mm = 1e3 * overlap_m;
        return format!(
            "{name} overlaps another body by {overlap_mm:.1} mm under gravity, at most {limit_mm:.1} mm is asked"
        );
    }
    let way = if displacement_m > LOST_M {
        "is lost".to_owned()
    } else {
        format!("moves {:.1} mm", 1e3 * displacement_m)
    };
    format!(
        "{name} {way} and turns {:.1} degrees under gravity, less than {limit_mm:.1} mm and {:.0} degrees is asked",
        rotation_rad.to_degrees(),
        highest_rad.to_degrees()
    )
}

/// Checks of poses and likeness that failed.
fn reasons(
    inputs: &Inputs,
    collisions: &[Collision],
    supports: &[SupportFinding],
    shipped: &Stability,
    objects: &[ObjectCertificate],
    fidelity: &Fidelity,
) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let mut reason = |code, bodies: &[&str], sentence: String| {
        let bodies = bodies.iter().map(|&name| name.to_owned()).collect();
        reasons.push(Reason { code, bodies, sentence });
    };
    for c in collisions {
        let sentence = format!("{} and {} collide, {:.1} mm deep", c.a, c.b, 1e3 * c.depth_m);
        reason(ReasonCode::Collision, &[&c.a, &c.b], sentence);
    }
    for (object, finding) in objects.iter().zip(supports) {
        if !finding.is_supported() {
            let how = match object.support_margin_m {
                Some(margin_m) => format!("its center of mass lies {:.1} mm outside", -1e3 * margin_m),
                None => "it touches nothing".into(),
            };
            let sentence = format!("{} is not supported: {how}", object.name);
            reason(ReasonCode::NotSupported, &[object.name.as_str()], sentence);
        }
    }
    for (object, movement) in objects.iter().zip(&shipped.movements[1..]) {
        if !movement.at_rest {
            let sentence = not_at_rest(inputs, object.name.as_str(), movement);
            reason(ReasonCode::NotAtRest, &[object.name.as_str()], sentence);
        }
    }
    for object in objects.iter().filter(|object| !object.inside_outline) {
        let over_mm = -1e3 * object.outline_margin_m;
        let sentence = format!("{} reaches {over_mm:.0} mm over the table's edge", object.name);
        reason(ReasonCode::OverTheEdge, &[object.name.as_str()], sentence);
    }
    if fidelity.is_judged {
        for sentence in unlike(fidelity, &inputs.fidelity) {
            reason(ReasonCode::UnlikeImage, &[], sentence);
        }
    }
    reasons
}

/// Whether the likeness is part of the verdict: not where the program itself rendered the reference image, nor where
/// objects were dropped on purpose.
fn is_judged(inputs: &Inputs) -> bool {
    if inputs.composition.clutter.is_some() {
        return false;
    }
    match inputs.identity.request.input {
        Input::Image { .. } => true,
        // Without the demands of the text a model generated the image, and the scene is made from it.
        Input::Text { .. } => inputs.stated.is_none(),
        Input::Edit { .. } | Input::Variant { .. } => false,
    }
}

/// Each limit of the likeness that is exceeded, in a sentence.
fn unlike(fidelity: &Fidelity, limits: &FidelitySettings) -> Vec<String> {
    let FidelitySettings { min_silhouette_iou, max_missed_share, max_invented_share } = *limits;
    let mut sentences = Vec::new();
    if fidelity.silhouette_iou < min_silhouette_iou {
        sentences.push(format!(
            "the scene is unlike the image: mean silhouette IoU {:.2}, at least {min_silhouette_iou:.2} is required",
            fidelity.silhouette_iou
        ));
    }
    let shares = [
        (fidelity.missed.share, max_missed_share, "of the pixels of objects in the image are missed"),
        (
            fidelity.invented.share,
            max_invented_share,
            "of the pixels of objects in the scene are not in the image",
        ),
    ];
    for (share, limit, what) in shares {
        if share > limit {
            let (found, limit) = (100.0 * share, 100.0 * limit);
            sentences.push(format!(
                "the scene is unlike the image: {found:.0} % {what}, at most {limit:.0} % is allowed"
            ));
        }
    }
    sentences
}
