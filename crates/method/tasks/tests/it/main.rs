//! Tasks in made scenes: reading, validation, proposals, files.

mod files;
mod made_scene;
mod proposals;
mod text;
mod validation;
