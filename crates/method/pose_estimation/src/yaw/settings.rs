//! Settings of the yaw estimation (DRO).

use serde::{Deserialize, Serialize};

/// Search effort and weights of [`estimate_yaw`](super::estimate_yaw).
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct YawSettings {
    /// Search method.
    pub solver: YawSolver,
    /// Weight of the silhouette term, 0..; the paper's 0.5.
    pub silhouette_weight: f64,
    /// Weight of the edge term, 0..; the paper's 0.5.
    pub edge_weight: f64,
    /// Weight of the classical descriptor's distance (0..2, usually below 1) in the loss where `solver` is
    /// [`YawSolver::Paper`] and an image is given, 0..; 0 leaves colors to the choice among equal outlines. The paper's
    /// 2.0 is for DINOv2's features. 0.1 tells a book's sides apart and leaves the dozen objects of
    /// `yaw/tests/solvers.rs` off by as much in the median as without; which weight is best was not searched for.
    pub descriptor_weight: f64,
    /// Yaws of the coarse search, 8..720, evenly spaced over a turn; the paper's 72.
    pub coarse_yaws: u32,
    /// Coarse candidates that are refined, 1..; the paper's 8. Golden sections begin at minima only, of which there
    /// may be fewer.
    pub keep: u32,
    /// Side of the square crop in the coarse search of golden sections, pixels, a multiple of 32.
    pub coarse_px: u32,
    /// Side of the square crop in the refinement, and wherever `solver` is [`YawSolver::Paper`], pixels, a
    /// multiple of 32; the paper's 256.
    pub fine_px: u32,
    /// Width of the interval at which golden sections stop, radians; less costs a silhouette per factor 1.6.
    pub tolerance_rad: f64,
    /// Blur of the silhouette where `solver` is [`YawSolver::Paper`], squared pixels of the fine crop,
    /// above 0; more pulls from farther away and blurs thin parts. 1.6 is the 1e-4 usual in PyTorch3D at
    /// 256 pixels.
    pub soft_sigma_px2: f64,
    /// Detail of the silhouette: vertices closer than the mesh's largest extent divided by this are
    /// merged when there are more than 20,000 triangles.
    pub outline_cells: u32,
    /// Spread of the loss curve below which any yaw is as good, loss units; more calls more objects round.
    pub flat_spread: f64,
    /// Deviation of the loss curve from its shifted copy, as a share of its spread, up to which it counts
    /// as periodic; more calls more objects symmetric.
    pub periodic_share: f64,
    /// Loss above the best up to which an outline counts as the same and colors decide, among minima and along
    /// stretches; more lets colors overrule worse outlines.
    pub same_outline: f64,
    /// Weight of the disagreement of colors (0..2) and of edges (0..1) against the loss among such outlines.
    pub appearance_weight: f64,
    /// Difference of color disagreement below which two poses count as equal; larger values report more objects as
    /// symmetric. The yaw is the one colors prefer in any case.
    pub flat_appearance: f64,
    /// Whether a camera that a model judged is refined first, by the silhouettes of the table and of all objects;
    /// cameras that are known or measured stay.
    pub refine_camera: bool,
    /// Loss of outlines without overlap: confidence 0.
    pub hopeless_loss: f64,
    /// Lead over the next pose at which the lead counts for one half, loss units.
    pub clear_lead: f64,
}

/// Search method of a yaw.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum YawSolver {
    /// Golden sections on hard silhouettes.
    Golden,
    /// The paper's: Adam on soft silhouettes.
    Paper,
}
