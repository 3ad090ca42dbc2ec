//! The account of the text: the goal, what edits changed, what was understood, what was not, demands that the layout
//! does not meet, stand-ins and fillings.

use crate::report::Report;
use markup::html::{Cell, Html};
use scene::InstanceId;
use scene::text_account::TextAccount;

pub fn write(page: &mut Html, report: &Report<'_>, account: &TextAccount) {
    if let Some(goal) = &account.goal {
        page.leaf("h3", &[], "Goal");
        page.open("p", &[]);
        page.text("The scene shows the start state of the instruction ");
        page.user_text(&goal.instruction);
        page.text(". At the end, all of these hold:");
        page.close();
        let rows = goal.predicates.iter().map(|predicate| vec![Cell::Words(predicate.to_string())]);
        page.table("", &["Condition"], rows.collect());
    }
    if let Some(scene) = &account.of_scene {
        let words = format!("The text is that of scene {scene}, from which edits made this one.");
        page.leaf("p", &[], &words);
    }
    if !account.changed.is_empty() {
        page.leaf("h3", &[], "Changed by edits");
        let rows = account
            .changed
            .iter()
            .map(|part| vec![Cell::UserText(part.span.text.clone()), Cell::Words(part.by.clone())]);
        page.table("", &["Words", "Change"], rows.collect());
    }
    if !account.unrecognized.is_empty() {
        page.leaf("h3", &[], "Without effect");
        let rows = account.unrecognized.iter().map(|part| {
            vec![
                Cell::UserText(part.span.text.clone()),
                Cell::Words(part.reason.to_string()),
                Cell::Words(part.nearest_by_spelling.clone().unwrap_or_default()),
                Cell::Words(part.nearest_by_meaning.clone().unwrap_or_default()),
            ]
        });
        page.table("", &["Words", "Reason", "Nearest by spelling", "Nearest by meaning"], rows.collect());
    }
    if !account.unmet.is_empty() {
        page.leaf("h3", &[], "Not met by the layout");
        page.leaf("p", &[], "No layout was found that meets all demands; these yielded.");
        let rows = account.unmet.iter().map(|unmet| vec![Cell::Words(unmet.to_string())]);
        page.table("", &["Demand"], rows.collect());
    }
    objects(
        page,
        report,
        "Stand-ins",
        "The catalog does not have these objects; the list of objects says what stands in for each.",
        &account.stand_ins,
    );
    objects(
        page,
        report,
        "Fillings",
        "The text does not name them; its theme added them.",
        &account.fillings,
    );
    page.leaf("h3", &[], "Understood");
    if account.understood.is_empty() {
        page.leaf("p", &[], "Nothing.");
        return;
    }
    let rows = account
        .understood
        .iter()
        .map(|part| vec![Cell::UserText(part.span.text.clone()), Cell::Words(part.meaning.to_string())]);
    page.table("", &["Words", "Meaning"], rows.collect());
}

/// Objects with their labels. A name that the scene does not have has no label.
fn objects(page: &mut Html, report: &Report<'_>, title: &str, note: &str, names: &[InstanceId]) {
    if names.is_empty() {
        return;
    }
    page.leaf("h3", &[], title);
    page.leaf("p", &[], note);
    let rows = names.iter().map(|name| {
        match report.scene.instances.iter().find(|instance| &instance.name == name) {
            Some(instance) => vec![Cell::Body(name.to_string()), Cell::UserText(instance.label.clone())],
            None => vec![Cell::Words(name.to_string()), Cell::Words("not in the scene".to_owned())],
        }
    });
    page.table("", &["Object", "Words"], rows.collect());
}
