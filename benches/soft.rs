//! Soft silhouettes of one mesh in many poses, compared with a mask; and the soft image in its colors.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::{FaceGroup, Material, Rgb, TexturedMesh};
use glam::{DVec2, Vec2, Vec3};
use imaging::Image;
use rayon::prelude::*;
use soft_raster::color::{ColorInput, MovingDirection, MovingKey, SoftImage, StudioLight};
use soft_raster::loss::{SoftTerms, Target, terms};
use soft_raster::{Grid, MovingPoint, ShadingMaterials, SoftSilhouette, Surface};

/// The paper's crop and PyTorch3D's usual blur on it.
const SIDE_PX: usize = 256;
const SIGMA_PX2: f32 = 1.6;

/// A closed ring with waves, seen askew: rings and quads around, two triangles a quad, 4,608 in all.
const AROUND: u32 = 96;
const ACROSS: u32 = 24;

fn ring() -> Surface {
    let at = |u: u32, v: u32| u % AROUND * ACROSS + v % ACROSS;
    let quads = (0..AROUND).flat_map(|u| (0..ACROSS).map(move |v| (u, v)));
    let triangles = quads.flat_map(|(u, v)| {
        let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
        [[a, b, c], [a, c, d]]
    });
    Surface::new(&triangles.collect::<Vec<_>>())
}

/// Vertices of the ring at a yaw, from 40 degrees above, without perspective.
fn points(yaw_rad: f64) -> Vec<MovingPoint<1>> {
    let (sin_e, cos_e) = 0.7_f64.sin_cos();
    let vertices = (0..AROUND).flat_map(|u| (0..ACROSS).map(move |v| (u, v)));
    vertices
        .map(|(u, v)| {
            let (a, b) = (TAU * f64::from(u) / f64::from(AROUND), TAU * f64::from(v) / f64::from(ACROSS));
            let radius = 70.0 + (25.0 + 6.0 * (5.0 * a).sin()) * b.cos();
            let (p, z) = (DVec2::new(1.2 * radius * a.cos(), radius * a.sin()), 30.0 * b.sin());
            let turned = DVec2::from_angle(yaw_rad).rotate(p);
            let seen = |p: DVec2, z: f64| DVec2::new(p.x, -p.y * sin_e - z * cos_e);
            let at_px = seen(turned, z) + 0.5 * SIDE_PX as f64;
            let slope = seen(turned.perp(), 0.0);
            MovingPoint { at_px: at_px.as_vec2().into(), slopes: [slope.as_vec2().into()] }
        })
        .collect()
}

/// The ring with a checkered texture wound around it; where it is does not matter to its colors.
fn colored(surface: &Surface) -> TexturedMesh {
    let mut texture = Image::filled(256, 256, [220, 200, 180, 255]);
    for (x, y) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        if (x / 32 + y / 32) % 2 == 0 {
            texture.set_pixel(x, y, [60, 40, 120, 255]);
        }
    }
    let mut material = Material::plain("checks", Rgb::hex(0xffffff), 0.5);
    material.base_color_texture = Some(texture.into());
    let vertices = || (0..AROUND).flat_map(|u| (0..ACROSS).map(move |v| (u as f32, v as f32)));
    let angles = |u: f32, v: f32| {
        (std::f32::consts::TAU * u / AROUND as f32, std::f32::consts::TAU * v / ACROSS as f32)
    };
    let normal = |(u, v)| {
        let (a, b) = angles(u, v);
        Vec3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin())
    };
    let normals: Vec<Vec3> = vertices().map(normal).collect();
    TexturedMesh {
        positions: normals.iter().map(|n| n.as_dvec3()).collect(),
        normals,
        uvs: vertices().map(|(u, v)| Vec2::new(u / AROUND as f32, v / ACROSS as f32)).collect(),
        groups: vec![FaceGroup { material: 0, triangles: surface.triangles.clone() }],
        materials: vec![material],
    }
}

/// The colors of one pose, its silhouette drawn already, at half its resolution.
fn bench_color(criterion: &mut Criterion) {
    let (surface, grid, points) = (ring(), Grid::square(SIDE_PX), points(0.3));
    let mut silhouette = SoftSilhouette::default();
    silhouette.draw(&surface, &points, grid, SIGMA_PX2);
    let faces: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    let shading = ShadingMaterials::new(&colored(&surface), &faces, &surface);
    // Without perspective a key is any number that falls with depth: lower on the screen is nearer.
    let key = |point: &MovingPoint<1>| MovingKey {
        key: 1.0 + 1e-3 * point.at_px[1],
        slopes: [1e-3 * point.slopes[0][1]],
    };
    let keys: Vec<MovingKey<1>> = points.iter().map(key).collect();
    let still = |at: Vec3| MovingDirection { at, slopes: [Vec3::ZERO] };
    let light = StudioLight { toward_key: still(Vec3::new(-0.48, -0.6, 0.64)), up: still(Vec3::Z) };
    let mut image = SoftImage::default();
    criterion.bench_function("soft/one_in_color", |b| {
        b.iter(|| {
            image.draw(&ColorInput {
                surface: &surface,
                points: black_box(&points),
                keys: &keys,
                shading: &shading,
                light: &light,
                silhouette: &silhouette,
                shrink: 2,
            });
        })
    });
}

fn bench(criterion: &mut Criterion) {
    let (surface, grid) = (ring(), Grid::square(SIDE_PX));
    let drawn = |points: &[MovingPoint<1>]| {
        let mut drawn = SoftSilhouette::default();
        drawn.draw(&surface, points, grid, SIGMA_PX2);
        drawn
    };
    let mask = drawn(&points(0.3)).coverage().to_vec();
    let (known, distance_px) = (vec![1.0; grid.pixels()], vec![3.0; grid.pixels()]);
    let mask_area_px2 = mask.iter().map(|&m| f64::from(m)).sum();
    let side_px = SIDE_PX as f64;
    let target = Target { mask: &mask, known: &known, distance_px: &distance_px, mask_area_px2, side_px };
    let coarse: Vec<_> = (0..72).map(|k| points(TAU * f64::from(k) / 72.0)).collect();
    for (name, poses) in [("one", &coarse[..1]), ("eight", &coarse[..8]), ("whole_turn", &coarse[..])] {
        criterion.bench_function(&format!("soft/{name}"), |b| {
            b.iter(|| {
                let compared = |points: &Vec<MovingPoint<1>>| terms(&drawn(points), &target);
                black_box(poses).par_iter().map(compared).collect::<Vec<SoftTerms<1>>>()
            })
        });
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench, bench_color }
criterion_main!(benches);
