//! Objects in a row or a column, also sorted.

use glam::DVec2;

use super::exchange::set_placed;
use super::{Done, all_of, ids, names};
use crate::pipeline::edit::draft::Draft;
use crate::pipeline::edit::error::EditError;
use editing::PlaceQuery;
use editing::place::nearest_right_angle_rad;
use geometry::pose::wrap_angle_rad;
use geometry::{Outline, Pose, Rgb};
use glam::DQuat;
use scene::{ArrangedAs, EditPlace, RelationKind, SortedBy, Supporter};

/// Free distances between neighbors that are tried, meters.
const GAPS_M: [f64; 4] = [0.04, 0.025, 0.015, 0.008];
/// Free distance to an edge of the table that is not stated, meters.
const MARGIN_M: f64 = 0.03;
/// Distances by which the whole row is shifted until it is free, meters.
const SHIFT_M: f64 = 0.02;
const SHIFTS: i32 = 12;
/// Free rows in which objects are let down before the operation is refused.
const MAX_TRIES: usize = 4;

/// An object of the row, as it will stand.
struct Member {
    object: usize,
    yaw_rad: f64,
    /// Extents in the world.
    size_m: DVec2,
}

pub(super) fn arrange(
    draft: &mut Draft,
    phrases: &[String],
    arrangement: ArrangedAs,
    sort_by: Option<SortedBy>,
    place: Option<&EditPlace>,
) -> Done {
    let mut targets = all_of(draft, phrases)?;
    if targets.len() < 2 {
        return Err(EditError::TooFewToLineUp);
    }
    match sort_by {
        Some(key) => sort(draft, &mut targets, key),
        // Neighbors stay neighbors.
        None if phrases.len() == 1 => {
            let along = |object: &usize| axis_of(arrangement).dot(draft.center_m(*object));
            targets.sort_by(|a, b| along(a).total_cmp(&along(b)));
        }
        None => {}
    }
    for &target in &targets {
        draft.is_named(target);
        let branch = draft.workspace.branch(target);
        draft.may_move(&branch, &format!("it moves with {}", draft.name(target)));
    }
    let members: Vec<Member> = targets.iter().map(|&object| member(draft, object)).collect();
    let center_m = center(draft, &members, arrangement, place)?;
    let mut last_error = EditError::NoRoomForRow;
    let mut tries = 0;
    for gap_m in GAPS_M {
        for shift_m in shifts() {
            let centers = centers(&members, arrangement, center_m + shift_m, gap_m);
            let mut tried = draft.clone();
            targets.iter().for_each(|&target| set_placed(&mut tried, target, false));
            if !is_free(&mut tried, &members, &centers) {
                continue;
            }
            match stood(&mut tried, &members, &centers) {
                Ok(()) => {
                    *draft = tried;
                    let shape = if arrangement == ArrangedAs::Row { "row" } else { "column" };
                    return Ok((
                        ids(draft, &targets),
                        format!("put {} in a {shape}", names(draft, &targets)),
                    ));
                }
                Err(why) => (last_error, tries) = (why, tries + 1),
            }
            if tries == MAX_TRIES {
                return Err(last_error);
            }
        }
    }
    Err(last_error)
}

fn axis_of(arrangement: ArrangedAs) -> DVec2 {
    match arrangement {
        ArrangedAs::Row => DVec2::X,
        ArrangedAs::Column => DVec2::Y,
    }
}

fn member(draft: &Draft, object: usize) -> Member {
    let pose = draft.pose(object);
    let now_rad = pose.yaw_rad().unwrap_or(0.0);
    let yaw_rad = nearest_right_angle_rad(now_rad);
    let turned = Pose { rotation: DQuat::from_rotation_z(yaw_rad - now_rad) * pose.rotation, ..pose };
    let (low, high) = draft.workspace.objects[object].footprint_at(&turned).bounds();
    Member { object, yaw_rad: wrap_angle_rad(yaw_rad), size_m: high - low }
}

