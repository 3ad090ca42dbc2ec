//! Images of the finished scene: hero, top, four sides, the view of the reference image, thumbnails.

mod hidden;

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use geometry::{Camera, Pose, TexturedMesh};
use gpu::{Gpu, GpuError};
use imaging::Image;
use render::gpu::GpuSceneCache;
use render::{
    Background, GeometryFrame, Lighting, RenderObject, RenderScene, RenderSettings, Room, SceneCache,
    Tabletop, TopView, View,
};
use scene::Light;

pub use hidden::HiddenShares;

/// Section `[preview]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PreviewSettings {
    /// Width of the hero image, pixels, 64..4096; more shows more and takes longer.
    pub hero_width_px: u32,
    /// Width of the side and top views and of either half of the image beside the reference, pixels,
    /// 64..4096.
    pub side_width_px: u32,
}

/// One body to be shown.
pub struct PreviewBody<'a> {
    pub mesh: &'a TexturedMesh,
    pub world_from_object: Pose,
}

/// Place from which a preview shows the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewpoint {
    Hero,
    Front,
    Right,
    Back,
    Left,
    Top,
}

impl Viewpoint {
    /// Direction of the viewer: 0 = from the front edge, pi/2 = from +x; `None` of the hero image, which chooses.
    fn azimuth_rad(self) -> Option<f64> {
        Some(match self {
            Self::Hero => return None,
            Self::Front | Self::Top => 0.0,
            Self::Right => FRAC_PI_2,
            Self::Back => PI,
            Self::Left => -FRAC_PI_2,
        })
    }
}

/// Horizontal field of view of all previews but the reference view, radians (about 30 degrees).
const FOV_X_RAD: f64 = 0.52;

/// Directions of the hero image, from the front edge toward +x, radians: the first from which all objects are seen.
const HERO_AZIMUTHS_RAD: [f64; 6] = [0.42, -0.42, 0.15, -0.15, 0.75, -0.75];

/// Smallest half of the width and depth that the hero image shows, meters: about a hand's breadth.
const MIN_HERO_HALF_M: f64 = 0.08;

/// The bodies in a studio, ready to be rendered from every side; ids count from 1 in the order given. The
/// floor lies under the lowest point. On a GPU, if it is put on one: an image that does not fit there is the CPU's,
/// with a line in the log, and an error means that the device is broken.
pub struct Studio<'a> {
    bodies: &'a [PreviewBody<'a>],
    scene_cache: Arc<SceneCache<'a>>,
    on_gpu: Option<GpuSceneCache<'a>>,
    /// Light of the scene, if it is not the studio's.
    lit_by: Option<Light>,
    /// Surroundings of hero and sides, if these are not in the studio.
    room: Option<Room>,
    hero_azimuth_rad: f64,
    low_m: DVec3,
    high_m: DVec3,
}

