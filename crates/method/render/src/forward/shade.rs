//! Shading of a surface point: Lambert and GGX under a key light, sky and mirrored surroundings.
//!
//! Metallic-roughness model of glTF 2.0 (appendix B): GGX distribution, Smith visibility, Schlick Fresnel; the
//! mirrored surroundings use Karis' fit of the split-sum table. Perspective-correct attributes come from intersecting
//! the pixel's ray with the triangle itself, so clipping needs no special case.

pub mod wear;

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use self::wear::SurfaceWear;
use super::backdrop::{Backdrop, BackdropPlace, Ray};
use super::environment::{Ambient, Environment};
use super::floor_light::FloorLight;
use super::partly_open::PartlyOpen;
use super::prepare::ViewGeometry;
use super::projection::Lens;
use super::relief::TextureAxes;
use super::scene_buffers::{SceneBuffers, SourceTriangle};
use super::shading_materials::ShadingMaterial;
use super::sky::SkyNearby;
use super::surface_colors::SurfaceColors;
use super::tone_curve::ToneCurve;
use crate::{Background, RenderObject};
use geometry::Pose;

/// Share of the light at the outline of glass that comes through it from another direction.
pub const RIM: f32 = 0.85;

/// Light, background and materials of an image: what shading needs that depends on no view.
pub struct Surroundings<'a> {
    pub environment: Environment<'a>,
    backdrop: Backdrop,
    colors: Arc<SurfaceColors<'a>>,
}

/// Everything that shading a point needs.
pub struct Shader<'a> {
    scene_buffers: &'a SceneBuffers<'a>,
    camera_points: &'a [Vec3],
    surroundings: &'a Surroundings<'a>,
    world_from_camera: Affine3A,
    world_from_object: Vec<Mat3A>,
    object_from_world: Vec<Affine3A>,
    /// Of each triangle, unit, in the world, by its winding.
    facings: &'a [Vec3A],
}

/// Light from a point toward the eye as long as nothing that moves is in its way, and where its shadows are sought.
#[derive(Clone, Copy, Default)]
pub struct StillLight {
    /// Without the key light.
    pub base: Vec3,
    /// Contribution of the key light, past everything that does not move.
    pub key: Vec3,
    /// Point on which shadows fall; `turn` is the rotation of the sampling pattern there.
    pub point: Vec3A,
    pub flat_normal: Vec3A,
    pub turn: f32,
}

/// Intersection of a pixel's ray with the plane of a triangle.
struct Hit {
    object: usize,
    /// In the mesh.
    vertices: [usize; 3],
    weights: [f32; 3],
    in_camera: Vec3,
    /// Sides from the first corner, camera's frame.
    sides: [Vec3; 2],
}

/// A point of a triangle seen through a pixel.
pub struct Surface {
    pub point: Vec3A,
    /// Unit, smooth, turned toward the eye.
    pub normal: Vec3A,
    /// Unit, of the flat triangle, turned toward the eye.
    pub flat_normal: Vec3A,
    pub toward_eye: Vec3A,
    pub uv: Vec2,
    /// Zero where the material has no relief.
    pub texture_axes: TextureAxes,
    /// Texture repeats squared per square meter.
    pub uv_density: f32,
    /// Number of its material among those of all objects.
    pub material: usize,
    /// Index of its object.
    object: usize,
}

/// Light that arrives at a surface point, as far as it does not depend on the surface's own color.
pub struct Incidence {
    key: Option<KeyIncidence>,
    diffuse: PartlyOpen,
    mirrored: PartlyOpen,
    /// Factor and addend that make the mirrored share of the reflectance at normal incidence.
    mirror_share: (f32, f32),
}

/// The key light at a surface point that it reaches.
struct KeyIncidence {
    light: Vec3,
    /// Share of Fresnel's grazing term.
    grazing: f32,
    shine: f32,
}

