//! Bar charts as inline SVG: columns for histograms, rows for names. Axes have titles with units and round ticks.

use super::distribution::Distribution;
use markup::html::Html;

/// Width of all charts, in units of the drawing.
const WIDTH: f64 = 680.0;

/// A chart of counts.
pub struct Chart<'a> {
    pub title: &'a str,
    /// Quantity of the bars, with its unit.
    pub axis: &'a str,
    /// Counted items.
    pub counted: &'a str,
}

/// Labels below the columns of a histogram.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ticks {
    /// The lower edge of each bin, below its column: whole numbers.
    Columns,
    /// Every edge, between columns.
    Edges,
}

impl Chart<'_> {
    /// A histogram as vertical columns of equal width.
    pub fn columns(&self, page: &mut Html, distribution: &Distribution, ticks: Ticks) {
        const HEIGHT: f64 = 300.0;
        const LEFT: f64 = 70.0;
        const TOP: f64 = 44.0;
        const BOTTOM: f64 = 236.0;
        let counts = &distribution.counts;
        let right = WIDTH - 20.0;
        self.open(page, HEIGHT);
        let (step, high) = scale(counts.iter().copied().max().unwrap_or(0));
        let y = |value: f64| BOTTOM - (BOTTOM - TOP) * value / high;
        for k in 0..=(high / step).round() as usize {
            let value = k as f64 * step;
            line(page, [LEFT, y(value)], [right, y(value)], "grid");
            text(page, [LEFT - 8.0, y(value) + 4.0], "tick end", &number(value));
        }
        let pitch = (right - LEFT) / counts.len().max(1) as f64;
        // Labels keep 34 units apart.
        let stride = (34.0 / pitch).ceil().max(1.0) as usize;
        for (k, count) in counts.iter().enumerate() {
            let x = LEFT + pitch * k as f64;
            let top = y(*count as f64);
            rectangle(page, [x + 0.06 * pitch, top], [0.88 * pitch, BOTTOM - top]);
            if *count > 0 && pitch >= 22.0 {
                text(page, [x + pitch / 2.0, top - 5.0], "value mid", &count.to_string());
            }
        }
        let labels = match ticks {
            Ticks::Columns => counts.len(),
            Ticks::Edges => distribution.edges.len(),
        };
        for k in (0..labels).step_by(stride) {
            let shift = if ticks == Ticks::Columns { 0.5 } else { 0.0 };
            let x = LEFT + pitch * (k as f64 + shift);
            if ticks == Ticks::Edges {
                line(page, [x, BOTTOM], [x, BOTTOM + 5.0], "axis");
            }
            text(page, [x, BOTTOM + 19.0], "tick mid", &number(distribution.edges[k]));
        }
        line(page, [LEFT, BOTTOM], [right, BOTTOM], "axis");
        text(page, [(LEFT + right) / 2.0, BOTTOM + 46.0], "title mid", self.axis);
        let turn = format!("rotate(-90 20 {:.1})", (TOP + BOTTOM) / 2.0);
        let y = format!("{:.1}", (TOP + BOTTOM) / 2.0);
        let attributes = [("x", "20"), ("y", y.as_str()), ("class", "title mid"), ("transform", &turn)];
        page.leaf("text", &attributes, self.counted);
        page.close();
    }

    /// Counts by name as horizontal bars, in the order given.
    pub fn rows(&self, page: &mut Html, bars: &[(String, usize)]) {
        const LEFT: f64 = 210.0;
        const TOP: f64 = 56.0;
        const PITCH: f64 = 22.0;
        let bottom = TOP + PITCH * bars.len().max(1) as f64;
        let right = WIDTH - 60.0;
        self.open(page, bottom + 56.0);
        let (step, high) = scale(bars.iter().map(|(_, count)| *count).max().unwrap_or(0));
        let x = |value: f64| LEFT + (right - LEFT) * value / high;
        for k in 0..=(high / step).round() as usize {
            let value = k as f64 * step;
            line(page, [x(value), TOP], [x(value), bottom], "grid");
            text(page, [x(value), bottom + 18.0], "tick mid", &number(value));
        }
        for (k, (name, count)) in bars.iter().enumerate() {
            let y = TOP + PITCH * k as f64;
            rectangle(page, [LEFT, y + 3.0], [x(*count as f64) - LEFT, PITCH - 6.0]);
            text(page, [LEFT - 8.0, y + 15.5], "tick end", &shortened(name));
            text(page, [x(*count as f64) + 6.0, y + 15.5], "value", &count.to_string());
        }
        line(page, [LEFT, TOP], [LEFT, bottom], "axis");
        text(page, [(LEFT + right) / 2.0, bottom + 44.0], "title mid", self.counted);
        // Above the names, where charts with few bars have room for it.
        text(page, [LEFT - 8.0, TOP - 8.0], "title end", self.axis);
        page.close();
    }

    fn open(&self, page: &mut Html, height: f64) {
        let view_box = format!("0 0 {WIDTH:.0} {height:.0}");
        let attributes = [
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("class", "chart"),
            ("viewBox", view_box.as_str()),
            ("role", "img"),
            ("aria-label", self.title),
        ];
        page.open("svg", &attributes);
        text(page, [WIDTH / 2.0, 20.0], "heading mid", self.title);
    }
}

