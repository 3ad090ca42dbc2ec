//! Lists of scenes, and counts of those that a filter leaves.
//!
//! State, verdict, kind and number of objects lie in the index that a list follows, so that a filter reads no rows that
//! it leaves out. A label or a category is followed by its own index. Only words of the text are compared row by row.

use sqlx::Row;

use super::{SceneRow, scene_of};
use crate::boxed;
use crate::jobs::{JOINED_COLUMNS, JobRow, job_in};
use crate::lifecycle::SceneState;
use crate::list_query::{ListQuery, Order};
use crate::{Store, StoreError};
use scene::{SceneId, TenantId};

/// Scenes that are counted at most, the newest ones: bounds the cost of counts.
pub const MAX_COUNTED: u32 = 100_000;

/// Categories and labels that are counted at most, those with the greatest numbers.
const MAX_NAMES: u32 = 50;

/// Filter of a scene list.
#[derive(Clone, Debug, Default)]
pub struct SceneFilter {
    /// `None` = all but deleted scenes.
    pub state: Option<SceneState>,
    /// `true` = certified `pass`; `false` = `quarantine`.
    pub passed: Option<bool>,
    pub kind: Option<SceneKind>,
    pub label: Option<(String, String)>,
    /// A category that an object of the scene has.
    pub category: Option<String>,
    /// Words of the text of the request, in upper or lower case, all of them.
    pub words: Vec<String>,
    pub min_objects: Option<i64>,
    pub max_objects: Option<i64>,
    pub parent: Option<SceneId>,
    pub created_after_ms: Option<i64>,
    pub oldest_first: bool,
    /// Only scenes behind this id, the last id of the previous page.
    pub before_id: Option<SceneId>,
    pub limit: u32,
}

/// The source of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    Text,
    Image,
    Edit,
    Variant,
}

impl SceneKind {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Image => "image",
            Self::Edit => "edit",
            Self::Variant => "variant",
        }
    }
}

/// Counts of the scenes that a filter leaves.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneCounts {
    /// At most [`MAX_COUNTED`].
    pub total: i64,
    /// By state, verdict, kind; a scene without a verdict is in none.
    pub states: Vec<(String, i64)>,
    pub verdicts: Vec<(String, i64)>,
    pub kinds: Vec<(String, i64)>,
    /// By a category that an object has, the greatest numbers first.
    pub categories: Vec<(String, i64)>,
    /// By key and value of a label, the greatest numbers first.
    pub labels: Vec<((String, String), i64)>,
}

impl Store {
    /// Scenes of the tenant, newest first unless the filter says otherwise, each with its newest job.
    #[boxed]
    pub async fn scenes(
        &self,
        tenant_id: &TenantId,
        filter: SceneFilter,
    ) -> Result<Vec<(SceneRow, Option<JobRow>)>, StoreError> {
        let (limit, order) = (filter.limit, order_of(&filter));
        let (list, id, scenes) = self.filtered(tenant_id, filter);
        let list = list.select_in("*", &id, &scenes, order, limit).within(|scenes| {
            format!(
                "SELECT s.*, {JOINED_COLUMNS} FROM ({scenes}) AS s
                 LEFT JOIN jobs AS j
                        ON j.id = (SELECT id FROM jobs WHERE jobs.scene_id = s.id ORDER BY id DESC LIMIT 1)
                 ORDER BY s.id {}",
                order.word()
            )
        });
        let rows = list.rows(&self.readers).await?;
        rows.iter()
            .map(|row| {
                let has_job = row.try_get::<Option<String>, _>("job_id")?.is_some();
                Ok((scene_of(row)?, has_job.then(|| job_in(row, "job_")).transpose()?))
            })
            .collect()
    }

