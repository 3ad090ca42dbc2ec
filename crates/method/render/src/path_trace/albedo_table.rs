//! Share of light that a GGX surface reflects, by cosine and roughness, integrated once.
//!
//! The share of a surface with reflectance `f0` at normal incidence is `f0 * scale + offset` for single reflections
//! (Karis 2013). What is left of a white surface has been reflected more than once; it is given back as a factor
//! (Turquin, "Practical multiple scattering compensation for microfacet models", 2019).

use std::sync::LazyLock;

use glam::{Vec2, Vec3A};

use super::ggx::Ggx;

/// Nodes of cosine and of roughness.
const SIDE: usize = 32;
/// Samples of a node along each side of a grid.
const GRID: usize = 24;

/// Factor and addend on the reflectance at normal incidence.
pub type SplitSum = Vec2;

/// Shares by roughness and cosine.
pub struct AlbedoTable {
    /// Row by row of one roughness.
    nodes: Vec<SplitSum>,
    /// Cosine-weighted means of each roughness.
    means: Vec<SplitSum>,
}

/// The table of GGX, made on first use by one thread, as [`crate::forward::environment_map::FURNISHED_ROOM`] is.
pub static GGX_ALBEDO: LazyLock<AlbedoTable> = LazyLock::new(AlbedoTable::new);

impl AlbedoTable {
    fn new() -> Self {
        let nodes: Vec<SplitSum> = (0..SIDE * SIDE)
            .map(|k| {
                let at = |k: usize| k as f32 / (SIDE - 1) as f32;
                integrated(at(k / SIDE), (at(k % SIDE) * at(k % SIDE)).max(1e-3))
            })
            .collect();
        let mean = |row: usize| {
            const STEPS: usize = 256;
            let cosine = |k: usize| (k as f32 + 0.5) / STEPS as f32;
            let at =
                |k: usize| 2.0 * cosine(k) * along(&nodes[row * SIDE..][..SIDE], place(cosine(k).sqrt()));
            (0..STEPS).map(at).sum::<SplitSum>() / STEPS as f32
        };
        let means = (0..SIDE).map(mean).collect();
        Self { nodes, means }
    }

    /// Split sum at a cosine.
    pub fn at(&self, cosine: f32, roughness: f32) -> SplitSum {
        let (row, t) = place(roughness);
        // Nodes are denser near the horizon, where the shares change fast.
        let column = place(cosine.sqrt());
        let of_row = |row: usize| along(&self.nodes[row * SIDE..][..SIDE], column);
        of_row(row).lerp(of_row(row + 1), t)
    }

    /// Cosine-weighted mean over the hemisphere.
    pub fn mean(&self, roughness: f32) -> SplitSum {
        along(&self.means, place(roughness))
    }
}

/// Node before a number in 0..1, and the share of the way to the next.
fn place(x: f32) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (SIDE - 1) as f32;
    let node = (x as usize).min(SIDE - 2);
    (node, x - node as f32)
}

fn along(nodes: &[SplitSum], (node, t): (usize, f32)) -> SplitSum {
    nodes[node].lerp(nodes[node + 1], t)
}

fn integrated(roughness: f32, cosine: f32) -> SplitSum {
    let ggx = Ggx::new(roughness.max(0.02));
    let v = Vec3A::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let mut sum = SplitSum::ZERO;
    for k in 0..GRID * GRID {
        let u = (Vec2::new((k % GRID) as f32, (k / GRID) as f32) + 0.5) / GRID as f32;
        let h = ggx.visible_normal(v, u);
        let l = 2.0 * v.dot(h) * h - v;
        if l.z > 0.0 {
            let weight = ggx.visible_from_both(v.z, l.z) / ggx.visible(v.z);
            let grazing = (1.0 - v.dot(h)).clamp(0.0, 1.0).powi(5);
            sum += weight * SplitSum::new(1.0 - grazing, grazing);
        }
    }
    sum / (GRID * GRID) as f32
}
