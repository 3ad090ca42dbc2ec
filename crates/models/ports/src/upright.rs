//! Standing a raw mesh up by geometric evidence, which every analyst's answer passes through.

use glam::DQuat;

use geometry::TexturedMesh;
use pose_estimation::upright::{UprightError, UprightPose, UprightProblem, upright};
use runtime::CancelFlag;

use super::{Port, ProviderError, UprightQuestion};

/// Rotates a mesh upright by its size, the image, a typical mesh of its category, and the rotations `hints` by a model.
///
/// # Errors
///
/// [`ProviderError::Rejected`] with the code `not_upright` where no rotation fits, and an interruption.
pub fn stood_up(
    question: &UprightQuestion,
    example: Option<&TexturedMesh>,
    hints: &[DQuat],
    cancel: &CancelFlag,
) -> Result<UprightPose, ProviderError> {
    let problem = UprightProblem {
        raw_mesh: &question.raw_mesh,
        camera: &question.camera,
        mask: &question.completion.silhouette,
        image: Some((&question.completion.image, question.completion.crop_px)),
        size_m: question.object.size_m,
        example,
        hints,
    };
    upright(&problem, &question.canonicalize, &question.dro, cancel).map_err(|error| match error {
        UprightError::Cancelled(cancelled) => cancelled.into(),
        other => ProviderError::Rejected {
            port: Port::Analyst,
            code: "not_upright",
            reason: format!("{}: {other}", question.object.id),
        },
    })
}
