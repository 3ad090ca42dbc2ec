//! One thing of a picture, redrawn alone and whole.
//!
//! The model sees a square around the thing twice: as it is, and with nothing but the thing's visible pixels. One that draws on
//! no transparent background is given a color to draw before ([`cut_out`]). What it draws is laid on the picture
//! ([`placement`]): it has to cover what is visible and nothing that is visibly something else.
//!
//! [`placement`]: vision::placement

use bytes::Bytes;
use glam::DVec2;
use image::ImageError;

use super::super::picture;
use super::not_taken;
use super::prompts::prompts;
use imaging::{Image, Mask};
use ports::{Call, Completion, CompletionRequest, Port, ProviderError};
use vision::cut_out::{Backdrop, cut_out, far_from, laid_on};
use vision::placement::{Placement, placed};

/// Side of the square, as a multiple of the longer side of what is visible.
const SURROUNDINGS: f64 = 1.8;

/// Sides of squares that are sent, pixels.
const SENT_PX: [u32; 2] = [64, 1024];

/// Share of a drawing that has to be transparent: less is a drawing with a background.
const LEAST_TRANSPARENT: f64 = 0.05;

/// Alpha from which a pixel belongs to the thing.
const SOLID: u8 = 128;

/// How a painter redraws.
pub(crate) struct Redrawing {
    /// Name of its adapter.
    pub adapter: &'static str,
    /// It draws on one plain color, which is cut away, and not on a transparent background.
    pub on_backdrop: bool,
    /// Least agreement with what is visible, intersection over union.
    pub least_agreement: f64,
    /// Drawings asked for again.
    pub redraws: u32,
}

