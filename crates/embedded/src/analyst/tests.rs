//! Sentences and what must be read from them.

use glam::DVec3;

use super::*;
use catalog::{Affordance, Category};

fn settings() -> Settings {
    Settings {
        max_text_chars: 4000,
        fewest_objects: 8,
        most_objects: 15,
        kinds_that_close_a_text: 3,
        table_area_per_footprint: 3.0,
    }
}

fn options() -> DescribeOptions {
    DescribeOptions { max_objects: 64, table: None }
}

/// The agreed names, so that the grammar's tests do not depend on how far the catalog is.
const NAMES: &[(&str, &str)] = &[
    (
        "dining_kitchen",
        "mug teacup saucer drinking_glass wine_glass plate bowl fork knife spoon chopsticks teapot kettle pitcher water_bottle wine_bottle soda_can jar salt_shaker pepper_mill cutting_board frying_pan saucepan spatula ladle whisk rolling_pin apple banana orange pear lemon carrot cucumber tomato egg bread_loaf baguette cheese_wedge croissant donut cake napkin_holder toaster milk_carton cereal_box tray basket",
    ),
    (
        "office_living",
        "laptop monitor keyboard mouse desk_lamp book notebook pen pencil pen_holder stapler tape_dispenser calculator smartphone tablet headphones speaker desk_clock picture_frame potted_plant cactus vase candle remote_control game_controller coaster eyeglasses globe desk_fan file_tray paper_stack sticky_notes tissue_box hourglass rubiks_cube bookend",
    ),
    (
        "workbench_utility",
        "hammer screwdriver wrench pliers adjustable_wrench hand_saw tape_measure power_drill toolbox spirit_level utility_knife c_clamp chisel hand_plane bolt nut paint_can flashlight multimeter wire_spool storage_bin oil_can funnel glue_bottle",
    ),
    (
        "crafting_hobby",
        "model_car model_airplane paint_bottle paintbrush paint_palette magnifying_glass scissors thread_spool yarn_ball sewing_machine pin_cushion button ruler glue_stick cutting_mat crayon_box color_pencil watercolor_set canvas_board storage_case embroidery_hoop dice chess_pawn playing_cards building_brick teddy_bear hot_glue_gun marker",
    ),
];

fn stocked() -> &'static Lexicon<'static> {
    static STOCKED: LazyLock<Lexicon<'static>> = LazyLock::new(|| {
        static CATEGORIES: LazyLock<Vec<Category>> = LazyLock::new(|| {
            let mut all = categories().to_vec();
            for (family, names) in NAMES {
                for name in names.split(' ') {
                    if all.iter().any(|category| category.name == name) {
                        continue;
                    }
                    let text = format!(
                        "name = \"{name}\"\nlabel = \"{}\"\nfamilies = [\"{family}\"]\ngroup = \"{family}\"\n\
                         size = {{ low_m = [0.05, 0.05, 0.05], high_m = [0.06, 0.06, 0.06] }}\n\
                         palette = [\"#808080\"]\nsubstance = \"wood\"\nfacing = \"any\"\nsymmetry_order = 1\nzone = \"any\"",
                        name.replace('_', " ")
                    );
                    let mut category: Category = toml::from_str(&text).expect("a stand-in");
                    if ["pen_holder", "basket", "storage_bin", "vase", "jar", "toolbox"].contains(&name) {
                        category.affordances = vec![Affordance::Container];
                        category.size.low_m = DVec3::new(0.09, 0.09, 0.1);
                        category.size.high_m = DVec3::new(0.12, 0.12, 0.12);
                    }
                    if ["tray", "cutting_board", "coaster", "book"].contains(&name) {
                        category.affordances = vec![Affordance::Support];
                        category.size.low_m = DVec3::new(0.2, 0.2, 0.01);
                        category.size.high_m = DVec3::new(0.3, 0.3, 0.02);
                    }
                    all.push(category);
                }
            }
            all
        });
        Lexicon::new(&CATEGORIES, table_models(), vocabulary::vocabulary(), themes::themes())
    });
    &STOCKED
}

fn describe_seed(text: &str, seed: u64) -> SceneDescription {
    describe_with(stocked(), text, seed, &options(), &settings()).expect(text)
}

/// "2 mug, 1 plate | mug_1 on plate_1 | ? unknown".
fn summary(description: &SceneDescription) -> String {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for object in description.objects.iter().filter(|object| object.requested) {
        match counts.iter_mut().find(|(name, _)| *name == object.category) {
            Some((_, count)) => *count += 1,
            None => counts.push((object.category.clone(), 1)),
        }
    }
    let mut text: String =
        counts.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ");
    let added = description.objects.iter().filter(|object| !object.requested).count();
    if added > 0 {
        text += &format!(" +{added}");
    }
    for object in description.objects.iter().filter(|object| object.requested) {
        for relation in &object.relations {
            let kind = serde_json::to_value(relation.kind).expect("a name");
            let target = relation.target.as_ref().map_or(String::new(), |id| format!(" {id}"));
            text += &format!(" | {} {}{target}", object.id, kind.as_str().expect("a string"));
        }
    }
    if !description.unrecognized_terms.is_empty() {
        text += &format!(" | ? {}", description.unrecognized_terms.join(", "));
    }
    text
}

