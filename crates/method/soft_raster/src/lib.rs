//! A differentiable soft rasterizer: blurred silhouettes and colors of a projected mesh, with their derivatives by a
//! few parameters (yaw, azimuth, elevation, field of view).
//!
//! Method: Liu et al., "Soft Rasterizer" (ICCV 2019), eq. 1: coverage `D = sigmoid(+-d^2 / sigma)`, plus inside, with
//! `d` the distance of the pixel center to the primitive's boundary, pixels. Derivatives use forward mode: one
//! parameter, one more plane.
//!
//! In the paper the primitive is the triangle, and eq. 3 aggregates `S = 1 - prod(1 - D_j)`. On a fine mesh that has
//! two faults. At an edge inside the object every face has D = 1/2, so the product dents. Beyond the outline every
//! triangle within reach contributes, front and back, so the outline moves out with the number of triangles, and the
//! Sobel image shows the mesh instead of the object. Here the primitive is the union of all triangles: `d` is the
//! distance to its outline, and the product has one factor. For a single triangle both definitions are the same
//! function. The result does not depend on the triangulation. As sigma goes to 0 it goes to 1 at pixel centers inside
//! the silhouette and to 0 outside.
//!
//! Steps: the hard image (fill.rs), the outline cut exactly at occlusions (outline.rs, crossing.rs), the distance to
//! it within reach (band.rs); loss.rs compares with a mask. The derivative is that of the distance to the outline's
//! nearest point, which moves with the vertices or, where two lines cross, with both. The set of outline pieces is not
//! differentiated: the coverage is continuous where the set changes, except where the last of a gap or hole closes;
//! inside such a gap's blur it jumps.
//!
//! Inputs: vertices in pixel coordinates (pixel centers at .5), f32. Guarantees: the same bits with any number of
//! threads; within 1e-3 of [`mod@reference`]; cut off where the sigmoid is within 1e-4 of 0 or 1. Cost: 1 to 1.5 ms of
//! a slow core for 5,000 triangles, closed, on 256 x 256 pixels, about 1 ms more for open meshes. Unsuitable for
//! parts, or gaps, thinner than sqrt(sigma): at their outline the coverage is 1/2 whatever their width, so they appear
//! about sqrt(sigma) wide. The coverage inside the outline is one; [`color`] renders its colors.
//!
//! The crate depends on meshes and images only. It must not depend on the renderer, on scenes or on pose estimation.
//!
//! A silhouette and its derivative with respect to a shift along x:
//!
//! ```
//! use soft_raster::{Grid, MovingPoint, SoftSilhouette, Surface};
//!
//! let surface = Surface::new(&[[0, 1, 2]]);
//! let corners = [[8.0, 8.0], [24.0, 8.0], [16.0, 24.0]];
//! let points = corners.map(|at_px| MovingPoint { at_px, slopes: [[1.0, 0.0]] });
//! let mut silhouette = SoftSilhouette::<1>::default();
//! silhouette.draw(&surface, &points, Grid::square(32), 1.0);
//! let pixel = |x: usize, y: usize| y * silhouette.grid().width_px() + x;
//! // Inside the triangle the coverage is 1, far outside 0.
//! assert!(silhouette.coverage()[pixel(16, 12)] > 0.99);
//! assert_eq!(silhouette.coverage()[pixel(2, 28)], 0.0);
//! // At the left edge a shift to the right uncovers the pixel: the derivative is negative there.
//! assert!(silhouette.slopes()[0][pixel(10, 12)] < 0.0);
//! ```

mod band;
mod bins;
mod color_discontinuities;
pub mod color;
mod crossing;
mod fill;
mod inside;
pub mod loss;
mod nearest;
mod outline;
mod shading;
pub mod reference;
mod surface;

pub use shading::ShadingMaterials;
pub use surface::Surface;

/// Number of adjacent pixels of a row that are computed together.
pub const BLOCK_PX: usize = 8;

/// A projected vertex with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingPoint<const N: usize> {
    /// Position, pixels: x to the right, y down.
    pub at_px: [f32; 2],
    /// Derivative of the position with respect to each parameter, pixels per unit of the parameter.
    pub slopes: [[f32; 2]; N],
}

/// Size of an image. Its width is whole blocks of [`BLOCK_PX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    pub blocks_across: usize,
    pub height_px: usize,
}

