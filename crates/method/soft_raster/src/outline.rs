//! The outline of a projected surface: the parts of its edges with nothing beyond them.
//!
//! An edge can be outline only if all its triangles lie on the same side of it in the image: a closed surface turns
//! away from the eye there, or an open one ends. Such contour edges are cut where they cross each other. A piece
//! between two cuts is outline throughout or nowhere, and one test just beyond its center decides. Computed in f64
//! from the f32 vertices: a piece of a few thousandths of a pixel wrongly taken for outline hardly changes the
//! coverage, but it may have a very different derivative.
//!
//! Cost: crossings and covered positions are searched within small cells, so in practice it grows with the number of
//! triangles.

use super::bins::{Bins, CELL_PX};
use super::crossing::{MovingLine, cross, minus};
use super::fill::Fill;
use super::inside::{InsideCells, StepLine, WIDENED_PX};
use super::{Grid, MovingPoint, Surface};
use imaging::rounding::{greater, lesser};

/// Distance beyond a piece of the tested position, pixels: above rounding, below visibility. Gaps narrower than this
/// are closed.
const BEYOND_PX: f64 = 1e-6;

/// Lines whose extents are farther apart than twice this do not cross, pixels: far above rounding.
const APART_PX: f32 = 1e-3;

/// The outline's pieces, with working memory.
#[derive(Debug)]
pub struct Outline<const N: usize> {
    pieces: Vec<Piece<N>>,
    contour: Vec<ContourEdge<N>>,
    cuts: Vec<Cut>,
    /// The same cuts in the order of discovery.
    found: Vec<Cut>,
    /// Of each edge where its cuts end.
    cut_ends: Vec<u32>,
    lines: Bins,
    /// Of each contour edge's part in and near the image, a little widened.
    line_extents: Vec<Extent>,
    /// Of those in one cell their part within it.
    parts: Vec<Extent>,
    /// Steps of the contour edges.
    steps: Vec<StepLine>,
    /// Cells that other steps pass.
    doubtful: Vec<usize>,
    inside: InsideCells,
    /// Cells in which triangles are searched.
    open: Vec<bool>,
    /// Cell of each vertex.
    point_cells: Vec<[i32; 2]>,
    triangles: Bins,
    /// Of each triangle that was entered.
    triangle_extents: Vec<Extent>,
}

/// A projected surface with its layer counts.
pub struct LayeredSurface<'a, const N: usize> {
    pub surface: &'a Surface,
    pub points: &'a [MovingPoint<N>],
    /// Of each triangle.
    pub clockwise: &'a [bool],
    /// Layers of the surface, of the same image.
    pub fill: &'a Fill,
}

impl<const N: usize> Default for Outline<N> {
    fn default() -> Self {
        Self {
            pieces: Vec::new(),
            contour: Vec::new(),
            cuts: Vec::new(),
            found: Vec::new(),
            cut_ends: Vec::new(),
            lines: Bins::default(),
            line_extents: Vec::new(),
            parts: Vec::new(),
            steps: Vec::new(),
            doubtful: Vec::new(),
            inside: InsideCells::default(),
            open: Vec::new(),
            point_cells: Vec::new(),
            triangles: Bins::default(),
            triangle_extents: Vec::new(),
        }
    }
}

/// A straight piece of the outline.
#[derive(Clone, Copy, Debug)]
pub struct Piece<const N: usize> {
    pub ends: [MovingPoint<N>; 2],
}

/// An edge with all its triangles to one side.
#[derive(Clone, Copy, Debug)]
struct ContourEdge<const N: usize> {
    vertices: [u32; 2],
    line: MovingLine<N>,
    /// Part of the edge in and near the image, as shares of its length.
    shown: (f64, f64),
    /// Whether the triangles lie to the left of the way from the first end to the second.
    left: bool,
}

/// Intersection of two contour edges.
#[derive(Clone, Copy, Debug, Default)]
struct Cut {
    /// Number of the edge that is cut, and the share of its way.
    edge: u32,
    at: f64,
    other: u32,
    other_at: f64,
}

