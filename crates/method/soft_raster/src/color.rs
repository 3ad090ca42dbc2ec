//! Soft color images with derivatives: the nearest surface's texture under a studio light, faded in from the soft
//! outline, and its derivatives by a few parameters.
//!
//! Method: the color aggregation of Liu et al., "Soft Rasterizer" (ICCV 2019), eq. 2, with the nearest face alone: the
//! hard image's color inside, since mixing in hidden faces makes solid objects transparent. For a pixel whose center
//! the surface covers, with mean soft coverage S over its square,
//!
//! - weight `T = max(0, 2 S - 1)`: 0 on the outline and beyond, 1 away from it inside, so that no color is needed
//!   outside, and nothing jumps as the outline passes a pixel;
//! - color `sqrt(albedo * (ground + (sky - ground) * (1 + n.up) / 2 + key * max(0, n.l)))`: Lambert and a hemisphere,
//!   n interpolated between the corners. The square root of linear light is close to the sRGB encoding, and cheap.
//!
//! The stored value is `T * color`, premultiplied: over a background B the image is `T * color + (1 - T) * B`.
//!
//! Derivatives use forward mode, one parameter, one more plane per channel. They are those of the surface point seen
//! through the fixed pixel: perspective-correct coordinates of the moving triangle there, texture by u, v and level
//! (shading.rs), normal and light. At color discontinuities inside the object (an occlusion, the border of a material)
//! the two colors are mixed by the share that the nearer one's edge covers (color_discontinuities.rs), and the edge's
//! motion is part of the derivative.
//!
//! Inputs: vertices in pixels as for the silhouette, their reciprocal depths (any unit), the light's directions in the
//! mesh's frame. `shrink` pixels of the silhouette, squared, make one of the image. Guarantees: the same bits always;
//! for the agreement with [`super::reference::color`] see the tests. Cost: a pass over the triangles, and one over the
//! covered pixels, which is the larger. The images have no shadows, gloss or glass and are not meant for display.

use glam::{Vec2, Vec3};

use super::color_discontinuities::{ColorDiscontinuities, Mixture};
use super::nearest::{NOTHING, Nearest};
use super::shading::ShadingMaterials;
use super::{BLOCK_PX, Grid, MovingPoint, SoftSilhouette, Surface};

/// The studio's key, ceiling and floor, as light on a white surface.
pub(super) const KEY: f32 = 0.55;
pub(super) const SKY: f32 = 0.53;
pub(super) const GROUND: f32 = 0.24;

/// Linear light below which the root is bent, so that black has a derivative.
pub(super) const DARK: f32 = 1e-4;

/// Differences of color up to which pixels need no mixing.
const FAINT: f32 = 0.01;

/// Red, green, blue and weight.
pub const CHANNELS: usize = 4;

/// A vertex's reciprocal depth and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingKey<const N: usize> {
    pub key: f32,
    pub slopes: [f32; N],
}

/// A unit vector in the mesh's frame and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingDirection<const N: usize> {
    pub at: Vec3,
    pub slopes: [Vec3; N],
}

/// A fixed studio in the frame of the turning mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudioLight<const N: usize> {
    pub toward_key: MovingDirection<N>,
    pub up: MovingDirection<N>,
}

/// Input of a soft image: a surface with its silhouette, shading, vertices and light.
pub struct ColorInput<'a, const N: usize> {
    pub surface: &'a Surface,
    /// Of the silhouette's vertices, in its pixels.
    pub points: &'a [MovingPoint<N>],
    pub keys: &'a [MovingKey<N>],
    /// Of the surface's triangles.
    pub shading: &'a ShadingMaterials,
    pub light: &'a StudioLight<N>,
    pub silhouette: &'a SoftSilhouette<N>,
    /// Silhouette pixels along a pixel of the image, 1..
    pub shrink: usize,
}

/// A soft image, premultiplied; keep it to save allocations.
#[derive(Debug)]
pub struct SoftImage<const N: usize> {
    grid: Grid,
    planes: [Vec<f32>; CHANNELS],
    slopes: [[Vec<f32>; CHANNELS]; N],
    /// Of each block of a row: whether any weight is above 0.
    shown: Vec<bool>,
    nearest: Nearest,
    scaled: Vec<MovingPoint<N>>,
    color_discontinuities: ColorDiscontinuities,
    mixed: Vec<ColorMix<N>>,
}

