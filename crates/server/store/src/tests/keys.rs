//! Keys, sessions and the record of changes.

use super::*;
use crate::audit::{AuditEntry, AuditFilter};
use crate::keys::{Grant, KeyFilter, KeyRow, NewKey, RevokeOutcome, Validity};
use crate::scopes::ScopeSet;
use crate::secret::Secret;

const HOUR_MS: i64 = 3_600_000;

fn new_key(tenant_id: &TenantId, lifetime_ms: Option<i64>) -> NewKey {
    let scopes = ScopeSet::parse("read submit").expect("scopes");
    NewKey { tenant_id: tenant_id.clone(), name: "robot lab".into(), scopes, lifetime_ms }
}

async fn made(store: &Store, lifetime_ms: Option<i64>) -> (KeyRow, Secret) {
    store.create_key(new_key(&DEFAULT_TENANT, lifetime_ms)).await.expect("makes a key")
}

async fn grant(store: &Store, secret: &Secret) -> Option<Grant> {
    store.key_grant(&secret.digest()).await.expect("reads")
}

async fn validity(store: &Store, secret: &Secret) -> Option<Validity> {
    grant(store, secret).await.map(|grant| grant.validity)
}

async fn validity_of_session(store: &Store, session: &Secret) -> Option<Validity> {
    store.session_grant(&session.digest()).await.expect("reads").map(|grant| grant.validity)
}

pub(super) async fn a_key_opens_until_it_expires_or_is_revoked(place: Place) {
    let (first, second) = (place.handle(0), place.handle(1));
    assert!(!first.has_keys().await.expect("reads"));
    let (key, secret) = made(&first, None).await;
    assert!(second.has_keys().await.expect("reads"));
    let opened = grant(&second, &secret).await.expect("is known");
    assert_eq!((&opened.key_id, &opened.tenant_id, &opened.scopes), (&key.id, &key.tenant_id, &key.scopes));
    assert_eq!((opened.validity, opened.expires_at_ms), (Validity::Valid, None));
    assert_eq!(validity(&second, &Secret::new_key().expect("random")).await, None);

    let (brief, brief_secret) = made(&first, Some(1)).await;
    assert_eq!(brief.expires_at_ms, Some(brief.created_at_ms + 1));
    tokio::time::sleep(Duration::from_millis(5)).await;
    assert_eq!(validity(&second, &brief_secret).await, Some(Validity::Expired));

    let other: TenantId = "other".parse().expect("an id");
    let revoke = async |tenant: &TenantId| first.revoke_key(tenant, &key.id).await.expect("answers");
    assert_eq!(revoke(&other).await, RevokeOutcome::NotFound);
    assert_eq!(validity(&second, &secret).await, Some(Validity::Valid));
    assert_eq!(revoke(&DEFAULT_TENANT).await, RevokeOutcome::Revoked);
    assert_eq!(validity(&second, &secret).await, Some(Validity::Revoked));
    assert_eq!(revoke(&DEFAULT_TENANT).await, RevokeOutcome::WasRevoked);
}

pub(super) async fn keys_are_listed_by_tenant_newest_first_without_their_secrets(place: Place) {
    let store = place.store();
    let other: TenantId = "other".parse().expect("an id");
    let (first, _) = made(store, None).await;
    let (second, secret) = made(store, Some(HOUR_MS)).await;
    let (of_other, _) = store.create_key(new_key(&other, None)).await.expect("makes a key");
    let list = async |tenant: &TenantId, before: Option<&KeyRow>, limit| {
        let filter = KeyFilter { before_id: before.map(|key| key.id.clone()), limit };
        store.keys(tenant, filter).await.expect("reads")
    };
    assert_eq!(list(&DEFAULT_TENANT, None, 10).await, [second.clone(), first.clone()]);
    assert_eq!(list(&DEFAULT_TENANT, None, 1).await, std::slice::from_ref(&second));
    assert_eq!(list(&DEFAULT_TENANT, Some(&second), 10).await, [first]);
    assert_eq!(list(&other, None, 10).await, [of_other]);
    let shown = format!("{second:?} {}", serde_json::to_string(&second).expect("serializes"));
    assert!(!shown.contains(secret.expose()) && !shown.contains(secret.digest().as_str()), "{shown}");
}

