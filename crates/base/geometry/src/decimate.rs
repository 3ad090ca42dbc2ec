//! Mesh decimation by edge collapses with the smallest quadric error.
//!
//! Garland and Heckbert, *Surface Simplification Using Quadric Error Metrics* (SIGGRAPH 1997), with half-edge
//! collapses: every remaining vertex is one of the mesh's own, with its texture coordinate and normal. Closed
//! surfaces stay closed. Creases, texture seams and material borders are collapsed only along themselves. Separate
//! shells stay separate, however close they are.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec3;

use super::{FaceGroup, TexturedMesh};

/// Weight of the planes that preserve creases and borders, relative to those of the triangles.
const CREASE_WEIGHT: f64 = 10.0;

/// Smallest cosine between a triangle's normals before and after a collapse.
const MIN_COSINE: f64 = 0.3;

/// The mesh with at most `max_triangles`, or as close to that as its creases and shells permit. No corner moves farther
/// than about `max_off_m` from its original planes (root mean square over them, by area). Deterministic. O(n log n).
pub fn decimated(mesh: &TexturedMesh, max_triangles: usize, max_off_m: f64) -> TexturedMesh {
    let mut surface = Surface::new(mesh);
    surface.collapse_down_to(max_triangles, max_off_m);
    surface.into_mesh(mesh)
}

/// Sum of squared distances from planes, as a function of the point: the upper half of the symmetric 4 x 4 matrix, and
/// the sum of the planes' weights.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 11]);

impl Quadric {
    /// `weight` times the squared distance from the plane through `point`.
    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let DVec3 { x: a, y: b, z: c } = normal;
        let d = -normal.dot(point);
        Self([a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d, 1.0].map(|m| weight * m))
    }

    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    fn weight(&self) -> f64 {
        self.0[10]
    }

    fn at(&self, p: DVec3) -> f64 {
        let [aa, ab, ac, ad, bb, bc, bd, cc, cd, dd, _] = self.0;
        let quadratic = p.x * (aa * p.x + 2.0 * (ab * p.y + ac * p.z + ad));
        (quadratic + p.y * (bb * p.y + 2.0 * (bc * p.z + bd)) + p.z * (cc * p.z + 2.0 * cd) + dd).max(0.0)
    }
}

/// A triangle: welded positions, and the mesh's vertices at them.
#[derive(Clone, Copy)]
struct Face {
    places: [usize; 3],
    vertices: [u32; 3],
    group: usize,
}

/// A collapse of one position into a neighbor; ordered by cost.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Collapse {
    /// Bits of the cost, which is not negative: ordered as the cost is.
    cost: u64,
    from: usize,
    to: usize,
    /// Change counters of the two positions when this was computed.
    changes: [u32; 2],
}

struct Surface {
    /// Welded positions.
    places: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    changes: Vec<u32>,
    /// `None` once collapsed.
    faces: Vec<Option<Face>>,
    /// Faces at each position.
    fans: Vec<Vec<usize>>,
    left: usize,
}

impl Surface {
    fn new(mesh: &TexturedMesh) -> Self {
        let mut known: BTreeMap<[u64; 3], usize> = BTreeMap::new();
        let mut places = Vec::new();
        let welded: Vec<usize> = mesh
            .positions
            .iter()
            .map(|&p| {
                *known.entry((p + 0.0).to_array().map(f64::to_bits)).or_insert_with(|| {
                    places.push(p);
                    places.len() - 1
                })
            })
            .collect();
        let mut faces = Vec::new();
        for (group, FaceGroup { triangles, .. }) in mesh.groups.iter().enumerate() {
            for &vertices in triangles {
                let places = vertices.map(|v| welded[v as usize]);
                let [a, b, c] = places;
                if a != b && b != c && c != a {
                    faces.push(Some(Face { places, vertices, group }));
                }
            }
        }
        let mut fans = vec![Vec::new(); places.len()];
        for (index, face) in faces.iter().enumerate() {
            face.iter().flat_map(|face| face.places).for_each(|place| fans[place].push(index));
        }
        let left = faces.len();
        let (changes, quadrics) = (vec![0; places.len()], vec![Quadric::default(); places.len()]);
        let mut surface = Self { places, quadrics, changes, faces, fans, left };
        surface.measure();
        surface
    }

