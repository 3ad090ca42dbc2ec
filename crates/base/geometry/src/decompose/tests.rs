//! Decompositions of known shapes, and their properties.

use super::*;
use crate::shapes::{block, lathe, ring, shell_of_revolution, sphere, tube};
use crate::{Material, Rgb, Solid};
use glam::{DQuat, DVec2, DVec3};

pub(super) fn settings() -> DecomposeSettings {
    DecomposeSettings {
        tolerance_m: 0.0015,
        max_hulls: 32,
        joined_excess_m: 0.003,
        max_pieces: 48,
        max_vertices: 64,
        min_thickness_m: 0.001,
        excess_spacing_m: 0.004,
    }
}

fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    mesh
}

fn mug() -> TexturedMesh {
    let profile = [DVec2::new(0.035, 0.0), DVec2::new(0.04, 0.05), DVec2::new(0.04, 0.1)];
    let path: Vec<DVec3> = (0..=12)
        .map(|k| {
            let angle = std::f64::consts::PI * (f64::from(k) / 12.0 - 0.5);
            DVec3::new(0.038 + 0.028 * angle.cos(), 0.0, 0.055 + 0.032 * angle.sin())
        })
        .collect();
    mesh([shell_of_revolution(&profile, 0.004, 0.006, 64), tube(&path, 0.005, 12)])
}

fn is_in_a_hull(d: &Decomposition, p: DVec3) -> bool {
    d.hulls.iter().any(|h| distance_above(&planes(h), p) < 1e-6)
}

#[test]
fn decompose_returns_convex_parts_unchanged() {
    let blocks = [block(DVec3::splat(0.1)), sphere(0.012, 32).translated(DVec3::new(0.0, 0.0, 0.1))];
    let d = decompose(&mesh(blocks), &settings(), &CancelFlag::default()).expect("two convex parts");
    assert_eq!(d.hulls.len(), 2);
    assert!(d.watertight && d.max_excess_m < 0.0011, "{}", d.max_excess_m);
    assert!((d.hull_volume_m3 / d.mesh_volume_m3 - 1.0).abs() < 0.02);
}

#[test]
fn decompose_keeps_the_cavity_of_a_vase_open() {
    // Radius and height of the outside, millimeters.
    let outside = [
        (35.24, 0.0),
        (39.75, 5.5),
        (46.02, 13.53),
        (51.16, 22.84),
        (54.57, 32.56),
        (56.84, 43.56),
        (56.84, 57.09),
        (53.26, 74.68),
        (47.41, 94.81),
        (42.06, 114.18),
        (37.68, 131.78),
        (33.81, 148.61),
        (31.83, 164.42),
        (32.71, 179.48),
        (35.49, 193.52),
        (38.65, 205.53),
        (42.19, 215.34),
        (46.1, 223.12),
        (48.88, 228.37),
    ];
    let outside: Vec<DVec2> = outside.iter().map(|&(radius, z)| 1e-3 * DVec2::new(radius, z)).collect();
    let body = shell_of_revolution(&outside, 0.004, 0.007, 40);
    let lip = ring(0.0469, 0.0026, 44, 8).translated(DVec3::Z * 0.2238);
    let d = decompose(&mesh([body, lip]), &settings(), &CancelFlag::default()).expect("a vase");
    assert!(
        d.hulls.len() <= 32 && d.hull_volume_m3 < 2.3 * d.mesh_volume_m3,
        "{} {}",
        d.hull_volume_m3,
        d.mesh_volume_m3
    );
    assert!(d.max_excess_m < 0.015, "{}", d.max_excess_m);
    for z in [0.02, 0.1, 0.2] {
        assert!(!is_in_a_hull(&d, DVec3::new(0.0, 0.0, z)), "the cavity is filled at {z}");
    }
}

/// Regression: half a turn is pi or -pi depending on rounding; sorted, such rings were one step apart.
#[test]
fn revolution_is_recognized_despite_rounding_at_its_seam() {
    let outside = [DVec2::new(0.03, 0.0), DVec2::new(0.04, 0.1)];
    let mut cup = shells(&mesh([shell_of_revolution(&outside, 0.004, 0.006, 40)])).remove(0);
    let seam = cup.points.iter_mut().filter(|p| p.x < 0.0 && p.y.abs() < 1e-9);
    for (k, point) in seam.enumerate() {
        point.y = if k % 2 == 0 { 1e-17 } else { -1e-17 };
    }
    assert!(Revolution::recognize(&cup).is_some());
}

