//! Blobs in a bucket of Amazon S3 or of a compatible server.
//!
//! Keys come from the environment variables that all S3 clients know (`AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`,
//! `AWS_SESSION_TOKEN`, or a role of the machine). Objects are created conditionally: one that exists has the same
//! bytes, because its name is their digest. An object that is old, or has another size, is written again. Large
//! objects go up in parts. All tries of a request together take less time than a lease.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path as ObjectPath;
use object_store::signer::{Method, SignedUrlOptions, Signer};
use object_store::{
    BackoffConfig, ClientOptions, Error, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode, PutOptions,
    Result, RetryConfig, WriteMultipart,
};
// The dependency chooses the TLS of the client of `object_store`, which does not compile without any.
use reqwest as _;

use super::{CONNECT_TIMEOUT, S3Settings};
use crate::StoreError;

/// Objects above this size go up in parts.
const MAX_SINGLE_PUT_BYTES: usize = 16 << 20;
/// Size of a part; S3 accepts 5 MiB and more.
const PART_BYTES: usize = 8 << 20;
/// Parts under way at the same time.
const CONCURRENT_PARTS: usize = 4;

/// A client of a bucket; cloning shares it.
#[derive(Clone)]
pub(in crate::blobs) struct Bucket(Arc<AmazonS3>);

impl Bucket {
    /// A client with the keys of the environment. Nothing is sent yet.
    ///
    /// # Errors
    ///
    /// [`StoreError::Blob`] if the settings name no usable bucket.
    pub(in crate::blobs) fn open(settings: &S3Settings) -> Result<Self, StoreError> {
        Self::build(settings, AmazonS3Builder::from_env()).map_err(|source| StoreError::Blob {
            name: format!("bucket {:?}", settings.bucket),
            doing: "opened",
            source,
        })
    }

    /// A client of the bucket; `keys` brings the keys.
    pub(in crate::blobs) fn build(settings: &S3Settings, keys: AmazonS3Builder) -> Result<Self> {
        // Only the first installation counts; another client may have installed the same provider.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = ClientOptions::new()
            .with_allow_http(settings.allow_http)
            .with_connect_timeout(CONNECT_TIMEOUT)
            // A download lasts as long as its reader takes; only silence of the server ends it.
            .with_timeout_disabled()
            .with_read_timeout(Duration::from_secs(settings.timeout_secs))
            .with_pool_idle_timeout(Duration::from_secs(30));
        let retry = RetryConfig {
            backoff: BackoffConfig { max_backoff: Duration::from_secs(2), ..BackoffConfig::default() },
            max_retries: 10,
            retry_timeout: Duration::from_secs(settings.retry_secs),
        };
        let mut builder = keys
            .with_bucket_name(&settings.bucket)
            .with_region(&settings.region)
            .with_virtual_hosted_style_request(!settings.path_style)
            .with_client_options(client)
            .with_retry(retry);
        if !settings.endpoint.is_empty() {
            builder = builder.with_endpoint(&settings.endpoint);
        }
        Ok(Self(Arc::new(builder.build()?)))
    }

    /// The objects of the bucket.
    pub(in crate::blobs) fn objects(&self) -> Arc<dyn ObjectStore> {
        self.0.clone()
    }

    /// Creates the object, or writes it again if it is at least `refresh_after` old.
    pub(in crate::blobs) async fn put(
        &self,
        path: &ObjectPath,
        bytes: Bytes,
        refresh_after: Duration,
    ) -> Result<()> {
        let objects = self.0.as_ref();
        let size = bytes.len() as u64;
        if bytes.len() > MAX_SINGLE_PUT_BYTES {
            if is_young(objects, path, size, refresh_after).await? {
                return Ok(());
            }
            return put_in_parts(objects, path, bytes).await;
        }
        let create = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        match objects.put_opts(path, bytes.clone().into(), create).await {
            Ok(_) => Ok(()),
            // Some compatible servers know no conditions.
            Err(Error::AlreadyExists { .. } | Error::NotImplemented { .. }) => {
                if is_young(objects, path, size, refresh_after).await? {
                    return Ok(());
                }
                objects.put(path, bytes.into()).await.map(|_| ())
            }
            Err(error) => Err(error),
        }
    }

    /// An address that serves the object to every client that has it.
    pub(in crate::blobs) async fn presigned(
        &self,
        path: &ObjectPath,
        lifetime: Duration,
        media_type: &str,
        disposition: Option<&str>,
    ) -> Result<String> {
        let headers =
            [("response-content-type", Some(media_type)), ("response-content-disposition", disposition)];
        let headers = headers.into_iter().filter_map(|(name, value)| Some((name, value?)));
        let options = SignedUrlOptions::default().with_query(headers);
        Ok(self.0.signed_url_opts(Method::GET, path, lifetime, &options).await?.into())
    }
}

/// An upload in parts is not conditional; bytes that two of them write are the same.
async fn put_in_parts(objects: &dyn ObjectStore, path: &ObjectPath, bytes: Bytes) -> Result<()> {
    let upload = objects.put_multipart(path).await?;
    let mut upload = WriteMultipart::new_with_chunk_size(upload, PART_BYTES);
    let mut rest = bytes;
    while !rest.is_empty() {
        if let Err(error) = upload.wait_for_capacity(CONCURRENT_PARTS).await {
            // The parts cost space until they are removed; the error of the upload says more than one of that.
            let _ = upload.abort().await;
            return Err(error);
        }
        upload.put(rest.split_to(PART_BYTES.min(rest.len())));
    }
    upload.finish().await.map(|_| ())
}

/// Whether the object is there, in full, and younger than `refresh_after`.
async fn is_young(
    objects: &dyn ObjectStore,
    path: &ObjectPath,
    size: u64,
    refresh_after: Duration,
) -> Result<bool> {
    match objects.head(path).await {
        Ok(meta) => Ok(meta.size == size && age(&meta) < refresh_after),
        Err(Error::NotFound { .. }) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Time since the object was written, by the clock of this machine; 0 if that lies in the future.
fn age(meta: &ObjectMeta) -> Duration {
    SystemTime::now().duration_since(SystemTime::from(meta.last_modified)).unwrap_or_default()
}
