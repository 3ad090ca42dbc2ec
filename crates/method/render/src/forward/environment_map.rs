//! Light from a furnished room by direction, prefiltered for diffuse and glossy reflection.
//!
//! The map holds no colors but the shares of four kinds of surface that a direction shows: windows, walls, ceiling and
//! what lies below the horizon. Light is their sum, weighted with the radiance of each kind, so one map serves rooms of
//! all colors. Directions are stored in octahedral maps (Cigolla et al., "A survey of efficient representations for
//! independent unit vectors", 2014), one for each of a few roughnesses (Karis, "Real shading in Unreal Engine 4", 2013)
//! and one convolved with the cosine. GGX lobes are replaced by spherical Gaussians of the same sharpness (Wang et al.,
//! "All-frequency rendering of dynamic, spatially-varying reflectance", 2009).
//!
//! Frame: z up; the largest window is toward +x, smaller ones are toward +y and -y.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4};

/// Texels along each side of the map of each roughness 0, 0.2, 0.4, 0.6, 0.8 and 1, and of the diffuse map.
pub const SIDES: [usize; 7] = [128, 64, 32, 16, 16, 16, 16];
/// Number of the diffuse map.
pub const DIFFUSE: usize = 6;
/// Steps of roughness between 0 and 1.
pub const ROUGHNESS_STEPS: f32 = 5.0;

/// Shares of windows, walls, ceiling and ground in that order.
pub type Shares = Vec4;

/// Prefiltered shares by direction.
pub struct EnvironmentMap {
    /// All maps one after another, each with a border of one texel.
    pub texels: Vec<Shares>,
    /// First texel of each map.
    pub starts: [usize; 7],
}

/// The map of the one furnished room, made on first use by one thread: a thread of a pool that waits for others takes
/// up other work of the pool meanwhile, which would wait here for itself.
pub static FURNISHED_ROOM: LazyLock<EnvironmentMap> = LazyLock::new(EnvironmentMap::new);

impl EnvironmentMap {
    fn new() -> Self {
        let mut map = Self { texels: Vec::new(), starts: [0; 7] };
        map.append(0, mean_in_texel);
        let sharp = Self { texels: map.texels.clone(), starts: map.starts };
        map.append(1, |direction, _| sharp.around(direction, gaussian_sharpness(0.2)));
        let coarse = CoarseSphere::new();
        for (number, roughness) in [(2, 0.4), (3, 0.6), (4, 0.8), (5, 1.0)] {
            let sharpness = gaussian_sharpness(roughness);
            map.append(number, |direction, _| {
                coarse.filtered(direction, |cosine| (sharpness * (cosine - 1.0)).exp() * cosine)
            });
        }
        map.append(DIFFUSE, |direction, _| coarse.filtered(direction, |cosine| cosine));
        map
    }

    fn append(&mut self, number: usize, of: impl Fn(Vec3, f32) -> Shares) {
        self.starts[number] = self.texels.len();
        let side = SIDES[number];
        let stride = side + 2;
        let texels = (0..stride * stride).map(|k| {
            let at = Vec2::new((k % stride) as f32 - 0.5, (k / stride) as f32 - 0.5) / side as f32;
            of(direction_of(at), 1.0 / side as f32)
        });
        self.texels.extend(texels);
    }

    /// Shares that a mirror of that roughness shows in a unit direction.
    pub fn mirrored(&self, direction: Vec3, roughness: f32) -> Shares {
        let level = (roughness * ROUGHNESS_STEPS).clamp(0.0, ROUGHNESS_STEPS);
        let sharp = (level as usize).min(DIFFUSE - 2);
        let blend = level - sharp as f32;
        let at = position_of(direction);
        self.bilinear(sharp, at).lerp(self.bilinear(sharp + 1, at), blend)
    }

    /// Cosine-weighted mean shares over the hemisphere about a unit normal.
    pub fn diffuse(&self, normal: Vec3) -> Shares {
        self.bilinear(DIFFUSE, position_of(normal))
    }

    #[inline]
    fn bilinear(&self, number: usize, at: Vec2) -> Shares {
        let side = SIDES[number];
        let p = at * side as f32 + 0.5;
        let (x, y) = ((p.x as usize).min(side), (p.y as usize).min(side));
        let (tx, ty) = (p.x - x as f32, p.y - y as f32);
        let stride = side + 2;
        let texels = &self.texels[self.starts[number] + y * stride + x..][..stride + 2];
        texels[0].lerp(texels[1], tx).lerp(texels[stride].lerp(texels[stride + 1], tx), ty)
    }

