//! Descriptive sentences with the facts that they state.

use super::*;
use scene::RelationKind;

/// Text, requested counts, and facts ("!" before facts that must be absent). Facts are "mug_1 on plate_1",
/// "mug_1 left_of plate_1 20cm", "mug_1 red", "cup_1 upside_down", "row of 3 mug", "cube_1 z 40 mm", "cube_1 p 100
/// -50" (position), "no fork", "filled" and "? text: reason".
const TABLE: &[(&str, &str, &[&str])] = &[
    // Exclusions.
    (
        "Set a tea table with a teapot and two cups. It must not have any spoons.",
        "1 teapot, 2 mug",
        &["no spoon", "!filled"],
    ),
    (
        "Generate a breakfast table. It shouldn't include bananas or oranges.",
        "",
        &["no banana", "no orange", "filled"],
    ),
    ("A typical office desk. Don't show a mug or a desk lamp.", "", &["no mug", "no desk_lamp", "filled"]),
    ("A laptop rather than a monitor, with a mouse.", "1 laptop, 1 mouse", &["no monitor"]),
    (
        "Instead of a fork, put a spoon next to the plate.",
        "1 spoon, 1 plate",
        &["no fork", "spoon_1 next_to plate_1"],
    ),
    ("Mugs are banned; use a glass and a bottle.", "1 drinking_glass, 1 water_bottle", &["no mug"]),
    ("Skip the forks, just two plates and a knife.", "2 plate, 1 knife", &["no fork"]),
    (
        "No cutlery except spoons: a bowl and two spoons.",
        "1 bowl, 2 spoon",
        &["no fork", "no knife", "!no spoon"],
    ),
    (
        "All fruit apart from apples is forbidden. A plate with three apples.",
        "1 plate, 3 apple",
        &["no banana", "!no apple"],
    ),
    ("Nothing apart from a kettle and a mug.", "1 kettle, 1 mug", &["!filled"]),
    // Contents, and what stands beside them.
    (
        "A table with chopsticks, a plate of sushi and two sake cups.",
        "1 chopsticks, 1 plate, 1 sushi, 2 sake_cup",
        &["sushi_1 on plate_1", "!sake_cup_1 on plate_1"],
    ),
    (
        "A counter with a plate of olives and wine glasses.",
        "1 plate, 4 olive, 2 wine_glass",
        &["olive_1 on plate_1", "!wine_glass_1 on plate_1"],
    ),
    ("A tray of cups and plates.", "1 tray, 3 mug, 3 plate", &["mug_1 on tray_1", "plate_1 on tray_1"]),
    (
        "A bathroom shelf with a toothbrush and a bar of soap.",
        "1 toothbrush, 1 soap",
        &["!toothbrush_1 on shelf_1"],
    ),
    ("A nightstand with a lamp and a book.", "1 desk_lamp, 1 book", &[]),
    // Requests.
    ("Spawn three cubes and a bowl.", "3 cube, 1 bowl", &[]),
    ("Could you spawn a red mug and a book?", "1 mug, 1 book", &["mug_1 red"]),
    (
        "Set up a scene where a pen lies on a notebook.",
        "1 pen, 1 notebook",
        &["pen_1 on notebook_1", "!goal"],
    ),
    ("Set up a table with a lamp and a clock.", "1 desk_lamp, 1 desk_clock", &["!goal"]),
    ("This is only a test: a mug on a book.", "1 mug, 1 book", &["mug_1 on book_1"]),
    ("Two mugs and a bowl; colors don't matter.", "2 mug, 1 bowl", &[]),
    (
        "A teapot and three mugs, handles are not important.",
        "1 teapot, 3 mug",
        &["? handles are not important: not_expressible"],
    ),
    // Definite descriptions.
    ("The large book and the small book stand next to each other.", "2 book", &["book_2 next_to book_1"]),
    (
        "The red cube and the blue cube stand side by side.",
        "2 cube",
        &["cube_1 red", "cube_2 blue", "row of 2 cube"],
    ),
    (
        "Three plates: the first one holds an apple, the second one a pear.",
        "3 plate, 1 apple, 1 pear",
        &["apple_1 on plate_2", "pear_1 on plate_3"],
    ),
    (
        "Two bowls: the left bowl holds a lemon and the right bowl holds an egg.",
        "2 bowl, 1 lemon, 1 egg",
        &["bowl_2 at_left", "bowl_1 at_right", "lemon_1 in bowl_2", "egg_1 in bowl_1"],
    ),
    (
        "Two plates: the left one carries a croissant, the right one an egg.",
        "2 plate, 1 croissant, 1 egg",
        &["plate_2 at_left", "plate_1 at_right", "croissant_1 on plate_2", "egg_1 on plate_1"],
    ),
    (
        "There are two mugs, a metal one and a ceramic one. The former stands on a book.",
        "2 mug, 1 book",
        &["mug_1 steel", "mug_2 ceramic", "mug_1 on book_1", "!mug_2 on"],
    ),
    (
        "There are two mugs, a metal one and a ceramic one. The latter stands on a book.",
        "2 mug, 1 book",
        &["mug_2 on book_1", "!mug_1 on"],
    ),
    (
        "A plate is on the left, another plate on the right. An egg lies on the right plate.",
        "2 plate, 1 egg",
        &["plate_1 at_left", "plate_2 at_right", "egg_1 on plate_2"],
    ),
    (
        "A glass stands near the laptop. That glass is blue and the laptop is silver.",
        "1 drinking_glass, 1 laptop",
        &["drinking_glass_1 blue", "laptop_1 silver"],
    ),
    ("Two vases, one of them green.", "2 vase", &["vase_1 green", "!vase_2 green"]),
    ("Two vases, one green, the other white.", "2 vase", &["vase_1 green", "vase_2 white"]),
    ("Two mugs, one on a book, the other in a box.", "2 mug, 1 book, 1 cardboard_box", &["mug_1 on book_1"]),
    (
        "A basket with three apples. Beside it, a bowl with the same fruit.",
        "1 basket, 6 apple, 1 bowl",
        &["apple_1 in basket_1", "apple_4 in bowl_1", "bowl_1 next_to basket_1"],
    ),
    (
        "A cup on a saucer; the cup is white, the saucer blue.",
        "1 mug, 1 saucer",
        &["mug_1 white", "saucer_1 blue"],
    ),
    (
        "A red, a green and a blue cube in a row. The green one is open to nobody.",
        "3 cube",
        &["cube_1 red", "cube_2 green", "cube_3 blue", "row of 3 cube"],
    ),
    (
        "Two cups stand on the table. The left one is red, the right one is blue.",
        "2 mug",
        &["mug_2 red", "mug_2 at_left", "mug_1 blue", "mug_1 at_right"],
    ),
    (
        "Three jars on a tray; the largest jar must be green.",
        "3 jar, 1 tray",
        &["jar_3 green", "jar_3 on tray_1"],
    ),
    (
        "Three mugs on a tray. The red mug holds a spoon.",
        "3 mug, 1 tray, 1 spoon",
        &["spoon_1 in mug_3", "mug_3 red"],
    ),
    (
        "A deck of cards and a die to the right of the deck.",
        "1 playing_cards, 1 dice",
        &["dice_1 right_of playing_cards_1"],
    ),
    ("A big bowl and a small bowl. An egg lies in the small one.", "2 bowl, 1 egg", &["egg_1 in bowl_2"]),
    (
        "A large plate, a small plate and a fork on the small plate.",
        "2 plate, 1 fork",
        &["fork_1 on plate_2"],
    ),
    // Measures.
    (
        "Three cubes with an edge length of 40 mm in red, green and blue.",
        "3 cube",
        &["cube_1 red", "cube_2 green", "cube_3 blue", "cube_1 z 40 mm", "cube_3 x 40 mm"],
    ),
    ("Two 5 cm cubes in red and yellow.", "2 cube", &["cube_1 red", "cube_2 yellow", "cube_2 z 50 mm"]),
    (
        "4 cm red, blue and green cubes.",
        "3 cube",
        &["cube_1 red", "cube_2 blue", "cube_3 green", "cube_3 z 40 mm"],
    ),
    ("three red and blue cubes", "3 cube", &["cube_1 red", "cube_2 blue"]),
    ("three red, blue and green cubes", "3 cube", &["cube_1 red", "cube_2 blue", "cube_3 green"]),
    ("wooden, metal and plastic spoons", "3 spoon", &["spoon_1 wood", "spoon_2 steel", "spoon_3 plastic"]),
    ("A cube with a side length of 50 mm.", "1 cube", &["cube_1 z 50 mm"]),
    (
        "A storage bin holding 4 cubes of 4 cm.",
        "1 storage_bin, 4 cube",
        &["cube_4 z 40 mm", "cube_4 in storage_bin_1"],
    ),
    (
        "A plate of 20 cm diameter and a bowl of 15 cm diameter.",
        "1 plate, 1 bowl",
        &["plate_1 x 200 mm", "bowl_1 x 150 mm"],
    ),
    // Distances.
    (
        "Put the phone half a meter to the left of the speaker.",
        "1 smartphone, 1 speaker",
        &["smartphone_1 left_of speaker_1 50cm"],
    ),
    (
        "A glass 2 cm from the plate on its right side.",
        "1 drinking_glass, 1 plate",
        &["drinking_glass_1 right_of plate_1 2cm"],
    ),
    (
        "The cup is 30 cm away from the laptop on its left side.",
        "1 mug, 1 laptop",
        &["mug_1 left_of laptop_1 30cm"],
    ),
    (
        "Keep the knife 25 cm away from the front edge, the plate 5 cm away from it.",
        "1 knife, 1 plate",
        &["knife_1 from_front_edge 25cm", "plate_1 from_front_edge 5cm", "!plate_1 next_to"],
    ),
    ("Keep 10 cm between the fork and the knife.", "1 fork, 1 knife", &["knife_1 next_to fork_1 10cm"]),
    (
        "There is a gap of 20 cm between the mug and the bottle.",
        "1 mug, 1 water_bottle",
        &["water_bottle_1 next_to mug_1 20cm"],
    ),
    ("Three bottles in a row with 5 cm between the bottles.", "3 water_bottle", &["row of 3 water_bottle"]),
    (
        "Two towers: one of three red cubes, one of two blue cubes, 20 cm apart.",
        "5 cube",
        &[
            "cube_3 stacked_on cube_2",
            "cube_5 stacked_on cube_4",
            "cube_3 red",
            "cube_4 blue",
            "cube_4 next_to cube_1 20cm",
        ],
    ),
    (
        "A candle 15 cm from the front edge and 20 cm from the left edge.",
        "1 candle",
        &["candle_1 from_front_edge 15cm", "candle_1 from_left_edge 20cm"],
    ),
    (
        "A monitor one foot behind the keyboard.",
        "1 monitor, 1 keyboard",
        &["monitor_1 behind keyboard_1 30cm"],
    ),
    // Places.
    ("In the near left corner lies a pen.", "1 pen", &["pen_1 at_front_left"]),
    (
        "In the far right corner there is a potted plant, and a phone lies close to the near edge.",
        "1 potted_plant, 1 smartphone",
        &["potted_plant_1 at_back_right", "smartphone_1 at_front", "!smartphone_1 at_back_right"],
    ),
    (
        "A book in the rear left corner, a cup in the rear right corner.",
        "1 book, 1 mug",
        &["book_1 at_back_left", "mug_1 at_back_right"],
    ),
    (
        "A lamp stands in the middle of the back edge.",
        "1 desk_lamp",
        &["desk_lamp_1 at_back", "!desk_lamp_1 at_center"],
    ),
    ("On the far side of the desk there is a lamp.", "1 desk_lamp", &["desk_lamp_1 at_back"]),
    ("A vase in the rear left third of the table.", "1 vase", &["vase_1 at_back_left"]),
    (
        "A monitor stands centered at the back with speakers on either side.",
        "1 monitor, 2 speaker",
        &["monitor_1 at_back", "speaker_1 left_of monitor_1", "speaker_2 right_of monitor_1"],
    ),
    (
        "A kettle opposite a teapot with a tray in between.",
        "1 kettle, 1 teapot, 1 tray",
        &["tray_1 between kettle_1 teapot_1"],
    ),
    (
        "A mug and a bowl with a spoon between them.",
        "1 mug, 1 bowl, 1 spoon",
        &["spoon_1 between mug_1 bowl_1"],
    ),
    (
        "A mug on the left, a bowl on the right, and in between a spoon.",
        "1 mug, 1 bowl, 1 spoon",
        &["mug_1 at_left", "bowl_1 at_right", "spoon_1 between mug_1 bowl_1"],
    ),
    (
        "A fork and a knife on either side of the plate.",
        "1 fork, 1 knife, 1 plate",
        &["fork_1 left_of plate_1", "knife_1 right_of plate_1"],
    ),
    (
        "A lamp to the left of and behind the laptop.",
        "1 desk_lamp, 1 laptop",
        &["desk_lamp_1 left_of laptop_1", "desk_lamp_1 behind laptop_1"],
    ),
    ("A mug near the viewer and a vase at the back.", "1 mug, 1 vase", &["mug_1 at_front", "vase_1 at_back"]),
    // Arrangements.
    ("A ring of eight chess pawns.", "8 chess_pawn", &["circle of 8 chess_pawn"]),
    ("A pyramid made of six cans.", "6 soda_can", &["pyramid of 6 soda_can"]),
    ("A heap of bolts, about ten.", "10 bolt", &["pile of 10 bolt"]),
    ("A row of candles, five in total.", "5 candle", &["row of 5 candle"]),
    (
        "The pencils form a line from front to back; there are four of them.",
        "4 pencil",
        &["column of 4 pencil"],
    ),
    ("Five dice form a row.", "5 dice", &["row of 5 dice"]),
    (
        "The bottles are lined up from left to right; there are three.",
        "3 water_bottle",
        &["row of 3 water_bottle"],
    ),
    ("Six mugs arranged to form a circle.", "6 mug", &["circle of 6 mug"]),
    (
        "Stack three saucers and put a teacup on the topmost one.",
        "3 saucer, 1 teacup",
        &["saucer_3 stacked_on saucer_2", "teacup_1 on saucer_3"],
    ),
    (
        "Two stacks: one of three plates, one of two bowls.",
        "3 plate, 2 bowl",
        &["plate_3 stacked_on plate_2", "bowl_2 stacked_on bowl_1"],
    ),
    (
        "A tower of two books and one of three plates.",
        "2 book, 3 plate",
        &["book_2 stacked_on book_1", "plate_3 stacked_on plate_2"],
    ),
    (
        "A candle on every plate, three plates altogether, side by side.",
        "3 candle, 3 plate",
        &["candle_3 on plate_3", "row of 3 plate"],
    ),
    ("A spoon on each saucer, four saucers in total.", "4 spoon, 4 saucer", &["spoon_4 on saucer_4"]),
    (
        "Four blocks, two red and two green, in a row with 5 cm gaps.",
        "4 block",
        &["block_1 red", "block_3 green", "row of 4 block"],
    ),
    // Coordination.
    (
        "Bananas and pears, two of each, in a fruit bowl.",
        "2 banana, 2 pear, 1 bowl",
        &["banana_2 in bowl_1", "pear_2 in bowl_1"],
    ),
    (
        "A black, a white and a red bowl next to a stack of two plates.",
        "3 bowl, 2 plate",
        &["bowl_1 black", "bowl_2 white", "bowl_3 red"],
    ),
    ("A small, a medium and a large bowl.", "3 bowl", &[]),
    ("A plate and a bowl, both white.", "1 plate, 1 bowl", &["plate_1 white", "bowl_1 white"]),
    (
        "A tray with one glass per person for three persons.",
        "1 tray, 3 drinking_glass",
        &["drinking_glass_3 on tray_1"],
    ),
    (
        "Objects:\n- 2 red cubes\n- 1 blue bowl\n- a spoon (metal)",
        "2 cube, 1 bowl, 1 spoon",
        &["cube_2 red", "bowl_1 blue", "spoon_1 steel"],
    ),
    (
        "Two plates (26 cm, white), one of them on a tray.",
        "2 plate, 1 tray",
        &["plate_1 white", "plate_2 white", "plate_1 on tray_1", "!plate_2 on"],
    ),
    (
        "Put down a tray. On the tray there are two teacups; one of them is pink.",
        "1 tray, 2 teacup",
        &["teacup_1 pink", "teacup_1 on tray_1", "teacup_2 on tray_1", "!teacup_2 pink", "!?"],
    ),
    (
        "A box labeled \"nails\" and a hammer.",
        "1 storage_case, 1 hammer",
        &["? labeled \"nails: not_expressible"],
    ),
    // States.
    ("An open laptop and a closed book.", "1 laptop, 1 book", &["laptop_1 open", "book_1 closed"]),
    ("A microwave with the door open.", "1 microwave", &["? with the door open: not_supported"]),
    ("A toolbox whose lid is closed.", "1 toolbox", &["toolbox_1 closed"]),
    ("A toolbox with a closed lid and a hammer.", "1 toolbox, 1 hammer", &["toolbox_1 closed"]),
    ("A cabinet with its drawer closed and a pen.", "1 cabinet, 1 pen", &["cabinet_1 closed", "!pen_1 in"]),
    (
        "A crate flipped over with a cup on it.",
        "1 crate, 1 mug",
        &["crate_1 upside_down", "mug_1 on crate_1"],
    ),
    ("Two cups, one upside down.", "2 mug", &["mug_1 upside_down", "!mug_2 upside_down"]),
    ("Two cups, one upside down and one upright.", "2 mug", &["mug_1 upside_down", "!mug_2 upside_down"]),
    ("The wine glass has fallen over.", "1 wine_glass", &["wine_glass_1 lying_on_side"]),
    // Contradictions.
    ("A round square table with a plate.", "1 plate", &["? round: contradiction"]),
    ("A round table with a plate. The table is square.", "1 plate", &["? square: contradiction"]),
    (
        "A wine glass both on and under the tray.",
        "1 wine_glass, 1 tray",
        &["wine_glass_1 on tray_1", "? under: contradiction"],
    ),
    ("The toolbox is open and closed.", "1 toolbox", &["? closed: contradiction"]),
    (
        "A mug to the left and to the right of the plate.",
        "1 mug, 1 plate",
        &["? to the left and to the right of: contradiction"],
    ),
    // References across sentences and lists.
    (
        "There are three mugs: red, green and yellow. The yellow mug is behind the red one.",
        "3 mug",
        &["mug_2 yellow", "mug_3 red", "mug_2 behind mug_3", "mug_1 green"],
    ),
    ("Two vases. One is blue, the other one is green.", "2 vase", &["vase_1 blue", "vase_2 green"]),
    (
        "A mug and a bowl. The former is blue, the latter is white.",
        "1 mug, 1 bowl",
        &["mug_1 blue", "bowl_1 white"],
    ),
    (
        "Three candles in a row. The first candle is red, the second is white, the third is blue.",
        "3 candle",
        &["candle_2 red", "candle_3 white", "candle_1 blue", "row of 3 candle"],
    ),
    (
        "A plate at the left and a plate at the right. Put a fork on the right plate.",
        "2 plate, 1 fork",
        &["fork_1 on plate_2"],
    ),
    (
        "A laptop. It is black. There is a mug to the left of it.",
        "1 laptop, 1 mug",
        &["mug_1 left_of laptop_1"],
    ),
    (
        "Two bananas and an apple. Both bananas are yellow and the only apple is green.",
        "2 banana, 1 apple",
        &["banana_1 yellow", "apple_1 green", "!?"],
    ),
    ("The bowl on the left; the bowl on the right.", "2 bowl", &["bowl_1 at_left", "bowl_2 at_right"]),
    ("laptop in the center, pen left of laptop", "1 laptop, 1 pen", &["pen_1 left_of laptop_1"]),
    (
        "The apple is left of the banana, which is left of the orange.",
        "1 apple, 1 banana, 1 orange",
        &["apple_1 left_of banana_1", "banana_1 left_of orange_1", "!apple_1 left_of orange_1"],
    ),
    (
        "A mug on a book that lies on a tray.",
        "1 mug, 1 book, 1 tray",
        &["mug_1 on book_1", "book_1 on tray_1"],
    ),
    // Counts of later sentences, members of sets.
    (
        "Every plate has a fork on its left and a knife on its right; there are three plates.",
        "3 plate, 3 fork, 3 knife",
        &["fork_3 left_of plate_3", "knife_3 right_of plate_3"],
    ),
    (
        "3 plates, 3 forks and 3 knives, each plate with a fork on the left and a knife on the right.",
        "3 plate, 3 fork, 3 knife",
        &["fork_3 left_of plate_3", "knife_1 right_of plate_1"],
    ),
    ("One egg in each of three bowls.", "3 egg, 3 bowl", &["egg_3 in bowl_3"]),
    ("Every cup has its own saucer; there are four cups.", "4 mug, 4 saucer", &[]),
    (
        "Four mugs: two red, one blue and one green.",
        "4 mug",
        &["mug_1 red", "mug_2 red", "mug_3 blue", "mug_4 green"],
    ),
    (
        "Some fruit in a bowl, e.g. two apples, a banana and a pear.",
        "1 bowl, 2 apple, 1 banana, 1 pear",
        &["apple_1 in bowl_1", "pear_1 in bowl_1"],
    ),
    (
        "Three cans, two standing and one on its side.",
        "3 soda_can",
        &["soda_can_3 lying_on_side", "!soda_can_1 lying"],
    ),
    ("a red, green, and blue cube", "3 cube", &["cube_1 red", "cube_2 green", "cube_3 blue"]),
    ("One small, one medium and one large cube.", "3 cube", &[]),
    ("fork (x3), spoon x2, plate: 0", "3 fork, 2 spoon", &["no plate"]),
    ("- name: hammer\n  count: 2\n- name: mug\n  color: red", "2 hammer, 1 mug", &["mug_1 red"]),
    // Notes.
    (
        "kettle top right, mug bottom left",
        "1 kettle, 1 mug",
        &["kettle_1 at_back_right", "mug_1 at_front_left"],
    ),
    ("Upper right corner: a clock.", "1 desk_clock", &["desk_clock_1 at_back_right"]),
    (
        "A mug @ (0.1, 0.2) m and a bowl at (-10, 5) cm.",
        "1 mug, 1 bowl",
        &["mug_1 p 100 200", "bowl_1 p -100 50"],
    ),
    ("A bowl 25 cm to the left of the center.", "1 bowl", &["bowl_1 p -250 0"]),
    ("A bowl no more than 10 cm from the plate.", "1 bowl, 1 plate", &["bowl_1 next_to plate_1 10cm"]),
    ("A lamp a foot from the back edge.", "1 desk_lamp", &["desk_lamp_1 from_back_edge 30cm"]),
    (
        "A cube with 5 cm sides and a bottle half a liter in volume.",
        "1 cube, 1 water_bottle",
        &["cube_1 z 50 mm"],
    ),
    ("A candle, Ø 5 cm, h 12 cm", "1 candle", &["candle_1 x 50 mm", "candle_1 z 120 mm"]),
    ("A mug behind the plate, 5 cm away.", "1 mug, 1 plate", &["mug_1 behind plate_1 5cm"]),
    ("Two vases at the left and right edge.", "2 vase", &["vase_1 at_left", "vase_2 at_right"]),
    (
        "A lamp at the back, a keyboard at the front, and a mug halfway between.",
        "1 desk_lamp, 1 keyboard, 1 mug",
        &["mug_1 between desk_lamp_1 keyboard_1"],
    ),
    ("A fork and a knife side by side.", "1 fork, 1 knife", &[]),
    ("Surround the cake with five candles.", "1 cake, 5 candle", &["candle_5 around cake_1"]),
    (
        "A row of alternating red and blue cups, six in total.",
        "6 mug",
        &["mug_1 red", "mug_2 blue", "row of 6 mug"],
    ),
    ("Two cups facing each other.", "2 mug", &["mug_1 facing mug_2", "mug_2 facing mug_1"]),
    // More exclusions and contradictions.
    ("A desk with a monitor, minus the keyboard and the mouse.", "1 monitor", &["no keyboard", "no mouse"]),
    ("A bare table except for one cactus.", "1 cactus", &["!filled"]),
    ("A desk with a mug. Replace the mug with a glass.", "1 drinking_glass", &["no mug"]),
    ("A cluttered desk with exactly one laptop", "1 laptop", &["filled"]),
    ("A small large bowl.", "1 bowl", &["? large: contradiction"]),
    ("A wooden steel spoon.", "1 spoon", &["? steel: contradiction"]),
    ("A mug on a book that lies on the mug.", "1 mug, 1 book", &["? on: contradiction"]),
    ("A box with an apple in it.", "1 cardboard_box, 1 apple", &["apple_1 in cardboard_box_1"]),
    ("The cabinet has a closed drawer.", "1 cabinet", &["cabinet_1 closed"]),
    ("Two upright bottles and one lying bottle.", "3 water_bottle", &["water_bottle_3 lying_on_side"]),
];