pub(super) async fn the_use_of_a_key_is_noted_once_a_minute(place: Place) {
    let store = place.store();
    let (key, secret) = made(store, None).await;
    let noted = async || {
        let filter = KeyFilter { limit: 1, ..KeyFilter::default() };
        store.keys(&DEFAULT_TENANT, filter).await.expect("reads")[0].last_used_at_ms
    };
    assert_eq!(noted().await, None);
    let used = grant(store, &secret).await.expect("is known").now_ms;
    let first = loop {
        match noted().await {
            Some(at) => break at,
            None => tokio::time::sleep(Duration::from_millis(5)).await,
        }
    };
    assert_eq!(first, used);
    grant(store, &secret).await.expect("is known");
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(noted().await, Some(first), "a minute has not passed");

    let (id, long_ago) = (key.id.clone(), first - 60_001);
    let age = store.writer.write("pretend a minute", move |connection| {
        Box::pin(async move {
            let query = sqlx::query("UPDATE api_keys SET last_used_at = $1 WHERE id = $2");
            query.bind(long_ago).bind(id.as_str()).execute(connection).await?;
            Ok(())
        })
    });
    age.await.expect("updates");
    grant(store, &secret).await.expect("is known");
    while noted().await == Some(long_ago) {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

pub(super) async fn a_session_ends_by_its_time_its_end_or_its_key(place: Place) {
    let (first, second) = (place.handle(0), place.handle(1));
    let begin = async |key: &Secret, lifetime_ms| {
        let session = Secret::new_session().expect("random");
        let begun = first.begin_session(&key.digest(), &session.digest(), lifetime_ms).await;
        (session, begun.expect("answers"))
    };
    let (key, secret) = made(&first, Some(HOUR_MS)).await;
    let (session, begun) = begin(&secret, 1000 * HOUR_MS).await;
    let begun = begun.expect("is known");
    assert_eq!((begun.validity, begun.expires_at_ms), (Validity::Valid, key.expires_at_ms));
    let opened = second.session_grant(&session.digest()).await.expect("reads").expect("is known");
    assert_eq!((opened.key_id, opened.expires_at_ms), (key.id.clone(), key.expires_at_ms));
    assert_eq!(validity(&second, &session).await, None, "a session is no key");
    assert_eq!(validity_of_session(&second, &secret).await, None, "a key is no session");

    let (brief, _) = begin(&secret, 1).await;
    tokio::time::sleep(Duration::from_millis(5)).await;
    assert_eq!(validity_of_session(&second, &brief).await, Some(Validity::Expired));
    let (ended, _) = begin(&secret, HOUR_MS).await;
    assert_eq!(validity_of_session(&second, &brief).await, None, "it was removed");
    first.end_session(&ended.digest()).await.expect("ends");
    assert_eq!(validity_of_session(&second, &ended).await, None);
    assert_eq!(validity_of_session(&second, &session).await, Some(Validity::Valid));

    first.revoke_key(&DEFAULT_TENANT, &key.id).await.expect("answers");
    assert_eq!(validity_of_session(&second, &session).await, None);
    let (refused, begun) = begin(&secret, HOUR_MS).await;
    assert_eq!(begun.map(|grant| grant.validity), Some(Validity::Revoked));
    assert_eq!(validity_of_session(&second, &refused).await, None);
    assert_eq!(begin(&Secret::new_key().expect("random"), HOUR_MS).await.1, None);
}

pub(super) async fn the_record_is_listed_by_tenant_and_never_changed(place: Place) {
    let store = place.store();
    let other: TenantId = "other".parse().expect("an id");
    let entry = |tenant_id: &TenantId, subject: &str| AuditEntry {
        tenant_id: tenant_id.clone(),
        principal: "key:k".into(),
        address: "192.0.2.7".into(),
        action: "submitScene".into(),
        subject: subject.into(),
        status: 202,
    };
    for subject in ["/a", "/b", "/c"] {
        store.record(entry(&DEFAULT_TENANT, subject)).await.expect("records");
    }
    store.record(entry(&other, "/d")).await.expect("records");
    let list =
        async |tenant: &TenantId, filter: AuditFilter| store.audit(tenant, filter).await.expect("reads");
    let all = AuditFilter { limit: 10, ..AuditFilter::default() };
    let rows = list(&DEFAULT_TENANT, all.clone()).await;
    let subjects: Vec<&str> = rows.iter().map(|row| row.entry.subject.as_str()).collect();
    assert_eq!(subjects, ["/c", "/b", "/a"]);
    assert_eq!(rows[2].entry, entry(&DEFAULT_TENANT, "/a"));
    assert_eq!(list(&other, all.clone()).await.len(), 1);
    let page = AuditFilter { before_id: Some(rows[0].id.clone()), limit: 1, ..all.clone() };
    assert_eq!(list(&DEFAULT_TENANT, page).await, [rows[1].clone()]);
    let since = AuditFilter { since_ms: Some(rows[2].at_ms), ..all.clone() };
    assert_eq!(list(&DEFAULT_TENANT, since).await.len(), 3);
    let later = AuditFilter { since_ms: Some(rows[0].at_ms + 1), ..all };
    assert_eq!(list(&DEFAULT_TENANT, later).await, []);

    for change in ["UPDATE audit SET principal = 'nobody'", "DELETE FROM audit"] {
        let changed = store.writer.write("change the record", move |connection| {
            Box::pin(async move {
                sqlx::query(change).execute(connection).await?;
                Ok(())
            })
        });
        assert!(changed.await.is_err(), "{change}");
    }
    assert_eq!(list(&DEFAULT_TENANT, AuditFilter { limit: 10, ..AuditFilter::default() }).await, rows);
}
