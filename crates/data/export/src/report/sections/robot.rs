//! Abilities of a robot in the scene: counts, and a table with one row per task.

use certificate::RobotFinding;
use markup::html::{Cell, Html};

pub fn write(page: &mut Html, finding: &RobotFinding) {
    let RobotFinding { name, objects, pickable, tasks_proposed, tasks_done, tasks } = finding;
    let words = format!(
        "In simulation, {name} picks up {pickable} of {objects} objects where they are, and does {tasks_done} of \
         {tasks_proposed} tasks that move them. The verdict does not depend on it."
    );
    page.leaf("p", &[], &words);
    if tasks.is_empty() {
        return;
    }
    let row = |task: &certificate::TaskTried| {
        vec![Cell::UserText(task.instruction.clone()), Cell::Words(task.outcome.replace('_', " "))]
    };
    page.table("", &["Task", "Outcome"], tasks.iter().map(row).collect());
}