#[test]
fn decompose_keeps_mug_and_handle_open() {
    let d = decompose(&mug(), &settings(), &CancelFlag::default()).expect("a mug");
    assert!(d.hulls.len() > 8 && d.hulls.iter().all(|h| h.points.len() <= 64));
    for z in [0.012, 0.05, 0.099] {
        assert!(!is_in_a_hull(&d, DVec3::new(0.0, 0.0, z)), "the cavity is filled at {z}");
        assert!(!is_in_a_hull(&d, DVec3::new(0.02, 0.01, z)), "the cavity is filled at {z}");
    }
    assert!(!is_in_a_hull(&d, DVec3::new(0.05, 0.0, 0.055)), "the handle is filled");
    assert!(is_in_a_hull(&d, DVec3::new(0.066, 0.0, 0.055)), "the handle is missing");
    assert!(is_in_a_hull(&d, DVec3::new(-0.038, 0.0, 0.08)), "the wall is missing");
    assert!(is_in_a_hull(&d, DVec3::new(0.0, 0.0, 0.003)), "the floor is missing");
    assert!(d.max_excess_m < 0.004, "hulls stick out by {}", d.max_excess_m);
    let lowest = d.hulls.iter().flat_map(|h| &h.points).map(|p| p.z).fold(1.0, f64::min);
    assert!(lowest.abs() < 1e-9);
}

#[test]
fn decompose_covers_the_surface() {
    for shape in [mug(), mesh([ring(0.05, 0.01, 48, 16)])] {
        let d = decompose(&shape, &settings(), &CancelFlag::default()).expect("a shape");
        let faces: Vec<_> = d.hulls.iter().map(planes).collect();
        for t in shape.triangles() {
            let center = t.map(|v| shape.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
            let outside = faces.iter().map(|f| distance_above(f, center)).fold(f64::INFINITY, f64::min);
            assert!(outside < 0.0008, "{center} sticks out by {outside}");
        }
    }
}

#[test]
fn decompose_gives_the_same_bytes_with_one_and_two_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| decompose(&mug(), &settings(), &CancelFlag::default())).expect("a mug")
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn decompose_stops_on_cancel_and_rejects_an_empty_mesh() {
    let cancel = CancelFlag::default();
    cancel.cancel();
    assert_eq!(decompose(&mug(), &settings(), &cancel), Err(DecomposeError::Cancelled(Cancelled)));
    let nothing = decompose(&TexturedMesh::default(), &settings(), &CancelFlag::default());
    assert_eq!(nothing, Err(DecomposeError::NoHull));
}

#[test]
fn air_under_a_lid_is_no_opening_and_a_gap_beside_the_lid_makes_it_one() {
    let outside = [DVec2::new(0.042, 0.0), DVec2::new(0.042, 0.0165)];
    let dish = || shell_of_revolution(&outside, 0.0015, 0.0015, 48);
    let lid = |radius_m: f64| {
        let profile = [(0.0, 0.016), (radius_m, 0.016), (radius_m, 0.018), (0.0, 0.018)];
        lathe(&profile.map(|(radius, height)| DVec2::new(radius, height)), 48)
    };
    let open_share = |mesh: &TexturedMesh| {
        let solid = MeshSolid::new(mesh).expect("a dish");
        let filled = convex_hull(&mesh.positions, 64, 0.0).expect("a hull");
        fit(&solid, &Field::new(&solid), &[filled], &CancelFlag::default()).expect("figures").open_share
    };
    assert_eq!(open_share(&mesh([dish(), lid(0.042)])), 1.0, "nothing gets in, so nothing is filled");
    assert!(open_share(&mesh([dish(), lid(0.02)])) < 0.1);
    assert!(open_share(&mesh([dish()])) < 0.1);
}

#[test]
fn fit_is_perfect_for_a_block_and_reports_a_filled_mug() {
    let figures = |mesh: &TexturedMesh| decompose_and_fit(mesh, &settings(), &CancelFlag::default());
    let (_, perfect) = figures(&mesh([block(DVec3::splat(0.1))])).expect("a block");
    assert!(
        perfect.air_share == 0.0 && perfect.open_share == 1.0 && perfect.hausdorff_m() < 1e-9,
        "{perfect:?}"
    );
    let (_, close) = figures(&mug()).expect("a mug");
    assert!(close.open_share > 0.9 && close.hausdorff_m() < 0.006 && close.air_share < 0.5, "{close:?}");
    let solid = MeshSolid::new(&mug()).expect("a mug");
    let filled = convex_hull(&mug().positions, 64, 0.0).expect("a hull");
    let filled = fit(&solid, &Field::new(&solid), &[filled], &CancelFlag::default()).expect("figures");
    assert!(filled.open_share < 0.1 && filled.hausdorff_m() > 0.03 && filled.air_share > 2.0, "{filled:?}");
}

#[test]
fn decompose_cuts_a_large_column_at_its_waists() {
    // Too large for a distance grid; on its axis the column is nearer to the top than to its own side.
    let profile =
        [(0.0, 0.0), (0.06, 0.0), (0.04, 0.1), (0.06, 0.4), (0.04, 0.62), (0.1, 0.702), (0.0, 0.702)];
    let column = lathe(&profile.map(|(radius, height)| DVec2::new(radius, height)), 40);
    let top = block(DVec3::new(1.6, 1.0, 0.03)).translated(DVec3::new(0.0, 0.0, 0.7));
    let d = decompose(&mesh([top, column]), &settings(), &CancelFlag::default()).expect("a table");
    assert!(d.hulls.len() <= 6 && d.max_excess_m < 0.0016, "{} out {}", d.hulls.len(), d.max_excess_m);
    assert!(!is_in_a_hull(&d, DVec3::new(0.055, 0.0, 0.1)), "the waist is filled");
}

