//! Content-addressed blobs in an object store: files in the data directory, memory of the process, or an S3 bucket.
//!
//! A blob's name is the SHA-256 digest of its bytes, so a blob never changes, and every full read is compared with the
//! name. Bytes that do not match are set aside below `damaged/` and count as missing: the next put writes them anew.
//!
//! A put always leaves a blob that is younger than the sweep's grace period. In files and memory it writes even if the
//! blob exists; in S3 it creates the object, and writes over one that is old. A sweep that has marked an old copy
//! therefore does not remove it before the new row refers to it. A put into files is durable when it returns: file and
//! directories are synced unless the settings disable that.

mod files;
mod reading;
pub mod s3;
pub(crate) mod sweeping;
mod verified;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path as ObjectPath;
use object_store::{ObjectStore, ObjectStoreExt};
use tokio::sync::RwLock;

use super::outage::{Health, Part};
use super::{BlobPlace, Digest, Settings, StoreError, private_files};
use crate::boxed;
use s3::{Bucket, S3Settings};
use verified::VerifiedBlobs;

/// Above this size, bytes are hashed on a thread that may block.
const INLINE_HASH_BYTES: usize = 1 << 20;
/// The probe that an outage is ended by.
const PROBE_BYTES: usize = 64 << 10;

/// Handle on the blobs; cloning shares it.
#[derive(Clone)]
pub struct Blobs {
    objects: Arc<dyn ObjectStore>,
    backend: Backend,
    /// Every object lies below it.
    root: ObjectPath,
    verified: Arc<VerifiedBlobs>,
    /// Puts share it; the removal of blobs excludes them, so that what is about to be removed is not put meanwhile.
    removal: Arc<RwLock<()>>,
    health: Health,
}

#[derive(Clone)]
enum Backend {
    Files {
        directory: PathBuf,
    },
    /// No other program can change the bytes, so they are not verified.
    Memory,
    S3 {
        bucket: Bucket,
        /// Time for which a redirect to the bucket is valid; `None` = the bytes are streamed.
        presign: Option<Duration>,
        /// An existing object of at least this age is written again.
        refresh_after: Duration,
    },
}

impl Blobs {
    /// Blobs where the settings keep them.
    ///
    /// # Errors
    ///
    /// [`StoreError::DataDir`] if the directory cannot be created, [`StoreError::Blob`] if the bucket cannot be used.
    pub(super) fn open(data_dir: &Path, settings: &Settings, health: Health) -> Result<Self, StoreError> {
        match settings.blobs {
            BlobPlace::Files => Self::local(&data_dir.join("blobs"), settings.fsync, health),
            BlobPlace::Memory => Ok(Self::in_memory(health)),
            BlobPlace::S3 => {
                let grace = Duration::from_secs(settings.retention.grace_secs);
                Self::in_s3(&settings.s3, grace, health)
            }
        }
    }

    /// Blobs in a local directory, which is created if missing.
    ///
    /// # Errors
    ///
    /// [`StoreError::DataDir`] if the directory cannot be created.
    pub(super) fn local(root: &Path, fsync: bool, health: Health) -> Result<Self, StoreError> {
        private_files::whole_directory(root)
            .map_err(|source| StoreError::DataDir { path: root.to_owned(), source })?;
        let files = LocalFileSystem::new_with_prefix(root)
            .map_err(|source| StoreError::Blob { name: root.display().to_string(), doing: "opened", source })?
            .with_fsync(fsync);
        let backend = Backend::Files { directory: root.to_owned() };
        Ok(Self::new(Arc::new(files), backend, ObjectPath::default(), health))
    }

    /// Blobs in memory, lost at the end of the process.
    pub(super) fn in_memory(health: Health) -> Self {
        Self::new(Arc::new(InMemory::new()), Backend::Memory, ObjectPath::default(), health)
    }

    /// Blobs in an S3 bucket, which must exist. Nothing is sent yet. `grace` is that of the sweep.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the settings name no usable bucket, [`StoreError::NotBuilt`] without the feature `s3`.
    fn in_s3(settings: &S3Settings, grace: Duration, health: Health) -> Result<Self, StoreError> {
        Ok(Self::in_bucket(Bucket::open(settings)?, settings, grace / 2, health))
    }

    fn in_bucket(bucket: Bucket, settings: &S3Settings, refresh_after: Duration, health: Health) -> Self {
        let objects = bucket.objects();
        let presign = (settings.presign_secs > 0).then(|| Duration::from_secs(settings.presign_secs));
        let backend = Backend::S3 { bucket, presign, refresh_after };
        Self::new(objects, backend, ObjectPath::from(settings.prefix.as_str()), health)
    }

    fn new(objects: Arc<dyn ObjectStore>, backend: Backend, root: ObjectPath, health: Health) -> Self {
        let (verified, removal) = (Arc::default(), Arc::default());
        Self { objects, backend, root, verified, removal, health }
    }

    /// Stores `bytes` and returns their digest. On return the blob may be referred to.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the bytes could not be written.
    pub async fn put(&self, bytes: impl Into<Bytes>) -> Result<Digest, StoreError> {
        let bytes: Bytes = bytes.into();
        let digest = digest_of(&bytes).await;
        let (path, size) = (self.path_of(&digest), bytes.len() as u64);
        let _no_removal = self.removal.read().await;
        let written = match &self.backend {
            Backend::Files { .. } | Backend::Memory => self.put_file(&path, bytes).await,
            Backend::S3 { bucket, refresh_after, .. } => bucket.put(&path, bytes, *refresh_after).await,
        };
        self.noted(&digest, "written", written)?;
        metrics::counter!("tabletopgen_blob_written_bytes_total").increment(size);
        self.health.succeeded(Part::Blobs);
        Ok(digest)
    }

