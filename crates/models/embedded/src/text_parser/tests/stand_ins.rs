//! Every stand-in of a text has its mark, with the noun that was asked for and the category that stands there.

use std::collections::BTreeSet;

use super::*;
use catalog::category;
use scene::InstanceId;

const SENTENCES: [&str; 2] = [
    include_str!("../../../../../../tests/words/sentences.jsonl"),
    include_str!("../../../../../../tests/words/tasks.jsonl"),
];

#[test]
fn a_stand_in_by_another_category_is_marked_with_its_noun() {
    for (text, stands_for, shown_as) in [
        ("a spork and a plate", "spork", "spoon"),
        ("a dumbbell rack and a plate", "dumbbell rack", "dish rack"),
        ("a sextant and a plate", "sextant", "equipment-shaped stand-in"),
    ] {
        let description = describe_seed(text, 1);
        let mark = description.objects[0].stand_in.as_ref().expect(text);
        assert_eq!((mark.stands_for.as_str(), mark.shown_as.as_str()), (stands_for, shown_as), "{text}");
        assert_eq!(description.objects[1].stand_in, None, "{text}");
    }
}

#[test]
fn the_account_of_every_test_text_lists_the_marked_objects() {
    let mut marked_in_all = 0;
    for line in SENTENCES.iter().flat_map(|file| file.lines()) {
        let line: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
        let text = line["text"].as_str().expect("a text");
        let Ok(description) = describe(text, 1, &options(), &settings()) else { continue };
        let listed: BTreeSet<InstanceId> = description.account().stand_ins.into_iter().collect();
        for object in &description.objects {
            assert_eq!(object.stand_in.is_some(), listed.contains(&object.id), "{text}: {}", object.id);
            let hidden = catalog::stand_in::is_stand_in(&object.category);
            assert!(object.stand_in.is_some() || !hidden, "{text}: {} has no mark", object.id);
            let Some(mark) = &object.stand_in else { continue };
            marked_in_all += 1;
            let label = category(&object.category).map(|category| category.label.as_str());
            assert_eq!(Some(mark.shown_as.as_str()), label, "{text}: {}", object.id);
            assert!(!mark.stands_for.is_empty() && mark.stands_for != mark.shown_as, "{text}: {mark:?}");
        }
    }
    assert!(marked_in_all > 5, "only {marked_in_all} stand-ins in all texts");
}
