//! Polite and narrative words around commands, and instructions that cannot be carried out: negations, conditions,
//! alternatives, questions.

use super::Reason;
use super::cursor::{Cursor, Outcome};

const POLITE: &[&str] = &[
    "could you please",
    "can you please",
    "would you please",
    "will you please",
    "could you",
    "can you",
    "would you",
    "will you",
    "could we",
    "can we",
    "shall we",
    "id like you to",
    "i would like you to",
    "i want you to",
    "i need you to",
    "id like to",
    "i would like to",
    "i want to",
    "i need to",
    "we need to",
    "we should",
    "you should",
    "id love to",
    "lets",
    "let us",
    "please",
    "kindly",
    "go ahead and",
    "now",
    "then",
    "also",
    "next",
    "finally",
    "after that",
    "afterwards",
    "first",
    "ok",
    "okay",
    "hi",
    "hello",
    "hey",
    "so",
    "just",
    "again",
    "lastly",
    "i think we should",
    "i think",
    "in addition",
    "additionally",
    "and",
    "plus",
    ",",
];

const THANKS: &[&str] = &[
    "please",
    "thank you very much",
    "thank you",
    "thanks a lot",
    "thanks",
    "for me",
    "as well",
    "too",
    "now",
    "cheers",
];

const NEGATIONS: &[&str] = &[
    "not", "dont", "never", "without", "cannot", "cant", "wont", "shouldnt", "mustnt", "neither", "nor",
    "nothing", "avoid",
];

const CONDITIONS: &[&str] =
    &["if", "unless", "when", "whenever", "otherwise", "until", "whether", "provided", "while", "in case"];

const QUESTIONS: &[&str] = &[
    "what", "where", "which", "who", "how", "why", "is", "are", "does", "did", "whats", "wheres", "should",
    "may", "might", "was", "were",
];

impl Cursor {
    /// Checks that the whole text asks for changes.
    pub fn check_mood(&self) -> Outcome<()> {
        if self.tokens.iter().all(|token| token.word == ".") {
            return Err(self.error(0, 0, Reason::Empty));
        }
        for index in 0..self.tokens.len() {
            let word = self.word(index);
            let last = index + 1;
            if NEGATIONS.contains(&word) {
                return Err(self.error(index, last, Reason::Negated));
            }
            if CONDITIONS.iter().any(|condition| self.is_at(index, condition)) {
                return Err(self.error(index, last, Reason::Conditional));
            }
            if word == "or" {
                return Err(self.error(index, last, Reason::Alternative));
            }
            if word == "instead" && self.is_at(index + 1, "of") {
                return Err(self.error(
                    index,
                    index + 2,
                    Reason::NotUnderstood("say: replace the mug with a glass"),
                ));
            }
        }
        Ok(())
    }

    /// Consumes what is polite or narrative, up to the command.
    pub fn skip_opening(&mut self) {
        while self.take_any(POLITE) {}
    }

    /// Consumes thanks after a command.
    pub fn skip_closing(&mut self) {
        loop {
            let before = self.at;
            let _ = self.take(",");
            if !self.take_any(THANKS) {
                self.at = before;
                return;
            }
        }
    }

    /// An error if the clause at the cursor is a question or keeps objects as they are.
    pub fn check_clause(&self) -> Outcome<()> {
        let word = self.word(self.at);
        let end = (self.at..self.tokens.len()).find(|&index| self.is_end(index)).unwrap_or(self.tokens.len());
        if matches!(word, "leave" | "keep") {
            return Err(self.error(self.at, end, Reason::Unchanged));
        }
        let asks = self.tokens.get(end).is_some_and(|token| token.asks);
        let auxiliary = asks && matches!(word, "can" | "could" | "do" | "would" | "will" | "there");
        if QUESTIONS.contains(&word) || (auxiliary && !self.is_polite_request(self.at)) {
            return Err(self.error(self.at, end, Reason::Question));
        }
        Ok(())
    }

    /// "could I have", "can we get": a request in the form of a question.
    pub fn is_polite_request(&self, index: usize) -> bool {
        self.polite_length(index).is_some()
    }

    /// The number of words of "I want", "there should be" and the like.
    pub fn polite_length(&self, index: usize) -> Option<usize> {
        let openings = [
            "i want to have",
            "i would like to have",
            "id like to have",
            "id like to see",
            "id like",
            "i would like",
            "i want to see",
            "i want",
            "i need",
            "we need",
            "we want",
            "there should be",
            "there must be",
            "let there be",
            "could i have",
            "can i have",
            "could i get",
            "can i get",
            "could we have",
            "can we have",
            "may i have",
            "to have",
            "have",
            "to see",
        ];
        self.length_of_any(index, &openings)
    }
}
