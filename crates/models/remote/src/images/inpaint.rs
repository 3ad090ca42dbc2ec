//! Inpainting of one object: a complete, isolated image of a partly hidden object.
//!
//! The model receives a square around the object twice: the crop, and the object's visible pixels only. A model without
//! transparent output is given a key color as its background ([`chroma_key`]). The result is registered with the
//! reference image ([`mask_registration`]). It must cover the visible pixels and no pixels of visible other objects.
//!
//! [`chroma_key`]: vision::chroma_key
//! [`mask_registration`]: vision::mask_registration

use ::image::ImageError;
use bytes::Bytes;
use glam::DVec2;

use super::super::image;
use super::prompts::prompts;
use super::{DrawingRefused, not_taken};
use imaging::{Image, Mask};
use ports::{Call, Completion, CompletionRequest, Port, ProviderError};
use vision::chroma_key::{KeyColor, composite_over, pick_key_color, remove_background};
use vision::mask_registration::{Placement, register};

/// Side of the square, as a multiple of the longer side of the visible box.
const SURROUNDINGS: f64 = 1.8;

/// Minimum side of the square, and maximum side of the sent images, pixels.
const SENT_PX: [u32; 2] = [64, 1024];

/// Minimum transparent share of a result; less means that it has a background.
const MIN_TRANSPARENT: f64 = 0.05;

/// Alpha from which a pixel belongs to the object.
const SOLID: u8 = 128;

/// Settings of inpainting with a model.
pub(crate) struct InpaintSettings {
    /// The name of the adapter.
    pub adapter: &'static str,
    /// Whether the model draws on a key color, which is removed, instead of a transparent background.
    pub on_backdrop: bool,
    /// Minimum agreement with the visible mask, intersection over union.
    pub min_agreement: f64,
    /// Maximum repeated requests.
    pub redraws: u32,
}

/// Inpaints an object. `draw` requests one image for a prompt and two images; its inner error is why it is unusable.
pub(crate) async fn inpaint<F>(
    how: &InpaintSettings,
    call: &Call,
    request: CompletionRequest,
    draw: impl Fn(String, [Bytes; 2]) -> F,
) -> Result<Completion, ProviderError>
where
    F: Future<Output = Result<Result<Image, DrawingRefused>, ProviderError>>,
{
    let CompletionRequest { reference, object, visible, others, .. } = request;
    let (shown, shown_others) = (visible.clone(), others.clone());
    let on_backdrop = how.on_backdrop;
    let (square, backdrop, sent) = call
        .compute(Port::ImageGenerator, move |_| {
            let square = Square::around(&shown, &shown_others)
                .filter(|_| (shown.width_px(), shown.height_px()) == size_of(&reference.image))
                .ok_or_else(|| {
                    rejected("nothing_visible", "no pixel of it shows in the image; leave it out")
                })?;
            let backdrop = on_backdrop.then(|| pick_key_color(&reference.image, &shown));
            let sent = square.images(&reference.image, &shown, backdrop);
            Ok((
                square,
                backdrop,
                sent.map_err(|_| rejected("image_unreadable", "its pixels cannot be sent"))?,
            ))
        })
        .await?;
    let mut reason = String::new();
    for _ in 0..=how.redraws {
        let drawn = draw(prompt_of(&object.label, backdrop, &reason), sent.clone()).await?;
        let (visible, others, lowest) = (visible.clone(), others.clone(), how.min_agreement);
        let taken = match drawn {
            Ok(drawing) => {
                call.compute(Port::ImageGenerator, move |_| {
                    let drawing = match backdrop {
                        Some(_) => remove_background(&drawing).ok_or(DrawingRefused::BackgroundNotPlain),
                        None => Ok(drawing),
                    };
                    Ok(drawing.and_then(|drawing| completion(drawing, square, &visible, &others, lowest)))
                })
                .await?
            }
            Err(refused) => Err(refused),
        };
        match taken {
            Ok(completion) => return Ok(completion),
            Err(why) => {
                tracing::debug!(object = %object.id, %why, "a drawing was not taken");
                reason = why.to_string();
            }
        }
    }
    Err(not_taken(how.adapter, format!("{}: {reason}", object.id), how.redraws + 1))
}

fn size_of(image: &Image) -> (u32, u32) {
    (image.width_px(), image.height_px())
}

fn rejected(code: &'static str, reason: &str) -> ProviderError {
    ProviderError::Rejected { port: Port::ImageGenerator, code, reason: reason.to_owned() }
}

