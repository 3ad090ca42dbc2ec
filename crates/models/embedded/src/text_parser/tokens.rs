//! The tokenizer: splits a text into lower-case words, numbers and pauses, with their positions in the text.
//!
//! Total over all Unicode input: characters other than letters, digits and known marks separate words.
//! Common accents fold to their base letter; apostrophes are removed ("rubik's" = "rubiks"); hyphens split.

use std::ops::Range;

use super::lexicon::{Lexicon, Meaning};

/// A word, a number or a pause of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Word(String),
    Number(f64),
    /// Comma, colon, bracket, dash: a pause inside a sentence.
    Pause,
    /// Period, semicolon, line break: the end of a sentence.
    End,
}

impl Token {
    pub fn word(&self) -> Option<&str> {
        match self {
            Self::Word(word) => Some(word),
            _ => None,
        }
    }
}

/// A text and its tokens.
#[derive(Clone, Debug, Default)]
pub(super) struct Source {
    pub text: String,
    pub tokens: Vec<Token>,
    /// Bytes of the text that each token covers.
    pub spans: Vec<Range<usize>>,
    /// Bytes of the numbers of list items ("1)") and of the keys of JSON, which are no tokens.
    pub markers: Vec<Range<usize>>,
}

impl Source {
    pub fn read(text: &str) -> Self {
        let characters: Vec<Character> = text
            .char_indices()
            .flat_map(|(at, c)| {
                let span = at..at + c.len_utf8();
                c.to_lowercase().map(move |c| Character { c, span: span.clone() })
            })
            .collect();
        let mut source = Self { text: text.to_owned(), ..Self::default() };
        Reader { characters: &characters, at: 0, source: &mut source }.read();
        source
    }

    /// Whether the text writes the token with a capital letter.
    pub fn is_capitalized(&self, token: usize) -> bool {
        let span = self.spans.get(token).cloned().unwrap_or_default();
        self.text[span].chars().next().is_some_and(char::is_uppercase)
    }

    pub fn push(&mut self, token: Token, span: Range<usize>) {
        self.tokens.push(token);
        self.spans.push(span);
    }

    /// Bytes that the tokens of a range cover.
    pub fn span(&self, tokens: Range<usize>) -> Range<usize> {
        let last = tokens.end.saturating_sub(1).max(tokens.start);
        // The tokens of JSON do not follow the order of the text.
        let spans = self.spans.get(tokens.start..=last).unwrap_or_default();
        let start = spans.iter().map(|span| span.start).min();
        let end = spans.iter().map(|span| span.end).max();
        start.unwrap_or(self.text.len())..end.unwrap_or(self.text.len())
    }

    /// Whether a sentence ends within the tokens.
    pub fn has_end(&self, tokens: Range<usize>) -> bool {
        self.tokens.get(tokens).is_some_and(|tokens| tokens.contains(&Token::End))
    }

    /// "laptop mouse keyboard": a text of bare nouns is a list.
    pub fn separate_bare_nouns(&mut self, lexicon: &Lexicon) {
        let mut starts = Vec::new();
        let mut at = 0;
        while at < self.tokens.len() {
            let Some((entry, length)) = lexicon.longest_at(&self.tokens, at) else { return };
            if !matches!(entry.meanings[0], Meaning::Category(_)) {
                return;
            }
            starts.push(at);
            at += length;
        }
        if starts.len() < 3 {
            return;
        }
        for &start in starts[1..].iter().rev() {
            let span = self.spans[start].start..self.spans[start].start;
            self.tokens.insert(start, Token::Pause);
            self.spans.insert(start, span);
        }
    }

    /// Whether the token is a bracket that opens.
    pub fn is_open_bracket(&self, token: usize) -> bool {
        self.spans.get(token).is_some_and(|span| matches!(&self.text[span.clone()], "(" | "["))
    }

    /// The token after a quotation that begins at a token.
    pub fn quotation(&self, first: usize) -> Option<usize> {
        let is_quote = |c: char| matches!(c, '"' | '\'' | '“' | '”' | '‘' | '’' | '«' | '»');
        let opens = |token: usize| self.text[..self.spans.get(token)?.start].chars().next_back();
        let closes = |token: usize| self.text[self.spans.get(token)?.end..].chars().next();
        opens(first).filter(|c| is_quote(*c))?;
        // The writing on an object is short.
        (first..first + 8).find(|&token| closes(token).is_some_and(is_quote)).map(|token| token + 1)
    }

    fn pause(&mut self, mark: Token, span: Range<usize>) {
        match self.tokens.last_mut() {
            None => {}
            Some(last @ Token::Pause) if mark == Token::End => *last = Token::End,
            Some(Token::Pause | Token::End) => {}
            Some(_) => self.push(mark, span),
        }
    }
}

