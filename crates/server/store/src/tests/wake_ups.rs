//! Wake-ups across processes.

use super::*;

pub(super) async fn a_change_of_one_handle_wakes_the_other(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let wait = Duration::from_secs(20);
    let mut changes = other.changes();
    changes.mark_unchanged();
    let job = submitted(&one).await.1;
    tokio::time::timeout(wait, changes.changed()).await.expect("wakes up").expect("the store is open");
    let mut cancellations = other.cancellations();
    cancellations.mark_unchanged();
    one.cancel(&DEFAULT_TENANT, &job).await.expect("cancels");
    tokio::time::timeout(wait, cancellations.changed()).await.expect("wakes up").expect("the store is open");
}