/// The prompt; a repeated request states why the earlier result was rejected.
fn prompt_of(label: &str, backdrop: Option<KeyColor>, reason: &str) -> String {
    let text = match backdrop {
        None => format!("{}\n\nThe thing: {label}.", prompts().redraw.text),
        Some(KeyColor { name, rgb: [r, g, b] }) => format!(
            "{}\n\nThe background: {name}, #{r:02x}{g:02x}{b:02x}.\n\nThe thing: {label}.",
            prompts().redraw_on_backdrop.text
        ),
    };
    match reason {
        "" => text,
        why => format!("{text}\n\nAn earlier drawing could not be used: {why}."),
    }
}

/// A square crop of the image, which may extend beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Square {
    x0: i64,
    y0: i64,
    side_px: u32,
}

impl Square {
    /// Around the visible pixels; `None` where there are none, or where the masks are of different sizes.
    fn around(visible: &Mask, others: &Mask) -> Option<Self> {
        let same = (visible.width_px(), visible.height_px()) == (others.width_px(), others.height_px());
        let [x0, y0, x1, y1] = visible.bbox_px().filter(|_| same)?;
        let longer = f64::from((x1 - x0).max(y1 - y0));
        let side_px = ((SURROUNDINGS * longer).ceil() as u32).max(SENT_PX[0]);
        let corner = |low: u32, high: u32| (i64::from(low) + i64::from(high) - i64::from(side_px)) / 2;
        Some(Self { x0: corner(x0, x1), y0: corner(y0, y1), side_px })
    }

    /// The two images for the model: the crop, white beyond the image, and the visible pixels only, over the key color
    /// where there is one.
    fn images(
        self,
        image: &Image,
        visible: &Mask,
        backdrop: Option<KeyColor>,
    ) -> Result<[Bytes; 2], ImageError> {
        let mut around = Image::filled(self.side_px, self.side_px, [255; 4]);
        let mut alone = Image::filled(self.side_px, self.side_px, [0; 4]);
        for v in 0..self.side_px {
            for u in 0..self.side_px {
                let place = (self.x0 + i64::from(u), self.y0 + i64::from(v));
                let (Ok(x), Ok(y)) = (u32::try_from(place.0), u32::try_from(place.1)) else { continue };
                if x >= image.width_px() || y >= image.height_px() {
                    continue;
                }
                let [r, g, b, _] = image.pixel(x, y);
                around.set_pixel(u, v, [r, g, b, 255]);
                if visible.contains(x, y) {
                    alone.set_pixel(u, v, [r, g, b, 255]);
                }
            }
        }
        let alone = match backdrop {
            Some(backdrop) => image::sent(&composite_over(&alone, backdrop.rgb), SENT_PX[1])?,
            None => image::sent_cut_out(&alone, SENT_PX[1])?,
        };
        Ok([image::sent(&around, SENT_PX[1])?, alone])
    }

    /// The placement of a result of `width_px` that keeps the frame of the square.
    fn framed(self, width_px: u32) -> Placement {
        let scale = f64::from(self.side_px) / f64::from(width_px.max(1));
        Placement { scale, offset_px: DVec2::new(self.x0 as f64, self.y0 as f64) }
    }
}

