//! Blobs in a bucket of Amazon S3 or of a compatible server.
//!
//! Keys come from the environment variables that all S3 clients know (`AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`,
//! `AWS_SESSION_TOKEN`, or a role of the machine). Objects are created conditionally: one that exists has the same
//! bytes, because its name is their digest. An object that is old, or has another size, is written again. Large
//! objects go up in parts. All tries of a request together take less time than a lease.

use std::time::{Duration, SystemTime};

use bytes::Bytes;
use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path as ObjectPath;
use object_store::signer::{Method, SignedUrlOptions, Signer};
use object_store::{
    BackoffConfig, ClientOptions, Error, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode, PutOptions,
    Result, RetryConfig, WriteMultipart,
};
use serde::{Deserialize, Serialize};

/// Objects above this size go up in parts.
const MAX_SINGLE_PUT_BYTES: usize = 16 << 20;
/// Size of a part; S3 accepts 5 MiB and more.
const PART_BYTES: usize = 8 << 20;
/// Parts under way at the same time.
const CONCURRENT_PARTS: usize = 4;
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Section `[store.s3]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct S3Settings {
    /// Address of the server; empty = Amazon's for the region.
    pub endpoint: String,
    /// The bucket, which must exist.
    pub bucket: String,
    /// Region of the bucket; servers of one's own accept any.
    pub region: String,
    /// Folder of the bucket; empty = its top.
    pub prefix: String,
    /// `endpoint/bucket/key` instead of `bucket.endpoint/key`; a server of one's own usually wants it.
    pub path_style: bool,
    /// Plain HTTP may be used.
    pub allow_http: bool,
    /// Longest wait for the server to answer or to send more, seconds.
    pub timeout_secs: u64,
    /// No further try begins after this time, seconds. More outlasts longer faults.
    pub retry_secs: u64,
    /// Time for which redirects of downloads to the bucket are valid, seconds; 0 = the service sends the bytes itself.
    pub presign_secs: u64,
}

impl S3Settings {
    /// Longest time of an operation with all tries, seconds.
    pub fn longest_secs(&self) -> u64 {
        self.retry_secs + self.timeout_secs + CONNECT_TIMEOUT.as_secs()
    }

    /// A client of the bucket; `keys` brings the keys.
    pub(super) fn build(&self, keys: AmazonS3Builder) -> Result<AmazonS3> {
        // Only the first installation counts; another client may have installed the same provider.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = ClientOptions::new()
            .with_allow_http(self.allow_http)
            .with_connect_timeout(CONNECT_TIMEOUT)
            // A download lasts as long as its reader takes; only silence of the server ends it.
            .with_timeout_disabled()
            .with_read_timeout(Duration::from_secs(self.timeout_secs))
            .with_pool_idle_timeout(Duration::from_secs(30));
        let retry = RetryConfig {
            backoff: BackoffConfig { max_backoff: Duration::from_secs(2), ..BackoffConfig::default() },
            max_retries: 10,
            retry_timeout: Duration::from_secs(self.retry_secs),
        };
        let mut builder = keys
            .with_bucket_name(&self.bucket)
            .with_region(&self.region)
            .with_virtual_hosted_style_request(!self.path_style)
            .with_client_options(client)
            .with_retry(retry);
        if !self.endpoint.is_empty() {
            builder = builder.with_endpoint(&self.endpoint);
        }
        builder.build()
    }
}

/// Creates the object, or writes it again if it is at least `refresh_after` old.
pub(super) async fn put(
    objects: &dyn ObjectStore,
    path: &ObjectPath,
    bytes: Bytes,
    refresh_after: Duration,
) -> Result<()> {
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

/// An address that serves the object to every client that has it.
pub(super) async fn presigned(
    signer: &AmazonS3,
    path: &ObjectPath,
    lifetime: Duration,
    media_type: &str,
    disposition: Option<&str>,
) -> Result<String> {
    let headers =
        [("response-content-type", Some(media_type)), ("response-content-disposition", disposition)];
    let headers = headers.into_iter().filter_map(|(name, value)| Some((name, value?)));
    let options = SignedUrlOptions::default().with_query(headers);
    Ok(signer.signed_url_opts(Method::GET, path, lifetime, &options).await?.into())
}
