//! Exact quantiles of more numbers than memory holds.
//!
//! Rows of f32 go to a file. At the end the file is read twice for every four dimensions: the first time the upper 16
//! bits of each number are counted, the second time the lower 16 bits of those whose upper bits hold a wanted rank.
//! Bits are arranged so that their order is that of the numbers, hence the selected numbers are those that sorting
//! would give. Memory: at most 11 tables of 65,536 counts for each of four dimensions, 24 MB, for any number of rows.
//! Disk: four bytes a number until the dataset is complete.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::PathBuf;

use crate::EpisodeError;
use crate::statistics::moments::Moments;
use crate::statistics::{FeatureStatistics, QUANTILES, interpolated, of_vectors, ranks};

const DIMENSIONS_A_PASS: usize = 4;
const HALF: usize = 1 << 16;

/// Rows of numbers in a file, and their moments.
pub struct Spool {
    path: PathBuf,
    file: BufWriter<File>,
    moments: Vec<Moments>,
    rows: u64,
}

impl Spool {
    /// An empty spool for rows of `width` numbers, in a new file.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the file.
    pub fn create(path: PathBuf, width: usize) -> Result<Self, EpisodeError> {
        let file = File::create(&path).map_err(|source| EpisodeError::write(&path, source))?;
        Ok(Self { path, file: BufWriter::new(file), moments: vec![Moments::EMPTY; width], rows: 0 })
    }

    /// Adds rows of finite numbers and returns their own statistics.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the file.
    pub fn add(&mut self, rows: &[f32]) -> Result<FeatureStatistics, EpisodeError> {
        let width = self.moments.len();
        for (d, moments) in self.moments.iter_mut().enumerate() {
            let column = rows.iter().skip(d).step_by(width);
            moments.merge(&Moments::of(column.map(|value| f64::from(*value))));
        }
        let bytes: Vec<u8> = rows.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.file.write_all(&bytes).map_err(|source| EpisodeError::write(&self.path, source))?;
        self.rows += (rows.len() / width) as u64;
        Ok(of_vectors(rows, width))
    }

    /// The statistics of all rows, of which there is at least one. Removes the file.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the file.
    pub fn finish(mut self) -> Result<FeatureStatistics, EpisodeError> {
        let failed = |source| EpisodeError::write(&self.path, source);
        self.file.flush().map_err(failed)?;
        let width = self.moments.len();
        let mut dimensions = Vec::with_capacity(width);
        for first in (0..width).step_by(DIMENSIONS_A_PASS) {
            let pass = first..width.min(first + DIMENSIONS_A_PASS);
            let quantiles = self.quantiles(pass.clone()).map_err(failed)?;
            dimensions.extend(pass.zip(quantiles).map(|(d, quantiles)| (self.moments[d], quantiles)));
        }
        std::fs::remove_file(&self.path).map_err(failed)?;
        Ok(FeatureStatistics::of_dimensions(&dimensions))
    }

    fn quantiles(&self, pass: std::ops::Range<usize>) -> std::io::Result<Vec<[f64; 5]>> {
        let mut upper = vec![vec![0_u64; HALF]; pass.len()];
        self.each(&pass, |d, key| upper[d][(key >> 16) as usize] += 1)?;
        let mut wanted: Vec<u64> = QUANTILES.iter().flat_map(|(_, share)| ranks(*share, self.rows)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        // For each dimension and rank: the upper half, and the rank among the numbers with this upper half.
        let places: Vec<Vec<(u32, u64)>> =
            upper.iter().map(|counts| wanted.iter().map(|rank| place(counts, *rank)).collect()).collect();
        // For each dimension: the wanted upper halves in ascending order, and counts of their lower halves.
        let mut lower: Vec<Vec<(u32, Vec<u64>)>> = places
            .iter()
            .map(|places| {
                let mut halves: Vec<u32> = places.iter().map(|(half, _)| *half).collect();
                halves.dedup();
                halves.into_iter().map(|half| (half, vec![0; HALF])).collect()
            })
            .collect();
        self.each(&pass, |d, key| {
            if let Ok(at) = lower[d].binary_search_by_key(&(key >> 16), |(half, _)| *half) {
                lower[d][at].1[(key & 0xFFFF) as usize] += 1;
            }
        })?;
        let number = |d: usize, rank: u64| {
            let (half, inside) = places[d][wanted.binary_search(&rank).unwrap_or_default()];
            let at = lower[d].binary_search_by_key(&half, |(half, _)| *half).unwrap_or_default();
            let (low, _) = place(&lower[d][at].1, inside);
            f64::from(number_of(half << 16 | low))
        };
        let of_dimension =
            |d: usize| QUANTILES.map(|(_, share)| interpolated(share, self.rows, |rank| number(d, rank)));
        Ok((0..pass.len()).map(of_dimension).collect())
    }

    /// Calls `visit` with the place in the pass and the sort key of every number in it.
    fn each(&self, pass: &std::ops::Range<usize>, mut visit: impl FnMut(usize, u32)) -> std::io::Result<()> {
        let mut reader = BufReader::with_capacity(1 << 16, File::open(&self.path)?);
        let mut row = vec![0; 4 * self.moments.len()];
        for _ in 0..self.rows {
            reader.read_exact(&mut row)?;
            for d in pass.clone() {
                let bytes = [row[4 * d], row[4 * d + 1], row[4 * d + 2], row[4 * d + 3]];
                visit(d - pass.start, sort_key(f32::from_le_bytes(bytes)));
            }
        }
        Ok(())
    }
}

/// Position of a rank in a table of counts: the entry, and the rank inside it.
fn place(counts: &[u64], rank: u64) -> (u32, u64) {
    let mut below = 0;
    for (entry, count) in (0_u32..).zip(counts) {
        if rank < below + count {
            return (entry, rank - below);
        }
        below += count;
    }
    (counts.len() as u32 - 1, 0)
}

/// Bits whose order as a whole number is that of the numbers.
fn sort_key(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn number_of(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}
