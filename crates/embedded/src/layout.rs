//! Where things stand: a sampler of collision-free, functional arrangements on a table.
//!
//! Things form a tree of who carries whom. What stands on or lies in something is laid out in its
//! supporter's frame first; the group then moves as one. On each surface (the table, a tray, a plate) groups are
//! placed one after the other: many candidate places are drawn, by the relations the text states, by habit
//! (the mouse right of the keyboard, the fork left of the plate, one place at the table per plate), and by
//! the zone a thing belongs to; those that overlap, reach over the real outline or break a relation are
//! dropped; the cheapest of the rest is taken. A dead end starts another attempt with another stream;
//! late attempts stand closer and read relations more loosely. What never fits is an error with names.
//!
//! Input: meshes in canonical frames (meters, +z up, front toward -y) and their relations. Output: poses
//! in the world (table top at z = 0) whose heights are rough: they are meant to be dropped. Guarantees: same
//! input, same poses; footprints on one surface do not overlap and lie inside the outline. Not for
//! arrangements that balance or lean. Cost: milliseconds for twelve things.

mod footprint;
mod relief;
mod tree;
mod links;
mod habits;
mod seats;
mod ground;
mod group;
mod arena;
mod container;
#[cfg(test)]
mod tests;

use glam::{DQuat, DVec2};
use serde::{Deserialize, Serialize};

use self::footprint::Footprint;
use self::group::{Group, Grouping};
use self::relief::Relief;
use catalog::Category;
use geometry::{Outline, Pose, TexturedMesh};
use runtime::seed::child_rng;
use runtime::{Interrupt, Interrupted};
use scene::RelationKind;
pub use tree::Carrier;

/// Section `[layout]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct LayoutSettings {
    /// Arrangements begun before giving up, 1..1000. More: fuller tables, slower refusals.
    pub attempts: u32,
    /// Places tried for each thing, 10..1000. More: tidier, slower.
    pub candidates: u32,
    /// Free space around each thing, meters, 0.002..0.1. More: sparser.
    pub gap_m: f64,
    /// What that shrinks to in the last attempts, meters, 0.001..`gap_m`.
    pub least_gap_m: f64,
    /// Distance kept from the table's edge, meters, 0..0.2.
    pub edge_margin_m: f64,
    /// Standard deviation of how carelessly things are turned, radians, 0..0.5. More: messier.
    pub jitter_rad: f64,
    /// Cost of a place varies at random by this much, 0..2 (a relation missed by 10 cm costs 1). More: more
    /// various and less orderly.
    pub whim: f64,
}

/// One thing to be placed.
pub struct Thing<'a> {
    /// How errors call it.
    pub name: String,
    pub category: &'a Category,
    /// In its canonical frame.
    pub mesh: &'a TexturedMesh,
    /// Relations to other things by index; `None` is the table.
    pub relations: Vec<(RelationKind, Option<usize>)>,
}

/// Why there is no arrangement.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LayoutError {
    #[error(
        "laying out the table: no room for {} after {attempts} attempts; ask for a larger table or fewer objects",
        names.join(", ")
    )]
    NoRoom { names: Vec<String>, attempts: u32 },
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Where something stands seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placement {
    xy_m: DVec2,
    yaw_rad: f64,
}

impl Placement {
    /// `self` is `outer_from_inner`, `inner` is `inner_from_thing`.
    fn then(&self, inner: &Placement) -> Placement {
        Placement {
            xy_m: self.xy_m + DVec2::from_angle(self.yaw_rad).rotate(inner.xy_m),
            yaw_rad: self.yaw_rad + inner.yaw_rad,
        }
    }
}

/// A thing with what the sampler needs to know of its shape.
struct Prepared<'a> {
    category: &'a Category,
    mesh: &'a TexturedMesh,
    footprint: Footprint,
    height_m: f64,
    /// Of supporters and containers only.
    relief: Option<Relief>,
}

/// Who carries each thing; `None` = the table.
pub fn carriers(things: &[Thing]) -> Vec<Option<Carrier>> {
    tree::carriers(things)
}

/// A pose for each thing; another seed, another arrangement.
pub fn arrange(
    things: &[Thing],
    outline: &Outline,
    seed: u64,
    settings: &LayoutSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Pose>, LayoutError> {
    let carriers = tree::carriers(things);
    let prepared: Vec<Prepared> = things
        .iter()
        .enumerate()
        .map(|(index, thing)| {
            let carries = carriers.iter().flatten().any(|carrier| carrier.parent == index);
            Prepared {
                category: thing.category,
                mesh: thing.mesh,
                footprint: Footprint::around(thing.mesh.positions.iter().map(|p| p.truncate())),
                height_m: thing.mesh.size_m().z,
                relief: carries.then(|| Relief::of(thing.mesh)),
            }
        })
        .collect();
    let links = links::links(things, &carriers);
    let mut failures = vec![0_u32; things.len()];
    for attempt in 0..settings.attempts {
        interrupt.check()?;
        let lateness = f64::from(attempt) / f64::from(settings.attempts);
        let squeeze = ((lateness - 0.4) / 0.5).clamp(0.0, 1.0);
        let mut grouping = Grouping {
            things: &prepared,
            carriers: &carriers,
            links: &links,
            wishes: things,
            settings,
            gap_m: settings.gap_m + squeeze * (settings.least_gap_m - settings.gap_m),
            slack: 1.0 + 2.0 * squeeze,
            rng: child_rng(seed, &format!("layout {attempt}")),
        };
        match grouping.arrange_on(outline) {
            Ok(groups) => return Ok(poses(&prepared, &carriers, &groups)),
            Err(thing) => failures[thing] += 1,
        }
    }
    // Those at fault in at least a fifth of the attempts.
    let bar = (settings.attempts / 5).max(1).min(failures.iter().copied().max().unwrap_or(0));
    let names =
        things.iter().zip(&failures).filter(|(_, f)| **f >= bar).map(|(t, _)| t.name.clone()).collect();
    Err(LayoutError::NoRoom { names, attempts: settings.attempts })
}

/// Poses of all members of the groups on the table.
fn poses(things: &[Prepared], carriers: &[Option<Carrier>], groups: &[(Placement, Group)]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; things.len()];
    for (placement, group) in groups {
        for member in &group.members {
            let at = placement.then(&member.at);
            let rotation = DQuat::from_rotation_z(at.yaw_rad) * member.lean;
            poses[member.thing] = Pose { translation_m: at.xy_m.extend(0.0), rotation: rotation.normalize() };
        }
    }
    for thing in 0..things.len() {
        // Roughly: as high as everything it stands on.
        let mut below = carriers[thing];
        while let Some(carrier) = below {
            poses[thing].translation_m.z += things[carrier.parent].height_m;
            below = carriers[carrier.parent];
        }
    }
    poses
}

impl Prepared<'_> {
    /// Its longer horizontal extent is along its own y.
    fn long_in_y(&self) -> bool {
        let size = self.footprint.size_m();
        size.y > size.x
    }

    /// Longest over second-longest extent.
    fn slenderness(&self) -> f64 {
        let size = self.footprint.size_m().extend(self.height_m);
        let mut extents = size.to_array();
        extents.sort_by(f64::total_cmp);
        extents[2] / extents[1].max(1e-6)
    }
}
