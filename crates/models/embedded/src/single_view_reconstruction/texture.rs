//! Projective texture: the image projected onto a mesh from its camera; the hidden side takes its mirror image.

use glam::{DVec2, DVec3, Vec2};

use geometry::{Camera, Material, Pose, Solid, TexturedMesh};
use imaging::{Image, Texture};
use ports::Completion;
use render::annotate::fitted;

/// A solid in its pose, and its view.
pub(super) struct Projection<'a> {
    pub camera: &'a Camera,
    pub completion: &'a Completion,
    /// Pose in which the solid was fitted.
    pub world_from_solid: Pose,
    /// Extents of the solid.
    pub size: DVec3,
    /// Longer side of the texture, pixels.
    pub texture_px: u32,
}

/// Splits every triangle into four, `times` over; the shell stays closed.
pub(super) fn subdivided(solid: &Solid, times: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (solid.positions.clone(), solid.triangles.clone());
    for _ in 0..times {
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut center = |p: u32, q: u32| {
                positions.push(0.5 * (positions[p as usize] + positions[q as usize]));
                positions.len() as u32 - 1
            };
            let (ab, bc, ca) = (center(a, b), center(b, c), center(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (positions, triangles)
}

impl Projection<'_> {
    /// Textures the triangles. Faces toward the camera take the image, faces downward the lowest colors of the
    /// image, the others the colors of their mirror image across the view.
    pub fn dress(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> TexturedMesh {
        let eye =
            self.world_from_solid.inverse().transform_point(self.camera.world_from_camera.translation_m);
        let away = -eye.truncate().normalize_or(-DVec2::Y);
        let mut corners = Vec::with_capacity(3 * triangles.len());
        let mut uvs = Vec::with_capacity(3 * triangles.len());
        let mut split = Vec::with_capacity(triangles.len());
        for t in triangles {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let seen = normal.dot(eye - (a + b + c) / 3.0) > 0.0;
            let base = corners.len() as u32;
            for p in [a, b, c] {
                corners.push(p);
                uvs.push(self.uv(if seen {
                    p
                } else if normal.z < -0.7 {
                    self.on_the_front(p, away)
                } else {
                    let depth = p.truncate().dot(away);
                    p - 2.0 * (depth * away).extend(0.0)
                }));
            }
            split.push([base, base + 1, base + 2]);
        }
        let solid = Solid::from_corners(&corners, &uvs, &split);
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::textured("picture", Texture::new(self.texture()), 0.6));
        mesh
    }

    /// The point just above the foot of the side toward the camera, at the same lateral position.
    fn on_the_front(&self, p: DVec3, away: DVec2) -> DVec3 {
        let side = away.perp();
        let half = 0.5 * (self.size.x * away.x).hypot(self.size.y * away.y);
        let across = 0.7 * p.truncate().dot(side) * side;
        (across - 0.9 * half * away).extend(0.08 * self.size.z)
    }

    /// Texture coordinates of a point of the solid: where the camera sees it in the completed image.
    pub fn uv(&self, p: DVec3) -> Vec2 {
        let [x0, y0, x1, y1] = self.completion.crop_px;
        let pixel = self.camera.project(self.world_from_solid.transform_point(p)).map(|(pixel, _)| pixel);
        let pixel = pixel.unwrap_or(DVec2::new(0.5 * (x0 + x1), 0.5 * (y0 + y1)));
        let u = ((pixel.x - x0) / (x1 - x0)).clamp(0.004, 0.996);
        let v = ((pixel.y - y0) / (y1 - y0)).clamp(0.004, 0.996);
        DVec2::new(u, 1.0 - v).as_vec2()
    }

    /// The completed image, opaque: transparent pixels take the nearest opaque ones' colors.
    pub fn texture(&self) -> Image {
        let image = &self.completion.image;
        let spread = spread_colors(image);
        if image.width_px().max(image.height_px()) > self.texture_px {
            fitted(&spread, self.texture_px, self.texture_px)
        } else {
            spread
        }
    }
}

/// Spreads colors outward ring by ring from pixels well inside the opaque part, whose edge is mixed with the
/// background.
fn spread_colors(image: &Image) -> Image {
    let (w, h) = (image.width_px() as usize, image.height_px() as usize);
    let opaque = |x: usize, y: usize| image.pixel(x as u32, y as u32)[3] >= 128;
    let deep = |x: usize, y: usize| {
        opaque(x, y)
            && (x == 0 || opaque(x - 1, y))
            && (y == 0 || opaque(x, y - 1))
            && (x + 1 == w || opaque(x + 1, y))
            && (y + 1 == h || opaque(x, y + 1))
    };
    let mut known: Vec<bool> = (0..w * h).map(|k| deep(k % w, k / w)).collect();
    if !known.contains(&true) {
        known = (0..w * h).map(|k| opaque(k % w, k / w)).collect();
    }
    let mut out = image.clone();
    let mut ring: Vec<usize> = (0..w * h).filter(|&k| known[k]).collect();
    while !ring.is_empty() {
        let mut next = Vec::new();
        for &k in &ring {
            let (x, y) = (k % w, k / w);
            let color = out.pixel(x as u32, y as u32);
            for v in y.saturating_sub(1)..(y + 2).min(h) {
                for u in x.saturating_sub(1)..(x + 2).min(w) {
                    if !known[v * w + u] {
                        known[v * w + u] = true;
                        out.set_pixel(u as u32, v as u32, color);
                        next.push(v * w + u);
                    }
                }
            }
        }
        ring = next;
    }
    out.as_rgba_mut().chunks_exact_mut(4).for_each(|p| p[3] = 255);
    out
}