/// Has it redrawn: `draw` asks for one drawing after a prompt and two pictures, and says why one cannot be used.
pub(crate) async fn redraw<Drawn>(
    how: &Redrawing,
    call: &Call,
    request: CompletionRequest,
    draw: impl Fn(String, [Bytes; 2]) -> Drawn,
) -> Result<Completion, ProviderError>
where
    Drawn: Future<Output = Result<Result<Image, String>, ProviderError>>,
{
    let CompletionRequest { reference, object, visible, others, .. } = request;
    let (shown, shown_others) = (visible.clone(), others.clone());
    let on_backdrop = how.on_backdrop;
    let (square, backdrop, sent) = call
        .compute(Port::Painter, move |_| {
            let square = Square::around(&shown, &shown_others)
                .filter(|_| (shown.width_px(), shown.height_px()) == size_of(&reference.picture))
                .ok_or_else(|| {
                    rejected("nothing_visible", "no pixel of it shows in the picture; leave it out")
                })?;
            let backdrop = on_backdrop.then(|| far_from(&reference.picture, &shown));
            let sent = square.pictures(&reference.picture, &shown, backdrop);
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
        let (visible, others, least) = (visible.clone(), others.clone(), how.least_agreement);
        let taken = match drawn {
            Ok(drawing) => {
                call.compute(Port::Painter, move |_| {
                    let drawing = match backdrop {
                        Some(_) => cut_out(&drawing).ok_or("its background is not one plain color"),
                        None => Ok(drawing),
                    };
                    Ok(drawing
                        .map_err(str::to_owned)
                        .and_then(|drawing| completion(drawing, square, &visible, &others, least)))
                })
                .await?
            }
            Err(refused) => Err(refused),
        };
        match taken {
            Ok(completion) => return Ok(completion),
            Err(why) => {
                tracing::debug!(object = %object.id, why, "a drawing was not taken");
                reason = why;
            }
        }
    }
    Err(not_taken(how.adapter, &format!("{}: {reason}", object.id), how.redraws + 1))
}

fn size_of(picture: &Image) -> (u32, u32) {
    (picture.width_px(), picture.height_px())
}

fn rejected(code: &'static str, reason: &str) -> ProviderError {
    ProviderError::Rejected { port: Port::Painter, code, reason: reason.to_owned() }
}

/// A second drawing is told what was wrong with the first.
fn prompt_of(label: &str, backdrop: Option<Backdrop>, reason: &str) -> String {
    let text = match backdrop {
        None => format!("{}\n\nThe thing: {label}.", prompts().redraw.text),
        Some(Backdrop { name, rgb: [r, g, b] }) => format!(
            "{}\n\nThe background: {name}, #{r:02x}{g:02x}{b:02x}.\n\nThe thing: {label}.",
            prompts().redraw_on_backdrop.text
        ),
    };
    match reason {
        "" => text,
        why => format!("{text}\n\nAn earlier drawing could not be used: {why}."),
    }
}

/// Part of the picture; it may reach beyond it.
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

    /// What the model sees: the square with white beyond the picture, and the visible pixels alone, before the backdrop if
    /// there is one.
    fn pictures(
        self,
        picture: &Image,
        visible: &Mask,
        backdrop: Option<Backdrop>,
    ) -> Result<[Bytes; 2], ImageError> {
        let mut around = Image::filled(self.side_px, self.side_px, [255; 4]);
        let mut alone = Image::filled(self.side_px, self.side_px, [0; 4]);
        for v in 0..self.side_px {
            for u in 0..self.side_px {
                let place = (self.x0 + i64::from(u), self.y0 + i64::from(v));
                let (Ok(x), Ok(y)) = (u32::try_from(place.0), u32::try_from(place.1)) else { continue };
                if x >= picture.width_px() || y >= picture.height_px() {
                    continue;
                }
                let [r, g, b, _] = picture.pixel(x, y);
                around.set_pixel(u, v, [r, g, b, 255]);
                if visible.contains(x, y) {
                    alone.set_pixel(u, v, [r, g, b, 255]);
                }
            }
        }
        let alone = match backdrop {
            Some(backdrop) => picture::sent(&laid_on(&alone, backdrop.rgb), SENT_PX[1])?,
            None => picture::sent_cut_out(&alone, SENT_PX[1])?,
        };
        Ok([picture::sent(&around, SENT_PX[1])?, alone])
    }

    /// Where a drawing of `width_px` lies that kept the frame.
    fn framed(self, width_px: u32) -> Placement {
        let scale = f64::from(self.side_px) / f64::from(width_px.max(1));
        Placement { scale, offset_px: DVec2::new(self.x0 as f64, self.y0 as f64) }
    }
}

