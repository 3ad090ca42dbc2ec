//! Frames of objects that do not stand upright.
//!
//! The stages before see an object that a text tips over as its image shows it: +z points up as it lies. The bundle
//! gives it the frame of the upright object, so that its pose states that it lies or stands upside down, and goals such
//! as `upright` or `upside_down` can be tested on its +z axis. Geometry in the world stays where it is. Meters.

use std::sync::Arc;

use glam::DQuat;

use super::Inputs;
use crate::pipeline::composition::{BodyParts, Composition};
use crate::pipeline::error::StageError;
use crate::pipeline::resolve::Loaded;
use geometry::Pose;
use geometry::solid_query::MeshSolid;

/// The bodies with their geometry, those of tipped objects in upright frames.
pub(super) fn in_upright_frames(
    inputs: Arc<Inputs>,
    mut loaded: Vec<Loaded>,
) -> Result<(Arc<Inputs>, Vec<Loaded>), StageError> {
    if inputs.composition.recognition.objects.iter().all(|object| object.tipped.is_none()) {
        return Ok((inputs, loaded));
    }
    let mut inputs = (*inputs).clone();
    turned_upright(&mut inputs.composition, &mut loaded)?;
    Ok((Arc::new(inputs), loaded))
}

/// Gives tipped objects their upright frames. For each body, how its frame was changed: `upright_from_tipped`.
pub(in crate::pipeline) fn turned_upright(
    composition: &mut Composition,
    loaded: &mut [Loaded],
) -> Result<Vec<Option<Pose>>, StageError> {
    let mut changes = vec![None; composition.bodies.len()];
    for (index, recognized) in composition.recognition.objects.iter().enumerate() {
        let Some(tipped) = &recognized.tipped else { continue };
        let (body, geometry) = (&mut composition.bodies[index + 1], &mut loaded[index + 1]);
        changes[index + 1] = Some(turn_upright(body, geometry, tipped.tipped_from_upright)?);
    }
    Ok(changes)
}

/// Returns `upright_from_tipped`.
fn turn_upright(
    body: &mut BodyParts,
    geometry: &mut Loaded,
    tipped_from_upright: DQuat,
) -> Result<Pose, StageError> {
    let rotation = tipped_from_upright.inverse();
    let turned = (*geometry.mesh).clone().rotated(rotation);
    let (low, high) = turned.bounds();
    let offset_m = -(0.5 * (low + high)).with_z(low.z);
    let upright_from_tipped = Pose { translation_m: offset_m, rotation };
    let tipped_from_upright = upright_from_tipped.inverse();
    let mesh = turned.translated(offset_m).snap_to_f32();
    let no_solid = |error: geometry::solid_query::SolidError| {
        StageError::permanent("no_solid", format!("{}: {error}", body.resolved.name))
    };
    geometry.solid = Arc::new(MeshSolid::new(&mesh).map_err(no_solid)?);
    geometry.mesh = Arc::new(mesh);
    let points = geometry.hulls.iter_mut().flat_map(|hull| &mut hull.points);
    points.for_each(|point| *point = upright_from_tipped.transform_point(*point));
    let resolved = &mut body.resolved;
    for pose in [&mut resolved.aligned, &mut resolved.planned, &mut resolved.settled] {
        *pose = *pose * tipped_from_upright;
    }
    let mass = &mut resolved.physical.mass;
    mass.center_of_mass_m = upright_from_tipped.transform_point(mass.center_of_mass_m);
    mass.principal_axes_xyzw = (rotation * mass.principal_axes_xyzw).normalize();
    Ok(upright_from_tipped)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::DVec3;

    use super::super::tests::{body, sound};
    use super::*;
    use geometry::shapes::block;
    use scene::{RequestedPose, TippedPose};

    fn corners(geometry: &Loaded, body: &BodyParts) -> Vec<DVec3> {
        let pose = body.resolved.settled;
        geometry.mesh.positions.iter().map(|p| pose.transform_point(*p)).collect()
    }

    /// Regression: the pose of a bottle lying on its side was that of an upright object, and the start of "stand the
    /// bottle up" had reached its goal.
    #[test]
    fn tipped_objects_get_the_frame_of_the_upright_object() {
        let mut planted = sound();
        // 0.16 m tall when upright; it lies with its top toward +x.
        let at = Pose::upright(DVec3::new(0.1, 0.2, 0.0), 0.4);
        let (parts, geometry) = body("cube_2", block(DVec3::new(0.16, 0.06, 0.05)), at);
        (planted.inputs.composition.bodies[2], planted.loaded[2]) = (parts, geometry);
        let mut recognition = (*planted.inputs.composition.recognition).clone();
        recognition.objects[1].tipped = Some(TippedPose {
            pose: RequestedPose::LyingOnSide,
            upright_size_m: DVec3::new(0.05, 0.06, 0.16),
            tipped_from_upright: DQuat::from_rotation_y(FRAC_PI_2),
        });
        planted.inputs.composition.recognition = Arc::new(recognition);
        let before = planted.inputs.clone();
        let corners_before = corners(&planted.loaded[2], &before.composition.bodies[2]);
        let (after, loaded) = in_upright_frames(Arc::new(planted.inputs), planted.loaded).expect("a solid");

        let (resolved, geometry) = (&after.composition.bodies[2].resolved, &loaded[2]);
        let size_m = geometry.mesh.size_m();
        assert!((size_m - DVec3::new(0.05, 0.06, 0.16)).abs().max_element() < 1e-6, "{size_m}");
        let top = resolved.settled.rotation * DVec3::Z;
        assert!(top.z.abs() < 1e-9 && (top.truncate().to_angle() - 0.4).abs() < 1e-9, "{top}");
        // Nothing moves in the world: mesh, hulls, center of mass and principal moments along its axes.
        for (a, b) in corners(geometry, &after.composition.bodies[2]).iter().zip(&corners_before) {
            assert!(a.distance(*b) < 1e-7, "{a} {b}");
        }
        let center = |body: &BodyParts| {
            body.resolved.settled.transform_point(body.resolved.physical.mass.center_of_mass_m)
        };
        assert!(center(&after.composition.bodies[2]).distance(center(&before.composition.bodies[2])) < 1e-9);
        let longest = |body: &BodyParts| {
            let mass = body.resolved.physical.mass;
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            let moments = mass.inertia_diagonal_kg_m2.to_array();
            let smallest = (0..3).min_by(|&a, &b| moments[a].total_cmp(&moments[b])).expect("three");
            body.resolved.settled.rotation * (mass.principal_axes_xyzw * axes[smallest])
        };
        assert!(
            longest(&after.composition.bodies[2]).dot(longest(&before.composition.bodies[2])).abs()
                > 1.0 - 1e-9
        );
        let low = geometry.hulls[0].points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        assert!(low.abs() < 1e-6, "{low}");
        assert_eq!(
            after.composition.bodies[1].resolved.settled,
            before.composition.bodies[1].resolved.settled
        );
    }
}
