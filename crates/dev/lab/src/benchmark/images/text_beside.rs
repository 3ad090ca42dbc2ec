//! Texts beside images: labels with and without a text that names what the image shows.
//!
//! The text is a list of the catalog objects that count ([`super::score::counts`]), in the order of the alphabet, such
//! as "a table with a mug, a mug, a plate". It names no composites, colors, sizes or places. The program's parser reads
//! it. A named object is right if its label is the one of the truth.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::ImageResult;
use super::score::{ObjectScore, counts};
use crate::synthetic_images::ImageTruth;
use embedded::analyst::describe;
use embedded::text_parser::TextParserSettings;
use ports::RecognitionHints;
use scene::request::RequestOptions;

/// The text for an image; `None` if no catalog object counts.
pub fn text(truth: &ImageTruth) -> Option<String> {
    let shown = truth.objects.iter().filter(|object| !object.is_composite && counts(object, truth));
    let categories = shown.filter_map(|object| catalog::category(&object.name));
    let mut labels: Vec<&str> = categories.map(|category| category.label.as_str()).collect();
    labels.sort_unstable();
    let article = |label: &str| if label.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    let listed: Vec<String> = labels.iter().map(|label| format!("{} {label}", article(label))).collect();
    (!listed.is_empty()).then(|| format!("a table with {}", listed.join(", ")))
}

/// Hints that the parser derives from the text.
pub fn hints(truth: &ImageTruth, parser: &TextParserSettings) -> Option<RecognitionHints> {
    let description = describe(&text(truth)?, truth.number, &RequestOptions::default(), parser).ok()?;
    RecognitionHints::of(&description).ok()
}

/// Labels of detected catalog objects, with and without text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LabelCounts {
    pub detected: usize,
    /// By the image alone.
    pub labeled: usize,
    pub right: usize,
    /// With the text.
    pub labeled_with_text: usize,
    pub right_with_text: usize,
}

/// Labels of a run, by the group of the object.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TextSummary {
    pub images: usize,
    /// `categories`: objects of the catalog. `composites`: objects that the text does not name.
    pub groups: BTreeMap<&'static str, LabelCounts>,
    /// Regions that are no object, and those among them that the text named.
    pub false_positives: usize,
    pub named_false_positives: usize,
}

impl TextSummary {
    pub fn new(images: &[ImageResult]) -> Self {
        let mut summary = Self { images: images.len(), ..Self::default() };
        for image in images {
            summary.false_positives += image.score.false_positives;
            summary.named_false_positives += image.score.named_false_positives;
            for object in &image.score.objects {
                summary.groups.entry(group(object)).or_default().add(object);
            }
        }
        summary
    }

    pub fn markdown(&self) -> String {
        let mut text = format!(
            "\nLabels beside a text that lists the catalog objects, {} images. Right: the label is the category.\n\n\
             | | detected | labeled, image alone | right | labeled with text | right |\n\
             | --- | ---: | ---: | ---: | ---: | ---: |\n",
            self.images
        );
        for (name, LabelCounts { detected, labeled, right, labeled_with_text, right_with_text }) in
            &self.groups
        {
            let share =
                |count: usize| format!("{count} ({:.1} %)", 100.0 * count as f64 / (*detected).max(1) as f64);
            let _ = writeln!(
                text,
                "| {name} | {detected} | {} | {} | {} | {} |",
                share(*labeled),
                share(*right),
                share(*labeled_with_text),
                share(*right_with_text)
            );
        }
        let _ = writeln!(
            text,
            "\nOf {} regions that are no object, {} got a name of the text.",
            self.false_positives, self.named_false_positives
        );
        text
    }
}

impl LabelCounts {
    fn add(&mut self, object: &ObjectScore) {
        let is_right = |label: Option<&'static str>| label.is_some_and(|label| label == object.name);
        self.detected += 1;
        self.labeled += usize::from(object.label.is_some());
        self.right += usize::from(is_right(object.label));
        self.labeled_with_text += usize::from(object.label_with_text.is_some());
        self.right_with_text += usize::from(is_right(object.label_with_text));
    }
}

fn group(object: &ObjectScore) -> &'static str {
    match catalog::category(&object.name) {
        Some(_) => "categories",
        None => "composites",
    }
}