/// The drawing as a completion, or why it is none.
fn completion(
    drawing: Image,
    square: Square,
    visible: &Mask,
    others: &Mask,
    least_agreement: f64,
) -> Result<Completion, String> {
    let (width_px, height_px) = size_of(&drawing);
    let solid = |x, y| drawing.pixel(x, y)[3] >= SOLID;
    let drawn = Mask::from_fn(width_px, height_px, solid);
    let whole = f64::from(width_px) * f64::from(height_px);
    if whole - (drawn.area_px() as f64) < LEAST_TRANSPARENT * whole {
        return Err("its background is not transparent".into());
    }
    let found = placed(&drawn, visible, others, square.framed(width_px));
    let (place, agreement) = found.ok_or("nothing is drawn")?;
    if agreement < least_agreement {
        return Err(format!(
            "it shows another thing, or another side: its outline agrees to {:.0} % with what is visible",
            100.0 * agreement
        ));
    }
    // What can be seen is certain; the rest is as drawn.
    let silhouette = Mask::from_fn(visible.width_px(), visible.height_px(), |x, y| {
        let at = place.redrawn_from_picture(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        visible.contains(x, y)
            || (at.min_element() >= 0.0 && drawn.contains(at.x as u32, at.y as u32) && others.contains(x, y))
    });
    let area = silhouette.area_px();
    let completed_share = (area - visible.area_px()) as f64 / area.max(1) as f64;
    let [x0, y0, x1, y1] = drawn.bbox_px().ok_or("nothing is drawn")?;
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
    let shown_px = [low.x, low.y, high.x, high.y];
    Ok(Completion { picture: cut, shown_px, silhouette, completed_share, completed_by: Vec::new() })
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
        let mut picture = Image::filled(256, 256, [0; 4]);
        for y in 0..256 {
            for x in 0..256 {
                if inside(f64::from(x) - 128.0, f64::from(y) - 120.0) {
                    picture.set_pixel(x, y, [200, 20, 20, 255]);
                }
            }
        }
        picture
    }

    #[test]
    fn a_half_hidden_disk_becomes_whole() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let drawn = drawing(|x, y| x.hypot(y) < 90.0);
        let completion = completion(drawn, square, &visible, &others, 0.8).expect("is the disk");
        let area = std::f64::consts::PI * 900.0;
        assert!((completion.silhouette.area_px() as f64 / area - 1.0).abs() < 0.08);
        assert!((0.2..0.45).contains(&completion.completed_share), "{}", completion.completed_share);
        let [x0, y0, x1, y1] = completion.shown_px;
        assert!((0.5 * (x0 + x1) - 100.0).abs() < 2.5 && (0.5 * (y0 + y1) - 60.0).abs() < 2.5);
        assert_eq!(completion.picture.pixel(0, 0)[3], 0);
    }

    #[test]
    fn other_things_and_backgrounds_are_not_taken() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let tried = |inside: fn(f64, f64) -> bool| {
            completion(drawing(inside), square, &visible, &others, 0.7).expect_err("is not the disk")
        };
        assert!(tried(|x, _| x.abs() < 6.0).contains("another thing"));
        assert!(tried(|_, _| true).contains("background"));
        assert!(tried(|_, _| false).contains("nothing is drawn"));
    }

    #[test]
    fn the_model_sees_the_surroundings_and_the_thing_alone() {
        let (visible, others) = scene();
        let square = Square::around(&visible, &others).expect("shows");
        let [around, alone] =
            square.pictures(&Image::filled(200, 120, [9, 8, 7, 255]), &visible, None).expect("encodes");
        let (around, alone) =
            (picture::received(&around).expect("intact"), picture::received(&alone).expect("intact"));
        assert_eq!((around.width_px(), alone.width_px()), (square.side_px, square.side_px));
        let at = |x: i64, y: i64| ((x - square.x0) as u32, (y - square.y0) as u32);
        let ((shown_x, shown_y), (hidden_x, hidden_y)) = (at(85, 50), at(110, 70));
        assert_eq!(around.pixel(hidden_x, hidden_y), [9, 8, 7, 255]);
        assert_eq!(alone.pixel(shown_x, shown_y), [9, 8, 7, 255]);
        assert_eq!(alone.pixel(hidden_x, hidden_y), [0; 4]);
        let backdrop = far_from(&Image::filled(200, 120, [9, 8, 7, 255]), &visible);
        let before = square.pictures(&Image::filled(200, 120, [9, 8, 7, 255]), &visible, Some(backdrop));
        let before = picture::received(&before.expect("encodes")[1]).expect("intact");
        assert_eq!(before.pixel(shown_x, shown_y), [9, 8, 7, 255]);
        assert_eq!(
            before.pixel(hidden_x, hidden_y),
            [backdrop.rgb[0], backdrop.rgb[1], backdrop.rgb[2], 255]
        );
        // The disk reaches to y = 31; above the picture is nothing.
        let tall = Mask::from_fn(20, 120, |x, _| x < 10);
        let square = Square::around(&tall, &Mask::empty(20, 120)).expect("shows");
        let [around, _] =
            square.pictures(&Image::filled(20, 120, [0, 0, 0, 255]), &tall, None).expect("encodes");
        assert_eq!(picture::received(&around).expect("intact").pixel(0, 0), [255; 4]);
        assert_eq!(Square::around(&tall, &Mask::empty(9, 9)), None);
    }
}
