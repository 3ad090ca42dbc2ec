//! Indistinguishable yaws of an object in the true image.
//!
//! The object is rotated about the vertical axis through its true origin while everything else stays. The image
//! crop around it is rendered again with the true meshes, poses and camera, in studio light without cast shadows,
//! so that a shadow alone does not distinguish yaws. A yaw is *indistinguishable* if fewer than 1 % of the object's
//! visible pixels change by more than 8 of 255 in any channel. The comparison is made at the true origin and at the
//! position where the silhouette's box has the true center: a mug with a hidden handle is the same rotated about
//! the center of its cup, and the position is not under test here.
//!
//! Every multiple of 5 degrees is rendered, coarsely (one sample per pixel) if that suffices to tell it apart, and
//! the whole degrees around close ones. The crop is rendered at most 160 pixels wide or high. Cost: several hundred
//! small renderings per object, about 0.2 s.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use geometry::{Camera, Pose};
use render::{Background, Frame, Lighting, RenderObject, RenderSettings, SceneCache, View};
use runtime::{CancelFlag, Cancelled};

/// Maximum share of the visible pixels that may change.
pub const CHANGED_SHARE: f64 = 0.01;

/// A pixel has changed if some channel differs by more than this, of 255.
pub const CHANGED_LEVELS: u8 = 8;

/// Whole degrees in a full turn.
const DEGREES: usize = 360;
/// Step of the first pass, degrees.
const STEP: usize = 5;
/// Changed share at a multiple of the step below which its neighborhood is tested.
const NEAR_SHARE: f64 = 0.10;
/// Changed share above which a coarse rendering suffices: its edge noise is smaller.
const FAR_SHARE: f64 = 0.35;
/// Maximum side of the renderings, pixels.
const MAX_PX: f64 = 160.0;
/// Box centers closer than this coincide, pixels.
const SAME_CENTER_PX: f64 = 0.05;
/// Boxes whose sides differ by more than this never match, pixels.
const SAME_SIDES_PX: f64 = 2.0;
/// Newton steps toward the same center; the first is off by the perspective only.
const CENTER_STEPS: usize = 3;
/// Step of the difference quotient, meters.
const CENTER_DIFFERENCE_M: f64 = 1e-4;

/// The true scene with its camera.
pub struct RenderedScene<'a> {
    pub camera: Camera,
    /// The table, then the objects in order, with ids from 1.
    pub objects: Vec<RenderObject<'a>>,
}

/// Rotations from a pose, whole degrees, at which an object appears as in the true image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndistinguishableYaws {
    /// Ascending; contains 0 if the pose is the true one.
    degrees: Vec<usize>,
}

impl IndistinguishableYaws {
    /// Only the true yaw.
    pub fn only_itself() -> Self {
        Self { degrees: vec![0] }
    }

    /// Distance from a rotation to the nearest indistinguishable one, degrees, 0..180; 180 if there is none. It is
    /// 0 between neighboring degrees that are both indistinguishable.
    pub fn distance_deg(&self, turn_deg: f64) -> f64 {
        let turn = turn_deg.rem_euclid(DEGREES as f64);
        let listed = |degree: usize| self.degrees.binary_search(&(degree % DEGREES)).is_ok();
        if listed(turn.floor() as usize) && listed(turn.ceil() as usize) {
            return 0.0;
        }
        let apart = |degree: usize| {
            let off = (turn - degree as f64).abs();
            off.min(DEGREES as f64 - off)
        };
        self.degrees.iter().map(|&degree| apart(degree)).fold(180.0, f64::min)
    }

    /// Whether each of these rotations is within `reach_deg` of one of the others.
    pub fn are_near(&self, others: &Self, reach_deg: f64) -> bool {
        self.degrees.iter().all(|&degree| others.distance_deg(degree as f64) <= reach_deg)
    }

