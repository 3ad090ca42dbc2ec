//! A closed triangle shell with texture coordinates: the result of the shape functions, to which
//! [`TexturedMesh::add`](super::TexturedMesh::add) assigns a material.

use std::collections::{BTreeMap, HashMap};

use glam::{DQuat, DVec3, Vec2, Vec3};

/// One closed shell. Vertices are split at creases and texture seams; positions at a split are
/// bit-identical, so welding by value closes the shell.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Solid {
    pub positions: Vec<DVec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

/// Angle between two faces above which their common edge is shaded as sharp.
pub const CREASE_ANGLE_RAD: f64 = 0.7;

/// Welded positions: equal ones share an index.
struct WeldedPositions {
    /// Welded index of each position.
    at: Vec<u32>,
    count: usize,
}

impl WeldedPositions {
    fn of(positions: &[DVec3]) -> Self {
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(positions.len());
        let number = |p: &DVec3| {
            let next = known.len() as u32;
            // Adding zero turns -0.0 into 0.0, which compare equal but differ in bits.
            *known.entry((*p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(next)
        };
        let at = positions.iter().map(number).collect();
        Self { at, count: known.len() }
    }
}

impl Solid {
    /// Builds the shell from corners (position, uv), dropping triangles without area, and computes
    /// normals: at each corner the angle-weighted mean of the faces meeting at that position whose
    /// normals lie within [`CREASE_ANGLE_RAD`] of this face's.
    pub fn from_corners(positions: &[DVec3], uvs: &[Vec2], triangles: &[[u32; 3]]) -> Self {
        let places = WeldedPositions::of(positions);
        let corner = |t: &[u32; 3], k: usize| positions[t[k] as usize];
        let kept: Vec<([u32; 3], DVec3)> = triangles
            .iter()
            .filter(|t| {
                let [a, b, c] = t.map(|v| places.at[v as usize]);
                a != b && b != c && c != a
            })
            .map(|t| {
                let normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
                (*t, normal.normalize_or_zero())
            })
            .collect();
        // Faces at each welded position with their angle there, sorted by position.
        let mut first = vec![0_u32; places.count + 1];
        kept.iter().flat_map(|(t, _)| t).for_each(|v| first[places.at[*v as usize] as usize + 1] += 1);
        (0..places.count).for_each(|place| first[place + 1] += first[place]);
        let mut faces_at = vec![(DVec3::ZERO, 0.0); 3 * kept.len()];
        let mut next = first.clone();
        for (t, normal) in &kept {
            for k in 0..3 {
                let (p, q, r) = (corner(t, k), corner(t, (k + 1) % 3), corner(t, (k + 2) % 3));
                let angle =
                    (q - p).normalize_or_zero().dot((r - p).normalize_or_zero()).clamp(-1.0, 1.0).acos();
                let next = &mut next[places.at[t[k] as usize] as usize];
                faces_at[*next as usize] = (*normal, angle);
                *next += 1;
            }
        }
        let crease_cosine = CREASE_ANGLE_RAD.cos();
        let mut solid = Solid::default();
        // For each input vertex: its quantized normals, with the output vertices.
        let mut made: Vec<Vec<([i64; 3], u32)>> = vec![Vec::new(); positions.len()];
        for (t, face_normal) in &kept {
            let triangle = [0, 1, 2].map(|k| {
                let place = places.at[t[k] as usize] as usize;
                let around = &faces_at[first[place] as usize..first[place + 1] as usize];
                let near = around.iter().filter(|(normal, _)| normal.dot(*face_normal) >= crease_cosine);
                let normal = near.fold(DVec3::ZERO, |sum, (normal, angle)| sum + *angle * *normal);
                let normal = normal.normalize_or(*face_normal);
                let quantized = (normal * 1e4).round().to_array().map(|c| c as i64);
                let made = &mut made[t[k] as usize];
                if let Some((_, vertex)) = made.iter().find(|(known, _)| *known == quantized) {
                    return *vertex;
                }
                let vertex = solid.positions.len() as u32;
                made.push((quantized, vertex));
                solid.positions.push(corner(t, k));
                solid.normals.push(normal.as_vec3());
                solid.uvs.push(uvs[t[k] as usize]);
                vertex
            });
            solid.triangles.push(triangle);
        }
        solid
    }

    /// The solid translated.
    pub fn translated(mut self, offset_m: DVec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p += offset_m);
        self
    }

    /// The solid rotated about the origin.
    pub fn rotated(mut self, rotation: DQuat) -> Self {
        let rotation_f32 = rotation.as_quat();
        self.positions.iter_mut().for_each(|p| *p = rotation * *p);
        self.normals.iter_mut().for_each(|n| *n = rotation_f32 * *n);
        self
    }

    /// The solid scaled per axis by positive factors.
    pub fn scaled(mut self, scale: DVec3) -> Self {
        let inverse = (1.0 / scale).as_vec3();
        self.positions.iter_mut().for_each(|p| *p *= scale);
        self.normals.iter_mut().for_each(|n| *n = (*n * inverse).normalize_or_zero());
        self
    }

    /// Replaces the texture coordinates by a box projection: one texture repeat each
    /// `meters_per_repeat`, projected along each face's dominant normal axis. For wood, stone, cloth.
    pub fn with_box_uvs(mut self, meters_per_repeat: f64) -> Self {
        for ((uv, p), n) in self.uvs.iter_mut().zip(&self.positions).zip(&self.normals) {
            let q = *p / meters_per_repeat;
            let a = n.abs();
            let flat = if a.z >= a.x && a.z >= a.y {
                glam::DVec2::new(q.x, q.y)
            } else if a.x >= a.y {
                glam::DVec2::new(q.y, q.z)
            } else {
                glam::DVec2::new(q.x, q.z)
            };
            *uv = flat.as_vec2();
        }
        self
    }

    /// The solid with exactly vertical normals on its horizontal faces, which rounded edges would
    /// otherwise bend (shading then shows the triangles of a large flat cap).
    pub fn with_flat_ends(mut self) -> Self {
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            if normal.z.abs() > 0.999_999 {
                t.iter().for_each(|&v| self.normals[v as usize] = normal.as_vec3());
            }
        }
        self
    }

    /// Signed volume, m^3; positive if the faces are oriented outward.
    pub fn volume_m3(&self) -> f64 {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| self.positions[v as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Whether every edge (by welded position) is used once in each direction.
    pub fn is_watertight(&self) -> bool {
        let bits = |v: u32| (self.positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut balance: BTreeMap<([u64; 3], [u64; 3]), i32> = BTreeMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
                if a < b {
                    *balance.entry((a, b)).or_default() += 1;
                } else {
                    *balance.entry((b, a)).or_default() -= 1;
                }
            }
        }
        !self.triangles.is_empty() && balance.values().all(|&count| count == 0)
    }
}
