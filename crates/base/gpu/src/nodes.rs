//! Detects graphics hardware by its device nodes, without loading a driver.

use std::path::Path;

/// Name prefixes of device nodes of graphics hardware: the kernel's own (`dri`), and those of vendor drivers (NVIDIA,
/// Windows for its Linux guests, Qualcomm, Arm, Tegra, PowerVR).
const NODES: [&str; 8] = ["dri", "nvidia", "dxg", "kgsl", "mali", "nvhost", "nvgpu", "pvr"];

/// False only on a Linux whose `/dev` can be read and has none of [`NODES`].
pub fn may_have_hardware() -> bool {
    !cfg!(target_os = "linux") || has_node(Path::new("/dev"))
}

/// Whether the folder contains one of [`NODES`] or cannot be read.
fn has_node(folder: &Path) -> bool {
    let Ok(entries) = folder.read_dir() else { return true };
    let is_node = |name: &str| NODES.iter().any(|node| name.starts_with(node));
    entries.flatten().any(|entry| is_node(&entry.file_name().to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_node_is_false_only_for_a_readable_folder_without_nodes() {
        let folder = tempfile::tempdir().expect("temporary directory");
        std::fs::write(folder.path().join("null"), "").expect("written");
        assert!(!has_node(folder.path()));
        std::fs::create_dir(folder.path().join("dri")).expect("created");
        assert!(has_node(folder.path()));
        assert!(has_node(&folder.path().join("missing")));
    }
}
