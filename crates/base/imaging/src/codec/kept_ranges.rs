//! Parts of a file that are kept, joined where they touch. Without gaps, nothing is copied.

use std::borrow::Cow;
use std::ops::Range;

/// Ascending ranges of a file.
pub(super) struct KeptRanges<'a> {
    file: &'a [u8],
    ranges: Vec<Range<usize>>,
}

impl<'a> KeptRanges<'a> {
    pub fn new(file: &'a [u8]) -> Self {
        Self { file, ranges: Vec::new() }
    }

    /// Adds a range that starts at or after the end of the one before.
    pub fn keep(&mut self, range: Range<usize>) {
        match self.ranges.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => self.ranges.push(range),
        }
    }

    /// The kept bytes, in their order.
    pub fn into_bytes(self) -> Cow<'a, [u8]> {
        match self.ranges.as_slice() {
            [only] => Cow::Borrowed(&self.file[only.clone()]),
            ranges => {
                Cow::Owned(ranges.iter().flat_map(|range| &self.file[range.clone()]).copied().collect())
            }
        }
    }
}
