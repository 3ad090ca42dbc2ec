//! Errors of the embedded image generator.

use crate::layout::LayoutError;
use physics::ResolveError;
use ports::{Port, ProviderError};
use runtime::Cancelled;

fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::ImageGenerator, code, reason }
}

/// A category or table model outside the catalog.
pub(super) fn unknown(what: &str, name: &str) -> ProviderError {
    rejected(
        "not_in_catalog",
        format!("painting: the catalog has no {what} {name:?}; describe the scene again"),
    )
}

/// A catalog mesh that does not convert to a rigid body.
pub(super) fn broken(name: &str, why: &dyn std::fmt::Display) -> ProviderError {
    rejected("broken_mesh", format!("painting {name}: {why}"))
}

pub(super) fn layout(error: LayoutError) -> ProviderError {
    match error {
        LayoutError::Cancelled(Cancelled) => Cancelled.into(),
        LayoutError::NoRoom { .. } => rejected("no_room", format!("painting: {error}")),
    }
}

pub(super) fn resolve(error: ResolveError) -> ProviderError {
    match error {
        ResolveError::Cancelled(Cancelled) => Cancelled.into(),
        ResolveError::NoSpace { .. } => rejected("no_room", format!("painting: {error}")),
        _ => rejected("does_not_hold", format!("painting: {error}")),
    }
}

/// Objects that are occluded from every camera tried.
pub(super) fn hidden(names: &[String]) -> ProviderError {
    rejected(
        "hidden",
        format!(
            "painting: {} would be hidden in every image tried; ask for a larger table or fewer objects",
            if names.is_empty() { "some objects".to_owned() } else { names.join(", ") }
        ),
    )
}