/// Correction of a pixel's color at a discontinuity.
#[derive(Debug)]
struct ColorMix<const N: usize> {
    pixel: usize,
    color: Vec3,
    slopes: [Vec3; N],
}

impl<const N: usize> Default for SoftImage<N> {
    fn default() -> Self {
        Self {
            grid: Grid { blocks_across: 0, height_px: 0 },
            planes: Default::default(),
            slopes: std::array::from_fn(|_| Default::default()),
            shown: Vec::new(),
            nearest: Nearest::default(),
            scaled: Vec::new(),
            color_discontinuities: ColorDiscontinuities::default(),
            mixed: Vec::new(),
        }
    }
}

impl<const N: usize> SoftImage<N> {
    /// An image from given planes: premultiplied red, green, blue (square roots of linear light) and weight, and their
    /// derivatives; row-major, `grid.pixels()` each.
    pub fn of_planes(grid: Grid, planes: [Vec<f32>; CHANNELS], slopes: [[Vec<f32>; CHANNELS]; N]) -> Self {
        let seen = |block: &[f32]| block.iter().any(|weight| *weight > 0.0);
        let shown = planes[CHANNELS - 1].chunks(BLOCK_PX).map(seen).collect();
        Self { grid, planes, slopes, shown, ..Self::default() }
    }

    /// Draws the image and replaces the previous content. The silhouette's sides must be whole numbers of blocks of
    /// the shrunk image; the remainder is cut off.
    pub fn draw(&mut self, rendered: &ColorInput<N>) {
        let (fine, shrink) = (rendered.silhouette.grid(), rendered.shrink.max(1));
        self.grid = Grid { blocks_across: fine.blocks_across / shrink, height_px: fine.height_px / shrink };
        let (grid, pixels) = (self.grid, self.grid.pixels());
        for plane in self.planes.iter_mut().chain(self.slopes.iter_mut().flatten()) {
            plane.clear();
            plane.resize(pixels, 0.0);
        }
        self.shown.clear();
        self.shown.resize(grid.blocks_across * grid.height_px, false);
        let per_shrink = 1.0 / shrink as f32;
        self.scaled.clear();
        self.scaled.extend(rendered.points.iter().map(|point| MovingPoint {
            at_px: point.at_px.map(|c| c * per_shrink),
            slopes: point.slopes.map(|slope| slope.map(|c| c * per_shrink)),
        }));
        let key = |v: u32| rendered.keys[v as usize].key;
        self.nearest.draw(&rendered.surface.triangles, &self.scaled, key, grid);
        self.color(rendered);
        self.soften_discontinuities(rendered);
        self.premultiply();
    }

