//! Reasons why a table of a shape defines no part or no surface.

/// Reason why a table of a shape defines no part or no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum TableError {
    #[error(
        "a part has exactly one form: box, cylinder, ball, turned, hoop, ring, tube, plate, loft or inflated"
    )]
    FormCount,
    #[error("the form has {points} points, but needs {needed}: {form}")]
    TooFewPoints { points: usize, needed: usize, form: String },
    #[error("`lumpy` is a share below one half, not {0}")]
    Lumpy(f64),
    #[error("`{0}` is no color: write main, lighter, darker, contrasting or #rrggbb")]
    UnknownColor(String),
    #[error("no finish is called `{0}`")]
    UnknownFinish(String),
}
