//! Synthesis of one image and its ground truth from a split and a number.

use glam::{DVec2, DVec3, Vec3};

use super::Split;
use super::arrangement::{ArrangementStyle, Placed, arrange, contact};
use super::backdrop::Backdrop;
use super::illumination::Illumination;
use super::image_degradation::{ImageDegradation, decoded};
use super::object::{Object, Palette};
use super::sampling::{chance, near, pale, uniform, weighted};
use super::surroundings::{self, Role, Surrounding};
use super::table::{self, Table};
use super::truth::{ImageTruth, Labels, ObjectTruth, TableTruth};
use super::viewpoint::{self, Viewpoint};
use catalog::{Category, categories};
use geometry::{Camera, Pose};
use imaging::srgb::LINEAR_OF_SRGB;
use imaging::{DepthImage, Image};
use rand::RngExt;
use render::{
    Background, Floor, GeometryFrame, RenderObject, RenderSettings, SceneCache, View, render_geometry,
};
use runtime::seed::{child_rng, child_seed};

/// Maximum number of objects on a table.
pub const MAX_OBJECTS: usize = 17;

/// Ids in rendered frames.
const TABLE_ID: u32 = 1;
const FIRST_OBJECT_ID: u32 = 2;
const SURROUNDING_ID: u32 = 1000;
const COVERING_ID: u32 = 1001;

/// Linear radiance of the placeholder backdrop during rendering; the drawn backdrop replaces it.
const GROUND: f32 = 0.5;

/// A synthetic image with its ground truth.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntheticImage {
    /// The image as a JPEG file.
    pub jpeg: Vec<u8>,
    /// The decoded JPEG file.
    pub image: Image,
    pub labels: Labels,
    /// Exact depths of the front-most surfaces; 0 for the backdrop, which has no geometry.
    pub depth: DepthImage,
    pub truth: ImageTruth,
}

/// Synthesizes image `number` of the split, its longer side `size_px` pixels (at least 64). The same arguments give
/// the same image. Images of one number in different sizes show the same scene with different noise.
pub fn synthesize(split: Split, number: u64, size_px: u32) -> SyntheticImage {
    let seed = child_seed(number, &format!("picture of {}", split.name()));
    let table = table::draw(split, &mut child_rng(seed, "table"));
    let placed = placed_objects(split, &table, seed);
    let view = viewpoint::draw(&table, &placed, size_px.max(64), &mut child_rng(seed, "camera"));
    let mut rng = child_rng(seed, "surroundings");
    let surroundings = surroundings::draw(split, &table, view.camera.azimuth_rad(), &mut rng);
    develop(&Scenery { split, number, seed, table, placed, surroundings, view }, size_px)
}

/// Synthesizes a close-up of one object among neighbors. Close-ups go through all categories of the catalog, in every
/// split; only finishes, backdrops and composites are those of the split.
pub fn synthesize_close_up(split: Split, number: u64, size_px: u32) -> SyntheticImage {
    let seed = child_seed(number, &format!("close-up of {}", split.name()));
    let table = table::draw(split, &mut child_rng(seed, "table"));
    let target = &categories()[(number % categories().len() as u64) as usize];
    let placed = close_up_objects(split, target, &table, seed);
    let shown = placed.iter().position(|one| one.object.name == target.name);
    let mut rng = child_rng(seed, "camera");
    let view = match shown {
        Some(shown) => viewpoint::close_up(&placed[shown], size_px.max(64), &mut rng),
        None => viewpoint::draw(&table, &placed, size_px.max(64), &mut rng),
    };
    develop(&Scenery { split, number, seed, table, placed, surroundings: Vec::new(), view }, size_px)
}

/// The objects before the camera.
struct Scenery {
    split: Split,
    number: u64,
    seed: u64,
    table: Table,
    placed: Vec<Placed>,
    surroundings: Vec<Surrounding>,
    view: Viewpoint,
}

