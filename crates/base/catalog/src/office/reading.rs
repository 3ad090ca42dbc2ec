//! Book, notebook, stack of paper, sticky notes, bookend.

use std::f64::consts::{PI, TAU};

use glam::DQuat;
use rand::RngExt;

use super::images::{book_cover, note, page_edges};
use super::parts::*;
use crate::Order;
use crate::tables::grain::along_repeating;
use crate::texture::{mapped_from_above, printed_page};
use geometry::shapes::{lathe, rectangle, rounded_rectangle};
use geometry::{DVec2, DVec3, Material, Rgb, TexturedMesh};

const PAPER: Rgb = Rgb::hex(0xf1_ea_d8);

/// Closed hardcover lying on its back: two boards, a rounded spine at the left, a block of pages.
pub fn book(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let cover = body_finish(order, 0.6);
    let front = Material::textured("front_cover", book_cover(cover.base_color, &mut order.rng), 0.55);
    let pages = Material::textured("pages", page_edges(PAPER, &mut order.rng), 0.9);
    let (w, d, h) = (size.x, size.y, size.z);
    let board_m = 0.0025;
    let spine = (0.18 * h).max(0.004);
    let left = -0.5 * w + spine;
    let mut mesh = TexturedMesh::default();
    for (low, finish) in [(0.0, &cover), (h - board_m, &front)] {
        let lid = rounded(at(left, -0.5 * d, low), at(0.5 * w, 0.5 * d, low + board_m), 0.002, 0.0008);
        mesh.add(mapped_from_above(lid), finish);
    }
    let block = [
        p2(left - 0.4 * spine, board_m - 0.0005),
        p2(0.5 * w - 0.0045, board_m - 0.0005),
        p2(0.5 * w - 0.0065, 0.3 * h),
        p2(0.5 * w - 0.0065, 0.7 * h),
        p2(0.5 * w - 0.0045, h - board_m + 0.0005),
        p2(left - 0.4 * spine, h - board_m + 0.0005),
    ];
    let mut block = upright(&block, -0.5 * d + 0.004, 0.5 * d - 0.004, 0.0);
    for (uv, p) in block.uvs.iter_mut().zip(&block.positions) {
        *uv = geometry::Vec2::new((10.0 * (p.x + p.y)) as f32, (p.z / h) as f32);
    }
    mesh.add(block, &pages);
    // The spine: a half ellipse around the left edges of both boards.
    let arc = |grow: f64, steps: i32| -> Vec<DVec2> {
        (0..=steps)
            .map(|k| {
                let angle = PI * f64::from(k) / f64::from(steps);
                p2(left - (spine + grow) * angle.sin(), 0.5 * h + (0.5 * h + grow.min(0.0)) * angle.cos())
            })
            .collect()
    };
    let mut outline = arc(0.0, 14);
    outline.extend(arc(-0.0022, 14).iter().rev().map(|p| *p + p2(0.002, 0.0)));
    mesh.add(upright(&outline, -0.5 * d, 0.5 * d, 0.0), &cover);
    let band = Material::plain("spine_band", front_ink(cover.base_color), 0.5);
    for y in [-0.34, 0.3, 0.36] {
        let mut outline = arc(0.0006, 14);
        outline.extend(arc(-0.001, 14).iter().rev());
        mesh.add(upright(&outline, y * d, (y + 0.025) * d, 0.0), &band);
    }
    fitted(mesh, size)
}

fn front_ink(color: Rgb) -> Rgb {
    if color.0.iter().sum::<f32>() > 1.6 { Rgb::hex(0x2a_24_22) } else { Rgb::hex(0xec_d8_9a) }
}

