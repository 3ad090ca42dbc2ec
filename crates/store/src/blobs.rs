//! Content-addressed blobs in an object store: a local directory, or the memory of the process.
//!
//! A put always writes, even if the blob exists. A garbage collector that has marked the old copy therefore cannot
//! remove it before the new row refers to it. A local put is durable when it returns: file and directories are synced
//! unless the settings disable that.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::stream::BoxStream;
use futures::{StreamExt, TryStreamExt};
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path as ObjectPath;
use object_store::{GetOptions, GetRange, ObjectStore, ObjectStoreExt};

use super::outage::{Health, Part};
use super::{Digest, StoreError};

/// Handle on the blobs; cloning shares it.
#[derive(Clone)]
pub struct Blobs {
    objects: Arc<dyn ObjectStore>,
    /// Whether other programs can change the bytes.
    reachable: bool,
    health: Health,
}

impl Blobs {
    /// Blobs in a local directory, which is created if missing.
    pub(super) fn local(root: &Path, fsync: bool, health: Health) -> Result<Self, StoreError> {
        std::fs::create_dir_all(root)
            .map_err(|source| StoreError::DataDir { path: root.to_owned(), source })?;
        let files = LocalFileSystem::new_with_prefix(root)
            .map_err(|source| StoreError::Blob { name: root.display().to_string(), doing: "opened", source })?
            .with_fsync(fsync);
        Ok(Self { objects: Arc::new(files), reachable: true, health })
    }

    /// Blobs in memory, lost at the end of the process.
    pub(super) fn in_memory(health: Health) -> Self {
        Self { objects: Arc::new(InMemory::new()), reachable: false, health }
    }

    /// Stores `bytes` and returns their digest. On return the blob may be referred to.
    pub async fn put(&self, bytes: impl Into<Bytes>) -> Result<Digest, StoreError> {
        let bytes: Bytes = bytes.into();
        let digest = if bytes.len() > 1 << 20 {
            let copy = bytes.clone();
            match tokio::task::spawn_blocking(move || Digest::of(&copy)).await {
                Ok(digest) => digest,
                Err(_) => Digest::of(&bytes),
            }
        } else {
            Digest::of(&bytes)
        };
        match self.objects.put(&path_of(&digest), bytes.into()).await {
            Ok(_) => {
                self.health.succeeded(Part::Blobs);
                Ok(digest)
            }
            Err(source) => {
                let error = failed(&digest, "written", source);
                self.health.failed(Part::Blobs, &error);
                Err(error)
            }
        }
    }

    /// The bytes, or `None` if the blob is missing or does not match its digest.
    pub async fn get(&self, digest: &Digest) -> Result<Option<Bytes>, StoreError> {
        let found = match self.objects.get(&path_of(digest)).await {
            Ok(found) => found,
            Err(object_store::Error::NotFound { .. }) => return Ok(None),
            Err(source) => return Err(failed(digest, "opened", source)),
        };
        let bytes = found.bytes().await.map_err(|source| failed(digest, "read", source))?;
        if !self.reachable || Digest::of(&bytes) == *digest {
            Ok(Some(bytes))
        } else {
            tracing::warn!(%digest, "a blob's bytes do not match its name; treating it as missing");
            Ok(None)
        }
    }

    /// A range of the bytes as a stream (`end` exclusive; `None` = all bytes), without verification.
    pub async fn stream(
        &self,
        digest: &Digest,
        range: Option<Range<u64>>,
    ) -> Result<Option<BoxStream<'static, Result<Bytes, StoreError>>>, StoreError> {
        let options = GetOptions { range: range.map(GetRange::Bounded), ..GetOptions::default() };
        let found = match self.objects.get_opts(&path_of(digest), options).await {
            Ok(found) => found,
            Err(object_store::Error::NotFound { .. }) => return Ok(None),
            Err(source) => return Err(failed(digest, "opened", source)),
        };
        let digest = digest.clone();
        Ok(Some(found.into_stream().map_err(move |source| failed(&digest, "read", source)).boxed()))
    }

    /// Whether the blob exists.
    pub async fn contains(&self, digest: &Digest) -> Result<bool, StoreError> {
        match self.objects.head(&path_of(digest)).await {
            Ok(_) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(source) => Err(failed(digest, "looked up", source)),
        }
    }
}

fn path_of(digest: &Digest) -> ObjectPath {
    let hex = digest.as_str();
    ObjectPath::from(format!("sha256/{}/{hex}", &hex[..2]))
}

fn failed(digest: &Digest, doing: &'static str, source: object_store::Error) -> StoreError {
    StoreError::Blob { name: digest.to_string(), doing, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn local_blobs_read_back_whole_and_in_ranges_and_detect_damage() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let blobs = Blobs::local(directory.path(), true, Health::new()).expect("opens");
        let digest = blobs.put(&b"hello table"[..]).await.expect("puts");
        assert_eq!(blobs.put(&b"hello table"[..]).await.expect("puts again"), digest);
        assert_eq!(blobs.get(&digest).await.expect("reads").as_deref(), Some(&b"hello table"[..]));
        let part: Vec<Bytes> = blobs
            .stream(&digest, Some(6..9))
            .await
            .expect("opens")
            .expect("is there")
            .try_collect()
            .await
            .expect("reads");
        assert_eq!(part.concat(), b"tab");
        assert_eq!(blobs.get(&Digest::of(b"other")).await.expect("answers"), None);

        // A damaged blob counts as missing.
        let hex = digest.as_str();
        std::fs::write(directory.path().join("sha256").join(&hex[..2]).join(hex), b"hello cable")
            .expect("damages the file");
        assert_eq!(blobs.get(&digest).await.expect("answers"), None);
    }

    #[tokio::test]
    async fn memory_blobs_read_back_whole_and_in_ranges() {
        let blobs = Blobs::in_memory(Health::new());
        let digest = blobs.put(&b"hello table"[..]).await.expect("puts");
        assert_eq!(digest, Digest::of(b"hello table"));
        assert_eq!(blobs.get(&digest).await.expect("reads").as_deref(), Some(&b"hello table"[..]));
        let part = blobs.stream(&digest, Some(6..9)).await.expect("opens").expect("is there");
        assert_eq!(part.try_collect::<Vec<Bytes>>().await.expect("reads").concat(), b"tab");
        let other = Digest::of(b"other");
        assert_eq!(blobs.get(&other).await.expect("answers"), None);
        assert!(blobs.contains(&digest).await.expect("answers"));
        assert!(!blobs.contains(&other).await.expect("answers"));
    }
}
