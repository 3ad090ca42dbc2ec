//! The workbench and utility family.

mod fastening;
mod gripping;
mod cutting;
mod measuring;
mod containers;
mod supplies;

use super::Generator;

/// Name of the category and the function that builds it.
pub const GENERATORS: &[(&str, Generator)] = &[
    ("hammer", fastening::hammer),
    ("screwdriver", fastening::screwdriver),
    ("bolt", fastening::bolt),
    ("nut", fastening::nut),
    ("power_drill", fastening::power_drill),
    ("wrench", gripping::wrench),
    ("adjustable_wrench", gripping::adjustable_wrench),
    ("pliers", gripping::pliers),
    ("c_clamp", gripping::c_clamp),
    ("hand_saw", cutting::hand_saw),
    ("utility_knife", cutting::utility_knife),
    ("chisel", cutting::chisel),
    ("hand_plane", cutting::hand_plane),
    ("tape_measure", measuring::tape_measure),
    ("spirit_level", measuring::spirit_level),
    ("multimeter", measuring::multimeter),
    ("toolbox", containers::toolbox),
    ("storage_bin", containers::storage_bin),
    ("paint_can", containers::paint_can),
    ("oil_can", containers::oil_can),
    ("glue_bottle", containers::glue_bottle),
    ("funnel", supplies::funnel),
    ("flashlight", supplies::flashlight),
    ("wire_spool", supplies::wire_spool),
];
