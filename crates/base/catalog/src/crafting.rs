//! The crafting and hobby family.

mod models;
mod painting;
mod sewing;
mod drawing;
mod tools;
mod toys;

use super::Generator;

/// Name of the category and the function that builds it.
pub const GENERATORS: &[(&str, Generator)] = &[
    ("model_car", models::model_car),
    ("model_airplane", models::model_airplane),
    ("paint_bottle", painting::paint_bottle),
    ("paintbrush", painting::paintbrush),
    ("paint_palette", painting::paint_palette),
    ("watercolor_set", painting::watercolor_set),
    ("canvas_board", painting::canvas_board),
    ("thread_spool", sewing::thread_spool),
    ("yarn_ball", sewing::yarn_ball),
    ("sewing_machine", sewing::sewing_machine),
    ("pin_cushion", sewing::pin_cushion),
    ("button", sewing::button),
    ("embroidery_hoop", sewing::embroidery_hoop),
    ("ruler", drawing::ruler),
    ("glue_stick", drawing::glue_stick),
    ("cutting_mat", drawing::cutting_mat),
    ("crayon_box", drawing::crayon_box),
    ("color_pencil", drawing::color_pencil),
    ("marker", drawing::marker),
    ("scissors", tools::scissors),
    ("magnifying_glass", tools::magnifying_glass),
    ("hot_glue_gun", tools::hot_glue_gun),
    ("storage_case", tools::storage_case),
    ("dice", toys::dice),
    ("chess_pawn", toys::chess_pawn),
    ("playing_cards", toys::playing_cards),
    ("building_brick", toys::building_brick),
    ("teddy_bear", toys::teddy_bear),
];
