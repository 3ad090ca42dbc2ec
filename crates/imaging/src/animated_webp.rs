//! Whether a picture file moves: told from its header, before any decoder sees it. Decoders of single
//! pictures are tried on many files, those of moving ones on few, and nothing here wants more than one
//! picture.

/// Whether these are the first bytes of a WebP file that says it is animated (RFC 9649, 2.7).
pub fn is_moving_webp(file: &[u8]) -> bool {
    const ANIMATION: u8 = 0b10;
    let is_extended = file.starts_with(b"RIFF") && file.get(8..16) == Some(b"WEBPVP8X");
    is_extended && file.get(20).is_some_and(|flags| flags & ANIMATION != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_animation_flag_of_an_extended_file_counts() {
        let header = |kind: &[u8; 4], flags: u8| {
            [b"RIFF\x1a\0\0\0WEBP".as_slice(), kind, &[10, 0, 0, 0, flags, 0, 0, 0]].concat()
        };
        assert!(is_moving_webp(&header(b"VP8X", 0b10)) && is_moving_webp(&header(b"VP8X", 0b1_0010)));
        for other in [header(b"VP8X", 0b1_0000), header(b"VP8 ", 0b10), b"RIFF".to_vec(), Vec::new()] {
            assert!(!is_moving_webp(&other), "{other:?}");
        }
        assert!(!is_moving_webp(&header(b"VP8X", 0b10)[..20]));
    }
}
