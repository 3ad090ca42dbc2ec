//! Reads every byte of a version again and compares it with `dataset.json`.
//!
//! Checked are the digest of the manifest, the list of files, size and digest of every file and of every member of a
//! shard, every file of every bundle against the bundle's manifest, what the manifest states about the scenes, the
//! counts, and that splits share nothing that counts as leakage. One scene is in memory at a time.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use crate::bundle::Bundle;
use crate::dataset_manifest::{self, DatasetManifest, Layout, SceneEntry};
use crate::error::DatasetError;
use crate::facts::SceneFacts;
use crate::files;
use crate::leakage;
use crate::members::{ARCHIVE, COPIES, MemberEntry};
use crate::sharing::Shareable;
use crate::splits;
use crate::statistics::Statistics;
use crate::tar::{MemberHeader, TarReader};

/// One difference between the dataset and its manifest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "DatasetFault", description = "A fault of a file of a dataset.")]
pub struct Fault {
    /// The file, with the member or the file of the bundle behind it.
    pub path: String,
    pub reason: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path, self.reason)
    }
}

/// The result of a verification.
#[derive(Debug)]
pub struct Verification {
    pub manifest: DatasetManifest,
    /// Empty for an intact dataset.
    pub faults: Vec<Fault>,
    /// Bytes of all files that were read.
    pub bytes: u64,
    /// Of the scenes that could be read, with their splits, in the order of the manifest.
    pub facts: Vec<(SceneFacts, String)>,
}

impl Verification {
    /// The statistics of the scenes as they were read.
    pub fn statistics(&self) -> Statistics {
        let facts: Vec<&SceneFacts> = self.facts.iter().map(|(facts, _)| facts).collect();
        let splits: Vec<String> = self.facts.iter().map(|(_, split)| split.clone()).collect();
        Statistics::of(&facts, &splits, &self.manifest.selection, &self.manifest.splits.plan)
    }
}

/// State of a verification.
struct Check<'a> {
    folder: &'a Path,
    faults: Vec<Fault>,
    bytes: u64,
    /// By id.
    facts: BTreeMap<String, SceneFacts>,
}

/// Verifies the version in `folder`. `notify` is called with the number of scenes done and of all.
///
/// # Errors
///
/// [`DatasetError`] if there is no readable `dataset.json`; every other fault is in the result.
pub fn verify(folder: &Path, notify: &mut dyn FnMut(usize, usize)) -> Result<Verification, DatasetError> {
    let (manifest, digest) = DatasetManifest::read(folder)?;
    let mut check = Check { folder, faults: Vec::new(), bytes: 0, facts: BTreeMap::new() };
    if digest != manifest.digest {
        check.fault(dataset_manifest::PATH, "its digest is not that of its content: it was changed");
    }
    check.list(&manifest)?;
    check.files(&manifest);
    let mut of_path: BTreeMap<&str, Vec<&SceneEntry>> = BTreeMap::new();
    for scene in &manifest.scenes {
        of_path.entry(&scene.path).or_default().push(scene);
    }
    for (path, scenes) in &of_path {
        match manifest.layout {
            Layout::Scenes => check.single(path, scenes),
            Layout::Shards { .. } => check.shard(path, scenes),
        }
        notify(check.facts.len(), manifest.scenes.len());
    }
    check.counts(&manifest);
    check.splits(&manifest);
    let Check { mut faults, bytes, mut facts, .. } = check;
    faults.dedup();
    let in_order = manifest.scenes.iter();
    let facts = in_order.filter_map(|scene| Some((facts.remove(&scene.id)?, scene.split.clone()))).collect();
    Ok(Verification { manifest, faults, bytes, facts })
}