    /// Whether every tested yaw is indistinguishable.
    pub fn is_any(&self) -> bool {
        (0..DEGREES).step_by(STEP).all(|degree| self.degrees.binary_search(&degree).is_ok())
    }

    /// Number of separate intervals of indistinguishable yaws.
    pub fn intervals(&self) -> usize {
        if self.degrees.len() == DEGREES {
            return 1;
        }
        let starts = self
            .degrees
            .iter()
            .filter(|&&degree| self.degrees.binary_search(&((degree + DEGREES - 1) % DEGREES)).is_err());
        starts.count()
    }
}

/// The rotations from `start` at which the object at `index` of `scene.objects` appears as in the true image.
pub fn indistinguishable_yaws(
    scene: &RenderedScene,
    index: usize,
    start: Pose,
    cancel: &CancelFlag,
) -> Result<IndistinguishableYaws, Cancelled> {
    let subject = scene.objects[index];
    let axis_m = subject.world_from_object.translation_m;
    let camera = windowed(&scene.camera, swept(&subject, start));
    let view = View::Perspective(camera);
    let lighting = Lighting::studio(scene.camera.azimuth_rad() - 0.6, 0.9, 0.5);
    let near: Vec<RenderObject> = scene
        .objects
        .iter()
        .enumerate()
        .filter(|(k, o)| *k == index || shows(o, &camera))
        .map(|(_, o)| *o)
        .collect();
    let render = |world_from_subject: Pose, supersampling: u32| {
        let settings = RenderSettings { supersampling, shadow_map_px: 0, sky_directions: 0, sky_map_px: 32 };
        let objects = near
            .iter()
            .map(|o| {
                if o.id == subject.id {
                    RenderObject { world_from_object: world_from_subject, ..*o }
                } else {
                    *o
                }
            })
            .collect();
        SceneCache::new(objects, &settings).render(lighting, Background::light(), &view)
    };
    let (truth, coarse_truth) = (render(subject.world_from_object, 2), render(subject.world_from_object, 1));
    let visible_px = truth.ids.iter().filter(|&&id| id == subject.id).count();
    let changed_share = |degree: usize| {
        cancel.check()?;
        let turn = Pose::upright(DVec3::ZERO, (degree as f64).to_radians());
        let turned = turn * Pose { translation_m: start.translation_m - axis_m, ..start };
        let turned = Pose { translation_m: turned.translation_m + axis_m, ..turned };
        let share = |a: &Frame, b: &Frame| changed_px(a, b) as f64 / visible_px.max(1) as f64;
        let share_at = |pose: Pose| {
            let coarse = share(&coarse_truth, &render(pose, 1));
            if coarse > FAR_SHARE { coarse } else { share(&truth, &render(pose, 2)) }
        };
        let moved = with_same_image_center(&camera, &subject, turned);
        Ok::<f64, Cancelled>(moved.map_or(f64::INFINITY, share_at).min(share_at(turned)))
    };
    let mut shares: Vec<Option<f64>> = vec![None; DEGREES];
    let fill = |shares: &mut Vec<Option<f64>>, degrees: Vec<usize>| {
        let found: Vec<(usize, f64)> = degrees
            .into_par_iter()
            .map(|degree| Ok((degree, changed_share(degree)?)))
            .collect::<Result<_, Cancelled>>()?;
        found.into_iter().for_each(|(degree, share)| shares[degree] = Some(share));
        Ok::<(), Cancelled>(())
    };
    fill(&mut shares, (0..DEGREES).step_by(STEP).collect())?;
    let close: Vec<usize> = (0..DEGREES)
        .filter(|degree| shares[*degree].is_none())
        .filter(|degree| {
            let (below, above) = (degree / STEP * STEP, (degree / STEP + 1) * STEP % DEGREES);
            [below, above].iter().any(|&knot| shares[knot].is_some_and(|share| share < NEAR_SHARE))
        })
        .collect();
    fill(&mut shares, close)?;
    let is_indistinguishable = |share: &Option<f64>| share.is_some_and(|share| share < CHANGED_SHARE);
    let degrees = (0..DEGREES).filter(|&degree| is_indistinguishable(&shares[degree])).collect();
    Ok(IndistinguishableYaws { degrees })
}

