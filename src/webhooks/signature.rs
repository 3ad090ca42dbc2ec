//! The signature of a message, by Standard Webhooks: the symmetric scheme `v1`.
//!
//! HMAC-SHA256 over the id, the time and the body with dots between them. The key is what the base64 behind `whsec_`
//! says.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use http_client::hmac::hmac_sha256;
use store::secret::{Secret, WEBHOOK_PREFIX};

/// The header `webhook-signature` of a message that is sent at a time in seconds since 1970: one signature by each
/// secret. A text that is no secret of a webhook signs nothing.
pub fn signatures(secrets: &[Secret], id: &str, timestamp_s: u64, body: &str) -> String {
    let signed = format!("{id}.{timestamp_s}.{body}");
    let signature = |secret: &Secret| {
        let key = STANDARD.decode(secret.expose().strip_prefix(WEBHOOK_PREFIX)?).ok()?;
        Some(format!("v1,{}", STANDARD.encode(hmac_sha256(&key, signed.as_bytes()))))
    };
    secrets.iter().filter_map(signature).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_match_the_example_of_the_specification() {
        let secret = Secret::given("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw");
        let (id, body) = ("msg_p5jXN8AQM9LWM0D4loKWxJek", r#"{"test": 2432232314}"#);
        let expected = "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=";
        assert_eq!(signatures(std::slice::from_ref(&secret), id, 1_614_265_330, body), expected);
        let new = Secret::new_webhook().expect("random");
        let both = signatures(&[new, secret], id, 1_614_265_330, body);
        assert_eq!(both.split(' ').count(), 2);
        assert!(both.ends_with(&format!(" {expected}")) && !both.starts_with(expected), "{both}");
        assert_eq!(signatures(&[Secret::given("whsec_?")], id, 0, body), "");
    }
}
