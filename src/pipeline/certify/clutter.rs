//! Clutter of a finished scene: what touches, what is covered, what is hidden.

use super::{Inputs, Loaded};
use crate::pipeline::error::StageError;
use crate::pipeline::preview::HiddenShares;
use crate::pipeline::resolve::body;
use physics::Body;
use physics::clutter::{contacts, covered_share};
use scene::InstanceId;
use scene::clutter::{ClutterFinding, ClutterPlacement, ClutteredObject};

/// The measurements of a scene whose objects were dropped; `None` for others. `hidden` is of the bodies, the table
/// first.
pub(super) fn finding(
    inputs: &Inputs,
    loaded: &[Loaded],
    hidden: &[HiddenShares],
) -> Result<Option<ClutterFinding>, StageError> {
    let Some(heap) = &inputs.composition.clutter else { return Ok(None) };
    let parts = inputs.composition.bodies.iter().zip(loaded).enumerate();
    let bodies: Vec<Body> = parts
        .map(|(index, (parts, geometry))| {
            let resolved = &parts.resolved;
            body(&resolved.name, geometry, resolved.settled, &resolved.physical, index == 0)
        })
        .collect();
    let touching = contacts(&bodies, inputs.certify.contact_gap_m);
    let mut objects = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate().skip(1) {
        let name = InstanceId::new(&body.name)
            .map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
        objects.push(ClutteredObject {
            placement: heap.placement(&body.name),
            name,
            contacts: touching[index].iter().filter(|contact| contact.other != 0).count(),
            hidden_in_hero: hidden[index].in_hero,
            hidden_from_above: hidden[index].from_above,
        });
    }
    let dropped: Vec<&Body> = bodies
        .iter()
        .skip(1)
        .zip(&objects)
        .filter(|(_, object)| object.placement != ClutterPlacement::Kept)
        .map(|(body, _)| body)
        .collect();
    let count = objects.len().max(1) as f64;
    let contacts = objects.iter().map(|object| object.contacts).sum::<usize>();
    let is_hidden = |object: &&ClutteredObject| {
        object.hidden_in_hero.max(object.hidden_from_above) >= ClutterFinding::HIDDEN
    };
    Ok(Some(ClutterFinding {
        density: heap.density,
        covered_share: covered_share(&dropped, inputs.composition.outline()),
        mean_contacts: contacts as f64 / count,
        touching: objects.iter().filter(|object| object.contacts > 0).count(),
        hidden_share: objects.iter().filter(is_hidden).count() as f64 / count,
        objects,
    }))
}
