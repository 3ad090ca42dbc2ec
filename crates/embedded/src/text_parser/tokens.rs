//! The tokenizer: splits a text into lower-case words, numbers and pauses.
//!
//! Total over all Unicode input: characters other than letters, digits and known marks separate words.
//! Common accents fold to their base letter; apostrophes are removed ("rubik's" = "rubiks"); hyphens split.

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

/// The text's tokens in order; never two pauses in a row.
pub(super) fn tokenize(text: &str) -> Vec<Token> {
    let characters: Vec<char> = text.chars().flat_map(char::to_lowercase).collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let c = characters[at];
        let next = characters.get(at + 1).copied().unwrap_or(' ');
        let previous = if at == 0 { ' ' } else { characters[at - 1] };
        if c.is_ascii_digit() {
            let (number, length) = read_number(&characters[at..]);
            tokens.push(Token::Number(number));
            at += length;
            continue;
        }
        if c.is_alphabetic() {
            let (word, length) = read_word(&characters[at..]);
            if !word.is_empty() {
                tokens.push(Token::Word(word));
            }
            at += length;
            continue;
        }
        match c {
            ',' | ':' | '(' | ')' | '[' | ']' | '—' | '|' => pause(&mut tokens, Token::Pause),
            '-' | '–' if previous.is_ascii_digit() && next.is_ascii_digit() => {
                tokens.push(Token::Word("to".to_owned()));
            }
            '-' | '–' if previous.is_whitespace() && next.is_whitespace() => {
                pause(&mut tokens, Token::Pause);
            }
            '.' | ';' | '!' | '?' | '\n' | '\r' | '。' => pause(&mut tokens, Token::End),
            '&' | '+' => tokens.push(Token::Word("and".to_owned())),
            '/' => tokens.push(Token::Word("and".to_owned())),
            '×' | '*' if matches!(tokens.last(), Some(Token::Number(_))) => {
                tokens.push(Token::Word("x".to_owned()));
            }
            '"' | '″' | '”' if previous.is_ascii_digit() => {
                tokens.push(Token::Word("inches".to_owned()));
            }
            _ => {}
        }
        at += 1;
    }
    tokens
}

fn pause(tokens: &mut Vec<Token>, mark: Token) {
    match tokens.last_mut() {
        None => {}
        Some(last @ Token::Pause) if mark == Token::End => *last = Token::End,
        Some(Token::Pause | Token::End) => {}
        Some(_) => tokens.push(mark),
    }
}

/// The number at the start and how many characters it takes: "1.2", "1,5", "1,000", "12".
fn read_number(characters: &[char]) -> (f64, usize) {
    let digits = |from: usize| characters[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let whole = digits(0);
    let mut text: String = characters[..whole].iter().collect();
    let mut length = whole;
    if matches!(characters.get(whole), Some('.' | ',')) {
        let fraction = digits(whole + 1);
        if characters[whole] == ',' && fraction == 3 {
            text.extend(&characters[whole + 1..whole + 4]);
            length = whole + 4;
        } else if fraction > 0 {
            text.push('.');
            text.extend(&characters[whole + 1..whole + 1 + fraction]);
            length = whole + 1 + fraction;
        }
    }
    let number: f64 = text.parse().unwrap_or(0.0);
    (number.min(1e6), length)
}

fn read_word(characters: &[char]) -> (String, usize) {
    let mut word = String::new();
    let mut length = 0;
    for &c in characters {
        match c {
            '\'' | '’' | '‘' => {}
            // The sign between two lengths: "10x20".
            c if c.is_ascii_digit() && word == "x" => break,
            c if c.is_alphanumeric() => word.extend(fold(c)),
            _ => break,
        }
        length += 1;
    }
    (word, length.max(1))
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
        assert_eq!(formatted("a 30cm plate, 10x20 cm; 1.2 m"), "a 30 cm plate , 10 x 20 cm . 1.2 m");
        assert_eq!(formatted("Rubik's cube\n- two–three CAFÉ mugs"), "rubiks cube . two three cafe mugs");
        assert_eq!(formatted("2-3 mugs & 1,5 m / 1,000"), "2 to 3 mugs and 1.5 m and 1000");
        assert_eq!(formatted("12\" x 8\""), "12 inches x 8 inches");
    }
}
