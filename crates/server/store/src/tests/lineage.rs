//! Scenes that were made from others.

use super::*;
use crate::scenes::SceneFilter;

async fn child_of(store: &Store, parent: Option<&SceneId>) -> SceneId {
    let new = NewScene { parent_id: parent.cloned(), ..new_scene() };
    match store.submit(new).await.expect("submits") {
        SubmitOutcome::Created { scene_id, .. } => scene_id,
        other => panic!("a submission without a key is {other:?}"),
    }
}

pub(super) async fn ancestors_come_oldest_first_and_children_newest_first(place: Place) {
    let store = place.store();
    let root = child_of(store, None).await;
    let first = child_of(store, Some(&root)).await;
    let second = child_of(store, Some(&first)).await;
    let sibling = child_of(store, Some(&first)).await;
    store.delete_scene(&DEFAULT_TENANT, &root).await.expect("deletes");
    let ancestors = async |tenant: &TenantId, id: &SceneId, limit| -> Vec<SceneId> {
        let rows = store.ancestors(tenant, id, limit).await.expect("reads");
        rows.into_iter().map(|scene| scene.id).collect()
    };
    let tenant: &TenantId = &DEFAULT_TENANT;
    assert_eq!(ancestors(tenant, &root, 10).await, []);
    assert_eq!(ancestors(tenant, &second, 10).await, [root.clone(), first.clone()]);
    assert_eq!(ancestors(tenant, &sibling, 1).await, std::slice::from_ref(&first));
    let other: TenantId = "other".parse().expect("an id");
    assert_eq!(ancestors(&other, &second, 10).await, []);

    let children = SceneFilter { parent: Some(first), limit: 10, ..SceneFilter::default() };
    let children = store.scenes(tenant, children).await.expect("reads");
    let children: Vec<_> = children.into_iter().map(|(scene, _)| scene.id).collect();
    assert_eq!(children, [sibling, second]);
}