#[test]
fn decompose_with_few_hulls_minimizes_added_volume() {
    let mug = mug();
    let mut last_m3 = f64::INFINITY;
    for max_hulls in [2, 8, 24, 60] {
        let settings = DecomposeSettings {
            max_hulls,
            tolerance_m: 0.0002,
            max_pieces: 4 * max_hulls,
            joined_excess_m: 1.0,
            ..settings()
        };
        let d = decompose(&mug, &settings, &CancelFlag::default()).expect("a mug");
        assert!(d.hulls.len() <= max_hulls as usize, "{} of {max_hulls}", d.hulls.len());
        assert!(d.hull_volume_m3 < last_m3, "{max_hulls} hulls hold {} m^3", d.hull_volume_m3);
        last_m3 = d.hull_volume_m3;
    }
    assert!(last_m3 < 1.3 * 9.9e-5 * 2.0, "{last_m3}");
}

#[test]
fn decompose_repairs_an_open_mesh_and_keeps_its_opening() {
    // A mug without the triangles of its handle's ends.
    let mut torn = mug();
    let is_end = |t: &[u32; 3]| {
        t.iter().all(|&v| torn.positions[v as usize].x < 0.0385 && torn.positions[v as usize].y.abs() < 0.006)
    };
    let kept: Vec<Vec<[u32; 3]>> =
        torn.groups.iter().map(|g| g.triangles.iter().copied().filter(|t| !is_end(t)).collect()).collect();
    torn.groups.iter_mut().zip(kept).for_each(|(group, kept)| group.triangles = kept);
    let d = decompose(&torn, &settings(), &CancelFlag::default()).expect("a mug");
    assert!(!d.watertight && d.repair.holes_filled > 0 && d.repair.shells_remeshed == 0, "{:?}", d.repair);
    assert!(!is_in_a_hull(&d, DVec3::new(0.0, 0.0, 0.05)) && !is_in_a_hull(&d, DVec3::new(0.05, 0.0, 0.055)));
}

#[test]
fn piece_volume_is_that_of_the_solid_in_its_cell() {
    use super::piece::Piece;
    use super::plane::Plane;
    let shells = crate::shells::shells(&mesh([ring(0.05, 0.01, 48, 16)]));
    let solid = MeshSolid::from_shells(&shells).expect("a ring");
    let is_inside = |p| solid.depth_m(p) > 0.0;
    let whole = Piece::new(&shells[0]);
    assert!((whole.volume_m3() - shells[0].volume_m3()).abs() < 1e-15);
    let mut pieces = vec![whole];
    for (point, normal) in [
        (DVec3::ZERO, DVec3::X),
        (DVec3::new(0.0, 0.01, 0.002), DVec3::new(0.2, 0.6, 0.7)),
        (DVec3::ZERO, DVec3::Y),
    ] {
        let plane = Plane::through(point, normal.normalize());
        pieces = pieces
            .iter()
            .flat_map(|p| p.split(&plane, is_inside).map_or(vec![p.clone()], |(a, b)| vec![a, b]))
            .collect();
    }
    assert!(pieces.len() > 4);
    let volumes: Vec<f64> = pieces.iter().map(Piece::volume_m3).collect();
    assert!(volumes.iter().all(|&v| v > 0.0), "{volumes:?}");
    assert!((volumes.iter().sum::<f64>() / shells[0].volume_m3() - 1.0).abs() < 1e-9);
    for (piece, volume_m3) in pieces.iter().zip(volumes) {
        let hull = convex_hull(&piece.spanning_points(), usize::MAX, 0.0).expect("a hull");
        assert!(volume_m3 < hull.volume_m3() * (1.0 + 1e-9));
    }
}

#[test]
fn a_lying_vase_is_cut_as_a_standing_one() {
    let outside =
        [(0.03, 0.0), (0.05, 0.03), (0.06, 0.08), (0.05, 0.12), (0.024, 0.17), (0.02, 0.2), (0.03, 0.23)];
    let outside = outside.map(|(radius, z)| DVec2::new(radius, z));
    let standing = mesh([shell_of_revolution(&outside, 0.004, 0.007, 40)]);
    let turn = DQuat::from_rotation_y(1.4) * DQuat::from_rotation_x(0.7);
    for squeeze in [1.0, 0.97] {
        let squeezed = standing.clone().scaled(DVec3::new(squeeze, 1.0, 1.0));
        let lying = squeezed.clone().rotated(turn).snap_to_f32();
        let [upright, tipped] = [squeezed, lying]
            .map(|mesh| decompose(&mesh, &settings(), &CancelFlag::default()).expect("a vase"));
        assert!(tipped.max_excess_m < 1.2 * upright.max_excess_m + 0.001, "{}", tipped.max_excess_m);
        let volume = tipped.hull_volume_m3 / upright.hull_volume_m3;
        assert!((0.9..1.1).contains(&volume), "{volume}");
    }
}