/// The center of the row: that of its objects, or the place that is stated.
fn center(
    draft: &Draft,
    members: &[Member],
    arrangement: ArrangedAs,
    place: Option<&EditPlace>,
) -> Result<DVec2, EditError> {
    use RelationKind as R;
    let count = members.len() as f64;
    let mean_m: DVec2 = members.iter().map(|member| draft.center_m(member.object)).sum::<DVec2>() / count;
    let Some(place) = place else { return Ok(mean_m) };
    if let Some(position_m) = place.position_m {
        return Ok(position_m);
    }
    let side = match place.relation {
        Some(R::AtCenter) => DVec2::ZERO,
        Some(R::AtLeft | R::FromLeftEdge) => DVec2::NEG_X,
        Some(R::AtRight | R::FromRightEdge) => DVec2::X,
        Some(R::AtFront | R::FromFrontEdge) => DVec2::NEG_Y,
        Some(R::AtBack | R::FromBackEdge) => DVec2::Y,
        Some(R::AtFrontLeft) => DVec2::new(-1.0, -1.0),
        Some(R::AtFrontRight) => DVec2::new(1.0, -1.0),
        Some(R::AtBackLeft) => DVec2::new(-1.0, 1.0),
        Some(R::AtBackRight) => DVec2::ONE,
        Some(R::On) if place.target.is_none() => return Ok(mean_m),
        _ => return Err(EditError::NoPlaceForRow),
    };
    let (low, high) = draft.workspace.outline.bounds();
    let axis = axis_of(arrangement);
    let length_m: f64 = members.iter().map(|member| axis.dot(member.size_m) + GAPS_M[1]).sum();
    let across = DVec2::ONE - axis;
    let depth_m = members.iter().map(|member| across.dot(member.size_m)).fold(0.0, f64::max);
    let row_m = axis * length_m + across * depth_m;
    let margin_m = place.distance_m.unwrap_or(MARGIN_M);
    Ok(0.5 * (low + high) + side * (0.5 * (high - low) - 0.5 * row_m - margin_m).max(DVec2::ZERO))
}

/// Shifts of the row, the smallest first.
fn shifts() -> Vec<DVec2> {
    let mut shifts: Vec<DVec2> = (-SHIFTS..=SHIFTS)
        .flat_map(|x| (-SHIFTS..=SHIFTS).map(move |y| DVec2::new(f64::from(x), f64::from(y)) * SHIFT_M))
        .collect();
    shifts.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    shifts
}

fn centers(members: &[Member], arrangement: ArrangedAs, center_m: DVec2, gap_m: f64) -> Vec<DVec2> {
    let axis = axis_of(arrangement);
    let lengths = members.iter().map(|member| axis.dot(member.size_m));
    let whole_m: f64 = lengths.clone().sum::<f64>() + gap_m * (members.len() as f64 - 1.0);
    let mut start_m = -0.5 * whole_m;
    lengths
        .map(|length_m| {
            let at = center_m + axis * (start_m + 0.5 * length_m);
            start_m += length_m + gap_m;
            at
        })
        .collect()
}

fn place_query(member: &Member, at_m: DVec2) -> PlaceQuery {
    PlaceQuery {
        near_m: Some(at_m),
        within_m: Some(0.006),
        yaw_rad: Some(member.yaw_rad),
        by_nearness: true,
        ..PlaceQuery::default()
    }
}

/// Whether every object has room at its place.
fn is_free(draft: &mut Draft, members: &[Member], centers: &[DVec2]) -> bool {
    members.iter().zip(centers).all(|(member, at_m)| {
        is_within(&draft.workspace.outline, *at_m)
            && draft.workspace.places(member.object, &place_query(member, *at_m)).is_ok()
    })
}

fn is_within(outline: &Outline, at_m: DVec2) -> bool {
    let (low, high) = outline.bounds();
    at_m.cmpgt(low).all() && at_m.cmplt(high).all()
}

fn stood(draft: &mut Draft, members: &[Member], centers: &[DVec2]) -> Result<(), EditError> {
    for (member, at_m) in members.iter().zip(centers) {
        set_placed(draft, member.object, true);
        draft.find_and_rest(member.object, &place_query(member, *at_m))?;
        debug_assert_eq!(draft.supporter(member.object), Supporter::TABLE);
    }
    Ok(())
}

fn sort(draft: &Draft, targets: &mut [usize], key: SortedBy) {
    let objects = draft.editable();
    match key {
        SortedBy::Size => {
            let volume_m3 = |object: &usize| objects[*object].size_m.element_product();
            targets.sort_by(|a, b| volume_m3(a).total_cmp(&volume_m3(b)));
        }
        SortedBy::Height => {
            let height_m = |object: &usize| objects[*object].size_m.z;
            targets.sort_by(|a, b| height_m(a).total_cmp(&height_m(b)));
        }
        SortedBy::Color => targets.sort_by(|a, b| {
            let hue = |object: &usize| objects[*object].color.map_or(f64::INFINITY, hue);
            hue(a).total_cmp(&hue(b))
        }),
        SortedBy::Kind => targets.sort_by(|a, b| objects[*a].category.cmp(&objects[*b].category)),
    }
}

/// The hue in turns, from red over green to blue; grays after all hues, the dark ones first.
fn hue(color: Rgb) -> f64 {
    let [red, green, blue] = color.0.map(f64::from);
    let (high, low) = (red.max(green).max(blue), red.min(green).min(blue));
    let chroma = high - low;
    if chroma < 0.08 {
        return 2.0 + high;
    }
    let sixths = match high {
        _ if high == red => ((green - blue) / chroma).rem_euclid(6.0),
        _ if high == green => (blue - red) / chroma + 2.0,
        _ => (red - green) / chroma + 4.0,
    };
    // Reds on both ends of the circle stand together.
    (sixths / 6.0 + 1.0 / 24.0).fract()
}
