//! The color of a surface point: Lambert and GGX under a key light, sky and mirrored surroundings.
//!
//! Metallic-roughness model of glTF 2.0 (appendix B): GGX distribution, Smith visibility, Schlick
//! Fresnel; the mirrored surroundings use Karis' fit of the split-sum table. Perspective-correct
//! attributes come from meeting the pixel's ray with the triangle itself, so clipping needs no care.

use glam::{Mat3A, Vec2, Vec3, Vec3A};

use super::environment::Environment;
use super::floor_light::FloorLight;
use super::prepare::Prepared;
use super::projection::Lens;
use super::texture_map::TextureMap;
use super::{Background, RenderObject, RenderScene};
use crate::geometry::Texture;

/// A material as the shader wants it.
struct Look {
    /// Linear light.
    base_color: Vec3,
    texture: Option<usize>,
    roughness: f32,
    metalness: f32,
    opacity: f32,
}

/// Everything needed to color a point of the scene.
pub struct Shader<'a> {
    objects: &'a [RenderObject<'a>],
    prepared: &'a Prepared,
    environment: Environment,
    background: Background,
    floor_light: Option<FloorLight>,
    world_from_camera: glam::Affine3A,
    world_from_object: Vec<Mat3A>,
    looks: Vec<Look>,
    first_look: Vec<usize>,
    textures: Vec<TextureMap>,
}

/// A point of a triangle seen through a pixel.
pub struct Surface {
    point: Vec3A,
    /// Unit, smooth, turned toward the eye.
    pub normal: Vec3A,
    /// Unit, of the flat triangle, turned toward the eye.
    flat_normal: Vec3A,
    toward_eye: Vec3A,
    uv: Vec2,
    /// Texture repeats squared per square meter.
    uv_density: f32,
    look: usize,
}

impl<'a> Shader<'a> {
    pub fn new(
        scene: &'a RenderScene<'a>,
        prepared: &'a Prepared,
        environment: Environment,
        world_from_camera: glam::Affine3A,
    ) -> Self {
        let mut known: Vec<&Texture> = Vec::new();
        let (mut looks, mut first_look) = (Vec::new(), Vec::new());
        for object in &scene.objects {
            first_look.push(looks.len());
            for material in &object.mesh.materials {
                let texture = material.base_color_texture.as_ref().map(|texture| {
                    known.iter().position(|k| std::sync::Arc::ptr_eq(k, texture)).unwrap_or_else(|| {
                        known.push(texture);
                        known.len() - 1
                    })
                });
                looks.push(Look {
                    base_color: Vec3::from(material.base_color.to_linear()),
                    texture,
                    roughness: material.roughness.clamp(0.03, 1.0),
                    metalness: material.metalness.clamp(0.0, 1.0),
                    opacity: material.opacity.clamp(0.0, 1.0),
                });
            }
        }
        use rayon::prelude::*;
        let textures = known.par_iter().map(|texture| TextureMap::new(texture)).collect();
        let turn = |object: &RenderObject| Mat3A::from_quat(object.world_from_object.rotation.as_quat());
        let floor_light = scene
            .background
            .floor
            .map(|floor| FloorLight::new(&scene.objects, &environment, floor.z_m as f32));
        Self {
            objects: &scene.objects,
            prepared,
            floor_light,
            environment,
            background: scene.background,
            world_from_camera,
            world_from_object: scene.objects.iter().map(turn).collect(),
            looks,
            first_look,
            textures,
        }
    }