    /// Writes a blob that nothing refers to, whether it exists or not.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if it could not be written.
    pub(super) async fn probe(&self) -> Result<(), StoreError> {
        let bytes = Bytes::from(vec![0; PROBE_BYTES]);
        let digest = Digest::of(&bytes);
        let written = self.put_file(&self.path_of(&digest), bytes).await;
        self.noted(&digest, "written", written)?;
        self.health.succeeded(Part::Blobs);
        Ok(())
    }

    /// Writes a blob where others may not read it. The library makes directories and files by the umask.
    async fn put_file(&self, path: &ObjectPath, bytes: Bytes) -> object_store::Result<()> {
        let Backend::Files { directory } = &self.backend else {
            return self.objects.put(path, bytes.into()).await.map(|_| ());
        };
        let failed =
            |source: std::io::Error| object_store::Error::Generic { store: "file", source: Box::new(source) };
        let file = directory.join(path.as_ref());
        if let Some(folder) = file.parent().filter(|folder| !folder.exists()) {
            private_files::create(folder).map_err(failed)?;
        }
        self.objects.put(path, bytes.into()).await?;
        private_files::set(&file).map_err(failed)
    }

    /// The bytes, or `None` if the blob is missing or does not match its digest.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the store does not answer.
    #[boxed]
    pub async fn get(&self, digest: &Digest) -> Result<Option<Bytes>, StoreError> {
        match self.intact(digest).await? {
            Read::Intact(bytes) => Ok(Some(bytes)),
            Read::Missing => Ok(None),
            Read::Damaged => self.set_aside(digest).await,
        }
    }

    /// Whether the blob exists. Its bytes are not read.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the store does not answer.
    #[boxed]
    pub async fn contains(&self, digest: &Digest) -> Result<bool, StoreError> {
        match self.objects.head(&self.path_of(digest)).await {
            Ok(_) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(source) => Err(self.failed(digest, "looked up", source)),
        }
    }

    /// Reads a blob and compares it with its digest; changes nothing.
    pub(super) async fn intact(&self, digest: &Digest) -> Result<Read, StoreError> {
        let found = match self.objects.get(&self.path_of(digest)).await {
            Ok(found) => found,
            Err(object_store::Error::NotFound { .. }) => return Ok(Read::Missing),
            Err(source) => return Err(self.failed(digest, "opened", source)),
        };
        let meta = found.meta.clone();
        let bytes = found.bytes().await.map_err(|source| self.failed(digest, "read", source))?;
        count_read(&bytes);
        if !self.is_reachable() {
            return Ok(Read::Intact(bytes));
        }
        if digest_of(&bytes).await == *digest {
            self.verified.remember(digest, &meta);
            Ok(Read::Intact(bytes))
        } else {
            Ok(Read::Damaged)
        }
    }

    /// Moves a damaged blob below `damaged/`, so that the next put writes it anew. It is read once more before: a
    /// transfer can fail as well as a disk, and another put may have repaired it. Returns the bytes in that case.
    pub(super) async fn set_aside(&self, digest: &Digest) -> Result<Option<Bytes>, StoreError> {
        let _no_put = self.removal.write().await;
        match self.intact(digest).await? {
            Read::Intact(bytes) => return Ok(Some(bytes)),
            Read::Missing => return Ok(None),
            Read::Damaged => {}
        }
        self.verified.forget(digest);
        metrics::counter!("tabletopgen_blobs_damaged_total").increment(1);
        let aside = self.root.clone().join("damaged").join(digest.as_str());
        match self.objects.rename(&self.path_of(digest), &aside).await {
            Ok(()) => tracing::error!(%digest, %aside, "a blob does not match its name; it is set aside"),
            Err(error) => tracing::error!(
                %digest, error = %error,
                "a blob does not match its name, and it cannot be set aside; remove it by hand"
            ),
        }
        Ok(None)
    }

    /// Whether other programs can change the bytes.
    fn is_reachable(&self) -> bool {
        !matches!(self.backend, Backend::Memory)
    }

    fn path_of(&self, digest: &Digest) -> ObjectPath {
        let hex = digest.as_str();
        self.root.clone().join("sha256").join(&hex[..2]).join(hex)
    }

    fn noted<T>(
        &self,
        digest: &Digest,
        doing: &'static str,
        result: object_store::Result<T>,
    ) -> Result<T, StoreError> {
        result.map_err(|source| self.failed(digest, doing, source))
    }

    /// Wraps the error and notes the outage.
    fn failed(&self, digest: &Digest, doing: &'static str, source: object_store::Error) -> StoreError {
        let error = StoreError::Blob { name: digest.to_string(), doing, source };
        let operation = if doing == "written" { "write" } else { "read" };
        metrics::counter!("tabletopgen_blob_failures_total", "operation" => operation).increment(1);
        // What cannot be read cannot be written either, except in a local directory.
        if doing == "written" || matches!(self.backend, Backend::S3 { .. }) {
            self.health.failed(Part::Blobs, &error);
        }
        error
    }
}

fn count_read(bytes: &Bytes) {
    metrics::counter!("tabletopgen_blob_read_bytes_total").increment(bytes.len() as u64);
}

/// Result of a read.
#[derive(Debug)]
pub(super) enum Read {
    Intact(Bytes),
    Missing,
    Damaged,
}

/// The digest of bytes; many of them are hashed on a thread that may block.
async fn digest_of(bytes: &Bytes) -> Digest {
    if bytes.len() <= INLINE_HASH_BYTES {
        return Digest::of(bytes);
    }
    let copy = bytes.clone();
    match tokio::task::spawn_blocking(move || Digest::of(&copy)).await {
        Ok(digest) => digest,
        Err(_) => Digest::of(bytes),
    }
}
