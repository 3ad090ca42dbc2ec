//! Instructions with the expected goals and start states.

use super::*;

/// "in apple_1 bowl_1, ...".
fn goal(description: &SceneDescription) -> String {
    let predicates = description.goal.iter().flat_map(|goal| &goal.predicates);
    let formatted = predicates.map(|predicate| {
        let kind = serde_json::to_value(predicate.predicate).expect("a name");
        let others = [&predicate.target, &predicate.second_target];
        let others: String = others.into_iter().flatten().map(|id| format!(" {id}")).collect();
        format!("{} {}{others}", kind.as_str().expect("a string"), predicate.object)
    });
    formatted.collect::<Vec<_>>().join(", ")
}

/// Text, goal, and parts of the summary of the start state ("!" before parts that must be absent).
const TASKS: &[(&str, &str, &[&str])] = &[
    ("put the apple in the bowl", "in apple_1 bowl_1", &["1 apple, 1 bowl", "!in bowl_1"]),
    ("Pick up the carrot and place it on the plate", "on carrot_1 plate_1", &["!on plate_1"]),
    ("set the fork down to the left of the plate", "left_of fork_1 plate_1", &["fork_1 right_of plate_1"]),
    ("place the candle at the back of the table", "at_back candle_1", &["candle_1 at_front"]),
    ("put the stapler in the front left corner", "at_front_left stapler_1", &["stapler_1 at_back_right"]),
    ("take the spoon out of the mug", "out_of spoon_1 mug_1", &["spoon_1 in mug_1"]),
    ("move the egg from the plate to the bowl", "in egg_1 bowl_1", &["egg_1 on plate_1"]),
    ("take the croissant off the plate", "off croissant_1 plate_1", &["croissant_1 on plate_1"]),
    ("swap the mug and the bowl", "swapped mug_1 bowl_1", &["1 mug, 1 bowl"]),
    ("stack the bowls", "stacked_on bowl_2 bowl_1", &["!stacked_on"]),
    (
        "push the soda can away from the laptop",
        "away_from soda_can_1 laptop_1",
        &["soda_can_1 next_to laptop_1"],
    ),
    ("open the laptop", "opened laptop_1", &["1 laptop"]),
    ("turn on the desk lamp", "pressed desk_lamp_1", &["1 desk_lamp"]),
    (
        "pour the water from the pitcher into the glass",
        "poured_into pitcher_1 drinking_glass_1",
        &["1 pitcher, 1 drinking_glass"],
    ),
    ("rotate the tray clockwise", "rotated tray_1", &[]),
    ("turn the bowl over", "upside_down bowl_1", &[]),
    ("can you put the apple on the plate?", "on apple_1 plate_1", &[]),
    ("I want the robot to pick up the hammer", "lifted hammer_1", &["1 hammer"]),
    ("Could you please hand me the screwdriver?", "lifted screwdriver_1", &[]),
    ("cut the apple with the knife", "used_on knife_1 apple_1", &[]),
    (
        "put the pens in the pen holder and the book on the tray",
        "in pen_1 pen_holder_1, in pen_2 pen_holder_1, on book_1 tray_1",
        &[],
    ),
    ("the banana is in the pan. move it to the plate", "on banana_1 plate_1", &["banana_1 in frying_pan_1"]),
    (
        "A desk with a laptop and a mug. The robot should move the mug behind the laptop.",
        "behind mug_1 laptop_1",
        &["1 laptop, 1 mug"],
    ),
    (
        "Scene: a basket with four eggs. Instruction: take one egg out of the basket.",
        "out_of egg_1 basket_1",
        &["4 egg"],
    ),
    ("put the small cup into the large cup", "in mug_1 mug_2", &["2 mug"]),
    ("place the cube between the two bowls", "", &[]),
];

#[test]
fn instructions_have_goals_that_the_start_state_does_not_satisfy() {
    let mut faults = Vec::new();
    for (text, expected, parts) in TASKS {
        let Ok(description) = describe(text, 4, &options(), &settings()) else {
            faults.push(format!("{text}: refused"));
            continue;
        };
        let (goal, summary) = (goal(&description), summary(&description));
        let stack = expected.starts_with("stacked_on bowl") && goal.starts_with(expected);
        let pens = expected.starts_with("in pen_1") && goal.starts_with("in pen_1 pen_holder_1, in pen_2");
        if goal != *expected && !stack && !pens && !expected.is_empty() {
            faults.push(format!("{text}: {goal} || {summary}"));
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
