//! The bytes of files and archives: slices of the blobs that an archive is stored in.

use uuid::Uuid;

use crate::api::download::Content;
use crate::api::pieces::Piece;
use crate::api::query::PageToken;
use store::recordings::{RecordingArchive, RecordingFile};

/// The whole archive.
pub(super) fn whole(archive: &RecordingArchive) -> Content {
    let parts = archive.parts.iter();
    Content::Pieces(parts.map(|part| Piece::Blob(part.digest.clone(), part.size)).collect())
}

/// A file in its archive.
pub(super) fn file_content(archive: &RecordingArchive, file: &RecordingFile) -> Content {
    let parts = archive.parts.iter();
    let pieces = parts.map(|part| Piece::Blob(part.digest.clone(), part.size)).collect();
    Content::Within(pieces, file.start)
}

/// The media type of a file of a dataset.
pub(super) fn media_type_of(path: &str) -> &'static str {
    match path.rsplit('.').next().unwrap_or_default() {
        "json" => "application/json",
        "jsonl" => "application/jsonl",
        "md" => "text/markdown; charset=utf-8",
        "png" => "image/png",
        "mp4" => "video/mp4",
        _ => "application/octet-stream",
    }
}

/// The token of the page behind a place in the list of files.
pub(super) fn token_after(place: u64) -> Option<PageToken> {
    PageToken::after(&Uuid::from_u128(place.into()).to_string())
}

/// The place that a token is behind of.
pub(super) fn place_of(token: PageToken) -> Option<u64> {
    let last: String = token.last_id()?;
    // A token of another list has a larger number: nothing is behind it.
    Uuid::parse_str(&last).ok().map(|id| u64::try_from(id.as_u128()).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_keep_places() {
        for place in [0, 49, 1 << 40] {
            assert_eq!(token_after(place).and_then(place_of), Some(place));
        }
    }
}
