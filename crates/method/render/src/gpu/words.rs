//! Serialization to four-byte words, in the layout that kernels read.

use glam::{Affine3A, Vec3};

/// Content of a buffer.
#[derive(Default)]
pub struct Words(Vec<u8>);

impl Words {
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Number of words so far: where the next one will be.
    pub fn count(&self) -> u32 {
        (self.0.len() / 4) as u32
    }

    pub fn push(&mut self, words: impl IntoIterator<Item = u32>) {
        self.0.extend(words.into_iter().flat_map(u32::to_ne_bytes));
    }

    pub fn push_floats(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.push(numbers.into_iter().map(f32::to_bits));
    }

    /// Depth keys; the empty key is the lowest finite number, since not every driver supports infinities.
    pub fn push_keys(&mut self, keys: &[f32]) {
        self.push_floats(keys.iter().map(|key| key.max(f32::MIN)));
    }

    /// A vector with what fills its fourth word.
    pub fn push_vector(&mut self, v: Vec3, fourth: f32) {
        self.push_floats([v.x, v.y, v.z, fourth]);
    }

    /// Three rows, each with its shift last.
    pub fn push_rows(&mut self, map: Affine3A) {
        for (row, shift) in (0..3).zip(map.translation.to_array()) {
            self.push_vector(map.matrix3.row(row).into(), shift);
        }
    }

    /// Four bytes a texel.
    pub fn push_texels(&mut self, rgba: &[u8]) {
        self.0.extend_from_slice(rgba);
    }

    /// Zeros up to a whole number of quadruples, which uniforms are made of.
    pub fn fill_quadruple(&mut self) {
        self.0.resize(self.0.len().next_multiple_of(16), 0);
    }
}
