//! Tables of the model's ratings, one row per criterion, and of its proposed tasks, one row per task; then missing
//! answers.

use crate::report::Report;
use crate::report::numbers::word;
use markup::html::{Cell, Html};
use scene::appraisal::{Appraisal, ModelResponse};

pub fn write(page: &mut Html, report: &Report<'_>, appraisal: &Appraisal) {
    if let Some(ratings) = &appraisal.ratings {
        let rows = ratings.said.iter().map(|rating| {
            vec![
                Cell::Words(word(rating.criterion)),
                Cell::Number(format!("{} of 7", rating.score)),
                Cell::UserText(rating.why.clone()),
            ]
        });
        page.table("", &["Rated", "Score", "Why"], rows.collect());
        source(page, ratings);
    }
    if let Some(tasks) = &appraisal.tasks {
        let label_of = |name: &str| {
            let instances = &report.scene.instances;
            let found = instances.iter().find(|instance| instance.name.as_str() == name);
            found.map_or_else(|| name.to_owned(), |instance| format!("{name} ({})", instance.label))
        };
        let rows = tasks.said.iter().map(|task| {
            let objects: Vec<String> = task.objects.iter().map(|name| label_of(name.as_str())).collect();
            vec![
                Cell::UserText(task.instruction.clone()),
                Cell::Words(word(task.kind)),
                Cell::UserText(objects.join(", ")),
            ]
        });
        page.table("", &["Task", "Kind", "About"], rows.collect());
        source(page, tasks);
    }
    for reason in &appraisal.missing {
        page.open("p", &[]);
        page.text("Not given: ");
        page.user_text(reason);
        page.close();
    }
}

fn source<T>(page: &mut Html, response: &ModelResponse<T>) {
    let ModelResponse { by, model, prompt, .. } = response;
    let words = format!(
        "Answered by {by}, model {model}, asked with prompt {prompt}. The verdict does not depend on it."
    );
    page.leaf("p", &[], &words);
}
