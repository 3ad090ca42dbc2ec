//! In place of a bucket in a program that was built without the feature `s3`: it opens none.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use object_store::path::Path as ObjectPath;
use object_store::{ObjectStore, Result};

use super::S3Settings;
use crate::StoreError;

/// A bucket that cannot exist.
#[derive(Clone)]
pub(in crate::blobs) enum Bucket {}

impl Bucket {
    pub(in crate::blobs) fn open(_: &S3Settings) -> Result<Self, StoreError> {
        Err(StoreError::NotBuilt { what: "S3", feature: "s3" })
    }

    pub(in crate::blobs) fn objects(&self) -> Arc<dyn ObjectStore> {
        match *self {}
    }

    pub(in crate::blobs) async fn put(&self, _: &ObjectPath, _: Bytes, _: Duration) -> Result<()> {
        match *self {}
    }

    pub(in crate::blobs) async fn presigned(
        &self,
        _: &ObjectPath,
        _: Duration,
        _: &str,
        _: Option<&str>,
    ) -> Result<String> {
        match *self {}
    }
}
