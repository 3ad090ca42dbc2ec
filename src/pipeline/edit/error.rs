//! Reasons why a draft of an edited scene cannot be made, and why an operation is refused.
//!
//! Each is the end of a sentence that names the operation, for the client.

use editing::references::ReferenceError;
use editing::{NoPlace, RestFault};
use geometry::collision_shape::BrokenHull;
use geometry::mass_properties::MassError;
use geometry::solid_query::SolidError;
use runtime::Cancelled;

/// Reason why a draft cannot be made or changed.
#[derive(Debug, thiserror::Error)]
pub(super) enum EditError {
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    #[error(transparent)]
    NoPlace(#[from] NoPlace),
    #[error(transparent)]
    Mass(#[from] MassError),
    #[error(transparent)]
    Solid(#[from] SolidError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("{body}: {source}")]
    Hulls { body: String, source: BrokenHull },

    // Rest.
    /// The place in words, such as "on plate_1".
    #[error("{object} does not stay {place}: {fault}")]
    LeavesPlace { object: String, place: String, fault: RestFault },
    #[error("{object} does not stay: {fault}")]
    LeavesDrawnPlace { object: String, fault: RestFault },
    #[error("the contents of {container} do not stay: {fault}")]
    RestlessContents { container: String, fault: RestFault },
    /// A seed drew the operation, which must keep all supports.
    #[error("something would come to rest on something else")]
    OtherSupports,

    // Objects and places that an operation names.
    #[error("the table cannot be moved, removed, replaced or resized; restyle_table changes its appearance")]
    FixedTable,
    #[error("the table is none of the objects")]
    TableIsNoObject,
    #[error("a place relative to the table is one of its regions, or `on` it")]
    RelativeToTable,
    #[error("{object} cannot be placed relative to itself")]
    RelativeToItself { object: String },
    #[error("{carried} rests on or in {object}, so {object} cannot go there")]
    RelativeToCarried { object: String, carried: String },
    #[error("a stack needs at least two different objects")]
    TooFewToStack,
    #[error("{below} rests on or in {above}; name the lower one first")]
    StackedUpsideDown { below: String, above: String },
    #[error("two objects change places; its phrases mean another number of them")]
    NotTwoToSwap,
    #[error("a row needs at least two objects")]
    TooFewToLineUp,
    #[error("there is no free place for the whole row; move what is in the way, or name another edge")]
    NoRoomForRow,
    #[error("a row stands along an edge, in a part of the table, or where its objects are")]
    NoPlaceForRow,
    #[error("{objects} objects and {landmarks} places do not match; name as many of one as of the other")]
    UnequalNumbers { objects: usize, landmarks: usize },
    #[error("it lies on its side, so it has no yaw; move it instead")]
    NoYaw,
    #[error("it cannot face itself")]
    FacesItself,
    #[error("nothing on the table can be aligned")]
    NothingToAlign,

    // New layouts.
    #[error("the text fixes where everything is")]
    EverythingFixed,
    #[error("{object} would not keep what the text states of it")]
    BreaksText { object: String },
    #[error("none of {layouts} other layouts is possible: {last}")]
    NoLayout { layouts: usize, last: Box<Self> },

    // New objects.
    #[error("it needs exactly one new object")]
    NotOneNewObject,
    #[error("the theme has {found} objects, not {wanted}")]
    ThemeTooSmall { found: usize, wanted: u32 },
    #[error("its phrase gives {made} objects, not {wanted}; name one kind of object")]
    OtherCount { made: usize, wanted: usize },
    #[error("{words:?} is not understood; name another object")]
    UnknownWords { words: String },

    // Appearance.
    #[error("{words:?} is no color that is known; give one such as red, navy or beige")]
    UnknownColor { words: String },
    #[error("{words:?} is no material that is known; give one such as wood, steel or glass")]
    UnknownMaterial { words: String },
    #[error("no table was made")]
    NoTable,
    #[error("this table cannot be made again in the same shape; its appearance stays")]
    OtherTableShape,
    #[error("this table cannot be made again with the same top; its color stays")]
    OtherTableTop,
}
