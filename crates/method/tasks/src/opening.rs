//! The opening of a container, from its convex hulls.
//!
//! Water is poured over the top surface of the object (priority flood: Barnes, Lehman and Mulla, "Priority-flood: an
//! optimal depression-filling and watershed-labeling algorithm", 2014). The largest basin is the cavity, its level
//! the rim, and the convex hull of its area the opening. A basin that is shallower than 1 cm or smaller than 4 cm^2
//! holds nothing. Object frame, meters. A few milliseconds.

mod flood;
mod height_field;

use geometry::ConvexHull;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};
use glam::{DVec2, DVec3};

use crate::convex_width::narrowest_width_m;

use self::flood::{Basin, basins};
use self::height_field::HeightField;

/// Least depth of a cavity, meters.
const MIN_DEPTH_M: f64 = 0.01;
/// Least area of an opening, square meters.
const MIN_AREA_M2: f64 = 4e-4;
/// Basins that a handle separates have nearly the same level, meters.
const SAME_LEVEL_M: f64 = 0.01;
/// Share of the largest basin from which another one is a part of the same opening.
const MIN_SHARE: f64 = 0.2;

/// Opening of a container: the space below the rim and inside the opening's hull. Object frame, meters.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Convex and counter-clockwise, seen from above.
    pub hull_m: Vec<DVec2>,
    /// Height at which the container would overflow.
    pub rim_m: f64,
    /// Height of the lowest point of the cavity.
    pub floor_m: f64,
    /// Volume below the rim, cubic meters.
    pub volume_m3: f64,
}

impl Opening {
    /// The opening of an object with these hulls; `None` if it holds nothing.
    pub fn of_hulls(hulls: &[ConvexHull]) -> Option<Self> {
        let field = HeightField::of(hulls)?;
        let basins = basins(&field);
        let main = basins.iter().max_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3))?;
        let belongs = |basin: &&Basin| {
            (basin.level_m - main.level_m).abs() <= SAME_LEVEL_M
                && basin.volume_m3 >= MIN_SHARE * main.volume_m3
        };
        let parts: Vec<&Basin> = basins.iter().filter(belongs).collect();
        let half_m = 0.5 * field.cell_m;
        let corners: Vec<DVec2> = parts
            .iter()
            .flat_map(|basin| &basin.cells)
            .flat_map(|&cell| {
                let center_m = field.center_of(cell);
                [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)]
                    .map(|offset| center_m + DVec2::from(offset))
            })
            .collect();
        let cells: usize = parts.iter().map(|basin| basin.cells.len()).sum();
        let floor_m = parts.iter().map(|basin| basin.floor_m).fold(f64::INFINITY, f64::min);
        let opening = Self {
            hull_m: convex_hull_2d(&corners),
            rim_m: main.level_m,
            floor_m,
            volume_m3: parts.iter().map(|basin| basin.volume_m3).sum(),
        };
        let is_deep = opening.depth_m() >= MIN_DEPTH_M;
        (is_deep && cells as f64 * field.cell_m * field.cell_m >= MIN_AREA_M2).then_some(opening)
    }

    /// From the rim to the lowest point of the cavity, meters.
    pub fn depth_m(&self) -> f64 {
        self.rim_m - self.floor_m
    }

    /// Smallest width of its hull over all horizontal directions, meters.
    pub fn narrowest_m(&self) -> f64 {
        narrowest_width_m(&self.hull_m)
    }

    /// Mean of the corners of its hull, at the rim.
    pub fn center_m(&self) -> DVec3 {
        let mean = self.hull_m.iter().sum::<DVec2>() / self.hull_m.len().max(1) as f64;
        mean.extend(self.rim_m)
    }

    /// Horizontal depth of a point inside the opening's hull, meters; negative outside.
    pub fn depth_inside_m(&self, point_m: DVec3) -> f64 {
        depth_in_convex_m(&self.hull_m, point_m.truncate())
    }
}

#[cfg(test)]
mod tests;