    /// Weight and color of each pixel that shows a triangle, not yet multiplied.
    fn color(&mut self, rendered: &ColorInput<N>) {
        let grid = self.grid;
        let mut seen: Option<ScreenFace<N>> = None;
        for (y, x) in (0..grid.height_px).flat_map(|y| (0..grid.width_px()).map(move |x| (y, x))) {
            let at = y * grid.width_px() + x;
            let number = self.nearest.faces[at];
            if number == NOTHING {
                continue;
            }
            let (weight, weight_slopes) = weight(rendered.silhouette, x, y, rendered.shrink);
            let face = match &seen {
                Some(face) if face.number == number => face,
                _ => &*seen.insert(ScreenFace::new(rendered, &self.scaled, number)),
            };
            let (color, color_slopes) = face.color(rendered, Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            self.shown[at / BLOCK_PX] = true;
            for (plane, value) in self.planes.iter_mut().zip(color.extend(weight).to_array()) {
                plane[at] = value;
            }
            for k in 0..N {
                let slope = color_slopes[k].extend(weight_slopes[k]).to_array();
                for (plane, value) in self.slopes[k].iter_mut().zip(slope) {
                    plane[at] = value;
                }
            }
        }
    }

    /// Mixes the colors of pixels beside color discontinuities, all from what they were before.
    fn soften_discontinuities(&mut self, rendered: &ColorInput<N>) {
        let silhouette = rendered.silhouette;
        self.color_discontinuities.find(
            rendered.surface,
            rendered.shading,
            &silhouette.clockwise,
            silhouette.fill.steps(),
        );
        self.mixed.clear();
        let (planes, slopes, mixed) = (&self.planes, &self.slopes, &mut self.mixed);
        let color =
            |planes: &[Vec<f32>; CHANNELS], at: usize| Vec3::new(planes[0][at], planes[1][at], planes[2][at]);
        let jump = |planes, mixture: &Mixture<N>| color(planes, mixture.with) - color(planes, mixture.pixel);
        let parts = (rendered.surface, rendered.shading);
        // Faces that run through each other meet where their depths do.
        let meet = |pixels: [usize; 2], axis: usize| {
            let faces = pixels.map(|at| self.nearest.faces[at]);
            if rendered.shading.share_an_edge(faces) {
                return None;
            }
            let (x, y) = (pixels[0] % self.grid.width_px(), pixels[0] / self.grid.width_px());
            let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let [one, other] = faces.map(|face| ScreenFace::plane(rendered, &self.scaled, face));
            meeting(&one, &other, center, axis)
        };
        let differ = |[one, other]: [usize; 2]| {
            (color(planes, one) - color(planes, other)).abs().max_element() >= FAINT
        };
        self.color_discontinuities.each_mixture(
            parts,
            &self.scaled,
            &self.nearest,
            differ,
            meet,
            |mixture| {
                let jumps = jump(planes, &mixture);
                mixed.push(ColorMix {
                    pixel: mixture.pixel,
                    color: mixture.share * jumps,
                    slopes: std::array::from_fn(|k| {
                        mixture.slopes[k] * jumps + mixture.share * jump(&slopes[k], &mixture)
                    }),
                });
            },
        );
        for ColorMix { pixel, color, slopes } in &self.mixed {
            (0..3).for_each(|c| self.planes[c][*pixel] += color[c]);
            for (planes, slope) in self.slopes.iter_mut().zip(slopes) {
                (0..3).for_each(|c| planes[c][*pixel] += slope[c]);
            }
        }
    }

    fn premultiply(&mut self) {
        let pixels = |block: usize| block * BLOCK_PX..(block + 1) * BLOCK_PX;
        let shown = self.shown.iter().enumerate().filter(|(_, shown)| **shown);
        for at in shown.flat_map(|(block, _)| pixels(block)) {
            let weight = self.planes[3][at];
            for channel in 0..3 {
                for slopes in &mut self.slopes {
                    slopes[channel][at] =
                        weight * slopes[channel][at] + slopes[3][at] * self.planes[channel][at];
                }
                self.planes[channel][at] *= weight;
            }
        }
    }

    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Premultiplied red, green, blue, square roots of linear light, and the weight, 0..1; row-major.
    pub fn planes(&self) -> &[Vec<f32>; CHANNELS] {
        &self.planes
    }

    /// Derivatives of the planes by each parameter.
    pub fn slopes(&self) -> &[[Vec<f32>; CHANNELS]; N] {
        &self.slopes
    }

    /// For each block of a row: whether any pixel has a surface. Elsewhere all planes are 0.
    pub fn shown(&self) -> &[bool] {
        &self.shown
    }

    /// Nearest triangle of each pixel; `u32::MAX` for background.
    pub fn faces(&self) -> &[u32] {
        &self.nearest.faces
    }

    /// The pixels whose color is mixed with that of one beside it, some more than once.
    pub fn mixed(&self) -> impl Iterator<Item = usize> {
        self.mixed.iter().map(|mixed| mixed.pixel)
    }
}

/// `max(0, 2 S - 1)` of the mean coverage over a square of the silhouette's pixels, and its derivatives.
#[inline]
fn weight<const N: usize>(drawn: &SoftSilhouette<N>, x: usize, y: usize, shrink: usize) -> (f32, [f32; N]) {
    let width = drawn.grid().width_px();
    let (mut coverage, mut slopes) = (0.0, [0.0; N]);
    for row in y * shrink..(y + 1) * shrink {
        let pixels = row * width + x * shrink..row * width + (x + 1) * shrink;
        coverage += drawn.coverage()[pixels.clone()].iter().sum::<f32>();
        for (slope, plane) in slopes.iter_mut().zip(drawn.slopes()) {
            *slope += plane[pixels.clone()].iter().sum::<f32>();
        }
    }
    let gain = 2.0 / (shrink * shrink) as f32;
    let weight = gain * coverage - 1.0;
    if weight > 0.0 { (weight, slopes.map(|slope| gain * slope)) } else { (0.0, [0.0; N]) }
}

/// Distance along the axis, pixels, from a pixel center where the first triangle is nearer to the intersection of both
/// planes, and its derivative; `None` if the planes do not intersect before the next center, or their line is nearly
/// parallel to the axis.
fn meeting<const N: usize>(
    one: &ScreenFace<N>,
    other: &ScreenFace<N>,
    center: Vec2,
    axis: usize,
) -> Option<(f32, [f32; N])> {
    let lead = |at: Vec2| one.key(at) - other.key(at);
    let beside = [Vec2::X, Vec2::Y].map(|step| center + step);
    let (here, there, across) = (lead(center), lead(beside[axis]), lead(beside[1 - axis]));
    let (along, aside) = ((there - here).abs(), (across - here).abs());
    let steep = if axis == 0 { along >= aside } else { along > aside };
    if !steep || here < 0.0 || there > 0.0 || along <= 0.0 {
        return None;
    }
    let reach = here / (here - there);
    let slope = |k: usize| {
        let lead_slope = |at: Vec2| one.key_slope(k, at) - other.key_slope(k, at);
        let (here_slope, there_slope) = (lead_slope(center), lead_slope(beside[axis]));
        (here_slope - reach * (here_slope - there_slope)) / (here - there)
    };
    Some((reach, std::array::from_fn(slope)))
}

/// A triangle on the screen with its derivatives; for geometry-only use the texture's levels are 0.
struct ScreenFace<const N: usize> {
    number: u32,
    from: Vec2,
    sides: [Vec2; 2],
    /// Twice the area, signed, pixels^2.
    area: f32,
    keys: [f32; 3],
    level: f32,
    moves: [FaceSlopes; N],
}

/// A triangle's derivatives by one parameter.
#[derive(Clone, Copy)]
struct FaceSlopes {
    from: Vec2,
    sides: [Vec2; 2],
    area: f32,
    keys: [f32; 3],
    level: f32,
}

impl FaceSlopes {
    /// Of the second and third corner's share on the screen, `d` from the first.
    #[inline]
    fn share_slopes(&self, [e1, e2]: [Vec2; 2], d: Vec2, per_area: f32) -> [f32; 2] {
        let (b1, b2) = (d.perp_dot(e2) * per_area, e1.perp_dot(d) * per_area);
        [
            (d.perp_dot(self.sides[1]) - self.from.perp_dot(e2) - b1 * self.area) * per_area,
            (self.sides[0].perp_dot(d) - e1.perp_dot(self.from) - b2 * self.area) * per_area,
        ]
    }