impl<'a> Studio<'a> {
    pub fn new(bodies: &'a [PreviewBody<'a>], quality: &RenderSettings) -> Self {
        Self::of(bodies, |objects| SceneCache::new(objects, quality))
    }

    fn of(
        bodies: &'a [PreviewBody<'a>],
        cached: impl FnOnce(Vec<RenderObject<'a>>) -> SceneCache<'a>,
    ) -> Self {
        let (low_m, high_m) = bounds(bodies);
        let scene_cache = Arc::new(cached(objects(bodies)));
        let [hero_azimuth_rad, ..] = HERO_AZIMUTHS_RAD;
        Self { bodies, scene_cache, on_gpu: None, lit_by: None, room: None, hero_azimuth_rad, low_m, high_m }
    }

    /// A studio with a room of that seed around the first body, a table, for images that people see; the hero image is
    /// from where objects hide each other least. Images that are compared with others stay in the studio.
    pub fn with_room(bodies: &'a [PreviewBody<'a>], quality: &RenderSettings, seed: u64) -> Self {
        let studio = Self::of(bodies, |objects| SceneCache::new(objects, quality).for_rooms());
        let table = bodies.first().map(|table| RenderObject {
            mesh: table.mesh,
            world_from_object: table.world_from_object,
            id: 1,
        });
        let around = |table| Room::around(studio.low_m, studio.high_m, Tabletop::of(&table), seed);
        Self { room: table.map(around), hero_azimuth_rad: studio.clearest_azimuth_rad(), ..studio }
    }

    /// Returns the studio in another light, which stays where it is when the viewer moves.
    pub fn lit_by(mut self, light: Option<Light>) -> Self {
        self.lit_by = light;
        self
    }

    /// Returns the studio rendered by the GPU.
    pub fn on(mut self, gpu: Arc<Gpu>) -> Result<Self, GpuError> {
        self.on_gpu = unless_unfit(GpuSceneCache::new(gpu, self.scene_cache.clone()))?;
        Ok(self)
    }

    /// Objects, light and background of a preview, and its camera.
    pub fn described(&self, viewpoint: Viewpoint, width_px: u32) -> (RenderScene<'a>, View) {
        let azimuth_rad = viewpoint.azimuth_rad().unwrap_or(self.hero_azimuth_rad);
        let (lighting, background) = match viewpoint {
            Viewpoint::Top => self.light(azimuth_rad),
            _ => self.surroundings(azimuth_rad),
        };
        let view = match viewpoint {
            Viewpoint::Hero => View::Perspective(self.hero_camera(self.hero_azimuth_rad, width_px)),
            Viewpoint::Top => View::Orthographic(self.top_view(width_px)),
            _ => View::Perspective(self.side_camera(azimuth_rad, width_px)),
        };
        (RenderScene { objects: objects(self.bodies), lighting, background }, view)
    }

    /// The preview from a place.
    pub fn seen_from(&self, viewpoint: Viewpoint, width_px: u32) -> Result<Image, GpuError> {
        let (RenderScene { lighting, background, .. }, view) = self.described(viewpoint, width_px);
        self.render_in(lighting, background, &view)
    }

    /// The key light stands to the left of a viewer at that azimuth.
    fn surroundings(&self, azimuth_rad: f64) -> (Lighting, Background) {
        match &self.room {
            Some(room) => self.daylight(azimuth_rad, room),
            None => self.light(azimuth_rad),
        }
    }

    fn render(&self, azimuth_rad: f64, view: &View) -> Result<Image, GpuError> {
        let (lighting, background) = self.surroundings(azimuth_rad);
        self.render_in(lighting, background, view)
    }

    fn render_in(&self, lighting: Lighting, background: Background, view: &View) -> Result<Image, GpuError> {
        let rendered = self.on_gpu.as_ref().map(|on_gpu| on_gpu.color(lighting, background, view));
        let rendered = rendered.map_or(Ok(None), unless_unfit)?;
        Ok(rendered.unwrap_or_else(|| self.scene_cache.color(lighting, background, view)))
    }

    fn light(&self, azimuth_rad: f64) -> (Lighting, Background) {
        let lighting = self.turned(Lighting::studio(azimuth_rad - 0.7, 0.95, 0.6));
        (lighting, Background::light_with_floor(self.low_m.z))
    }

    fn daylight(&self, azimuth_rad: f64, room: &Room) -> (Lighting, Background) {
        let lighting = self.turned(Lighting::daylight(azimuth_rad - 0.7, 0.8)).exposed_for(room);
        (lighting, Background::in_room(*room))
    }

    /// The light with the direction and intensity that the scene's light has, if it has one.
    fn turned(&self, mut lighting: Lighting) -> Lighting {
        if let Some(light) = &self.lit_by {
            lighting.toward_key = light.toward_light();
            lighting.key_color *= light.intensity as f32;
        }
        lighting
    }

    /// The objects on the table, three quarters from the front; the table where there is nothing else.
    pub fn hero(&self, settings: &PreviewSettings) -> Result<Image, GpuError> {
        self.seen_from(Viewpoint::Hero, settings.hero_width_px)
    }

    fn hero_camera(&self, azimuth_rad: f64, width_px: u32) -> Camera {
        let objects = match self.bodies {
            [_, objects @ ..] if !objects.is_empty() => objects,
            all => all,
        };
        let mut shown_m = strided_points(objects);
        let (low_m, high_m) = bounds(objects);
        let center_m = 0.5 * (low_m + high_m);
        let half_m = (0.5 * (high_m - low_m)).max(DVec3::splat(MIN_HERO_HALF_M));
        shown_m.extend([-1.0, 1.0].map(|side| center_m + side * half_m.with_z(0.0)));
        Self::framing(&shown_m, (low_m, high_m), width_px, width_px * 3 / 4, azimuth_rad, 0.6)
    }

    /// One of the sides: azimuth 0 = from the front edge, pi/2 = from +x.
    pub fn side(&self, azimuth_rad: f64, settings: &PreviewSettings) -> Result<Image, GpuError> {
        let camera = self.side_camera(azimuth_rad, settings.side_width_px);
        self.render(azimuth_rad, &View::Perspective(camera))
    }

    /// The camera that fills its image with everything.
    fn side_camera(&self, azimuth_rad: f64, width_px: u32) -> Camera {
        let (shown_m, boxed_m) = (strided_points(self.bodies), (self.low_m, self.high_m));
        Self::framing(&shown_m, boxed_m, width_px, width_px * 3 / 4, azimuth_rad, 0.3)
    }

    /// Straight from above, orthographic, in the studio.
    pub fn top(&self, settings: &PreviewSettings) -> Result<Image, GpuError> {
        self.seen_from(Viewpoint::Top, settings.side_width_px)
    }

    fn top_view(&self, width_px: u32) -> TopView {
        let size = 1.06 * (self.high_m - self.low_m).truncate();
        let height_px = ((f64::from(width_px) * size.y / size.x).round() as u32).clamp(64, 4 * width_px);
        TopView {
            width_px,
            height_px,
            meters_per_px: (size.x / f64::from(width_px)).max(size.y / f64::from(height_px)),
            center_m: 0.5 * (self.low_m + self.high_m).truncate(),
            eye_z_m: self.high_m.z + 0.1,
        }
    }

    /// Depths and ids at each pixel of the reference image's camera, always by the CPU; ids count from 1 in the order
    /// of the bodies.
    pub fn reference_geometry(&self, camera: &Camera) -> GeometryFrame {
        self.scene_cache.measure(&View::Perspective(*camera))
    }

    /// The scene from the camera of the reference image, as wide as a side view.
    pub fn reference_view(&self, camera: &Camera, settings: &PreviewSettings) -> Result<Image, GpuError> {
        let share = f64::from(settings.side_width_px) / f64::from(camera.width_px);
        let height_px = (share * f64::from(camera.height_px)).round().max(1.0);
        let small = Camera {
            width_px: settings.side_width_px,
            height_px: height_px as u32,
            fx: share * camera.fx,
            fy: share * camera.fy,
            cx: share * camera.cx,
            cy: share * camera.cy,
            ..*camera
        };
        let (lighting, background) = self.light(camera.azimuth_rad());
        self.render_in(lighting, background, &View::Perspective(small))
    }

    /// The nearest camera on that ray that sees the points, which lie in a box, with a small margin.
    fn framing(
        shown_m: &[DVec3],
        (low, high): (DVec3, DVec3),
        width_px: u32,
        height_px: u32,
        azimuth_rad: f64,
        elevation_rad: f64,
    ) -> Camera {
        let mut target = 0.5 * (low + high);
        let mut distance_m = 2.5 * (high - low).length().max(1e-3);
        let camera = |target, distance| {
            Camera::orbit(width_px, height_px, FOV_X_RAD, target, azimuth_rad, elevation_rad, distance)
        };
        // Center what is seen, then come closer or go back until it fills nine tenths of the frame.
        for _ in 0..6 {
            let now = camera(target, distance_m);
            let seen = shown_m.iter().filter_map(|point| now.project(*point)).map(|(pixel, _)| pixel);
            let (low_px, high_px) =
                seen.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            if !low_px.is_finite() {
                distance_m *= 2.0;
                continue;
            }
            let frame = DVec2::new(f64::from(width_px), f64::from(height_px));
            let off_px = 0.5 * (low_px + high_px) - 0.5 * frame;
            let meters_per_px = distance_m / now.fx;
            let right = now.world_from_camera.transform_vector(DVec3::X);
            let down = now.world_from_camera.transform_vector(DVec3::Y);
            target += meters_per_px * (off_px.x * right + off_px.y * down);
            distance_m *= ((high_px - low_px) / (0.9 * frame)).max_element().clamp(0.4, 2.5);
        }
        camera(target, distance_m)
    }
}

