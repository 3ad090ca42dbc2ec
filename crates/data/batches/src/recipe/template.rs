//! Templates: texts with slots in braces.

/// A text with slots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Template {
    parts: Vec<Part>,
    /// Numbers of the slots that it uses, each once, in the order of their first place.
    pub(super) slots: Vec<usize>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(String),
    /// Index into `slots` of the template.
    Slot(usize),
}

/// The reason why a text is no template. Columns count characters from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum TemplateError {
    #[error("is empty; describe a table and what lies on it")]
    Empty,
    #[error("has a `}}` at character {column} that closes nothing")]
    ClosesNothing { column: usize },
    #[error("has a `{{` at character {column} that is not closed")]
    NotClosed { column: usize },
    #[error("uses the slot {name:?}, which has no values in `slots` (character {column})")]
    UnknownSlot { name: String, column: usize },
}

impl Template {
    /// Reads a template; `slot_of` is the number of a slot by its name.
    pub(super) fn parse(
        text: &str,
        mut slot_of: impl FnMut(&str) -> Option<usize>,
    ) -> Result<Self, TemplateError> {
        if !text.contains(char::is_alphanumeric) {
            return Err(TemplateError::Empty);
        }
        let mut template = Self { parts: Vec::new(), slots: Vec::new() };
        let mut rest = text;
        let column = |rest: &str| text[..text.len() - rest.len()].chars().count() + 1;
        while let Some(open) = rest.find(['{', '}']) {
            let (before, from_brace) = rest.split_at(open);
            if from_brace.starts_with('}') {
                return Err(TemplateError::ClosesNothing { column: column(from_brace) });
            }
            let inside = &from_brace[1..];
            let close = match inside.find(['{', '}']) {
                Some(close) if inside[close..].starts_with('}') => close,
                _ => return Err(TemplateError::NotClosed { column: column(from_brace) }),
            };
            let name = inside[..close].trim();
            let slot = slot_of(name).ok_or_else(|| {
                let column = column(from_brace);
                TemplateError::UnknownSlot { name: name.to_owned(), column }
            })?;
            let place = template.slots.iter().position(|known| *known == slot).unwrap_or_else(|| {
                template.slots.push(slot);
                template.slots.len() - 1
            });
            template.parts.push(Part::Text(before.to_owned()));
            template.parts.push(Part::Slot(place));
            rest = &inside[close + 1..];
        }
        template.parts.push(Part::Text(rest.to_owned()));
        Ok(template)
    }

    /// The text with values in its slots; `value` has the index into `slots`.
    pub(super) fn filled<'a>(&self, value: impl Fn(usize) -> &'a str) -> String {
        let texts = self.parts.iter().map(|part| match part {
            Part::Text(text) => text.as_str(),
            Part::Slot(place) => value(*place),
        });
        texts.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Template, TemplateError> {
        Template::parse(text, |name| ["color", "item"].iter().position(|slot| *slot == name))
    }

    #[test]
    fn slots_are_filled_wherever_they_stand() {
        for (text, slots, expected) in [
            ("a mug", vec![], "a mug"),
            ("{item}", vec![1], "VALUE0"),
            ("a { color } {item}", vec![0, 1], "a VALUE0 VALUE1"),
            ("{item} and {color} {item}", vec![1, 0], "VALUE0 and VALUE1 VALUE0"),
        ] {
            let template = parse(text).expect(text);
            assert_eq!(template.slots, slots, "{text}");
            assert_eq!(template.filled(|k| ["VALUE0", "VALUE1"][k]), expected);
        }
    }

    #[test]
    fn wrong_templates_state_the_place() {
        for (text, says) in [
            ("  ", "is empty"),
            ("é {color", "`{` at character 3 that is not closed"),
            ("a color} mug", "`}` at character 8"),
            ("a {{color}} mug", "`{` at character 3"),
            ("a {size} mug", "uses the slot \"size\", which has no values in `slots` (character 3)"),
            ("a {} mug", "uses the slot \"\", which has no values in `slots` (character 3)"),
        ] {
            let detail = parse(text).expect_err(text).to_string();
            assert!(detail.contains(says), "{text}: {detail}");
        }
    }
}
