//! Normals of surfaces whose texture is also a relief.

use glam::{Vec2, Vec3A};

use super::texture_map::TextureMap;
use crate::room::luminance;

/// Unit directions in which the coordinates of a texture grow on a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct TextureAxes {
    pub u: Vec3A,
    pub v: Vec3A,
}

impl TextureAxes {
    /// Of a triangle with these sides from its first corner, and the steps of the coordinates along them; zero where
    /// the texture has no area.
    pub fn new(sides: [Vec3A; 2], steps: [Vec2; 2]) -> Self {
        let normal = sides[0].cross(sides[1]);
        let (along, across) = (sides[1].cross(normal), normal.cross(sides[0]));
        let gradient = |of: [f32; 2]| (of[0] * along + of[1] * across).normalize_or_zero();
        Self { u: gradient([steps[0].x, steps[1].x]), v: gradient([steps[0].y, steps[1].y]) }
    }

    /// A unit normal leaned away from what rises: `slope` is the rise of the relief along u and v.
    pub fn leaned(&self, normal: Vec3A, slope: Vec2) -> Vec3A {
        let rise = slope.x * self.u + slope.y * self.v;
        (normal - (rise - rise.dot(normal) * normal)).normalize_or(normal)
    }
}

/// Rise of a relief along u and v, per length in which the texture repeats, at a level of the mipmap.
pub fn slope(texture: &TextureMap, relief: f32, uv: Vec2, level: f32) -> Vec2 {
    // As in files, whose maps of normals are half as wide and high as the texture.
    let level = level.max(1.0);
    let step = 0.5 * level.exp2() / texture.side_texels();
    let height = |at: Vec2| luminance(texture.sample(at, level));
    let rise = |toward: Vec2| height(uv + toward) - height(uv - toward);
    0.5 * relief * Vec2::new(rise(Vec2::new(step.x, 0.0)), rise(Vec2::new(0.0, step.y))) / step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_leans_down_the_slope() {
        // A triangle in the world's xy plane whose u grows along y and whose v grows against x.
        let axes = TextureAxes::new([Vec3A::X, Vec3A::Y], [Vec2::new(0.0, -2.0), Vec2::new(2.0, 0.0)]);
        assert!(axes.u.abs_diff_eq(Vec3A::Y, 1e-6) && axes.v.abs_diff_eq(Vec3A::NEG_X, 1e-6));
        let leaned = axes.leaned(Vec3A::Z, Vec2::new(1.0, 0.0));
        assert!(leaned.abs_diff_eq(Vec3A::new(0.0, -1.0, 1.0).normalize(), 1e-6), "{leaned}");
        assert_eq!(axes.leaned(Vec3A::Z, Vec2::ZERO), Vec3A::Z);
    }
}