#[derive(Clone, Debug)]
struct Character {
    c: char,
    span: Range<usize>,
}

struct Reader<'a> {
    characters: &'a [Character],
    at: usize,
    source: &'a mut Source,
}

/// Second parts of compounds with a hyphen whose first part is no object of the scene.
const NAMES_NOTHING_BEFORE: &[&str] = &[
    "side", "style", "themed", "picking", "packing", "sorting", "making", "cleaning", "handling", "serving",
    "loading", "free", "friendly", "related", "ready", "based",
];

/// Names that begin with a digit.
const NAMES: &[&str] = &["7up", "3d", "9v"];

/// Words after which a period is part of an abbreviation.
const ABBREVIATIONS: &[&str] = &["oz", "cm", "mm", "in", "ft", "lb", "lbs", "kg", "approx", "ca", "ml", "fl"];

impl Reader<'_> {
    fn peek(&self, ahead: usize) -> char {
        self.characters.get(self.at + ahead).map_or(' ', |character| character.c)
    }

    fn previous(&self) -> char {
        if self.at == 0 { '\n' } else { self.characters[self.at - 1].c }
    }

    fn span(&self, length: usize) -> Range<usize> {
        let end = (self.at + length).min(self.characters.len());
        self.characters[self.at].span.start..self.characters[end - 1].span.end
    }

    fn push(&mut self, token: Token, length: usize) {
        let span = self.span(length);
        self.source.push(token, span);
        self.at += length;
    }

    /// Whether this name stands here as a word.
    fn is_name(&self, name: &str) -> bool {
        name.chars().enumerate().all(|(k, c)| self.peek(k) == c)
            && !self.previous().is_alphanumeric()
            && !self.peek(name.len()).is_alphanumeric()
    }

    /// Whether only blanks precede on this line.
    fn at_line_start(&self) -> bool {
        let before = self.characters[..self.at].iter().rev().map(|character| character.c);
        let mut before = before.skip_while(|c| matches!(c, ' ' | '\t'));
        matches!(before.next(), None | Some('\n' | '\r'))
    }

    fn read(&mut self) {
        while self.at < self.characters.len() {
            let c = self.peek(0);
            if let Some(name) = NAMES.iter().find(|name| self.is_name(name)) {
                self.push(Token::Word((*name).to_owned()), name.len());
            } else if c.is_ascii_digit()
                || (c == '.' && self.peek(1).is_ascii_digit() && !self.previous().is_alphanumeric())
            {
                self.number();
            } else if matches!(c, '-' | '−')
                && self.peek(1).is_ascii_digit()
                && matches!(self.previous(), ' ' | '(' | ',' | '=')
                && !self.at_line_start()
            {
                self.at += 1;
                self.number();
                if let Some(Token::Number(number)) = self.source.tokens.last_mut() {
                    *number = -*number;
                }
            } else if c.is_alphabetic() {
                self.words();
            } else {
                self.mark(c);
            }
        }
    }

    /// A number; the number of a list item ("1." at the start of a line, "2)") is no token.
    fn number(&mut self) {
        let (number, length) = read_number(&self.characters[self.at..]);
        let (mark, after) = (self.peek(length), self.peek(length + 1));
        let opened = self.in_brackets();
        let blank = after.is_whitespace();
        if (mark == '.' && blank && self.at_line_start()) || (mark == ')' && blank && !opened && length < 3) {
            let span = self.span(length + 1);
            self.source.markers.push(span.clone());
            self.source.pause(Token::End, span);
            self.at += length + 1;
            return;
        }
        self.push(Token::Number(number), length);
    }

    /// Whether a bracket of this line is open.
    fn in_brackets(&self) -> bool {
        let line = self.characters[..self.at].iter().rev().map(|character| character.c);
        let mut line = line.take_while(|c| !matches!(c, '\n' | '\r')).filter(|c| matches!(c, '(' | ')'));
        line.next() == Some('(')
    }

    fn words(&mut self) {
        let (word, length, apostrophe) = read_word(&self.characters[self.at..]);
        // "w/" and "w/o".
        if word == "w" && self.peek(1) == '/' && !self.peek(2).is_ascii_digit() {
            let without = self.peek(2) == 'o' && !self.peek(3).is_alphanumeric();
            let (word, length) = if without { ("without", 3) } else { ("with", 2) };
            self.push(Token::Word(word.to_owned()), length);
            return;
        }
        // "it's" is "it is".
        if apostrophe
            && let Some(base) = word.strip_suffix('s')
            && matches!(base, "it" | "there" | "that" | "here" | "what" | "who")
        {
            let span = self.span(length);
            self.source.push(Token::Word(base.to_owned()), span.clone());
            self.source.push(Token::Word("is".to_owned()), span);
            self.at += length;
            return;
        }
        // "a sink-side counter", "bin-picking practice": one word, in which no object is named.
        if self.peek(length) == '-' && self.peek(length + 1).is_alphabetic() {
            let (second, second_length, _) = read_word(&self.characters[self.at + length + 1..]);
            if NAMES_NOTHING_BEFORE.contains(&second.as_str()) {
                self.push(Token::Word(format!("{word}{second}")), length + 1 + second_length);
                return;
            }
        }
        if word.is_empty() {
            self.at += length;
        } else {
            self.push(Token::Word(word), length);
        }
    }

    fn mark(&mut self, c: char) {
        let (previous, next) = (self.previous(), self.peek(1));
        let span = self.span(1);
        let is_number = matches!(self.source.tokens.last(), Some(Token::Number(_)));
        let word = |source: &mut Source, word: &str| source.push(Token::Word(word.to_owned()), span.clone());
        match c {
            '-' | '=' if next == '>' => {
                let arrow = self.span(2);
                self.source.pause(Token::Pause, arrow);
                self.at += 1;
            }
            '<' if next == '-' && self.peek(2) == '>' => {
                let arrow = self.span(3);
                self.source.pause(Token::Pause, arrow);
                self.at += 2;
            }
            '→' | '⇒' | '↔' => self.source.pause(Token::Pause, span),
            ',' | ':' | '(' | ')' | '[' | ']' | '—' | '|' => self.source.pause(Token::Pause, span),
            '-' | '–' if previous.is_ascii_digit() && next.is_ascii_digit() => word(self.source, "to"),
            '-' | '–' if self.at_line_start() => {}
            '-' | '–' if previous.is_whitespace() && next.is_whitespace() => {
                self.source.pause(Token::Pause, span);
            }
            '.' if self.is_initial(next) => {}
            '.' if next == ' ' && self.is_abbreviation() => {}
            '.' | ';' | '!' | '?' | '\n' | '\r' | '。' => self.source.pause(Token::End, span),
            '/' if is_number && next.is_ascii_digit() => self.fraction(),
            '&' | '+' | '/' => word(self.source, "and"),
            '½' => self.source.push(Token::Number(0.5), span),
            '@' => word(self.source, "at"),
            '%' if is_number => word(self.source, "percent"),
            '°' if is_number => word(self.source, "degrees"),
            '×' | '*' if is_number => word(self.source, "x"),
            // "30 cm × 20 cm".
            '×' if next.is_ascii_digit() || next.is_whitespace() && self.peek(2).is_ascii_digit() => {
                word(self.source, "x");
            }
            '"' | '″' | '”' if previous.is_ascii_digit() => word(self.source, "inches"),
            _ => {}
        }
        self.at += 1;
    }

    /// Whether the period belongs to "e.g." or "i.e.".
    fn is_initial(&self, next: char) -> bool {
        let word = |back: usize| {
            self.source.tokens.len().checked_sub(back).and_then(|at| self.source.tokens[at].word())
        };
        let first = matches!((word(1), next), (Some("e"), 'g') | (Some("i"), 'e'));
        first || matches!((word(2), word(1)), (Some("e"), Some("g")) | (Some("i"), Some("e")))
    }

    fn is_abbreviation(&self) -> bool {
        let lower =
            self.characters[self.at..].iter().map(|character| &self.source.text[character.span.clone()]);
        let next = lower.skip(1).find(|text| !text.trim().is_empty()).and_then(|text| text.chars().next());
        next.is_some_and(|c| c.is_lowercase() || c.is_ascii_digit())
            && self.source.tokens.last().and_then(Token::word).is_some_and(|w| ABBREVIATIONS.contains(&w))
    }

    /// "1/2".
    fn fraction(&mut self) {
        let (denominator, length) = read_number(&self.characters[self.at + 1..]);
        if let Some(Token::Number(number)) = self.source.tokens.last_mut()
            && denominator > 0.0
        {
            *number /= denominator;
        }
        let end = self.span(length + 1).end;
        if let Some(span) = self.source.spans.last_mut() {
            span.end = end;
        }
        self.at += length;
    }
}

