//! In place of the driver in a program that was built without the feature `postgres`: it opens no connection.

use std::time::Duration;

use sqlx::error::DatabaseError;
use sqlx::{AnyConnection, AnyPool};

use super::{Intent, Settings, StoreError};

const NOT_BUILT: StoreError = StoreError::NotBuilt { what: "PostgreSQL", feature: "postgres" };

pub(super) async fn pool(_: &str, _: &Settings, _: Intent) -> Result<AnyPool, StoreError> {
    Err(NOT_BUILT)
}

pub(super) async fn session(_: &str, _: &Settings) -> Result<AnyConnection, StoreError> {
    Err(NOT_BUILT)
}

pub(super) fn is_error(_: &dyn DatabaseError) -> bool {
    false
}

/// A connection that cannot exist.
pub(super) enum Listener {}

impl Listener {
    pub(super) async fn connect(_: &str, _: Duration) -> Result<Self, StoreError> {
        Err(NOT_BUILT)
    }

    pub(super) async fn listen(&mut self, _: &str) -> Result<(), sqlx::Error> {
        match *self {}
    }

    pub(super) async fn heard(&mut self) -> Result<Option<String>, sqlx::Error> {
        match *self {}
    }
}
