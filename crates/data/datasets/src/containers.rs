//! Writes scenes into tar shards or as single archives. One scene is in memory at a time.

use std::io::Write;
use std::path::Path;

use crate::bundle::{Bundle, sha256};
use crate::dataset_manifest::{FileEntry, Layout};
use crate::error::DatasetError;
use crate::files::{self, AtomicFile};
use crate::members::{self, ARCHIVE, MemberEntry};
use crate::progress::{self, ContainerRecord, PlannedScene, StoredScene};
use crate::tar;

/// All containers of a dataset.
#[derive(Debug, Default)]
pub struct Containers {
    /// In the order of the planned scenes, each with the path of its container.
    pub scenes: Vec<(StoredScene, String)>,
    /// In the order in which they were written.
    pub files: Vec<FileEntry>,
    /// Number of containers that an earlier, interrupted freeze had written.
    pub kept: usize,
}

/// The content of one scene, ready to be written.
struct Content {
    members: Vec<(String, Vec<u8>)>,
    stored: StoredScene,
}

/// Writes the containers of all scenes, which are sorted by split. `notify` is called with the number of scenes done.
///
/// # Errors
///
/// [`DatasetError`] if a bundle is damaged or changed since it was selected, or the disk fails.
pub fn write(
    folder: &Path,
    planned: &[PlannedScene],
    layout: Layout,
    notify: &mut dyn FnMut(usize),
) -> Result<Containers, DatasetError> {
    let mut containers = Containers::default();
    for scenes in planned.chunk_by(|a, b| a.split == b.split) {
        let mut rest = scenes;
        // The scene that did not fit into the last shard: it is packed once.
        let mut waiting: Option<Content> = None;
        for number in 0.. {
            let Some(first) = rest.first() else { break };
            let path = match layout {
                Layout::Scenes => format!("scenes/{}.zip", first.id),
                Layout::Shards { .. } => format!("shards/{}-{number:06}.tar", first.split),
            };
            let record = match ContainerRecord::reusable(folder, &path, layout, rest) {
                Some(record) => {
                    containers.kept += 1;
                    waiting = None;
                    record
                }
                None => {
                    let record = match layout {
                        Layout::Scenes => write_archive(folder, path.clone(), rest)?,
                        Layout::Shards { .. } => {
                            write_shard(folder, path.clone(), rest, layout, &mut waiting)?
                        }
                    };
                    record.write(folder)?;
                    record
                }
            };
            rest = &rest[record.scenes.len()..];
            containers.scenes.extend(record.scenes.into_iter().map(|scene| (scene, path.clone())));
            containers.files.push(record.file);
            notify(containers.scenes.len());
        }
    }
    Ok(containers)
}

fn write_archive(
    folder: &Path,
    path: String,
    rest: &[PlannedScene],
) -> Result<ContainerRecord, DatasetError> {
    let mut bundle = open(&rest[0])?;
    let bytes = bundle.archive()?;
    let file = files::write_beside(folder, &path, &partial_path(&path), &bytes)?;
    let (size, sha256) = (file.size, file.sha256.clone());
    let PlannedScene { id, manifest_sha256, .. } = rest[0].clone();
    let scene = StoredScene { id, manifest_sha256, size, sha256, members: members::Members::new() };
    Ok(ContainerRecord { layout: Layout::Scenes, file, scenes: vec![scene], next: progress::next(rest, 1) })
}

fn write_shard(
    folder: &Path,
    path: String,
    rest: &[PlannedScene],
    layout: Layout,
    waiting: &mut Option<Content>,
) -> Result<ContainerRecord, DatasetError> {
    let (max_bytes, max_scenes) = match layout {
        Layout::Shards { max_bytes, max_scenes } => (max_bytes, max_scenes.unwrap_or(usize::MAX)),
        Layout::Scenes => (u64::MAX, usize::MAX),
    };
    let target = folder.join(&path);
    let mut shard = AtomicFile::create(folder.join(partial_path(&path)), target.clone())?;
    let mut scenes: Vec<StoredScene> = Vec::new();
    for scene in rest {
        if scenes.len() >= max_scenes {
            break;
        }
        let content = match waiting.take() {
            Some(content) => content,
            None => read(scene)?,
        };
        let sizes = content.members.iter().map(|(_, bytes)| tar::member_bytes(bytes.len() as u64));
        let end = shard.size() + sizes.sum::<u64>() + tar::END_BYTES;
        if !scenes.is_empty() && end > max_bytes {
            *waiting = Some(content);
            break;
        }
        for (extension, bytes) in &content.members {
            tar::write_member(&mut shard, &format!("{}.{extension}", scene.id), bytes)
                .map_err(DatasetError::file("write", &target))?;
        }
        scenes.push(content.stored);
    }
    tar::write_end(&mut shard).and_then(|()| shard.flush()).map_err(DatasetError::file("write", &target))?;
    let (size, sha256) = shard.finish()?;
    let next = progress::next(rest, scenes.len());
    Ok(ContainerRecord { layout, file: FileEntry { path, size, sha256 }, scenes, next })
}

/// Opens the bundle of a planned scene.
fn open(scene: &PlannedScene) -> Result<Bundle, DatasetError> {
    let bundle = Bundle::open(&scene.place)?;
    if bundle.manifest_sha256() != scene.manifest_sha256 {
        return Err(DatasetError::bundle(
            &scene.place,
            "it changed while the dataset was written; freeze again",
        ));
    }
    Ok(bundle)
}

fn read(scene: &PlannedScene) -> Result<Content, DatasetError> {
    let members = members::read(&mut open(scene)?)?;
    let archive = members.get(ARCHIVE).map_or(&[][..], Vec::as_slice);
    let stored = StoredScene {
        id: scene.id.clone(),
        manifest_sha256: scene.manifest_sha256.clone(),
        size: archive.len() as u64,
        sha256: sha256(archive),
        members: members.iter().map(|(name, bytes)| (name.clone(), MemberEntry::of(bytes))).collect(),
    };
    Ok(Content { members: members.into_iter().collect(), stored })
}

fn partial_path(path: &str) -> String {
    format!("{}/{}.partial", progress::FOLDER, path.replace('/', "-"))
}
