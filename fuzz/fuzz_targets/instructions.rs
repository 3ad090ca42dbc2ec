//! Instructions for edits and tasks: each is read or refused, operations are valid, and errors point into the text.
#![no_main]

use language::{EnglishNouns, edit, task};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match edit::read(text, &EnglishNouns) {
        Ok(program) => {
            let operations: Vec<_> = program.meanings().cloned().collect();
            assert!(scene::edit::violations(&operations).is_empty());
        }
        Err(error) => assert!(text.get(error.span.clone()).is_some(), "{:?} is no part of the text", error.span),
    }
    if text.chars().count() <= edit::MAX_CHARACTERS {
        let _ = task::read(text, &EnglishNouns);
    }
});
