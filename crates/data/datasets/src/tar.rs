//! Tar archives in the ustar format: plain files, no times, no owners. Equal members give equal bytes.

use std::io::{self, Read, Write};

const BLOCK: usize = 512;

/// Bytes of the two empty blocks at the end of an archive.
pub const END_BYTES: u64 = 2 * BLOCK as u64;

/// Largest size that eleven octal digits hold.
const MAX_SIZE: u64 = (1 << 33) - 1;
/// Begins a size that is a binary number.
const BINARY: u8 = 0x80;

/// Bytes that a member of this size takes up, its header included.
pub fn member_bytes(size: u64) -> u64 {
    BLOCK as u64 + size.next_multiple_of(BLOCK as u64)
}

/// Writes one member.
///
/// # Errors
///
/// If the name is longer than 100 bytes, or the writer fails.
pub fn write_member(archive: &mut impl Write, name: &str, bytes: &[u8]) -> io::Result<()> {
    archive.write_all(&header(name, bytes.len() as u64)?)?;
    archive.write_all(bytes)?;
    let padding = bytes.len().next_multiple_of(BLOCK) - bytes.len();
    archive.write_all(&[0; BLOCK][..padding])
}

/// Writes the end of the archive.
///
/// # Errors
///
/// If the writer fails.
pub fn write_end(archive: &mut impl Write) -> io::Result<()> {
    archive.write_all(&[0; 2 * BLOCK])
}

/// The header of a member, which precedes its content. A size from 8 GiB is written in binary, as GNU tar, BSD tar and
/// Python have it.
///
/// # Errors
///
/// If the name is longer than 100 bytes.
pub fn header(name: &str, size: u64) -> io::Result<[u8; BLOCK]> {
    if name.is_empty() || name.len() > 100 || !name.is_ascii() {
        return Err(io::Error::other(format!("{name:?} does not fit into a tar header")));
    }
    let mut header = [0; BLOCK];
    let mut put = |at: usize, text: &[u8]| header[at..at + text.len()].copy_from_slice(text);
    put(0, name.as_bytes());
    put(100, b"0000644\0");
    put(108, b"0000000\0");
    put(116, b"0000000\0");
    if size > MAX_SIZE {
        put(124, &[BINARY]);
        put(128, &size.to_be_bytes());
    } else {
        put(124, format!("{size:011o}\0").as_bytes());
    }
    put(136, b"00000000000\0");
    put(148, b"        ");
    put(156, b"0");
    put(257, b"ustar\0");
    put(263, b"00");
    let sum = checksum(&header);
    header[148..156].copy_from_slice(format!("{sum:06o}\0 ").as_bytes());
    Ok(header)
}

/// Sum of the bytes of a header, its checksum counted as spaces.
fn checksum(header: &[u8; BLOCK]) -> u32 {
    let bytes = header.iter().enumerate();
    bytes.map(|(at, byte)| if (148..156).contains(&at) { 32 } else { u32::from(*byte) }).sum()
}

/// Name and size of a member.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemberHeader {
    pub name: String,
    pub size: u64,
}

/// Reads an archive member by member.
pub struct TarReader<R> {
    archive: R,
}

impl<R: Read> TarReader<R> {
    pub fn new(archive: R) -> Self {
        Self { archive }
    }

