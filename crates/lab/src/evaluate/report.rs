//! The tables of the layout benchmark: as Markdown for people, as JSON for programs.

use std::fmt::Write;

use serde::Serialize;

use super::ablation::{PLACE_NOISE_M, SIZE_NOISE_SHARE, YAW_NOISE_RAD};
use super::layout::{CameraScore, Difficulty, SceneScore};
use super::noise::Noise;
use super::scenes::Family;
use super::score::Standing;
use super::statistics::{Quantiles, Summary, summary};

/// Worst objects that are named for each difficulty.
const WORST: usize = 12;

/// Results of one difficulty.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    pub difficulty: Difficulty,
    /// What was done to what the stages saw; absent where nothing was.
    pub noise: Option<Noise>,
    pub all: Summary,
    pub families: Vec<(Family, Summary)>,
    /// Scenes that could not be painted or placed, and why.
    pub failed: Vec<(String, String)>,
    pub scenes: Vec<SceneScore>,
}

/// Results of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `layout`.
    pub set: &'static str,
    pub version: &'static str,
    /// Scenes of the whole set.
    pub set_size: usize,
    pub sections: Vec<Section>,
}

/// What a difficulty is held to: median and 95 % of yaw in degrees, median position in meters, median scale share.
struct Bars {
    yaw_median_deg: f64,
    yaw_p95_deg: f64,
    position_median_m: f64,
    scale_median: f64,
}

impl Section {
    /// Sums up the scores of a difficulty.
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
            "\nOf the objects {} lean by more than 10 degrees and {} have a front but look the same at every yaw; {} \
             are hidden by more than a tenth, one by {}.",
            percent(self.all.leaning_share),
            percent(self.all.look_the_same_share),
            percent(self.all.hidden_share),
            percent(self.all.most_hidden),
        );
        if let Some(with_them) = self.all.pictured_yaw_deg.filter(|_| self.all.only_pictures_tell_share > 0.0)
        {
            let _ = writeln!(
                text,
                "\nThe meshes wear other pictures than what was painted. Of the objects {} have a yaw that only such \
                 pictures tell: once every material has one color, a yaw more than 10 degrees off looks the same. They are \
                 left out above. With them, {} yaws: median {:.2}, 95 % {:.2} degrees.",
                percent(self.all.only_pictures_tell_share),
                with_them.count,
                with_them.median,
                with_them.p95
            );
        }
        text += &self.paintings();
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

    /// What it took that nothing is hidden by more than the difficulty allows.
    fn paintings(&self) -> String {
        let Some(noise) = self.difficulty.noise() else { return String::new() };
        let again = self.scenes.iter().filter(|scene| scene.paintings > 1).count();
        let objects = self.scenes.iter().flat_map(|scene| &scene.objects);
        let hidden = objects.filter(|object| object.visible_share < noise.least_visible_share).count();
        format!(
            "\n{again} scenes were painted more than once; {hidden} objects are still hidden by more than {}.\n",
            percent(1.0 - noise.least_visible_share)
        )
    }

    /// How far the camera was off as it was recognized, and how far it still is; nothing where it was exact.
    fn cameras(&self) -> String {
        let of = |error: fn(&CameraScore) -> f64| {
            let mut errors: Vec<f64> = self.scenes.iter().map(|scene| error(&scene.camera).abs()).collect();
            errors.sort_by(f64::total_cmp);
            let most = errors.last().copied().unwrap_or(0.0);
            (errors.get(errors.len() / 2).copied().unwrap_or(0.0), most)
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
            .filter(|(_, object)| object.standing == Standing::Scored)
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
    /// The whole report.
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Layout benchmark\n\n");
        let _ = writeln!(
            text,
            "`tabletopgen evaluate --set layout`, tabletopgen {}: {} scenes in the set. Errors are those of `place`, before \
             anything is repaired, against the settled poses of the painting; yaws against the nearest that looks the \
             same in the true picture, 180 degrees for a mesh stood on a side on which none does.\n\nIn the ablation a removed \
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

/// What the layout is held to; the noisy bars are those of the noise without the camera's error.
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
