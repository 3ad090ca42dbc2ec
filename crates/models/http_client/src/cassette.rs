//! Cassettes: recorded HTTP exchanges, which replay a run byte for byte without a network.
//!
//! An exchange is stored under the digest of its request: method, URL, headers, content type and body. Credentials and
//! the signatures in URLs are neither part of the digest nor stored ([`redaction`]). A repeated request, such as a
//! status query, receives its responses in the recorded order, and then the last one again. Responses of any status
//! are recorded; a broken connection leaves no exchange. A cassette is a folder with one file per exchange.
//! [`Cassette::replay`] also reads a ZIP archive of such a folder.

mod exchange;
mod redaction;

use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::message::{HttpRequest, HttpResponse};
use exchange::Exchange;
pub use exchange::{ExchangeError, request_digest};

/// Maximum size of one exchange, bytes.
const MAX_EXCHANGE_BYTES: u64 = 512 << 20;

/// Maximum size of a replayed cassette, bytes.
const MAX_CASSETTE_BYTES: u64 = 4 << 30;

/// Suffix of the files of a cassette.
const SUFFIX: &str = ".json";

/// A cassette that is being recorded or replayed.
pub struct Cassette {
    place: PathBuf,
    /// By the digest of the request. While recording, tracks hold positions only.
    tracks: Mutex<BTreeMap<String, Track>>,
}

/// The responses to one request.
#[derive(Default)]
struct Track {
    responses: Vec<HttpResponse>,
    /// Number of responses that were replayed or recorded.
    position: usize,
}

/// Reason why a cassette cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CassetteError {
    #[error("the recording {place} cannot be used: {source}; name another in providers.cassette")]
    Unusable { place: String, source: std::io::Error },
    #[error("{file} of the recording {place} is no recorded exchange ({reason}); record again")]
    Broken { place: String, file: String, reason: ExchangeError },
    #[error("the recording {place} holds no exchange; record one with providers.mode = record")]
    Empty { place: String },
}

impl Cassette {
    /// A cassette that records into `folder`. Exchanges that the folder holds stay, and new ones follow them.
    ///
    /// # Errors
    ///
    /// [`CassetteError::Unusable`] where the folder cannot be created or read.
    pub fn record_into(folder: &Path) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: folder.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(unusable)?;
        let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(unusable)? {
            let name = entry.map_err(unusable)?.file_name();
            if let Some((digest, number)) = name.to_str().and_then(parse_file_name) {
                let track = tracks.entry(digest.to_owned()).or_default();
                track.position = track.position.max(number + 1);
            }
        }
        Ok(Self { place: folder.to_owned(), tracks: Mutex::new(tracks) })
    }

    /// A cassette that replays a folder or a ZIP archive of one, which is read completely.
    ///
    /// # Errors
    ///
    /// [`CassetteError`] where it cannot be read, is malformed, or holds no exchange.
    pub fn replay(place: &Path) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: place.display().to_string(), source };
        match place.is_dir() {
            true => Self::from_files(place, files_of_folder(place).map_err(unusable)?),
            false => Self::replay_archive(place, std::fs::File::open(place).map_err(unusable)?),
        }
    }

    /// A cassette that replays the ZIP archive of a folder; `place` names it in errors.
    ///
    /// # Errors
    ///
    /// As [`Self::replay`].
    pub fn replay_archive(place: &Path, archive: impl Read + Seek) -> Result<Self, CassetteError> {
        let unusable = |source| CassetteError::Unusable { place: place.display().to_string(), source };
        Self::from_files(place, files_of_archive(archive).map_err(unusable)?)
    }

    fn from_files(place: &Path, files: BTreeMap<String, Vec<u8>>) -> Result<Self, CassetteError> {
        let mut tracks: BTreeMap<String, Track> = BTreeMap::new();
        // Names sort by request and then by number.
        for (name, text) in &files {
            let broken = |reason| CassetteError::Broken {
                place: place.display().to_string(),
                file: name.clone(),
                reason,
            };
            let Some((digest, _)) = parse_file_name(name) else { continue };
            let response = Exchange::read(text).map_err(broken)?;
            tracks.entry(digest.to_owned()).or_default().responses.push(response);
        }
        if tracks.is_empty() {
            return Err(CassetteError::Empty { place: place.display().to_string() });
        }
        Ok(Self { place: place.to_owned(), tracks: Mutex::new(tracks) })
    }

    /// Writes an exchange without its secrets; it is on disk when this returns.
    pub async fn record(&self, request: &HttpRequest, response: &HttpResponse) -> std::io::Result<()> {
        let digest = request_digest(request);
        let number = {
            let mut tracks = self.tracks.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let track = tracks.entry(digest.clone()).or_default();
            track.position += 1;
            track.position - 1
        };
        let text = Exchange::new(request, response).to_json();
        let place = self.place.join(file_name(&digest, number));
        let unfinished = place.with_extension("unfinished");
        tokio::fs::write(&unfinished, text).await?;
        tokio::fs::rename(&unfinished, &place).await
    }

    /// The next response to a request; `None` where the request was not recorded.
    pub fn next_response(&self, request: &HttpRequest) -> Option<HttpResponse> {
        let mut tracks = self.tracks.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let track = tracks.get_mut(&request_digest(request))?;
        let at = track.position.min(track.responses.len().saturating_sub(1));
        track.position = at + 1;
        track.responses.get(at).cloned()
    }
}

fn file_name(digest: &str, number: usize) -> String {
    format!("{digest}-{number:04}{SUFFIX}")
}

/// The digest and the number in a file name.
fn parse_file_name(name: &str) -> Option<(&str, usize)> {
    let (digest, number) = name.strip_suffix(SUFFIX)?.split_once('-')?;
    let is_digest = digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit());
    Some((digest, number.parse().ok()?)).filter(|_| is_digest)
}

fn files_of_folder(folder: &Path) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut left = MAX_CASSETTE_BYTES;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        if parse_file_name(&name).is_some() {
            files.insert(name, read_bounded(std::fs::File::open(entry.path())?, &mut left)?);
        }
    }
    Ok(files)
}

fn files_of_archive(archive: impl Read + Seek) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let mut archive = zip::ZipArchive::new(archive)?;
    let mut files = BTreeMap::new();
    let mut left = MAX_CASSETTE_BYTES;
    for index in 0..archive.len() {
        let file = archive.by_index(index)?;
        let name = file.name()?.rsplit('/').next().unwrap_or_default().to_owned();
        if parse_file_name(&name).is_some() {
            files.insert(name, read_bounded(file, &mut left)?);
        }
    }
    Ok(files)
}

/// Reads a whole file within the limits of one file and of the rest of the cassette, `left`.
fn read_bounded(file: impl Read, left: &mut u64) -> std::io::Result<Vec<u8>> {
    let limit = MAX_EXCHANGE_BYTES.min(*left);
    let mut bytes = Vec::new();
    let read = file.take(limit + 1).read_to_end(&mut bytes)? as u64;
    if read > limit {
        return Err(std::io::Error::other("it is larger than recordings may be"));
    }
    *left -= read;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