    /// Counts of the scenes of the tenant that a filter leaves, whatever page it asks for.
    #[boxed]
    pub async fn scene_counts(
        &self,
        tenant_id: &TenantId,
        filter: SceneFilter,
    ) -> Result<SceneCounts, StoreError> {
        let filter = SceneFilter { before_id: None, oldest_first: false, ..filter };
        let counted = |columns: &str| {
            let (list, id, scenes) = self.filtered(tenant_id, filter.clone());
            list.select_in(
                &format!("{id} AS counted_id{columns}"),
                &id,
                &scenes,
                Order::NewestFirst,
                MAX_COUNTED,
            )
        };
        let facts = counted(", state, verdict, kind").within(|scenes| {
            format!("SELECT state, verdict, kind, COUNT(*) AS scenes FROM ({scenes}) AS counted GROUP BY state, verdict, kind")
        });
        let mut counts = SceneCounts::default();
        for row in facts.rows(&self.readers).await? {
            let scenes: i64 = row.try_get("scenes")?;
            counts.total += scenes;
            for (column, counts) in [
                ("state", &mut counts.states),
                ("verdict", &mut counts.verdicts),
                ("kind", &mut counts.kinds),
            ] {
                if let Some(word) = row.try_get::<Option<String>, _>(column)? {
                    add(counts, word, scenes);
                }
            }
        }
        for counts in [&mut counts.states, &mut counts.verdicts, &mut counts.kinds] {
            counts.sort_by(|(word, scenes), (other, of_other)| (of_other, word).cmp(&(scenes, other)));
        }
        let categories = counted("").within(|scenes| {
            format!(
                "SELECT category, COUNT(*) AS scenes FROM ({scenes}) AS counted
                 JOIN scene_categories AS named ON named.scene_id = counted.counted_id
                 GROUP BY category ORDER BY scenes DESC, category LIMIT {MAX_NAMES}"
            )
        });
        for row in categories.rows(&self.readers).await? {
            counts.categories.push((row.try_get("category")?, row.try_get("scenes")?));
        }
        let labels = counted("").within(|scenes| {
            format!(
                "SELECT key, value, COUNT(*) AS scenes FROM ({scenes}) AS counted
                 JOIN scene_labels AS named ON named.scene_id = counted.counted_id
                 GROUP BY key, value ORDER BY scenes DESC, key, value LIMIT {MAX_NAMES}"
            )
        });
        for row in labels.rows(&self.readers).await? {
            counts.labels.push(((row.try_get("key")?, row.try_get("value")?), row.try_get("scenes")?));
        }
        Ok(counts)
    }

    /// The conditions of a filter, the column with the ids of its scenes, and what they are read from.
    fn filtered(&self, tenant_id: &TenantId, filter: SceneFilter) -> (ListQuery, String, String) {
        let mut list = match filter.state {
            Some(state) => ListQuery::of(tenant_id).word("state", Some(state.as_str())),
            None => ListQuery::of(tenant_id).fixed("state <> 'deleted'"),
        };
        let join = self.readers.dialect().join_to_first();
        // Of a label and a category, one is followed and the other one compared.
        let followed = |table: &str, condition: &str| {
            let scenes = format!(
                "(SELECT named.scene_id AS named_id, scenes.* FROM {table} AS named
                  {join} scenes ON scenes.id = named.scene_id
                  WHERE named.tenant_id = $1 AND {condition}) AS scenes"
            );
            ("named_id".to_owned(), scenes)
        };
        let (mut id, mut scenes) = ("id".to_owned(), "scenes".to_owned());
        let is_labeled = filter.label.is_some();
        if let Some((key, value)) = filter.label {
            let (key, value) = (list.parameter(key), list.parameter(value));
            let condition = format!("named.key = {key} AND named.value = {value}");
            (id, scenes) = followed("scene_labels", &condition);
        }
        if let Some(category) = filter.category {
            let condition = format!("named.category = {}", list.parameter(category));
            if is_labeled {
                list = list.fixed(&format!(
                    "EXISTS (SELECT 1 FROM scene_categories AS named
                             WHERE named.tenant_id = $1 AND {condition} AND named.scene_id = {id})"
                ));
            } else {
                (id, scenes) = followed("scene_categories", &condition);
            }
        }
        let like = self.readers.dialect().like_any_case();
        for word in filter.words {
            let pattern = list.parameter(containing(&word));
            list = list.fixed(&format!(r"request_text {like} {pattern} ESCAPE '\'"));
        }
        let behind = if filter.oldest_first { ">" } else { "<" };
        let list = list
            .word("verdict", filter.passed.map(|passed| if passed { "pass" } else { "quarantine" }))
            .word("kind", filter.kind.map(SceneKind::as_str))
            .number("objects >=", filter.min_objects)
            .number("objects <=", filter.max_objects)
            .text("parent_id =", filter.parent)
            .number("created_at >", filter.created_after_ms)
            .text(&format!("{id} {behind}"), filter.before_id);
        (list, id, scenes)
    }
}

fn order_of(filter: &SceneFilter) -> Order {
    if filter.oldest_first { Order::OldestFirst } else { Order::NewestFirst }
}

fn add(counts: &mut Vec<(String, i64)>, word: String, scenes: i64) {
    match counts.iter_mut().find(|(known, _)| *known == word) {
        Some((_, count)) => *count += scenes,
        None => counts.push((word, scenes)),
    }
}

/// The pattern of texts that contain a word.
fn containing(word: &str) -> String {
    let mut pattern = String::from("%");
    for character in word.chars() {
        if matches!(character, '%' | '_' | '\\') {
            pattern.push('\\');
        }
        pattern.push(character);
    }
    pattern.push('%');
    pattern
}
