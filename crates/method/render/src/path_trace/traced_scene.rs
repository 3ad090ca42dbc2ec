//! Geometry and materials of a scene in the form that rays need, and the surface where one ends.

use glam::{Mat3A, Vec2, Vec3, Vec3A};

use super::bvh::{Bvh, FAR, Met};
use super::glass;
use crate::RenderObject;
use crate::forward::one_sided::shows_no_backs;
use crate::forward::relief::{TextureAxes, slope};
use crate::forward::scene_buffers::{SceneBuffers, SourceTriangle};
use crate::forward::shading_materials::{ShadingMaterial, ShadingMaterials};
use crate::forward::texture_map::TextureMap;

/// Opacity from which on a surface is opaque.
const OPAQUE: f32 = 0.999;
/// Distance by which rays start off a surface, per meter from the origin of the world.
const OFFSET: f32 = 1e-5;
/// Limit of the lift of a point to the curved surface, as a share of its triangle's longest side.
const MAX_LIFT: f32 = 0.1;

/// Placed objects behind a tree of boxes.
pub struct TracedScene<'a> {
    pub scene_buffers: SceneBuffers<'a>,
    bvh: Bvh,
    materials: ShadingMaterials<'a>,
    textures: Vec<TextureMap<'a>>,
    world_from_object: Vec<Mat3A>,
    /// Whether the transparent faces of each object bound a volume.
    holds_glass: Vec<bool>,
}

/// A surface that a ray meets, turned toward where the ray came from.
pub struct TracedSurface<'s> {
    pub point: Vec3A,
    /// Unit, of the flat triangle.
    pub flat_normal: Vec3A,
    /// Unit, smooth, with `toward_eye` above it.
    pub normal: Vec3A,
    pub toward_eye: Vec3A,
    /// Whether the ray came from outside.
    pub is_front: bool,
    pub albedo: Vec3,
    pub material: &'s ShadingMaterial,
    /// Point of the curved surface that the triangle stands for, where rays of light start.
    pub lifted: Vec3A,
    /// Whether it belongs to no closed body of glass.
    pub is_sheet: bool,
}

impl<'a> TracedScene<'a> {
    pub fn new(objects: Vec<RenderObject<'a>>) -> Self {
        let scene_buffers = SceneBuffers::new(objects);
        let corners: Vec<[Vec3A; 3]> = scene_buffers
            .triangles
            .iter()
            .map(|t| t.vertices.map(|v| scene_buffers.points_in_world[v as usize]))
            .collect();
        let materials = ShadingMaterials::new(&scene_buffers.objects);
        let textures = materials.textures.iter().map(|texture| TextureMap::new(texture)).collect();
        let turn = |object: &RenderObject| Mat3A::from_quat(object.world_from_object.rotation.as_quat());
        let world_from_object = scene_buffers.objects.iter().map(turn).collect();
        let holds_glass = scene_buffers
            .objects
            .iter()
            .map(|object| shows_no_backs(object.mesh, |material| material.opacity < OPAQUE))
            .collect();
        Self { bvh: Bvh::new(&corners), scene_buffers, materials, textures, world_from_object, holds_glass }
    }

