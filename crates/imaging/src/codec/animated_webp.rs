//! Detects animated WebP files by their header, before a decoder reads them.
//!
//! Every caller needs a single image, and decoders of animations are far less tested than those of still images.

/// Whether these are the first bytes of a WebP file with the animation flag set (RFC 9649, 2.7).
pub(super) fn is_animated_webp(file: &[u8]) -> bool {
    const ANIMATION: u8 = 0b10;
    let is_extended = file.starts_with(b"RIFF") && file.get(8..16) == Some(b"WEBPVP8X");
    is_extended && file.get(20).is_some_and(|flags| flags & ANIMATION != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_animated_webp_reads_only_the_flag_of_an_extended_file() {
        let header = |kind: &[u8; 4], flags: u8| {
            [b"RIFF\x1a\0\0\0WEBP".as_slice(), kind, &[10, 0, 0, 0, flags, 0, 0, 0]].concat()
        };
        assert!(is_animated_webp(&header(b"VP8X", 0b10)) && is_animated_webp(&header(b"VP8X", 0b1_0010)));
        for other in [header(b"VP8X", 0b1_0000), header(b"VP8 ", 0b10), b"RIFF".to_vec(), Vec::new()] {
            assert!(!is_animated_webp(&other), "{other:?}");
        }
        assert!(!is_animated_webp(&header(b"VP8X", 0b10)[..20]));
    }
}
