//! A table with room: lays the objects out, and yields or grows the table where that is not possible.
//!
//! The order is: all demands on the described table; without the habits of the theme; on the smallest larger table with
//! room, if neither text nor options state a size; then demands yield in the order of [`Yielding`], on the described
//! table and at last on the largest one. Contradictory demands do not grow the table: where the largest one does not
//! help, growth is skipped. Each step tries several seeds. Cost: that of the successful layout, plus the failed
//! attempts.

use super::arrangement::{self, Arrangement, UnarrangedScene};
use super::objects::{self, Bodies, SceneObject};
use super::table::{SceneTable, build_scene_table};
use super::viewpoint::{self, Viewpoint};
use super::{Settings, error, timed};
use crate::layout::{StatedDemands, Yielding};
use ports::ProviderError;
use runtime::CancelFlag;
use runtime::seed::child_seed;
use scene::SceneDescription;

/// Factors on width and depth of a table without a stated size.
const GROWTH: [f64; 5] = [1.15, 1.35, 1.6, 2.0, 2.5];
/// Largest width and depth to which a table grows, meters.
const MAX_SIDE_M: f64 = 3.5;
/// Arrangements tried for each step after the first.
const ARRANGEMENTS_PER_STEP: u32 = 3;
/// Arrangements tried for more visibility of what is in containers, as long as each of these objects shows a little.
const ARRANGEMENTS_FOR_CONTENTS: u32 = 2;
/// Of an object that others hide in every arrangement, this share of its silhouette has to show.
const MIN_HIDDEN_SHARE: f64 = 0.05;
/// Layouts without room after which a step gives up.
const MAX_FULL_TABLES: u32 = 2;

/// A table with its objects arranged and a camera that shows them.
pub(super) struct ArrangedTable {
    pub table: SceneTable,
    pub arrangement: Arrangement,
    pub viewpoint: Viewpoint,
}

/// One combination of table size and yielding.
struct Step {
    growth: f64,
    max_yielding: Yielding,
    arrangements: u32,
}