/// Renders the scenery under a random light before a random backdrop, and degrades the image.
fn develop(scenery: &Scenery, size_px: u32) -> SyntheticImage {
    let Scenery { split, number, seed, table, placed, surroundings, view } = scenery;
    let (split, number, seed) = (*split, *number, *seed);
    let illumination = Illumination::draw(&mut child_rng(seed, "light"));
    let backdrop = Backdrop::draw(split, &mut child_rng(seed, "backdrop"));
    let mut rng = child_rng(seed, "darkroom");
    let degradation = ImageDegradation::draw(size_px, &mut rng);
    let scene = PlacedScene { table, placed, surroundings, camera: view.camera };
    let frame = scene.render(&illumination, &backdrop, size_px);
    let labels = scene.labels(&frame.front);
    let lines = |k: usize| is_line(&frame.front, k);
    let jpeg = degradation.apply(&frame.light, view.camera.width_px as usize, lines, &mut rng);
    let truth = ImageTruth {
        split,
        number,
        width_px: view.camera.width_px,
        height_px: view.camera.height_px,
        camera: view.camera,
        elevation_rad: view.camera.elevation_rad(),
        azimuth_rad: view.camera.azimuth_rad(),
        fov_x_rad: 2.0 * (0.5 * f64::from(view.camera.width_px) / view.camera.fx).atan(),
        framing: view.framing,
        backdrop: backdrop.kind.name().to_owned(),
        is_cartoon: degradation.cartoon,
        table: scene.table_truth(),
        objects: scene.object_truths(&labels, view),
    };
    SyntheticImage { image: decoded(&jpeg), jpeg, labels, depth: depth_image(&frame.front), truth }
}

/// The depths of a frame in whole millimeters; 0 beyond the range of 16 bits.
fn depth_image(front: &GeometryFrame) -> DepthImage {
    let whole_mm = |depth_m: &f32| {
        let depth_mm = (1e3 * depth_m).round();
        if depth_mm.is_finite() && depth_mm <= f32::from(u16::MAX) { depth_mm as u16 } else { 0 }
    };
    let depths_mm = front.depth_m.iter().map(whole_mm).collect();
    DepthImage::new(front.width_px, front.height_px, depths_mm).expect("a frame has a depth a pixel")
}

/// Objects in their placed poses; smaller objects are drawn if none of the first draw finds space.
fn placed_objects(split: Split, table: &Table, seed: u64) -> Vec<Placed> {
    let mut rng = child_rng(seed, "arrangement");
    let style = ArrangementStyle::draw(&mut rng);
    for shrunk in [1.0, 0.7, 0.4] {
        let objects = draw_objects(split, table, shrunk, seed);
        let wanted = !objects.is_empty();
        let placed = arrange(objects, &table.outline, style, &mut rng);
        if !placed.is_empty() || !wanted {
            return placed;
        }
    }
    Vec::new()
}

/// The target and up to five other objects close to it; smaller ones if the table has no space for the target.
fn close_up_objects(split: Split, target: &'static Category, table: &Table, seed: u64) -> Vec<Placed> {
    let mut rng = child_rng(seed, "arrangement");
    let all: Vec<&'static Category> = categories().iter().collect();
    let style = ArrangementStyle { huddled_share: 0.9, ..ArrangementStyle::draw(&mut rng) };
    for shrunk in [1.0, 0.6, 0.3] {
        let scale = shrunk * uniform(&mut rng, 0.85, 1.15);
        let mut objects = vec![Object::of_category(split, target, Palette::Usual, scale, &mut rng)];
        let neighbors = rng.random_range(0..=5);
        objects.extend((0..neighbors).map(|_| Object::draw(split, Palette::Usual, scale, &all, &mut rng)));
        let placed = arrange(objects, &table.outline, style, &mut rng);
        if placed.iter().any(|one| one.object.name == target.name) {
            return placed;
        }
    }
    Vec::new()
}

/// Random objects for the table, `shrunk` times their usual size.
fn draw_objects(split: Split, table: &Table, shrunk: f64, seed: u64) -> Vec<Object> {
    let mut rng = child_rng(seed, "things");
    let [min_count, max_count] =
        weighted(&mut rng, &[([0, 0], 0.2), ([1, 3], 1.5), ([4, 9], 4.5), ([10, MAX_OBJECTS], 3.0)]);
    let count = rng.random_range(min_count..=max_count);
    let palette = if chance(&mut rng, 0.12) {
        Palette::Tone(if chance(&mut rng, 0.5) { pale(&mut rng) } else { near(&mut rng, table.color, 0.05) })
    } else {
        Palette::Usual
    };
    // Product images show objects that are large for their table.
    let (low, high) = table.outline.bounds();
    let room = (0.5 * (high - low).element_sum()).clamp(0.5, 1.3);
    let scale = shrunk * room * uniform(&mut rng, 0.75, 1.7);
    let categories = split.categories();
    let mut objects: Vec<Object> = Vec::new();
    while objects.len() < count {
        let own = if palette != Palette::Usual && chance(&mut rng, 0.15) { Palette::Usual } else { palette };
        let object = Object::draw(split, own, scale * uniform(&mut rng, 0.85, 1.15), &categories, &mut rng);
        // Sets of equal objects are common: three cups, five crayons.
        let copies = if chance(&mut rng, 0.12) { rng.random_range(2..5) } else { 1 };
        objects.extend(std::iter::repeat_n(object, copies.min(count - objects.len())));
    }
    objects
}

