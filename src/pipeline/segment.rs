//! Stage `segment`: the pixels of each recognized object in the reference image.
//!
//! Masks that a model drew are regrown to the edges the image shows ([`mask_repair`]).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, artifact_io, reference};
use imaging::{Image, Mask};
use ports::{Adapter, Ports};
use render::annotate::{distinct_color, draw_mask_outline, draw_text, tint_mask};
use scene::{InstanceId, InstanceMask, MaskEdges, Recognition};
use vision::mask_repair;

pub const STAGE: Stage = Stage { name: "segment", version: 8 };

#[derive(Serialize)]
pub struct Inputs {
    image: ArtifactRef,
    known: Option<ArtifactRef>,
    /// Without depths, the key is that of the image alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<ArtifactRef>,
    recognition: Arc<Recognition>,
    segmenter: Adapter,
}

/// In the order of the recognized objects.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub masks: Vec<InstanceMask>,
    /// Pixels of the table; `None` where the segmenter did not search for it.
    pub table: Option<Mask>,
    /// Pixels of what stands on the table and is none of the objects; `None` where the segmenter did not search for it.
    pub unread: Option<Mask>,
    /// Pixels of the bare table top; `None` where the segmenter did not search for it.
    pub bare_top: Option<Mask>,
}

impl Inputs {
    pub fn new(reference: &reference::Output, recognition: &Arc<Recognition>, ports: &Ports) -> Self {
        Self {
            image: reference.image.clone(),
            known: reference.known.clone(),
            depth: reference.depth.clone(),
            recognition: recognition.clone(),
            segmenter: ports.segmenter.adapter(),
        }
    }
}

impl Output {
    /// Pixels that may show the bare top in an image of that size: those of no instance, where the segmenter did not
    /// search for the top.
    pub fn uncovered(&self, width_px: u32, height_px: u32) -> Mask {
        let everything = || Mask::from_fn(width_px, height_px, |_, _| true);
        let uncovered = self.bare_top.clone().unwrap_or_else(everything);
        let covering = self.masks.iter().map(|mask| &mask.visible).chain(&self.unread);
        covering.fold(uncovered, |uncovered, mask| uncovered.without(mask))
    }

    /// For each instance the pixels of all others: they may hide it.
    pub fn others(&self) -> Vec<Mask> {
        let Some(first) = self.masks.first() else { return Vec::new() };
        let none = Mask::empty(first.visible.width_px(), first.visible.height_px());
        // What is before an instance in the list, united with what is after it.
        let mut others = Vec::with_capacity(self.masks.len());
        let mut before = none.clone();
        for mask in &self.masks {
            others.push(before.clone());
            before.unite(&mask.visible);
        }
        let mut after = none;
        for (others, mask) in others.iter_mut().zip(&self.masks).rev() {
            others.unite(&after);
            after.unite(&mask.visible);
        }
        others
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let (known, depth) = (inputs.known.as_ref(), inputs.depth.as_ref());
    let seen = reference::seen(&context, &inputs.image, known, depth).await?;
    let found = ports.segmenter.segment(&call, seen.clone(), inputs.recognition.clone()).await?;
    check_masks(&found.masks, &inputs.recognition, &seen.image)?;
    let masks = match found.edges {
        MaskEdges::Sharp => found.masks,
        MaskEdges::Rough => {
            let image = seen.image.clone();
            context.cpu(move || with_edges_of(&image, found.masks)).await?
        }
    };
    let table = ports.segmenter.table(&call, seen.clone()).await?;
    let output = Output { masks, table, unread: found.unread, bare_top: found.bare_top };
    check_sizes(&output, &seen.image)?;
    context.put_json("masks.json", &output.masks).await?;
    let shown = output.clone();
    let drawn = context.cpu(move || drawn_on(&seen.image, &shown.masks)).await?;
    artifact_io::put_image(&context, "masks.png", drawn).await?;
    Ok(output)
}

fn with_edges_of(image: &Image, masks: Vec<InstanceMask>) -> Vec<InstanceMask> {
    let (ids, visible): (Vec<InstanceId>, Vec<Mask>) =
        masks.into_iter().map(|mask| (mask.id, mask.visible)).unzip();
    let repaired = mask_repair::repair(image, &visible);
    ids.into_iter().zip(repaired).map(|(id, visible)| InstanceMask { id, visible }).collect()
}

fn check_masks(masks: &[InstanceMask], recognition: &Recognition, image: &Image) -> Result<(), StageError> {
    let size = (image.width_px(), image.height_px());
    let named = recognition.objects.iter().map(|object| &object.id).eq(masks.iter().map(|m| &m.id));
    if !named || masks.iter().any(|m| (m.visible.width_px(), m.visible.height_px()) != size) {
        return Err(StageError::permanent(
            "masks_inconsistent",
            "segmenting the image: the masks are not those of the recognized objects",
        ));
    }
    match masks.iter().find(|mask| mask.visible.area_px() == 0) {
        Some(hidden) => Err(StageError::permanent(
            "object_not_visible",
            format!("segmenting the image: {} shows nowhere; use another seed or image", hidden.id),
        )),
        None => Ok(()),
    }
}

fn check_sizes(output: &Output, image: &Image) -> Result<(), StageError> {
    let size = (image.width_px(), image.height_px());
    let of_whole = [
        ("the table's mask", &output.table),
        ("the mask of what was not read", &output.unread),
        ("the mask of the bare top", &output.bare_top),
    ];
    let fits = |mask: &Mask| (mask.width_px(), mask.height_px()) == size;
    match of_whole.into_iter().find(|(_, mask)| !mask.as_ref().is_none_or(fits)) {
        Some((what, _)) => Err(StageError::permanent(
            "masks_inconsistent",
            format!("segmenting the image: {what} belongs to an image of another size"),
        )),
        None => Ok(()),
    }
}

/// The image with each object's pixels in a color of their own.
pub(super) fn drawn_on(image: &Image, masks: &[InstanceMask]) -> Image {
    let mut drawn = image.clone();
    for (index, mask) in masks.iter().enumerate() {
        tint_mask(&mut drawn, &mask.visible, distinct_color(index), 0.35);
        draw_mask_outline(&mut drawn, &mask.visible, distinct_color(index), 1);
    }
    for mask in masks {
        if let Some([x0, y0, ..]) = mask.visible.bbox_px() {
            let (x, y) = (i64::from(x0), i64::from(y0) - 10);
            draw_text(&mut drawn, x, y, mask.id.as_str(), 1, [20, 20, 24, 255]);
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_all_pixels_of_all_other_instances() {
        let mask = |name: &str, from: u32, to: u32| InstanceMask {
            id: InstanceId::new(name).expect("a name"),
            visible: Mask::from_fn(9, 2, |x, _| (from..to).contains(&x)),
        };
        // The second lies over the first and the third.
        let output = Output {
            masks: vec![mask("a", 0, 3), mask("b", 2, 6), mask("c", 5, 7)],
            table: None,
            unread: None,
            bare_top: None,
        };
        let columns = |mask: &Mask| (0..9).filter(|&x| mask.contains(x, 1)).collect::<Vec<u32>>();
        let others: Vec<Vec<u32>> = output.others().iter().map(columns).collect();
        assert_eq!(others, [vec![2, 3, 4, 5, 6], vec![0, 1, 2, 5, 6], vec![0, 1, 2, 3, 4, 5]]);
        assert!(Output { masks: Vec::new(), table: None, unread: None, bare_top: None }.others().is_empty());
    }
}