    /// The nearest surface along a ray with unit direction.
    pub fn nearest(&self, origin: Vec3A, direction: Vec3A) -> Option<TracedSurface<'_>> {
        self.bvh.nearest(origin, direction, FAR).map(|met| self.surface(&met, direction))
    }

    /// Share of light that reaches a point from infinity: none past an opaque body, a tinted share through glass, which
    /// does not bend it.
    pub fn arriving(&self, origin: Vec3A, toward_light: Vec3A) -> Vec3 {
        let mut arriving = Vec3::ONE;
        self.bvh.visit(origin, toward_light, FAR, |met| {
            let (material, albedo) = self.color(&met);
            if material.opacity >= OPAQUE {
                arriving = Vec3::ZERO;
                return -1.0;
            }
            let cosine = self.scene_buffers.facings()[met.triangle as usize].dot(toward_light).abs();
            arriving *= glass::tint(material, albedo)
                * (glass::passing(cosine, self.is_sheet(met.triangle))
                    * (1.0 - glass::body(material.opacity)));
            FAR
        });
        arriving
    }

    fn is_sheet(&self, triangle: u32) -> bool {
        !self.holds_glass[self.scene_buffers.triangles[triangle as usize].object as usize]
    }

    /// Material with the color of its texture at full size: samples of a pixel average it.
    fn color(&self, met: &Met) -> (&ShadingMaterial, Vec3) {
        let triangle = &self.scene_buffers.triangles[met.triangle as usize];
        let object = triangle.object as usize;
        let material = self.materials.material(self.materials.number(object, triangle.material as usize));
        let Some(texture) = material.texture else { return (material, material.base_color) };
        let [a, b, c] = self.uvs(triangle);
        let uv: Vec2 = a + met.u * (b - a) + met.v * (c - a);
        (material, material.base_color * self.textures[texture].sample(uv, 0.0))
    }

    /// Texture coordinates of the corners of a triangle.
    fn uvs(&self, triangle: &SourceTriangle) -> [Vec2; 3] {
        let object = triangle.object as usize;
        let (mesh, first) =
            (self.scene_buffers.objects[object].mesh, self.scene_buffers.first_vertex[object]);
        triangle.vertices.map(|v| mesh.uvs[(v - first) as usize])
    }

    /// A unit normal with the relief of the material.
    fn in_relief(&self, met: &Met, corners: [Vec3A; 3], normal: Vec3A) -> Vec3A {
        let triangle = &self.scene_buffers.triangles[met.triangle as usize];
        let number = self.materials.number(triangle.object as usize, triangle.material as usize);
        let material = self.materials.material(number);
        let Some(texture) = material.texture.filter(|_| material.relief > 0.0) else { return normal };
        let [a, b, c] = self.uvs(triangle);
        let axes = TextureAxes::new([corners[1] - corners[0], corners[2] - corners[0]], [b - a, c - a]);
        let uv = a + met.u * (b - a) + met.v * (c - a);
        axes.leaned(normal, slope(&self.textures[texture], material.relief, uv, 0.0))
    }

    fn surface(&self, met: &Met, direction: Vec3A) -> TracedSurface<'_> {
        let buffers = &self.scene_buffers;
        let triangle = &buffers.triangles[met.triangle as usize];
        let object = triangle.object as usize;
        let corners = triangle.vertices.map(|v| buffers.points_in_world[v as usize]);
        let weights = [1.0 - met.u - met.v, met.u, met.v];
        let point = (0..3).fold(Vec3A::ZERO, |sum, k| sum + weights[k] * corners[k]);
        let facing = buffers.facings()[met.triangle as usize];
        let is_front = facing.dot(direction) <= 0.0;
        let flat_normal = if is_front { facing } else { -facing };
        let first = buffers.first_vertex[object];
        let normals = triangle.vertices.map(|v| {
            let own = Vec3A::from(buffers.objects[object].mesh.normals[(v - first) as usize]);
            let normal = (self.world_from_object[object] * own).normalize_or(flat_normal);
            if normal.dot(flat_normal) < 0.0 { -normal } else { normal }
        });
        let smooth = (0..3).fold(Vec3A::ZERO, |sum, k| sum + weights[k] * normals[k]);
        let toward_eye = -direction;
        let (material, albedo) = self.color(met);
        let smooth = self.in_relief(met, corners, smooth.normalize_or(flat_normal));
        TracedSurface {
            point,
            flat_normal,
            normal: above(smooth, toward_eye),
            toward_eye,
            is_front,
            albedo,
            material,
            lifted: point + lift(point, corners, weights, normals),
            is_sheet: self.is_sheet(met.triangle),
        }
    }
}

impl TracedSurface<'_> {
    pub fn is_opaque(&self) -> bool {
        self.material.opacity >= OPAQUE
    }

    /// Start of a ray that leaves on the side of the flat normal.
    pub fn start(&self, at: Vec3A) -> Vec3A {
        off(at, self.flat_normal)
    }

    /// Start of a ray that goes through.
    pub fn start_behind(&self) -> Vec3A {
        off(self.point, -self.flat_normal)
    }
}

/// A point moved off a surface.
pub fn off(point: Vec3A, normal: Vec3A) -> Vec3A {
    point + normal * (OFFSET * point.abs().max_element().max(1.0))
}

/// The normal, turned until a direction lies above its surface: smooth normals can face away at an outline.
fn above(normal: Vec3A, toward_eye: Vec3A) -> Vec3A {
    const LOWEST: f32 = 0.01;
    let cosine = normal.dot(toward_eye);
    if cosine >= LOWEST { normal } else { (normal + (LOWEST - cosine) * toward_eye).normalize_or(toward_eye) }
}

/// Way from a point of a triangle to the curved surface that its normals describe (Hanika, "Hacking the shadow
/// terminator", Ray Tracing Gems II, 2021): without it, facets shade each other where light grazes a round body.
fn lift(point: Vec3A, corners: [Vec3A; 3], weights: [f32; 3], normals: [Vec3A; 3]) -> Vec3A {
    let lift = (0..3).fold(Vec3A::ZERO, |sum, k| {
        let below = (point - corners[k]).dot(normals[k]).min(0.0);
        sum - weights[k] * below * normals[k]
    });
    let [a, b, c] = corners;
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt();
    lift.clamp_length_max(MAX_LIFT * longest)
}
