//! Relations between objects from the links of the text, restricted to physically possible supports.

use glam::DVec3;

use super::draft::{Draft, DraftRelation};
use super::grammar::{Link, LinkKind, ParsedText};
use super::measured_size;
use RelationKind::{AtBackLeft, AtBackRight, AtFrontLeft, AtFrontRight, In, LeftOf, NextTo, On, RightOf};
use catalog::{Affordance, Category};
use scene::RelationKind;
use scene::description::RequestedPose;
use scene::predicates::direction_of;

/// Flat objects that support others even if the text only says "with".
const CARRIERS: &[&str] = &["plate", "saucer", "tray", "cutting_board", "coaster"];
const CUTLERY: &[&str] = &["fork", "knife", "spoon", "chopsticks"];

/// Adds the relations stated by the text to every object.
pub(super) fn relate(draft: &mut Draft, parsed: &ParsedText) {
    // Supports come first, because other relations depend on them ("to the left of the mug").
    for pass in 0..2 {
        for link in &parsed.links {
            let link = &underlaid(draft, link);
            let (from, to) = (draft.of_mention[link.from].clone(), draft.of_mention[link.to].clone());
            if from.is_empty() || to.is_empty() {
                continue;
            }
            let kind = kind_of(draft, parsed, link, from[0], to[0]);
            if kind.is_support() != (pass == 0) {
                continue;
            }
            // The members of a stack share the position of its bottom object.
            let stacked = parsed.mentions[link.from].stacked;
            let on_pile = parsed.mentions[link.to].stacked;
            let each = parsed.mentions[link.from].each_of == Some(link.to);
            for (k, &object) in from.iter().enumerate() {
                if stacked && k > 0 {
                    break;
                }
                let target = if on_pile && kind.is_support() {
                    to[to.len() - 1]
                } else if on_pile {
                    to[0]
                } else if each {
                    to[(k / (from.len() / to.len()).max(1)).min(to.len() - 1)]
                } else {
                    to[k % to.len()]
                };
                let kind = match link.kind {
                    LinkKind::Flank => {
                        if k % 2 == 0 {
                            LeftOf
                        } else {
                            RightOf
                        }
                    }
                    _ => kind,
                };
                let second = link.second.and_then(|second| {
                    let others = &draft.of_mention[second];
                    others.iter().copied().find(|&other| other != target && other != object)
                });
                let kind = if kind == RelationKind::Between && second.is_none() { NextTo } else { kind };
                // "place settings for two: plate, fork left": the side is that of the person.
                let at_setting = each && parsed.people.is_some() && draft.category(target).name == "plate";
                let relation = DraftRelation {
                    second,
                    distance_m: link.distance_m,
                    seated: at_setting && direction_of(kind).is_some(),
                    ..DraftRelation::new(kind, Some(target))
                };
                draft.relate_as(object, relation);
            }
        }
    }
    for (m, mention) in parsed.mentions.iter().enumerate() {
        for &object in &draft.of_mention[m].clone() {
            if mention.corners {
                let corners = [AtBackLeft, AtBackRight, AtFrontLeft, AtFrontRight];
                let position = draft.of_mention[m].iter().position(|&other| other == object).unwrap_or(0);
                draft.relate(object, corners[position % corners.len()], None);
            }
            for place in &mention.places {
                let relation = DraftRelation::new(place.kind, None);
                draft.relate_as(object, DraftRelation { distance_m: place.distance_m, ..relation });
            }
        }
    }
}

/// "every cup has its own saucer": the cup is on the saucer.
fn underlaid(draft: &Draft, link: &Link) -> Link {
    let category = |mention: usize| draft.of_mention[mention].first().map(|&object| draft.category(object));
    match (category(link.from), category(link.to)) {
        (Some(item), Some(host))
            if link.kind == LinkKind::With
                && ["saucer", "coaster"].contains(&item.name.as_str())
                && host.group == "vessel" =>
        {
            Link { from: link.to, to: link.from, kind: LinkKind::Relation(On), ..*link }
        }
        _ => *link,
    }
}

