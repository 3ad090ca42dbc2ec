//! Another color for a mesh: its main material is tinted, and the pattern of its texture stays.

use geometry::{Rgb, TexturedMesh};
use glam::DVec3;
use imaging::{Image, Texture};

/// Materials whose color is this near to the main one's are tinted with it, in each channel.
const ALIKE: f32 = 0.12;

/// The mesh with its main color replaced.
pub(super) fn recolored(mesh: &TexturedMesh, color: Rgb) -> TexturedMesh {
    let mut mesh = mesh.clone();
    let Some(main) = main_material(&mesh) else { return mesh };
    let main_color = mean_color(&mesh, main);
    let is_alike = |other: Rgb| main_color.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() <= ALIKE);
    let chosen: Vec<usize> = (0..mesh.materials.len())
        .filter(|&index| index == main || is_alike(mean_color(&mesh, index)))
        .collect();
    for index in chosen {
        let material = &mut mesh.materials[index];
        material.base_color = color;
        if let Some(texture) = &material.base_color_texture {
            material.base_color_texture = Some(shading(texture));
        }
    }
    mesh
}

/// The color that covers most of the surface.
pub(in crate::pipeline) fn main_color(mesh: &TexturedMesh) -> Option<Rgb> {
    main_material(mesh).map(|main| mean_color(mesh, main))
}

/// The material with the largest area.
fn main_material(mesh: &TexturedMesh) -> Option<usize> {
    let mut areas_m2 = vec![0.0; mesh.materials.len()];
    for group in &mesh.groups {
        let area_m2: f64 = group
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c]: [DVec3; 3] = triangle.map(|corner| mesh.positions[corner as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        if let Some(sum) = areas_m2.get_mut(group.material) {
            *sum += area_m2;
        }
    }
    (0..areas_m2.len()).max_by(|a, b| areas_m2[*a].total_cmp(&areas_m2[*b]))
}

fn mean_color(mesh: &TexturedMesh, material: usize) -> Rgb {
    let material = &mesh.materials[material];
    let Some(texture) = &material.base_color_texture else { return material.base_color };
    let mean = mean_of(texture);
    let mut color = material.base_color.0;
    color.iter_mut().zip(mean).for_each(|(channel, mean)| *channel *= mean);
    Rgb(color)
}

/// Mean of each channel, 0..1.
fn mean_of(image: &Image) -> [f32; 3] {
    let mut sums = [0.0_f64; 3];
    let pixels = image.as_rgba().chunks_exact(4);
    let count = pixels.len().max(1) as f64;
    for pixel in pixels {
        sums.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += f64::from(*channel));
    }
    sums.map(|sum| (sum / count / 255.0) as f32)
}

/// The lights and darks of a texture, around white.
fn shading(texture: &Texture) -> Texture {
    let luminance = |pixel: &[u8]| {
        0.2126 * f32::from(pixel[0]) + 0.7152 * f32::from(pixel[1]) + 0.0722 * f32::from(pixel[2])
    };
    let mut image: Image = (**texture).clone();
    let pixels = image.as_rgba().chunks_exact(4);
    let count = pixels.len().max(1) as f32;
    let mean = (pixels.map(luminance).sum::<f32>() / count).max(1.0);
    for pixel in image.as_rgba_mut().chunks_exact_mut(4) {
        let gray = (235.0 * luminance(pixel) / mean).clamp(0.0, 255.0) as u8;
        pixel[..3].fill(gray);
    }
    Texture::new(image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, shapes};

    fn mesh(material: &Material) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::block(DVec3::splat(0.1)), material);
        mesh
    }

    #[test]
    fn the_largest_material_takes_the_color_and_a_small_one_of_another_color_stays() {
        let mut mug = mesh(&Material::plain("glaze", Rgb::hex(0x20_20_c0), 0.4));
        mug.add(shapes::block(DVec3::splat(0.01)), &Material::plain("logo", Rgb::hex(0xff_ff_00), 0.4));
        let red = Rgb::hex(0xc0_39_2b);
        let changed = recolored(&mug, red);
        assert_eq!(main_color(&changed), Some(red));
        assert_eq!(changed.materials[1].base_color, Rgb::hex(0xff_ff_00));
        assert_eq!(changed.positions, mug.positions);
    }

    #[test]
    fn a_texture_keeps_its_pattern_and_takes_the_color() {
        let mut stripes = Image::filled(4, 4, [40, 60, 200, 255]);
        stripes.set_pixel(1, 1, [10, 15, 50, 255]);
        let green = Rgb::hex(0x3f_8f_4f);
        let changed = recolored(&mesh(&Material::textured("cloth", Texture::new(stripes), 0.8)), green);
        let texture = changed.materials[0].base_color_texture.as_ref().expect("a texture");
        assert!(texture.pixel(1, 1)[0] < texture.pixel(0, 0)[0] / 2);
        let color = main_color(&changed).expect("a material").0;
        assert!(color[1] > color[0] && color[1] > color[2], "{color:?}");
    }
}
