//! How painting fails.

use crate::layout::LayoutError;
use physics::ResolveError;
use ports::{Port, ProviderError};
use runtime::Interrupted;

fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::Painter, code, reason }
}

/// A category or a table model the catalog does not have.
pub(super) fn unknown(what: &str, name: &str) -> ProviderError {
    rejected(
        "not_in_catalog",
        format!("painting: the catalog has no {what} {name:?}; describe the scene again"),
    )
}

/// A catalog mesh from which no body can be made.
pub(super) fn broken(name: &str, why: &dyn std::fmt::Display) -> ProviderError {
    rejected("broken_mesh", format!("painting {name}: {why}"))
}

pub(super) fn layout(error: LayoutError) -> ProviderError {
    match error {
        LayoutError::Interrupted(Interrupted) => Interrupted.into(),
        LayoutError::NoRoom { .. } => rejected("no_room", format!("painting: {error}")),
    }
}

pub(super) fn resolve(error: ResolveError) -> ProviderError {
    match error {
        ResolveError::Interrupted(Interrupted) => Interrupted.into(),
        ResolveError::NoRoom { .. } => rejected("no_room", format!("painting: {error}")),
        _ => rejected("does_not_hold", format!("painting: {error}")),
    }
}

/// No camera shows these objects.
pub(super) fn hidden(names: &[String]) -> ProviderError {
    rejected(
        "hidden",
        format!(
            "painting: {} would be hidden in every picture tried; ask for a larger table or fewer objects",
            if names.is_empty() { "some objects".to_owned() } else { names.join(", ") }
        ),
    )
}
