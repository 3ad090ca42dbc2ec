//! Listing and removal of old blobs, shard by shard: a shard holds the digests with the same first byte.

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use futures::stream::{self, BoxStream};
use futures::{StreamExt, TryStreamExt};
use object_store::path::Path as ObjectPath;
use object_store::{ObjectMeta, ObjectStoreExt};

use super::{Backend, Blobs, Digest, StoreError};

/// Blobs that are removed while puts wait.
const MAX_CHUNK: usize = 64;
const CONCURRENT_QUERIES: usize = 16;

/// Number and size of blobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Volume {
    pub blobs: u64,
    pub bytes: u64,
}

impl Volume {
    pub(crate) fn add(&mut self, bytes: u64) {
        self.blobs += 1;
        self.bytes += bytes;
    }

    pub(crate) fn extend(&mut self, other: Self) {
        self.blobs += other.blobs;
        self.bytes += other.bytes;
    }
}

impl Blobs {
    /// Removes the blobs of a shard (`None` = of all) that are at least `grace` old and that `is_referenced` does not
    /// know. Everything else below the shard that is as old goes too. Returns what was removed (or would be) and what
    /// stays.
    pub(crate) async fn sweep_shard(
        &self,
        shard: Option<u8>,
        grace: Duration,
        dry_run: bool,
        is_referenced: impl Fn(&Digest) -> bool + Send + Sync,
    ) -> Result<(Volume, Volume), StoreError> {
        let all = self.root.clone().join("sha256");
        let folder_of = |shard: u8| all.clone().join(format!("{shard:02x}"));
        let folder = shard.map_or_else(|| all.clone(), folder_of);
        let (mut removed, mut kept, mut chunk) = (Volume::default(), Volume::default(), Vec::new());
        let mut objects = self.list(&folder);
        while let Some(meta) = objects.try_next().await? {
            if is_young(&meta, grace) || digest_in(&meta.location).as_ref().is_some_and(&is_referenced) {
                kept.add(meta.size);
                continue;
            }
            chunk.push(meta);
            if chunk.len() >= MAX_CHUNK {
                removed.extend(self.remove(std::mem::take(&mut chunk), grace, dry_run).await?);
            }
        }
        removed.extend(self.remove(chunk, grace, dry_run).await?);
        for shard in shard.map_or(0..=u8::MAX, |shard| shard..=shard) {
            removed.extend(self.remove_unfinished(&folder_of(shard), grace, dry_run).await?);
        }
        Ok((removed, kept))
    }

    /// Removes blobs that were set aside as damaged at least `grace` ago.
    pub(crate) async fn sweep_damaged(&self, grace: Duration, dry_run: bool) -> Result<Volume, StoreError> {
        let folder = self.root.clone().join("damaged");
        let (mut objects, mut old) = (self.list(&folder), Vec::new());
        while let Some(meta) = objects.try_next().await? {
            if !is_young(&meta, grace) {
                old.push(meta);
            }
        }
        self.remove(old, grace, dry_run).await
    }

    fn list(&self, folder: &ObjectPath) -> BoxStream<'static, Result<ObjectMeta, StoreError>> {
        let name = folder.to_string();
        let failed = move |source| StoreError::Blob { name: name.clone(), doing: "listed", source };
        Box::pin(self.objects.list(Some(folder)).map_err(failed))
    }

    /// Removes objects that are still old. In this process no put runs meanwhile, so none of them can have been put
    /// again; another process may put one between the look-up and the removal, in a few milliseconds out of the grace
    /// period. Its reader finds the blob missing and computes it again.
    async fn remove(
        &self,
        objects: Vec<ObjectMeta>,
        grace: Duration,
        dry_run: bool,
    ) -> Result<Volume, StoreError> {
        let mut removed = Volume::default();
        for chunk in objects.chunks(MAX_CHUNK) {
            let _no_put = self.removal.write().await;
            let queries: Vec<_> = chunk
                .iter()
                .map(|meta| {
                    let (objects, path) = (self.objects.clone(), meta.location.clone());
                    async move { (objects.head(&path).await, path) }
                })
                .collect();
            let found_objects: Vec<_> =
                stream::iter(queries).buffer_unordered(CONCURRENT_QUERIES).collect().await;
            let mut old = Vec::new();
            for (found, path) in found_objects {
                match found {
                    Ok(meta) if is_young(&meta, grace) => {}
                    Ok(meta) => {
                        removed.add(meta.size);
                        old.push(Ok(path));
                    }
                    Err(object_store::Error::NotFound { .. }) => {}
                    Err(source) => return Err(failed(&path, source)),
                }
            }
            if dry_run {
                continue;
            }
            for path in old.iter().flatten() {
                if let Some(digest) = digest_in(path) {
                    self.verified.forget(&digest);
                }
            }
            let mut deleted = self.objects.delete_stream(stream::iter(old).boxed());
            while let Some(done) = deleted.next().await {
                match done {
                    Ok(_) | Err(object_store::Error::NotFound { .. }) => {}
                    Err(source) => return Err(failed(&self.root, source)),
                }
            }
        }
        Ok(removed)
    }

    async fn remove_unfinished(
        &self,
        folder: &ObjectPath,
        grace: Duration,
        dry_run: bool,
    ) -> Result<Volume, StoreError> {
        let Backend::Files { directory } = &self.backend else { return Ok(Volume::default()) };
        let folder: PathBuf = directory.join(folder.as_ref());
        let name = folder.display().to_string();
        let before = SystemTime::now().checked_sub(grace).unwrap_or(SystemTime::UNIX_EPOCH);
        let swept =
            tokio::task::spawn_blocking(move || super::files::remove_unfinished(&folder, before, dry_run));
        match swept.await {
            Ok(Ok((blobs, bytes))) => Ok(Volume { blobs, bytes }),
            Ok(Err(source)) => Err(StoreError::DataDir { path: name.into(), source }),
            Err(_) => Ok(Volume::default()),
        }
    }
}

fn is_young(meta: &ObjectMeta, grace: Duration) -> bool {
    // What was written in the future, by this machine's clock, was written just now by another.
    let age = SystemTime::now().duration_since(SystemTime::from(meta.last_modified));
    age.map_or(true, |age| age < grace)
}

fn digest_in(path: &ObjectPath) -> Option<Digest> {
    path.filename().and_then(|name| Digest::parse(name).ok())
}

fn failed(path: &ObjectPath, source: object_store::Error) -> StoreError {
    StoreError::Blob { name: path.to_string(), doing: "removed", source }
}