    /// The point of the triangle on the ray through a sample position.
    pub fn surface(&self, source: u32, lens: &Lens, x: f32, y: f32) -> Surface {
        let source = &self.prepared.sources[source as usize];
        let [a, b, c] = source.vertices.map(|v| self.prepared.camera_points[v as usize]);
        let (origin, direction) = lens.ray(x, y);
        let (e1, e2) = (b - a, c - a);
        let across = direction.cross(e2);
        let determinant = e1.dot(across);
        let inverse = if determinant.abs() > 1e-30 { 1.0 / determinant } else { 0.0 };
        let from_a = origin - a;
        let u = (from_a.dot(across) * inverse).clamp(0.0, 1.0);
        let v = (direction.dot(from_a.cross(e1)) * inverse).clamp(0.0, 1.0 - u);
        let in_camera = a + u * e1 + v * e2;
        let object = source.object as usize;
        let mesh = self.objects[object].mesh;
        let first = self.prepared.first_vertex[object];
        let [i, j, k] = source.vertices.map(|v| (v - first) as usize);
        let w = 1.0 - u - v;
        let smooth = w * mesh.normals[i] + u * mesh.normals[j] + v * mesh.normals[k];
        let point = self.world_from_camera.transform_point3a(Vec3A::from(in_camera));
        let away = if lens.perspective { in_camera } else { direction };
        let toward_eye = -self.world_from_camera.transform_vector3a(Vec3A::from(away)).normalize_or_zero();
        let cross = e1.cross(e2);
        let mut flat_normal =
            self.world_from_camera.transform_vector3a(Vec3A::from(cross)).normalize_or_zero();
        if flat_normal.dot(toward_eye) < 0.0 {
            flat_normal = -flat_normal;
        }
        let mut normal = (self.world_from_object[object] * Vec3A::from(smooth)).normalize_or(flat_normal);
        if normal.dot(flat_normal) < 0.0 {
            normal = -normal;
        }
        let (uv_i, uv_j, uv_k) = (mesh.uvs[i], mesh.uvs[j], mesh.uvs[k]);
        let uv_area = (uv_j - uv_i).perp_dot(uv_k - uv_i).abs();
        Surface {
            point,
            normal,
            flat_normal,
            toward_eye,
            uv: w * uv_i + u * uv_j + v * uv_k,
            uv_density: uv_area / cross.length().max(1e-20),
            look: self.first_look[object] + source.material as usize,
        }
    }

    /// Whether two triangles belong to one smooth piece of one material: same object, same material, and
    /// planes within about 15 degrees.
    pub fn continues(&self, a: u32, b: u32) -> bool {
        let (a, b) = (&self.prepared.sources[a as usize], &self.prepared.sources[b as usize]);
        if a.object != b.object || a.material != b.material {
            return false;
        }
        let normal = |source: &super::prepare::SourceTriangle| {
            let [p, q, r] = source.vertices.map(|v| self.prepared.camera_points[v as usize]);
            (q - p).cross(r - p).normalize_or_zero()
        };
        normal(a).dot(normal(b)) > 0.965
    }

    /// Linear light leaving an opaque surface point toward the eye.
    pub fn color(&self, s: &Surface, pixel_size_m: f32, turn_rad: f32) -> Vec3 {
        let look = &self.looks[s.look];
        let albedo = self.albedo(s, look, pixel_size_m);
        let (diffuse, specular) = self.reflected(s, look, albedo, turn_rad);
        (diffuse + specular) * self.environment.lighting.exposure
    }

    /// A see-through surface: what it adds, and the factor on what lies behind.
    pub fn glass(&self, s: &Surface, pixel_size_m: f32, turn_rad: f32) -> (Vec3, Vec3) {
        let look = &self.looks[s.look];
        let albedo = self.albedo(s, look, pixel_size_m);
        let (diffuse, specular) = self.reflected(s, look, albedo, turn_rad);
        let facing = s.normal.dot(s.toward_eye).clamp(0.0, 1.0);
        let grazing = (1.0 - facing).powi(3);
        let solid = look.opacity + (1.0 - look.opacity) * 0.35 * grazing;
        let tint = Vec3::ONE.lerp(albedo, 0.35 + 0.3 * look.opacity);
        let added = (diffuse * solid * 0.8 + specular) * self.environment.lighting.exposure;
        (added, tint * (1.0 - solid))
    }

    fn albedo(&self, s: &Surface, look: &Look, pixel_size_m: f32) -> Vec3 {
        let Some(texture) = look.texture else { return look.base_color };
        let texture = &self.textures[texture];
        let facing = s.flat_normal.dot(s.toward_eye).max(0.05);
        let texels = s.uv_density * texture.area_texels() * pixel_size_m * pixel_size_m / facing;
        look.base_color * texture.sample(s.uv, 0.5 * texels.max(1.0).log2() - 0.25)
    }

