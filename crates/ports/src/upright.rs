//! Standing a raw mesh up by geometric evidence, which every analyst's answer passes through.

use glam::DQuat;

use geometry::TexturedMesh;
use pose_estimation::canonicalize::{CanonicalPose, CanonicalizeError, UprightProblem, upright};
use runtime::Interrupt;

use super::{Port, ProviderError, UprightQuestion};

/// Rotates a mesh upright by its size, the image, a typical mesh of its category, and the rotations `told` by a model.
///
/// # Errors
///
/// [`ProviderError::Rejected`] with the code `not_upright` where no rotation fits, and an interruption.
pub fn stood_up(
    question: &UprightQuestion,
    example: Option<&TexturedMesh>,
    told: &[DQuat],
    interrupt: &Interrupt,
) -> Result<CanonicalPose, ProviderError> {
    let problem = UprightProblem {
        raw_mesh: &question.raw_mesh,
        camera: &question.camera,
        mask: &question.completion.silhouette,
        picture: Some((&question.completion.picture, question.completion.shown_px)),
        size_m: question.object.size_m,
        example,
        told,
    };
    upright(&problem, &question.canonicalize, &question.dro, interrupt).map_err(|error| match error {
        CanonicalizeError::Interrupted(interrupted) => interrupted.into(),
        other => ProviderError::Rejected {
            port: Port::Analyst,
            code: "not_upright",
            reason: format!("{}: {other}", question.object.id),
        },
    })
}