/// The text's tokens in order; never two pauses in a row.
pub(super) fn tokenize(text: &str) -> Vec<Token> {
    Source::read(text).tokens
}

/// The number at the start and how many characters it takes: "1.2", "1,5", "1,000", "12".
fn read_number(characters: &[Character]) -> (f64, usize) {
    let digits = |from: usize| {
        characters[from.min(characters.len())..].iter().take_while(|c| c.c.is_ascii_digit()).count()
    };
    let at = |position: usize| characters.get(position).map(|character| character.c);
    let whole = digits(0);
    let mut text: String = characters[..whole].iter().map(|character| character.c).collect();
    let mut length = whole;
    if matches!(at(whole), Some('.' | ',')) {
        let fraction = digits(whole + 1);
        let decimals = characters[(whole + 1).min(characters.len())..].iter().map(|character| character.c);
        if at(whole) == Some(',') && fraction == 3 {
            text.extend(decimals.take(3));
            length = whole + 4;
        } else if fraction > 0 {
            text.push('.');
            text.extend(decimals.take(fraction));
            length = whole + 1 + fraction;
        }
    }
    let number: f64 = text.parse().unwrap_or(0.0);
    (number.min(1e6), length.max(1))
}

/// The word at the start, how many characters it takes, and whether it has an apostrophe before its last letter.
fn read_word(characters: &[Character]) -> (String, usize, bool) {
    let mut word = String::new();
    let mut length = 0;
    let mut apostrophe = 0;
    for Character { c, .. } in characters {
        match *c {
            '\'' | '’' | '‘' => apostrophe = length + 1,
            // The sign between two lengths: "10x20".
            c if c.is_ascii_digit() && word == "x" => break,
            c if c.is_alphanumeric() => word.extend(fold(c)),
            _ => break,
        }
        length += 1;
    }
    (word, length.max(1), apostrophe > 0 && apostrophe + 1 == length)
}

