//! Medians, tails and shares of scores.

use serde::Serialize;

use super::layout::SceneScore;
use super::score::{ObjectScore, YawStatus};

/// Nearest-rank quantiles of a list; each is a value of the list.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantiles {
    pub count: usize,
    pub median: f64,
    pub p95: f64,
    pub worst: f64,
}

/// Scores of a group of scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub scenes: usize,
    pub objects: usize,
    /// Degrees; `None` where no object's yaw is scored.
    pub yaw_deg: Option<Quantiles>,
    /// Degrees, including yaws that only textures determine and that the stages' meshes lack.
    pub textured_yaw_deg: Option<Quantiles>,
    /// Meters.
    pub position_m: Option<Quantiles>,
    /// Shares.
    pub scale: Option<Quantiles>,
    /// Share of the objects whose category has symmetry of order 0.
    pub order_zero_share: f64,
    /// Share of the other objects whose yaw is not scored.
    pub excluded_share: f64,
    /// Share of all objects that lean, of those with a front whose yaws are all indistinguishable, and of those
    /// whose yaw only textures determine.
    pub leaning_share: f64,
    pub indistinguishable_share: f64,
    pub only_texture_tells_share: f64,
    /// Number of meshes on another side, among those whose yaw is scored.
    pub wrong_sides: usize,
    /// Share of the objects that are occluded by more than a tenth, and the largest occluded share.
    pub hidden_share: f64,
    pub max_hidden: f64,
    pub ablation: Vec<Collisions>,
}

/// One line of the ablation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Collisions {
    pub variation: &'static str,
    /// Share of scenes with a collision.
    pub col_s: f64,
    /// Mean share of colliding pairs over the scenes.
    pub col_o: f64,
}

/// Quantiles; `None` of an empty list.
pub fn quantiles(mut values: Vec<f64>) -> Option<Quantiles> {
    values.sort_by(f64::total_cmp);
    let rank =
        |share: f64| values[((share * values.len() as f64).ceil() as usize).clamp(1, values.len()) - 1];
    (!values.is_empty()).then(|| Quantiles {
        count: values.len(),
        median: rank(0.5),
        p95: rank(0.95),
        worst: rank(1.0),
    })
}

/// Summary of a group of scenes.
pub fn summary(scenes: &[&SceneScore]) -> Summary {
    let objects: Vec<&ObjectScore> = scenes.iter().flat_map(|scene| &scene.objects).collect();
    let share = |count: usize, of: usize| if of == 0 { 0.0 } else { count as f64 / of as f64 };
    let yaw_status = |what: YawStatus| objects.iter().filter(|o| o.yaw_status == what).count();
    let order_zero = yaw_status(YawStatus::OrderZero);
    let (leaning, same) = (yaw_status(YawStatus::Leaning), yaw_status(YawStatus::AnyIndistinguishable));
    let textured = yaw_status(YawStatus::OnlyTextureTells);
    let scored = objects.iter().filter(|o| o.yaw_status == YawStatus::Scored);
    let wrong_side = |o: &&&ObjectScore| o.wrong_side && o.yaw_status == YawStatus::Scored;
    Summary {
        scenes: scenes.len(),
        objects: objects.len(),
        yaw_deg: quantiles(scored.filter_map(|o| o.yaw_error_deg).collect()),
        textured_yaw_deg: quantiles(objects.iter().filter_map(|o| o.yaw_error_deg).collect()),
        position_m: quantiles(objects.iter().filter_map(|o| o.position_error_m).collect()),
        scale: quantiles(objects.iter().map(|o| o.scale_error).collect()),
        order_zero_share: share(order_zero, objects.len()),
        excluded_share: share(leaning + same + textured, objects.len() - order_zero),
        leaning_share: share(leaning, objects.len()),
        indistinguishable_share: share(same, objects.len()),
        only_texture_tells_share: share(textured, objects.len()),
        wrong_sides: objects.iter().filter(wrong_side).count(),
        hidden_share: share(objects.iter().filter(|o| o.visible_share < 0.9).count(), objects.len()),
        max_hidden: objects.iter().map(|o| 1.0 - o.visible_share).fold(0.0, f64::max),
        ablation: vec![
            collisions("full", scenes, |scene| &scene.ablation.full),
            collisions("w/o DRO", scenes, |scene| &scene.ablation.without_dro),
            collisions("w/o TSA", scenes, |scene| &scene.ablation.without_tsa),
            collisions("w/o both", scenes, |scene| &scene.ablation.without_both),
        ],
    }
}

fn collisions(
    variation: &'static str,
    scenes: &[&SceneScore],
    of: impl Fn(&SceneScore) -> &super::ablation::Collisions,
) -> Collisions {
    let count = scenes.len().max(1) as f64;
    let hit = scenes.iter().filter(|scene| !of(scene).colliding.is_empty()).count();
    let share = |scene: &&SceneScore| of(scene).colliding.len() as f64 / of(scene).pairs.max(1) as f64;
    let col_o = scenes.iter().map(share).sum::<f64>() / count;
    Collisions { variation, col_s: hit as f64 / count, col_o }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_occurred() {
        let found = quantiles((1..=100).rev().map(f64::from).collect()).expect("a hundred");
        assert_eq!((found.median, found.p95, found.worst), (50.0, 95.0, 100.0));
        let one = quantiles(vec![3.0]).expect("one");
        assert_eq!((one.count, one.median, one.p95, one.worst), (1, 3.0, 3.0, 3.0));
        assert_eq!(quantiles(Vec::new()), None);
    }
}