/// The first arrangement that succeeds.
///
/// # Errors
///
/// `Rejected`: `no_room` if the objects do not fit even without relations; `does_not_hold`, `hidden`.
pub(super) fn arrange_on_sufficient_table(
    description: &SceneDescription,
    objects: &[SceneObject],
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<ArrangedTable, ProviderError> {
    let stated = StatedDemands::of(description);
    let arrangements = settings.image_generator.arrangements.max(1);
    let few = arrangements.min(ARRANGEMENTS_PER_STEP);
    let largest = growth_factors(description).last().copied();
    // The last one is next.
    let mut waiting = vec![
        Step { growth: 1.0, max_yielding: Yielding::Habits, arrangements: few },
        Step { growth: 1.0, max_yielding: Yielding::Nothing, arrangements },
    ];
    let mut has_grown = false;
    let mut current: Option<(f64, SceneTable, Bodies)> = None;
    let mut last_error = None;
    loop {
        let Some(step) = waiting.pop() else {
            return Err(last_error.unwrap_or_else(|| error::hidden(&[])));
        };
        let (table, bodies) = match current.take() {
            Some((growth, table, bodies)) if growth == step.growth => (table, bodies),
            _ => {
                let table = timed("table", || build_scene_table(&grown(description, step.growth), seed))?;
                let bodies =
                    timed("bodies", || objects::bodies(&table, objects, &settings.decompose, cancel))?;
                (table, bodies)
            }
        };
        let scene = UnarrangedScene { table: &table, objects, bodies: &bodies, stated: &stated };
        match arrange(&scene, &step, seed, settings, cancel) {
            Ok((arrangement, viewpoint)) => return Ok(ArrangedTable { table, arrangement, viewpoint }),
            Err(error) if error::is_no_room(&error) => {
                tracing::debug!(%error, growth = step.growth, yields = ?step.max_yielding, "no room");
                last_error = Some(error);
            }
            Err(error) => return Err(error),
        }
        if waiting.is_empty() && !has_grown {
            has_grown = true;
            waiting.extend(largest.map(|growth| Step {
                growth,
                max_yielding: Yielding::Relations,
                arrangements: few,
            }));
            waiting.push(Step { growth: 1.0, max_yielding: Yielding::Relations, arrangements: few });
            let growth = sufficient_growth(&scene, description, seed, settings, cancel)?;
            waiting.extend(growth.map(|growth| Step {
                growth,
                max_yielding: Yielding::Habits,
                arrangements: few,
            }));
        }
        current = Some((step.growth, table, bodies));
    }
}

/// Permitted growth factors, ascending; empty if the size is stated.
fn growth_factors(description: &SceneDescription) -> Vec<f64> {
    let Some(size_m) = description.table.size_m.filter(|_| !description.table_size_is_stated) else {
        return Vec::new();
    };
    GROWTH.into_iter().filter(|factor| factor * size_m.truncate().max_element() <= MAX_SIDE_M).collect()
}

/// The smallest factor with which the demands can be met, without physics; `None` if no factor helps.
fn sufficient_growth(
    scene: &UnarrangedScene,
    description: &SceneDescription,
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<Option<f64>, ProviderError> {
    let factors = growth_factors(description);
    let has_room = |factor: f64| arrangement::has_room(scene, factor, seed, settings, cancel);
    match factors.last() {
        Some(&largest) if has_room(largest)? => {}
        _ => return Ok(None),
    }
    for factor in factors {
        if has_room(factor)? {
            return Ok(Some(factor));
        }
    }
    Ok(None)
}

/// The specification with a larger top.
fn grown(description: &SceneDescription, growth: f64) -> scene::TableSpec {
    let mut spec = description.table.clone();
    spec.size_m = spec.size_m.map(|size_m| (growth * size_m.truncate()).extend(size_m.z));
    spec
}

/// A stable arrangement and a camera with sufficient visibility of every object, or the best pair tried.
fn arrange(
    scene: &UnarrangedScene,
    step: &Step,
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<(Arrangement, Viewpoint), ProviderError> {
    let mut last_error: Option<ProviderError> = None;
    let mut best: Option<(Arrangement, Viewpoint)> = None;
    let mut full_tables = 0;
    for number in 0..step.arrangements {
        let seed = child_seed(seed, &format!("arrangement {number}"));
        let arranged =
            timed("arrangement", || arrangement::arrange(scene, step.max_yielding, seed, settings, cancel));
        let arrangement = match arranged {
            Ok(arrangement) => arrangement,
            Err(ProviderError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => {
                tracing::debug!(%error, number, "an arrangement did not hold");
                full_tables += u32::from(error::is_no_room(&error));
                last_error = Some(error);
                if full_tables >= MAX_FULL_TABLES {
                    break;
                }
                continue;
            }
        };
        let viewpoint = timed("viewpoint", || {
            viewpoint::choose(
                scene.table,
                scene.objects,
                &arrangement,
                seed,
                &settings.image_generator,
                cancel,
            )
        })?;
        let wanted_share = settings.image_generator.min_visible_share;
        // Where contents hide, another arrangement may show them; what lies below others it cannot.
        let contents_may_show = number + 1 < ARRANGEMENTS_FOR_CONTENTS;
        let counted_share = match contents_may_show {
            true => viewpoint.min_uncovered_visible_share,
            false => viewpoint.min_open_visible_share,
        };
        let sufficient = viewpoint.min_visible_share >= MIN_HIDDEN_SHARE.min(wanted_share)
            && counted_share >= wanted_share;
        let better =
            best.as_ref().is_none_or(|(_, best)| viewpoint.min_visible_share > best.min_visible_share);
        if better {
            best = Some((arrangement, viewpoint));
        }
        if sufficient {
            break;
        }
    }
    match best {
        Some((_, viewpoint)) if viewpoint.min_visible_share <= 0.0 => Err(error::hidden(&viewpoint.hidden)),
        Some(best) => Ok(best),
        None => Err(last_error.unwrap_or_else(|| error::hidden(&[]))),
    }
}
