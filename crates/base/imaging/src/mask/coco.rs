//! A second, independent encoder of COCO's compressed run lengths, for mock servers: tests of
//! [`RunLengths::from_compressed`](super::RunLengths::from_compressed) then do not depend on its own inverse.

use crate::Mask;

/// Compressed run lengths of the mask, as COCO's format describes them: columns, alternating runs, differences,
/// groups of five bits.
pub fn compressed(mask: &Mask) -> String {
    let (mut runs, mut inside) = (vec![0_i64], false);
    for x in 0..mask.width_px() {
        for y in 0..mask.height_px() {
            if mask.contains(x, y) != inside {
                inside = !inside;
                runs.push(0);
            }
            if let Some(run) = runs.last_mut() {
                *run += 1;
            }
        }
    }
    let mut text = String::new();
    for (index, run) in runs.iter().enumerate() {
        let mut rest = if index > 2 { run - runs[index - 2] } else { *run };
        loop {
            let group = (rest & 31) as u8;
            rest >>= 5;
            let done = (rest == 0 && group & 16 == 0) || (rest == -1 && group & 16 != 0);
            text.push(char::from(group + if done { 48 } else { 80 }));
            if done {
                break;
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compressed_matches_the_documented_example() {
        // The example of docs/segmentation-sidecar.yaml: the center two by two pixels of four by four.
        let mask = Mask::from_fn(4, 4, |x, y| (1..3).contains(&x) && (1..3).contains(&y));
        assert_eq!(compressed(&mask), "52203");
    }
}
