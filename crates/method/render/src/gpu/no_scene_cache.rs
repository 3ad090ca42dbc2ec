//! In place of a scene on a GPU in a program that was built without the feature `wgpu`: there is no device for it.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;

use crate::{Background, Frame, GeometryFrame, Lighting, SceneCache, View};
use gpu::{Gpu, GpuError};
use imaging::Image;

/// Placed objects on a device that cannot exist.
pub struct GpuSceneCache<'a> {
    never: Infallible,
    scene_cache: PhantomData<SceneCache<'a>>,
}

impl<'a> GpuSceneCache<'a> {
    /// # Errors
    ///
    /// [`GpuError::NotBuilt`] in any case.
    pub fn new(_: Arc<Gpu>, _: Arc<SceneCache<'a>>) -> Result<Self, GpuError> {
        Err(GpuError::NotBuilt)
    }

    /// The device that renders.
    pub fn gpu(&self) -> &Arc<Gpu> {
        match self.never {}
    }

    /// As [`SceneCache::color`].
    pub fn color(&self, _: Lighting, _: Background, _: &View) -> Result<Image, GpuError> {
        match self.never {}
    }

    /// As [`SceneCache::render`].
    pub fn render(&self, _: Lighting, _: Background, _: &View) -> Result<Frame, GpuError> {
        match self.never {}
    }

    /// As [`SceneCache::render_with_normals`].
    pub fn render_with_normals(&self, _: Lighting, _: Background, _: &View) -> Result<Frame, GpuError> {
        match self.never {}
    }

    /// As [`SceneCache::measure`].
    pub fn measure(&self, _: &View) -> Result<GeometryFrame, GpuError> {
        match self.never {}
    }
}
