//! The units of an H.264 byte stream (ITU-T H.264, annex B), and how MP4 stores them (ISO/IEC 14496-15).
//!
//! In a byte stream, start codes precede the units. In MP4, a length of four bytes does, and the parameter sets stand
//! once in the file's header.

const SEQUENCE_PARAMETER_SET: u8 = 7;
/// Unit type of the parameters that the slices of a frame share.
const PER_IMAGE_PARAMETER_SET: u8 = 8;

/// The settings that a decoder needs before the first frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterSets {
    sequence: Vec<u8>,
    per_image: Vec<u8>,
}

impl ParameterSets {
    /// The parameter sets at the start of a key frame; `None` where it has none, or has several.
    pub fn of(key_frame: &[u8]) -> Option<Self> {
        let of_kind = |kind: u8| {
            let mut found = units(key_frame).into_iter().filter(|unit| kind_of(unit) == kind);
            found.next().filter(|_| found.next().is_none()).map(<[u8]>::to_vec)
        };
        let sequence = of_kind(SEQUENCE_PARAMETER_SET).filter(|set| set.len() >= 4)?;
        Some(Self { sequence, per_image: of_kind(PER_IMAGE_PARAMETER_SET)? })
    }

    /// The AVCDecoderConfigurationRecord for lengths of four bytes.
    pub fn configuration_record(&self) -> Vec<u8> {
        let profile_and_level = &self.sequence[1..4];
        let mut record = vec![1];
        record.extend(profile_and_level);
        record.extend([0xFF, 0xE1]);
        record.extend((self.sequence.len() as u16).to_be_bytes());
        record.extend(&self.sequence);
        record.push(1);
        record.extend((self.per_image.len() as u16).to_be_bytes());
        record.extend(&self.per_image);
        record
    }
}

/// A frame as MP4 stores it: its units after their lengths, without parameter sets.
pub fn length_prefixed(frame: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(frame.len());
    for unit in units(frame) {
        if !matches!(kind_of(unit), SEQUENCE_PARAMETER_SET | PER_IMAGE_PARAMETER_SET) {
            bytes.extend((unit.len() as u32).to_be_bytes());
            bytes.extend(unit);
        }
    }
    bytes
}

fn kind_of(unit: &[u8]) -> u8 {
    unit.first().map_or(0, |first| first & 0x1F)
}

/// The units between start codes (0, 0, 1 with any zeros before), without empty ones.
fn units(stream: &[u8]) -> Vec<&[u8]> {
    let starts: Vec<usize> =
        stream.windows(3).enumerate().filter(|(_, three)| *three == [0, 0, 1]).map(|(at, _)| at).collect();
    let ends = starts.iter().skip(1).copied().chain([stream.len()]);
    let cut = |(start, end): (&usize, usize)| {
        let mut unit = &stream[start + 3..end];
        // A unit never ends with zero: those belong to the next start code.
        while let [before @ .., 0] = unit {
            unit = before;
        }
        unit
    };
    starts.iter().zip(ends).map(cut).filter(|unit| !unit.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STREAM: &[u8] =
        &[0, 0, 0, 1, 0x67, 66, 0, 20, 9, 0, 0, 0, 1, 0x68, 5, 0, 0, 1, 0x65, 1, 0, 0, 3, 0, 2, 0];

    #[test]
    fn units_end_where_start_codes_begin() {
        let expected: [&[u8]; 3] = [&[0x67, 66, 0, 20, 9], &[0x68, 5], &[0x65, 1, 0, 0, 3, 0, 2]];
        assert_eq!(units(STREAM), expected);
    }

    #[test]
    fn parameter_sets_move_from_the_frame_to_the_record() {
        let sets = ParameterSets::of(STREAM).expect("parameter sets");
        assert_eq!(
            sets.configuration_record(),
            [1, 66, 0, 20, 0xFF, 0xE1, 0, 5, 0x67, 66, 0, 20, 9, 1, 0, 2, 0x68, 5]
        );
        assert_eq!(length_prefixed(STREAM), [0, 0, 0, 7, 0x65, 1, 0, 0, 3, 0, 2]);
        assert_eq!(ParameterSets::of(&STREAM[14..]), None);
    }
}
