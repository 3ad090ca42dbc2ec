//! Generators of the office and living room family.
//!
//! Each models in meters inside the requested extents, front toward -y, and scales the mesh to them exactly
//! at the end (`parts::fitted`).

mod parts;
mod images;
mod computers;
mod handhelds;
mod reading;
mod writing;
mod appliances;
mod decor;
mod curios;
mod plants;

use super::Generator;

/// Name of the category and the function that builds it.
pub const GENERATORS: &[(&str, Generator)] = &[
    ("laptop", computers::laptop),
    ("monitor", computers::monitor),
    ("keyboard", computers::keyboard),
    ("mouse", computers::mouse),
    ("smartphone", handhelds::smartphone),
    ("tablet", handhelds::tablet),
    ("calculator", handhelds::calculator),
    ("remote_control", handhelds::remote_control),
    ("game_controller", handhelds::game_controller),
    ("book", reading::book),
    ("notebook", reading::notebook),
    ("paper_stack", reading::paper_stack),
    ("sticky_notes", reading::sticky_notes),
    ("bookend", reading::bookend),
    ("pen", writing::pen),
    ("pencil", writing::pencil),
    ("pen_holder", writing::pen_holder),
    ("stapler", writing::stapler),
    ("tape_dispenser", writing::tape_dispenser),
    ("file_tray", writing::file_tray),
    ("headphones", appliances::headphones),
    ("speaker", appliances::speaker),
    ("desk_lamp", appliances::desk_lamp),
    ("desk_fan", appliances::desk_fan),
    ("desk_clock", appliances::desk_clock),
    ("potted_plant", plants::potted_plant),
    ("cactus", plants::cactus),
    ("vase", decor::vase),
    ("candle", decor::candle),
    ("coaster", decor::coaster),
    ("eyeglasses", curios::eyeglasses),
    ("globe", curios::globe),
    ("picture_frame", decor::picture_frame),
    ("tissue_box", decor::tissue_box),
    ("hourglass", curios::hourglass),
    ("rubiks_cube", curios::rubiks_cube),
];
