//! What a model thinks of the scene, where one was asked: a row a criterion, a row a task, and what was not given.

use crate::report::Report;
use crate::report::html::{Cell, Html};
use crate::report::numbers::word;
use scene::appraisal::{Appraisal, Opinion};

pub fn write(page: &mut Html, report: &Report<'_>, appraisal: &Appraisal) {
    if let Some(ratings) = &appraisal.ratings {
        let rows = ratings.said.iter().map(|rating| {
            vec![
                Cell::Words(word(rating.criterion)),
                Cell::Number(format!("{} of 7", rating.score)),
                Cell::Told(rating.why.clone()),
            ]
        });
        page.table("", &["Rated", "Score", "Why"], rows.collect());
        said_by(page, ratings);
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
                Cell::Told(task.instruction.clone()),
                Cell::Words(word(task.kind)),
                Cell::Told(objects.join(", ")),
            ]
        });
        page.table("", &["Task", "Kind", "About"], rows.collect());
        said_by(page, tasks);
    }
    for told in &appraisal.missing {
        page.open("p", &[]);
        page.text("Not given: ");
        page.told(told);
        page.close();
    }
}

fn said_by<T>(page: &mut Html, opinion: &Opinion<T>) {
    let Opinion { by, model, prompt, .. } = opinion;
    let words = format!(
        "Said by {by}, model {model}, asked with prompt {prompt}. The verdict does not depend on it."
    );
    page.leaf("p", &[], &words);
}
