//! The demands of a text that the finished scene does not meet.
//!
//! The image generator reports those that its arrangement leaves. Stages after it may lose further ones, or meet one by
//! chance: what users get decides.

use std::sync::Arc;

use super::Inputs;
use crate::pipeline::resolve::Loaded;
use scene::predicates::{PosedFootprint, unmet};

/// The inputs with the demands that their bodies do not meet. They stay as they are if an object of the description has
/// no body, and for images and edits, whose objects no description names.
pub(super) fn evaluated(inputs: Arc<Inputs>, loaded: &[Loaded]) -> Arc<Inputs> {
    let Some(stated) = inputs.stated.clone() else { return inputs };
    let bodies = &inputs.composition.bodies;
    let footprints: Option<Vec<PosedFootprint>> = stated
        .objects
        .iter()
        .map(|object| {
            let at = bodies.iter().position(|body| body.resolved.name == object.id.as_str())?;
            let pose = bodies[at].resolved.settled;
            let points = loaded[at].mesh.positions.iter().map(|point| pose.transform_point(*point));
            Some(PosedFootprint::of_points(points, &pose))
        })
        .collect();
    let Some(footprints) = footprints else { return inputs };
    let found = unmet(&stated, &footprints, &inputs.composition.table.outline_m);
    let mut inputs = (*inputs).clone();
    if let Some(account) = &mut inputs.composition.account {
        account.unmet = found;
    }
    Arc::new(inputs)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use serde_json::json;

    use super::super::tests::{Planted, sound};
    use super::*;
    use scene::SceneDescription;
    use scene::predicates::UnmetDemand;
    use scene::text_account::TextAccount;

    /// Both cubes of [`sound`] with that stated yaw.
    fn cubes_turned_by(yaw_rad: f64) -> SceneDescription {
        let object = |id: &str| {
            json!({
                "id": id, "label": "a cube", "category": "cube", "size_m": [0.06, 0.06, 0.06], "seed": 1,
                "requested": true, "yaw_rad": yaw_rad, "relations": [],
            })
        };
        let table = json!({ "shape": "square", "size_m": [1.0, 1.0, 0.03], "material": null, "color": null });
        serde_json::from_value(json!({
            "theme": "office_desk", "family": "office_living", "table": table, "prose": "",
            "objects": [object("cube_1"), object("cube_2")],
        }))
        .expect("a description")
    }

    #[test]
    fn a_yaw_that_the_bodies_do_not_have_is_reported() {
        for (yaw_rad, expected) in [(0.3, 0), (0.3 + PI, 2)] {
            let Planted { mut inputs, loaded, .. } = sound();
            inputs.stated = Some(Arc::new(cubes_turned_by(yaw_rad)));
            inputs.composition.account = Some(TextAccount::default());
            let evaluated = evaluated(Arc::new(inputs), &loaded);
            let unmet = &evaluated.composition.account.as_ref().expect("an account").unmet;
            assert_eq!(unmet.len(), expected, "{unmet:?}");
            assert!(unmet.iter().all(|unmet| matches!(unmet.demand, UnmetDemand::Yaw { .. })));
        }
    }
}