fn fold(c: char) -> Option<char> {
    Some(match c {
        'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' => 'a',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' => 'o',
        'ù' | 'ú' | 'û' | 'ü' => 'u',
        'ç' => 'c',
        'ñ' => 'n',
        other => other,
    })
}

/// The word at a position; `None` for another token or the end.
pub(super) fn word(tokens: &[Token], at: usize) -> Option<&str> {
    tokens.get(at).and_then(Token::word)
}

/// Number of tokens of `phrase` if its words occur at `at`.
pub(super) fn match_phrase(tokens: &[Token], at: usize, phrase: &str) -> Option<usize> {
    let mut length = 0;
    for expected in phrase.split(' ') {
        if word(tokens, at + length)? != expected {
            return None;
        }
        length += 1;
    }
    Some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formatted(text: &str) -> String {
        tokenize(text)
            .iter()
            .map(|token| match token {
                Token::Word(word) => word.clone(),
                Token::Number(number) => number.to_string(),
                Token::Pause => ",".to_owned(),
                Token::End => ".".to_owned(),
            })
            .collect::<Vec<_>>()
            .join(" ")
    }

    #[test]
    fn tokenize_splits_units_numbers_and_marks() {
        for (text, tokens) in [
            ("a 30cm plate, 10x20 cm; 1.2 m", "a 30 cm plate , 10 x 20 cm . 1.2 m"),
            ("Rubik's cube\n- two–three CAFÉ mugs", "rubiks cube . two three cafe mugs"),
            ("2-3 mugs & 1,5 m / 1,000", "2 to 3 mugs and 1.5 m and 1000"),
            ("12\" x 8\"", "12 inches x 8 inches"),
            ("30cm × 20 cm×10 cm", "30 cm x 20 cm x 10 cm"),
            ("1. mug\n2. plate", "mug . plate"),
            ("1) mug 2) plate", "mug . plate"),
            ("* mug\n* plate", "mug . plate"),
            ("it's red, .5 m, 1/2 full", "it is red , 0.5 m , 0.5 full"),
            ("at (0.2, -0.1)", "at , 0.2 , -0.1 ,"),
            ("at (-10, 5) cm, e.g. a mug w/ a spoon", "at , -10 , 5 , cm , e g a mug with a spoon"),
            ("a 12 oz. mug", "a 12 oz mug"),
            ("45° and 50%", "45 degrees and 50 percent"),
            ("a 7up can, 7 upright cans", "a 7up can , 7 upright cans"),
        ] {
            assert_eq!(formatted(text), tokens, "{text}");
        }
    }

    #[test]
    fn spans_cover_the_words_of_the_text() {
        let source = Source::read("Zwei CAFÉ-Tische, İ x");
        let words: Vec<&str> = source.spans.iter().map(|span| &source.text[span.clone()]).collect();
        assert_eq!(words[..4], ["Zwei", "CAFÉ", "Tische", ","]);
    }
}
