//! A dataset's folder as tar archives, one for each format, in parts of bounded size.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use tokio::sync::mpsc;

use super::RecordError;
use crate::problem::{Problem, ProblemType};
use datasets::tar;
use store::recordings::RecordingFile;
use store::{Digest, DigestBuilder};

/// Bytes of each part but the last of an archive.
pub const PART_BYTES: usize = 32 << 20;
/// Bytes that are read at once.
const CHUNK_BYTES: usize = 1 << 20;

/// Output of packing, in this order for each format.
pub enum Packed {
    Begin {
        format: String,
    },
    /// The next bytes of the archive.
    Part(Bytes),
    /// Files and parts alternate: a file is named when all its bytes are packed.
    File(RecordingFile),
    End {
        digest: Digest,
        files: u64,
    },
}

/// Packs the folder of each format. Members are in the order of their paths and begin with the format.
///
/// # Errors
///
/// [`RecordError::Stopped`] where the parts are not taken; [`RecordError::File`] of the disk.
pub fn pack(dataset: &Path, formats: &[String], packed: &mpsc::Sender<Packed>) -> Result<(), RecordError> {
    for format in formats {
        send(packed, Packed::Begin { format: format.clone() })?;
        let mut paths = Vec::new();
        list(&dataset.join(format), format, &mut paths)?;
        paths.sort();
        let mut archive = Archive { part: Vec::new(), size: 0, hash: DigestBuilder::default(), packed };
        for (path, place) in &paths {
            archive.add(path, place)?;
        }
        archive.end(paths.len() as u64)?;
    }
    Ok(())
}

/// An archive that is being packed.
struct Archive<'a> {
    /// Bytes of the part that is not full yet.
    part: Vec<u8>,
    /// Bytes so far.
    size: u64,
    hash: DigestBuilder,
    packed: &'a mpsc::Sender<Packed>,
}

impl Archive<'_> {
    fn add(&mut self, path: &str, place: &Path) -> Result<(), RecordError> {
        let unreadable = |source| RecordError::file("read", place)(source);
        let mut file = File::open(place).map_err(unreadable)?;
        let size = file.metadata().map_err(unreadable)?.len();
        let header = tar::header(path, size).map_err(|_| {
            let detail = format!("{path} does not fit into a tar archive; give cameras shorter names");
            Problem::new(ProblemType::InvalidRequest, "path_too_long", detail)
        })?;
        self.write(&header)?;
        let (start, mut hash, mut left) = (self.size, DigestBuilder::default(), size);
        let mut chunk = vec![0; CHUNK_BYTES];
        while left > 0 {
            let wanted = usize::try_from(left).unwrap_or(usize::MAX).min(CHUNK_BYTES);
            file.read_exact(&mut chunk[..wanted]).map_err(unreadable)?;
            hash.update(&chunk[..wanted]);
            self.write(&chunk[..wanted])?;
            left -= wanted as u64;
        }
        let padding = tar::member_bytes(size) - tar::member_bytes(0) - size;
        self.write(&vec![0; padding as usize])?;
        let file = RecordingFile { path: path.to_owned(), digest: hash.finish(), start, size };
        send(self.packed, Packed::File(file))
    }

    fn write(&mut self, mut bytes: &[u8]) -> Result<(), RecordError> {
        self.hash.update(bytes);
        self.size += bytes.len() as u64;
        while !bytes.is_empty() {
            let (now, rest) = bytes.split_at(bytes.len().min(PART_BYTES - self.part.len()));
            self.part.extend_from_slice(now);
            bytes = rest;
            if self.part.len() == PART_BYTES {
                send(self.packed, Packed::Part(std::mem::take(&mut self.part).into()))?;
            }
        }
        Ok(())
    }

    fn end(mut self, files: u64) -> Result<(), RecordError> {
        self.write(&vec![0; tar::END_BYTES as usize])?;
        if !self.part.is_empty() {
            send(self.packed, Packed::Part(std::mem::take(&mut self.part).into()))?;
        }
        send(self.packed, Packed::End { digest: self.hash.finish(), files })
    }
}

fn send(packed: &mpsc::Sender<Packed>, next: Packed) -> Result<(), RecordError> {
    packed.blocking_send(next).map_err(|_| RecordError::Stopped)
}

/// Every file below a folder: its path with `/`, and where it is.
fn list(folder: &Path, path: &str, found: &mut Vec<(String, PathBuf)>) -> Result<(), RecordError> {
    let unreadable = |source| RecordError::file("read", folder)(source);
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let place = entry.map_err(unreadable)?.path();
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        let path = format!("{path}/{name}");
        if place.is_dir() { list(&place, &path, found)? } else { found.push((path, place)) }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_in_the_parts_of_their_archive() {
        let home = tempfile::tempdir().expect("a folder");
        let large: Vec<u8> = (0..PART_BYTES + 700).map(|index| (index % 251) as u8).collect();
        for (path, bytes) in
            [("robomimic/b.bin", &large[..]), ("robomimic/a/x.json", b"{}"), ("other/y", b"y")]
        {
            let place = home.path().join(path);
            std::fs::create_dir_all(place.parent().expect("a folder")).expect("is made");
            std::fs::write(place, bytes).expect("is written");
        }
        let (packed, mut received) = mpsc::channel(8);
        let folder = home.path().to_owned();
        let thread = std::thread::spawn(move || pack(&folder, &["robomimic".into()], &packed).is_ok());
        let (mut archive, mut parts, mut files, mut end) = (Vec::new(), 0, Vec::new(), None);
        while let Some(next) = received.blocking_recv() {
            match next {
                Packed::Begin { format } => assert_eq!(format, "robomimic"),
                Packed::Part(bytes) => {
                    parts += 1;
                    archive.extend_from_slice(&bytes);
                }
                Packed::File(file) => files.push(file),
                Packed::End { digest, files } => end = Some((digest, files)),
            }
        }
        assert!(thread.join().expect("runs"));
        assert_eq!((parts, end), (2, Some((Digest::of(&archive), 2))));
        let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
        assert_eq!(paths, ["robomimic/a/x.json", "robomimic/b.bin"]);
        for (file, bytes) in files.iter().zip([&b"{}"[..], &large]) {
            let found = &archive[file.start as usize..(file.start + file.size) as usize];
            assert!(found == bytes && file.digest == Digest::of(bytes), "{}", file.path);
        }
        let mut reader = tar::TarReader::new(&archive[..]);
        for file in &files {
            let member = reader.next_member().expect("whole").expect("a member");
            assert_eq!((&member.name, member.size), (&file.path, file.size));
            reader.skip(&member).expect("whole");
        }
        assert_eq!(reader.next_member().expect("whole"), None);
    }
}
