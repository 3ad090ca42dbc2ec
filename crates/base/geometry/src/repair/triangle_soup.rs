//! Operations on unordered triangles: weld, orient consistently, fill holes, thicken.

use std::collections::{BTreeMap, HashMap, VecDeque};

use glam::DVec3;

use crate::shells::{Shell, split};

/// Triangles over shared vertices.
pub(super) struct TriangleSoup {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleSoup {
    pub(super) fn of(shells: &[Shell]) -> Self {
        let mut soup = Self { points: Vec::new(), triangles: Vec::new() };
        for shell in shells {
            let first = soup.points.len() as u32;
            soup.points.extend(&shell.points);
            soup.triangles.extend(shell.triangles.iter().map(|t| t.map(|v| first + v)));
        }
        soup
    }

    /// Moves every vertex onto the first one within `distance_m` and drops degenerate and duplicate triangles.
    /// Returns the number of moved vertices.
    pub(super) fn weld(&mut self, distance_m: f64) -> u32 {
        let cell = |p: DVec3| (p / distance_m.max(1e-9)).floor().as_i64vec3();
        let mut kept: Vec<DVec3> = Vec::new();
        let mut in_cell: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut moved = 0;
        let onto: Vec<u32> = self
            .points
            .iter()
            .map(|&p| {
                let home = cell(p);
                let near = (-1..=1)
                    .flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z])))
                    .filter_map(|step| in_cell.get(&(home + glam::I64Vec3::from_array(step)).to_array()))
                    .flatten()
                    .copied()
                    .filter(|&k| kept[k as usize].distance(p) <= distance_m)
                    .min();
                near.inspect(|&k| moved += u32::from(kept[k as usize] != p)).unwrap_or_else(|| {
                    let next = kept.len() as u32;
                    in_cell.entry(home.to_array()).or_default().push(next);
                    kept.push(p);
                    next
                })
            })
            .collect();
        let mut seen: BTreeMap<[u32; 3], ()> = BTreeMap::new();
        self.triangles = self
            .triangles
            .iter()
            .map(|t| t.map(|v| onto[v as usize]))
            .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            .filter(|t| {
                let mut corners = *t;
                corners.sort_unstable();
                seen.insert(corners, ()).is_none()
            })
            .collect();
        self.points = kept;
        moved
    }

    /// Flips triangles so that neighbors across a shared edge are oriented consistently; the larger part of a connected
    /// surface stays. Returns the number of flipped triangles.
    pub(super) fn turn_alike(&mut self) -> u32 {
        let mut at_edge: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        for (k, t) in self.triangles.iter().enumerate() {
            for [a, b] in edges(*t) {
                at_edge.entry((a.min(b), a.max(b))).or_default().push(k as u32);
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
        let mut count = 0;
        for start in 0..self.triangles.len() {
            if turned[start].is_some() {
                continue;
            }
            turned[start] = Some(false);
            let mut part = vec![start];
            let mut open = VecDeque::from([start]);
            while let Some(here) = open.pop_front() {
                for [a, b] in edges(self.triangles[here]) {
                    let [one, other] = at_edge[&(a.min(b), a.max(b))][..] else { continue };
                    let next = if one as usize == here { other } else { one } as usize;
                    if next == here || turned[next].is_some() {
                        continue;
                    }
                    let same_way = edges(self.triangles[next]).contains(&[a, b]);
                    turned[next] = Some(turned[here] == Some(!same_way));
                    part.push(next);
                    open.push_back(next);
                }
            }
            let over = part.iter().filter(|&&k| turned[k] == Some(true)).count();
            let turn = if 2 * over > part.len() { Some(false) } else { Some(true) };
            for k in part.into_iter().filter(|&k| turned[k] == turn) {
                self.triangles[k].swap(1, 2);
                count += 1;
            }
        }
        count
    }

    pub(super) fn into_shells(self) -> Vec<Shell> {
        split(self.points, self.triangles)
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Boundary edges by their start, in the direction of the missing triangle.
fn open_edges(shell: &Shell) -> BTreeMap<u32, Vec<u32>> {
    let mut balance: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for t in &shell.triangles {
        for [a, b] in edges(*t) {
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let mut open: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ((a, b), count) in balance {
        for _ in 0..count {
            open.entry(b).or_default().push(a);
        }
        for _ in count..0 {
            open.entry(a).or_default().push(b);
        }
    }
    open
}

/// Loops of boundary edges; a fan over their corners closes the surface.
fn holes(shell: &Shell) -> Vec<Vec<u32>> {
    let mut open = open_edges(shell);
    let mut loops = Vec::new();
    while let Some((&start, _)) = open.iter().find(|(_, ends)| !ends.is_empty()) {
        let mut walked = vec![start];
        let mut here = start;
        while let Some(next) = open.get_mut(&here).and_then(Vec::pop) {
            // A repeated corner closes a loop of its own.
            if let Some(at) = walked.iter().position(|&v| v == next) {
                loops.push(walked.split_off(at));
            }
            walked.push(next);
            here = next;
        }
    }
    loops.retain(|l| l.len() > 2);
    loops
}

/// Closes holes whose area is at most `share` of the surface with a fan around their center, or with a triangle if they
/// have three corners. Returns the number of filled holes.
pub(super) fn fill_holes(shell: &mut Shell, share: f64) -> u32 {
    let surface_m2: f64 = shell.corners().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
    let mut filled = 0;
    for hole in holes(shell) {
        let at = |v: u32| shell.points[v as usize];
        let midpoint = hole.iter().map(|&v| at(v)).sum::<DVec3>() / hole.len() as f64;
        let next = |k: usize| hole[(k + 1) % hole.len()];
        let area =
            (0..hole.len()).map(|k| (at(hole[k]) - midpoint).cross(at(next(k)) - midpoint)).sum::<DVec3>();
        if 0.5 * area.length() > share * surface_m2 {
            continue;
        }
        filled += 1;
        if let [a, b, c] = hole[..] {
            shell.triangles.push([a, b, c]);
            continue;
        }
        let center = shell.points.len() as u32;
        shell.points.push(midpoint);
        shell.triangles.extend((0..hole.len()).map(|k| [hole[k], next(k), center]));
    }
    filled
}

/// Adds a second side `thickness_m` behind an open surface, joined along the boundary loops. Returns `false` if the
/// boundary edges form no loops.
pub(super) fn thicken(shell: &mut Shell, thickness_m: f64) -> bool {
    let rims = open_edges(shell);
    if rims.is_empty() {
        return false;
    }
    /// At sharper edges the second side is closer than `thickness_m`.
    const SHARPEST: f64 = 0.3;
    let mut normals = vec![(DVec3::ZERO, 0.0); shell.points.len()];
    for (t, [a, b, c]) in shell.triangles.iter().zip(shell.corners()) {
        let normal = (b - a).cross(c - a);
        for &v in t {
            normals[v as usize].0 += normal;
            normals[v as usize].1 += normal.length();
        }
    }
    // The offset is larger where faces meet at an angle, so that each keeps its thickness.
    let back_m = |(normal, area): &(DVec3, f64)| {
        let cosine = (normal.length() / area.max(f64::MIN_POSITIVE)).max(SHARPEST);
        thickness_m / cosine * normal.normalize_or_zero()
    };
    let count = shell.points.len() as u32;
    let behind: Vec<DVec3> = shell.points.iter().zip(&normals).map(|(&p, n)| p - back_m(n)).collect();
    shell.points.extend(behind);
    let back: Vec<[u32; 3]> =
        shell.triangles.iter().map(|&[a, b, c]| [count + a, count + c, count + b]).collect();
    shell.triangles.extend(back);
    for (a, ends) in rims {
        for b in ends {
            shell.triangles.extend([[a, b, count + b], [a, count + b, count + a]]);
        }
    }
    true
}
