//! The scene to render: table, objects, light and camera.

use super::arrangement::Arrangement;
use super::objects::SceneObject;
use super::table::SceneTable;
use super::viewpoint::Viewpoint;
use geometry::{Camera, Pose};
use imaging::Image;
use render::{Background, Frame, Lighting, RenderObject, RenderSettings, SceneCache, View};

/// Id of the table in rendered frames; object k has id k + [`FIRST_OBJECT_ID`].
pub(super) const TABLE_ID: u32 = 1;
pub(super) const FIRST_OBJECT_ID: u32 = 2;

/// Posed meshes with light, camera and background.
pub(super) struct RenderScene<'a> {
    scene_cache: SceneCache<'a>,
    /// The table, then the objects in order.
    pub placed: Vec<RenderObject<'a>>,
    pub camera: Camera,
    pub lighting: Lighting,
    pub background: Background,
}

impl<'a> RenderScene<'a> {
    pub fn new(
        table: &'a SceneTable,
        objects: &'a [SceneObject],
        arrangement: &Arrangement,
        viewpoint: &Viewpoint,
        quality: &RenderSettings,
    ) -> Self {
        let mut placed =
            vec![RenderObject { mesh: &table.mesh, world_from_object: Pose::IDENTITY, id: TABLE_ID }];
        placed.extend(objects.iter().zip(&arrangement.poses).enumerate().map(|(k, (object, pose))| {
            RenderObject { mesh: &object.mesh, world_from_object: *pose, id: k as u32 + FIRST_OBJECT_ID }
        }));
        Self {
            scene_cache: SceneCache::new(placed.clone(), quality),
            placed,
            camera: viewpoint.camera,
            lighting: viewpoint.lighting,
            background: Background::light_with_floor(-table.recognized.size_m.z),
        }
    }

    /// Renders the reference image.
    pub fn render(&self) -> Frame {
        self.scene_cache.render(self.lighting, self.background, &View::Perspective(self.camera))
    }

    /// Renders another view in the same light, without a floor.
    pub fn color_from(&self, view: &View) -> Image {
        self.scene_cache.color(self.lighting, Background { floor: None, ..self.background }, view)
    }

    /// The objects without the table, in order.
    pub fn placed_objects(&self) -> &[RenderObject<'a>] {
        &self.placed[1..]
    }
}
