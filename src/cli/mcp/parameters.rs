//! Parameters of the tools, whose descriptions an assistant reads.

use schemars::JsonSchema;
use serde::Deserialize;

/// Of `generate`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Generate {
    /// Name of the new scene: letters, digits, _ and -.
    pub scene: String,
    /// The table and the objects on it, such as "A round table with a teapot, two mugs and a bowl of apples".
    pub text: String,
    /// The same text and seed make the same scene.
    pub seed: Option<u64>,
    /// Refuse a scene of more objects, 1 to 64.
    pub max_objects: Option<u32>,
}

/// Of `parse`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parse {
    /// A description, as `generate` takes it.
    pub text: String,
}

/// Of `edit`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// Name of the finished scene.
    pub scene: String,
    /// The change, such as "move the mug to the left of the bowl".
    pub text: String,
    /// Name of the scene that is made; the old one stays as it is.
    pub new_scene: String,
    /// The same change and seed make the same scene.
    pub seed: Option<u64>,
}

/// Of `variants`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variants {
    /// Name of the finished scene.
    pub scene: String,
    /// Name of the folder of the variants.
    pub new_scenes: String,
    /// Number of variants.
    #[schemars(range(min = 1, max = 1000))]
    pub count: u32,
    /// Some of layout, meshes, sizes, colors, materials, table, light, camera, mass, friction; all without it.
    pub vary: Option<Vec<String>>,
    pub seed: Option<u64>,
}

/// Of `inspect`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inspect {
    /// Name of the scene; of a variant `FOLDER/NAME`, as `list` names it.
    pub scene: String,
}

/// Of `tasks`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tasks {
    pub scene: String,
    /// Read this instruction in place of proposing tasks.
    pub text: Option<String>,
    /// Number of proposals.
    #[schemars(range(min = 1, max = 100))]
    pub count: Option<u32>,
    /// `panda` (the default) or `piper`.
    pub robot: Option<String>,
    /// Try grasps and motions in simulation, which takes seconds; else propose by shapes and weights alone.
    #[serde(default)]
    pub rehearse: bool,
}

/// Of `execute`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Execute {
    pub scene: String,
    /// An instruction in words, such as "put the mug on the plate".
    pub task: String,
    /// `panda` (the default) or `piper`.
    pub robot: Option<String>,
    /// Name of the folder for verdict, motion and the robot in the scene.
    pub out: String,
    /// Also write a video.
    #[serde(default)]
    pub video: bool,
    pub seed: Option<u64>,
}

/// Of `episodes`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Episodes {
    pub scene: String,
    /// An instruction in words.
    pub task: String,
    /// Number of episodes that succeed.
    #[schemars(range(min = 1, max = 10000))]
    pub count: u32,
    /// Name of the folder for the dataset.
    pub out: String,
    /// `panda` (the default) or `piper`.
    pub robot: Option<String>,
    pub seed: Option<u64>,
}
