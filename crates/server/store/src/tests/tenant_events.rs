//! Events of all jobs and recordings of a tenant: one order, in which nothing is skipped.

use std::collections::BTreeSet;

use super::recordings;
use super::*;
use crate::tenant_events::TenantEvent;

/// Every event of the tenant after a position, read a few at a time.
async fn pages(store: &Store, mut after: i64) -> Vec<TenantEvent> {
    let mut all = Vec::new();
    store.number_events().await.expect("numbers");
    loop {
        let page = store.tenant_events(&DEFAULT_TENANT, after, 3).await.expect("reads");
        let Some(last) = page.last() else { return all };
        after = last.position;
        all.extend(page);
    }
}

pub(super) async fn events_of_jobs_and_recordings_have_one_order(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let (scene, job) = submitted(&one).await;
    let recording = recordings::submitted(&other, 1, 50).await;
    let first = pages(&one, 0).await;
    let claim = claimed(&other, "worker").await;
    other.note(&claim.lease, "alpha", "half".into()).await.expect("notes");
    let strange = NewScene { tenant_id: "other".parse().expect("an id"), ..new_scene() };
    one.submit(strange).await.expect("submits");
    let last = first.last().expect("events").position;
    let later = pages(&other, last).await;
    assert_eq!(
        one.last_position(&DEFAULT_TENANT).await.expect("reads"),
        later.last().expect("events").position
    );
    let all = pages(&other, 0).await;
    assert_eq!(all, [first, later].concat());

    let positions: Vec<i64> = all.iter().map(|event| event.position).collect();
    assert!(positions.is_sorted_by(|one, next| one < next), "{positions:?}");
    let of_job: Vec<_> = all
        .iter()
        .filter(|event| event.job.as_ref().is_some_and(|(id, _)| *id == job))
        .map(|event| event.event.clone())
        .collect();
    assert_eq!(of_job, one.events(&DEFAULT_TENANT, &job, 0, 9).await.expect("reads"));
    assert_eq!(of_job.len(), 3);
    let of_scene = all.iter().find(|event| event.scene_id.as_ref() == Some(&scene)).expect("one of the job");
    assert_eq!(of_scene.job, Some((job, JobKind::Generate)));
    let of_recording: Vec<_> = all.iter().filter(|event| event.job.is_none()).collect();
    assert_eq!(of_recording.len(), 1);
    assert_eq!(
        (of_recording[0].event.kind.as_str(), &of_recording[0].recording_id),
        ("queued", &Some(recording))
    );
}

pub(super) async fn a_reader_skips_nothing_of_writers_at_once(place: Place) {
    const WRITERS: usize = 4;
    const SCENES: usize = 25;
    let writers: Vec<_> = (0..WRITERS)
        .map(|writer| {
            let store = place.handle(writer);
            tokio::spawn(async move {
                for _ in 0..SCENES {
                    let (_, job) = submitted(&store).await;
                    store.cancel(&DEFAULT_TENANT, &job).await.expect("cancels");
                }
            })
        })
        .collect();
    // Two processes number and read meanwhile; each goes on after what it saw last.
    let readers: Vec<_> = (0..2)
        .map(|reader| {
            let store = place.handle(reader);
            tokio::spawn(async move {
                let (mut seen, mut after) = (Vec::new(), 0);
                for _ in 0..3_000 {
                    let new = pages(&store, after).await;
                    after = new.last().map_or(after, |event| event.position);
                    seen.extend(new);
                    if seen.len() == 2 * WRITERS * SCENES {
                        break;
                    }
                    tokio::time::sleep(Duration::from_millis(3)).await;
                }
                seen
            })
        })
        .collect();
    for writer in writers {
        writer.await.expect("writes");
    }
    let stored = pages(place.store(), 0).await;
    let names: BTreeSet<_> =
        stored.iter().map(|event| (event.job.clone().expect("a job").0, event.event.seq)).collect();
    assert_eq!((stored.len(), names.len()), (2 * WRITERS * SCENES, 2 * WRITERS * SCENES));
    for reader in readers {
        assert_eq!(reader.await.expect("reads"), stored);
    }
}
