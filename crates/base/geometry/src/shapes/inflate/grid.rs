//! A grid over an outline: boundary squares, and the solution of Poisson's equation inside.

use std::collections::BTreeMap;

use glam::DVec2;

/// Maximum number of squares along the longer side.
const LONGEST: f64 = 120.0;
/// Minimum distance of nodes from the outline, squares; closer nodes give slivers.
const CLEARANCE: f64 = 0.1;
/// Over-relaxation factor, and iterations: per square root of the number of squares, plus a constant.
const RELAXATION: f64 = 1.6;
const ROUNDS: [f64; 2] = [6.0, 30.0];

/// Nodes of a square grid with their depth inside an outline.
pub(super) struct Grid {
    origin: DVec2,
    side: f64,
    columns: usize,
    rows: usize,
    /// Signed distance to the outline, squares; positive inside.
    depth: Vec<f64>,
    /// Whether the outline continues below the lowest row as it does above.
    is_mirrored: bool,
}

/// One of the two sheets of an inflated outline.
pub(super) struct Sheet {
    pub places: Vec<DVec2>,
    pub half: Vec<f64>,
    pub triangles: Vec<[u32; 3]>,
    pub foot: Vec<[u32; 2]>,
}

impl Grid {
    /// About `squares` squares inside the outline. With a `cut`, the lowest row of nodes is at that height, and edges
    /// of the outline along it are ignored. Only the largest connected component is kept. `None` if no node is
    /// inside.
    pub fn new(outline: &[DVec2], cut: Option<f64>, squares: u32) -> Option<Self> {
        let (low, high) = outline
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let extent = high - low;
        let area = 0.5
            * (0..outline.len())
                .map(|k| outline[k].perp_dot(outline[(k + 1) % outline.len()]))
                .sum::<f64>()
                .abs();
        if outline.len() < 3 || !extent.is_finite() || area <= 1e-6 * extent.element_product() {
            return None;
        }
        let side = (area / f64::from(squares.max(16))).sqrt().max(extent.max_element() / LONGEST);
        let origin = DVec2::new(low.x - 0.5 * side, cut.unwrap_or(low.y - 0.5 * side));
        let count = |length: f64| (length / side).ceil() as usize + 2;
        let (columns, rows) = (count(high.x - origin.x), count(high.y - origin.y));
        let is_side = |a: DVec2, b: DVec2| cut.is_none_or(|cut| a.y > cut || b.y > cut);
        let depth = (0..columns * rows)
            .map(|k| {
                let p = origin + side * DVec2::new((k % columns) as f64, (k / columns) as f64);
                // Just above the cut, so that nodes of its row count as inside.
                let lifted = p + DVec2::new(0.0, 1e-6 * side);
                let (mut nearest, mut inside) = (f64::INFINITY, false);
                for (k, &b) in outline.iter().enumerate() {
                    let a = outline[(k + outline.len() - 1) % outline.len()];
                    if is_side(a, b) {
                        let along = b - a;
                        let t = ((p - a).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
                        nearest = nearest.min((p - (a + t * along)).length_squared());
                    }
                    inside ^= (a.y > lifted.y) != (b.y > lifted.y)
                        && lifted.x < a.x + (b.x - a.x) * (lifted.y - a.y) / (b.y - a.y);
                }
                let distance = (nearest.sqrt() / side).max(CLEARANCE);
                if inside { distance } else { -distance }
            })
            .collect();
        let mut grid = Self { origin, side, columns, rows, depth, is_mirrored: cut.is_some() };
        grid.keep_largest_part();
        grid.depth.iter().any(|depth| *depth > 0.0).then_some(grid)
    }

    fn keep_largest_part(&mut self) {
        let mut part = vec![0_usize; self.depth.len()];
        let mut sizes = vec![0_usize];
        for start in 0..self.depth.len() {
            if self.depth[start] <= 0.0 || part[start] != 0 {
                continue;
            }
            let name = sizes.len();
            sizes.push(0);
            part[start] = name;
            let mut open = vec![start];
            while let Some(at) = open.pop() {
                sizes[name] += 1;
                for next in self.neighbors(at).into_iter().flatten() {
                    if self.depth[next] > 0.0 && part[next] == 0 {
                        part[next] = name;
                        open.push(next);
                    }
                }
            }
        }
        let largest = (1..sizes.len()).max_by_key(|name| (sizes[*name], usize::MAX - name)).unwrap_or(0);
        let others =
            self.depth.iter_mut().zip(&part).filter(|(depth, part)| **depth > 0.0 && **part != largest);
        others.for_each(|(depth, _)| *depth = -CLEARANCE);
    }

    /// Left, right, below, above.
    fn neighbors(&self, at: usize) -> [Option<usize>; 4] {
        let (x, y) = (at % self.columns, at / self.columns);
        [
            (x > 0).then(|| at.wrapping_sub(1)),
            (x + 1 < self.columns).then_some(at + 1),
            (y > 0).then(|| at.wrapping_sub(self.columns)),
            (y + 1 < self.rows).then_some(at + self.columns),
        ]
    }

    /// Distance from an inside node to the outline toward an outside one, squares.
    fn to_rim(&self, inside: usize, outside: usize) -> f64 {
        let (d, e) = (self.depth[inside], -self.depth[outside]);
        (d / (d + e)).clamp(0.5 * CLEARANCE, 1.0 - 0.5 * CLEARANCE)
    }

    /// The solution of laplacian f = -2 that vanishes on the outline, squares squared.
    fn solved(&self) -> Vec<f64> {
        let mut f = vec![0.0; self.depth.len()];
        // For each inside node: its index, and for each neighbor its index, if inside, and its weight.
        let mut nodes: Vec<(usize, [Option<usize>; 4], [f64; 4])> = Vec::new();
        for at in (0..self.depth.len()).filter(|at| self.depth[*at] > 0.0) {
            let mut who = self.neighbors(at);
            if self.is_mirrored && who[2].is_none() {
                who[2] = who[3];
            }
            let far = who.map(|next| match next {
                Some(next) if self.depth[next] > 0.0 => 1.0,
                Some(next) => self.to_rim(at, next),
                None => 1.0,
            });
            let weight = [0, 1, 2, 3].map(|k| 2.0 / (far[k] * (far[k] + far[k ^ 1])));
            nodes.push((at, who.map(|next| next.filter(|next| self.depth[*next] > 0.0)), weight));
        }
        let rounds = (ROUNDS[0] * (nodes.len() as f64).sqrt() + ROUNDS[1]) as usize;
        for _ in 0..rounds {
            for (at, who, weight) in &nodes {
                let inflow: f64 =
                    who.iter().zip(weight).filter_map(|(next, weight)| Some(weight * f[(*next)?])).sum();
                let balanced = (2.0 + inflow) / weight.iter().sum::<f64>();
                f[*at] = (f[*at] + RELAXATION * (balanced - f[*at])).max(0.0);
            }
        }
        f
    }

    /// The sheet: inside nodes, and intersections of the outline with the grid's edges.
    pub fn sheet(&self) -> Sheet {
        let f = self.solved();
        let mut sheet =
            Sheet { places: Vec::new(), half: Vec::new(), triangles: Vec::new(), foot: Vec::new() };
        let at = |node: usize| {
            self.origin + self.side * DVec2::new((node % self.columns) as f64, (node / self.columns) as f64)
        };
        let mut node_of = vec![u32::MAX; self.depth.len()];
        for node in (0..self.depth.len()).filter(|node| self.depth[*node] > 0.0) {
            node_of[node] = sheet.places.len() as u32;
            sheet.places.push(at(node));
            sheet.half.push(self.side * f[node].sqrt().max(0.05 * CLEARANCE));
        }
        let mut cuts: BTreeMap<[usize; 2], u32> = BTreeMap::new();
        for y in 0..self.rows - 1 {
            for x in 0..self.columns - 1 {
                let low = y * self.columns + x;
                let corners = [low, low + 1, low + 1 + self.columns, low + self.columns];
                let inside = corners.map(|node| self.depth[node] > 0.0);
                let mut cut = |k: usize| {
                    let (a, b) = (corners[k % 4], corners[(k + 1) % 4]);
                    *cuts.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                        let (from, to) = if self.depth[a] > 0.0 { (a, b) } else { (b, a) };
                        sheet.places.push(at(from) + self.to_rim(from, to) * (at(to) - at(from)));
                        sheet.half.push(0.0);
                        sheet.places.len() as u32 - 1
                    })
                };
                let mut ring: Vec<u32> = Vec::with_capacity(6);
                if inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1] {
                    // Two corners that do not touch.
                    for k in (0..4).filter(|k| inside[*k]) {
                        let tip = [node_of[corners[k]], cut(k), cut(k + 3)];
                        sheet.triangles.push(tip);
                    }
                } else {
                    for k in 0..4 {
                        if inside[k] {
                            ring.push(node_of[corners[k]]);
                        }
                        if inside[k] != inside[(k + 1) % 4] {
                            ring.push(cut(k));
                        }
                    }
                }
                // A fan about a node, so that no triangle lies on the rim with all its corners.
                let node = ring.iter().position(|v| sheet.half[*v as usize] > 0.0).unwrap_or(0);
                ring.rotate_left(node);
                sheet
                    .triangles
                    .extend((1..ring.len().saturating_sub(1)).map(|k| [ring[0], ring[k], ring[k + 1]]));
                if y == 0 && self.is_mirrored && (inside[0] || inside[1]) {
                    let [left, right] = [0, 1].map(|k| node_of[corners[k]]);
                    let cut = cuts.get(&[corners[0], corners[1]]).copied();
                    sheet.foot.push(match cut {
                        Some(cut) if inside[0] => [left, cut],
                        Some(cut) => [cut, right],
                        None => [left, right],
                    });
                }
            }
        }
        sheet
    }
}
