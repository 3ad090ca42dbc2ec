//! The upright orientation of a raw mesh: a model names the side views that are the top and the front.
//!
//! The model is asked a second time after the mesh is rotated accordingly. Its answers are one kind of evidence beside
//! the object size and the image ([`stood_up`]), which override them where they disagree.

use std::sync::Arc;

use bytes::Bytes;
use glam::{DMat3, DQuat};
use serde::Deserialize;
use serde_json::{Value, json};

use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::image;
use catalog::Recipe;
use geometry::TexturedMesh;
use imaging::Image;
use ports::{Call, Port, ProviderError, Upright, UprightQuestion, UprightView, stood_up};
use render::annotate::{draw_text, sheet};
use render::side_views::{Side, side_views};
use vision::chroma_key::composite_over;

/// Maximum questions per mesh: a second one follows where the first rotated it.
const MAX_VIEWS: usize = 2;

/// Side of a view on the sheet, and half the maximum side of the object image, pixels.
const VIEW_PX: u32 = 256;

/// Background of the object image: the mean color of the backdrop of the sheet.
const BACKDROP: [u8; 3] = [190, 191, 193];

#[derive(Deserialize)]
pub(super) struct Answer {
    top: String,
    front: String,
}

/// The sides that are the top and the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NamedSides {
    top: Side,
    front: Side,
}

impl NamedSides {
    /// The rotation that brings them to the top and the front.
    fn rotation(self) -> DQuat {
        let (up, back) = (self.top.outward(), -self.front.outward());
        let rows = DMat3::from_cols(back.cross(up), back, up);
        DQuat::from_mat3(&rows.transpose()).normalize()
    }

    fn is_identity(self) -> bool {
        (self.top, self.front) == (Side::Top, Side::Front)
    }
}

pub(super) fn schema() -> Value {
    let side = || schema::word(Side::ALL.map(Side::name));
    schema::object(&[("top", side()), ("front", side())])
}

/// Asks for the orientation of the mesh, and combines the answers with geometric evidence.
pub(super) async fn upright(
    analyst: &ChatAnalyst,
    call: &Call,
    question: UprightQuestion,
) -> Result<Upright, ProviderError> {
    let mut views: Vec<UprightView> = Vec::new();
    let mut turned = DQuat::IDENTITY;
    let object = question.completion.image.clone();
    while views.len() < MAX_VIEWS {
        let (mesh, object) = (question.raw_mesh.clone(), object.clone());
        let images = call.compute(Port::Analyst, move |_| images(&object, &mesh, turned));
        let topic = Topic {
            prompt: &prompts().upright,
            schema: schema(),
            seed: question.object.seed,
            data: json!({ "thing": question.object.label }),
            images: images.await?,
        };
        let sides = analyst.ask(call, topic, accepted).await?;
        turned = (sides.rotation() * turned).normalize();
        let (top, front) = (sides.top.name().to_owned(), sides.front.name().to_owned());
        views.push(UprightView { top, front, rotation_xyzw: turned });
        if sides.is_identity() {
            break;
        }
    }
    let hints: Vec<DQuat> = views.iter().map(|view| view.rotation_xyzw).collect();
    let question = Arc::new(question);
    let asked = question.clone();
    let pose = call.compute(Port::Analyst, move |cancel| {
        let object = &asked.object;
        let example = Recipe::typical(&object.category, object.color, object.material.clone())
            .and_then(|r| catalog::build_cached(&r));
        stood_up(&asked, example.as_deref(), &hints, cancel)
    });
    let pose = pose.await?;
    if pose.rotation.dot(turned).abs() < 0.99 {
        let object = question.object.id.as_str();
        tracing::info!(object, "a mesh is not turned as the analyst says: sizes and image contradict it");
    }
    Ok(Upright { pose, views })
}

/// The object on a plain backdrop, and the sheet of side views of the rotated mesh.
fn images(object: &Image, mesh: &TexturedMesh, turned: DQuat) -> Result<Vec<Bytes>, ProviderError> {
    let mut views = side_views(&mesh.clone().rotated(turned), VIEW_PX);
    for (side, view) in &mut views {
        draw_text(view, 8, 8, side.name(), 2, [20, 20, 24, 255]);
    }
    let cells: Vec<(&Image, &str)> = views.iter().map(|(side, view)| (view, side.name())).collect();
    let sheet = sheet(&cells, 3, VIEW_PX);
    let sent = |image: &Image, longest_px| {
        image::sent(image, longest_px)
            .map_err(|error| rejected("image_unreadable", format!("an image cannot be sent: {error}")))
    };
    Ok(vec![sent(&composite_over(object, BACKDROP), 2 * VIEW_PX)?, sent(&sheet, u32::MAX)?])
}

pub(super) fn accepted(answer: Answer) -> Result<NamedSides, Vec<String>> {
    let mut complaints = Complaints::default();
    let mut side = |at: &str, name: &str| {
        Side::named(name).unwrap_or_else(|| {
            complaints.add(format!("{at} must be one of the given words"));
            Side::Top
        })
    };
    let said = NamedSides { top: side("top", &answer.top), front: side("front", &answer.front) };
    if said.top.outward().dot(said.front.outward()).abs() > 0.5 {
        complaints.add(
            "front must be a side of what stands: neither the view named in top nor the one opposite to it",
        );
    }
    complaints.none_or(said)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn said(top: &str, front: &str) -> Result<NamedSides, Vec<String>> {
        accepted(Answer { top: top.into(), front: front.into() })
    }

    #[test]
    fn valid_answers_are_the_24_axis_aligned_rotations() {
        let names = Side::ALL.map(Side::name);
        let pairs = names.iter().flat_map(|top| names.iter().map(move |front| (*top, *front)));
        let rotations: Vec<DQuat> = pairs
            .filter_map(|(top, front)| {
                let said = said(top, front).ok()?;
                let rotation = said.rotation();
                assert!((rotation * said.top.outward()).abs_diff_eq(DVec3::Z, 1e-12), "{said:?}");
                assert!((rotation * said.front.outward()).abs_diff_eq(-DVec3::Y, 1e-12), "{said:?}");
                Some(rotation)
            })
            .collect();
        assert_eq!(rotations.len(), 24);
        for (k, one) in rotations.iter().enumerate() {
            assert!(rotations[k + 1..].iter().all(|other| one.dot(*other).abs() < 0.99));
        }
        assert!(said("top", "front").expect("may be").is_identity());
    }

    #[test]
    fn accepted_rejects_a_front_on_the_top_axis() {
        for (top, front) in
            [("top", "top"), ("top", "bottom"), ("left", "right"), ("up", "front"), ("top", "")]
        {
            let message = said(top, front).expect_err("complains");
            assert!(message.iter().all(|message| message.len() < 200), "{message:?}");
        }
    }

    #[test]
    fn transparent_objects_are_composited_over_the_backdrop() {
        let mut object = Image::filled(2, 1, [200, 10, 7, 255]);
        object.set_pixel(1, 0, [255, 255, 255, 0]);
        let opaque = composite_over(&object, BACKDROP);
        assert_eq!((opaque.pixel(0, 0), opaque.pixel(1, 0)), ([200, 10, 7, 255], [190, 191, 193, 255]));
    }
}