/// The relation that a link expresses between these categories.
fn kind_of(draft: &Draft, parsed: &ParsedText, link: &Link, from: usize, to: usize) -> RelationKind {
    let (item, host) = (draft.category(from), draft.category(to));
    match link.kind {
        LinkKind::Relation(kind) => kind,
        LinkKind::Flank => NextTo,
        LinkKind::At => at(item, host),
        LinkKind::WithAtSide(side) => {
            match kind_of(draft, parsed, &Link { kind: LinkKind::With, ..*link }, from, to) {
                NextTo => side,
                kind => kind,
            }
        }
        LinkKind::With => {
            let contents = parsed.mentions[link.from].contents;
            let carrier = CARRIERS.contains(&host.name.as_str());
            let cutlery = CUTLERY.contains(&item.name.as_str());
            // A stated size decides what fits.
            let measures = &draft.objects[to].attributes.measures;
            let host_m = if measures.is_empty() {
                host.size.typical_m()
            } else {
                measured_size::apply(measures, host.size.typical_m())
            };
            let fits = fits_in(item.size.typical_m(), host_m, capacity_m3(host, host_m));
            // Food goes on a plate, a glass beside it, a cup on a saucer, every object on a tray.
            let dishes = ["cutlery", "vessel", "dish"].contains(&item.group.as_str());
            let served = match host.name.as_str() {
                "plate" => !dishes,
                "saucer" | "coaster" => item.group == "vessel",
                _ => !cutlery || host.name == "tray" || host.name == "cutting_board",
            };
            let small = item.size.typical_m().truncate().max_element()
                < 0.8 * host.size.typical_m().truncate().max_element();
            if host.affords(Affordance::Container)
                && !carrier
                && fits
                && !(cutlery && !contents && host.name != "mug")
            {
                In
            } else if (carrier && (contents || (small && served)))
                || (contents && host.affords(Affordance::Support))
            {
                On
            } else {
                NextTo
            }
        }
    }
}

/// In a container that holds the item, otherwise on what carries it, otherwise beside it.
pub(super) fn at(item: &Category, host: &Category) -> RelationKind {
    if covers(item) {
        On
    } else if holds(item, host) {
        In
    } else if host.affords(Affordance::Support) || is_carrier(host) || host.affords(Affordance::Container) {
        On
    } else {
        NextTo
    }
}

/// Whether the host has an inside with room for the item.
fn holds(item: &Category, host: &Category) -> bool {
    let (item_m, host_m) = (item.size.typical_m(), host.size.typical_m());
    let is_open_container = host.affords(Affordance::Container) && !is_carrier(host);
    (encloses(host) && is_smaller(item_m, host_m))
        || (is_open_container && fits_in(item_m, host_m, capacity_m3(host, host_m)))
}

/// Whether the category has an inside that its mesh does not open.
fn encloses(category: &Category) -> bool {
    const ENCLOSURES: &[&str] = &[
        "cabinet",
        "microwave",
        "toaster_oven",
        "toolbox",
        "storage_case",
        "rice_cooker",
        "pressure_cooker",
        "slow_cooker",
        "dutch_oven",
    ];
    ENCLOSURES.contains(&category.name.as_str())
}

fn is_smaller(item_m: DVec3, host_m: DVec3) -> bool {
    item_m.min_element() < host_m.min_element() && item_m.max_element() < host_m.max_element()
}

/// Whether the category closes a vessel from above.
fn covers(category: &Category) -> bool {
    category.name == "lid"
}

/// Whether the category is a flat object that supports others.
pub(super) fn is_carrier(category: &Category) -> bool {
    CARRIERS.contains(&category.name.as_str())
}

/// Whether an item fits in or on a host.
pub(super) fn fits(item: &Category, host: &Category, kind: RelationKind) -> bool {
    let (item_m, host_m) = (item.size.typical_m(), host.size.typical_m());
    match kind {
        In => host.affords(Affordance::Container) && fits_in(item_m, host_m, capacity_m3(host, host_m)),
        _ => {
            (is_carrier(host) || host.affords(Affordance::Support) || host.affords(Affordance::Container))
                && item_m.truncate().max_element() < 0.8 * host_m.truncate().max_element()
        }
    }
}

/// Capacity of a container of this size, cubic meters, where the catalog knows it for the typical size.
fn capacity_m3(vessel: &Category, vessel_m: DVec3) -> Option<f64> {
    let scale = vessel_m.element_product() / vessel.size.typical_m().element_product();
    vessel.container_volume_m3.map(|volume_m3| scale * volume_m3)
}