    /// Accumulates the quadrics of each position: the planes of its triangles, and perpendicular planes along creases
    /// and borders.
    fn measure(&mut self) {
        for index in 0..self.faces.len() {
            let Some(face) = self.faces[index] else { continue };
            let corners = face.places.map(|place| self.places[place]);
            let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let normal = across.normalize_or_zero();
            let flat = Quadric::plane(normal, corners[0], 0.5 * across.length());
            for k in 0..3 {
                let (from, to) = (face.places[k], face.places[(k + 1) % 3]);
                self.quadrics[from] = self.quadrics[from].plus(flat);
                if self.is_crease(from, to) {
                    let along = corners[(k + 1) % 3] - corners[k];
                    let upright = along.cross(normal).normalize_or_zero();
                    let wall = Quadric::plane(upright, corners[k], CREASE_WEIGHT * along.length_squared());
                    self.quadrics[from] = self.quadrics[from].plus(wall);
                    self.quadrics[to] = self.quadrics[to].plus(wall);
                }
            }
        }
    }

    fn faces_at(&self, place: usize) -> impl Iterator<Item = (usize, Face)> + '_ {
        self.fans[place].iter().filter_map(|&index| self.faces[index].map(|face| (index, face)))
    }

    /// The faces on both sides of an edge.
    fn beside(&self, from: usize, to: usize) -> Vec<(usize, Face)> {
        self.faces_at(from).filter(|(_, face)| face.places.contains(&to)).collect()
    }

    fn is_crease(&self, from: usize, to: usize) -> bool {
        let beside = self.beside(from, to);
        let [(_, a), (_, b)] = beside[..] else { return true };
        a.group != b.group || [from, to].iter().any(|&place| a.vertex_at(place) != b.vertex_at(place))
    }

    /// Positions that share an edge with this one, ascending.
    fn neighbors(&self, place: usize) -> Vec<usize> {
        let mut around: Vec<usize> = self.faces_at(place).flat_map(|(_, face)| face.places).collect();
        around.sort_unstable();
        around.dedup();
        around.retain(|&other| other != place);
        around
    }

    /// `None` where it would move the surface too far.
    fn found(&self, from: usize, to: usize, max_off_m: f64) -> Option<Reverse<Collapse>> {
        let planes = self.quadrics[from].plus(self.quadrics[to]);
        let cost = planes.at(self.places[to]);
        let near = cost <= planes.weight() * max_off_m.powi(2);
        let changes = [self.changes[from], self.changes[to]];
        near.then(|| Reverse(Collapse { cost: cost.to_bits(), from, to, changes }))
    }

    fn collapse_down_to(&mut self, max_triangles: usize, max_off_m: f64) {
        let mut heap: BinaryHeap<Reverse<Collapse>> = BinaryHeap::new();
        for from in 0..self.places.len() {
            heap.extend(self.neighbors(from).into_iter().filter_map(|to| self.found(from, to, max_off_m)));
        }
        while self.left > max_triangles {
            let Some(Reverse(Collapse { from, to, changes, .. })) = heap.pop() else { return };
            if changes != [self.changes[from], self.changes[to]] || !self.collapse(from, to) {
                continue;
            }
            for other in self.neighbors(to) {
                heap.extend(self.found(to, other, max_off_m));
                heap.extend(self.found(other, to, max_off_m));
            }
        }
    }

    /// Moves `from` onto `to`, unless the surface would become non-manifold or would fold.
    fn collapse(&mut self, from: usize, to: usize) -> bool {
        let beside = self.beside(from, to);
        let [(first, a), (second, b)] = beside[..] else { return false };
        let (around_from, around_to) = (self.neighbors(from), self.neighbors(to));
        let shared: Vec<usize> =
            around_from.iter().copied().filter(|n| around_to.binary_search(n).is_ok()).collect();
        let is_fan = self.faces_at(from).count() == around_from.len();
        if !is_fan || shared.len() != 2 || shared.iter().any(|&n| self.neighbors(n).len() <= 3) {
            return false;
        }
        // The vertex of `from` in a face must be that of one of the two faces beside the edge; otherwise `to` has no
        // match.
        let worn = |vertex: u32, group: usize| {
            let alike = |face: &Face| face.vertex_at(from) == Some(vertex) && face.group == group;
            [a, b].into_iter().find(alike).and_then(|face| face.vertex_at(to))
        };
        let mut moved = Vec::new();
        for (index, face) in self.faces_at(from).filter(|(index, _)| ![first, second].contains(index)) {
            let Some(k) = face.places.iter().position(|&place| place == from) else { return false };
            let Some(vertex) = worn(face.vertices[k], face.group) else { return false };
            let mut after = face;
            (after.places[k], after.vertices[k]) = (to, vertex);
            let (old, new) = (self.across(&face), self.across(&after));
            if old.dot(new) <= MIN_COSINE * old.length() * new.length() {
                return false;
            }
            moved.push((index, after));
        }
        for (index, face) in moved {
            self.faces[index] = Some(face);
            self.fans[to].push(index);
        }
        (self.faces[first], self.faces[second]) = (None, None);
        self.left -= 2;
        self.quadrics[to] = self.quadrics[to].plus(self.quadrics[from]);
        self.changes[from] += 1;
        self.changes[to] += 1;
        self.fans[from].clear();
        let alive = &self.faces;
        self.fans[to].retain(|&index| alive[index].is_some());
        true
    }

    /// Normal of a face, twice its area long.
    fn across(&self, face: &Face) -> DVec3 {
        let [a, b, c] = face.places.map(|place| self.places[place]);
        (b - a).cross(c - a)
    }

    /// The remaining faces with their vertices.
    fn into_mesh(self, mesh: &TexturedMesh) -> TexturedMesh {
        let mut groups: Vec<FaceGroup> = mesh
            .groups
            .iter()
            .map(|group| FaceGroup { material: group.material, triangles: Vec::new() })
            .collect();
        let (mut kept, mut renamed) = (Vec::new(), vec![None; mesh.positions.len()]);
        for face in self.faces.into_iter().flatten() {
            let triangle = face.vertices.map(|vertex| {
                *renamed[vertex as usize].get_or_insert_with(|| {
                    kept.push(vertex as usize);
                    kept.len() as u32 - 1
                })
            });
            groups[face.group].triangles.push(triangle);
        }
        TexturedMesh {
            positions: kept.iter().map(|&v| mesh.positions[v]).collect(),
            normals: kept.iter().map(|&v| mesh.normals[v]).collect(),
            uvs: kept.iter().map(|&v| mesh.uvs[v]).collect(),
            groups,
            materials: mesh.materials.clone(),
        }
    }
}

