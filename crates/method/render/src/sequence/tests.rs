//! Images over a layer are those that are drawn in full, and those are nearly what the renderer of single images gives.

use super::*;
use crate::{RenderScene, render, render_geometry};
use geometry::{Camera, DVec3, Material, Rgb, TexturedMesh, shapes};

fn settings() -> RenderSettings {
    RenderSettings { supersampling: 2, shadow_map_px: 256, sky_directions: 0, sky_map_px: 32 }
}

fn mesh(solid: geometry::Solid, material: &Material) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, material);
    mesh
}

struct Meshes {
    table: TexturedMesh,
    ball: TexturedMesh,
    block: TexturedMesh,
    pane: TexturedMesh,
}

impl Meshes {
    fn new() -> Self {
        let matte = |color: u32| Material::plain("matte", Rgb::hex(color), 0.4);
        let glass = Material { opacity: 0.3, ..Material::plain("glass", Rgb::hex(0xf0f8ff), 0.1) };
        Self {
            table: mesh(
                shapes::block(DVec3::new(1.0, 0.7, 0.03)).translated(-0.03 * DVec3::Z),
                &matte(0xb08050),
            ),
            ball: mesh(shapes::sphere(0.06, 40), &matte(0xc03020)),
            block: mesh(shapes::block(DVec3::new(0.08, 0.2, 0.15)), &matte(0x3060c0)),
            pane: mesh(shapes::block(DVec3::new(0.15, 0.01, 0.12)), &glass),
        }
    }

    fn still(&self, has_glass: bool) -> Vec<RenderObject<'_>> {
        let at = |mesh, x: f64, y: f64, id| RenderObject {
            mesh,
            world_from_object: Pose::upright(DVec3::new(x, y, 0.0), 0.3),
            id,
        };
        let mut still = vec![at(&self.table, 0.0, 0.0, 1), at(&self.ball, -0.2, 0.1, 2)];
        if has_glass {
            still.push(at(&self.pane, 0.1, -0.1, 5));
        }
        still
    }

    /// A block that flies over the table, and a ball that it follows.
    fn moving(&self, step: usize) -> Vec<RenderObject<'_>> {
        let t = step as f64;
        let block = Pose::upright(DVec3::new(-0.3 + 0.15 * t, 0.05, 0.06 + 0.03 * t), 0.4 * t);
        let ball = Pose::upright(DVec3::new(0.3 - 0.1 * t, -0.15, 0.0), 0.0);
        vec![
            RenderObject { mesh: &self.block, world_from_object: block, id: 3 },
            RenderObject { mesh: &self.ball, world_from_object: ball, id: 4 },
        ]
    }
}

fn view() -> View {
    View::Perspective(Camera::orbit(160, 120, 0.7, DVec3::ZERO, 0.3, 0.6, 1.3))
}

fn light() -> (Lighting, Background) {
    (Lighting::studio(-0.6, 0.9, 0.5), Background::light_with_floor(-0.7))
}

fn poses(objects: &[RenderObject]) -> Vec<Pose> {
    objects.iter().map(|object| object.world_from_object).collect()
}

fn differences(a: &Image, b: &Image) -> Vec<u8> {
    a.as_rgba().iter().zip(b.as_rgba()).map(|(a, b)| a.abs_diff(*b)).collect()
}

#[test]
fn images_over_a_layer_are_those_that_are_drawn_in_full() {
    let meshes = Meshes::new();
    let (lighting, background) = light();
    for has_glass in [false, true] {
        let still = meshes.still(has_glass);
        let mut sequence =
            ImageSequence::new(still.clone(), meshes.moving(0), lighting, background, &settings());
        let mut layer = sequence.still_layer(&view());
        for step in [0, 1, 2, 3, 1] {
            let moving = meshes.moving(step);
            sequence.move_to(&poses(&moving));
            let (over, full) = (sequence.render_over(&mut layer), sequence.render(&view()));
            let differences = differences(&over.color, &full.color);
            // A sum in another order may round to the neighboring byte.
            assert!(differences.iter().all(|d| *d <= 1), "step {step}, glass {has_glass}");
            let other = differences.iter().filter(|d| **d > 0).count();
            assert!(100 * other < differences.len(), "{other} of {}", differences.len());
            let all: Vec<RenderObject> = still.iter().chain(&moving).copied().collect();
            let geometry = render_geometry(&all, &view());
            assert!(over.ids == geometry.ids && over.depth_m == geometry.depth_m, "step {step}");
            assert!(full.ids == geometry.ids && full.depth_m == geometry.depth_m, "step {step}");
            // A sequence without a past gives the same.
            let fresh = ImageSequence::new(still.clone(), moving, lighting, background, &settings());
            assert!(fresh.render(&view()) == full, "step {step}");
            assert!(fresh.render_over(&mut fresh.still_layer(&view())) == over, "step {step}");
        }
    }
}

#[test]
fn sequence_is_close_to_single_images() {
    let meshes = Meshes::new();
    let (lighting, background) = light();
    let (still, moving) = (meshes.still(false), meshes.moving(2));
    let sequence = ImageSequence::new(still.clone(), moving.clone(), lighting, background, &settings());
    let scene = RenderScene { objects: still.into_iter().chain(moving).collect(), lighting, background };
    let single = render(&scene, &view(), &RenderSettings { shadow_map_px: 160, ..settings() });
    let differences = differences(&sequence.color(&view()), &single.color);
    let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
    let apart = differences.iter().filter(|d| **d > 24).count();
    // Maps of shadows have other texels.
    assert!(mean < 0.6, "mean {mean}");
    assert!(100 * apart < differences.len(), "{apart} of {}", differences.len());
}

#[test]
fn shadows_of_what_moves_move() {
    let meshes = Meshes::new();
    let (lighting, background) = light();
    let mut sequence =
        ImageSequence::new(meshes.still(false), meshes.moving(0), lighting, background, &settings());
    let mut layer = sequence.still_layer(&view());
    let first = sequence.render_over(&mut layer);
    sequence.move_to(&poses(&meshes.moving(3)));
    let later = sequence.render_over(&mut layer);
    let on_table = |k: &usize| first.ids[*k] == 1 && later.ids[*k] == 1;
    let brightness = |frame: &Frame, k: usize| i32::from(frame.color.as_rgba()[4 * k + 1]);
    let table: Vec<usize> = (0..first.ids.len()).filter(on_table).collect();
    let change = |k: &&usize| brightness(&later, **k) - brightness(&first, **k);
    let (lit, dark) =
        (table.iter().filter(|k| change(k) > 20).count(), table.iter().filter(|k| change(k) < -20).count());
    assert!(lit > 100 && dark > 100, "{lit} pixels of the table get light, {dark} get shadow");
}
