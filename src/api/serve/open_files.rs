//! The limit of open files: raised as far as the system allows, and how many connections it leaves room for.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// More open files than this are not asked for.
const WANTED: u64 = 1 << 16;

/// Descriptors for the database, stored files and outbound calls.
const RESERVED: u64 = 256;

/// Raises the soft limit of open files to the hard limit, at most [`WANTED`]; the limit afterwards. A limit that cannot
/// be raised stays.
pub fn raise() -> u64 {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let now = current.unwrap_or(WANTED);
    let wanted = maximum.unwrap_or(WANTED).min(WANTED);
    if now >= wanted {
        return now;
    }
    match setrlimit(Resource::Nofile, Rlimit { current: Some(wanted), maximum }) {
        Ok(()) => wanted,
        Err(error) => {
            tracing::warn!(%error, now, wanted, "cannot raise the limit of open files");
            now
        }
    }
}

/// Number of connections that fit under a limit of open files: a download needs two, its socket and its file.
pub fn connections_within(open_files: u64) -> usize {
    let pairs = open_files.saturating_sub(RESERVED.min(open_files / 2)) / 2;
    usize::try_from(pairs).unwrap_or(usize::MAX).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_raised_and_leaves_room_for_files() {
        let raised = raise();
        assert_eq!(getrlimit(Resource::Nofile).current.unwrap_or(raised), raised);
        assert_eq!(raise(), raised);
        assert_eq!(connections_within(1024), 384);
        assert_eq!(connections_within(64), 16);
        assert_eq!(connections_within(0), 1);
    }
}
