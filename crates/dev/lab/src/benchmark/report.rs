//! Report of the layout benchmark, as Markdown and JSON.

use std::fmt::Write;

use serde::Serialize;

use super::ablation::{PLACE_NOISE_M, SIZE_NOISE_SHARE, YAW_NOISE_RAD};
use super::layout::{CameraScore, Difficulty, SceneScore};
use super::noise::Noise;
use super::scenes::Family;
use super::score::YawStatus;
use super::statistics::{Quantiles, Summary, summary};

/// Number of worst objects listed per difficulty.
const WORST: usize = 12;

/// Results of one difficulty.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    pub difficulty: Difficulty,
    /// Noise of the stage inputs; absent without noise.
    pub noise: Option<Noise>,
    pub all: Summary,
    pub families: Vec<(Family, Summary)>,
    /// Scenes that failed, with the reason.
    pub failed: Vec<(String, String)>,
    pub scenes: Vec<SceneScore>,
}

/// Results of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `layout`.
    pub set: &'static str,
    pub version: &'static str,
    /// Number of scenes of the whole set.
    pub set_size: usize,
    pub sections: Vec<Section>,
}

/// Target values of a difficulty: median and 95 % of yaw in degrees, median position in meters, median scale share.
struct Bars {
    yaw_median_deg: f64,
    yaw_p95_deg: f64,
    position_median_m: f64,
    scale_median: f64,
}

impl Section {
    /// Summarizes the scores of a difficulty.
    pub fn new(difficulty: Difficulty, scenes: Vec<SceneScore>, failed: Vec<(String, String)>) -> Self {
        let all: Vec<&SceneScore> = scenes.iter().collect();
        let families = Family::ALL
            .into_iter()
            .map(|family| (family, all.iter().copied().filter(|s| s.family == family).collect::<Vec<_>>()))
            .filter(|(_, of)| !of.is_empty())
            .map(|(family, of)| (family, summary(&of)))
            .collect();
        Self { difficulty, noise: difficulty.noise(), all: summary(&all), families, failed, scenes }
    }

    fn markdown(&self) -> String {
        let mut text = format!("## {}\n\n", capitalized(self.difficulty.name()));
        text += "| | scenes | objects | yaw deg, median | 95 % | position mm, median | 95 % | scale %, median \
                 | 95 % | order 0 | left out | wrong side |\n";
        text += "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
        text += &row("all", &self.all);
        for (family, of) in &self.families {
            text += &row(family.name(), of);
        }
        let bars = bars(self.difficulty);
        if let Some(bars) = &bars {
            let _ = writeln!(
                text,
                "| bar | | | {} | {} | {} | | {} | | | < 15 % | |",
                bars.yaw_median_deg,
                bars.yaw_p95_deg,
                1e3 * bars.position_median_m,
                100.0 * bars.scale_median
            );
            let missed = self.missed(bars);
            let verdict =
                if missed.is_empty() { "Every bar is met.".to_owned() } else { missed.join("; ") + "." };
            let _ = writeln!(text, "\n{verdict}");
        }
        let _ = writeln!(
            text,
            "\nOf the objects {} lean by more than 10 degrees and {} have a front but the same appearance at every yaw; {} \
             are hidden by more than a tenth, one by {}.",
            percent(self.all.leaning_share),
            percent(self.all.indistinguishable_share),
            percent(self.all.hidden_share),
            percent(self.all.max_hidden),
        );
        if let Some(with_them) = self.all.textured_yaw_deg.filter(|_| self.all.only_texture_tells_share > 0.0)
        {
            let _ = writeln!(
                text,
                "\nThe meshes have other textures than the true ones. Of the objects {} have a yaw that only \
                 textures determine: once every material has one color, a yaw more than 10 degrees off gives the same image. They are \
                 left out above. With them, {} yaws: median {:.2}, 95 % {:.2} degrees.",
                percent(self.all.only_texture_tells_share),
                with_them.count,
                with_them.median,
                with_them.p95
            );
        }
        text += &self.rerenderings();
        text += &self.cameras();
        text += "\nAblation at `place`:\n\n| | Col_S | Col_O |\n| --- | ---: | ---: |\n";
        for line in &self.all.ablation {
            let _ =
                writeln!(text, "| {} | {} | {} |", line.variation, percent(line.col_s), percent(line.col_o));
        }
        for (scene, why) in &self.failed {
            let _ = writeln!(text, "\nNot scored: {scene}: {why}");
        }
        text + &self.worst()
    }

    fn missed(&self, bars: &Bars) -> Vec<String> {
        let mut missed = Vec::new();
        let mut check = |what: &str, is: Option<f64>, bar: f64| {
            if let Some(is) = is.filter(|is| *is > bar) {
                missed.push(format!("Missed: {what} {is:.2}, the bar is {bar}"));
            }
        };
        let (yaw, position, scale) = (self.all.yaw_deg, self.all.position_m, self.all.scale);
        check("median yaw (degrees)", yaw.map(|q| q.median), bars.yaw_median_deg);
        check("95 % of yaws (degrees)", yaw.map(|q| q.p95), bars.yaw_p95_deg);
        check("median position (mm)", position.map(|q| 1e3 * q.median), 1e3 * bars.position_median_m);
        check("median scale (%)", scale.map(|q| 100.0 * q.median), 100.0 * bars.scale_median);
        check("share left out (%)", Some(100.0 * self.all.excluded_share), 15.0);
        missed
    }