/// Statements of a description, in the words of the table.
fn facts(description: &SceneDescription) -> Vec<String> {
    let words = vocabulary::vocabulary();
    let name = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let named = |kind: RelationKind| name(serde_json::to_value(kind).expect("a name"));
    let mut facts: Vec<String> = description.excluded_categories.iter().map(|c| format!("no {c}")).collect();
    for object in &description.objects {
        let id = object.id.as_str();
        let mut add = |fact: String| facts.push(format!("{id} {fact}"));
        for word in words.colors.keys().filter(|word| phrase::color_of(words, word) == object.color) {
            add(word.clone());
        }
        object.material.iter().chain(&object.state).for_each(|word| add(word.clone()));
        add(name(serde_json::to_value(object.pose).expect("a name")));
        add(format!("x {:.0} mm", 1000.0 * object.size_m.x));
        add(format!("z {:.0} mm", 1000.0 * object.size_m.z));
        if let Some(position) = object.position_m {
            add(format!("p {:.0} {:.0}", 1000.0 * position.x, 1000.0 * position.y));
        }
        for relation in &object.relations {
            let ids = [&relation.target, &relation.second_target];
            let ids: String = ids.into_iter().flatten().map(|id| format!(" {}", id.as_str())).collect();
            let distance = relation.distance_m.map_or(String::new(), |m| format!(" {:.0}cm", 100.0 * m));
            add(format!("{}{ids}{distance}", named(relation.kind)));
        }
    }
    for group in &description.arrangements {
        let kind = serde_json::to_value(group.kind).expect("a kind");
        let first =
            description.objects.iter().find(|object| object.id == group.objects[0]).expect("a member");
        facts.push(format!(
            "{} of {} {}",
            name(kind["arrangement"].clone()),
            group.objects.len(),
            first.category
        ));
    }
    for part in &description.unrecognized {
        let reason = name(serde_json::to_value(part.reason).expect("a name"));
        facts.push(format!("? {}: {reason}", part.span.text));
    }
    let filled = description.objects.iter().any(|object| !object.requested);
    facts.extend(filled.then(|| "filled".to_owned()));
    facts.extend(description.goal.as_ref().map(|_| "goal".to_owned()));
    facts
}

#[test]
fn descriptive_sentences_state_their_facts() {
    check(TABLE);
}

/// Parses every text of a table and reports all that differs.
pub(super) fn check(table: &[(&str, &str, &[&str])]) {
    let mut faults = Vec::new();
    for (text, counts, expected) in table {
        let description = describe_seed(text, 3);
        let summary = summary(&description);
        let read = summary.split(" | ").next().expect("counts").split(" +").next().expect("counts");
        if read != *counts {
            faults.push(format!("{text}: {summary}"));
        }
        let facts = facts(&description);
        for fact in *expected {
            let holds = match fact.strip_prefix('!') {
                Some(absent) => !facts.iter().any(|fact| fact.starts_with(absent)),
                None => facts.iter().any(|known| known == fact),
            };
            if !holds {
                faults.push(format!("{text}: {fact:?} in {facts:?}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
