//! Faults of recording become failures that say what to do, and whether the attempt counts.

use std::io::ErrorKind;

use super::*;
use crate::pipeline::error::StageErrorClass;

#[test]
fn a_disk_that_refuses_is_tried_again_and_a_refusal_is_not() {
    let refused = RecordError::file("create", Path::new("x"))(ErrorKind::PermissionDenied.into());
    let refused = StageError::from(refused);
    assert_eq!((refused.class, refused.code), (StageErrorClass::Transient, "work_folder_unusable"));
    assert!(refused.message.contains("cannot create") && refused.message.contains("permissions"));
    let full = StageError::from(RecordError::from(EpisodeError::DiskFull { path: "x".into() }));
    let cause = full.cause.and_then(|cause| cause.downcast::<std::io::Error>().ok());
    assert_eq!(cause.map(|cause| cause.kind()), Some(ErrorKind::StorageFull), "which burns no attempt");
    let refusal = Problem::new(ProblemType::InvalidRequest, "not_feasible", "too far");
    let refused = StageError::from(RecordError::from(refusal));
    assert_eq!((refused.class, refused.code), (StageErrorClass::Permanent, "not_feasible"));
}
