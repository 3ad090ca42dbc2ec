//! Six orthographic side views of a mesh, for deciding how it is oriented.

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::{Background, Lighting, RenderObject, RenderSettings, SceneCache, TopView, View};
use geometry::{Pose, TexturedMesh};
use imaging::Image;

/// Largest extent of the mesh as it is rendered, meters: light and shadows are made for objects of this size.
const DRAWN_M: f64 = 0.2;

/// A side of an object that stands on a table: its front faces the table's front edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
}

impl Side {
    pub const ALL: [Self; 6] = [Self::Front, Self::Back, Self::Left, Self::Right, Self::Top, Self::Bottom];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|side| side.name() == name)
    }

    /// The direction that this side faces: z up, y back.
    pub fn outward(self) -> DVec3 {
        match self {
            Self::Front => -DVec3::Y,
            Self::Back => DVec3::Y,
            Self::Left => -DVec3::X,
            Self::Right => DVec3::X,
            Self::Top => DVec3::Z,
            Self::Bottom => -DVec3::Z,
        }
    }

    /// The side that faces this direction best.
    pub fn facing(direction: DVec3) -> Self {
        let mut best = Self::Front;
        for side in Self::ALL {
            if side.outward().dot(direction) > best.outward().dot(direction) {
                best = side;
            }
        }
        best
    }

    /// Direction of the upper edge of the view, in the object's frame: up in views of the sides, the back in that of
    /// the top, the front in that of the bottom.
    fn upper_edge(self) -> DVec3 {
        match self {
            Self::Top => DVec3::Y,
            Self::Bottom => -DVec3::Y,
            _ => DVec3::Z,
        }
    }

    /// Turns this side toward +z, with the upper edge of its view toward +y.
    fn toward_viewer(self) -> DQuat {
        let (up, toward) = (self.upper_edge(), self.outward());
        DQuat::from_mat3(&DMat3::from_cols(up.cross(toward), up, toward).transpose())
    }
}

/// Six views in the order of [`Side::ALL`], squares of `side_px`, all at the same scale. Same mesh, same bytes.
pub fn side_views(mesh: &TexturedMesh, side_px: u32) -> Vec<(Side, Image)> {
    let quality = RenderSettings { supersampling: 2, shadow_map_px: 128, sky_directions: 8, sky_map_px: 64 };
    let (low, high) = mesh.bounds();
    let longest = (high - low).max_element().max(1e-9);
    let mesh = mesh.clone().translated(-0.5 * (low + high)).scaled(DVec3::splat(DRAWN_M / longest));
    let views = Side::ALL.into_iter().map(|side| {
        let turned = mesh.clone().rotated(side.toward_viewer());
        let object = RenderObject { mesh: &turned, world_from_object: Pose::IDENTITY, id: 1 };
        let view = TopView {
            width_px: side_px,
            height_px: side_px,
            meters_per_px: 1.1 * DRAWN_M / f64::from(side_px.max(1)),
            center_m: DVec2::ZERO,
            eye_z_m: DRAWN_M,
        };
        let scene_cache = SceneCache::new(vec![object], &quality);
        // From above and a little from the upper left of the view.
        let light = Lighting::studio(-2.4, 1.0, 0.6);
        (side, scene_cache.color(light, Background::light(), &View::Orthographic(view)))
    });
    views.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    #[test]
    fn side_views_show_each_face_upright() {
        let colors = [0xff0000, 0x00ff00, 0x0000ff, 0xffff00, 0x00ffff, 0xff00ff];
        let mut mesh = TexturedMesh::default();
        for (side, color) in Side::ALL.into_iter().zip(colors) {
            let plate = shapes::block(DVec3::splat(0.2)).translated(side.outward() * 0.9 - DVec3::Z * 0.1);
            mesh.add(plate, &Material::plain(side.name(), Rgb::hex(color), 0.9));
        }
        let named =
            |side: Side| Side::ALL.into_iter().position(|other| other == side).expect("is one of six");
        for (side, view) in side_views(&mesh, 100) {
            let is = |pixel: [u8; 4], of: Side| {
                let color = colors[named(of)];
                let wanted = [(color >> 16) as u8, (color >> 8) as u8, color as u8];
                (0..3).all(|k| (wanted[k] == 255) == (pixel[k] > 100))
            };
            assert!(is(view.pixel(50, 50), side), "{side:?}: {:?}", view.pixel(50, 50));
            let above = match side {
                Side::Top => Side::Back,
                Side::Bottom => Side::Front,
                _ => Side::Top,
            };
            assert!(is(view.pixel(50, 9), above), "{side:?}: {:?}", view.pixel(50, 9));
            if side == Side::Front {
                assert!(
                    is(view.pixel(91, 50), Side::Right),
                    "who stands in front sees its right at the right"
                );
            }
        }
    }

    #[test]
    fn side_names_match_directions() {
        for side in Side::ALL {
            assert_eq!((Side::named(side.name()), Side::facing(side.outward())), (Some(side), side));
            let turned = side.toward_viewer() * side.outward();
            assert!(turned.abs_diff_eq(DVec3::Z, 1e-12), "{side:?}");
        }
        assert_eq!(Side::named("inside"), None);
    }
}
