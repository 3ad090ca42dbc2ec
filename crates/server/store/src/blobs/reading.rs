//! Streams of blobs, whole or in part, without a wrong byte under a right name.
//!
//! - A blob of up to [`MAX_VERIFY_FIRST_BYTES`], and any blob of which a part is wanted, is read in full before its
//!   first byte is sent, unless it was verified within the last hour and has not changed since.
//! - A larger blob that is wanted whole is hashed while it is sent. The last chunk is held back until the digest is
//!   known; on a mismatch the stream ends with an error instead, and the client has fewer bytes than were announced.
//! - Whole blobs are hashed while they are sent in every case.
//!
//! A part of a blob that was verified within the hour is sent as it is read.

use std::io::{Read as _, Seek, SeekFrom};
use std::ops::Range;

use bytes::Bytes;
use futures::stream::{self, BoxStream};
use futures::{StreamExt, TryStreamExt};
use object_store::{GetOptions, GetRange, GetResult, GetResultPayload, ObjectMeta, ObjectStoreExt};
use sha2::{Digest as _, Sha256};

use super::{Backend, Blobs, Digest, StoreError};
use crate::boxed;

/// Larger blobs that are wanted whole are verified while they are sent.
pub const MAX_VERIFY_FIRST_BYTES: u64 = if cfg!(test) { 4 << 20 } else { 64 << 20 };
/// Blobs up to this size are read once, verified and sent from memory.
const MAX_BUFFERED_BYTES: u64 = 1 << 20;
/// Bytes of a file that are read at once.
const CHUNK_BYTES: u64 = 128 << 10;

type Chunks = BoxStream<'static, Result<Bytes, StoreError>>;

impl Blobs {
    /// A range of the bytes as a stream (`end` exclusive; `None` = all bytes). `None` if the blob is missing or was
    /// found damaged before its first byte.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the store does not answer. The stream ends with [`StoreError::BlobDamaged`] if a blob
    /// that is sent whole does not match its digest.
    #[boxed]
    pub async fn stream(
        &self,
        digest: &Digest,
        range: Option<Range<u64>>,
    ) -> Result<Option<Chunks>, StoreError> {
        let Some(meta) = self.meta(digest).await? else { return Ok(None) };
        if !self.is_reachable() {
            let found = self.opened(digest, range, None).await?;
            return Ok(found.map(|found| self.plain(digest, found)));
        }
        let whole = range.as_ref().is_none_or(|range| range.start == 0 && range.end >= meta.size);
        if !self.verified.contains(digest, &meta) {
            if meta.size <= MAX_BUFFERED_BYTES {
                let Some(bytes) = self.get(digest).await? else { return Ok(None) };
                let end = bytes.len() as u64;
                let range = range.map_or(0..end, |range| range.start.min(end)..range.end.min(end));
                let part = bytes.slice(range.start as usize..range.end as usize);
                return Ok(Some(stream::iter([Ok(part)]).boxed()));
            }
            let first = meta.size <= MAX_VERIFY_FIRST_BYTES || !whole;
            if first && !self.verify(digest).await? {
                return Ok(None);
            }
        }
        // A put may have replaced the object since; then its bytes are as good, but another version.
        let found = match self.opened(digest, range.clone(), meta.e_tag).await? {
            Some(found) => Some(found),
            None if self.verify(digest).await? => self.opened(digest, range, None).await?,
            None => None,
        };
        Ok(found.map(|found| match whole {
            true => self.checked(digest, found),
            false => self.plain(digest, found),
        }))
    }

    /// An address under which the bucket itself serves the verified blob for a limited time, with these headers.
    /// `None` where the settings do not allow that, or the blob is missing or damaged.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the store does not answer.
    #[boxed]
    pub async fn presigned(
        &self,
        digest: &Digest,
        media_type: &str,
        disposition: Option<&str>,
    ) -> Result<Option<String>, StoreError> {
        let Backend::S3 { bucket, presign: Some(lifetime), .. } = &self.backend else { return Ok(None) };
        let Some(meta) = self.meta(digest).await? else { return Ok(None) };
        if !self.verified.contains(digest, &meta) && !self.verify(digest).await? {
            return Ok(None);
        }
        let url = bucket.presigned(&self.path_of(digest), *lifetime, media_type, disposition).await;
        url.map(Some).map_err(|source| self.failed(digest, "signed", source))
    }

    /// Size of the blob, bytes; `None` if it is missing.
    pub(crate) async fn size(&self, digest: &Digest) -> Result<Option<u64>, StoreError> {
        Ok(self.meta(digest).await?.map(|meta| meta.size))
    }

