//! The S3 server of the tests: that of `TABLETOPGEN_TEST_S3_URL`, or one that the Python module
//! `tabletopgen_checks.service.s3` starts and that ends with this process.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use super::super::super::outage::Health;
use super::super::Blobs;
use super::super::s3::{Bucket, S3Settings};
use object_store::aws::AmazonS3Builder;

const VARIABLE: &str = "TABLETOPGEN_TEST_S3_URL";
/// Prints the address and waits for the end of its input, which comes with the end of this process.
const HOLD: &str = "echo \"$TABLETOPGEN_TEST_S3_URL\"; cat >/dev/null";

/// A server that runs.
pub(super) struct S3Server {
    pub(super) url: String,
}

impl S3Server {
    /// The server of all tests of this process.
    pub(super) fn shared() -> &'static Self {
        static SERVER: OnceLock<S3Server> = OnceLock::new();
        SERVER.get_or_init(|| Self { url: std::env::var(VARIABLE).unwrap_or_else(|_| start()) })
    }

    /// Blobs in a bucket, which is created if it is not there.
    pub(super) fn blobs(&self, bucket: &str, prefix: &str, refresh_after: Duration) -> Blobs {
        let (status, _, body) = self.request("PUT", &format!("/{bucket}"), true);
        assert!(matches!(status, 200 | 409), "{status}: {}", String::from_utf8_lossy(&body));
        self.blobs_with(bucket, prefix, refresh_after, Health::new())
    }

    /// The same without creating the bucket.
    pub(super) fn blobs_with(
        &self,
        bucket: &str,
        prefix: &str,
        refresh_after: Duration,
        health: Health,
    ) -> Blobs {
        let settings = S3Settings {
            endpoint: self.url.clone(),
            bucket: bucket.into(),
            region: "us-east-1".into(),
            prefix: prefix.into(),
            path_style: true,
            allow_http: true,
            timeout_secs: 20,
            retry_secs: 1,
            presign_secs: 0,
        };
        let keys = AmazonS3Builder::new().with_access_key_id("test").with_secret_access_key("test");
        let bucket = Bucket::build(&settings, keys).expect("is a valid configuration");
        Blobs::in_bucket(bucket, &settings, refresh_after, health)
    }

    /// Status, head and body of a plain request. The server routes by the service that a signature names.
    pub(super) fn request(&self, method: &str, path: &str, signed: bool) -> (u16, String, Vec<u8>) {
        let host = self.url.strip_prefix("http://").expect("plain HTTP");
        let mut stream = TcpStream::connect(host).expect("connects");
        let signature = if signed {
            "Authorization: AWS4-HMAC-SHA256 Credential=test/20260101/us-east-1/s3/aws4_request, \
             SignedHeaders=host, Signature=0\r\n"
        } else {
            ""
        };
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\n{signature}Content-Length: 0\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).expect("sends");
        let mut response = Vec::new();
        stream.read_to_end(&mut response).expect("is answered");
        let end = response.windows(4).position(|four| four == b"\r\n\r\n").expect("has a head");
        let head = String::from_utf8_lossy(&response[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("has a status");
        (status, head, response[end + 4..].to_vec())
    }
}

fn start() -> String {
    let root =
        PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests")).join("../../..");
    let target = std::env::var("CARGO_TARGET_DIR").map_or_else(|_| root.join("target"), PathBuf::from);
    let mut program = Command::new("python3")
        .args(["-m", "tabletopgen_checks.service.s3"])
        .env("PYTHONPATH", root.join("python"))
        .arg("--target-dir")
        .arg(target)
        .args(["sh", "-c", HOLD])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts Python");
    let mut address = String::new();
    let output = program.stdout.take().expect("is piped");
    BufReader::new(output).read_line(&mut address).expect("reads");
    assert!(
        address.starts_with("http://"),
        "tabletopgen_checks.service.s3 started no S3 server; what it said is above"
    );
    // The input stays open as long as this process lives.
    std::mem::forget(program);
    address.trim().to_owned()
}
