//! Instructions with the expected goals and start states.

use super::*;

/// "in apple_1 bowl_1, ...".
pub(super) fn goal(description: &SceneDescription) -> String {
    let predicates = description.goal.iter().flat_map(|goal| &goal.predicates);
    let formatted = predicates.map(|predicate| {
        let kind = serde_json::to_value(predicate.predicate).expect("a name");
        let others = [&predicate.target, &predicate.second_target];
        let others: String = others.into_iter().flatten().map(|id| format!(" {id}")).collect();
        format!("{} {}{others}", kind.as_str().expect("a string"), predicate.object)
    });
    formatted.collect::<Vec<_>>().join(", ")
}

/// The summary with the poses and states: "mug_1 lying_on_side", "cabinet_1 open".
pub(super) fn start(description: &SceneDescription) -> String {
    let mut text = summary(description);
    for object in &description.objects {
        let pose = serde_json::to_value(object.pose).expect("a name");
        let pose = pose.as_str().unwrap_or_default();
        text += &format!(" | {} {pose}", object.id);
        if let Some(state) = &object.state {
            text += &format!(" | {} {state}", object.id);
        }
    }
    text
}

/// Text, goal, and parts of the summary of the start state ("!" before parts that must be absent).
const TASKS: &[(&str, &str, &[&str])] = &[
    ("put the apple in the bowl", "in apple_1 bowl_1", &["1 apple, 1 bowl", "!in bowl_1"]),
    ("Pick up the carrot and place it on the plate", "on carrot_1 plate_1", &["!on plate_1"]),
    ("set the fork down to the left of the plate", "left_of fork_1 plate_1", &["fork_1 right_of plate_1"]),
    ("place the candle at the back of the table", "at_back candle_1", &["candle_1 at_front"]),
    ("put the stapler in the front left corner", "at_front_left stapler_1", &["stapler_1 at_back_right"]),
    (
        "put the apple in the bowl, then the spoon next to it",
        "in apple_1 bowl_1, next_to spoon_1 bowl_1",
        &["1 apple, 1 bowl, 1 spoon", "!in bowl_1", "!spoon_1 next_to bowl_1"],
    ),
    (
        "Put the fork on the plate and then the mug on the coaster.",
        "on fork_1 plate_1, on mug_1 coaster_1",
        &["!on plate_1", "!on coaster_1"],
    ),
    (
        "move the egg from the plate to the bowl, then the croissant to the tray",
        "in egg_1 bowl_1, on croissant_1 tray_1",
        &["egg_1 on plate_1", "!croissant_1 on tray_1"],
    ),
    ("put the mug on the tray, then lift the bowl", "on mug_1 tray_1, lifted bowl_1", &[]),
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
    // Headings of the end state.
    ("Wanted: the spoon inside the mug.", "in spoon_1 mug_1", &["!in mug_1"]),
    ("The goal state has the book on the tray.", "on book_1 tray_1", &["!on tray_1"]),
    ("Final state: two apples in the bowl", "in apple_1 bowl_1, in apple_2 bowl_1", &["!in bowl_1"]),
    (
        "Goal: the apple is on the plate and the pear is in the bowl",
        "on apple_1 plate_1, in pear_1 bowl_1",
        &[],
    ),
    // Arrows, steps and agents.
    ("grab apple -> put in bowl", "in apple_1 bowl_1", &["!in bowl_1"]),
    ("pear => basket", "in pear_1 basket_1", &["1 pear, 1 basket"]),
    ("1. pick up the mug 2. put it on the plate", "on mug_1 plate_1", &[]),
    ("Step one: grab the lid. Step two: put it on the pot.", "on lid_1 saucepan_1", &[]),
    ("let the gripper place the lemon in the bowl", "in lemon_1 bowl_1", &["!in bowl_1"]),
    ("the gripper has to move the ball into the basket", "in ball_1 basket_1", &["!in basket_1"]),
    ("have the cup and the bowl switch places", "swapped mug_1 bowl_1", &["1 mug, 1 bowl"]),
    ("make the pen lie on its side", "lying_on_side pen_1", &[]),
    // Verbs that are not known, and verbs without a predicate.
    ("frobnicate the mug into the bowl", "in mug_1 bowl_1", &["!in bowl_1"]),
    ("heave the book onto the shelf", "on book_1 shelf_1", &["!on shelf_1"]),
    ("fold the towel", "moved towel_1", &["1 towel"]),
    ("load the basket with the two apples", "in apple_1 basket_1, in apple_2 basket_1", &["!in basket_1"]),
    ("unload the basket: two pears are in it", "out_of pear_1 basket_1, out_of pear_2 basket_1", &[]),
    ("uncover the pan", "off lid_1 frying_pan_1", &["lid_1 on frying_pan_1"]),
    ("grab the sponge; wipe the plate", "used_on sponge_1 plate_1", &[]),
    ("close the jar with the lid", "on lid_1 jar_1", &["!on jar_1"]),
    // Buttons of an object.
    ("push the power button of the blender", "pressed blender_1", &["1 blender"]),
    ("flip the switch of the lamp", "pressed desk_lamp_1", &["1 desk_lamp"]),
    // Sources, and what happened before.
    (
        "open the toolbox and get the wrench out",
        "opened toolbox_1, out_of wrench_1 toolbox_1",
        &["wrench_1 in"],
    ),
    (
        "take the pen from the mug and put it on the table",
        "out_of pen_1 mug_1, on pen_1",
        &["pen_1 in mug_1"],
    ),
    ("the fork fell off the plate, put it back", "on fork_1 plate_1", &["!on plate_1"]),
    ("the mug should no longer be on the book", "off mug_1 book_1", &["mug_1 on book_1"]),
    // Some of several objects.
    ("put either mug on the tray", "on mug_1 tray_1", &["2 mug, 1 tray"]),
    ("drop one of the two balls into the basket", "in ball_1 basket_1", &["2 ball, 1 basket"]),
    ("put the red one of the two mugs on the tray", "on mug_1 tray_1", &["2 mug, 1 tray"]),
    ("remove the top plate from the stack of four plates", "off plate_4 plate_3", &["4 plate"]),
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
