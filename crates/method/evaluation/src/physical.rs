//! The physical columns of the paper's tables over many scenes: Col_O, Col_S, SS and DSS.
//!
//! The rates of each scene are those of its certificate, measured when the scene was made; nothing is computed again.
//! All rates are fractions, not percent.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use certificate::Certificate;
use geometry::json_numbers::Fraction;
use scene::Metrics;

/// Rates of one scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenePhysics {
    #[serde(flatten)]
    pub metrics: Metrics,
    /// Number of examined pairs of bodies, the table included.
    pub pairs: usize,
    /// Number of pairs that collide.
    pub colliding_pairs: usize,
}

/// Rates over scenes. Each scene counts the same, however many objects it has, unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhysicalRates {
    /// Number of scenes.
    #[schemars(range(min = 1))]
    pub scenes: usize,
    /// Mean share of colliding pairs.
    #[schemars(with = "Fraction")]
    pub col_o: f64,
    /// Colliding pairs of all scenes over pairs of all scenes: scenes with more objects count more. The paper does not
    /// say by which of the two its column is.
    #[schemars(with = "Fraction")]
    pub col_o_of_all_pairs: f64,
    /// Share of scenes in which any pair collides.
    #[schemars(with = "Fraction")]
    pub col_s: f64,
    /// Mean share of statically stable objects.
    #[schemars(with = "Fraction")]
    pub ss: f64,
    /// Mean share of dynamically stable objects, from the poses of the stage `place`.
    #[schemars(with = "Fraction")]
    pub dss_aligned: f64,
    /// As `dss_aligned`, from the poses of the bundle.
    #[schemars(with = "Fraction")]
    pub dss_shipped: f64,
}

impl ScenePhysics {
    /// The rates that a certificate states.
    pub fn of(certificate: &Certificate) -> Self {
        Self {
            metrics: certificate.metrics,
            pairs: certificate.pairs,
            colliding_pairs: certificate.collisions.len(),
        }
    }
}

impl PhysicalRates {
    /// Rates over scenes; `None` without scenes.
    pub fn over<'a>(scenes: impl IntoIterator<Item = &'a ScenePhysics>) -> Option<Self> {
        let scenes: Vec<&ScenePhysics> = scenes.into_iter().collect();
        if scenes.is_empty() {
            return None;
        }
        let mean = |rate: fn(&Metrics) -> f64| {
            scenes.iter().map(|scene| rate(&scene.metrics)).sum::<f64>() / scenes.len() as f64
        };
        let total =
            |count: fn(&ScenePhysics) -> usize| scenes.iter().map(|scene| count(scene)).sum::<usize>();
        let (pairs, colliding) = (total(|scene| scene.pairs), total(|scene| scene.colliding_pairs));
        Some(Self {
            scenes: scenes.len(),
            col_o: mean(|metrics| metrics.col_o),
            col_o_of_all_pairs: colliding as f64 / pairs.max(1) as f64,
            col_s: mean(|metrics| metrics.col_s),
            ss: mean(|metrics| metrics.ss),
            dss_aligned: mean(|metrics| metrics.dss_aligned),
            dss_shipped: mean(|metrics| metrics.dss_shipped),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_means_over_scenes_and_over_all_pairs() {
        let scene = |pairs: usize, colliding_pairs: usize, ss: f64, dss: f64| {
            let col_o = colliding_pairs as f64 / pairs as f64;
            let col_s = if colliding_pairs > 0 { 1.0 } else { 0.0 };
            let metrics = Metrics { col_o, col_s, ss, dss_aligned: 0.5 * dss, dss_shipped: dss };
            ScenePhysics { metrics, pairs, colliding_pairs }
        };
        let scenes = [
            scene(10, 1, 1.0, 1.0),
            scene(90, 0, 0.5, 0.25),
            scene(20, 0, 0.75, 1.0),
            scene(1, 1, 1.0, 0.75),
        ];
        let rates = PhysicalRates::over(&scenes).expect("has scenes");
        assert_eq!((rates.scenes, rates.col_s), (4, 0.5));
        assert!((rates.col_o - 1.1 / 4.0).abs() < 1e-12);
        assert!((rates.col_o_of_all_pairs - 2.0 / 121.0).abs() < 1e-12);
        assert_eq!((rates.ss, rates.dss_shipped, rates.dss_aligned), (0.8125, 0.75, 0.375));
        assert_eq!(PhysicalRates::over(&[]), None);
    }
}