/// A complete scene with its camera.
struct PlacedScene<'a> {
    table: &'a Table,
    placed: &'a [Placed],
    surroundings: &'a [Surrounding],
    camera: Camera,
}

/// Rendered radiance and geometry before image degradation.
struct RenderedFrame {
    light: Vec<Vec3>,
    front: GeometryFrame,
}

impl PlacedScene<'_> {
    fn objects(&self) -> impl Iterator<Item = RenderObject<'_>> {
        self.placed.iter().enumerate().map(|(k, one)| RenderObject {
            mesh: &one.object.mesh,
            world_from_object: one.world_from_object,
            id: FIRST_OBJECT_ID + k as u32,
        })
    }

    fn everything(&self) -> Vec<RenderObject<'_>> {
        let table = RenderObject { mesh: &self.table.mesh, world_from_object: Pose::IDENTITY, id: TABLE_ID };
        let around = self.surroundings.iter().map(|piece| RenderObject {
            mesh: &piece.mesh,
            world_from_object: piece.world_from_object,
            id: match piece.role {
                Role::Backdrop => SURROUNDING_ID,
                Role::Covering => COVERING_ID,
            },
        });
        std::iter::once(table).chain(self.objects()).chain(around).collect()
    }

    fn render(&self, illumination: &Illumination, backdrop: &Backdrop, size_px: u32) -> RenderedFrame {
        let view = View::Perspective(self.camera);
        let quality = RenderSettings {
            supersampling: 2,
            shadow_map_px: size_px.clamp(256, 1024),
            sky_directions: 8,
            sky_map_px: 128,
        };
        let objects = self.everything();
        let room = backdrop.room(&objects);
        let mut scene_cache = SceneCache::new(objects, &quality);
        if room.is_some() {
            scene_cache = scene_cache.for_rooms();
        }
        let (lightings, ground) = match room {
            Some(room) => (illumination.in_room(&room), Background::in_room(room)),
            None => (illumination.lightings.clone(), self.placeholder(backdrop)),
        };
        let share = 1.0 / lightings.len() as f32;
        let mut light = vec![Vec3::ZERO; (self.camera.width_px * self.camera.height_px) as usize];
        for lighting in lightings {
            add_light(&mut light, &scene_cache.color(lighting, ground, &view), share);
        }
        let front = scene_cache.measure(&view);
        if self.table.mirror_share > 0.0 {
            self.add_mirrored(&mut light, &front, illumination, &quality);
        }
        if room.is_none() {
            self.draw_backdrop(&mut light, backdrop, &scene_cache);
        }
        RenderedFrame { light, front }
    }

    /// The background during rendering, on whose floor the table throws its shadow.
    fn placeholder(&self, backdrop: &Backdrop) -> Background {
        let gray = Vec3::splat(GROUND);
        let floor = backdrop.shadowed.then_some(Floor { z_m: -self.table.height_m });
        Background { top_color: gray, bottom_color: gray, floor, room: None }
    }

    /// Replaces the placeholder, keeping its shadows.
    fn draw_backdrop(&self, light: &mut [Vec3], backdrop: &Backdrop, scene_cache: &SceneCache) {
        let coverage = self.backdrop_coverage(scene_cache);
        let width = self.camera.width_px as usize;
        let dimmed: Vec<f32> =
            light.iter().map(|l| (l.dot(Vec3::splat(1.0 / 3.0)) / GROUND).min(1.0)).collect();
        for k in 0..light.len() {
            let open = coverage[k];
            if open > 0.0 {
                let dim = if open >= 1.0 { dimmed[k] } else { beside(k, width, &coverage, &dimmed) };
                let pixel = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
                let own = backdrop.light_at(&self.camera, pixel, -self.table.height_m);
                light[k] = (light[k] + open * dim * (own - Vec3::splat(GROUND))).max(Vec3::ZERO);
            }
        }
    }

    /// Share of each pixel that shows the backdrop, in quarters, at the color sampling positions.
    fn backdrop_coverage(&self, scene_cache: &SceneCache) -> Vec<f32> {
        let c = self.camera;
        let fine = Camera {
            width_px: 2 * c.width_px,
            height_px: 2 * c.height_px,
            fx: 2.0 * c.fx,
            fy: 2.0 * c.fy,
            cx: 2.0 * c.cx,
            cy: 2.0 * c.cy,
            ..c
        };
        let ids = scene_cache.measure(&View::Perspective(fine)).ids;
        let (width, fine_width) = (c.width_px as usize, fine.width_px as usize);
        (0..width * c.height_px as usize)
            .map(|k| {
                let corner = 2 * (k / width) * fine_width + 2 * (k % width);
                let open = [corner, corner + 1, corner + fine_width, corner + fine_width + 1];
                0.25 * open.iter().filter(|&&at| ids[at] == 0).count() as f32
            })
            .collect()
    }

    /// Blends reflections of the objects into the bare table top. A camera below the top renders the mirrored
    /// world; its image is upside down.
    fn add_mirrored(
        &self,
        light: &mut [Vec3],
        front: &GeometryFrame,
        illumination: &Illumination,
        quality: &RenderSettings,
    ) {
        let c = self.camera;
        let eye = c.world_from_camera;
        let mirrored = |axis: DVec3| {
            let v = eye.transform_vector(axis);
            DVec3::new(v.x, v.y, -v.z)
        };
        let axes = glam::DMat3::from_cols(mirrored(DVec3::X), -mirrored(DVec3::Y), mirrored(DVec3::Z));
        let at = eye.translation_m;
        let pose =
            Pose { translation_m: at.with_z(-at.z), rotation: glam::DQuat::from_mat3(&axes).normalize() };
        let below = Camera { cy: f64::from(c.height_px) - c.cy, world_from_camera: pose, ..c };
        let objects: Vec<RenderObject> = self.objects().collect();
        let coarse =
            RenderSettings { supersampling: 1, shadow_map_px: 0, sky_directions: 0, ..quality.clone() };
        let scene_cache = SceneCache::new(objects, &coarse);
        let ground = Background { top_color: Vec3::ZERO, bottom_color: Vec3::ZERO, floor: None, room: None };
        let frame = scene_cache.render(illumination.lightings[0], ground, &View::Perspective(below));
        let width = c.width_px as usize;
        for (k, light) in light.iter_mut().enumerate() {
            let (x, y) = (k % width, k / width);
            let there = (c.height_px as usize - 1 - y) * width + x;
            if frame.ids[there] != 0 && self.is_top(front, k) {
                let [r, g, b, _] = frame.color.pixel(x as u32, (c.height_px as usize - 1 - y) as u32);
                let reflected = Vec3::from([r, g, b].map(|byte| LINEAR_OF_SRGB[byte as usize]));
                let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let grazing = 1.0 + c.ray_direction_in_world(pixel).z;
                let share = (self.table.mirror_share * (0.25 + 0.75 * grazing * grazing)) as f32;
                *light = light.lerp(reflected, share.min(0.9));
            }
        }
    }

    /// Whether the pixel shows the flat surface of the table top.
    fn is_top(&self, front: &GeometryFrame, k: usize) -> bool {
        if front.ids[k] != TABLE_ID {
            return false;
        }
        let (x, y) = (k % front.width_px as usize, k / front.width_px as usize);
        let c = &self.camera;
        let ray = DVec3::new((x as f64 + 0.5 - c.cx) / c.fx, (y as f64 + 0.5 - c.cy) / c.fy, 1.0);
        let point = c.world_from_camera.transform_point(ray * f64::from(front.depth_m[k]));
        point.z.abs() < 1e-3
    }

    fn labels(&self, front: &GeometryFrame) -> Labels {
        let value = |k: usize| match front.ids[k] {
            0 | SURROUNDING_ID => Labels::BACKDROP,
            COVERING_ID => Labels::TOP,
            TABLE_ID if self.is_top(front, k) => Labels::TOP,
            TABLE_ID => Labels::FRAME,
            id => Labels::FIRST_OBJECT + (id - FIRST_OBJECT_ID) as u8,
        };
        let values = (0..front.ids.len()).map(value).collect();
        Labels { width_px: front.width_px, height_px: front.height_px, values }
    }

    fn table_truth(&self) -> TableTruth {
        let outline_m = self.table.outline.corners().to_vec();
        let outline_px = projected(&self.camera, outline_m.iter().map(|p| p.extend(0.0)));
        let (width, height) = (f64::from(self.camera.width_px), f64::from(self.camera.height_px));
        let within = |p: &DVec2| p.x >= 0.0 && p.y >= 0.0 && p.x <= width && p.y <= height;
        TableTruth {
            shape: self.table.shape,
            finish: self.table.finish.name().to_owned(),
            is_whole: outline_px.len() == outline_m.len() && outline_px.iter().all(within),
            outline_m,
            outline_px,
            height_m: self.table.height_m,
        }
    }

    fn object_truths(&self, labels: &Labels, view: &Viewpoint) -> Vec<ObjectTruth> {
        let mut visible = vec![0_usize; self.placed.len()];
        for value in labels.values.iter().filter(|value| **value >= Labels::FIRST_OBJECT) {
            visible[(value - Labels::FIRST_OBJECT) as usize] += 1;
        }
        self.objects()
            .zip(self.placed)
            .zip(visible)
            .map(|((object, one), visible_px)| {
                let corners =
                    one.object.mesh.positions.iter().map(|p| one.world_from_object.transform_point(*p));
                let (low, high) = projected(&view.camera, corners)
                    .iter()
                    .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
                let whole = silhouette_px(object, &view.camera, low, high);
                let (contact_m, contact_z_m) = contact(one);
                let contact_px = projected(&view.camera, contact_m.iter().map(|p| p.extend(contact_z_m)));
                ObjectTruth {
                    name: one.object.name.to_owned(),
                    is_composite: one.object.is_composite,
                    world_from_object: one.world_from_object,
                    size_m: one.object.mesh.size_m(),
                    stands_on: one.stands_on,
                    is_inside: one.inside,
                    contact_m,
                    contact_z_m,
                    contact_px,
                    footprint_m: one.footprint.clone(),
                    box_px: if low.is_finite() { [low.x, low.y, high.x, high.y] } else { [0.0; 4] },
                    visible_px,
                    visible_share: if whole == 0 { 0.0 } else { visible_px as f64 / whole as f64 },
                }
            })
            .collect()
    }
}

