//! Turns of tenants at a scarce part of the server: a few requests have it at a time, and when one leaves, the next is
//! of the tenant that waits longest for a turn, however many of another tenant wait.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

use scene::TenantId;

/// The part, for so many requests at a time; cloning shares it.
#[derive(Clone, Debug)]
pub struct Turns(Arc<Mutex<State>>);

#[derive(Debug)]
struct State {
    /// Requests that may begin at once.
    free: usize,
    /// Tenants with requests that wait, each with its own in their order. The first tenant is next.
    waiting: VecDeque<(TenantId, VecDeque<oneshot::Sender<Turn>>)>,
}

/// The right to the part, until it is dropped; `None` = it was given to another.
#[derive(Debug)]
pub struct Turn(Option<Turns>);

impl Turns {
    pub fn new(at_once: usize) -> Self {
        Self(Arc::new(Mutex::new(State { free: at_once.max(1), waiting: VecDeque::new() })))
    }

    /// Waits for a turn of the tenant. A request that goes away gives up its place.
    pub async fn of(&self, tenant_id: &TenantId) -> Turn {
        let granted = {
            let mut state = self.state();
            if state.free > 0 {
                state.free -= 1;
                return Turn(Some(self.clone()));
            }
            let (sender, granted) = oneshot::channel();
            match state.waiting.iter_mut().find(|(of, _)| of == tenant_id) {
                Some((_, own)) => own.push_back(sender),
                None => state.waiting.push_back((tenant_id.clone(), VecDeque::from([sender]))),
            }
            granted
        };
        // No sender is dropped before it has sent.
        granted.await.unwrap_or(Turn(None))
    }

    /// Passes a turn on, or frees it.
    fn pass_on(&self) {
        loop {
            let next = {
                let mut state = self.state();
                let Some((tenant_id, mut own)) = state.waiting.pop_front() else {
                    state.free += 1;
                    return;
                };
                let next = own.pop_front();
                if !own.is_empty() {
                    state.waiting.push_back((tenant_id, own));
                }
                next
            };
            let Some(sender) = next else { continue };
            match sender.send(Turn(Some(self.clone()))) {
                Ok(()) => return,
                // The request is gone, and the turn goes to the next, once.
                Err(mut unused) => unused.0 = None,
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        if let Some(turns) = self.0.take() {
            turns.pass_on();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn tenant(name: &str) -> TenantId {
        name.parse().expect("an id")
    }

    /// Lets waiting tasks come to where they wait.
    async fn settle() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }

    #[tokio::test]
    async fn tenants_take_turns_however_many_requests_they_have() {
        let turns = Turns::new(1);
        let first = turns.of(&tenant("flood")).await;
        let order = Arc::new(Mutex::new(Vec::new()));
        let mut tasks = Vec::new();
        for (k, name) in ["flood", "flood", "flood", "flood", "lab", "lab", "arm"].into_iter().enumerate() {
            let (turns, order) = (turns.clone(), order.clone());
            tasks.push(tokio::spawn(async move {
                let _turn = turns.of(&tenant(name)).await;
                order.lock().expect("a lock").push(format!("{name} {k}"));
                settle().await;
            }));
            settle().await;
        }
        drop(first);
        for task in tasks {
            task.await.expect("ends");
        }
        let expected = ["flood 0", "lab 4", "arm 6", "flood 1", "lab 5", "flood 2", "flood 3"];
        assert_eq!(*order.lock().expect("a lock"), expected);
    }

    #[tokio::test]
    async fn a_request_that_goes_away_keeps_no_turn() {
        let turns = Turns::new(2);
        let held = [turns.of(&tenant("a")).await, turns.of(&tenant("a")).await];
        let gone = tokio::spawn({
            let turns = turns.clone();
            async move { turns.of(&tenant("b")).await }
        });
        settle().await;
        gone.abort();
        assert!(gone.await.is_err());
        drop(held);
        let _both = [turns.of(&tenant("a")).await, turns.of(&tenant("b")).await];
        let third = tokio::time::timeout(Duration::from_millis(50), turns.of(&tenant("c"))).await;
        assert!(third.is_err(), "three have two turns");
    }
}