impl Grid {
    /// A square image, its side rounded up to whole blocks.
    pub fn square(side_px: usize) -> Self {
        let blocks_across = side_px.div_ceil(BLOCK_PX);
        Self { blocks_across, height_px: blocks_across * BLOCK_PX }
    }

    pub fn width_px(self) -> usize {
        self.blocks_across * BLOCK_PX
    }

    pub fn pixels(self) -> usize {
        self.width_px() * self.height_px
    }
}

/// A soft silhouette with its working memory; reuse it to save allocations.
#[derive(Debug)]
pub struct SoftSilhouette<const N: usize> {
    grid: Grid,
    coverage: Vec<f32>,
    slopes: [Vec<f32>; N],
    near_outline: Vec<bool>,
    /// Squared distance to the outline where within reach, pixels^2.
    nearest_px2: Vec<f32>,
    /// For each triangle: whether it is clockwise on the screen.
    clockwise: Vec<bool>,
    fill: fill::Fill,
    outline: outline::Outline<N>,
}

impl<const N: usize> Default for SoftSilhouette<N> {
    fn default() -> Self {
        Self {
            grid: Grid { blocks_across: 0, height_px: 0 },
            coverage: Vec::new(),
            slopes: std::array::from_fn(|_| Vec::new()),
            near_outline: Vec::new(),
            nearest_px2: Vec::new(),
            clockwise: Vec::new(),
            fill: fill::Fill::default(),
            outline: outline::Outline::default(),
        }
    }
}

impl<const N: usize> SoftSilhouette<N> {
    /// Draws the surface with its vertices at `points` and replaces the previous content. `sigma_px2` is the blur,
    /// above 0: the coverage falls from 1/2 to 1/4 within 1.05 sqrt(sigma). Smaller values are sharper and have
    /// derivatives on fewer pixels; PyTorch3D's default 1e-4 is 1.6 pixels^2 on 256 x 256.
    pub fn draw(&mut self, surface: &Surface, points: &[MovingPoint<N>], grid: Grid, sigma_px2: f32) {
        if self.grid != grid {
            *self = Self { grid, ..Self::default() };
        }
        surface.find_clockwise(points, &mut self.clockwise);
        self.fill.count(surface, points, &self.clockwise, grid);
        self.coverage.clear();
        self.coverage.extend(self.fill.layers().iter().map(|&layers| if layers != 0 { 1.0 } else { 0.0 }));
        let seen = outline::LayeredSurface { surface, points, clockwise: &self.clockwise, fill: &self.fill };
        self.outline.trace(&seen, grid, band::reach_px(sigma_px2));
        self.clear_planes();
        band::soften(
            self.outline.pieces(),
            grid,
            sigma_px2,
            band::Planes {
                coverage: &mut self.coverage,
                slopes: self.slopes.each_mut().map(Vec::as_mut_slice),
                nearest_px2: &mut self.nearest_px2,
                near_outline: &mut self.near_outline,
            },
        );
    }

    /// Resets the planes near the last outline; elsewhere they are unchanged but for the coverage.
    fn clear_planes(&mut self) {
        let grid = self.grid;
        self.nearest_px2.resize(grid.pixels(), f32::INFINITY);
        self.slopes.iter_mut().for_each(|plane| plane.resize(grid.pixels(), 0.0));
        for (block, near) in self.near_outline.iter_mut().enumerate().filter(|(_, near)| **near) {
            let pixels = block * BLOCK_PX..(block + 1) * BLOCK_PX;
            self.nearest_px2[pixels.clone()].fill(f32::INFINITY);
            self.slopes.iter_mut().for_each(|plane| plane[pixels.clone()].fill(0.0));
            *near = false;
        }
        self.near_outline.resize(grid.blocks_across * grid.height_px, false);
    }

    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// 0..1, row-major.
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    /// Derivatives of the coverage, one plane per parameter, row-major.
    pub fn slopes(&self) -> &[Vec<f32>; N] {
        &self.slopes
    }

    /// For each block of a row: whether the outline is within reach. Elsewhere coverage is 0 or 1 throughout the block
    /// and the slopes are 0. Row-major.
    pub fn near_outline(&self) -> &[bool] {
        &self.near_outline
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod turntable;
