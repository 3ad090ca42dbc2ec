//! Bundles of finished requests: `DIR/CUSTOM_ID/`, or `DIR/CUSTOM_ID.zip`.
//!
//! A bundle is written below `DIR/.partial/` and then renamed, so that what has its name is whole.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use futures::TryStreamExt;

use crate::cli::backup::failed;
use crate::cli::output::{Kind, Output};
use crate::cli::scene_summary::{Outcome, Place, Target};
use crate::cli::{Exit, Failure};
use store::scenes::SceneRow;
use store::{DEFAULT_TENANT, Digest, Store};

const PARTIAL: &str = ".partial";
const MANIFEST: &str = "manifest.json";

/// Writes bundles.
pub(super) struct Bundles {
    out: PathBuf,
    as_archives: bool,
    /// Whether the bundle of another request may be replaced.
    is_forced: bool,
}

impl Bundles {
    /// Removes what a run that was stopped left half written.
    pub(super) fn new(out: &Path, as_archives: bool, is_forced: bool) -> Result<Self, Failure> {
        let bundles = Self { out: out.to_owned(), as_archives, is_forced };
        remove(&out.join(PARTIAL))?;
        Ok(bundles)
    }

    /// Refuses a request that is to be made if a bundle of another one has its name.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of kind usage.
    pub(super) fn check_free(&self, custom_id: &str) -> Result<(), Failure> {
        let place = self.place(custom_id);
        if self.is_forced || !place.exists() { Ok(()) } else { Err(occupied(&place)) }
    }

    fn place(&self, custom_id: &str) -> PathBuf {
        let ending = if self.as_archives { ".zip" } else { "" };
        self.out.join(format!("{custom_id}{ending}"))
    }

    /// Writes the bundle of a finished scene unless it is there; returns its name in the folder of the batch, or
    /// `None` if the scene has no bundle any more.
    pub(super) async fn write(
        &self,
        store: &Store,
        custom_id: &str,
        scene: &SceneRow,
    ) -> Result<Option<String>, Failure> {
        if self.as_archives {
            return self.write_archive(store, custom_id, scene).await;
        }
        let place = self.place(custom_id);
        if let Ok(present) = std::fs::read(place.join(MANIFEST)) {
            let files = store.bundle_files(&DEFAULT_TENANT, &scene.id).await.map_err(failed)?;
            let listed = files.iter().find(|file| file.name == MANIFEST);
            if listed.is_some_and(|file| file.digest == Digest::of(&present)) {
                return Ok(Some(custom_id.to_owned()));
            }
        }
        self.check_free(custom_id)?;
        let archive = store.archive(&DEFAULT_TENANT, &scene.id, "all").await.map_err(failed)?;
        let Some(archive) = archive else { return Ok(None) };
        if !store.blobs().contains(&archive.digest).await.map_err(failed)? {
            return Ok(None);
        }
        let partial = self.out.join(PARTIAL);
        let output = Output::check(&place, Kind::Bundle, self.is_forced, &[])?.with_partials_in(&partial);
        let target = Target { place: Place::Named(output), artifacts: false };
        Outcome::write(store, scene, 0, Vec::new(), target).await?;
        remove(&partial)?;
        Ok(Some(custom_id.to_owned()))
    }

    async fn write_archive(
        &self,
        store: &Store,
        custom_id: &str,
        scene: &SceneRow,
    ) -> Result<Option<String>, Failure> {
        let name = format!("{custom_id}.zip");
        let place = self.place(custom_id);
        let archive = store.archive(&DEFAULT_TENANT, &scene.id, "all").await.map_err(failed)?;
        let Some(archive) = archive else { return Ok(None) };
        if std::fs::metadata(&place).is_ok_and(|about| about.len() == archive.size) {
            let present = std::fs::read(&place).map_err(|error| unwritable(&place, &error))?;
            if Digest::of(&present) == archive.digest {
                return Ok(Some(name));
            }
        }
        self.check_free(custom_id)?;
        let Some(mut parts) = store.blobs().stream(&archive.digest, None).await.map_err(failed)? else {
            return Ok(None);
        };
        let partial = self.out.join(PARTIAL);
        std::fs::create_dir_all(&partial).map_err(|error| unwritable(&partial, &error))?;
        let path = partial.join(&name);
        let unwritable_part = |error: std::io::Error| unwritable(&path, &error);
        let mut file = File::create(&path).map_err(unwritable_part)?;
        while let Some(part) = parts.try_next().await.map_err(failed)? {
            file.write_all(&part).map_err(unwritable_part)?;
        }
        file.sync_all().map_err(unwritable_part)?;
        std::fs::rename(&path, &place).map_err(|error| unwritable(&place, &error))?;
        remove(&partial)?;
        Ok(Some(name))
    }
}

fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_dir_all(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::new(Exit::Error, format!("cannot remove {}: {error}", path.display())))
        }
        _ => Ok(()),
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Error, format!("cannot write {}: {error}", path.display()))
}

fn occupied(path: &Path) -> Failure {
    let advice = "name another folder with --out, or add --force to replace it";
    Failure::usage(format!(
        "{} exists and is not the bundle of the request of this name; {advice}",
        path.display()
    ))
}