/// The completion of a result, or the reason why it is rejected.
fn completion(
    drawing: Image,
    square: Square,
    visible: &Mask,
    others: &Mask,
    min_agreement: f64,
) -> Result<Completion, DrawingRefused> {
    let (width_px, height_px) = size_of(&drawing);
    let solid = |x, y| drawing.pixel(x, y)[3] >= SOLID;
    let drawn = Mask::from_fn(width_px, height_px, solid);
    let whole = f64::from(width_px) * f64::from(height_px);
    if whole - (drawn.area_px() as f64) < MIN_TRANSPARENT * whole {
        return Err(DrawingRefused::BackgroundNotTransparent);
    }
    let found = register(&drawn, visible, others, square.framed(width_px));
    let (place, agreement) = found.ok_or(DrawingRefused::Empty)?;
    if agreement < min_agreement {
        return Err(DrawingRefused::AnotherObject { agreement });
    }
    // Visible pixels are certain; hidden ones follow the result.
    let silhouette = Mask::from_fn(visible.width_px(), visible.height_px(), |x, y| {
        let at = place.redrawn_from_image(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        visible.contains(x, y)
            || (at.min_element() >= 0.0 && drawn.contains(at.x as u32, at.y as u32) && others.contains(x, y))
    });
    let area = silhouette.area_px();
    let completed_share = (area - visible.area_px()) as f64 / area.max(1) as f64;
    let [x0, y0, x1, y1] = drawn.bbox_px().ok_or(DrawingRefused::Empty)?;
    let margin = ((x1 - x0).max(y1 - y0) as f64 * 0.05).ceil() as u32;
    let (x0, y0) = (x0.saturating_sub(margin), y0.saturating_sub(margin));
    let (x1, y1) = ((x1 + margin).min(width_px), (y1 + margin).min(height_px));
    let mut cut = Image::filled(x1 - x0, y1 - y0, [0; 4]);
    for y in y0..y1 {
        for x in x0..x1 {
            cut.set_pixel(x - x0, y - y0, drawing.pixel(x, y));
        }
    }
    let low = place.offset_px + place.scale * DVec2::new(f64::from(x0), f64::from(y0));
    let high = place.offset_px + place.scale * DVec2::new(f64::from(x1), f64::from(y1));
    let crop_px = [low.x, low.y, high.x, high.y];
    Ok(Completion { image: cut, crop_px, silhouette, completed_share, completed_by: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk of 30 pixels' radius at 100, 60, half of it behind a box.
    fn scene() -> (Mask, Mask) {
        let disk = |x: u32, y: u32| (f64::from(x) - 100.0).hypot(f64::from(y) - 60.0) < 30.0;
        let others = Mask::from_fn(200, 120, |x, y| (90..160).contains(&x) && (60..110).contains(&y));
        (Mask::from_fn(200, 120, |x, y| disk(x, y) && !others.contains(x, y)), others)
    }

    fn drawing(inside: impl Fn(f64, f64) -> bool) -> Image {
        let mut image = Image::filled(256, 256, [0; 4]);
        for y in 0..256 {
            for x in 0..256 {
                if inside(f64::from(x) - 128.0, f64::from(y) - 120.0) {
                    image.set_pixel(x, y, [200, 20, 20, 255]);
                }
            }
        }
        image
    }

    #[test]
    fn completion_restores_a_half_hidden_disk() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let drawn = drawing(|x, y| x.hypot(y) < 90.0);
        let completion = completion(drawn, square, &visible, &others, 0.8).expect("is the disk");
        let area = std::f64::consts::PI * 900.0;
        assert!((completion.silhouette.area_px() as f64 / area - 1.0).abs() < 0.08);
        assert!((0.2..0.45).contains(&completion.completed_share), "{}", completion.completed_share);
        let [x0, y0, x1, y1] = completion.crop_px;
        assert!((0.5 * (x0 + x1) - 100.0).abs() < 2.5 && (0.5 * (y0 + y1) - 60.0).abs() < 2.5);
        assert_eq!(completion.image.pixel(0, 0)[3], 0);
    }

    #[test]
    fn completion_rejects_other_objects_and_backgrounds() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let tried = |inside: fn(f64, f64) -> bool| {
            completion(drawing(inside), square, &visible, &others, 0.7).expect_err("is not the disk")
        };
        assert!(matches!(tried(|x, _| x.abs() < 6.0), DrawingRefused::AnotherObject { .. }));
        assert!(matches!(tried(|_, _| true), DrawingRefused::BackgroundNotTransparent));
        assert!(matches!(tried(|_, _| false), DrawingRefused::Empty));
    }

    #[test]
    fn square_images_show_the_crop_and_the_isolated_object() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let [around, alone] =
            square.images(&Image::filled(200, 120, [9, 8, 7, 255]), &visible, None).expect("encodes");
        let (around, alone) =
            (image::received(&around).expect("intact"), image::received(&alone).expect("intact"));
        assert_eq!((around.width_px(), alone.width_px()), (square.side_px, square.side_px));
        let at = |x: i64, y: i64| ((x - square.x0) as u32, (y - square.y0) as u32);
        let ((shown_x, shown_y), (hidden_x, hidden_y)) = (at(85, 50), at(110, 70));
        assert_eq!(around.pixel(hidden_x, hidden_y), [9, 8, 7, 255]);
        assert_eq!(alone.pixel(shown_x, shown_y), [9, 8, 7, 255]);
        assert_eq!(alone.pixel(hidden_x, hidden_y), [0; 4]);
        let backdrop = pick_key_color(&Image::filled(200, 120, [9, 8, 7, 255]), &visible);
        let before = square.images(&Image::filled(200, 120, [9, 8, 7, 255]), &visible, Some(backdrop));
        let before = image::received(&before.expect("encodes")[1]).expect("intact");
        assert_eq!(before.pixel(shown_x, shown_y), [9, 8, 7, 255]);
        assert_eq!(
            before.pixel(hidden_x, hidden_y),
            [backdrop.rgb[0], backdrop.rgb[1], backdrop.rgb[2], 255]
        );
        // The disk reaches to y = 31; nothing lies above the image.
        let tall = Mask::from_fn(20, 120, |x, _| x < 10);
        let square = Square::around(&tall, &Mask::empty(20, 120)).expect("shows");
        let [around, _] =
            square.images(&Image::filled(20, 120, [0, 0, 0, 255]), &tall, None).expect("encodes");
        assert_eq!(image::received(&around).expect("intact").pixel(0, 0), [255; 4]);
        assert_eq!(Square::around(&tall, &Mask::empty(9, 9)), None);
    }
}
