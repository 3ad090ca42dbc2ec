//! Kinds of sentences with the expected objects, relations and reports.

use super::*;
use scene::text_account::TextMeaning;

/// Text, requested counts, and parts of the summary ("!" before parts that must be absent).
const TABLE: &[(&str, &str, &[&str])] = &[
    // What is permitted need not be there; "anything else" closes the list.
    ("Forks are banned, spoons are fine: two plates", "2 plate", &[]),
    ("Knives are okay, so add one butter knife and a bagel.", "1 butter_spreading_knife, 1 bagel", &[]),
    ("A hammer and pliers, minus the usual clutter.", "1 hammer, 1 pliers", &[]),
    ("Don't bother with plates. One fork.", "1 fork", &[]),
    ("Swap out the fork: use chopsticks instead.", "1 chopsticks", &[]),
    ("a shoe box, but the shoes themselves should be left out", "1 shoe_box", &[]),
    // Sides of an owner, and words between commas.
    ("On the crate's left: a knife.", "1 crate, 1 knife", &["knife_1 left_of crate_1"]),
    ("a mug to the plate's right", "1 mug, 1 plate", &["mug_1 right_of plate_1"]),
    (
        "a stove and, in front of it, a frying pan",
        "1 stove, 1 frying_pan",
        &["frying_pan_1 in_front_of stove_1"],
    ),
    // Distances that a clause states.
    ("The distance between the kettle and the toaster is 25 cm.", "1 kettle, 1 toaster", &["next_to"]),
    // Levels of stacks.
    ("the second book of the stack is red", "3 book", &[]),
    ("a stack of four plates; the second is blue", "4 plate", &[]),
    ("pile up five lemons", "5 lemon", &[]),
    ("some sort of cereal bowl", "1 bowl", &[]),
    ("glasses at the corners of the table", "4 drinking_glass", &[]),
    ("a heap of potatoes, say seven", "7 potato", &[]),
    ("could you do a desk with two mugs", "2 mug", &[]),
    ("put the pot to the left of the plate", "1 saucepan, 1 plate", &[]),
    // Negation.
    ("a desk with a laptop, but no pens and no pencils", "1 laptop", &[]),
    ("Set the table with a plate and a spoon. Do not include any forks.", "1 plate, 1 spoon", &[]),
    ("We don't want a keyboard here. A monitor and a mouse.", "1 monitor, 1 mouse", &[]),
    ("a mug instead of a glass, and a plate", "1 mug, 1 plate", &[]),
    ("Neither knives nor scissors: a cutting board and a tomato", "1 cutting_board, 1 tomato", &[]),
    // Compounds: the head decides.
    ("a lamp shade next to a book", "1 stand_in_lamp, 1 book", &[]),
    ("a bottle cap and a mug", "1 bottle_cap, 1 mug", &[]),
    ("a zorblax holder, two plates", "2 plate", &["? zorblax holder"]),
    // Coordination.
    ("a red and a blue mug", "2 mug", &[]),
    ("three wooden and two metal spoons", "5 spoon", &[]),
    ("two mugs, one red and one blue", "2 mug", &[]),
    ("3x mug (red), 2x plate (white)", "3 mug, 2 plate", &[]),
    ("- two forks\n- a bowl\n- one wine bottle", "2 fork, 1 bowl, 1 wine_bottle", &[]),
    ("1) laptop 2) mouse", "1 laptop, 1 mouse", &[]),
    (r#"{"objects": ["mug", {"name": "plate", "count": 2}]}"#, "1 mug, 2 plate", &[]),
    (
        "a tray with a cup, a spoon and a plate on it",
        "1 tray, 1 mug, 1 spoon, 1 plate",
        &["mug_1 on tray_1", "spoon_1 on tray_1", "plate_1 on tray_1"],
    ),
    (
        "a spoon on a saucer on a tray",
        "1 spoon, 1 saucer, 1 tray",
        &["spoon_1 on saucer_1", "saucer_1 on tray_1"],
    ),
    ("bananas and pears, two of each", "2 banana, 2 pear", &[]),
    // What a relation attaches to.
    (
        "a fork behind a spoon behind a vase",
        "1 fork, 1 spoon, 1 vase",
        &["fork_1 behind spoon_1", "spoon_1 behind vase_1"],
    ),
    (
        "three lemons in a basket at the back, a can to its right",
        "3 lemon, 1 basket, 1 soda_can",
        &["basket_1 at_back", "soda_can_1 right_of basket_1"],
    ),
    (
        "A crate, in it a ball; a bowl, in it an egg.",
        "1 crate, 1 ball, 1 bowl, 1 egg",
        &["ball_1 in crate_1", "egg_1 in bowl_1"],
    ),
    (
        "a bowl with a fork on either side",
        "1 bowl, 2 fork",
        &["fork_1 left_of bowl_1", "fork_2 right_of bowl_1"],
    ),
    ("The saucepan has its lid on.", "1 saucepan, 1 lid", &["lid_1 on saucepan_1"]),
    ("a phone, 4 cm to the left: a pencil", "1 smartphone, 1 pencil", &["pencil_1 left_of smartphone_1"]),
    ("a fork beside each of the three plates", "3 fork, 3 plate", &["fork_3 next_to plate_3"]),
    ("Back row: two mugs. Front row: a plate.", "2 mug, 1 plate", &["mug_2 at_back", "plate_1 at_front"]),
    // Inventories and settings.
    ("hammer: yes, hand saw: no, pliers: yes", "1 hammer, 1 pliers", &[]),
    (
        "A basket: two apples and a pear",
        "1 basket, 2 apple, 1 pear",
        &["apple_2 in basket_1", "pear_1 in basket_1"],
    ),
    (
        "Place settings for two: bowl, spoon right.",
        "2 bowl, 2 spoon",
        &["spoon_1 right_of bowl_1", "spoon_2 right_of bowl_2"],
    ),
    ("a plate and a mug, but under no circumstances a knife", "1 plate, 1 mug", &[]),
    ("4 x 3 cubes", "12 cube", &[]),
    ("two towers of three cubes each", "6 cube", &["cube_2 stacked_on cube_1", "cube_5 stacked_on cube_4"]),
    // Measures are no counts.
    ("a 12 oz mug and a 16 oz glass", "1 mug, 1 drinking_glass", &[]),
    ("a box 30 cm wide, 20 cm deep and 10 cm high", "1 storage_case", &[]),
    // Definite descriptions.
    ("the small cup and the large cup", "2 mug", &[]),
    (
        "There is a red mug and a blue mug. The red mug holds a spoon.",
        "2 mug, 1 spoon",
        &["spoon_1 in mug_1"],
    ),
    // Distances and places.
    ("a mug 10 cm from the left edge of the table", "1 mug", &["mug_1 from_left_edge"]),
    ("the bowl is 20 cm to the right of the plate", "1 bowl, 1 plate", &["bowl_1 right_of plate_1"]),
    ("a vase in the back left corner", "1 vase", &["vase_1 at_back_left"]),
    (
        "a candle between the plate and the bowl",
        "1 candle, 1 plate, 1 bowl",
        &["candle_1 between plate_1 bowl_1"],
    ),
    (
        "each corner of the table has a candle",
        "4 candle",
        &["candle_1 at_back_left", "candle_4 at_front_right"],
    ),
    ("a laptop facing a teddy bear", "1 laptop, 1 teddy_bear", &["laptop_1 facing teddy_bear_1"]),
    // Arrangements.
    ("a 2x3 grid of dice", "6 dice", &[]),
    ("two rows of four dice", "8 dice", &[]),
    (
        "three stacks of two books",
        "6 book",
        &["book_2 stacked_on book_1", "book_4 stacked_on book_3", "!book_3 stacked_on"],
    ),
    // Contradictions.
    (
        "a mug to the left of the plate and to the right of the plate",
        "1 mug, 1 plate",
        &["mug_1 left_of plate_1"],
    ),
];

#[test]
fn each_kind_of_sentence_has_its_objects_and_relations() {
    let mut faults = Vec::new();
    for (text, counts, parts) in TABLE {
        let summary = summary(&describe_seed(text, 3));
        let read = summary.split(" | ").next().expect("counts");
        if read != *counts {
            faults.push(format!("{text}: {summary}"));
        }
        for part in *parts {
            let holds = match part.strip_prefix('!') {
                Some(absent) => !summary.contains(absent),
                None => summary.contains(part),
            };
            if !holds {
                faults.push(format!("{text}: {part:?} in {summary}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn reports_have_a_reason_and_a_span() {
    for (text, span, reason) in [
        ("a mug and a zorblax", "zorblax", UnrecognizedReason::UnknownObject),
        ("a vintage mug", "vintage", UnrecognizedReason::NotSupported),
        ("a mug and a person", "person", UnrecognizedReason::NotPlaceable),
        ("a plate 3 meters in diameter", "3 meters in diameter", UnrecognizedReason::OutOfRange),
        ("a laptop inside a mug", "inside", UnrecognizedReason::NotSupported),
        ("a red mug that is blue", "blue", UnrecognizedReason::Contradiction),
        ("a mug left of a plate and right of the plate", "right of", UnrecognizedReason::Contradiction),
        ("a burning candle", "burning", UnrecognizedReason::NotSupported),
    ] {
        let description = describe_seed(text, 3);
        let found = description.unrecognized.iter().find(|part| part.span.text == span);
        assert_eq!(found.map(|part| part.reason), Some(reason), "{text}: {:?}", description.unrecognized);
        for part in &description.unrecognized {
            assert_eq!(text[part.span.start..part.span.end], part.span.text);
        }
    }
}

#[test]
fn excluded_categories_are_absent_also_from_fillings() {
    for (text, excluded) in [
        ("a typical office desk without a desk lamp", "desk_lamp"),
        ("a messy desk, but please no mugs", "mug"),
        ("a dinner table for two; there must never be a knife", "knife"),
        ("an office desk. Leave out the keyboard.", "keyboard"),
    ] {
        for seed in 0..4 {
            let description = describe_seed(text, seed);
            assert!(description.objects.iter().any(|object| !object.requested), "{text}");
            assert!(description.objects.iter().all(|object| object.category != excluded), "{text}");
            assert!(description.excluded_categories.iter().any(|name| name == excluded), "{text}");
        }
    }
}

#[test]
fn lists_are_closed_and_bare_themes_are_filled() {
    for (text, filled) in [
        ("an office desk with a mug", false),
        ("a kitchen table with a whisk", false),
        ("a cluttered workbench", true),
        ("a laptop on an office desk and other typical things", true),
        ("a dinner table for two", true),
        ("a desk with a mug and nothing else", false),
    ] {
        let description = describe_seed(text, 5);
        assert_eq!(description.objects.iter().any(|object| !object.requested), filled, "{text}");
    }
}

#[test]
fn misspelled_words_are_corrected_and_reported() {
    let cases: [(&str, &[(&str, &str)]); 3] = [
        ("a labtop and a keybord", &[("labtop", "laptop"), ("keybord", "keyboard")]),
        // The words beside it are not corrected.
        ("There are two bananna on the desk.", &[("bananna", "banana")]),
        // Bare nouns are separated, which inserts tokens.
        ("mug plate keybord", &[("keybord", "keyboard")]),
    ];
    for (text, expected) in cases {
        let description = describe_seed(text, 1);
        let corrections: Vec<(&str, &str)> = description
            .understood
            .iter()
            .filter_map(|part| match &part.meaning {
                TextMeaning::Correction { corrected } => Some((part.span.text.as_str(), corrected.as_str())),
                _ => None,
            })
            .collect();
        assert_eq!(corrections, expected, "{text}");
    }
    assert!(summary(&describe_seed("a labtop and a keybord", 1)).starts_with("1 laptop, 1 keyboard"));
}

#[test]
fn other_languages_and_unknown_parts_are_refused_on_request() {
    let refused = describe("ein Tisch mit zwei Tassen", 1, &options(), &settings());
    assert!(matches!(refused, Err(DescribeError::NotEnglish { .. })), "{refused:?}");
    let strict = DescribeOptions { on_unknown: OnUnknown::Fail, ..options() };
    let refused = describe("a mug and a zorblax", 1, &strict, &settings());
    let Err(DescribeError::NotUnderstood { parts }) = refused else { panic!("{refused:?}") };
    assert_eq!((parts[0].span.start, parts[0].span.text.as_str()), (12, "zorblax"));
    assert!(describe("a mug and a plate", 1, &strict, &settings()).is_ok());
}

/// Every word of a description is in a span, or ignorable.
fn open_words(text: &str, description: &SceneDescription) -> Vec<String> {
    let spans: Vec<(usize, usize)> = description
        .understood
        .iter()
        .map(|part| (part.span.start, part.span.end))
        .chain(description.unrecognized.iter().map(|part| (part.span.start, part.span.end)))
        .collect();
    let source = Source::read(text);
    let ignorable = &vocabulary::vocabulary().grammar.ignorable;
    source
        .tokens
        .iter()
        .zip(&source.spans)
        .filter_map(|(token, span)| Some((token.word()?, span)))
        .filter(|(word, span)| {
            !ignorable.contains(*word)
                && !spans.iter().any(|(start, end)| *start <= span.start && span.end <= *end)
        })
        .map(|(word, _)| word.to_owned())
        .collect()
}

#[test]
fn every_word_is_accounted_for() {
    let mut faults = Vec::new();
    let sentences = SENTENCES.iter().chain(TABLE).map(|(text, _, _)| *text);
    for text in sentences.filter(|text| !text.starts_with('{')) {
        let open = open_words(text, &describe_seed(text, 3));
        if !open.is_empty() {
            faults.push(format!("{text}: {open:?}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn adversarial_texts_are_read_without_a_panic() {
    let words = [
        "a", "the", "mug", "with", "on", "left", "of", "and", ",", ".", "no", "not", "put", "in", "10", "cm",
        "x", "red", "each", "between", "it", "them", "one", "(", ")", "zorblax", "row", "stack", "to",
        "from", "facing", "upside", "down", "table", "two", "without", "plate", "glass", "half", "full",
        "so", "that", "swap", "degrees", "-", "½",
    ];
    let mut state = 1_u64;
    for _ in 0..300 {
        let mut text = String::new();
        for _ in 0..40 {
            // Numerical Recipes' linear congruential generator.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text.push_str(words[(state >> 33) as usize % words.len()]);
            text.push(' ');
        }
        // An error is as good as a description.
        let _ = describe(&text, 1, &options(), &settings());
    }
}

#[test]
fn the_time_is_linear_in_the_text() {
    let calls = |text: &str| {
        phrase::CALLS.with(|calls| calls.set(0));
        let source = Source::read(text);
        let _ = grammar::parse(&LEXICON, &source, true);
        phrase::CALLS.with(std::cell::Cell::get)
    };
    for unit in [
        "with a cup, ",
        "put it in the mug and ",
        "no mug, ",
        "one red and ",
        "a mug on a plate on ",
        "to the left of ",
        "zorblax ",
        "each ",
        "a tray with a cup, a spoon and ",
        "between the mug and ",
        "10 cm ",
        "that is ",
        "the ",
    ] {
        let (short, long) = (calls(&unit.repeat(60)), calls(&unit.repeat(240)));
        assert!(long <= 5 * short + 100, "{unit:?}: {short} calls for 60 repetitions, {long} for 240");
    }
}
