//! The statement of a list: only the conditions that are asked for, so that each list finds its index and a later page
//! costs what the first one costs.

use sqlx::any::{Any, AnyRow};
use sqlx::{AssertSqlSafe, Executor};

use super::StoreError;
use scene::TenantId;

/// Order of a list by its ids, which grow with time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    NewestFirst,
    OldestFirst,
}

impl Order {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::NewestFirst => "DESC",
            Self::OldestFirst => "ASC",
        }
    }
}

/// Conditions on the rows of one table, newest first by `id`.
#[derive(Debug)]
pub(super) struct ListQuery {
    conditions: String,
    values: Vec<Value>,
}

#[derive(Debug)]
enum Value {
    Text(String),
    Number(i64),
}

impl ListQuery {
    /// The rows of a tenant.
    pub(super) fn of(tenant_id: &TenantId) -> Self {
        let values = vec![Value::Text(tenant_id.to_string())];
        Self { conditions: "tenant_id = $1".to_owned(), values }
    }

    /// The rows of all tenants, for the operator.
    pub(super) fn of_all() -> Self {
        Self { conditions: "TRUE".to_owned(), values: Vec::new() }
    }

    /// A condition without parameters. It stands in the text, so that it finds a partial index.
    pub(super) fn fixed(mut self, condition: &str) -> Self {
        self.conditions.push_str(" AND ");
        self.conditions.push_str(condition);
        self
    }

    /// A column has one of the program's own words, which stands in the text as well.
    pub(super) fn word(self, column: &str, word: Option<&'static str>) -> Self {
        match word {
            Some(word) => self.fixed(&format!("{column} = '{word}'")),
            None => self,
        }
    }

    /// A comparison with a text, such as `id <`.
    pub(super) fn text(mut self, comparison: &str, text: Option<impl Into<String>>) -> Self {
        if let Some(text) = text {
            let place = self.bind(Value::Text(text.into()));
            self.conditions.push_str(&format!(" AND {comparison} {place}"));
        }
        self
    }

    /// A comparison with a number, such as `created_at >`.
    pub(super) fn number(mut self, comparison: &str, number: Option<i64>) -> Self {
        if let Some(number) = number {
            let place = self.bind(Value::Number(number));
            self.conditions.push_str(&format!(" AND {comparison} {place}"));
        }
        self
    }

    /// The parameter of a text that is used in a condition of its own.
    pub(super) fn parameter(&mut self, text: impl Into<String>) -> String {
        self.bind(Value::Text(text.into()))
    }

    /// The list: at most `limit` rows of `table`.
    pub(super) fn select(self, table: &str, limit: u32) -> Statement {
        self.select_in("*", "id", table, Order::NewestFirst, limit)
    }

    /// The same with some columns, in an order by another column with the ids of the rows.
    pub(super) fn select_in(
        mut self,
        columns: &str,
        id: &str,
        table: &str,
        order: Order,
        limit: u32,
    ) -> Statement {
        let (place, order) = (self.bind(Value::Number(i64::from(limit))), order.word());
        let conditions = &self.conditions;
        let sql =
            format!("SELECT {columns} FROM {table} WHERE {conditions} ORDER BY {id} {order} LIMIT {place}");
        Statement { sql, values: self.values }
    }

    fn bind(&mut self, value: Value) -> String {
        self.values.push(value);
        format!("${}", self.values.len())
    }
}

/// A list that can be read, or be a part of a larger statement.
#[derive(Debug)]
pub(super) struct Statement {
    sql: String,
    values: Vec<Value>,
}

impl Statement {
    /// The list inside another statement.
    pub(super) fn within(self, wrap: impl FnOnce(&str) -> String) -> Self {
        Self { sql: wrap(&self.sql), values: self.values }
    }

    /// The rows.
    pub(super) async fn rows<'c>(
        self,
        readers: impl Executor<'c, Database = Any>,
    ) -> Result<Vec<AnyRow>, StoreError> {
        let query = sqlx::query(AssertSqlSafe(self.sql));
        let query = self.values.into_iter().fold(query, |query, value| match value {
            Value::Text(text) => query.bind(text),
            Value::Number(number) => query.bind(number),
        });
        Ok(query.fetch_all(readers).await?)
    }
}
