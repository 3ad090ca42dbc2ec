//! The words a person used for a body come back as they were, in every format that this program's own
//! readers can ask for them.

use std::collections::BTreeMap;

use crate::mjcf::LABEL_PREFIX;
use crate::xml::allowed_in_xml;
use crate::{Body, ExportError};

use super::xml_tree::Element;
use super::{Files, ReadResult, glb};

/// Body name to label.
type Labels = BTreeMap<String, String>;

/// Fails with the first label that reads back as something else.
pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<(), ExportError> {
    let read = [
        ("URDF", urdf(bodies, files)),
        ("MJCF", mjcf(bodies, files)),
        ("SDF", sdf(bodies, files)),
        ("GLB", glb::labels(files)),
    ];
    for (format, labels) in read {
        let labels = labels.map_err(|reason| ExportError::Unreadable { format, reason })?;
        for body in bodies {
            // XML has no way to write most control characters.
            let wanted = if format == "GLB" { body.label.clone() } else { allowed_in_xml(&body.label) };
            let found = labels.get(&body.name);
            if found != Some(&wanted) {
                let difference = format!("{}: the label is {found:?} instead of {wanted:?}", body.name);
                return Err(ExportError::Parity { format, difference });
            }
        }
    }
    Ok(())
}

fn urdf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let of = |body: &Body| {
        let name = &body.name;
        let robot = Element::parse(files.text(&format!("urdf/{name}/{name}.urdf"))?)?;
        Ok((name.clone(), robot.child("tabletopgen:label")?.attribute("text")?.to_owned()))
    };
    bodies.iter().map(of).collect()
}

fn sdf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let of = |body: &Body| {
        let model = Element::parse(files.text(&format!("sdf/models/{}/model.config", body.name))?)?;
        Ok((body.name.clone(), model.child("description")?.text.clone()))
    };
    bodies.iter().map(of).collect()
}

/// MuJoCo refuses empty text, so that a body without a label is told by its name.
fn mjcf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let root = Element::parse(files.text("mjcf/scene.xml")?)?;
    let custom = root.child("custom")?;
    let of = |body: &Body| {
        let entry = format!("{LABEL_PREFIX}{}", body.name);
        let text = custom.all("text").find(|text| text.optional("name") == Some(&entry));
        let text = text.ok_or_else(|| format!("there is no text {entry}"))?.attribute("data")?;
        let label = if body.label.is_empty() && text == body.name { "" } else { text };
        Ok((body.name.clone(), label.to_owned()))
    };
    bodies.iter().map(of).collect()
}