    /// Mean of the sharpest map under a narrow Gaussian about a direction.
    fn around(&self, direction: Vec3, sharpness: f32) -> Shares {
        const COUNT: usize = 48;
        let (right, up) = direction.any_orthonormal_pair();
        let sum: Shares = (0..COUNT)
            .map(|k| {
                // Vogel's spiral, with the radii of a Gaussian.
                let share = (k as f32 + 0.5) / COUNT as f32;
                let radius = (-2.0 * (1.0 - share).ln() / sharpness).sqrt();
                let angle = k as f32 * 2.399_963_2;
                let off = radius * (angle.cos() * right + angle.sin() * up);
                self.bilinear(0, position_of((direction + off).normalize()))
            })
            .sum();
        sum / COUNT as f32
    }
}

/// Sharpness of the spherical Gaussian that stands for a GGX lobe about the mirrored direction.
fn gaussian_sharpness(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    0.5 * (1.0 / (alpha * alpha) - 1.0)
}

/// Directions spread over the sphere with the shares and the solid angle of each.
struct CoarseSphere(Vec<(Vec3, Shares, f32)>);

impl CoarseSphere {
    fn new() -> Self {
        const SIDE: usize = 32;
        let cells = (0..SIDE * SIDE).map(|k| {
            let at = (Vec2::new((k % SIDE) as f32, (k / SIDE) as f32) + 0.5) / SIDE as f32;
            let direction = direction_of(at);
            // The octahedron |x| + |y| + |z| = 1 seen from its center: the area shrinks with the cubed distance.
            let solid_angle = (direction.x.abs() + direction.y.abs() + direction.z.abs()).powi(3);
            (direction, mean_in_texel(direction, 1.0 / SIDE as f32), solid_angle)
        });
        Self(cells.collect())
    }

    /// Mean under a kernel of the cosine to a direction, over its hemisphere.
    fn filtered(&self, direction: Vec3, kernel: impl Fn(f32) -> f32) -> Shares {
        let (mut sum, mut weights) = (Shares::ZERO, 0.0);
        for (toward, shares, solid_angle) in &self.0 {
            let cosine = toward.dot(direction);
            if cosine > 0.0 {
                let weight = kernel(cosine) * solid_angle;
                sum += weight * *shares;
                weights += weight;
            }
        }
        sum / weights
    }
}

/// Mean of 4 x 4 directions in a texel about a direction, `side` of the octahedral square wide.
fn mean_in_texel(direction: Vec3, side: f32) -> Shares {
    let center = position_of(direction);
    let sum: Shares = (0..16)
        .map(|k| {
            let off = Vec2::new((k % 4) as f32 - 1.5, (k / 4) as f32 - 1.5) * (0.25 * side);
            shown(direction_of(center + off))
        })
        .sum();
    sum / 16.0
}

/// Kind of surface in a direction from a table in the center of the room.
fn shown(d: Vec3) -> Shares {
    const WINDOWS: Shares = Vec4::X;
    const WALLS: Shares = Vec4::Y;
    const CEILING: Shares = Vec4::Z;
    const GROUND: Shares = Vec4::W;
    /// Half the room along x and y, and the ceiling above the table, meters.
    const HALF_M: Vec3 = Vec3::new(2.6, 2.1, 1.75);
    if d.z < 0.0 {
        return GROUND;
    }
    let far = HALF_M / d.abs().max(Vec3::splat(1e-6));
    let reach = far.min_element();
    let p = reach * d;
    if reach == far.z {
        return CEILING;
    }
    // Daylight is brighter above the horizon than before the houses across the street.
    let daylight = WINDOWS * (0.6 + 0.4 * (p.z / 1.5).clamp(0.0, 1.0));
    if reach == far.x && d.x > 0.0 {
        return window(p.y + 1.0, p.z - 0.1, Vec2::new(2.0, 1.4), 3)
            .map_or(WALLS, |glass| if glass { daylight } else { CEILING });
    }
    if reach == far.y && d.y > 0.0 {
        return window(p.x + 1.1, p.z - 0.1, Vec2::new(1.1, 1.4), 2)
            .map_or(WALLS, |glass| if glass { 0.7 * daylight } else { CEILING });
    }
    if reach == far.y {
        // Opposite the viewer of a light from the left: it draws the edges of glossy objects.
        return window(p.x + 2.4, p.z - 0.3, Vec2::new(1.5, 1.4), 2)
            .map_or(WALLS, |glass| if glass { 0.6 * daylight } else { CEILING });
    }
    WALLS
}

