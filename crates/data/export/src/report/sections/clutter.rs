//! Clutter of the scene: measurements in a sentence, and a table with one row per object.

use markup::html::{Cell, Html};
use scene::clutter::{ClutterFinding, ClutterPlacement};

pub fn write(page: &mut Html, finding: &ClutterFinding) {
    let ClutterFinding { density, covered_share, mean_contacts, touching, hidden_share, objects } = finding;
    let words = format!(
        "Objects were dropped onto the table with density {density:.2}. They cover {:.0} % of the area under the heap; \
         {touching} of {} touch another one, with {mean_contacts:.1} contacts on average; a quarter or more of {:.0} % of \
         them is hidden in the first image or from above. Their poses are those after the drop, so the reference image \
         does not decide the verdict.",
        100.0 * covered_share,
        objects.len(),
        100.0 * hidden_share,
    );
    page.leaf("p", &[], &words);
    let percent = |share: f64| Cell::Number(format!("{:.0} %", 100.0 * share));
    let rows = objects.iter().map(|object| {
        let placement = match object.placement {
            ClutterPlacement::Kept => "in its place",
            ClutterPlacement::Dropped => "dropped",
            ClutterPlacement::SetDown => "set down upright",
        };
        vec![
            Cell::Body(object.name.to_string()),
            Cell::Words(placement.to_owned()),
            Cell::Number(object.contacts.to_string()),
            percent(object.hidden_in_hero),
            percent(object.hidden_from_above),
        ]
    });
    let columns = ["Object", "Placement", "Touches", "Hidden in the first image", "Hidden from above"];
    page.table("", &columns, rows.collect());
}