/// Projections of the points into the image; points behind the camera are dropped.
fn projected(camera: &Camera, points: impl Iterator<Item = DVec3>) -> Vec<DVec2> {
    points.filter_map(|p| camera.project(p).map(|(pixel, _)| pixel)).collect()
}

/// Number of silhouette pixels of the object within the frame without occluders; `low` and `high` bound them.
fn silhouette_px(object: RenderObject, camera: &Camera, low: DVec2, high: DVec2) -> usize {
    let size = DVec2::new(f64::from(camera.width_px), f64::from(camera.height_px));
    let (from, to) = (low.floor().max(DVec2::ZERO), high.ceil().min(size));
    if !(to - from).cmpgt(DVec2::ZERO).all() {
        return 0;
    }
    let window = Camera {
        width_px: (to.x - from.x) as u32,
        height_px: (to.y - from.y) as u32,
        cx: camera.cx - from.x,
        cy: camera.cy - from.y,
        ..*camera
    };
    render_geometry(&[object], &View::Perspective(window)).ids.iter().filter(|id| **id != 0).count()
}

fn add_light(sum: &mut [Vec3], image: &Image, share: f32) {
    for (light, rgba) in sum.iter_mut().zip(image.as_rgba().chunks_exact(4)) {
        *light += share
            * Vec3::new(
                LINEAR_OF_SRGB[rgba[0] as usize],
                LINEAR_OF_SRGB[rgba[1] as usize],
                LINEAR_OF_SRGB[rgba[2] as usize],
            );
    }
}

/// Shadow factor of the backdrop at a partly covered pixel: the mean over its fully uncovered neighbors.
fn beside(k: usize, width: usize, coverage: &[f32], dimmed: &[f32]) -> f32 {
    let steps = [-1, 1, -(width as isize), width as isize];
    let near: Vec<f32> = steps
        .iter()
        .filter_map(|step| k.checked_add_signed(*step))
        .filter(|&at| coverage.get(at).is_some_and(|seen| *seen >= 1.0))
        .map(|at| dimmed[at])
        .collect();
    if near.is_empty() { 1.0 } else { near.iter().sum::<f32>() / near.len() as f32 }
}

/// Whether a cartoon has an outline at the pixel: another object to the right or below, or a depth step.
fn is_line(front: &GeometryFrame, k: usize) -> bool {
    let width = front.width_px as usize;
    [k + 1, k + width].into_iter().any(|other| {
        other < front.ids.len()
            && (front.ids[other] != front.ids[k]
                || (front.depth_m[other] - front.depth_m[k]).abs() > 0.02 * front.depth_m[k])
    })
}
