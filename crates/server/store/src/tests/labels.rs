//! Labels of scenes that are there already.

use super::*;
use crate::scenes::{LabelsOutcome, SceneFilter, SceneRow};

fn labels(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

async fn read(store: &Store, id: &SceneId) -> SceneRow {
    store.scene(&DEFAULT_TENANT, id).await.expect("reads").expect("is there")
}

/// Number of scenes with a label.
async fn found(store: &Store, key: &str, value: &str) -> usize {
    let label = Some((key.to_owned(), value.to_owned()));
    let filter = SceneFilter { label, limit: 9, ..SceneFilter::default() };
    store.scenes(&DEFAULT_TENANT, filter).await.expect("reads").len()
}

pub(super) async fn labels_are_replaced_and_found_by_their_new_values(place: Place) {
    let store = place.store();
    let new = NewScene { labels: labels(&[("split", "test"), ("room", "k")]), ..new_scene() };
    let SubmitOutcome::Created { scene_id, .. } = store.submit(new).await.expect("submits") else {
        panic!("no key")
    };
    submitted(store).await;
    let before = read(store, &scene_id).await;
    let changed = labels(&[("split", "train"), ("reviewed", "")]);
    let outcome = store.replace_labels(&DEFAULT_TENANT, before.clone(), changed.clone()).await;
    let LabelsOutcome::Replaced(after) = outcome.expect("answers") else { panic!("nobody else changes it") };
    assert_eq!((*after.clone(), &after.labels), (read(store, &scene_id).await, &changed));
    for (key, value, count) in
        [("split", "train", 1), ("reviewed", "", 1), ("split", "test", 0), ("room", "k", 0)]
    {
        assert_eq!(found(store, key, value).await, count, "{key}:{value}");
    }
    let late = store.replace_labels(&DEFAULT_TENANT, before, labels(&[])).await.expect("answers");
    assert_eq!(late, LabelsOutcome::Differs, "it was read before the change");
    let stranger: TenantId = "other".parse().expect("an id");
    let other = store.replace_labels(&stranger, *after.clone(), labels(&[])).await.expect("answers");
    assert_eq!(other, LabelsOutcome::Differs);
    assert_eq!(read(store, &scene_id).await, *after);
}

pub(super) async fn changes_at_once_follow_each_other(place: Place) {
    const CHANGES: usize = 12;
    let id = submitted(place.store()).await.0;
    let changes: Vec<_> = (0..CHANGES)
        .map(|index| {
            let (store, id) = (place.handle(index), id.clone());
            tokio::spawn(async move {
                loop {
                    let scene = read(&store, &id).await;
                    let mut labels = scene.labels.clone();
                    labels.insert(format!("k{index}"), "v".to_owned());
                    let outcome = store.replace_labels(&DEFAULT_TENANT, scene, labels).await;
                    if outcome.expect("answers") != LabelsOutcome::Differs {
                        return;
                    }
                }
            })
        })
        .collect();
    for change in changes {
        change.await.expect("runs");
    }
    assert_eq!(read(place.store(), &id).await.labels.len(), CHANGES, "no change is lost");
    assert_eq!(found(place.store(), "k7", "v").await, 1);
}