/// A bounding box, pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Extent {
    low: [f32; 2],
    high: [f32; 2],
}

impl Extent {
    fn around<const K: usize>(points: [[f32; 2]; K]) -> Self {
        let mut around = Self { low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2] };
        for p in points {
            around.low = [lesser(p[0], around.low[0]), lesser(p[1], around.low[1])];
            around.high = [greater(p[0], around.high[0]), greater(p[1], around.high[1])];
        }
        around
    }

    fn widened(self, by: f32) -> Self {
        Self { low: self.low.map(|c| c - by), high: self.high.map(|c| c + by) }
    }

    /// The part within the other; turned about where there is none.
    fn within(&self, other: &Self) -> Self {
        let [x, y] = [0, 1].map(|axis| {
            [greater(self.low[axis], other.low[axis]), lesser(self.high[axis], other.high[axis])]
        });
        Self { low: [x[0], y[0]], high: [x[1], y[1]] }
    }

    /// Whether the two have a point in common.
    #[inline]
    fn meets(&self, other: &Self) -> bool {
        // Without short cuts: which side they are apart on cannot be foreseen.
        (self.low[0] <= other.high[0])
            & (self.low[1] <= other.high[1])
            & (self.high[0] >= other.low[0])
            & (self.high[1] >= other.low[1])
    }
}

impl<const N: usize> Outline<N> {
    pub fn pieces(&self) -> &[Piece<N>] {
        &self.pieces
    }

    /// Finds the pieces within `margin_px` of the image, and perhaps some beyond.
    pub fn trace(&mut self, seen: &LayeredSurface<N>, grid: Grid, margin_px: f32) {
        self.pieces.clear();
        self.find_contour(seen, grid, margin_px);
        self.inside.find(&self.lines, &self.steps, &self.doubtful, seen.fill.layers(), grid);
        self.find_cuts();
        self.find_triangles(seen, grid, margin_px);
        self.keep_visible(seen);
    }

    fn find_contour(&mut self, seen: &LayeredSurface<N>, grid: Grid, margin_px: f32) {
        let (surface, points) = (seen.surface, seen.points);
        self.contour.clear();
        self.steps.clear();
        self.doubtful.clear();
        self.lines.clear(grid.width_px(), grid.height_px, margin_px);
        self.line_extents.clear();
        let margin_px = f64::from(margin_px);
        let low = [-margin_px; 2];
        let high = [grid.width_px() as f64 + margin_px, grid.height_px as f64 + margin_px];
        // An edge with all triangles to one side is a step.
        for step in seen.fill.steps() {
            let edge = &surface.edges[step.edge as usize];
            let line = MovingLine::between(edge.ends.map(|v| &points[v as usize]));
            let Some(shown) = line.clip(low, high) else { continue };
            let [a, b] = [shown.0, shown.1].map(|t| line.at(t).at_px_f32());
            // A triangle that runs clockwise on the screen along the edge lies to its right, which with y
            // down is the positive side.
            let left = |s: &super::surface::Side| seen.clockwise[s.triangle as usize] == s.back;
            let sides = surface.sides(edge);
            if sides[1..].iter().any(|s| left(s) != left(&sides[0])) {
                let doubtful = &mut self.doubtful;
                self.lines.each_on_line(a, b, |cell| doubtful.push(cell));
                continue;
            }
            self.lines.add_line(self.contour.len() as u32, a, b);
            self.line_extents.push(Extent::around([a, b]).widened(APART_PX));
            self.steps.push(StepLine::between(a, b, step.layers));
            self.contour.push(ContourEdge { vertices: edge.ends, line, shown, left: left(&sides[0]) });
        }
        self.lines.finish();
    }