impl Check<'_> {
    fn fault(&mut self, path: impl Into<String>, reason: impl Into<String>) {
        self.faults.push(Fault { path: path.into(), reason: reason.into() });
    }

    /// The files that exist are those of the manifest.
    fn list(&mut self, manifest: &DatasetManifest) -> Result<(), DatasetError> {
        let containers = manifest.scenes.iter().map(|scene| scene.path.as_str());
        let listed = manifest.files.iter().map(|file| file.path.as_str());
        let known: BTreeSet<&str> =
            std::iter::once(dataset_manifest::PATH).chain(containers).chain(listed).collect();
        let found = files::list(self.folder)?;
        for path in found.iter().filter(|path| !known.contains(path.as_str())) {
            self.fault(path, "is no file of the dataset");
        }
        for path in known {
            let is_plain =
                std::fs::symlink_metadata(self.folder.join(path)).is_ok_and(|about| about.is_file());
            if !is_plain {
                self.fault(path, "is missing, or no plain file");
            }
        }
        Ok(())
    }

    /// Size and digest of the listed files. Archives of single scenes are checked with their scene.
    fn files(&mut self, manifest: &DatasetManifest) {
        for file in &manifest.files {
            match files::measure(&self.folder.join(&file.path)) {
                Ok((size, sha256)) => {
                    self.bytes += size;
                    if (size, &sha256) != (file.size, &file.sha256) {
                        let reason =
                            format!("has {size} bytes and SHA-256 {sha256}; {} are listed", file.size);
                        self.fault(&file.path, reason);
                    }
                }
                Err(error) => self.fault(&file.path, error.to_string()),
            }
        }
    }

    fn single(&mut self, path: &str, scenes: &[&SceneEntry]) {
        let bytes = match std::fs::read(self.folder.join(path)) {
            Ok(bytes) => bytes,
            Err(error) => return self.fault(path, error.to_string()),
        };
        self.bytes += bytes.len() as u64;
        for scene in scenes {
            self.compare(path, &bytes, scene.size, &scene.sha256);
            self.scene(path, scene, bytes.clone());
        }
    }

    fn shard(&mut self, path: &str, scenes: &[&SceneEntry]) {
        let file = match File::open(self.folder.join(path)) {
            Ok(file) => file,
            Err(error) => return self.fault(path, error.to_string()),
        };
        let expected = scenes.iter().flat_map(|scene| {
            let members = scene.members.iter();
            members
                .map(|(extension, member)| (format!("{}.{extension}", scene.id), (*scene, extension, member)))
        });
        let order: Vec<(String, (&SceneEntry, &String, &MemberEntry))> = expected.collect();
        let mut missing: BTreeSet<&str> = order.iter().map(|(name, _)| name.as_str()).collect();
        let mut reader = TarReader::new(BufReader::with_capacity(1 << 18, file));
        loop {
            let header = match reader.next_member() {
                Ok(Some(header)) => header,
                Ok(None) => break,
                Err(error) => {
                    self.fault(path, format!("cannot be read as a tar archive: {error}"));
                    break;
                }
            };
            let place = format!("{path}/{}", header.name);
            let known = order.iter().find(|(name, _)| *name == header.name).map(|(_, entry)| *entry);
            let Some((scene, extension, member)) = known.filter(|_| missing.remove(header.name.as_str()))
            else {
                self.fault(&place, "is no member of the shard, or a second one");
                if let Err(error) = reader.skip(&header) {
                    self.fault(path, error.to_string());
                    break;
                }
                continue;
            };
            match self.member(&mut reader, &header, &place, member) {
                Ok(Some(bytes)) if extension == ARCHIVE => self.scene(&place, scene, bytes),
                Ok(_) => {}
                Err(error) => {
                    self.fault(path, error.to_string());
                    break;
                }
            }
        }
        let missing: Vec<String> = missing.into_iter().map(|name| format!("{path}/{name}")).collect();
        missing.into_iter().for_each(|place| self.fault(place, "is missing"));
    }

    /// The content of a member; `None` if its size is not the listed one.
    fn member(
        &mut self,
        reader: &mut TarReader<BufReader<File>>,
        header: &MemberHeader,
        place: &str,
        member: &MemberEntry,
    ) -> std::io::Result<Option<Vec<u8>>> {
        if header.size != member.size {
            self.fault(place, format!("has {} bytes; {} are listed", header.size, member.size));
            return reader.skip(header).map(|()| None);
        }
        let bytes = reader.content(header)?;
        self.compare(place, &bytes, member.size, &member.sha256);
        Ok(Some(bytes))
    }

    fn compare(&mut self, place: &str, bytes: &[u8], size: u64, sha256: &str) {
        if bytes.len() as u64 != size || crate::bundle::sha256(bytes) != sha256 {
            self.fault(place, "its bytes are not those of the manifest");
        }
    }

    /// The bundle in an archive is whole, and is what the manifest states.
    fn scene(&mut self, place: &str, scene: &SceneEntry, archive: Vec<u8>) {
        let size = archive.len() as u64;
        let archive_sha256 = crate::bundle::sha256(&archive);
        let mut bundle = match Bundle::of_archive(Path::new(place), archive) {
            Ok(bundle) => bundle,
            Err(error) => return self.fault(place, error.to_string()),
        };
        let facts = match bundle.check().and_then(|()| SceneFacts::read(&mut bundle)) {
            Ok(facts) => facts,
            Err(error) => return self.fault(place, error.to_string()),
        };
        let copies = COPIES.iter().filter_map(|(extension, path)| {
            let of_bundle = bundle.entries().get(*path).map(|entry| (entry.size, entry.sha256.as_str()));
            let of_member = scene.members.get(*extension).map(|entry| (entry.size, entry.sha256.as_str()));
            let has_members = !scene.members.is_empty();
            (has_members && of_bundle != of_member).then_some(*extension)
        });
        let copies: Vec<&str> = copies.collect();
        let claims = [
            ("id", scene.id == facts.id),
            ("size or sha256", scene.size == size && scene.sha256 == archive_sha256),
            ("manifest_sha256", scene.manifest_sha256 == facts.manifest_sha256),
            ("verdict", scene.verdict == if facts.passed() { "pass" } else { "quarantine" }),
            ("objects", scene.objects == facts.objects.len()),
            ("categories", scene.categories == facts.categories()),
            ("parent, text_sha256, image_sha256 or mesh_sha256", scene.shares == Shareable::of(&facts)),
            ("members", copies.is_empty()),
        ];
        for (claim, _) in claims.iter().filter(|(_, holds)| !holds) {
            self.fault(place, format!("the bundle is not what dataset.json states as {claim}"));
        }
        if self.facts.insert(scene.id.clone(), facts).is_some() {
            self.fault(place, "the scene occurs twice");
        }
    }

    fn counts(&mut self, manifest: &DatasetManifest) {
        let mut splits: BTreeMap<String, usize> =
            manifest.splits.plan.ratios.iter().map(|split| (split.name.clone(), 0)).collect();
        for scene in &manifest.scenes {
            *splits.entry(scene.split.clone()).or_default() += 1;
        }
        let counts = &manifest.counts;
        let groups: BTreeSet<&str> = manifest.scenes.iter().map(|scene| scene.group.as_str()).collect();
        let objects: usize = manifest.scenes.iter().map(|scene| scene.objects).sum();
        let claims = [
            ("counts/scenes", counts.scenes == manifest.scenes.len()),
            ("counts/objects", counts.objects == objects),
            ("counts/groups", counts.groups == groups.len()),
            ("counts/splits", counts.splits == splits),
            ("scenes", self.facts.len() == manifest.scenes.len()),
        ];
        for (claim, _) in claims.iter().filter(|(_, holds)| !holds) {
            self.fault(format!("{}#/{claim}", dataset_manifest::PATH), "is not the number of what was found");
        }
    }

    /// No leakage, each scene in the shard of its split, and the assignment is that of the seed.
    fn splits(&mut self, manifest: &DatasetManifest) {
        // What bundles say counts; for a scene that cannot be read, what the manifest says.
        let scenes: Vec<(Shareable, String)> = manifest
            .scenes
            .iter()
            .map(|scene| {
                let found = self.facts.get(&scene.id).map(Shareable::of);
                (found.unwrap_or_else(|| scene.shares.clone()), scene.split.clone())
            })
            .collect();
        let rules = &manifest.splits.leakage_rules;
        for leak in leakage::leaks(&scenes, rules) {
            self.fault(dataset_manifest::PATH, format!("leakage: {leak}"));
        }
        for scene in &manifest.scenes {
            let is_shard = matches!(manifest.layout, Layout::Shards { .. });
            if is_shard && !scene.path.starts_with(&format!("shards/{}-", scene.split)) {
                self.fault(&scene.path, format!("holds {} of the split {}", scene.id, scene.split));
            }
        }
        if manifest.splits.method != splits::METHOD {
            return;
        }
        let shares: Vec<Shareable> = scenes.iter().map(|(shares, _)| shares.clone()).collect();
        let groups = splits::groups(&shares, rules);
        let earlier = manifest.scenes.iter();
        let earlier =
            earlier.filter_map(|scene| Some((scene.id.clone(), scene.earlier_split.clone()?))).collect();
        let assigned = splits::assign(&groups, &manifest.splits.plan, &earlier);
        let mut expected: BTreeMap<&str, (String, &str)> = BTreeMap::new();
        for (group, split) in groups.iter().zip(&assigned) {
            for id in group.scenes() {
                expected.insert(id, (group.name(), split));
            }
        }
        for scene in &manifest.scenes {
            let place = format!("{}#/scenes/{}", dataset_manifest::PATH, scene.id);
            let Some((group, split)) = expected.get(scene.id.as_str()) else { continue };
            if scene.split != *split {
                self.fault(&place, format!("is in the split {}; seed and ratios give {split}", scene.split));
            }
            if scene.group != *group {
                self.fault(
                    &place,
                    format!("is in the group {}; the leakage rules give {group}", scene.group),
                );
            }
        }
    }
}
