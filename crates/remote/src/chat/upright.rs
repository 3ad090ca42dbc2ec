//! How a raw mesh stands: a model says which of its sides is the top and which the front, and looks a second
//! time once it has been turned so. What it says is one kind of evidence beside sizes and the picture
//! ([`pose_estimation::canonicalize`]), which overrule it where they show the thing otherwise.

use std::sync::Arc;

use bytes::Bytes;
use glam::{DMat3, DQuat};
use serde::Deserialize;
use serde_json::{Value, json};

use super::conversation::Topic;
use super::prompts::prompts;
use super::words::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::picture;
use catalog::Recipe;
use geometry::TexturedMesh;
use imaging::Image;
use ports::{Call, Port, ProviderError, Upright, UprightLook, UprightQuestion, stood_up};
use render::overlay::{draw_text, sheet};
use render::side_views::{Side, side_views};
use vision::cut_out::laid_on;

/// Most looks at a mesh: one, and another where the first turned it.
const MOST_LOOKS: usize = 2;

/// Side of a view on the sheet, and longest side of the picture of the thing, pixels.
const VIEW_PX: u32 = 256;

/// What is behind the thing in its picture: the middle of the sheet's backdrop.
const BACKDROP: [u8; 3] = [190, 191, 193];

#[derive(Deserialize)]
pub(super) struct Answer {
    top: String,
    front: String,
}

/// The sides that belong on top and to the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Said {
    top: Side,
    front: Side,
}

impl Said {
    /// The rotation that brings them there.
    fn rotation(self) -> DQuat {
        let (up, back) = (self.top.outward(), -self.front.outward());
        let rows = DMat3::from_cols(back.cross(up), back, up);
        DQuat::from_mat3(&rows.transpose()).normalize()
    }

    fn as_it_is(self) -> bool {
        (self.top, self.front) == (Side::Top, Side::Front)
    }
}

pub(super) fn schema() -> Value {
    let side = || schema::word(Side::ALL.map(Side::name));
    schema::object(&[("top", side()), ("front", side())])
}

/// Asks how the mesh stands, and weighs the answer.
pub(super) async fn upright(
    analyst: &ChatAnalyst,
    call: &Call,
    question: UprightQuestion,
) -> Result<Upright, ProviderError> {
    let mut looks: Vec<UprightLook> = Vec::new();
    let mut turned = DQuat::IDENTITY;
    let thing = question.completion.picture.clone();
    while looks.len() < MOST_LOOKS {
        let (mesh, thing) = (question.raw_mesh.clone(), thing.clone());
        let pictures = call.compute(Port::Analyst, move |_| pictures(&thing, &mesh, turned));
        let topic = Topic {
            prompt: &prompts().upright,
            schema: schema(),
            seed: question.object.seed,
            data: json!({ "thing": question.object.label }),
            pictures: pictures.await?,
        };
        let said = analyst.ask(call, topic, accepted).await?;
        turned = (said.rotation() * turned).normalize();
        let (top, front) = (said.top.name().to_owned(), said.front.name().to_owned());
        looks.push(UprightLook { top, front, rotation_xyzw: turned });
        if said.as_it_is() {
            break;
        }
    }
    let told: Vec<DQuat> = looks.iter().map(|look| look.rotation_xyzw).collect();
    let question = Arc::new(question);
    let asked = question.clone();
    let pose = call.compute(Port::Analyst, move |interrupt| {
        let object = &asked.object;
        let example = Recipe::typical(&object.category, object.color, object.material.clone())
            .and_then(|r| catalog::stocked(&r));
        stood_up(&asked, example.as_deref(), &told, interrupt)
    });
    let pose = pose.await?;
    if pose.rotation.dot(turned).abs() < 0.99 {
        let object = question.object.id.as_str();
        tracing::info!(
            object,
            "a mesh is not turned as the analyst says: sizes and picture show it otherwise"
        );
    }
    Ok(Upright { pose, looks })
}

/// The thing before a plain backdrop, and the sheet of the mesh as far as it has been turned.
fn pictures(thing: &Image, mesh: &TexturedMesh, turned: DQuat) -> Result<Vec<Bytes>, ProviderError> {
    let mut views = side_views(&mesh.clone().rotated(turned), VIEW_PX);
    for (side, view) in &mut views {
        draw_text(view, 8, 8, side.name(), 2, [20, 20, 24, 255]);
    }
    let cells: Vec<(&Image, &str)> = views.iter().map(|(side, view)| (view, side.name())).collect();
    let sheet = sheet(&cells, 3, VIEW_PX);
    let sent = |image: &Image, longest_px| {
        picture::sent(image, longest_px)
            .map_err(|error| rejected("image_unreadable", format!("a picture cannot be sent: {error}")))
    };
    Ok(vec![sent(&laid_on(thing, BACKDROP), 2 * VIEW_PX)?, sent(&sheet, u32::MAX)?])
}

pub(super) fn accepted(answer: Answer) -> Result<Said, Vec<String>> {
    let mut complaints = Complaints::default();
    let mut side = |at: &str, name: &str| {
        Side::named(name).unwrap_or_else(|| {
            complaints.add(format!("{at} must be one of the given words"));
            Side::Top
        })
    };
    let said = Said { top: side("top", &answer.top), front: side("front", &answer.front) };
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

    fn said(top: &str, front: &str) -> Result<Said, Vec<String>> {
        accepted(Answer { top: top.into(), front: front.into() })
    }

    #[test]
    fn every_answer_that_may_be_given_is_one_of_24_rotations() {
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
        assert!(said("top", "front").expect("may be").as_it_is());
    }

    #[test]
    fn a_front_on_top_is_complained_about() {
        for (top, front) in
            [("top", "top"), ("top", "bottom"), ("left", "right"), ("up", "front"), ("top", "")]
        {
            let told = said(top, front).expect_err("complains");
            assert!(told.iter().all(|told| told.len() < 200), "{told:?}");
        }
    }

    #[test]
    fn transparent_things_are_sent_before_a_backdrop() {
        let mut thing = Image::filled(2, 1, [200, 10, 7, 255]);
        thing.set_pixel(1, 0, [255, 255, 255, 0]);
        let opaque = laid_on(&thing, BACKDROP);
        assert_eq!((opaque.pixel(0, 0), opaque.pixel(1, 0)), ([200, 10, 7, 255], [190, 191, 193, 255]));
    }
}