    /// Finds intersections of contour edges, except in cells that are covered.
    fn find_cuts(&mut self) {
        self.found.clear();
        for cell in (0..self.lines.cells()).filter(|&cell| !self.inside.covered()[cell]) {
            let here = self.lines.in_cell(cell);
            if here.len() < 2 {
                continue;
            }
            // Two lines may meet in several cells' lists but cross in one.
            let corner = self.lines.corner_of(cell);
            let square = Extent { low: corner, high: corner.map(|c| c + CELL_PX) }.widened(APART_PX);
            self.parts.clear();
            self.parts.extend(here.iter().map(|&i| self.line_extents[i as usize].within(&square)));
            for (k, (&i, part)) in here.iter().zip(&self.parts).enumerate() {
                let e = &self.contour[i as usize];
                for (&j, other) in here[k + 1..].iter().zip(&self.parts[k + 1..]) {
                    if !part.meets(other) {
                        continue;
                    }
                    let f = &self.contour[j as usize];
                    if e.vertices.iter().any(|v| f.vertices.contains(v)) {
                        continue;
                    }
                    let Some((s, u)) = e.line.crossing(&f.line) else { continue };
                    if self.lines.cell_of(e.line.at(s).at_px_f32()) == Some(cell) {
                        self.found.push(Cut { edge: i, at: s, other: j, other_at: u });
                        self.found.push(Cut { edge: j, at: u, other: i, other_at: s });
                    }
                }
            }
        }
        self.sort_cuts();
    }

    /// By edge, then along it. Edges have few cuts each: sorted into their places first, hardly any is left to sort.
    fn sort_cuts(&mut self) {
        let starts = &mut self.cut_ends;
        starts.clear();
        starts.resize(self.contour.len() + 1, 0);
        self.found.iter().for_each(|cut| starts[cut.edge as usize + 1] += 1);
        (0..self.contour.len()).for_each(|edge| starts[edge + 1] += starts[edge]);
        self.cuts.clear();
        self.cuts.resize(self.found.len(), Cut::default());
        for cut in &self.found {
            // The starts end up as the ends.
            let end = &mut starts[cut.edge as usize];
            let mut at = *end as usize;
            *end += 1;
            while at > 0
                && self.cuts[at - 1].edge == cut.edge
                && self.cuts[at - 1].at.total_cmp(&cut.at).is_gt()
            {
                self.cuts[at] = self.cuts[at - 1];
                at -= 1;
            }
            self.cuts[at] = *cut;
        }
    }

    /// Finds the triangles in cells that contour edges pass and that are not certainly covered.
    fn find_triangles(&mut self, seen: &LayeredSurface<N>, grid: Grid, margin_px: f32) {
        let surface = seen.surface;
        self.open.clear();
        self.open.extend(
            (0..self.lines.cells())
                .map(|cell| !self.inside.covered()[cell] && !self.lines.in_cell(cell).is_empty()),
        );
        self.triangles.clear(grid.width_px(), grid.height_px, margin_px);
        self.triangle_extents.resize(surface.triangles.len(), Extent::default());
        self.point_cells.clear();
        self.point_cells.extend(seen.points.iter().map(|point| self.triangles.place_of(point.at_px)));
        for (index, t) in surface.triangles.iter().enumerate() {
            // A ray meets as many triangles of one orientation of a closed surface as of the other: one orientation
            // suffices.
            if surface.closed && !seen.clockwise[index] {
                continue;
            }
            let places = t.map(|v| self.point_cells[v as usize]);
            if self.triangles.add_between(index as u32, places, &self.open) {
                self.triangle_extents[index] = Extent::around(t.map(|v| seen.points[v as usize].at_px));
            }
        }
        self.triangles.finish();
    }