/// The pose moved horizontally so that the image box of the vertices has the same center as in the true pose.
/// `None` if it has it already, the box has other sides, or no such position exists.
fn with_same_image_center(camera: &Camera, subject: &RenderObject, pose: Pose) -> Option<Pose> {
    let box_px = |pose: Pose| {
        let points = subject.mesh.positions.iter().map(|p| pose.transform_point(*p));
        pixel_box(camera, points).map(|(low, high)| (0.5 * (low + high), high - low))
    };
    let moved_by = |pose: Pose, step_m: DVec3| Pose { translation_m: pose.translation_m + step_m, ..pose };
    let (target_px, sides_px) = box_px(subject.world_from_object)?;
    let (center_px, turned_sides_px) = box_px(pose)?;
    if center_px.distance(target_px) < SAME_CENTER_PX
        || (turned_sides_px - sides_px).abs().max_element() > SAME_SIDES_PX
    {
        return None;
    }
    let mut moved = pose;
    for _ in 0..CENTER_STEPS {
        let (at_px, _) = box_px(moved)?;
        let slope = |axis: DVec3| {
            let (beside_px, _) = box_px(moved_by(moved, CENTER_DIFFERENCE_M * axis))?;
            Some((beside_px - at_px) / CENTER_DIFFERENCE_M)
        };
        let px_per_m = DMat2::from_cols(slope(DVec3::X)?, slope(DVec3::Y)?);
        let step_m = px_per_m.inverse() * (target_px - at_px);
        moved = moved_by(moved, step_m.extend(0.0));
    }
    moved.translation_m.is_finite().then_some(moved)
}

/// Number of pixels that differ by more than [`CHANGED_LEVELS`] in some channel.
fn changed_px(a: &Frame, b: &Frame) -> usize {
    let pixels = a.color.as_rgba().chunks_exact(4).zip(b.color.as_rgba().chunks_exact(4));
    pixels.filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > CHANGED_LEVELS)).count()
}

/// Points around the volume that the object sweeps when rotated about the vertical axis through its true origin, in
/// its true pose and from `start`.
fn swept(object: &RenderObject, start: Pose) -> Vec<DVec3> {
    let axis_m = object.world_from_object.translation_m;
    let (mut radius_m, mut low_m, mut high_m) = (0.0_f64, 0.0_f64, 0.0_f64);
    for pose in [object.world_from_object, start] {
        for point in &object.mesh.positions {
            let p = pose.transform_point(*point) - axis_m;
            (radius_m, low_m, high_m) =
                (radius_m.max(p.truncate().length()), low_m.min(p.z), high_m.max(p.z));
        }
    }
    (0..16)
        .map(|k| 1.03 * radius_m * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 16.0))
        .flat_map(|xy| [axis_m + xy.extend(low_m), axis_m + xy.extend(high_m)])
        .collect()
}

/// The camera cropped to these points and scaled down to [`MAX_PX`].
fn windowed(camera: &Camera, points: Vec<DVec3>) -> Camera {
    let frame = DVec2::new(f64::from(camera.width_px), f64::from(camera.height_px));
    let (low, high) = pixel_box(camera, points.into_iter()).unwrap_or((DVec2::ZERO, frame));
    let low = (low - 2.0).floor().clamp(DVec2::ZERO, frame - 1.0);
    let size = ((high + 2.0).ceil().clamp(DVec2::ZERO, frame) - low).max(DVec2::ONE);
    let scale = (MAX_PX / size.max_element()).min(1.0);
    let size = (scale * size).ceil();
    Camera {
        width_px: size.x as u32,
        height_px: size.y as u32,
        fx: scale * camera.fx,
        fy: scale * camera.fy,
        cx: scale * (camera.cx - low.x),
        cy: scale * (camera.cy - low.y),
        ..*camera
    }
}