impl<'a> Surroundings<'a> {
    pub fn new(
        scene_buffers: &SceneBuffers<'a>,
        environment: Environment<'a>,
        background: Background,
        colors: Arc<SurfaceColors<'a>>,
    ) -> Self {
        let floor_light =
            background.floor_z_m().map(|z_m| FloorLight::new(scene_buffers, &environment, z_m as f32));
        let backdrop = Backdrop::new(background, &environment, floor_light);
        Self { environment, backdrop, colors }
    }
}

impl<'a> Shader<'a> {
    pub fn new(
        scene_buffers: &'a SceneBuffers<'a>,
        prepared: &'a ViewGeometry,
        surroundings: &'a Surroundings<'a>,
        world_from_camera: Affine3A,
    ) -> Self {
        let turn = |object: &RenderObject| Mat3A::from_quat(object.world_from_object.rotation.as_quat());
        Self {
            scene_buffers,
            camera_points: &prepared.camera_points,
            surroundings,
            world_from_camera,
            world_from_object: scene_buffers.objects.iter().map(turn).collect(),
            object_from_world: scene_buffers.objects.iter().map(object_from_world).collect(),
            facings: scene_buffers.facings(),
        }
    }

    fn hit(&self, source: &SourceTriangle, lens: &Lens, x: f32, y: f32) -> Hit {
        let point = |v: u32| self.camera_points[v as usize];
        let [i, j, k] = source.vertices;
        let (a, b, c) = (point(i), point(j), point(k));
        let (origin, direction) = lens.ray(x, y);
        let (e1, e2) = (b - a, c - a);
        let across = direction.cross(e2);
        let determinant = e1.dot(across);
        // Edge-on, every point of the triangle is on the ray to within rounding: the first corner serves.
        let inverse = if determinant.abs() > 1e-30 { 1.0 / determinant } else { 0.0 };
        let from_a = origin - a;
        // Rounding at an edge must not take attributes from outside the triangle.
        let u = (from_a.dot(across) * inverse).clamp(0.0, 1.0);
        let v = (direction.dot(from_a.cross(e1)) * inverse).clamp(0.0, 1.0 - u);
        let object = source.object as usize;
        let first = self.scene_buffers.first_vertex[object];
        Hit {
            object,
            vertices: [(i - first) as usize, (j - first) as usize, (k - first) as usize],
            weights: [1.0 - u - v, u, v],
            in_camera: a + u * e1 + v * e2,
            sides: [e1, e2],
        }
    }

    /// Unit, smooth, turned to the side of `flat_normal`.
    fn smooth_normal(&self, hit: &Hit, flat_normal: Vec3A) -> Vec3A {
        let normals = &self.scene_buffers.objects[hit.object].mesh.normals;
        let smooth = (0..3).fold(Vec3::ZERO, |sum, k| sum + hit.weights[k] * normals[hit.vertices[k]]);
        let normal = (self.world_from_object[hit.object] * Vec3A::from(smooth)).normalize_or(flat_normal);
        if normal.dot(flat_normal) < 0.0 { -normal } else { normal }
    }

    /// Unit, from the surface point back along the ray.
    fn toward_eye(&self, in_camera: Vec3, lens: &Lens) -> Vec3A {
        let away = if lens.perspective { in_camera } else { Vec3::Z };
        -self.world_from_camera.transform_vector3a(Vec3A::from(away)).normalize_or_zero()
    }

    /// Unit, of the flat triangle, turned toward the eye.
    fn flat_normal(&self, source: u32, toward_eye: Vec3A) -> Vec3A {
        let normal = self.facings[source as usize];
        if normal.dot(toward_eye) < 0.0 { -normal } else { normal }
    }

    /// Unit smooth normal, facing the eye: the normal of [`Self::surface`] without its other fields.
    pub fn normal(&self, source: u32, lens: &Lens, x: f32, y: f32) -> Vec3A {
        let hit = self.hit(&self.scene_buffers.triangles[source as usize], lens, x, y);
        self.smooth_normal(&hit, self.flat_normal(source, self.toward_eye(hit.in_camera, lens)))
    }