/// Spiral-bound at the left, or bound with an elastic band and a ribbon.
pub fn notebook(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let cover = body_finish(order, 0.55);
    let pages = Material::textured("pages", page_edges(Rgb::hex(0xf6_f3_ea), &mut order.rng), 0.9);
    let label = Material::textured("label", note(Rgb::hex(0xf4_ee_dc), &mut order.rng), 0.8);
    let (w, d, h) = (size.x, size.y, size.z);
    let spiral = order.pick(3) < 2;
    let mut mesh = TexturedMesh::default();
    // What rises above the cover: an elastic band and a sticker, or hardly anything. Notebooks of a stack lie on their
    // covers, and rock neither on coils nor on stickers.
    let (z0, z1, sticker) = if spiral { (0.0, h - 0.0002, 0.0001) } else { (0.0, h - 0.0009, 0.0006) };
    let wire_radius = if spiral { 0.5 * z1 - 0.0006 } else { 0.0 };
    let left = -0.5 * w + wire_radius;
    let corner = 0.008;
    let sheet = 0.0016;
    mesh.add(rounded(at(left, -0.5 * d, z0), at(0.5 * w, 0.5 * d, z0 + sheet), corner, 0.0004), &cover);
    let top = rounded(at(left, -0.5 * d, z1 - sheet), at(0.5 * w, 0.5 * d, z1), corner, 0.0004);
    mesh.add(top, &cover);
    let block = rounded(
        at(left + 0.002, -0.5 * d + 0.002, z0 + sheet - 0.0003),
        at(0.5 * w - 0.002, 0.5 * d - 0.002, z1 - sheet + 0.0003),
        corner,
        0.0,
    );
    mesh.add(block.with_box_uvs(0.02), &pages);
    let (lx, ly) = (left + 0.5 * (0.5 * w - left), 0.18 * d);
    let tag = rounded(
        at(lx - 0.24 * w, ly - 0.1 * d, z1 - 0.0006),
        at(lx + 0.24 * w, ly + 0.1 * d, z1 + sticker),
        0.003,
        0.0003,
    );
    mesh.add(mapped_from_above(tag), &label);
    if spiral {
        let wire = Material::metal("wire", Rgb::hex(0x8a_8d_92), 0.35);
        // A coil on a core: one body with ripples, which one hull covers. Few corners, since each is looked up where
        // notebooks lie on each other.
        let (loops, bar) = ((d / 0.0125) as i32, 0.0013);
        let (outer, inner) = (wire_radius, wire_radius - bar);
        let mut profile = vec![DVec2::new(0.0, -0.5 * d), DVec2::new(inner, -0.5 * d)];
        for k in 0..loops {
            let y = -0.5 * d + (f64::from(k) + 0.5) * d / f64::from(loops);
            let ripple = [(inner, -1.5 * bar), (outer, 0.0), (inner, 1.5 * bar)];
            profile.extend(ripple.map(|(radius, along)| DVec2::new(radius, y + along)));
        }
        profile.extend([DVec2::new(inner, 0.5 * d), DVec2::new(0.0, 0.5 * d)]);
        let coil = lathe(&profile, 14).rotated(DQuat::from_rotation_x(-0.5 * PI));
        mesh.add(coil.translated(at(left + 0.15 * wire_radius, 0.0, 0.5 * z1)), &wire);
    } else {
        let elastic = plain("elastic", 0x1d_1d_20, 0.8);
        let x = 0.36 * w;
        mesh.add(
            rounded(at(x, -0.5 * d - 0.0008, 0.0), at(x + 0.006, 0.5 * d + 0.0008, h), 0.001, 0.0008),
            &elastic,
        );
        let ribbon = plain("ribbon", 0xb0_30_2c, 0.7);
        mesh.add(
            board(
                at(-0.05 * w, -0.5 * d - 0.012, 0.4 * h),
                at(-0.05 * w + 0.006, -0.4 * d, 0.4 * h + 0.0012),
            ),
            &ribbon,
        );
    }
    fitted(mesh, size)
}

/// Sheets in a slightly untidy pile, printed.
pub fn paper_stack(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let print = Material::textured("printed_sheet", printed_page(Rgb::hex(0xfa_f9_f5), &mut order.rng), 0.9);
    let edges = Material::textured("sheets", page_edges(Rgb::hex(0xf4_f2_ec), &mut order.rng), 0.9);
    let layers = ((h / 0.002) as i32).clamp(8, 24);
    let step = h / f64::from(layers);
    let mut mesh = TexturedMesh::default();
    for k in 0..layers {
        let top = k + 1 == layers;
        let outline = rounded_rectangle(0.965 * w, 0.975 * d, 0.0015, 2);
        let turn = if k % 3 == 0 { order.uniform(-0.02, 0.02) } else { order.uniform(-0.006, 0.006) };
        let shift = at(order.uniform(-0.006, 0.006) * w, order.uniform(-0.006, 0.006) * d, 0.0);
        let low = f64::from(k) * step - if k == 0 { 0.0 } else { 0.0003 };
        let sheet = plate(&outline, low, f64::from(k + 1) * step, 0.0);
        let mut sheet = if top { mapped_from_above(sheet) } else { sheet };
        if !top {
            for (uv, p) in sheet.uvs.iter_mut().zip(&sheet.positions) {
                *uv = geometry::Vec2::new(p.x as f32 * 5.0, (p.z / h) as f32);
            }
        }
        mesh.add(
            sheet.rotated(DQuat::from_rotation_z(turn)).translated(shift),
            if top { &print } else { &edges },
        );
    }
    fitted(mesh, size)
}

