//! Answers of a chat model: JSON, in fences or among sentences, to each of the questions.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use remote::chat::response_check::QuestionKind;
use scene::InstanceId;

/// The objects that the questions are about; the seeds speak of them.
static ASKED: LazyLock<Vec<InstanceId>> = LazyLock::new(|| {
    ["plate_1", "apple_1", "fork_1"].map(|name| InstanceId::new(name).expect("is a name")).into()
});

fuzz_target!(|words: &str| {
    for question in QuestionKind::ALL {
        for complaint in question.complaints(words, &ASKED) {
            // They are sent to the model again: it must not make them long.
            assert!(complaint.len() < 2_000, "{question:?}: {complaint}");
        }
    }
});