/// Whether the object may be visible in the camera image.
fn shows(object: &RenderObject, camera: &Camera) -> bool {
    let (low, high) = object.mesh.bounds();
    let corners = (0..8).map(|k| {
        let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 0 { l } else { h };
        let corner = DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
        object.world_from_object.transform_point(corner)
    });
    pixel_box(camera, corners).is_none_or(|(low, high)| {
        high.min_element() >= 0.0
            && low.x <= f64::from(camera.width_px)
            && low.y <= f64::from(camera.height_px)
    })
}

/// Image bounding box of the points; `None` if one lies behind the camera.
fn pixel_box(camera: &Camera, mut points: impl Iterator<Item = DVec3>) -> Option<(DVec2, DVec2)> {
    points.try_fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
        camera.project(point).map(|(pixel, _)| (low.min(pixel), high.max(pixel)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use catalog::{Recipe, build, build_table, category};

    /// Rotated by `yaw_rad`, without textures.
    fn of(name: &str, yaw_rad: f64) -> IndistinguishableYaws {
        let size_m = category(name).expect("known").size.typical_m();
        let recipe = Recipe { category: name.into(), size_m, color: None, material: None, seed: 5 };
        let mesh = build(&recipe).expect("builds");
        let mesh = mesh.without_textures().unwrap_or(mesh);
        let table = build_table("desk", DVec3::new(1.0, 0.6, 0.74), None, None, 1).expect("a desk").mesh;
        let camera = Camera::orbit(960, 720, 0.61, DVec3::ZERO, 0.1, 0.6, 1.6);
        let pose = Pose::upright(DVec3::new(0.1, 0.05, 0.0), yaw_rad);
        let objects = vec![
            RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 },
            RenderObject { mesh: &mesh, world_from_object: pose, id: 2 },
        ];
        indistinguishable_yaws(&RenderedScene { camera, objects }, 1, pose, &CancelFlag::default())
            .expect("not interrupted")
    }

    #[test]
    fn rotated_mug_is_distinguishable() {
        let mug = of("mug", 0.5);
        assert!(!mug.is_any());
        assert!(mug.distance_deg(90.0) > 10.0 && mug.distance_deg(0.0) == 0.0);
    }

    #[test]
    fn mug_with_hidden_handle_is_indistinguishable_about_its_cup() {
        // The origin is that of cup and handle together; a rotation about it moves the cup. The angles are multiples of
        // that between two of its 48 facets.
        let mug = of("mug", 1.5);
        assert!(mug.distance_deg(30.0) == 0.0 && mug.distance_deg(-15.0) == 0.0, "{mug:?}");
        assert!(mug.distance_deg(90.0) > 10.0 && mug.distance_deg(180.0) > 10.0, "{mug:?}");
    }

    #[test]
    fn distances_wrap_around_and_neighbors_form_one_interval() {
        let yaws = IndistinguishableYaws { degrees: vec![0, 1, 179, 180, 181, 359] };
        assert_eq!(yaws.intervals(), 2);
        for (turn, distance) in
            [(0.5, 0.0), (-0.4, 0.0), (-3.0, 2.0), (175.0, 4.0), (180.7, 0.0), (90.0, 89.0)]
        {
            assert!((yaws.distance_deg(turn) - distance).abs() < 1e-9, "{turn}");
        }
        assert!(yaws.are_near(&IndistinguishableYaws { degrees: vec![5, 175] }, 6.0));
        assert!(!IndistinguishableYaws { degrees: vec![0, 90] }.are_near(&yaws, 10.0));
        let nothing = IndistinguishableYaws { degrees: Vec::new() };
        assert_eq!(nothing.distance_deg(0.0), 180.0);
        assert!((IndistinguishableYaws::only_itself().distance_deg(-170.0) - 170.0).abs() < 1e-9);
    }
}