fn text(page: &mut Html, at: [f64; 2], class: &str, words: &str) {
    let (x, y) = (format!("{:.1}", at[0]), format!("{:.1}", at[1]));
    page.leaf("text", &[("x", &x), ("y", &y), ("class", class)], words);
}

fn line(page: &mut Html, from: [f64; 2], to: [f64; 2], class: &str) {
    let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(|value| format!("{value:.1}"));
    page.void("line", &[("x1", &x1), ("y1", &y1), ("x2", &x2), ("y2", &y2), ("class", class)]);
}

fn rectangle(page: &mut Html, at: [f64; 2], size: [f64; 2]) {
    let [x, y, width, height] = [at[0], at[1], size[0], size[1]].map(|value| format!("{value:.1}"));
    page.void("rect", &[("x", &x), ("y", &y), ("width", &width), ("height", &height), ("class", "bar")]);
}

/// A round distance of ticks, and the end of an axis that holds `max`: at most six ticks, whole numbers.
fn scale(max: usize) -> (f64, f64) {
    let max = max.max(1) as f64;
    let decade = 10_f64.powf((max / 5.0).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| (step * decade).max(1.0));
    let step = steps.into_iter().find(|step| max / step <= 5.0).unwrap_or(steps[3]);
    (step, step * (max / step).ceil())
}

/// A number without trailing zeros.
fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    format!("{rounded}")
}

fn shortened(name: &str) -> String {
    const MAX: usize = 24;
    if name.chars().count() <= MAX {
        return name.to_owned();
    }
    let start: String = name.chars().take(MAX - 1).collect();
    format!("{start}…")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_a_round_number_that_holds_the_largest_value() {
        assert_eq!(
            [0, 1, 3, 7, 48, 1000].map(scale),
            [(1.0, 1.0), (1.0, 1.0), (1.0, 3.0), (2.0, 8.0), (10.0, 50.0), (200.0, 1000.0)]
        );
    }

    #[test]
    fn a_chart_has_a_title_both_axes_and_a_bar_per_bin() {
        let mut page = Html::default();
        let chart = Chart { title: "Masses", axis: "mass, kg", counted: "objects" };
        chart.columns(
            &mut page,
            &Distribution::of("kg", &[0.0, 1.0, 2.0], vec![0.5, 1.5, 1.6]),
            Ticks::Edges,
        );
        let text = page.finish();
        for words in ["aria-label=\"Masses\"", ">mass, kg</text>", ">objects</text>", ">2</text>"] {
            assert!(text.contains(words), "{words} in {text}");
        }
        assert_eq!(text.matches("<rect").count(), 2);
    }

    #[test]
    fn long_names_are_shortened() {
        assert_eq!(shortened("mug"), "mug");
        assert_eq!(shortened(&"a".repeat(40)).chars().count(), 24);
    }
}