    fn reflected(&self, s: &Surface, look: &Look, albedo: Vec3, turn_rad: f32) -> (Vec3, Vec3) {
        let lighting = &self.environment.lighting;
        let (n, v, l) = (s.normal, s.toward_eye, self.environment.toward_key);
        let nv = n.dot(v).clamp(0.02, 1.0);
        let nl = n.dot(l).min(2.0 * s.flat_normal.dot(l)).max(0.0);
        let f0 = Vec3::splat(0.04).lerp(albedo, look.metalness);
        let matte = albedo * (1.0 - look.metalness);
        let mut diffuse = Vec3::ZERO;
        let mut specular = Vec3::ZERO;
        if nl > 0.0 {
            let reaching = self.environment.key_visibility(s.point, s.flat_normal, turn_rad);
            if reaching > 0.0 {
                let key = lighting.key_color * (nl * reaching);
                let h = (l + v).normalize_or_zero();
                // A light of finite size blurs the highlight (Karis 2013).
                let alpha = (look.roughness * look.roughness + 0.4 * lighting.key_radius_rad as f32).min(1.0);
                let a2 = alpha * alpha;
                let nh = n.dot(h).clamp(0.0, 1.0);
                let d = nh * nh * (a2 - 1.0) + 1.0;
                let smith = nl * (nv * nv * (1.0 - a2) + a2).sqrt() + nv * (nl * nl * (1.0 - a2) + a2).sqrt();
                let shine = 0.5 * a2 / (d * d * smith.max(1e-4));
                let fresnel = f0 + (Vec3::ONE - f0) * (1.0 - v.dot(h).clamp(0.0, 1.0)).powi(5);
                diffuse += matte * key;
                specular += fresnel * key * shine.min(12.0);
            }
        }
        let sky = self.environment.sky_light(s.point, s.flat_normal);
        let up = 0.5 + 0.5 * n.z;
        let up_flat = 0.5 + 0.5 * s.flat_normal.z;
        // Occlusion is that of the flat face (a smooth normal would leak through it); its brightness is
        // carried over to the smooth one.
        let smooth_over_flat = (lighting.sky_color * up + lighting.ground_color * (1.0 - up))
            / (lighting.sky_color * up_flat + lighting.ground_color * (1.0 - up_flat)).max(Vec3::splat(1e-3));
        diffuse += matte * sky.diffuse * smooth_over_flat;
        let r = 2.0 * n.dot(v) * n - v;
        let surroundings = self.environment.mirrored(r, look.roughness);
        let occlusion = (0.25 + 0.75 * sky.openness).min(1.0);
        specular += surroundings * mirror_share(f0, look.roughness, nv) * occlusion;
        (diffuse, specular)
    }

    /// The backdrop at height `fraction` of the picture (0 = top), dimmed by shadows on its floor.
    pub fn backdrop(&self, fraction: f32, lens: &Lens, x: f32, y: f32, turn_rad: f32) -> Vec3 {
        let color = self.background.top_color.lerp(self.background.bottom_color, fraction);
        let Some(floor) = self.background.floor else { return color };
        let (origin, direction) = lens.ray(x, y);
        let origin = self.world_from_camera.transform_point3a(Vec3A::from(origin));
        let direction = self.world_from_camera.transform_vector3a(Vec3A::from(direction));
        let t = (floor.z_m as f32 - origin.z) / direction.z;
        if !t.is_finite() || t <= 0.0 {
            return color;
        }
        let point = origin + t * direction;
        let lighting = &self.environment.lighting;
        let up = Vec3A::Z;
        let key = lighting.key_color * self.environment.toward_key.z.max(0.0);
        let reaching = self.environment.key_visibility(point, up, turn_rad);
        let sky = self.floor_light.as_ref().map_or(lighting.sky_color, |light| light.at(point));
        let arriving = key * reaching + sky;
        color * (arriving / (key + lighting.sky_color).max(Vec3::splat(1e-3))).min(Vec3::ONE)
    }
}

/// Share of the surroundings a surface mirrors (Karis, "Physically based shading on mobile", 2014).
fn mirror_share(f0: Vec3, roughness: f32, nv: f32) -> Vec3 {
    let r =
        [1.0 - roughness, 0.0425 - 0.0275 * roughness, 1.04 - 0.572 * roughness, 0.022 * roughness - 0.04];
    let a004 = (r[0] * r[0]).min((-9.28 * nv).exp2()) * r[0] + r[1];
    let (scale, offset) = (-1.04 * a004 + r[2], 1.04 * a004 + r[3]);
    f0 * scale + Vec3::splat(offset.max(0.0))
}