    /// Size and version of the object; `None` if it is missing.
    async fn meta(&self, digest: &Digest) -> Result<Option<ObjectMeta>, StoreError> {
        match self.objects.head(&self.path_of(digest)).await {
            Ok(meta) => Ok(Some(meta)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(source) => Err(self.failed(digest, "looked up", source)),
        }
    }

    /// Opens a range; `None` if the object is missing or has another version than asked for.
    async fn opened(
        &self,
        digest: &Digest,
        range: Option<Range<u64>>,
        if_match: Option<String>,
    ) -> Result<Option<GetResult>, StoreError> {
        let options = GetOptions { range: range.map(GetRange::Bounded), if_match, ..GetOptions::default() };
        match self.objects.get_opts(&self.path_of(digest), options).await {
            Ok(found) => Ok(Some(found)),
            Err(object_store::Error::NotFound { .. } | object_store::Error::Precondition { .. }) => Ok(None),
            Err(source) => Err(self.failed(digest, "opened", source)),
        }
    }

    /// Reads all of the blob in bounded memory; sets it aside if it is damaged. Whether it is intact.
    async fn verify(&self, digest: &Digest) -> Result<bool, StoreError> {
        let Some(found) = self.opened(digest, None, None).await? else { return Ok(false) };
        let meta = found.meta.clone();
        let (mut chunks, mut hasher) = (self.plain(digest, found), Sha256::new());
        while let Some(chunk) = chunks.try_next().await? {
            hasher.update(&chunk);
        }
        if is(hasher, digest) {
            self.verified.remember(digest, &meta);
            return Ok(true);
        }
        Ok(self.set_aside(digest).await?.is_some())
    }

    fn plain(&self, digest: &Digest, found: GetResult) -> Chunks {
        let (blobs, digest) = (self.clone(), digest.clone());
        chunks_of(found)
            .inspect_ok(super::count_read)
            .map_err(move |source| blobs.failed(&digest, "read", source))
            .boxed()
    }

    /// The chunks, of which the last comes only if all of them together match the digest.
    fn checked(&self, digest: &Digest, found: GetResult) -> Chunks {
        let meta = found.meta.clone();
        let state = CheckedChunks {
            chunks: self.plain(digest, found),
            hasher: Some(Sha256::new()),
            last: None,
            blobs: self.clone(),
            digest: digest.clone(),
            meta,
        };
        stream::try_unfold(
            state,
            |mut state| async move { Ok(state.next().await?.map(|chunk| (chunk, state))) },
        )
        .boxed()
    }
}

struct CheckedChunks {
    chunks: Chunks,
    /// `None` after the end.
    hasher: Option<Sha256>,
    /// The newest chunk, held back.
    last: Option<Bytes>,
    blobs: Blobs,
    digest: Digest,
    meta: ObjectMeta,
}

impl CheckedChunks {
    async fn next(&mut self) -> Result<Option<Bytes>, StoreError> {
        while let Some(hasher) = &mut self.hasher {
            if let Some(chunk) = self.chunks.try_next().await? {
                hasher.update(&chunk);
                if let Some(before) = self.last.replace(chunk) {
                    return Ok(Some(before));
                }
                continue;
            }
            if self.hasher.take().is_some_and(|hasher| is(hasher, &self.digest)) {
                self.blobs.verified.remember(&self.digest, &self.meta);
            } else {
                self.blobs.verified.forget(&self.digest);
                self.blobs.set_aside(&self.digest).await?;
                return Err(StoreError::BlobDamaged { name: self.digest.to_string() });
            }
        }
        Ok(self.last.take())
    }
}

fn is(hasher: Sha256, digest: &Digest) -> bool {
    runtime::digest::hex(&hasher.finalize()) == digest.as_str()
}

/// The chunks of an object; those of a file are larger than `object_store` would read them.
fn chunks_of(found: GetResult) -> BoxStream<'static, object_store::Result<Bytes>> {
    let file = match found.payload {
        GetResultPayload::File(file, _) => file,
        GetResultPayload::Stream(chunks) => return chunks,
    };
    stream::try_unfold((file, found.range), |(mut file, mut range)| async move {
        if range.is_empty() {
            return Ok(None);
        }
        let length = CHUNK_BYTES.min(range.end - range.start);
        let read = tokio::task::spawn_blocking(move || {
            let mut bytes = vec![0; length as usize];
            file.seek(SeekFrom::Start(range.start))?;
            file.read_exact(&mut bytes)?;
            range.start += length;
            Ok::<_, std::io::Error>((Bytes::from(bytes), (file, range)))
        })
        .await;
        let generic = |source| object_store::Error::Generic { store: "files", source };
        match read {
            Ok(Ok((bytes, rest))) => Ok(Some((bytes, rest))),
            Ok(Err(error)) => Err(generic(Box::new(error) as _)),
            Err(error) => Err(generic(Box::new(error) as _)),
        }
    })
    .boxed()
}
