//! Generators of the office and living room family.
//!
//! Each draws in meters inside the ordered extents, front toward -y, and is scaled to them exactly
//! at the end (`parts::fitted`).

mod parts;
mod pictures;
mod computers;
mod handhelds;
mod reading;

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
];
