//! Settings that requests may change: declared here for the options that hold them, described by `config`, which knows
//! them.

/// Settings of a scene by name, as text.
#[derive(Default)]
pub struct SceneSettings;
