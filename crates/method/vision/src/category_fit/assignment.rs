//! Maximum-benefit assignment of rows to columns, at most one each; a pair without a positive benefit is left out.
//!
//! Kuhn, "The Hungarian method for the assignment problem", 1955, with potentials and shortest augmenting paths
//! (Jonker and Volgenant, 1987). Every row has a column of its own with benefit 0, so that it may stay unassigned.
//! Deterministic. Cost: O(r^2 (r + c)).

/// The assignment of maximum total benefit: the column of each row, and the total. `benefits[row][column]` is minus
/// infinity for a pair that is impossible.
pub(super) fn maximize(benefits: &[Vec<f64>], columns: usize) -> (Vec<Option<usize>>, f64) {
    let rows = benefits.len();
    let all = columns + rows;
    // A pair without benefit costs more than to leave both out.
    let cost = |row: usize, column: usize| match column.checked_sub(columns) {
        Some(own) if own == row => 0.0,
        Some(_) => 1.0,
        None => {
            let benefit = benefits[row][column];
            if benefit > 0.0 { -benefit } else { 1.0 }
        }
    };
    // Index 0 stands for "none"; rows and columns count from 1.
    let (mut row_potential, mut column_potential) = (vec![0.0; rows + 1], vec![0.0; all + 1]);
    let mut row_of = vec![0_usize; all + 1];
    for row in 1..=rows {
        let (mut shortest, mut reached_from) = (vec![f64::INFINITY; all + 1], vec![0_usize; all + 1]);
        let mut is_done = vec![false; all + 1];
        row_of[0] = row;
        let mut at = 0;
        while row_of[at] != 0 {
            is_done[at] = true;
            let (from, mut step, mut next) = (row_of[at], f64::INFINITY, 0);
            for column in (1..=all).filter(|column| !is_done[*column]) {
                let reduced = cost(from - 1, column - 1) - row_potential[from] - column_potential[column];
                if reduced < shortest[column] {
                    (shortest[column], reached_from[column]) = (reduced, at);
                }
                if shortest[column] < step {
                    (step, next) = (shortest[column], column);
                }
            }
            for column in 0..=all {
                if is_done[column] {
                    row_potential[row_of[column]] += step;
                    column_potential[column] -= step;
                } else {
                    shortest[column] -= step;
                }
            }
            at = next;
        }
        while at != 0 {
            let from = reached_from[at];
            row_of[at] = row_of[from];
            at = from;
        }
    }
    let mut assigned = vec![None; rows];
    for (column, row) in row_of.iter().skip(1).take(columns).enumerate() {
        if let Some(row) = row.checked_sub(1) {
            assigned[row] = Some(column).filter(|column| benefits[row][*column] > 0.0);
        }
    }
    let total =
        assigned.iter().enumerate().filter_map(|(row, column)| column.map(|column| benefits[row][column]));
    let total = total.sum();
    (assigned, total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_seed;

    /// The best total by trying every assignment.
    fn slow_total(benefits: &[Vec<f64>], columns: usize, row: usize, taken: u32) -> f64 {
        if row == benefits.len() {
            return 0.0;
        }
        let free = (0..columns).filter(|column| taken & (1 << column) == 0);
        let with = free.map(|column| {
            benefits[row][column] + slow_total(benefits, columns, row + 1, taken | (1 << column))
        });
        with.fold(slow_total(benefits, columns, row + 1, taken), f64::max)
    }

    #[test]
    fn small_assignments_are_known() {
        let no = f64::NEG_INFINITY;
        for (benefits, columns, expected, total) in [
            (vec![], 2, vec![], 0.0),
            (vec![vec![], vec![]], 0, vec![None, None], 0.0),
            (vec![vec![2.0, 3.0], vec![1.0, 2.9]], 2, vec![Some(0), Some(1)], 4.9),
            // Both want the only column; the better one gets it.
            (vec![vec![1.0], vec![1.5]], 1, vec![None, Some(0)], 1.5),
            (vec![vec![-1.0, no], vec![0.0, no]], 2, vec![None, None], 0.0),
            // The first row gives way, because the second has no other column.
            (vec![vec![5.0, 4.5], vec![4.0, no]], 2, vec![Some(1), Some(0)], 8.5),
        ] {
            let (assigned, found) = maximize(&benefits, columns);
            assert_eq!(assigned, expected, "{benefits:?}");
            assert!((found - total).abs() < 1e-12, "{benefits:?}: {found}");
        }
    }

    #[test]
    fn totals_equal_those_of_the_slow_reference() {
        for case in 0..300 {
            let drawn = |name: &str, below: u64| child_seed(case, name) % below;
            let (rows, columns) = (drawn("rows", 6), drawn("columns", 6) as usize);
            let benefit = |row: u64, column: usize| match drawn(&format!("{row} {column}"), 500) {
                0..100 => f64::NEG_INFINITY,
                other => 0.02 * (other - 100) as f64 - 3.0,
            };
            let of_row = |row: u64| (0..columns).map(|column| benefit(row, column)).collect();
            let benefits: Vec<Vec<f64>> = (0..rows).map(of_row).collect();
            let (assigned, total) = maximize(&benefits, columns);
            let mut used: Vec<usize> = assigned.iter().flatten().copied().collect();
            used.sort_unstable();
            let count = used.len();
            used.dedup();
            assert_eq!(used.len(), count, "case {case}: a column is used twice");
            let slow = slow_total(&benefits, columns, 0, 0);
            assert!((total - slow).abs() < 1e-9, "case {case}: {total} for {slow}");
        }
    }
}