/// Whether the narrower side of an object fits through the opening of a vessel of this size.
fn fits_in(item_m: DVec3, vessel_m: DVec3, capacity_m3: Option<f64>) -> bool {
    let opening = 0.85 * vessel_m.x.min(vessel_m.y);
    // A banana lies across a shallow bowl.
    let shallow = vessel_m.z < 0.7 * vessel_m.x.min(vessel_m.y);
    if shallow
        && item_m.x.max(item_m.y) < 1.3 * vessel_m.x.max(vessel_m.y)
        && item_m.x.min(item_m.y) < opening
    {
        return true;
    }
    // A folded towel lies along an oblong basket. A mug is oblong only because of its handle.
    let (item_long, item_short) = (item_m.x.max(item_m.y), item_m.x.min(item_m.y));
    let (long, short) = (vessel_m.x.max(vessel_m.y), vessel_m.x.min(vessel_m.y));
    let has_room = capacity_m3.is_none_or(|limit_m3| item_m.element_product() < limit_m3);
    if has_room && long > 1.1 * short && item_long < 0.85 * long && item_short < 0.85 * short {
        return true;
    }
    let mut extents = item_m.to_array();
    extents.sort_by(f64::total_cmp);
    // Slender objects lean, so their second extent decides.
    let slender = extents[2] > 2.5 * extents[1];
    let through = if slender { extents[1] } else { item_m.x.max(item_m.y) };
    through < opening
}

/// Replaces impossible supports ("a laptop on a mouse", the ninth apple of a small bowl) by `NextTo`. Returns the
/// objects that lost their support, and those inside of something whose mesh is closed.
pub(super) fn keep_what_fits(draft: &mut Draft) -> Vec<usize> {
    let mut replaced = Vec::new();
    let mut filled: Vec<f64> = vec![0.0; draft.objects.len()];
    for object in 0..draft.objects.len() {
        let Some((slot, kind, to)) =
            draft.objects[object].relations.iter().enumerate().find_map(|(slot, relation)| {
                match relation.to {
                    Some(to) if matches!(relation.kind, In | On) => Some((slot, relation.kind, to)),
                    _ => None,
                }
            })
        else {
            continue;
        };
        let host = draft.category(to);
        let (item_m, host_m) = (draft.objects[object].size_m, draft.objects[to].size_m);
        let capacity_m3 = capacity_m3(host, host_m);
        // An overturned container carries objects on its bottom.
        let is_overturned =
            draft.objects[to].pose == RequestedPose::UpsideDown && host.affords(Affordance::Container);
        let container = host.affords(Affordance::Container) && !is_overturned;
        let carries =
            host.affords(Affordance::Support) || is_overturned || CARRIERS.contains(&host.name.as_str());
        let narrow = |size: DVec3| size.x.min(size.y);
        let kind = match kind {
            On if container && covers(draft.category(object)) => On,
            In if container && fits_in(item_m, host_m, capacity_m3) => In,
            In if encloses(host) && is_smaller(item_m, host_m) => {
                replaced.push(object);
                continue;
            }
            On if container && !carries && fits_in(item_m, host_m, capacity_m3) => In,
            In | On if carries && narrow(item_m) < 2.2 * narrow(host_m) => On,
            _ => NextTo,
        };
        let kind = if kind == In {
            // A slender object takes the space of its cross-section; contents may form two layers.
            let mut extents = item_m.to_array();
            extents.sort_by(f64::total_cmp);
            let room = (0.85 * narrow(host_m)).powi(2);
            let need =
                if extents[2] > 2.5 * extents[1] { 2.0 * extents[1].powi(2) } else { extents[1].powi(2) };
            // Flat contents lie on each other.
            let need = if extents[0] < 0.35 * extents[1] { 0.5 * need } else { need };
            filled[to] += need;
            // The first object always fits.
            if filled[to] > 1.7 * room && filled[to] > need { NextTo } else { In }
        } else if kind == On {
            let room = host_m.x * host_m.y;
            let need = item_m.x * item_m.y;
            filled[to] += need;
            if filled[to] > 0.9 * room && filled[to] > need { NextTo } else { On }
        } else {
            kind
        };
        if kind == NextTo {
            replaced.push(object);
        }
        draft.objects[object].relations[slot].kind = kind;
    }
    replaced
}