    /// Of the key there.
    #[inline]
    fn key_slope(&self, [e1, e2]: [Vec2; 2], keys: [f32; 3], d: Vec2, per_area: f32) -> f32 {
        let (b1, b2) = (d.perp_dot(e2) * per_area, e1.perp_dot(d) * per_area);
        let [b1_slope, b2_slope] = self.share_slopes([e1, e2], d, per_area);
        b1_slope * (keys[1] - keys[0])
            + b2_slope * (keys[2] - keys[0])
            + (1.0 - b1 - b2) * self.keys[0]
            + b1 * self.keys[1]
            + b2 * self.keys[2]
    }
}

impl<const N: usize> ScreenFace<N> {
    fn new(rendered: &ColorInput<N>, points: &[MovingPoint<N>], number: u32) -> Self {
        let mut seen = Self::plane(rendered, points, number);
        let face = &rendered.shading.faces[number as usize];
        let material = &rendered.shading.materials[face.material];
        let [u, v] = [face.uvs[1] - face.uvs[0], face.uvs[2] - face.uvs[0]];
        let texels = u.perp_dot(v).abs() * material.area_texels();
        let level = 0.5 * (texels / seen.area.abs()).log2();
        let last = material.levels.len().saturating_sub(1) as f32;
        if level > 0.0 && level < last {
            let area = seen.area;
            seen.moves.iter_mut().for_each(|m| m.level = -0.5 * std::f32::consts::LOG2_E * m.area / area);
        }
        // `max` takes the number where the triangle has no area in the texture or on the screen.
        seen.level = level.max(0.0).min(last);
        seen
    }

