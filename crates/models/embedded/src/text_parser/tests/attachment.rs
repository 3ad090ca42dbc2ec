//! Lists before and beside a vessel or a support: which of their members are in or on it.

use super::descriptions::check;

/// As in [`super::descriptions`].
const TABLE: &[(&str, &str, &[&str])] = &[
    (
        "A row of four color pencils, two boxes of crayons and a marker in a mug.",
        "4 color_pencil, 2 crayon_box, 1 marker, 1 mug",
        &["marker_1 in mug_1", "!crayon_box_1 in", "!color_pencil_1 in"],
    ),
    (
        "A stack of two boxes and a marker in a mug.",
        "2 storage_case, 1 marker, 1 mug",
        &["marker_1 in mug_1", "!storage_case_1 in"],
    ),
    (
        "A row of three pens and a ruler in a box.",
        "3 pen, 1 ruler, 1 cardboard_box",
        &["ruler_1 in cardboard_box_1", "!pen_1 in"],
    ),
    (
        "A pen, two pencils and a marker in a mug.",
        "1 pen, 2 pencil, 1 marker, 1 mug",
        &["pen_1 in mug_1", "pencil_2 in mug_1"],
    ),
    (
        "A pen holder with two pencils in it and a pair of scissors behind a ruler.",
        "1 pen_holder, 2 pencil, 1 scissors, 1 ruler",
        &[
            "pencil_2 in pen_holder_1",
            "scissors_1 behind ruler_1",
            "!pen_holder_1 behind",
            "!scissors_1 next_to",
        ],
    ),
    (
        "A tray with a glass on it and a bottle behind a plate.",
        "1 tray, 1 drinking_glass, 1 water_bottle, 1 plate",
        &["drinking_glass_1 on tray_1", "water_bottle_1 behind plate_1", "!water_bottle_1 on"],
    ),
    (
        "A plate with an apple on it and a fork to the left of a knife.",
        "1 plate, 1 apple, 1 fork, 1 knife",
        &["apple_1 on plate_1", "fork_1 left_of knife_1", "!fork_1 next_to"],
    ),
    (
        "A tray with a glass on it and a bottle to the left of the tray.",
        "1 tray, 1 drinking_glass, 1 water_bottle",
        &["drinking_glass_1 on tray_1", "water_bottle_1 left_of tray_1"],
    ),
    ("A mug with a spoon in it and a fork beside it.", "1 mug, 1 spoon, 1 fork", &["fork_1 next_to mug_1"]),
];

#[test]
fn members_of_lists_have_the_supports_that_readers_expect() {
    check(TABLE);
}
