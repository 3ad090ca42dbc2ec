//! A made scene: everything on a table, as `sentences.toml` speaks of it. Objects are boxes; containers are open boxes.

use std::sync::Arc;

use editing::EditableObject;
use geometry::convex_hull::convex_hull;
use geometry::{ConvexHull, Outline, Pose, Rgb};
use glam::{DVec2, DVec3};
use scene::{InstanceId, Supporter};
use tasks::{ObjectShape, PosedObject, TaskScene};

/// Name, label, category, color, material, extents, center on the table; directions as seen from the front edge.
type Row = (&'static str, &'static str, &'static str, u32, &'static str, [f64; 3], [f64; 2]);

const ROWS: [Row; 19] = [
    ("laptop_1", "laptop", "laptop", 0x85_88_8c, "plastic", [0.34, 0.24, 0.22], [0.0, 0.15]),
    ("mug_1", "red mug", "mug", 0xb5_35_2b, "ceramic", [0.12, 0.09, 0.10], [-0.30, 0.12]),
    ("mug_2", "mug", "mug", 0x2f_5f_ae, "ceramic", [0.12, 0.09, 0.10], [0.27, 0.12]),
    ("plate_1", "plate", "plate", 0xf2_f0_ea, "porcelain", [0.26, 0.26, 0.02], [-0.38, -0.25]),
    ("plate_2", "plate", "plate", 0xf2_f0_ea, "porcelain", [0.20, 0.20, 0.02], [0.38, -0.25]),
    ("spoon_1", "spoon", "spoon", 0xb0_b2_b5, "steel", [0.03, 0.03, 0.16], [-0.30, 0.12]),
    ("spoon_2", "wooden spoon", "spoon", 0xb0_80_50, "wood", [0.22, 0.04, 0.02], [0.0, -0.40]),
    ("tray_1", "tray", "tray", 0x7a_52_30, "wood", [0.40, 0.26, 0.03], [0.0, -0.20]),
    ("apple_1", "apple", "apple", 0xb9_2b_27, "fruit", [0.07, 0.07, 0.07], [-0.10, -0.20]),
    ("banana_1", "banana", "banana", 0xf0_c3_30, "fruit", [0.16, 0.05, 0.04], [0.08, -0.20]),
    ("book_1", "book", "book", 0x2f_63_b5, "paper", [0.15, 0.20, 0.02], [-0.58, 0.27]),
    ("book_2", "green book", "book", 0x3f_8f_4f, "paper", [0.15, 0.20, 0.02], [-0.32, 0.36]),
    ("book_3", "book", "book", 0xc0_39_2b, "paper", [0.15, 0.20, 0.02], [0.10, 0.42]),
    ("lamp_1", "desk lamp", "desk_lamp", 0x25_26_2a, "steel", [0.15, 0.15, 0.45], [0.52, 0.38]),
    ("wine_glass_1", "wine glass", "wine_glass", 0xdd_e6_ea, "glass", [0.07, 0.07, 0.08], [0.55, -0.02]),
    ("box_1", "cardboard box", "storage_box", 0xc0_94_60, "cardboard", [0.2; 3], [-0.65, -0.05]),
    ("car_1", "toy car", "model_car", 0x30_9f_40, "plastic", [0.12, 0.06, 0.05], [-0.65, -0.05]),
    ("cube_1", "cube", "cube", 0xc0_39_2b, "wood", [0.05; 3], [0.25, -0.45]),
    ("cube_2", "cube", "cube", 0x2f_63_b5, "wood", [0.05; 3], [0.40, -0.45]),
];

/// Objects on or in others, and the height of their bottom.
const SUPPORTS: [(usize, Supporter, f64); 4] = [
    (5, Supporter::containing(1), 0.004),
    (8, Supporter::on(7), 0.03),
    (9, Supporter::on(7), 0.03),
    (16, Supporter::containing(15), 0.004),
];

/// The scene on a table of 1.6 m by 1.1 m.
pub fn made_scene() -> TaskScene {
    let half = DVec2::new(0.8, 0.55);
    let table = corners(half).to_vec();
    let (mut posed, mut described) = (Vec::new(), Vec::new());
    for (index, (name, label, category, color, material, size_m, at_m)) in ROWS.into_iter().enumerate() {
        let size_m = DVec3::from(size_m);
        let support = SUPPORTS.iter().find(|(object, ..)| *object == index);
        let bottom_m = support.map_or(0.0, |(.., bottom_m)| *bottom_m);
        let is_open = matches!(category, "mug" | "storage_box");
        let hulls = if is_open { open_box(size_m) } else { vec![hull_of_box(size_m, DVec3::ZERO)] };
        let movable = !matches!(category, "laptop" | "desk_lamp" | "storage_box");
        let shape = ObjectShape::new(hulls, 0.5 * size_m * DVec3::Z, 0.2, movable).expect("convex hulls");
        let world_from_object = Pose::upright(DVec2::from(at_m).extend(bottom_m), 0.0);
        let object = PosedObject::new(InstanceId::new(name).expect(name), Arc::new(shape), world_from_object);
        described.push(EditableObject {
            name: object.name.clone(),
            label: label.to_owned(),
            category: category.to_owned(),
            stand_in: category.starts_with("stand_in_"),
            color: Some(Rgb::hex(color)),
            material: Some(material.to_owned()),
            size_m,
            footprint: object.footprint(),
            supporter: support.map_or(Supporter::TABLE, |(_, supporter, _)| *supporter),
        });
        posed.push(object);
    }
    TaskScene::new(Outline::new(table).expect("a rectangle"), posed, described).expect("as many of each")
}

fn corners(half: DVec2) -> [DVec2; 4] {
    [-half, DVec2::new(half.x, -half.y), half, DVec2::new(-half.x, half.y)]
}

fn hull_of_box(size_m: DVec3, bottom_m: DVec3) -> ConvexHull {
    let ring = corners(0.5 * size_m.truncate());
    let points: Vec<DVec3> =
        [0.0, size_m.z].iter().flat_map(|z| ring.map(|corner| bottom_m + corner.extend(*z))).collect();
    convex_hull(&points, 64, 0.0).expect("a box has a volume")
}

/// A floor and four walls of 4 mm.
fn open_box(size_m: DVec3) -> Vec<ConvexHull> {
    const WALL_M: f64 = 0.004;
    let half = 0.5 * (size_m - WALL_M);
    let (side, end) = (DVec3::new(WALL_M, size_m.y, size_m.z), DVec3::new(size_m.x, WALL_M, size_m.z));
    let mut hulls = vec![hull_of_box(DVec3::new(size_m.x, size_m.y, WALL_M), DVec3::ZERO)];
    hulls.extend([-half.x, half.x].map(|x| hull_of_box(side, DVec3::X * x)));
    hulls.extend([-half.y, half.y].map(|y| hull_of_box(end, DVec3::Y * y)));
    hulls
}