/// Whether a position measured from the lower left corner of a window is glass, or its frame; `None` beside it.
fn window(x: f32, y: f32, size_m: Vec2, columns: u32) -> Option<bool> {
    const FRAME_M: f32 = 0.035;
    if x < 0.0 || y < 0.0 || x > size_m.x || y > size_m.y {
        return None;
    }
    let pane = Vec2::new(size_m.x / columns as f32, 0.5 * size_m.y);
    let inside = Vec2::new(x % pane.x, y % pane.y);
    Some(inside.min(pane - inside).min_element() > FRAME_M)
}

/// Unit direction of a position in the octahedral square, 0..1 each way; positions beyond it continue across its edges.
fn direction_of(at: Vec2) -> Vec3 {
    let mut p = 2.0 * at - 1.0;
    if p.x.abs() > 1.0 {
        p = Vec2::new(p.x.signum() * (2.0 - p.x.abs()), -p.y);
    }
    if p.y.abs() > 1.0 {
        p = Vec2::new(-p.x, p.y.signum() * (2.0 - p.y.abs()));
    }
    let z = 1.0 - p.x.abs() - p.y.abs();
    let folded = (-z).max(0.0);
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    Vec3::new(p.x - sign(p.x) * folded, p.y - sign(p.y) * folded, z).normalize()
}

/// Position of a unit direction in the octahedral square, 0..1 each way.
#[inline]
fn position_of(d: Vec3) -> Vec2 {
    let per_sum = 1.0 / (d.x.abs() + d.y.abs() + d.z.abs());
    let (x, y) = (d.x * per_sum, d.y * per_sum);
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    let p = if d.z < 0.0 {
        Vec2::new((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
    } else {
        Vec2::new(x, y)
    };
    0.5 * p + 0.5
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, mpsc};
    use std::time::Duration;

    use super::*;

    fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |k| {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
            let (radius, angle) = ((1.0 - z * z).sqrt(), k as f32 * 2.399_963_2);
            Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    }

    #[test]
    fn positions_and_directions_are_inverse() {
        for d in directions(500) {
            assert!(direction_of(position_of(d)).abs_diff_eq(d, 1e-5), "{d}");
        }
    }

    #[test]
    fn filtering_neither_adds_nor_loses_light() {
        let map = &*FURNISHED_ROOM;
        let mean = |of: &dyn Fn(Vec3) -> Shares| directions(20_000).map(of).sum::<Shares>() / 20_000.0;
        let bare = mean(&shown);
        for roughness in [0.0, 0.2, 0.5, 1.0] {
            let filtered = mean(&|d| map.mirrored(d, roughness));
            assert!(filtered.abs_diff_eq(bare, 0.012), "{roughness}: {filtered} for {bare}");
        }
        let diffuse = mean(&|d| map.diffuse(d));
        assert!(diffuse.abs_diff_eq(bare, 0.012), "{diffuse} for {bare}");
    }

    #[test]
    fn images_that_a_pool_begins_one_after_another_do_not_wait_for_themselves() {
        for _ in 0..10 {
            let map = Arc::new(LazyLock::new(EnvironmentMap::new as fn() -> EnvironmentMap));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().expect("threads");
            let (done, all_done) = mpsc::channel();
            for _ in 0..64 {
                let (map, done) = (map.clone(), done.clone());
                pool.spawn(move || done.send(map.starts[0]).expect("the test waits"));
                // Some begin while the map is being made.
                std::thread::sleep(Duration::from_micros(200));
            }
            for image in 0..64 {
                let began = all_done.recv_timeout(Duration::from_secs(120));
                assert_eq!(began, Ok(0), "image {image} waits for itself");
            }
        }
    }

    #[test]
    fn rough_mirrors_blur_the_window_and_smooth_ones_show_its_frame() {
        let map = &*FURNISHED_ROOM;
        let across = |roughness: f32| -> Vec<f32> {
            let ray = |k: i32| Vec3::new(2.6, 0.01 * k as f32, 0.45).normalize();
            (-90..=90).map(|k| map.mirrored(ray(k), roughness).x).collect()
        };
        let swing = |values: &[f32]| {
            values.iter().fold(0.0_f32, |a, b| a.max(*b)) - values.iter().fold(9.0_f32, |a, b| a.min(*b))
        };
        let (sharp, rough) = (swing(&across(0.05)), swing(&across(0.6)));
        assert!(sharp > 0.3 && rough < 0.15, "{sharp} {rough}");
    }
}
