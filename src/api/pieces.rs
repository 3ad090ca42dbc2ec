//! A response body out of several pieces, of which some are blobs: an archive that is stored nowhere as a whole.

use std::ops::Range;

use axum::body::Body;
use bytes::Bytes;
use futures::{StreamExt, TryStreamExt, stream};

use store::{Digest, Store, StoreError};

/// A part of a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    Memory(Bytes),
    /// A blob and its size, bytes.
    Blob(Digest, u64),
}

impl Piece {
    fn size(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::Blob(_, size) => *size,
        }
    }
}

/// Bytes of all pieces together.
pub fn size(pieces: &[Piece]) -> u64 {
    pieces.iter().map(Piece::size).sum()
}

/// A range of the pieces one after the other. A blob that is lost ends the body with an error, so that the client sees
/// that it is cut off.
pub fn body(store: Store, pieces: Vec<Piece>, range: Range<u64>) -> Body {
    let parts = stream::iter(cut(pieces, range)).then(move |(piece, part)| {
        let store = store.clone();
        async move {
            match piece {
                Piece::Memory(bytes) => {
                    let part = bytes.slice(part.start as usize..part.end as usize);
                    Ok(stream::iter([Ok(part)]).boxed())
                }
                Piece::Blob(digest, _) => {
                    let name = digest.to_string();
                    let found = store.blobs().stream(&digest, Some(part)).await?;
                    found.ok_or(StoreError::BlobDamaged { name })
                }
            }
        }
    });
    Body::from_stream(parts.try_flatten())
}

/// The pieces that lie in a range, each with the range of its own bytes.
fn cut(pieces: Vec<Piece>, range: Range<u64>) -> Vec<(Piece, Range<u64>)> {
    let mut start = 0;
    let parts = pieces.into_iter().map(|piece| {
        let (from, size) = (start, piece.size());
        start += size;
        let within = |at: u64| at.saturating_sub(from).min(size);
        let part = within(range.start)..within(range.end);
        (piece, part)
    });
    parts.filter(|(_, part)| !part.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_takes_the_parts_of_the_pieces_in_it() {
        let memory = |text: &'static str| Piece::Memory(Bytes::from_static(text.as_bytes()));
        let blob = Piece::Blob(Digest::of(b"blob"), 4);
        let pieces = vec![memory("abc"), blob.clone(), memory(""), memory("xy")];
        assert_eq!(size(&pieces), 9);
        let all = vec![(memory("abc"), 0..3), (blob.clone(), 0..4), (memory("xy"), 0..2)];
        assert_eq!(cut(pieces.clone(), 0..9), all);
        assert_eq!(cut(pieces.clone(), 2..5), [(memory("abc"), 2..3), (blob.clone(), 0..2)]);
        assert_eq!(cut(pieces.clone(), 4..6), [(blob, 1..3)]);
        assert_eq!(cut(pieces.clone(), 8..9), [(memory("xy"), 1..2)]);
        assert_eq!(cut(pieces, 9..9), []);
    }
}
