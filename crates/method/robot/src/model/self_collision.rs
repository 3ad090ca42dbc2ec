//! Pairs of links that must not touch each other.

use crate::model::link::Link;
use crate::model::robot::Robot;

/// Computes the pairs of links, lower index first, that must be checked against each other.
///
/// Left out are links without shapes that collide, links that are fixed to each other, links whose bodies one joint
/// connects, and the pairs that the robot's file names with a reason.
pub fn checked_pairs(robot: &Robot) -> Vec<(usize, usize)> {
    let links = robot.links();
    let collides = |index: usize| links[index].shapes.iter().any(|shape| shape.collides());
    let neighbors = |a: usize, b: usize| {
        let (a, b) = (body(links, a), body(links, b));
        a == b || carrier(links, a) == Some(b) || carrier(links, b) == Some(a)
    };
    let is_ignored = |a: usize, b: usize| robot.ignored_pairs().iter().any(|pair| pair.links == (a, b));
    let pairs = (0..links.len()).flat_map(|a| (a + 1..links.len()).map(move |b| (a, b)));
    pairs.filter(|(a, b)| collides(*a) && collides(*b) && !neighbors(*a, *b) && !is_ignored(*a, *b)).collect()
}

/// The link whose moving joint, or being the base, decides where `index` is.
fn body(links: &[Link], mut index: usize) -> usize {
    while let Some(joint) = links[index].joint.as_ref().filter(|joint| joint.moving().is_none()) {
        index = joint.parent;
    }
    index
}

/// The body that carries a body.
fn carrier(links: &[Link], index: usize) -> Option<usize> {
    links[index].joint.as_ref().map(|joint| body(links, joint.parent))
}
