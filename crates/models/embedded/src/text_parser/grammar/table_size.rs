//! Sizes of the table that a heading states: "Table dimensions: 1.5 m by 0.8 m".

use super::Parser;
use crate::text_parser::measures::read_measure;
use crate::text_parser::phrase::noun_phrase;

impl Parser<'_, '_> {
    /// A heading with the size of the table. Whether the rule applies.
    pub(super) fn table_size(&mut self) -> bool {
        let start = self.at;
        let noun = start + usize::from(self.word(0) == Some("the"));
        let of = [
            "dimensions of the table",
            "size of the table",
            "measurements of the table",
            "dimensions of the desk",
            "size of the desk",
        ];
        let inverted = self.longest(&of, noun);
        let table = if inverted > 0 { noun + inverted - 1 } else { noun };
        let is_table = matches!(
            self.word_at(table),
            Some("table" | "desk" | "tabletop" | "workbench" | "bench" | "counter" | "countertop")
        );
        let names = ["dimensions", "size", "measurements", "surface size", "top size"];
        let named = if inverted > 0 { 0 } else { self.longest(&names, table + 1) };
        let end = table + 1 + named;
        if !is_table || inverted + named == 0 {
            return false;
        }
        let links = ["is", "are", "of", "is about", "should be", "must be"];
        let link = self.longest(&links, end) + usize::from(self.is_colon(end));
        let Some((reading, length)) = read_measure(self.lexicon.vocabulary, self.tokens, end + link) else {
            return false;
        };
        let tokens = &self.tokens[..table + 1];
        let Some((mut phrase, _)) =
            noun_phrase(self.lexicon, tokens, table).filter(|(phrase, _)| phrase.is_table())
        else {
            return false;
        };
        let size = end + link..end + link + length;
        let property = phrase.attributes.add_reading(reading);
        phrase.properties.push((property, size.clone()));
        self.parsed.account.used(start..size.end);
        self.at = size.end;
        self.table(None, phrase);
        true
    }
}
