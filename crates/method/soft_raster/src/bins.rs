//! Spatial index: numbered objects binned into the square cells of an image.

use imaging::rounding::floor_within;

/// Side of a cell, pixels.
pub const CELL_PX: f32 = 4.0;

/// Lines this near to a cell are entered in it, pixels.
pub const SLACK_PX: f32 = 0.01;

/// Cells of an image and of a margin around it, each with the ascending numbers of the objects that touch it.
#[derive(Debug, Default)]
pub struct Bins {
    margin_px: f32,
    across: usize,
    down: usize,
    /// Of each cell, where its list begins; one more at the end.
    starts: Vec<u32>,
    entries: Vec<u32>,
    /// (cell, number) as they come, and how many there are; more is room.
    pairs: Vec<(u32, u32)>,
    entered: usize,
}

impl Bins {
    /// The margin is at least `margin_px`, in whole cells.
    pub fn clear(&mut self, width_px: usize, height_px: usize, margin_px: f32) {
        self.margin_px = (margin_px / CELL_PX).ceil() * CELL_PX;
        let cells = |px: usize| ((px as f32 + 2.0 * self.margin_px) / CELL_PX).ceil() as usize;
        (self.across, self.down) = (cells(width_px), cells(height_px));
        self.entered = 0;
    }

    /// Column (or row) of a coordinate, not bounded.
    #[inline]
    fn line(&self, x: f32) -> i32 {
        // Far away is far enough.
        floor_within((x + self.margin_px) / CELL_PX, -1000.0, 1e6)
    }

    /// Cells that a box touches: columns and rows.
    #[inline]
    fn range(&self, low: [f32; 2], high: [f32; 2]) -> Option<([usize; 2], [usize; 2])> {
        let (x0, y0) = (self.line(low[0]).max(0), self.line(low[1]).max(0));
        let x1 = self.line(high[0]).min(self.across as i32 - 1);
        let y1 = self.line(high[1]).min(self.down as i32 - 1);
        (x0 <= x1 && y0 <= y1).then_some(([x0 as usize, x1 as usize], [y0 as usize, y1 as usize]))
    }

    /// Column and row of a position, not bounded.
    #[inline]
    pub fn place_of(&self, p: [f32; 2]) -> [i32; 2] {
        p.map(|c| self.line(c))
    }

    /// Enters a number in all `wanted` cells of the box around those places; returns whether there are any.
    #[inline]
    pub fn add_between(&mut self, number: u32, places: [[i32; 2]; 3], wanted: &[bool]) -> bool {
        let [[ax, ay], [bx, by], [cx, cy]] = places;
        let (x0, x1) = (ax.min(bx).min(cx).max(0), ax.max(bx).max(cx).min(self.across as i32 - 1));
        let (y0, y1) = (ay.min(by).min(cy).max(0), ay.max(by).max(cy).min(self.down as i32 - 1));
        if x0 > x1 {
            return false;
        }
        let (across, before) = ((x1 - x0 + 1) as usize, self.entered);
        let highest = before + across * (y1 - y0 + 1).max(0) as usize;
        if highest > self.pairs.len() {
            self.pairs.resize(2 * highest, (0, 0));
        }
        // Branchless: all candidates are written, each over the previous one until one is wanted.
        let mut entered = before;
        for y in y0..=y1 {
            let first = y as usize * self.across + x0 as usize;
            for (cell, &wanted) in (first as u32..).zip(&wanted[first..first + across]) {
                self.pairs[entered] = (cell, number);
                entered += usize::from(wanted);
            }
        }
        self.entered = entered;
        entered > before
    }

    /// Enters a number in the cells a line passes, and in those it nearly touches.
    pub fn add_line(&mut self, number: u32, a: [f32; 2], b: [f32; 2]) {
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.truncate(self.entered);
        self.each_on_line(a, b, |cell| pairs.push((cell as u32, number)));
        self.entered = pairs.len();
        self.pairs = pairs;
    }

    /// Visits the cells of [`Self::add_line`].
    #[inline]
    pub fn each_on_line(&self, a: [f32; 2], b: [f32; 2], mut each: impl FnMut(usize)) {
        let [low_y, high_y] = [a[1].min(b[1]) - SLACK_PX, a[1].max(b[1]) + SLACK_PX];
        let [low_x, high_x] = [a[0].min(b[0]) - SLACK_PX, a[0].max(b[0]) + SLACK_PX];
        let Some((columns, rows)) = self.range([low_x, low_y], [high_x, high_y]) else { return };
        // Most lines are short: their box has one row or one column, and they pass all of it.
        if columns[0] == columns[1] || rows[0] == rows[1] {
            for y in rows[0]..=rows[1] {
                (columns[0]..=columns[1]).for_each(|x| each(y * self.across + x));
            }
            return;
        }
        for y in rows[0]..=rows[1] {
            // The part of the line within the row of cells.
            let top = y as f32 * CELL_PX - self.margin_px - SLACK_PX;
            let bottom = top + CELL_PX + 2.0 * SLACK_PX;
            let at = |y: f32| a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0);
            let (u, v) = if (b[1] - a[1]).abs() < 1e-6 { (a[0], b[0]) } else { (at(top), at(bottom)) };
            let first = self.line(u.min(v) - SLACK_PX).max(0);
            let last = self.line(u.max(v) + SLACK_PX).min(self.across as i32 - 1);
            (first..=last).for_each(|x| each(y * self.across + x as usize));
        }
    }

    /// Sorts the entries; required before queries.
    pub fn finish(&mut self) {
        let cells = self.across * self.down;
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        let entered = &self.pairs[..self.entered];
        for &(cell, _) in entered {
            self.starts[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            self.starts[cell + 1] += self.starts[cell];
        }
        self.entries.clear();
        self.entries.resize(entered.len(), 0);
        // Numbers come in ascending order, so the lists are ascending too. The starts move while the lists
        // are filled and are moved back after.
        for &(cell, number) in entered {
            let at = &mut self.starts[cell as usize];
            self.entries[*at as usize] = number;
            *at += 1;
        }
        self.starts.copy_within(0..cells, 1);
        self.starts[0] = 0;
    }

    pub fn cells(&self) -> usize {
        self.across * self.down
    }

    /// (cell, number) as they were entered.
    pub fn entered(&self) -> &[(u32, u32)] {
        &self.pairs[..self.entered]
    }

    /// The corner of a cell where x and y are lowest.
    #[inline]
    pub fn corner_of(&self, cell: usize) -> [f32; 2] {
        [cell % self.across, cell / self.across].map(|k| k as f32 * CELL_PX - self.margin_px)
    }

    /// Numbers of the objects that touch a cell.
    #[inline]
    pub fn in_cell(&self, cell: usize) -> &[u32] {
        &self.entries[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The cell of a position; `None` beyond the margin.
    #[inline]
    pub fn cell_of(&self, p: [f32; 2]) -> Option<usize> {
        let ([x, _], [y, _]) = self.range(p, p)?;
        Some(y * self.across + x)
    }
}
