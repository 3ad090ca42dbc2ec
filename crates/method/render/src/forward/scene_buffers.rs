//! World-space vertex and triangle buffers of all objects. They depend on neither view nor light, so all images of a
//! scene and their light maps share them.

use std::ops::Range;
use std::sync::OnceLock;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use super::one_sided::shows_no_backs;
use crate::RenderObject;
use geometry::{Material, Pose};

/// A triangle with its object and material.
pub struct SourceTriangle {
    /// Into [`SceneBuffers::points_in_world`].
    pub vertices: [u32; 3],
    /// Index of the object.
    pub object: u32,
    /// Material in the object's mesh.
    pub material: u32,
    /// Whether the back face is never visible, see [`shows_no_backs`].
    pub one_sided: bool,
}

/// The triangles to draw. The shaders of the GPU renderer know the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleFilter {
    All = 0,
    Opaque = 1,
    Transparent = 2,
}

/// Vertices and triangles of the placed objects.
pub struct SceneBuffers<'a> {
    pub objects: Vec<RenderObject<'a>>,
    /// Box of each object's mesh, in its own frame: lowest and highest corner.
    pub bounds: Vec<(DVec3, DVec3)>,
    /// Vertices of all objects, one after the other.
    pub points_in_world: Vec<Vec3A>,
    /// First vertex of each object.
    pub first_vertex: Vec<u32>,
    /// First triangle of each object.
    first_triangle: Vec<u32>,
    /// Triangles of all objects, one after the other.
    pub triangles: Vec<SourceTriangle>,
    opaque: Vec<u32>,
    transparent: Vec<u32>,
    facings: OnceLock<Vec<Vec3A>>,
}

fn is_opaque(material: &Material) -> bool {
    material.opacity >= 0.999
}

impl<'a> SceneBuffers<'a> {
    /// Moves every vertex into the world and lists the triangles.
    pub fn new(objects: Vec<RenderObject<'a>>) -> Self {
        let placed: Vec<Vec<Vec3A>> = objects
            .par_iter()
            .map(|object| {
                let world_from_object = object.world_from_object;
                let place = |p: &glam::DVec3| world_from_object.transform_point(*p).as_vec3a();
                object.mesh.positions.iter().map(place).collect()
            })
            .collect();
        let mut first_vertex = Vec::with_capacity(objects.len());
        let mut points_in_world = Vec::with_capacity(placed.iter().map(Vec::len).sum());
        for points in placed {
            first_vertex.push(points_in_world.len() as u32);
            points_in_world.extend(points);
        }
        let count = objects.iter().map(|object| object.mesh.triangle_count()).sum();
        let mut triangles = Vec::with_capacity(count);
        let (mut opaque, mut transparent) = (Vec::with_capacity(count), Vec::new());
        let no_backs: Vec<bool> =
            objects.par_iter().map(|object| shows_no_backs(object.mesh, is_opaque)).collect();
        let mut first_triangle = Vec::with_capacity(objects.len());
        for (index, object) in objects.iter().enumerate() {
            let base = first_vertex[index];
            first_triangle.push(triangles.len() as u32);
            for group in &object.mesh.groups {
                let next = triangles.len() as u32;
                let hides = is_opaque(&object.mesh.materials[group.material]);
                triangles.extend(group.triangles.iter().map(|t| SourceTriangle {
                    vertices: t.map(|v| v + base),
                    object: index as u32,
                    material: group.material as u32,
                    one_sided: hides && no_backs[index],
                }));
                let kept = if hides { &mut opaque } else { &mut transparent };
                kept.extend(next..triangles.len() as u32);
            }
        }
        let bounds = objects.iter().map(|object| object.mesh.bounds()).collect();
        let facings = OnceLock::new();
        Self {
            objects,
            bounds,
            points_in_world,
            first_vertex,
            first_triangle,
            triangles,
            opaque,
            transparent,
            facings,
        }
    }

    /// Moves an object.
    pub fn set_pose(&mut self, index: usize, world_from_object: Pose) {
        let object = &mut self.objects[index];
        if object.world_from_object == world_from_object {
            return;
        }
        object.world_from_object = world_from_object;
        let mesh = object.mesh;
        let vertices = self.vertices_of(&(index..index + 1));
        for (point, p) in self.points_in_world[vertices].iter_mut().zip(&mesh.positions) {
            *point = world_from_object.transform_point(*p).as_vec3a();
        }
        if let Some(mut facings) = self.facings.take() {
            let moved = self.triangles_of(&(index..index + 1));
            let moved = moved.start as usize..moved.end as usize;
            for (facing, triangle) in facings[moved.clone()].iter_mut().zip(&self.triangles[moved]) {
                *facing = self.facing(triangle);
            }
            self.facings = OnceLock::from(facings);
        }
    }

    /// All objects.
    pub fn all(&self) -> Range<usize> {
        0..self.objects.len()
    }

    /// The vertices of consecutive objects.
    pub fn vertices_of(&self, objects: &Range<usize>) -> Range<usize> {
        let first =
            |index: usize| self.first_vertex.get(index).map_or(self.points_in_world.len(), |v| *v as usize);
        first(objects.start)..first(objects.end)
    }

    /// The triangles of consecutive objects.
    pub fn triangles_of(&self, objects: &Range<usize>) -> Range<u32> {
        let first =
            |index: usize| self.first_triangle.get(index).copied().unwrap_or(self.triangles.len() as u32);
        first(objects.start)..first(objects.end)
    }

    /// The triangles of consecutive objects to draw.
    pub fn drawn(&self, keep: TriangleFilter, objects: &Range<usize>) -> DrawnTriangles<'_> {
        let triangles = self.triangles_of(objects);
        let among = |numbers: &'_ [u32]| {
            let place = |end: u32| numbers.partition_point(|number| *number < end);
            place(triangles.start)..place(triangles.end)
        };
        match keep {
            TriangleFilter::All => DrawnTriangles::All(triangles),
            TriangleFilter::Opaque => DrawnTriangles::Some(&self.opaque[among(&self.opaque)]),
            TriangleFilter::Transparent => DrawnTriangles::Some(&self.transparent[among(&self.transparent)]),
        }
    }

    /// Unit normal of each triangle by its winding, world frame; zero for a degenerate triangle.
    pub fn facings(&self) -> &[Vec3A] {
        self.facings.get_or_init(|| self.triangles.iter().map(|triangle| self.facing(triangle)).collect())
    }

    fn facing(&self, triangle: &SourceTriangle) -> Vec3A {
        let [p, q, r] = triangle.vertices.map(|v| self.points_in_world[v as usize]);
        (q - p).cross(r - p).normalize_or_zero()
    }
}

/// Indices of triangles, in list order.
#[derive(Clone)]
pub enum DrawnTriangles<'a> {
    All(Range<u32>),
    Some(&'a [u32]),
}

impl DrawnTriangles<'_> {
    pub fn len(&self) -> usize {
        match self {
            Self::All(triangles) => triangles.len(),
            Self::Some(numbers) => numbers.len(),
        }
    }

    /// Index of the triangle at a position of the list.
    #[inline]
    pub fn at(&self, place: usize) -> u32 {
        match self {
            Self::All(triangles) => triangles.start + place as u32,
            Self::Some(numbers) => numbers[place],
        }
    }
}
