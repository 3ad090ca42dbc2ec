//! The umask of programs that keep data: what they make is for their own user alone, whatever umask they are started
//! with.

/// Takes the rights of the group and of others from every file and directory that this process makes from now on.
pub(super) fn keep_private() {
    rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
}