/// A square pad; the top note is written on and curls up toward the viewer.
pub fn sticky_notes(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let color = order.color;
    let written = Material::textured("note", note(color, &mut order.rng), 0.9);
    let curl = 0.3 * h + 0.004;
    let pad_top = h - curl;
    let layers = 8;
    let mut mesh = TexturedMesh::default();
    let step = pad_top / f64::from(layers);
    for k in 0..layers {
        let shade = Material::plain(
            &format!("pad_{}", k % 2),
            color.scaled(if k % 2 == 0 { 0.9 } else { 0.98 }),
            0.9,
        );
        let reach = 0.4975 + order.uniform(-0.0025, 0.0025);
        let outline = rounded_rectangle(2.0 * reach * w, 2.0 * reach * d, 0.0008, 2);
        let low = f64::from(k) * step - if k == 0 { 0.0 } else { 0.0003 };
        mesh.add(plate(&outline, low, f64::from(k + 1) * step, 0.0), &shade);
    }
    let thick = 0.0011;
    let steps = 16;
    let (bend, sway) = (0.35 * d, order.uniform(-0.25, 0.25));
    let lift = |x: f64, y: f64| {
        let t = ((-y - 0.5 * d + bend) / bend).clamp(0.0, 1.0);
        (curl - thick) * t * t * (1.0 - sway.abs() + sway * 2.0 * x / w).clamp(0.0, 1.0)
    };
    let rows = 3;
    let rings: Vec<Vec<DVec3>> = (0..=steps)
        .map(|k| {
            let y = 0.5 * d - d * f64::from(k) / f64::from(steps);
            let x = |j: i32| w * (f64::from(j) / f64::from(rows) - 0.5);
            let base = pad_top - 0.0003;
            let mut points: Vec<DVec3> = (0..=rows).map(|j| at(x(j), y, base + lift(x(j), y))).collect();
            points.extend((0..=rows).rev().map(|j| at(x(j), y, base + lift(x(j), y) + thick)));
            points.reverse();
            points
        })
        .collect();
    mesh.add(mapped_from_above(skin(&rings)), &written);
    fitted(mesh, size)
}

/// An upright with an arched top and a foot, joined by a brace; wood or bent metal.
pub fn bookend(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let body = body_finish(order, 0.5);
    let wooden = order.rng.random_range(0..2) == 0;
    let thick = if wooden { 0.014 } else { 0.008 };
    let mut mesh = TexturedMesh::default();
    // The upright stands at the left and faces +x: an arch in the y-z plane.
    let steps = 18;
    let mut arch = vec![p2(-0.5 * d, 0.0), p2(0.5 * d, 0.0)];
    arch.extend((0..=steps).map(|k| {
        let angle = PI * f64::from(k) / f64::from(steps);
        p2(0.5 * d * angle.cos(), h - 0.5 * d + 0.5 * d * angle.sin())
    }));
    let grain = |solid| along_repeating(solid, DVec3::Z, 0.25);
    mesh.add(grain(side_on(&arch, -0.5 * w, -0.5 * w + thick, 0.0015)), &body);
    let foot = rounded(at(-0.5 * w + 0.004, -0.5 * d, 0.0), at(0.5 * w, 0.5 * d, 0.7 * thick), 0.012, 0.0015);
    mesh.add(along_repeating(foot, DVec3::X, 0.25), &body);
    let accent = Material::metal("brass", Rgb::hex(0xc9_a2_4c), 0.35);
    let inner = -0.5 * w + thick;
    let brace = [
        p2(inner - 0.001, 0.7 * thick - 0.001),
        p2(0.36 * w, 0.7 * thick - 0.001),
        p2(inner + 0.22 * w, 0.2 * h),
        p2(inner + 0.1 * w, 0.42 * h),
        p2(inner - 0.001, 0.62 * h),
    ];
    mesh.add(upright(&brace, -0.06 * d, 0.06 * d, 0.001), &accent);
    // A raised star or disc on the back of the upright.
    let emblem: Vec<DVec2> = if wooden {
        (0..10)
            .map(|k| {
                DVec2::from_angle(TAU * (0.25 + k as f64 / 10.0)) * d * if k % 2 == 0 { 0.26 } else { 0.11 }
            })
            .collect()
    } else {
        rectangle(0.3 * d, 0.3 * d).iter().map(|p| p.rotate(DVec2::from_angle(0.25 * PI))).collect()
    };
    let emblem: Vec<DVec2> = emblem.iter().map(|p| *p + p2(0.0, 0.62 * h)).collect();
    mesh.add(side_on(&emblem, -0.5 * w - 0.002, -0.5 * w + 0.002, 0.0), &accent);
    fitted(mesh, size)
}
