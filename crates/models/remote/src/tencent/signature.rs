//! TC3-HMAC-SHA256, the request signature of Tencent Cloud's APIs.
//!
//! Method: "Signature v3" of Tencent Cloud's API documentation. The hash of a canonical form of the request is signed
//! with a key derived from the secret key, the day and the service (HMAC after RFC 2104). Times are seconds since
//! 1970 in UTC; a server accepts a signature for five minutes. The tests hold the published worked example.

use sha2::{Digest as _, Sha256};

use runtime::digest::hex;

use http_client::Secret;
use http_client::hmac::hmac_sha256;

/// The signed headers, sorted.
const SIGNED_HEADERS: &str = "content-type;host;x-tc-action";

/// The signed parts of a request.
#[derive(Clone, Copy, Debug)]
pub struct Signed<'a> {
    pub secret_id: &'a str,
    /// The first label of the service's host (`ai3d`).
    pub service: &'a str,
    /// The sent `Host` header, with the port where it is not the default.
    pub host: &'a str,
    pub action: &'a str,
    pub content_type: &'a str,
    pub body: &'a [u8],
    /// Seconds since 1970-01-01 in UTC.
    pub timestamp_s: u64,
}

/// The value of the header `Authorization`.
pub fn authorization(signed: &Signed<'_>, secret_key: &Secret) -> String {
    let action = signed.action.to_ascii_lowercase();
    let headers =
        format!("content-type:{}\nhost:{}\nx-tc-action:{action}\n", signed.content_type, signed.host);
    let canonical = canonical_request(&headers, SIGNED_HEADERS, signed.body);
    of_canonical(signed, &canonical, SIGNED_HEADERS, secret_key)
}

/// The canonical form of a POST to the root without a query.
fn canonical_request(headers: &str, signed_headers: &str, body: &[u8]) -> String {
    format!("POST\n/\n\n{headers}\n{signed_headers}\n{}", hex(&Sha256::digest(body)))
}

fn of_canonical(signed: &Signed<'_>, canonical: &str, signed_headers: &str, secret_key: &Secret) -> String {
    let Signed { secret_id, service, timestamp_s, .. } = *signed;
    let date = date_of(timestamp_s);
    let scope = format!("{date}/{service}/tc3_request");
    let hashed = hex(&Sha256::digest(canonical));
    let to_sign = format!("TC3-HMAC-SHA256\n{timestamp_s}\n{scope}\n{hashed}");
    let of_day = hmac_sha256(format!("TC3{}", secret_key.expose()).as_bytes(), date.as_bytes());
    let of_service = hmac_sha256(&of_day, service.as_bytes());
    let signature = hex(&hmac_sha256(&hmac_sha256(&of_service, b"tc3_request"), to_sign.as_bytes()));
    format!(
        "TC3-HMAC-SHA256 Credential={secret_id}/{scope}, SignedHeaders={signed_headers}, Signature={signature}"
    )
}

/// `YYYY-MM-DD` of a time in UTC.
fn date_of(timestamp_s: u64) -> String {
    let time = i64::try_from(timestamp_s).ok().and_then(|seconds| jiff::Timestamp::from_second(seconds).ok());
    time.unwrap_or_default().strftime("%Y-%m-%d").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// "Signature v3", the example of `DescribeInstances`.
    const BODY: &str =
        r#"{"Limit": 1, "Filters": [{"Values": ["\u672a\u547d\u540d"], "Name": "instance-name"}]}"#;

    fn example() -> (Signed<'static>, Secret) {
        let signed = Signed {
            secret_id: "AKIDz8krbsJ5yKBZQpn74WFkmLPx3EXAMPLE",
            service: "cvm",
            host: "cvm.tencentcloudapi.com",
            action: "DescribeInstances",
            content_type: "application/json; charset=utf-8",
            body: BODY.as_bytes(),
            timestamp_s: 1_551_113_065,
        };
        (signed, Secret::new("Gu5t9xGARNpq86cd98joQYCN3EXAMPLE").expect("a key"))
    }

    #[test]
    fn authorization_matches_the_published_example() {
        let (signed, key) = example();
        let headers = "content-type:application/json; charset=utf-8\nhost:cvm.tencentcloudapi.com\n";
        let canonical = canonical_request(headers, "content-type;host", signed.body);
        assert!(canonical.ends_with("35e9c5b0e3ae67532d3c9f17ead6c90222632e5b1ff7f6e89887f1398934f064"));
        assert_eq!(
            hex(&Sha256::digest(&canonical)),
            "5ffe6a04c0664d6b969fab9a13bdab201d63ee709638e2749d62a09ca18d7031"
        );
        assert_eq!(
            of_canonical(&signed, &canonical, "content-type;host", &key),
            "TC3-HMAC-SHA256 Credential=AKIDz8krbsJ5yKBZQpn74WFkmLPx3EXAMPLE/2019-02-25/cvm/tc3_request, \
             SignedHeaders=content-type;host, \
             Signature=72e494ea809ad7a8c8f7a4507b9bddcbaa8e581f516e8da2f66e2c5a96525168"
        );
    }

    #[test]
    fn authorization_signs_the_action_and_the_body() {
        let (signed, key) = example();
        let headers = "content-type:application/json; charset=utf-8\nhost:cvm.tencentcloudapi.com\n\
                       x-tc-action:describeinstances\n";
        let canonical = canonical_request(headers, SIGNED_HEADERS, signed.body);
        assert_eq!(
            hex(&Sha256::digest(&canonical)),
            "7019a55be8395899b900fb5564e4200d984910f34794a27cb3fb7d10ff6a1e84"
        );
        assert_eq!(authorization(&signed, &key), of_canonical(&signed, &canonical, SIGNED_HEADERS, &key));
        let other = Signed { body: b"{}", ..signed };
        assert_ne!(authorization(&other, &key), authorization(&signed, &key));
    }

    #[test]
    fn date_of_handles_leap_years() {
        for (timestamp_s, date) in [
            (0, "1970-01-01"),
            (951_782_399, "2000-02-28"),
            (951_782_400, "2000-02-29"),
            (951_868_800, "2000-03-01"),
            (1_551_113_065, "2019-02-25"),
            (1_735_689_599, "2024-12-31"),
            (1_735_689_600, "2025-01-01"),
        ] {
            assert_eq!(date_of(timestamp_s), date);
        }
    }
}
