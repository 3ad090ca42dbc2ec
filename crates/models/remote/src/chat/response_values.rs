//! Validated values of answers: texts, numbers, names, colors and boxes, with the violations they cause.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use geometry::Rgb;
use scene::InstanceId;

/// Maximum length of a label, characters.
const MAX_LABEL_CHARS: usize = 80;

/// Violations in an answer, which the repair turn reports to the model.
#[derive(Debug, Default)]
pub struct Complaints(Vec<String>);

impl Complaints {
    pub fn add(&mut self, complaint: impl Into<String>) {
        // The first few suffice for a repair.
        if self.0.len() < 20 {
            self.0.push(complaint.into());
        }
    }

    /// `value` where there are no violations.
    pub fn none_or<T>(self, value: T) -> Result<T, Vec<String>> {
        if self.0.is_empty() { Ok(value) } else { Err(self.0) }
    }

    /// Requires a number within a range.
    pub fn range(&mut self, at: &str, number: f64, low: f64, high: f64) {
        if !(low..=high).contains(&number) {
            self.add(format!("{at} is {number}; it must be from {low} to {high}"));
        }
    }

    /// Requires a non-empty text of bounded length without control characters.
    pub fn plain(&mut self, at: &str, text: &str, max_chars: usize) {
        let chars = text.chars().count();
        if text.trim().is_empty() || chars > max_chars || text.chars().any(char::is_control) {
            self.add(format!("{at} must be plain text of 1 to {max_chars} characters"));
        }
    }

    pub fn label(&mut self, at: &str, text: &str) {
        self.plain(at, text, MAX_LABEL_CHARS);
    }

    /// Requires `#rrggbb` or no color.
    pub fn color(&mut self, at: &str, text: Option<&str>) -> Option<Rgb> {
        let text = text?;
        let color = hex_color(text);
        if color.is_none() {
            self.add(format!("{at} is {:?}; it must be a color such as #c03020, or null", clipped(text)));
        }
        color
    }

    /// Requires unique valid names; returns the index of each.
    pub fn names<'a>(&mut self, names: impl Iterator<Item = &'a str>) -> BTreeMap<&'a str, usize> {
        let mut indices = BTreeMap::new();
        for (index, name) in names.enumerate() {
            if name == "table" || InstanceId::new(name).is_err() {
                let name = clipped(name);
                self.add(format!(
                    "{name:?} is no name: use lower-case letters, digits and underscores, a letter first, at most 63, \
                     and not `table`"
                ));
            } else if indices.insert(name, index).is_some() {
                self.add(format!("the name {name} is given to two objects; give each its own"));
            }
        }
        indices
    }

    /// Requires the names `asked`, in any order; returns the index of the answer for each of them.
    pub fn answers<'a>(
        &mut self,
        asked: &[InstanceId],
        answered: impl Iterator<Item = &'a str>,
    ) -> Vec<usize> {
        let indices = self.names(answered);
        let found: Vec<Option<usize>> = asked.iter().map(|id| indices.get(id.as_str()).copied()).collect();
        for (id, _) in asked.iter().zip(&found).filter(|(_, index)| index.is_none()) {
            self.add(format!("{id} is missing; answer for every name that was given"));
        }
        for name in indices.keys().filter(|name| asked.iter().all(|id| id.as_str() != **name)) {
            self.add(format!("{name} was not asked about; leave it out"));
        }
        found.into_iter().flatten().collect()
    }
}

/// Three extents of an answer.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
pub struct Extents {
    pub width_m: f64,
    pub depth_m: f64,
    pub height_m: f64,
}

impl Extents {
    pub fn size_m(self) -> DVec3 {
        DVec3::new(self.width_m, self.depth_m, self.height_m)
    }
}

/// A box of an answer, in thousandths of the image size.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
pub struct ImageBox {
    pub x0: f64,
    pub y0: f64,
    pub x1: f64,
    pub y1: f64,
}

impl ImageBox {
    /// x0, y0, x1, y1 in pixels on an image of this size.
    pub fn in_pixels(self, width_px: u32, height_px: u32) -> [f64; 4] {
        let (width, height) = (f64::from(width_px) / 1000.0, f64::from(height_px) / 1000.0);
        [self.x0 * width, self.y0 * height, self.x1 * width, self.y1 * height]
    }

    pub fn check(self, at: &str, low: f64, high: f64, complaints: &mut Complaints) {
        for (name, value) in [("x0", self.x0), ("y0", self.y0), ("x1", self.x1), ("y1", self.y1)] {
            complaints.range(&format!("{at}.{name}"), value, low, high);
        }
        if !(self.x0 < self.x1 && self.y0 < self.y1) {
            complaints.add(format!("{at} is empty: x0 < x1 and y0 < y1 must hold"));
        }
    }
}

/// Parses `#rrggbb`.
pub fn hex_color(text: &str) -> Option<Rgb> {
    let digits = text
        .strip_prefix('#')
        .filter(|digits| digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit()))?;
    u32::from_str_radix(digits, 16).ok().map(Rgb::hex)
}

/// The indices whose chain of supports `carried` (an index, `None` = the table) never reaches the table.
pub fn cyclic(carried: &[Option<usize>]) -> Vec<usize> {
    let ends = |start: usize| {
        let mut at = Some(start);
        for _ in 0..=carried.len() {
            match at {
                Some(here) => at = carried.get(here).copied().flatten(),
                None => return true,
            }
        }
        false
    };
    (0..carried.len()).filter(|start| !ends(*start)).collect()
}

pub(super) fn clipped(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_color_requires_six_hexadecimal_digits() {
        assert_eq!(hex_color("#ff0000"), Some(Rgb([1.0, 0.0, 0.0])));
        for bad in ["ff0000", "#ff000", "#ff00000", "#gg0000", "red", "#+f0000", "#éa000"] {
            assert_eq!(hex_color(bad), None, "{bad}");
        }
    }

    #[test]
    fn cyclic_finds_cycles_and_accepts_trees() {
        assert!(cyclic(&[None, Some(0), Some(1)]).is_empty());
        assert_eq!(cyclic(&[Some(1), Some(0), None, Some(0)]), [0, 1, 3]);
        assert_eq!(cyclic(&[Some(0)]), [0]);
    }

    #[test]
    fn answers_rejects_missing_and_unknown_names() {
        let asked: Vec<InstanceId> =
            ["mug_1", "bowl_1"].map(|name| InstanceId::new(name).expect(name)).into();
        let mut complaints = Complaints::default();
        assert_eq!(complaints.answers(&asked, ["bowl_1", "mug_1"].into_iter()), [1, 0]);
        assert!(complaints.none_or(()).is_ok());
        let mut complaints = Complaints::default();
        complaints.answers(&asked, ["bowl_1", "bowl_1", "Robert'); --", "cup_1"].into_iter());
        let message = complaints.none_or(()).expect_err("complains").join("\n");
        for part in ["two objects", "no name", "mug_1 is missing", "cup_1 was not asked about"] {
            assert!(message.contains(part), "{message}");
        }
    }
}
