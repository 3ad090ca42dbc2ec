//! Settings of blobs in a bucket of Amazon S3 or of a compatible server. A program that was built without the feature
//! `s3` reads them, too, and has no bucket.

#[cfg(feature = "s3")]
mod bucket;
#[cfg(not(feature = "s3"))]
mod no_bucket;

use std::time::Duration;

use serde::{Deserialize, Serialize};

#[cfg(feature = "s3")]
pub(super) use bucket::Bucket;
#[cfg(not(feature = "s3"))]
pub(super) use no_bucket::Bucket;

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
}