    /// Number of rerendered scenes and of objects that are still too occluded.
    fn rerenderings(&self) -> String {
        let Some(noise) = self.difficulty.noise() else { return String::new() };
        let again = self.scenes.iter().filter(|scene| scene.renderings > 1).count();
        let objects = self.scenes.iter().flat_map(|scene| &scene.objects);
        let hidden = objects.filter(|object| object.visible_share < noise.min_visible_share).count();
        format!(
            "\n{again} scenes were rendered more than once; {hidden} objects are still hidden by more than {}.\n",
            percent(1.0 - noise.min_visible_share)
        )
    }

    /// Camera errors as recognized and after refinement; empty for an exact camera.
    fn cameras(&self) -> String {
        let of = |error: fn(&CameraScore) -> f64| {
            let mut errors: Vec<f64> = self.scenes.iter().map(|scene| error(&scene.camera).abs()).collect();
            errors.sort_by(f64::total_cmp);
            let highest = errors.last().copied().unwrap_or(0.0);
            (errors.get(errors.len() / 2).copied().unwrap_or(0.0), highest)
        };
        let (elevation, azimuth) = (of(|c| c.given_elevation_deg), of(|c| c.given_azimuth_deg));
        if elevation.1 < 1e-9 && azimuth.1 < 1e-9 {
            return String::new();
        }
        let (left_elevation, left_azimuth) = (of(|c| c.elevation_deg), of(|c| c.azimuth_deg));
        format!(
            "\nCamera, median and largest error in degrees: elevation {:.2} and {:.2} as recognized, {:.2} and {:.2} \
             refined; azimuth {:.2} and {:.2}, {:.2} and {:.2}.\n",
            elevation.0,
            elevation.1,
            left_elevation.0,
            left_elevation.1,
            azimuth.0,
            azimuth.1,
            left_azimuth.0,
            left_azimuth.1
        )
    }

    fn worst(&self) -> String {
        let mut objects: Vec<_> = self
            .scenes
            .iter()
            .flat_map(|scene| scene.objects.iter().map(move |object| (&scene.scene, object)))
            .filter(|(_, object)| object.yaw_status == YawStatus::Scored)
            .filter_map(|(scene, object)| object.yaw_error_deg.map(|error| (error, scene, object)))
            .collect();
        objects.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut text = String::from(
            "\nLargest yaw errors:\n\n| scene | object | yaw deg | wrong side | visible | loss | confidence |\n\
             | --- | --- | ---: | --- | ---: | ---: | ---: |\n",
        );
        for (error, scene, object) in objects.into_iter().take(WORST) {
            let _ = writeln!(
                text,
                "| {scene} | {} | {error:.1} | {} | {} | {:.4} | {:.2} |",
                object.name,
                if object.wrong_side { "yes" } else { "" },
                percent(object.visible_share),
                object.loss,
                object.confidence
            );
        }
        text
    }
}

impl Report {
    /// The whole report as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Layout benchmark\n\n");
        let _ = writeln!(
            text,
            "`tabletopgen-lab evaluate --set layout`, tabletopgen {}: {} scenes in the set. Errors are those of `place`, before \
             anything is repaired, against the settled poses of the rendering; yaws against the nearest with the \
             same appearance in the true image, 180 degrees for a mesh stood on a side on which none does.\n\nIn the ablation a removed \
             stage is replaced by the truth with noise: yaws within {:.0} degrees; places within {:.0} mm and sizes \
             within {:.0} %.\n",
            self.version,
            self.set_size,
            YAW_NOISE_RAD.to_degrees(),
            1e3 * PLACE_NOISE_M,
            100.0 * SIZE_NOISE_SHARE
        );
        text + &self.sections.iter().map(Section::markdown).collect::<Vec<_>>().join("\n")
    }
}

/// Target values of the layout; the noisy ones apply to noise without the camera error.
fn bars(difficulty: Difficulty) -> Option<Bars> {
    match difficulty {
        Difficulty::Clean => {
            Some(Bars { yaw_median_deg: 0.5, yaw_p95_deg: 3.0, position_median_m: 0.005, scale_median: 0.02 })
        }
        Difficulty::Noisy => Some(Bars {
            yaw_median_deg: 3.0,
            yaw_p95_deg: 10.0,
            position_median_m: 0.015,
            scale_median: 0.08,
        }),
        Difficulty::NoisyExactCamera => None,
    }
}

fn row(name: &str, of: &Summary) -> String {
    let pair = |quantiles: Option<Quantiles>, unit: f64, digits: usize| match quantiles {
        Some(q) => format!("{:.digits$} | {:.digits$}", unit * q.median, unit * q.p95),
        None => "- | -".to_owned(),
    };
    format!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        of.scenes,
        of.objects,
        pair(of.yaw_deg, 1.0, 2),
        pair(of.position_m, 1e3, 1),
        pair(of.scale, 100.0, 2),
        percent(of.order_zero_share),
        percent(of.excluded_share),
        of.wrong_sides
    )
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn capitalized(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
