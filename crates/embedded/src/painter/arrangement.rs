//! From things to poses that hold: lay out, then resolve.

use super::props::{Bodies, Prop};
use super::table::PaintedTable;
use super::{Settings, error};
use crate::layout;
use crate::layout::Thing;
use geometry::Pose;
use geometry::mesh_solid::MeshSolid;
use physics::{ResolveProblem, SupportedBy, resolve};
use ports::ProviderError;
use runtime::Interrupt;

/// Where every prop stands.
pub(super) struct Arrangement {
    /// `world_from_object`, settled, in the order of the props.
    pub poses: Vec<Pose>,
}

/// Lays the props out and settles them; the error names what found no place or does not hold.
pub(super) fn arrange(
    table: &PaintedTable,
    props: &[Prop],
    bodies: &Bodies,
    seed: u64,
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<Arrangement, ProviderError> {
    let things = things(props);
    let poses =
        layout::arrange(&things, &table.outline, seed, &settings.layout, interrupt).map_err(error::layout)?;
    let mut movable = bodies.bodies.clone();
    for (body, pose) in movable.iter_mut().skip(1).zip(&poses) {
        body.world_from_object = *pose;
    }
    let carried = layout::carriers(&things).into_iter().map(|carrier| {
        // Bodies count the table first.
        Some(match carrier {
            Some(carrier) => SupportedBy { parent: carrier.parent + 1, inside: carrier.inside },
            None => SupportedBy { parent: 0, inside: false },
        })
    });
    let supports: Vec<Option<SupportedBy>> = std::iter::once(None).chain(carried).collect();
    let solids: Vec<&MeshSolid> = bodies.solids.iter().collect();
    let problem =
        ResolveProblem { bodies: &movable, solids: &solids, supports: &supports, outline: &table.outline };
    let resolved = resolve(problem, &settings.resolve, &settings.settle, &settings.certify, interrupt)
        .map_err(error::resolve)?;
    for line in &resolved.log {
        tracing::debug!(line, "resolving the layout");
    }
    Ok(Arrangement { poses: resolved.poses.into_iter().skip(1).collect() })
}

/// The props as the layout sampler sees them.
pub(super) fn things<'a>(props: &'a [Prop]) -> Vec<Thing<'a>> {
    props
        .iter()
        .map(|prop| Thing {
            name: prop.spec.id.to_string(),
            category: prop.category,
            mesh: &prop.mesh,
            relations: prop
                .spec
                .relations
                .iter()
                .filter_map(|relation| match &relation.target {
                    None => Some((relation.kind, None)),
                    Some(id) => {
                        props.iter().position(|other| other.spec.id == *id).map(|k| (relation.kind, Some(k)))
                    }
                })
                .collect(),
        })
        .collect()
}