impl Face {
    /// The mesh vertex of the face at a position.
    fn vertex_at(&self, place: usize) -> Option<u32> {
        self.places.iter().position(|&own| own == place).map(|k| self.vertices[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{block, sphere};
    use crate::solid_query::MeshSolid;
    use crate::{Material, Rgb};

    fn plain(name: &str) -> Material {
        Material::plain(name, Rgb([0.5; 3]), 0.5)
    }

    #[test]
    fn decimated_ball_stays_closed_and_keeps_its_volume() {
        let mut ball = TexturedMesh::default();
        ball.add(sphere(0.05, 40), &plain("ball"));
        let highest = ball.triangle_count() / 5;
        let coarse = decimated(&ball, highest, 0.01);
        assert!(
            (highest - 1..=highest).contains(&coarse.triangle_count()),
            "{} of {highest}",
            coarse.triangle_count()
        );
        assert!(MeshSolid::new(&coarse).is_ok());
        let volume = |mesh: &TexturedMesh| -> f64 {
            mesh.triangles()
                .map(|t| t.map(|v| mesh.positions[v as usize]))
                .map(|[a, b, c]| a.dot(b.cross(c)))
                .sum()
        };
        let ratio = volume(&coarse) / volume(&ball);
        assert!((0.93..1.0).contains(&ratio), "{ratio}");
        for p in &coarse.positions {
            assert!(ball.positions.contains(p));
        }
    }

    #[test]
    fn decimated_moves_no_corner_beyond_the_limit() {
        let mut ball = TexturedMesh::default();
        ball.add(sphere(0.05, 40), &plain("ball"));
        let coarse = [1e-5, 1e-4, 1e-3].map(|off_m| decimated(&ball, 0, off_m).triangle_count());
        assert!(coarse[0] > coarse[1] && coarse[1] > coarse[2] && coarse[2] > 12, "{coarse:?}");
        assert_eq!(decimated(&ball, usize::MAX, 1.0).triangle_count(), ball.triangle_count());
    }

    #[test]
    fn decimated_keeps_box_corners_and_separate_shells() {
        // Regression: a screen 0.7 mm in front of its frame; merged corners put both into one plane.
        let mut monitor = TexturedMesh::default();
        monitor.add(block(DVec3::new(0.6, 0.02, 0.4)), &plain("frame"));
        let screen = block(DVec3::new(0.58, 0.0017, 0.38)).translated(DVec3::new(0.0, -0.00985, 0.0));
        monitor.add(screen, &plain("screen"));
        assert_eq!(decimated(&monitor, 0, 1.0).bounds(), monitor.bounds());
        assert_eq!(decimated(&monitor, 0, 1.0).triangle_count(), 24);
    }
}