/// Sentences and what must be read in them: counts first, then relations.
const SENTENCES: &[(&str, &str, &[&str])] = &[
    ("a desk with two mugs and a plate", "2 mug, 1 plate", &[]),
    ("twelve pencils, half a dozen donuts and a pair of scissors", "12 pencil, 6 donut, 1 scissors", &[]),
    ("two dozen buttons, twenty-five dice", "24 button, 25 dice", &[]),
    ("laptop mouse keyboard", "1 laptop, 1 mouse, 1 keyboard", &[]),
    (
        "a stack of three books with a mug on top",
        "3 book, 1 mug",
        &["book_3 stacked_on book_2", "mug_1 on book_3"],
    ),
    ("two plates, each with a fork and a knife", "2 plate, 2 fork, 2 knife", &["fork_2 next_to plate_2"]),
    (
        "a mug with two pencils in it, three books stacked on each other, two plates next to each other",
        "1 mug, 2 pencil, 3 book, 2 plate",
        &["pencil_2 in mug_1", "book_3 stacked_on book_2", "!book_1 next_to", "!plate_1"],
    ),
    ("Two coasters with a mug on each", "2 coaster, 2 mug", &["mug_2 on coaster_2"]),
    (
        "a mug with a spoon in it next to a red book",
        "1 mug, 1 spoon, 1 book",
        &["spoon_1 in mug_1", "mug_1 next_to book_1"],
    ),
    ("a coaster under a mug", "1 coaster, 1 mug", &["mug_1 on coaster_1"]),
    (
        "a bowl containing 3 lemons, an orange mug and two oranges",
        "1 bowl, 3 lemon, 1 mug, 2 orange",
        &["lemon_3 in bowl_1"],
    ),
    (
        "An office desk with a laptop, a keyboard in front of it, and a mouse to the right of the keyboard. Behind the laptop stands a lamp.",
        "1 laptop, 1 keyboard, 1 mouse, 1 desk_lamp",
        &["keyboard_1 in_front_of laptop_1", "mouse_1 right_of keyboard_1", "desk_lamp_1 behind laptop_1"],
    ),
    (
        "a plate in the center, with a fork to the left and a knife to the right",
        "1 plate, 1 fork, 1 knife",
        &["plate_1 at_center", "fork_1 left_of plate_1", "knife_1 right_of plate_1"],
    ),
    (
        "four plates around a vase, a candle between the vase and the wine bottle",
        "4 plate, 1 vase, 1 candle, 1 wine_bottle",
        &["plate_4 around vase_1", "candle_1 next_to vase_1", "candle_1 next_to wine_bottle_1"],
    ),
    (
        "a workbench with a hammer, three screwdrivers, pliers, and a wrench, but no saw",
        "1 hammer, 3 screwdriver, 1 pliers, 1 wrench",
        &[],
    ),
    (
        "A cluttered desk only: monitor, mouse, coffee mug, 3 pens in a pen holder, and sticky notes",
        "1 monitor, 1 mouse, 1 mug, 3 pen, 1 pen_holder, 1 sticky_notes",
        &["pen_3 in pen_holder_1"],
    ),
    (
        "four plates, each with a fork on the left and a knife on the right, four wine glasses and a basket",
        "4 plate, 4 fork, 4 knife, 4 wine_glass, 1 basket",
        &["fork_4 left_of plate_4", "knife_1 right_of plate_1", "knife_4 right_of plate_4"],
    ),
    (
        "a cutting board, two tomatoes and a cucumber on the cutting board, a jar",
        "1 cutting_board, 2 tomato, 1 cucumber, 1 jar",
        &["tomato_2 on cutting_board_1", "cucumber_1 on cutting_board_1"],
    ),
    ("a mug with a spoon in it and two eggs", "1 mug, 1 spoon, 2 egg", &["spoon_1 in mug_1", "!egg_1"]),
    ("a mug holder and a zorblax next to a stapler", "1 stapler", &["? mug holder, zorblax"]),
    (
        "An apple and a banana in a bowl",
        "1 apple, 1 banana, 1 bowl",
        &["apple_1 in bowl_1", "banana_1 in bowl_1"],
    ),
    ("a bottle of wine, a box of crayons, a ball of yarn", "1 wine_bottle, 1 crayon_box, 1 yarn_ball", &[]),
    (
        "a croissant on a plate, a boiled egg, and a cup of coffee",
        "1 croissant, 1 plate, 1 egg, 1 mug",
        &["croissant_1 on plate_1"],
    ),
];

#[test]
fn sentences_are_read() {
    for (text, counts, relations) in SENTENCES {
        for seed in [1, 2, 77] {
            let summary = summary(&describe_seed(text, seed));
            let read = summary.split(" | ").next().expect("counts");
            assert_eq!(read, *counts, "{text}: {summary}");
            for relation in *relations {
                // "!egg_1": nothing is said of it.
                match relation.strip_prefix('!') {
                    Some(absent) => assert!(!summary.contains(absent), "{text}: {absent:?} in {summary}"),
                    None => assert!(summary.contains(relation), "{text}: no {relation:?} in {summary}"),
                }
            }
        }
    }
}

#[test]
fn a_mug_does_not_grow_in_length_for_the_spoon_in_it() {
    for seed in 0..20 {
        let description = describe_seed("a mug with a spoon in it", seed);
        let size_of = |name: &str| {
            description.objects.iter().find(|object| object.id.as_str() == name).expect("named").size_m
        };
        let mug = categories().iter().find(|category| category.name == "mug").expect("known");
        assert!(size_of("mug_1").x <= mug.size.high_m.x, "seed {seed}: {}", size_of("mug_1"));
    }
}
