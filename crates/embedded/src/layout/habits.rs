//! How people put things down where nobody says how: what belongs beside what, and which way it is
//! turned.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;
use rand::RngExt;

use super::links::{BEHIND, FRONT, LEFT, Link, RIGHT, Spot};
use super::tree::Carrier;
use super::{Prepared, Thing};
use catalog::Facing;
use runtime::seed::Rng;

/// Beyond and to the right of a plate, where glasses stand.
const UPPER_RIGHT: Spot = Spot::Toward(0.9);
/// And where bowls do.
const UPPER_LEFT: Spot = Spot::Toward(2.25);

/// A category stands at a spot of the first of the targets that is there.
struct Habit {
    category: &'static str,
    spot: Spot,
    targets: &'static [&'static str],
    /// Directions are those of whoever sits at the target.
    turns: bool,
}

const fn habit(category: &'static str, spot: Spot, targets: &'static [&'static str]) -> Habit {
    Habit { category, spot, targets, turns: false }
}

const fn at_place(category: &'static str, spot: Spot, targets: &'static [&'static str]) -> Habit {
    Habit { category, spot, targets, turns: true }
}

const HABITS: &[Habit] = &[
    habit("keyboard", FRONT, &["monitor", "laptop"]),
    habit("mouse", RIGHT, &["keyboard", "laptop"]),
    at_place("fork", LEFT, &["plate", "bowl"]),
    at_place("knife", RIGHT, &["plate", "cutting_board"]),
    at_place("spoon", RIGHT, &["plate", "bowl", "teacup", "saucer", "mug"]),
    at_place("chopsticks", RIGHT, &["plate", "bowl"]),
    at_place("wine_glass", UPPER_RIGHT, &["plate"]),
    at_place("drinking_glass", UPPER_RIGHT, &["plate"]),
    at_place("mug", UPPER_RIGHT, &["plate"]),
    at_place("bowl", UPPER_LEFT, &["plate"]),
    habit("pepper_mill", Spot::Beside, &["salt_shaker"]),
    habit("salt_shaker", Spot::Beside, &["pepper_mill"]),
    habit("pen", RIGHT, &["notebook", "paper_stack", "sticky_notes"]),
    habit("pencil", RIGHT, &["notebook", "paper_stack", "sticky_notes"]),
    habit("eyeglasses", Spot::Beside, &["book", "notebook"]),
    habit("remote_control", Spot::Beside, &["game_controller"]),
    habit("paintbrush", Spot::Beside, &["paint_palette", "watercolor_set", "canvas_board"]),
    habit("dice", Spot::Beside, &["playing_cards"]),
    habit("nut", Spot::Beside, &["bolt"]),
    habit("pin_cushion", Spot::Beside, &["sewing_machine"]),
    habit("utility_knife", Spot::Beside, &["cutting_mat"]),
    habit("pitcher", BEHIND, &["drinking_glass"]),
];

/// Kinds of which several lie together.
const HERDS: &[&str] = &[
    "fruit",
    "vegetable",
    "food",
    "bakery",
    "hand_tool",
    "hardware",
    "writing_tool",
    "pen",
    "paint",
    "brush",
    "sewing",
    "game",
    "toy",
    "adhesive",
    "spool",
    "bottle",
    "measuring_tool",
    "reading",
];

/// Adds the habits of things the text ties to nothing.
pub(super) fn add_links(things: &[Thing], carriers: &[Option<Carrier>], links: &mut Vec<Link>) {
    let same_ground = |a: usize, b: usize| carriers[a].map(|c| c.parent) == carriers[b].map(|c| c.parent);
    let of = |name: &str, near: usize| -> Vec<usize> {
        (0..things.len()).filter(|&k| things[k].category.name == name && same_ground(k, near)).collect()
    };
    for from in 0..things.len() {
        if carriers[from].is_some_and(|carrier| carrier.inside) {
            continue;
        }
        let category = things[from].category;
        let said: Vec<Link> = links.iter().copied().filter(|l| l.from == from && l.firm).collect();
        let placed =
            things[from].relations.iter().any(|(kind, target)| target.is_none() && !kind.is_support());
        let rank = of(&category.name, from).iter().position(|&k| k == from).unwrap_or(0);
        for habit in HABITS.iter().filter(|habit| habit.category == category.name) {
            // "Next to the plate" leaves the side open; any other word settles it.
            let beside = said.iter().find(|l| {
                l.spot == Spot::Beside && habit.targets.contains(&things[l.to].category.name.as_str())
            });
            if let Some(link) = beside {
                links.push(Link { spot: habit.spot, turns: habit.turns, firm: false, ..*link });
            } else if said.is_empty() && !placed {
                let targets = habit.targets.iter().map(|name| of(name, from)).find(|found| !found.is_empty());
                let Some(targets) = targets else { continue };
                // One each; what is left over stands free.
                let Some(&to) = targets.get(rank).or(if habit.turns { None } else { targets.last() }) else {
                    continue;
                };
                let mutual = links.iter().any(|l| l.from == to && l.to == from);
                if to != from && !mutual {
                    links.push(Link { from, to, spot: habit.spot, turns: habit.turns, firm: false });
                }
            }
        }
        let tied = links.iter().any(|l| l.from == from);
        if !tied && !placed && rank > 0 && HERDS.contains(&category.group.as_str()) {
            let to = of(&category.name, from)[rank - 1];
            links.push(Link { from, to, spot: Spot::Beside, turns: false, firm: false });
        }
    }
}

/// Which way a thing is turned.
pub(super) struct Turning<'a> {
    pub thing: &'a Prepared<'a>,
    /// Yaw of the place it belongs to (a fork's plate), of the seat, or of its like beside it.
    pub follows_rad: Option<f64>,
    /// Half the depth of the surface, meters: how far away the viewer is.
    pub half_depth_m: f64,
    pub jitter_rad: f64,
    /// What faces the viewer may as well stand sideways: where it found no room facing him.
    pub sideways_too: bool,
}

impl Turning<'_> {
    /// A yaw for the thing at `xy_m`.
    pub fn yaw_rad(&self, xy_m: DVec2, rng: &mut Rng) -> f64 {
        let jitter = self.jitter_rad * (rng.random_range(-1.0..1.0_f64) + rng.random_range(-1.0..1.0_f64));
        if let Some(yaw_rad) = self.follows_rad {
            return yaw_rad + jitter;
        }
        match self.thing.category.facing {
            Facing::Viewer => {
                // Turned halfway toward somebody who stands in front of the middle.
                let away = xy_m.y + self.half_depth_m + 0.45;
                let aside = if self.sideways_too {
                    [0.0, FRAC_PI_2, -FRAC_PI_2][rng.random_range(0..3)]
                } else {
                    0.0
                };
                0.5 * (-xy_m.x).atan2(away) + aside + jitter
            }
            Facing::Aligned => jitter,
            Facing::Any if self.thing.slenderness() > 1.8 => {
                // Long things mostly point away from the viewer or lie across.
                let base = if self.thing.long_in_y() { 0.0 } else { FRAC_PI_2 };
                let turn = match rng.random_range(0..10) {
                    0..=5 => rng.random_range(-0.45..0.45),
                    6..=7 => FRAC_PI_2 + rng.random_range(-0.4..0.4),
                    _ => rng.random_range(-PI..PI),
                };
                base + turn
            }
            Facing::Any => rng.random_range(-PI..PI),
        }
    }
}
