//! Turning and resizing objects.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};

use super::{Done, ids, names, one, place_branches, several};
use crate::pipeline::edit::draft::{self, Draft};
use crate::pipeline::edit::error::EditError;
use editing::PlaceQuery;
use geometry::pose::wrap_angle_rad;
use scene::Supporter;

/// An object that is turned or resized stays within this of its place, meters.
const MAX_STEP_M: f64 = 0.018;

pub(super) fn rotate(
    draft: &mut Draft,
    phrase: &str,
    by_rad: Option<f64>,
    to_rad: Option<f64>,
    facing: Option<&str>,
) -> Done {
    let targets = several(draft, phrase)?;
    for &target in &targets {
        let pose = draft.pose(target);
        let yaw_rad = pose.yaw_rad().ok_or(EditError::NoYaw)?;
        let turn_rad = match (by_rad, to_rad, facing) {
            (Some(by_rad), ..) => by_rad,
            (_, Some(to_rad), _) => to_rad - yaw_rad,
            (_, _, Some(phrase)) => {
                let other = one(draft, phrase)?;
                if other == target {
                    return Err(EditError::FacesItself);
                }
                let toward = draft.center_m(other) - draft.center_m(target);
                // At yaw 0 the front faces -y.
                toward.to_angle() + FRAC_PI_2 - yaw_rad
            }
            _ => 0.0,
        };
        let turn = DQuat::from_rotation_z(wrap_angle_rad(turn_rad));
        // About the center of the footprint, so that it stays in its place.
        let center_m = draft.center_m(target).extend(0.0);
        let mut turned = pose;
        turned.rotation = (turn * pose.rotation).normalize();
        turned.translation_m = center_m + turn * (pose.translation_m - center_m);
        draft.is_named(target);
        let load = draft.workspace.branch(target);
        draft.may_move(&load, &format!("it turns with {}", draft.name(target)));
        let supporter = draft.supporter(target);
        let wanted_rad = wrap_angle_rad(yaw_rad + turn_rad);
        if let Err(why) = draft.rest_turned(target, turned, supporter, wanted_rad) {
            // At the edge of the table, or beside another object, a small step makes room.
            let query = PlaceQuery { yaw_rad: Some(wanted_rad), ..draft.near_by(target, MAX_STEP_M) };
            draft.find_and_rest(target, &query).map_err(|_| why)?;
        }
    }
    Ok((ids(draft, &targets), format!("turned {}", names(draft, &targets))))
}

pub(super) fn set_physics(
    draft: &mut Draft,
    phrase: &str,
    mass_factor: Option<f64>,
    friction_factor: Option<f64>,
) -> Done {
    let targets = several(draft, phrase)?;
    for &target in &targets {
        let physical = &mut draft.parts(target).resolved.physical;
        let mass_kg = physical.mass.mass_kg * mass_factor.unwrap_or(1.0);
        physical.mass = physical.mass.with_mass(mass_kg);
        let factor = friction_factor.unwrap_or(1.0);
        physical.friction.static_coefficient *= factor;
        physical.friction.dynamic_coefficient *= factor;
        draft.refresh(target)?;
    }
    let of = |what: &str, factor: Option<f64>| factor.map(|factor| format!("{what} by {factor:.2}"));
    let changed: Vec<String> =
        [of("mass", mass_factor), of("friction", friction_factor)].into_iter().flatten().collect();
    Ok((ids(draft, &targets), format!("changed of {} {}", names(draft, &targets), changed.join(" and "))))
}

pub(super) fn resize(draft: &mut Draft, phrase: &str, factor: f64) -> Done {
    let targets = several(draft, phrase)?;
    for &target in &targets {
        draft.is_named(target);
        let load: Vec<(usize, Supporter)> =
            draft.load(target).into_iter().map(|object| (object, draft.supporter(object))).collect();
        for &(object, _) in &load {
            for member in draft.workspace.branch(object) {
                draft.workspace.objects[member].is_placed = false;
            }
            // Not on it while it is searched a place.
            draft.workspace.objects[object].supporter = Supporter::TABLE;
        }
        let geometry = &draft.loaded[target + 1];
        let mesh = (*geometry.mesh).clone().scaled(DVec3::splat(factor));
        let mut hulls = geometry.hulls.clone();
        hulls.iter_mut().flat_map(|hull| &mut hull.points).for_each(|point| *point *= factor);
        draft.reshape(target, draft::load(mesh, hulls)?, factor)?;
        let parts = draft.parts(target);
        parts.scale *= factor;
        parts.hull_excess_m *= factor;
        parts.hull_fit = parts.hull_fit.scaled(factor);
        parts.provenance.notes.push(format!("resized by {factor:.2} in an edit"));
        let pose = draft.pose(target);
        let supporter = draft.supporter(target);
        if let Err(why) = draft.rest_at(target, pose, supporter) {
            let query = draft.near_by(target, MAX_STEP_M);
            draft.find_and_rest(target, &query).map_err(|_| why)?;
        }
        place_branches(draft, &load);
        let cause = format!("{} was resized below it", draft.name(target));
        draft.rest_again(&load, &cause)?;
    }
    Ok((ids(draft, &targets), format!("resized {} by {factor:.2}", names(draft, &targets))))
}
