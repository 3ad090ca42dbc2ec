//! Settings of the writers: section `[export]`.

use serde::{Deserialize, Serialize};

/// Settings of the exported files. The defaults are in `config/default.toml`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ExportSettings {
    /// Author named in asset metadata; any text.
    pub author: String,
    /// SPDX identifier of the licence of the bundle's own files and of assets that name none.
    pub licence: String,
    /// Date written into asset metadata, `YYYY-MM-DD`. It is a setting, because bundles must not depend on the clock.
    pub date: String,
    /// Gravity of the simulation files, m/s^2, positive downward.
    pub gravity_m_s2: f64,
    /// Step of the MJCF file, seconds, 0.0005..0.005; smaller is stiffer and slower.
    pub mujoco_timestep_s: f64,
    /// MuJoCo's ratio of frictional to normal constraint impedance, 1..100; larger creeps less and
    /// converges more slowly.
    pub mujoco_impratio: f64,
    /// Form of the USD files.
    pub usd: UsdForm,
    /// Paths of meshes in the URDF files.
    pub urdf: UrdfPaths,
    /// Intensity of the USD dome light; brighter is larger.
    pub usd_dome_intensity: f64,
    /// Intensity of the USD sun.
    pub usd_sun_intensity: f64,
}

/// Paths of meshes in the URDF files.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum UrdfPaths {
    /// Relative to the file.
    Relative,
    /// `package://`; the folder is a ROS 2 package.
    Ros2,
}

/// File format of the USD layers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum UsdForm {
    /// Every layer as text.
    Usda,
    /// Layers with meshes in the crate format, which is smaller and opens faster; the stage as text.
    Usdc,
    /// Everything in one package.
    Usdz,
}
