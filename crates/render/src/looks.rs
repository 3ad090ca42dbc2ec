//! Materials of all objects as shading wants them, and the textures they share.

use glam::Vec3;

use super::RenderObject;
use imaging::Texture;

/// A material as shading wants it.
pub struct Look {
    /// Linear light.
    pub base_color: Vec3,
    /// Into [`Looks::textures`].
    pub texture: Option<usize>,
    pub roughness: f32,
    pub metalness: f32,
    pub opacity: f32,
}

/// Looks of the objects' materials, one object after another.
pub struct Looks<'a> {
    looks: Vec<Look>,
    first_look: Vec<usize>,
    /// Every texture once.
    pub textures: Vec<&'a Texture>,
}

impl<'a> Looks<'a> {
    pub fn new(objects: &[RenderObject<'a>]) -> Self {
        let mut textures: Vec<&'a Texture> = Vec::new();
        let (mut looks, mut first_look) = (Vec::new(), Vec::new());
        for object in objects {
            first_look.push(looks.len());
            for material in &object.mesh.materials {
                let texture = material.base_color_texture.as_ref().map(|texture| {
                    textures.iter().position(|k| k.is_clone_of(texture)).unwrap_or_else(|| {
                        textures.push(texture);
                        textures.len() - 1
                    })
                });
                looks.push(Look {
                    base_color: Vec3::from(material.base_color.to_linear()),
                    texture,
                    roughness: material.roughness.clamp(0.03, 1.0),
                    metalness: material.metalness.clamp(0.0, 1.0),
                    opacity: material.opacity.clamp(0.0, 1.0),
                });
            }
        }
        Self { looks, first_look, textures }
    }

    /// Number of an object's material among all looks.
    pub fn number(&self, object: usize, material: usize) -> usize {
        self.first_look[object] + material
    }

    /// The look of that number.
    pub fn look(&self, number: usize) -> &Look {
        &self.looks[number]
    }

    /// Those of one object.
    pub fn of_object(&self, object: usize) -> &[Look] {
        let end = self.first_look.get(object + 1).copied().unwrap_or(self.looks.len());
        &self.looks[self.first_look[object]..end]
    }
}
