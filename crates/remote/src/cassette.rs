//! What was said over the network, kept so that it can be said again: a run that was recorded once is
//! repeated without a network, byte for byte.
//!
//! An exchange is kept under the digest of its request: method, address, headers, content type and body.
//! Whatever proves who asks is no part of that and is not kept, nor are the signatures in addresses
//! ([`redaction`]). A request that is made again, as one looks at a vendor's job, finds its answers in the
//! order in which they came, and after the last one that one again. Only answers are kept, whatever their
//! status; a connection that broke leaves nothing. A recording is a folder of one file an exchange,
//! [`Cassette::played`] also from a ZIP archive of such a folder.

mod exchange;
mod redaction;

use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::outbound::{Outgoing, Reply};
use exchange::Exchange;
pub use exchange::digest_of;

/// Largest file of a recording, bytes.
const MAX_EXCHANGE_BYTES: u64 = 512 << 20;

/// Largest recording that is played, bytes.
const MAX_CASSETTE_BYTES: u64 = 4 << 30;

/// Ends the names of a recording's files.
const SUFFIX: &str = ".json";

/// A recording, being made or being played.
pub struct Cassette {
    place: PathBuf,
    /// By the digest of the request; of a recording that is being made, only how many answers there are.
    tracks: Mutex<BTreeMap<String, Track>>,
}

/// The answers to one request.
#[derive(Default)]
struct Track {
    replies: Vec<Reply>,
    /// How many were given, or written.
    position: usize,
}

/// Why a recording cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CassetteError {
    #[error("the recording {place} cannot be used: {source}; name another in providers.cassette")]
    Unusable { place: String, source: std::io::Error },
    #[error("{file} of the recording {place} is no recorded exchange ({reason}); record again")]
    Broken { place: String, file: String, reason: String },
    #[error("the recording {place} holds no exchange; record one with providers.mode = record")]
    Empty { place: String },
}

impl Cassette {
    /// A folder to record into; what it holds already stays and comes first.
    pub fn recorded(folder: &Path) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: folder.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(unusable)?;
        let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(unusable)? {
            let name = entry.map_err(unusable)?.file_name();
            if let Some((digest, number)) = name.to_str().and_then(parts_of) {
                let track = tracks.entry(digest.to_owned()).or_default();
                track.position = track.position.max(number + 1);
            }
        }
        Ok(Self { place: folder.to_owned(), tracks: Mutex::new(tracks) })
    }

    /// A folder, or a ZIP archive of one, to play; all of it is read now.
    pub fn played(place: &Path) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: place.display().to_string(), source };
        match place.is_dir() {
            true => Self::of_files(place, folder_files(place).map_err(unusable)?),
            false => Self::of_archive(place, std::fs::File::open(place).map_err(unusable)?),
        }
    }

    /// The ZIP archive of a folder, to play; `place` is where it is from.
    pub fn of_archive(place: &Path, archive: impl Read + Seek) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: place.display().to_string(), source };
        Self::of_files(place, archive_files(archive).map_err(unusable)?)
    }

    fn of_files(place: &Path, files: BTreeMap<String, Vec<u8>>) -> Result<Self, CassetteError> {
        let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
        // Names sort by request and then by number.
        for (name, text) in &files {
            let broken = |reason: String| CassetteError::Broken {
                place: place.display().to_string(),
                file: name.clone(),
                reason,
            };
            let Some((digest, _)) = parts_of(name) else { continue };
            let reply = Exchange::read(text).map_err(broken)?;
            tracks.entry(digest.to_owned()).or_default().replies.push(reply);
        }
        if tracks.is_empty() {
            return Err(CassetteError::Empty { place: place.display().to_string() });
        }
        Ok(Self { place: place.to_owned(), tracks: Mutex::new(tracks) })
    }

    /// Keeps an answer, without secrets; on disk when this returns.
    pub async fn keep(&self, outgoing: &Outgoing, reply: &Reply) -> std::io::Result<()> {
        let digest = digest_of(outgoing);
        let number = {
            let mut tracks = self.tracks.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let track = tracks.entry(digest.clone()).or_default();
            track.position += 1;
            track.position - 1
        };
        let text = Exchange::of(outgoing, reply).text();
        let place = self.place.join(name_of(&digest, number));
        let unfinished = place.with_extension("unfinished");
        tokio::fs::write(&unfinished, text).await?;
        tokio::fs::rename(&unfinished, &place).await
    }

    /// The next answer to this request; `None` where it was never made.
    pub fn find(&self, outgoing: &Outgoing) -> Option<Reply> {
        let mut tracks = self.tracks.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let track = tracks.get_mut(&digest_of(outgoing))?;
        let at = track.position.min(track.replies.len().saturating_sub(1));
        track.position = at + 1;
        track.replies.get(at).cloned()
    }
}

fn name_of(digest: &str, number: usize) -> String {
    format!("{digest}-{number:04}{SUFFIX}")
}

/// Digest and number in a file's name.
fn parts_of(name: &str) -> Option<(&str, usize)> {
    let (digest, number) = name.strip_suffix(SUFFIX)?.split_once('-')?;
    let is_digest = digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit());
    Some((digest, number.parse().ok()?)).filter(|_| is_digest)
}

fn folder_files(folder: &Path) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut left = MAX_CASSETTE_BYTES;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        if parts_of(&name).is_some() {
            files.insert(name, bounded(std::fs::File::open(entry.path())?, &mut left)?);
        }
    }
    Ok(files)
}

fn archive_files(archive: impl Read + Seek) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let mut archive = zip::ZipArchive::new(archive)?;
    let mut files = BTreeMap::new();
    let mut left = MAX_CASSETTE_BYTES;
    for index in 0..archive.len() {
        let file = archive.by_index(index)?;
        let name = file.name()?.rsplit('/').next().unwrap_or_default().to_owned();
        if parts_of(&name).is_some() {
            files.insert(name, bounded(file, &mut left)?);
        }
    }
    Ok(files)
}

/// The whole file, if it and all before it are not too large.
fn bounded(file: impl Read, left: &mut u64) -> std::io::Result<Vec<u8>> {
    let most = MAX_EXCHANGE_BYTES.min(*left);
    let mut bytes = Vec::new();
    let read = file.take(most + 1).read_to_end(&mut bytes)? as u64;
    if read > most {
        return Err(std::io::Error::other("it is larger than recordings may be"));
    }
    *left -= read;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
