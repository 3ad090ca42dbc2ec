//! Marks of use: more with more wear, none on food, and nothing else than the texture changes.

use super::*;
use crate::{Recipe, build, build_table};
use geometry::shapes::block;

/// Mean difference of two images of one size, bytes.
fn difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.as_rgba().iter().zip(b.as_rgba());
    pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.as_rgba().len() as f64
}

fn texture_of<'a>(mesh: &'a TexturedMesh, is_wanted: &dyn Fn(&Material) -> bool) -> &'a Texture {
    let material = mesh.materials.iter().find(|known| is_wanted(known)).expect("a material");
    material.base_color_texture.as_ref().expect("a texture")
}

#[test]
fn tops_show_more_the_more_they_are_worn_and_keep_color_and_shape() {
    for material in ["oak", "marble", "white", "granite", "tile"] {
        let size_m = DVec3::new(1.4, 0.8, 0.74);
        let new = build_table("dining_table", size_m, None, Some(material), 5).expect("a table").mesh;
        let top = |known: &Material| TOPS.contains(&known.name.as_str());
        let worn = [0.25, 0.5, 1.0].map(|wear| worn_table(new.clone(), wear, 3));
        let marks = worn.each_ref().map(|mesh| {
            assert_eq!((&mesh.positions, &mesh.uvs, &mesh.groups), (&new.positions, &new.uvs, &new.groups));
            let before = new.materials.iter().find(|known| top(known)).expect("a top");
            let before = match &before.base_color_texture {
                Some(texture) => Image::clone(texture),
                None => {
                    let after = texture_of(mesh, &top);
                    Image::filled(after.width_px(), after.height_px(), before.base_color.to_rgba8())
                }
            };
            difference(&before, texture_of(mesh, &top))
        });
        assert!(marks[0] > 0.01 && marks[0] < marks[1] && marks[1] < marks[2], "{material}: {marks:?}");
        assert!(marks[2] < 6.0, "{material} keeps its color: {marks:?}");
    }
}

#[test]
fn as_new_is_as_built() {
    let table = build_table("desk", DVec3::new(1.2, 0.6, 0.74), None, Some("oak"), 5).expect("a desk").mesh;
    assert_eq!(worn_table(table.clone(), 0.0, 3), table);
    let carton = build(&Recipe::typical("cereal_box", None, None).expect("a category")).expect("a mesh");
    assert_eq!(worn_object(carton.clone(), "cereal_box", None, 0.0, 3), carton);
}

#[test]
fn a_carton_is_worn_and_an_apple_is_not() {
    let built = |name: &str| build(&Recipe::typical(name, None, None).expect("a category")).expect("a mesh");
    let carton = built("cereal_box");
    assert_ne!(worn_object(carton.clone(), "cereal_box", None, 0.6, 3), carton);
    assert_eq!(
        worn_object(carton.clone(), "cereal_box", None, 0.6, 3),
        worn_object(carton, "cereal_box", None, 0.6, 3)
    );
    let apple = built("apple");
    assert_eq!(worn_object(apple.clone(), "apple", None, 1.0, 3), apple);
}

#[test]
fn the_scale_of_a_texture_is_that_of_the_surface() {
    let mut mesh = TexturedMesh::default();
    mesh.add(
        block(DVec3::new(0.3, 0.2, 0.1)).with_box_uvs(0.12),
        &Material::plain("print", Rgb::hex(0), 0.5),
    );
    let scale = Scale::of(&mesh, 0).expect("an extent");
    assert!((scale.meters_per_repeat - 0.12).abs().max_element() < 1e-6, "{}", scale.meters_per_repeat);
    assert!(scale.repeats.x > 2.0);
}

#[test]
fn a_mark_at_the_edge_goes_on_at_the_other() {
    let mut canvas = Canvas::new(Image::filled(64, 64, [200, 200, 200, 255]), DVec2::splat(0.1).as_vec2());
    let rng = &mut child_rng(1, "ring");
    (0..6).for_each(|_| canvas.ring(0.4, rng));
    let changed = |x: u32, y: u32| canvas.image.pixel(x, y) != [200, 200, 200, 255];
    assert!((0..64).any(|y| changed(0, y) && changed(63, y)));
}