    /// The face without its texture data.
    fn plane(rendered: &ColorInput<N>, points: &[MovingPoint<N>], number: u32) -> Self {
        let corners = rendered.surface.triangles[number as usize];
        let [a, b, c] = corners.map(|v| &points[v as usize]);
        let keys = corners.map(|v| &rendered.keys[v as usize]);
        let from = Vec2::from(a.at_px);
        let sides = [Vec2::from(b.at_px) - from, Vec2::from(c.at_px) - from];
        let area = sides[0].perp_dot(sides[1]);
        let moves = std::array::from_fn(|k| {
            let [p, q, r] = [a, b, c].map(|point| Vec2::from(point.slopes[k]));
            let moving = [q - p, r - p];
            let grows = moving[0].perp_dot(sides[1]) + sides[0].perp_dot(moving[1]);
            FaceSlopes {
                from: p,
                sides: moving,
                area: grows,
                keys: keys.map(|key| key.slopes[k]),
                level: 0.0,
            }
        });
        Self { number, from, sides, area, keys: keys.map(|key| key.key), level: 0.0, moves }
    }

    /// Depth key of the face's plane at a pixel position.
    fn key(&self, at: Vec2) -> f32 {
        let ([e1, e2], [k0, k1, k2]) = (self.sides, self.keys);
        let (per_area, d) = (1.0 / self.area, at - self.from);
        let (b1, b2) = (d.perp_dot(e2) * per_area, e1.perp_dot(d) * per_area);
        k0 + b1 * (k1 - k0) + b2 * (k2 - k0)
    }

    /// Derivative by one parameter of the depth key of the face's plane.
    fn key_slope(&self, k: usize, at: Vec2) -> f32 {
        self.moves[k].key_slope(self.sides, self.keys, at - self.from, 1.0 / self.area)
    }

    /// Color at a pixel position, and its derivatives.
    #[inline]
    fn color(&self, rendered: &ColorInput<N>, at: Vec2) -> (Vec3, [Vec3; N]) {
        let face = &rendered.shading.faces[self.number as usize];
        let material = &rendered.shading.materials[face.material];
        let [e1, e2] = self.sides;
        let (per_area, d) = (1.0 / self.area, at - self.from);
        // Shares of the corners on the screen, then in space (perspective-correct).
        let (b1, b2) = (d.perp_dot(e2) * per_area, e1.perp_dot(d) * per_area);
        let [k0, k1, k2] = self.keys;
        let per_key = 1.0 / ((1.0 - b1 - b2) * k0 + b1 * k1 + b2 * k2);
        let (w1, w2) = (b1 * k1 * per_key, b2 * k2 * per_key);
        let [u1, u2] = [face.uvs[1] - face.uvs[0], face.uvs[2] - face.uvs[0]];
        let [n1, n2] = [face.normals[1] - face.normals[0], face.normals[2] - face.normals[0]];
        let texel = material.sample(face.uvs[0] + w1 * u1 + w2 * u2, self.level);
        let across = face.normals[0] + w1 * n1 + w2 * n2;
        let per_length = across.length_recip();
        let normal = across * per_length;
        let StudioLight { toward_key, up } = rendered.light;
        let facing = normal.dot(toward_key.at);
        let lit = facing > 0.0;
        let light =
            GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal.dot(up.at)) + KEY * if lit { facing } else { 0.0 };
        let albedo = material.base_color * texel.color;
        let linear = albedo * light + DARK;
        let color = Vec3::new(linear.x.sqrt(), linear.y.sqrt(), linear.z.sqrt());
        let slopes = std::array::from_fn(|k| {
            let m = &self.moves[k];
            let [b1_slope, b2_slope] = m.share_slopes([e1, e2], d, per_area);
            let key_slope = m.key_slope([e1, e2], self.keys, d, per_area);
            let w1_slope = (b1_slope * k1 + b1 * m.keys[1] - w1 * key_slope) * per_key;
            let w2_slope = (b2_slope * k2 + b2 * m.keys[2] - w2 * key_slope) * per_key;
            let uv_slope = w1_slope * u1 + w2_slope * u2;
            let texel_slope = texel.by_u * uv_slope.x + texel.by_v * uv_slope.y + texel.by_level * m.level;
            let across_slope = w1_slope * n1 + w2_slope * n2;
            let normal_slope = (across_slope - normal * normal.dot(across_slope)) * per_length;
            let facing_slope = normal_slope.dot(toward_key.at) + normal.dot(toward_key.slopes[k]);
            let up_slope = normal_slope.dot(up.at) + normal.dot(up.slopes[k]);
            let light_slope = 0.5 * (SKY - GROUND) * up_slope + KEY * if lit { facing_slope } else { 0.0 };
            (material.base_color * texel_slope * light + albedo * light_slope) * (0.5 / color)
        });
        (color, slopes)
    }
}

#[cfg(test)]
mod tests;