    /// The point of the triangle on the ray through a sample position.
    pub fn surface(&self, source: u32, lens: &Lens, x: f32, y: f32) -> Surface {
        let triangle = &self.scene_buffers.triangles[source as usize];
        let hit = self.hit(triangle, lens, x, y);
        let toward_eye = self.toward_eye(hit.in_camera, lens);
        let flat_normal = self.flat_normal(source, toward_eye);
        let uvs = &self.scene_buffers.objects[hit.object].mesh.uvs;
        let [i, j, k] = hit.vertices;
        let uvs = [uvs[i], uvs[j], uvs[k]];
        let uv_area = (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs();
        let area = hit.sides[0].cross(hit.sides[1]).length();
        let material = self.surroundings.colors.materials.number(hit.object, triangle.material as usize);
        let sides = hit.sides.map(|side| self.world_from_camera.transform_vector3a(Vec3A::from(side)));
        let texture_axes = match self.surroundings.colors.materials.material(material).relief > 0.0 {
            true => TextureAxes::new(sides, [uvs[1] - uvs[0], uvs[2] - uvs[0]]),
            false => TextureAxes::default(),
        };
        Surface {
            point: self.world_from_camera.transform_point3a(Vec3A::from(hit.in_camera)),
            normal: self.smooth_normal(&hit, flat_normal),
            flat_normal,
            toward_eye,
            uv: (0..3).fold(Vec2::ZERO, |sum, k| sum + hit.weights[k] * uvs[k]),
            uv_density: uv_area / area.max(1e-20),
            texture_axes,
            material,
            object: hit.object,
        }
    }

    /// Whether two triangles belong to one smooth piece of one material: same object, same material, and
    /// planes within about 15 degrees.
    pub fn continues(&self, a: u32, b: u32) -> bool {
        let (p, q) = (&self.scene_buffers.triangles[a as usize], &self.scene_buffers.triangles[b as usize]);
        p.object == q.object
            && p.material == q.material
            && self.facings[a as usize].dot(self.facings[b as usize]) > 0.965
    }

    /// Linear light leaving an opaque surface point toward the eye. `nearby` caches the sky share for neighboring
    /// pixels; `turn` (0..1) is the pixel's rotation of the shadow sampling pattern.
    pub fn color(&self, s: &Surface, pixel_size_m: f32, turn: f32, nearby: &mut SkyNearby) -> Vec3 {
        let environment = &self.surroundings.environment;
        let reaching = || environment.key_visibility(s.point, s.flat_normal, turn);
        self.color_in(s, pixel_size_m, nearby, reaching)
    }

    /// The light of [`Self::color`], open for shadows of what moves.
    pub fn still_color(
        &self,
        s: &Surface,
        pixel_size_m: f32,
        turn: f32,
        nearby: &mut SkyNearby,
    ) -> StillLight {
        let environment = &self.surroundings.environment;
        let base = self.color_in(s, pixel_size_m, nearby, || Vec3::ZERO);
        let reaching = || environment.past_still(s.point, s.flat_normal, turn);
        let key = self.color_in(s, pixel_size_m, nearby, reaching) - base;
        StillLight { base, key, point: s.point, flat_normal: s.flat_normal, turn }
    }

    fn color_in(
        &self,
        s: &Surface,
        pixel_size_m: f32,
        nearby: &mut SkyNearby,
        reaching: impl Fn() -> Vec3,
    ) -> Vec3 {
        let Surroundings { environment, colors, .. } = self.surroundings;
        let ambient = nearby.at(environment, (s.point, s.flat_normal, s.normal), pixel_size_m);
        let wear = self.wear(s, pixel_size_m);
        let incidence =
            self.incidence(s, self.normal_in_relief(s, pixel_size_m), &ambient, wear.roughness, reaching);
        let material = colors.material(s);
        let mut albedo = colors.albedo(s, pixel_size_m);
        if material.texture.is_none() {
            albedo *= wear.color;
        }
        let (diffuse, specular) = incidence.reflected(material, albedo);
        (diffuse + specular) * environment.lighting.exposure
    }

    /// Unevenness of a surface point. Images outside of rooms, which are compared with others, have none.
    fn wear(&self, s: &Surface, pixel_size_m: f32) -> SurfaceWear {
        match self.surroundings.environment.room {
            Some(_) => {
                let in_object = self.object_from_world[s.object].transform_point3a(s.point);
                SurfaceWear::at(in_object, pixel_size_m, s.material as u32)
            }
            None => SurfaceWear::NONE,
        }
    }

    /// The light of [`Self::color`] for each of several sets of colors, which differ in base colors and textures only.
    pub fn colors_in<const SETS: usize>(
        &self,
        sets: [&SurfaceColors; SETS],
        s: &Surface,
        pixel_size_m: f32,
        turn: f32,
    ) -> [Vec3; SETS] {
        let environment = &self.surroundings.environment;
        let ambient = environment.ambient(s.point, s.flat_normal, s.normal);
        let wear = self.wear(s, pixel_size_m);
        let normal = self.normal_in_relief(s, pixel_size_m);
        let incidence = self.incidence(s, normal, &ambient, wear.roughness, || {
            environment.key_visibility(s.point, s.flat_normal, turn)
        });
        let mut light = [Vec3::ZERO; SETS];
        for (light, colors) in light.iter_mut().zip(sets) {
            let material = colors.material(s);
            let mut albedo = colors.albedo(s, pixel_size_m);
            if material.texture.is_none() {
                albedo *= wear.color;
            }
            let (diffuse, specular) = incidence.reflected(material, albedo);
            *light = (diffuse + specular) * environment.lighting.exposure;
        }
        light
    }

    /// A transparent surface: the light it adds, and the factor on the light from behind.
    pub fn glass(&self, s: &Surface, pixel_size_m: f32, turn: f32) -> (Vec3, Vec3) {
        let [glass] = self.glass_in([&*self.surroundings.colors], s, pixel_size_m, turn);
        glass
    }

    /// [`Self::glass`] for each of several sets of colors, which differ in base colors and textures only.
    pub fn glass_in<const SETS: usize>(
        &self,
        sets: [&SurfaceColors; SETS],
        s: &Surface,
        pixel_size_m: f32,
        turn: f32,
    ) -> [(Vec3, Vec3); SETS] {
        let environment = &self.surroundings.environment;
        let ambient = environment.ambient(s.point, s.flat_normal, s.normal);
        let reaching = || environment.key_visibility(s.point, s.flat_normal, turn);
        let incidence = self.incidence(s, s.normal, &ambient, 1.0, reaching);
        let facing = s.normal.dot(s.toward_eye).clamp(0.0, 1.0);
        let grazing = (1.0 - facing).powi(3);
        let rim = environment.room.as_ref().map(|room| room.refracted(s, &ambient));
        let mut blended = [(Vec3::ZERO, Vec3::ZERO); SETS];
        for ((added, passed), colors) in blended.iter_mut().zip(sets) {
            let (material, albedo) = (colors.material(s), colors.albedo(s, pixel_size_m));
            let (diffuse, specular) = incidence.reflected(material, albedo);
            let opacity = material.opacity;
            let tint = Vec3::ONE.lerp(albedo, 0.35 + 0.3 * opacity);
            let light = match rim {
                // Clean glass is seen by what it mirrors, and by its outline, where it shows another part of the room.
                Some(rim) => {
                    let solid = opacity * opacity * (0.2 + 0.8 * opacity);
                    let bent = RIM * grazing * (1.0 - opacity);
                    *passed = tint * ((1.0 - solid) * (1.0 - bent));
                    diffuse * solid * 0.5 + specular + rim * tint * tint * bent
                }
                None => {
                    let solid = opacity + (1.0 - opacity) * 0.35 * grazing;
                    *passed = tint * (1.0 - solid);
                    diffuse * solid * 0.8 + specular
                }
            };
            *added = light * environment.lighting.exposure;
        }
        blended
    }

    /// Unit normal with the relief of the material, which images outside of rooms do not show.
    fn normal_in_relief(&self, s: &Surface, pixel_size_m: f32) -> Vec3A {
        match self.surroundings.environment.room {
            Some(_) => self.surroundings.colors.normal(s, pixel_size_m),
            None => s.normal,
        }
    }

    /// `n` is the unit normal, `wear` a factor on the roughness.
    fn incidence(
        &self,
        s: &Surface,
        n: Vec3A,
        ambient: &Ambient,
        wear: f32,
        reaching: impl Fn() -> Vec3,
    ) -> Incidence {
        let Surroundings { environment, colors, .. } = self.surroundings;
        let roughness = (colors.material(s).roughness * wear).min(1.0);
        let lighting = &environment.lighting;
        let (v, l) = (s.toward_eye, environment.toward_key);
        let nv = n.dot(v).clamp(0.02, 1.0);
        // The flat normal fades the light out before the flat face turns away from it, where the smooth normal alone
        // would end in a hard edge of facets.
        let nl = n.dot(l).min(2.0 * s.flat_normal.dot(l)).max(0.0);
        let mut key = None;
        if nl > 0.0 {
            let reaching = reaching();
            if reaching != Vec3::ZERO {
                let h = (l + v).normalize_or_zero();
                // A light of finite size blurs the highlight (Karis 2013).
                let alpha = (roughness * roughness + 0.4 * lighting.key_radius_rad as f32).min(1.0);
                let a2 = alpha * alpha;
                let nh = n.dot(h).clamp(0.0, 1.0);
                let d = nh * nh * (a2 - 1.0) + 1.0;
                let smith = nl * (nv * nv * (1.0 - a2) + a2).sqrt() + nv * (nl * nl * (1.0 - a2) + a2).sqrt();
                // GGX times Smith's visibility. The key's color is its irradiance over pi, which cancels the 1 / pi of
                // GGX.
                let shine = 0.5 * a2 / (d * d * smith.max(1e-4));
                key = Some(KeyIncidence {
                    light: lighting.key_color * nl * reaching,
                    grazing: (1.0 - v.dot(h).clamp(0.0, 1.0)).powi(5),
                    shine: shine.min(12.0),
                });
            }
        }
        let r = 2.0 * n.dot(v) * n - v;
        let (seen, mirror_share) = (ambient.seen, mirror_share(roughness, nv));
        if let Some(room) = &environment.room {
            return Incidence {
                key,
                diffuse: room.diffuse(n, ambient),
                mirrored: room.mirrored(s.point, r, roughness, ambient),
                mirror_share,
            };
        }
        let up = 0.5 + 0.5 * n.z;
        let up_flat = 0.5 + 0.5 * s.flat_normal.z;
        // Occlusion is evaluated for the flat face, since a smooth normal would leak through it, and rescaled to the
        // smooth normal.
        let smooth_over_flat = (lighting.sky_color * up + lighting.ground_color * (1.0 - up))
            / (lighting.sky_color * up_flat + lighting.ground_color * (1.0 - up_flat)).max(Vec3::splat(1e-3));
        let occlusion = (0.25 + 0.75 * seen.open).min(1.0);
        Incidence {
            key,
            diffuse: PartlyOpen::whole(environment.diffuse(s.flat_normal, seen) * smooth_over_flat),
            mirrored: PartlyOpen::whole(environment.mirrored(r, roughness) * occlusion),
            mirror_share,
        }
    }

    /// Curve from light to image.
    pub fn tone_curve(&self) -> ToneCurve {
        self.surroundings.environment.tone_curve()
    }

    /// The backdrop at height `fraction` of the image (0 = top), dimmed by shadows on its floor.
    pub fn backdrop(&self, fraction: f32, lens: &Lens, x: f32, y: f32, turn: f32) -> Vec3 {
        let Surroundings { environment, backdrop, .. } = self.surroundings;
        let place = self.backdrop_place(fraction, lens, x, y);
        match &place.receiver {
            Some(at) => backdrop.tinted_light(&place, environment.key_visibility(at.point, at.normal, turn)),
            None => backdrop.light(&place, 0.0),
        }
    }

    /// The light of [`Self::backdrop`], open for shadows of what moves.
    pub fn still_backdrop(&self, fraction: f32, lens: &Lens, x: f32, y: f32, turn: f32) -> StillLight {
        let Surroundings { environment, backdrop, .. } = self.surroundings;
        let place = self.backdrop_place(fraction, lens, x, y);
        let base = backdrop.light(&place, 0.0);
        let Some(at) = &place.receiver else {
            return StillLight { base, key: Vec3::ZERO, point: Vec3A::ZERO, flat_normal: Vec3A::Z, turn };
        };
        let reaching = environment.past_still(at.point, at.normal, turn);
        let key = backdrop.tinted_light(&place, reaching) - base;
        StillLight { base, key, point: at.point, flat_normal: at.normal, turn }
    }

    /// Backdrop along the ray through a sample position.
    fn backdrop_place(&self, fraction: f32, lens: &Lens, x: f32, y: f32) -> BackdropPlace {
        let (origin, direction) = lens.ray(x, y);
        let ray = Ray {
            origin: self.world_from_camera.transform_point3a(Vec3A::from(origin)),
            direction: self.world_from_camera.transform_vector3a(Vec3A::from(direction)),
        };
        let Surroundings { environment, backdrop, .. } = self.surroundings;
        backdrop.place(environment, &ray, fraction, |depth| lens.pixel_size_m(depth))
    }
}

impl Incidence {
    /// Diffuse and specular light that a surface of that color reflects.
    #[inline]
    fn reflected(&self, material: &ShadingMaterial, albedo: Vec3) -> (Vec3, Vec3) {
        let f0 = Vec3::splat(0.04).lerp(albedo, material.metalness);
        let matte = albedo * (1.0 - material.metalness);
        let mut diffuse = Vec3::ZERO;
        let mut specular = Vec3::ZERO;
        if let Some(key) = &self.key {
            let fresnel = f0 + (Vec3::ONE - f0) * key.grazing;
            diffuse += matte * key.light;
            specular += fresnel * key.light * key.shine;
        }
        diffuse += matte * self.diffuse.between(albedo);
        let (scale, offset) = self.mirror_share;
        specular += self.mirrored.between(f0) * (f0 * scale + Vec3::splat(offset));
        (diffuse, specular)
    }
}

/// Frame of an object from that of the world.
pub fn object_from_world(object: &RenderObject) -> Affine3A {
    let Pose { rotation, translation_m } = object.world_from_object.inverse();
    Affine3A::from_rotation_translation(rotation.as_quat(), translation_m.as_vec3())
}

/// Share of the surroundings a surface mirrors, as a factor on its reflectance at normal incidence and an addend
/// (Karis, "Physically based shading on mobile", 2014).
fn mirror_share(roughness: f32, nv: f32) -> (f32, f32) {
    let r =
        [1.0 - roughness, 0.0425 - 0.0275 * roughness, 1.04 - 0.572 * roughness, 0.022 * roughness - 0.04];
    let a004 = (r[0] * r[0]).min((-9.28 * nv).exp2()) * r[0] + r[1];
    let (scale, offset) = (-1.04 * a004 + r[2], 1.04 * a004 + r[3]);
    (scale, offset.max(0.0))
}