    /// Keeps the pieces with nothing beyond; pieces that continue each other become one.
    fn keep_visible(&mut self, seen: &LayeredSurface<N>) {
        let mut entered = self.lines.entered();
        let mut first_cut = 0;
        // The edge's parts within cells that are covered, shares of the way.
        let mut hidden: Vec<(f64, f64)> = Vec::new();
        let mut last_found = None;
        for (index, edge) in self.contour.iter().enumerate() {
            let end_cut = self.cut_ends[index] as usize;
            let mine = &self.cuts[first_cut..end_cut];
            first_cut = end_cut;
            let own = entered.iter().take_while(|(_, number)| *number as usize == index).count();
            let (cells, rest) = entered.split_at(own);
            entered = rest;
            let covered = |cell: &usize| self.inside.covered()[*cell];
            let cells = cells.iter().map(|c| c.0 as usize);
            if cells.clone().all(|cell| covered(&cell)) {
                continue;
            }
            hidden.clear();
            hidden.extend(cells.filter(covered).filter_map(|cell| self.part_within(cell, edge)));
            let [dx, dy] = edge.line.direction();
            let outward =
                if edge.left { 1.0 } else { -1.0 } * BEYOND_PX / (dx * dx + dy * dy).sqrt().max(1e-30);
            let beyond = [-dy * outward, dx * outward];
            // Ends of the piece in the making: `None` = the edge's own.
            let (mut start, mut from): (Option<&Cut>, f64) = (None, edge.shown.0);
            let mut begun = false;
            let mut before: Option<&Cut> = None;
            for end in mine.iter().map(Some).chain([None]) {
                let to = end.map_or(edge.shown.1, |c| c.at.clamp(from, edge.shown.1));
                // Cuts in covered cells are unknown, but a piece that ends there has a surface beyond.
                let open = !hidden.iter().any(|part| part.0 < to && from < part.1) && {
                    let [x, y] = edge.line.at(0.5 * (from + to)).at_px;
                    !self.covered([x + beyond[0], y + beyond[1]], seen, &mut last_found)
                };
                if open && !begun {
                    (begun, start) = (true, before);
                }
                if begun && !open {
                    self.pieces.push(self.piece(edge, start, before));
                    begun = false;
                }
                (before, from) = (end, to);
            }
            if begun {
                self.pieces.push(self.piece(edge, start, None));
            }
        }
    }

    fn part_within(&self, cell: usize, edge: &ContourEdge<N>) -> Option<(f64, f64)> {
        let corner = self.lines.corner_of(cell).map(f64::from);
        let widened = f64::from(WIDENED_PX);
        edge.line.clip(corner.map(|c| c - widened), corner.map(|c| c + f64::from(CELL_PX) + widened))
    }

    fn piece(&self, edge: &ContourEdge<N>, start: Option<&Cut>, end: Option<&Cut>) -> Piece<N> {
        let cut = |c: &Cut| {
            let other = &self.contour[c.other as usize];
            edge.line.crossing_point(c.at, &other.line, c.other_at)
        };
        let first = start.map_or_else(|| edge.line.at(edge.shown.0), cut);
        let last = end.map_or_else(|| edge.line.at(edge.shown.1), cut);
        Piece { ends: [first, last].map(|end| end.rounded()) }
    }

    /// Whether any triangle covers the position. Positions beyond the margin count as covered, since they do not
    /// matter. Positions come along edges: the triangle that covered the last one often covers the next.
    fn covered(&self, p: [f64; 2], seen: &LayeredSurface<N>, last_found: &mut Option<u32>) -> bool {
        // Rounding is monotone, so a point within a triangle's extent stays within.
        let rounded = p.map(|c| c as f32);
        let Some(cell) = self.triangles.cell_of(rounded) else { return true };
        if self.inside.covered()[cell] {
            return true;
        }
        let here = Extent { low: rounded, high: rounded };
        let covers = |t: u32| {
            if !self.triangle_extents[t as usize].meets(&here) {
                return false;
            }
            let corner = |v: u32| minus(seen.points[v as usize].at_px.map(f64::from), p);
            let [a, b, c] = seen.surface.triangles[t as usize].map(corner);
            // Without short cuts, as in `meets`.
            let [s, t, u] = [cross(a, b), cross(b, c), cross(c, a)];
            ((s >= 0.0) & (t >= 0.0) & (u >= 0.0)) | ((s <= 0.0) & (t <= 0.0) & (u <= 0.0))
        };
        if last_found.is_some_and(covers) {
            return true;
        }
        *last_found = self.triangles.in_cell(cell).iter().copied().find(|&t| covers(t));
        last_found.is_some()
    }
}
