//! Stable codes of rejected texts, and the words that are not known.

use super::DescribeError;

impl DescribeError {
    /// The stable error code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Empty => "text_empty",
            Self::TooLong { .. } => "text_too_long",
            Self::NothingRecognized { .. } => "nothing_recognized",
            Self::NotEnglish { .. } => "not_english",
            Self::NotUnderstood { .. } => "not_understood",
            Self::TooManyObjects { .. } => "too_many_objects",
            Self::UnknownTableModel { .. } => "unknown_table_model",
        }
    }

    /// The words of the text that are not known; empty if the text is rejected for another reason.
    pub fn terms(&self) -> &[String] {
        match self {
            Self::NothingRecognized { terms, .. } => terms,
            Self::NotEnglish { words } => words,
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_those_of_unknown_words_only() {
        let unknown =
            DescribeError::NothingRecognized { terms: vec!["zorblax".into()], suggestions: Vec::new() };
        assert_eq!((unknown.code(), unknown.terms()), ("nothing_recognized", &["zorblax".to_owned()][..]));
        assert_eq!((DescribeError::Empty.code(), DescribeError::Empty.terms().len()), ("text_empty", 0));
    }
}
