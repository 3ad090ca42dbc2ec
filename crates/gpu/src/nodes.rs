//! Whether the system has graphics hardware at all, told without loading a driver.

use std::path::Path;

/// How device nodes of graphics hardware begin: the kernel's own (`dri`), and those of drivers beside it: NVIDIA's,
/// Windows' for its Linux guests, Qualcomm's, Arm's, Tegra's, PowerVR's.
const NODES: [&str; 8] = ["dri", "nvidia", "dxg", "kgsl", "mali", "nvhost", "nvgpu", "pvr"];

/// False only on a Linux whose `/dev` can be read and has none of these.
pub fn may_have_hardware() -> bool {
    !cfg!(target_os = "linux") || has_node(Path::new("/dev"))
}

/// Whether the folder has one of them, or cannot be read.
fn has_node(folder: &Path) -> bool {
    let Ok(entries) = folder.read_dir() else { return true };
    let is_node = |name: &str| NODES.iter().any(|node| name.starts_with(node));
    entries.flatten().any(|entry| is_node(&entry.file_name().to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_nodes_has_no_hardware_and_one_that_cannot_be_read_may() {
        let folder = tempfile::tempdir().expect("temporary directory");
        std::fs::write(folder.path().join("null"), "").expect("written");
        assert!(!has_node(folder.path()));
        std::fs::create_dir(folder.path().join("dri")).expect("created");
        assert!(has_node(folder.path()));
        assert!(has_node(&folder.path().join("missing")));
    }
}