/// The bodies as the renderer has them.
fn objects<'a>(bodies: &[PreviewBody<'a>]) -> Vec<RenderObject<'a>> {
    let object = |(body, id): (&PreviewBody<'a>, u32)| RenderObject {
        mesh: body.mesh,
        world_from_object: body.world_from_object,
        id,
    };
    bodies.iter().zip(1..).map(object).collect()
}

/// Some 500 points of each body in the world.
fn strided_points(bodies: &[PreviewBody]) -> Vec<DVec3> {
    let of = |body: &PreviewBody| {
        let stride = body.mesh.positions.len().div_ceil(500).max(1);
        let points = body.mesh.positions.iter().step_by(stride);
        points.map(|p| body.world_from_object.transform_point(*p)).collect::<Vec<_>>()
    };
    bodies.iter().flat_map(of).collect()
}

/// Box of all bodies in the world.
fn bounds(bodies: &[PreviewBody]) -> (DVec3, DVec3) {
    bodies
        .iter()
        .flat_map(|body| body.mesh.positions.iter().map(|p| body.world_from_object.transform_point(*p)))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Result of a GPU; `None`, and a line in the log, where it does not fit this scene and would fail again.
fn unless_unfit<T>(made: Result<T, GpuError>) -> Result<Option<T>, GpuError> {
    match made {
        Err(error) if !error.is_device_failure() => {
            tracing::warn!(%error, "a preview is rendered on the CPU");
            Ok(None)
        }
        made => made.map(Some),
    }
}

/// One mesh, 256 x 256 pixels, on the CPU.
pub fn thumbnail(mesh: &TexturedMesh) -> Image {
    let quality = RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 8, sky_map_px: 64 };
    let bodies = [PreviewBody { mesh, world_from_object: Pose::IDENTITY }];
    let studio = Studio::new(&bodies, &quality);
    let (lighting, background) = studio.light(0.5);
    let boxed_m = (studio.low_m, studio.high_m);
    let camera = Studio::framing(&strided_points(&bodies), boxed_m, 256, 256, 0.5, 0.5);
    studio.scene_cache.color(lighting, background, &View::Perspective(camera))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::{block, cylinder};
    use geometry::{Material, Rgb, Solid};

    fn mesh(solid: Solid) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        mesh
    }

    #[test]
    fn objects_fill_the_hero_image_and_none_is_cut() {
        let table = mesh(block(DVec3::new(1.6, 0.9, 0.75)).translated(DVec3::new(0.0, 0.0, -0.75)));
        let can = mesh(cylinder(0.04, 0.09, 0.0, 24));
        let at = |x_m: f64, y_m: f64| Pose::upright(DVec3::new(x_m, y_m, 0.0), 0.3);
        for (places, min_share) in
            [(vec![at(0.5, -0.2)], 0.15), (vec![at(-0.1, 0.0), at(0.0, 0.1), at(0.1, -0.1)], 0.1)]
        {
            let on_table = places.iter().map(|pose| PreviewBody { mesh: &can, world_from_object: *pose });
            let table = PreviewBody { mesh: &table, world_from_object: Pose::IDENTITY };
            let bodies: Vec<PreviewBody> = std::iter::once(table).chain(on_table).collect();
            let quality =
                RenderSettings { supersampling: 1, shadow_map_px: 64, sky_directions: 4, sky_map_px: 16 };
            let studio = Studio::new(&bodies, &quality);
            let frame =
                studio.scene_cache.measure(&View::Perspective(studio.hero_camera(HERO_AZIMUTHS_RAD[0], 320)));
            let covered = frame.ids.iter().filter(|id| **id > 1).count();
            let share = covered as f64 / frame.ids.len() as f64;
            assert!(share > min_share, "{} objects cover {share:.2}", places.len());
            let rows = frame.ids.chunks(320).flat_map(|row| [row[0], row[319]]);
            let edge = frame.ids[..320].iter().chain(&frame.ids[320 * 239..]).copied().chain(rows);
            assert_eq!(edge.filter(|id| *id > 1).count(), 0, "an object is cut");
        }
    }
}
