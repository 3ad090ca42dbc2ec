//! Errors of the embedded image generator.

use crate::layout::LayoutError;
use physics::ResolveError;
use ports::{Port, ProviderError};
use runtime::Cancelled;
use scene::RequestedPose;

fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::ImageGenerator, code, reason }
}

/// A category or table model outside the catalog.
pub(super) fn unknown(what: &str, name: &str) -> ProviderError {
    rejected(
        "not_in_catalog",
        format!("rendering: the catalog has no {what} {name:?}; describe the scene again"),
    )
}

/// A catalog mesh that does not convert to a rigid body.
pub(super) fn broken(name: &str, why: &dyn std::fmt::Display) -> ProviderError {
    rejected("broken_mesh", format!("rendering {name}: {why}"))
}

/// An object that no face of its hull carries in the requested pose.
pub(super) fn cannot_rest(name: &str, pose: RequestedPose) -> ProviderError {
    let pose = match pose {
        RequestedPose::Upright => "upright",
        RequestedPose::LyingOnSide => "on its side",
        RequestedPose::UpsideDown => "upside down",
    };
    rejected("pose_not_supported", format!("rendering {name}: it cannot rest {pose}; ask for another pose"))
}

/// Whether the error states that space is missing.
pub(super) fn is_no_room(error: &ProviderError) -> bool {
    matches!(error, ProviderError::Rejected { code: "no_room", .. })
}

pub(super) fn layout(error: LayoutError) -> ProviderError {
    match error {
        LayoutError::Cancelled(Cancelled) => Cancelled.into(),
        LayoutError::NoRoom { .. } => rejected("no_room", format!("rendering: {error}")),
    }
}

pub(super) fn resolve(error: ResolveError) -> ProviderError {
    match error {
        ResolveError::Cancelled(Cancelled) => Cancelled.into(),
        ResolveError::NoSpace { .. } => rejected("no_room", format!("rendering: {error}")),
        _ => rejected("does_not_hold", format!("rendering: {error}")),
    }
}

/// Objects that are occluded from every camera tried.
pub(super) fn hidden(names: &[String]) -> ProviderError {
    rejected(
        "hidden",
        format!(
            "rendering: {} would be hidden in every image tried; ask for a larger table or fewer objects",
            if names.is_empty() { "some objects".to_owned() } else { names.join(", ") }
        ),
    )
}
