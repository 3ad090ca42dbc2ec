//! The set as it is painted: table, props, light, camera.

use super::arrangement::Arrangement;
use super::props::Prop;
use super::table::PaintedTable;
use super::view::Viewpoint;
use geometry::{Camera, Pose};
use imaging::Image;
use render::{Background, Diorama, Frame, Lighting, RenderObject, RenderSettings, View};

/// Id of the table in painted frames; prop k has id k + [`FIRST_PROP`].
pub(super) const TABLE: u32 = 1;
pub(super) const FIRST_PROP: u32 = 2;

/// Everything in its place, ready to be painted.
pub(super) struct Stage<'a> {
    diorama: Diorama<'a>,
    /// The table, then the props in order.
    pub objects: Vec<RenderObject<'a>>,
    pub camera: Camera,
    pub lighting: Lighting,
    pub background: Background,
}

impl<'a> Stage<'a> {
    pub fn new(
        table: &'a PaintedTable,
        props: &'a [Prop],
        arrangement: &Arrangement,
        viewpoint: &Viewpoint,
        quality: &RenderSettings,
    ) -> Self {
        let mut objects =
            vec![RenderObject { mesh: &table.mesh, world_from_object: Pose::IDENTITY, id: TABLE }];
        objects.extend(props.iter().zip(&arrangement.poses).enumerate().map(|(k, (prop, pose))| {
            RenderObject { mesh: &prop.mesh, world_from_object: *pose, id: k as u32 + FIRST_PROP }
        }));
        Self {
            diorama: Diorama::new(objects.clone(), quality),
            objects,
            camera: viewpoint.camera,
            lighting: viewpoint.lighting,
            background: Background::light_with_floor(-table.recognized.size_m.z),
        }
    }

    /// The reference picture.
    pub fn paint(&self) -> Frame {
        self.diorama.paint(self.lighting, self.background, &View::Perspective(self.camera))
    }

    /// The same light without a floor, from elsewhere.
    pub fn color_from(&self, view: &View) -> Image {
        self.diorama.color(self.lighting, Background { floor: None, ..self.background }, view)
    }

    /// The props alone, in order.
    pub fn props(&self) -> &[RenderObject<'a>] {
        &self.objects[1..]
    }
}