    /// The next member; `None` at the end of the archive. The content must be read or skipped before the next call.
    ///
    /// # Errors
    ///
    /// If the archive ends early or holds another header than [`write_member`] writes.
    pub fn next_member(&mut self) -> io::Result<Option<MemberHeader>> {
        let mut block = [0; BLOCK];
        self.archive.read_exact(&mut block)?;
        if block == [0; BLOCK] {
            self.archive.read_exact(&mut block)?;
            let mut rest = [0; 1];
            let is_end = block == [0; BLOCK] && self.archive.read(&mut rest)? == 0;
            return if is_end {
                Ok(None)
            } else {
                Err(io::Error::other("data follow the end of the archive"))
            };
        }
        let text = |range: std::ops::Range<usize>| {
            let field = &block[range];
            let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
            String::from_utf8_lossy(&field[..end]).into_owned()
        };
        let name = text(0..100);
        let size = match block[124] {
            BINARY => block[128..136].iter().fold(0, |size, byte| size << 8 | u64::from(*byte)),
            _ => u64::from_str_radix(&text(124..136), 8).map_err(io::Error::other)?,
        };
        if header(&name, size)? != block {
            return Err(io::Error::other(format!("the header of {name:?} is not in the dataset's form")));
        }
        Ok(Some(MemberHeader { name, size }))
    }

    /// The content of the member that was returned last.
    ///
    /// # Errors
    ///
    /// If the archive ends early.
    pub fn content(&mut self, member: &MemberHeader) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let padded = member.size.next_multiple_of(BLOCK as u64);
        (&mut self.archive).take(padded).read_to_end(&mut bytes)?;
        if bytes.len() as u64 != padded {
            return Err(io::Error::other(format!("the archive ends inside {}", member.name)));
        }
        bytes.truncate(usize::try_from(member.size).map_err(io::Error::other)?);
        Ok(bytes)
    }

    /// Skips the content of the member that was returned last.
    ///
    /// # Errors
    ///
    /// If the archive ends early.
    pub fn skip(&mut self, member: &MemberHeader) -> io::Result<()> {
        let padded = member.size.next_multiple_of(BLOCK as u64);
        let skipped = io::copy(&mut (&mut self.archive).take(padded), &mut io::sink())?;
        if skipped == padded {
            return Ok(());
        }
        Err(io::Error::other(format!("the archive ends inside {}", member.name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_read_as_they_were_written() {
        let mut archive = Vec::new();
        let members: [(&str, &[u8]); 3] = [("a.json", b"{}"), ("a.zip", &[7; 1024]), ("b.top.png", b"")];
        for (name, bytes) in members {
            write_member(&mut archive, name, bytes).expect("a vector takes all bytes");
        }
        write_end(&mut archive).expect("a vector takes all bytes");
        let size = members.iter().map(|(_, bytes)| member_bytes(bytes.len() as u64)).sum::<u64>() + END_BYTES;
        assert_eq!(archive.len() as u64, size);
        let mut reader = TarReader::new(archive.as_slice());
        for (name, bytes) in members {
            let member = reader.next_member().expect("whole").expect("a member");
            assert_eq!(member.name, name);
            assert_eq!(reader.content(&member).expect("whole"), bytes);
        }
        assert_eq!(reader.next_member().expect("whole"), None);
    }

    #[test]
    fn truncated_and_foreign_archives_are_errors() {
        let mut archive = Vec::new();
        write_member(&mut archive, "a", &[1; 700]).expect("a vector takes all bytes");
        let mut reader = TarReader::new(&archive[..1000]);
        let member = reader.next_member().expect("a header").expect("a member");
        assert!(reader.content(&member).is_err());
        // The owner's name is no part of the dataset's form.
        archive[265] = b'x';
        assert!(TarReader::new(archive.as_slice()).next_member().is_err());
        assert!(TarReader::new(&[0_u8; 512][..]).next_member().is_err());
    }

    #[test]
    fn sizes_have_no_limit() {
        for size in [0, MAX_SIZE, MAX_SIZE + 1, 1 << 40] {
            let mut archive: &[u8] = &header("dataset.hdf5", size).expect("fits");
            let member = TarReader::new(&mut archive).next_member().expect("a header").expect("a member");
            assert_eq!(member.size, size);
        }
        let large = header("a", 1 << 33).expect("fits");
        assert_eq!(large[124..136], [0x80, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0]);
    }

    #[test]
    fn long_names_are_refused() {
        assert!(write_member(&mut Vec::new(), &"a".repeat(101), b"").is_err());
    }
}
