//! Materials of all objects in the form that shading uses, and their shared textures.

use glam::Vec3;

use crate::RenderObject;
use imaging::Texture;

/// A material in the form that shading uses.
pub struct ShadingMaterial {
    /// Linear light.
    pub base_color: Vec3,
    /// Into [`ShadingMaterials::textures`].
    pub texture: Option<usize>,
    pub roughness: f32,
    pub metalness: f32,
    pub opacity: f32,
    /// Height of white over black in the texture, as a share of the texture's repeat.
    pub relief: f32,
}

/// Shading materials of all objects, one object after another.
pub struct ShadingMaterials<'a> {
    materials: Vec<ShadingMaterial>,
    first_material: Vec<usize>,
    /// Every texture once.
    pub textures: Vec<&'a Texture>,
}

impl<'a> ShadingMaterials<'a> {
    pub fn new(objects: &[RenderObject<'a>]) -> Self {
        let mut textures: Vec<&'a Texture> = Vec::new();
        let (mut materials, mut first_material) = (Vec::new(), Vec::new());
        for object in objects {
            first_material.push(materials.len());
            for material in &object.mesh.materials {
                let texture = material.base_color_texture.as_ref().map(|texture| {
                    textures.iter().position(|k| k.is_clone_of(texture)).unwrap_or_else(|| {
                        textures.push(texture);
                        textures.len() - 1
                    })
                });
                materials.push(ShadingMaterial {
                    base_color: Vec3::from(material.base_color.to_linear()),
                    texture,
                    roughness: material.roughness.clamp(0.03, 1.0),
                    metalness: material.metalness.clamp(0.0, 1.0),
                    opacity: material.opacity.clamp(0.0, 1.0),
                    relief: if texture.is_some() { material.relief.clamp(0.0, 1.0) } else { 0.0 },
                });
            }
        }
        Self { materials, first_material, textures }
    }

    /// Index of an object's material among all materials.
    pub fn number(&self, object: usize, material: usize) -> usize {
        self.first_material[object] + material
    }

    /// The material with that index.
    pub fn material(&self, number: usize) -> &ShadingMaterial {
        &self.materials[number]
    }

    /// The materials of one object.
    pub fn of_object(&self, object: usize) -> &[ShadingMaterial] {
        let end = self.first_material.get(object + 1).copied().unwrap_or(self.materials.len());
        &self.materials[self.first_material[object]..end]
    }
}
