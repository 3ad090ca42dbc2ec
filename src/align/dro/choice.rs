//! Which of several poses with the same outline: the one whose colors are the picture's.
//!
//! A book, a keyboard, a labeled jar look the same in outline turned by half a turn or by any angle; the
//! picture does not. Whether the colors tell the poses apart also decides what is left of the symmetry.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::DroSettings;
use super::comparison::Comparison;
use super::search::golden_section;
use super::symmetry;
use crate::align::appearance::{Model, PictureCrop};
use crate::geometry::{Interrupt, Interrupted};

/// Yaws tried where the outline says nothing.
const TURNS: u32 = 36;

/// Everything a color comparison needs.
pub struct Colors<'a> {
    pub model: Model<'a>,
    pub comparison: &'a Comparison<'a>,
    pub picture: &'a PictureCrop,
}

impl Colors<'_> {
    fn disagreement(&self, yaw_rad: f64, interrupt: &Interrupt) -> Result<f64, Interrupted> {
        interrupt.check()?;
        Ok(self.picture.disagreement(&self.model, self.comparison, yaw_rad))
    }
}

/// Best yaw, its color disagreement, and the order of the symmetry that outline and colors share.
/// `top` are the outline's candidates, best first, `outline_order` its symmetry.
pub fn choose(
    colors: &Colors,
    top: &[(f64, f64)],
    outline_order: u32,
    settings: &DroSettings,
    interrupt: &Interrupt,
) -> Result<(f64, u32), Interrupted> {
    let best = top[0];
    match outline_order {
        0 => {
            let step_rad = TAU / f64::from(TURNS);
            let look = |k: u32| {
                let yaw_rad = f64::from(k) * step_rad;
                colors.disagreement(yaw_rad, interrupt).map(|value| (yaw_rad, value))
            };
            // What shows at all shows over half a turn: where a third of the yaws are all but alike, all are.
            let (few, more): (Vec<u32>, Vec<u32>) = (0..TURNS).partition(|k| k.is_multiple_of(3));
            let mut curve = few.into_par_iter().map(look).collect::<Result<Vec<_>, Interrupted>>()?;
            if relief(&curve) < 0.5 * settings.flat_appearance {
                return Ok((0.0, 0));
            }
            curve.extend(more.into_par_iter().map(look).collect::<Result<Vec<_>, Interrupted>>()?);
            curve.sort_by(|a, b| a.0.total_cmp(&b.0));
            if relief(&curve) < settings.flat_appearance {
                return Ok((0.0, 0));
            }
            let order = symmetry::periodic_order(&curve, 2.0 * settings.periodic_share);
            let around =
                curve.iter().copied().fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
            let (from, to) = (around.0 - step_rad, around.0 + step_rad);
            let (yaw_rad, value) =
                golden_section(from, to, 0.02, |yaw_rad| colors.disagreement(yaw_rad, interrupt))?;
            Ok((if value <= around.1 { yaw_rad } else { around.0 }, order))
        }
        1 => {
            let mut chosen = (best.0, f64::INFINITY);
            for &(yaw_rad, loss) in top.iter().filter(|c| c.1 <= best.1 + settings.same_outline) {
                // Colors add to the loss: no outline from here on can be chosen.
                if loss >= chosen.1 {
                    break;
                }
                let value = loss + settings.appearance_weight * colors.disagreement(yaw_rad, interrupt)?;
                if value < chosen.1 {
                    chosen = (yaw_rad, value);
                }
            }
            Ok((chosen.0, 1))
        }
        order => {
            let step_rad = TAU / f64::from(order);
            let mut turned = Vec::new();
            for k in 0..order {
                let yaw_rad = best.0 + f64::from(k) * step_rad;
                turned.push((yaw_rad, colors.disagreement(yaw_rad, interrupt)?));
            }
            let n = turned.len();
            let alike = |m: usize| {
                (0..n).all(|k| (turned[k].1 - turned[(k + n / m) % n].1).abs() < settings.flat_appearance)
            };
            let left = (1..=n).rev().find(|m| n.is_multiple_of(*m) && alike(*m)).unwrap_or(1);
            let chosen =
                turned.iter().copied().fold((best.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
            Ok((chosen.0, left as u32))
        }
    }
}

/// Highest value less the lowest.
fn relief(curve: &[(f64, f64)]) -> f64 {
    let range = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
    let (low, high) = curve.iter().map(|c| c.1).fold((f64::INFINITY, f64::NEG_INFINITY), range);
    high - low
}
