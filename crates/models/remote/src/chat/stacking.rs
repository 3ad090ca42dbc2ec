//! The support relation of the objects in an image.

use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Value, json};

use super::prompts::prompts;
use super::recognize::{Detections, named};
use super::repair_turn::Topic;
use super::response_values::{Complaints, cyclic};
use super::{ChatAnalyst, schema};
use ports::{Call, ProviderError};
use scene::instance::SupportRelation;
use scene::{InstanceId, StandsOn};

/// The name of the table in answers.
const TABLE: &str = "table";

#[derive(Deserialize)]
pub(super) struct Answer {
    objects: Vec<AnswerObject>,
}

#[derive(Deserialize)]
struct AnswerObject {
    name: String,
    relation: SupportRelation,
    carried_by: String,
}

pub(super) fn schema() -> Value {
    let object = schema::object(&[
        ("name", schema::text("as given")),
        ("relation", schema::word(["on", "in"])),
        ("carried_by", schema::text("`table`, or a given name")),
    ]);
    schema::object(&[("objects", schema::list(&object))])
}

/// Asks for the support of each object, in the order of the detections.
pub(super) async fn stacking(
    analyst: &ChatAnalyst,
    call: &Call,
    image: &Bytes,
    detections: &Detections,
    seed: u64,
) -> Result<Vec<StandsOn>, ProviderError> {
    let topic = Topic {
        prompt: &prompts().stacking,
        schema: schema(),
        seed,
        data: json!({ "objects": named(detections) }),
        images: vec![image.clone()],
    };
    let ids: Vec<InstanceId> = detections.objects.iter().map(|object| object.id.clone()).collect();
    analyst.ask(call, topic, |answer| accepted(&answer, &ids)).await
}

pub(super) fn accepted(answer: &Answer, asked: &[InstanceId]) -> Result<Vec<StandsOn>, Vec<String>> {
    let mut complaints = Complaints::default();
    let order = complaints.answers(asked, answer.objects.iter().map(|object| object.name.as_str()));
    let mut carried = Vec::with_capacity(order.len());
    let mut stands = Vec::with_capacity(order.len());
    for place in order {
        let AnswerObject { name, relation, carried_by } = &answer.objects[place];
        let carrier = asked.iter().position(|id| id.as_str() == carried_by);
        if carrier.is_none() && carried_by != TABLE {
            complaints
                .add(format!("{name} is carried by something that is neither `table` nor a given name"));
        }
        carried.push(carrier);
        stands.push(match (carrier, relation) {
            (None, _) => StandsOn::Table,
            (Some(carrier), SupportRelation::On) => StandsOn::On(asked[carrier].clone()),
            (Some(carrier), SupportRelation::In) => StandsOn::In(asked[carrier].clone()),
        });
    }
    if carried.len() == asked.len() {
        for index in cyclic(&carried) {
            complaints.add(format!("{} is carried, in the end, by itself", asked[index]));
        }
    }
    complaints.none_or(stands)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids() -> Vec<InstanceId> {
        ["plate_1", "plate_2", "fork_1"].map(|name| InstanceId::new(name).expect(name)).into()
    }

    fn answered(text: &str) -> Result<Vec<StandsOn>, Vec<String>> {
        accepted(&serde_json::from_str(text).expect("has the form"), &ids())
    }

    #[test]
    fn stacking_accepts_a_tree_in_the_order_asked() {
        let stands = answered(
            r#"{"objects": [{"name": "plate_2", "relation": "on", "carried_by": "plate_1"},
                {"name": "fork_1", "relation": "in", "carried_by": "plate_2"},
                {"name": "plate_1", "relation": "on", "carried_by": "table"}]}"#,
        );
        let [plate, above, _] = <[InstanceId; 3]>::try_from(ids()).expect("three");
        assert_eq!(stands, Ok(vec![StandsOn::Table, StandsOn::On(plate), StandsOn::In(above)]));
    }

    #[test]
    fn stacking_rejects_cycles_and_unknown_ids() {
        let message = answered(
            r#"{"objects": [{"name": "plate_1", "relation": "on", "carried_by": "plate_2"},
                {"name": "plate_2", "relation": "on", "carried_by": "plate_1"},
                {"name": "fork_1", "relation": "on", "carried_by": "floor"}]}"#,
        );
        let message = message.expect_err("complains").join("\n");
        assert!(
            message.contains("plate_1 is carried, in the end, by itself") && message.contains("fork_1"),
            "{message}"
        );
    }
}
