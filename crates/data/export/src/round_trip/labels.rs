//! Compares the user's labels of all bodies with the labels that URDF, MJCF, SDF and GLB hold. The USD reader compares
//! its labels with the rest of the body.

use std::collections::BTreeMap;

use markup::xml::allowed_in_xml;

use crate::mjcf::LABEL_PREFIX;
use crate::urdf::LABEL_NAMESPACE;
use crate::{Body, ExportError};

use super::xml_node::{self, XmlNode};
use super::{Difference, Files, ReadError, ReadResult, glb};

/// Body name to label.
type Labels = BTreeMap<String, String>;

/// Fails with the first label that differs after reading.
pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<(), ExportError> {
    let read = [
        ("URDF", urdf(bodies, files)),
        ("MJCF", mjcf(bodies, files)),
        ("SDF", sdf(bodies, files)),
        ("GLB", glb::labels(files)),
    ];
    for (format, labels) in read {
        let labels = labels.map_err(|reason| ExportError::unreadable(format, reason))?;
        for body in bodies {
            // XML has no way to write most control characters.
            let wanted = if format == "GLB" { body.label.clone() } else { allowed_in_xml(&body.label) };
            let found = labels.get(&body.name);
            if found != Some(&wanted) {
                let (body, found) = (body.name.clone(), found.cloned());
                let difference = Difference::Label { body, found, wanted };
                return Err(ExportError::mismatch(format, difference));
            }
        }
    }
    Ok(())
}

fn urdf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let of = |body: &Body| {
        let name = &body.name;
        let document = xml_node::parse(files.text(&format!("urdf/{name}/{name}.urdf"))?)?;
        let label = document.root_element().child((LABEL_NAMESPACE, "label"))?;
        Ok((name.clone(), label.required("text")?.to_owned()))
    };
    bodies.iter().map(of).collect()
}

fn sdf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let of = |body: &Body| {
        let document = xml_node::parse(files.text(&format!("sdf/models/{}/model.config", body.name))?)?;
        Ok((body.name.clone(), document.root_element().child("description")?.content()))
    };
    bodies.iter().map(of).collect()
}

/// MuJoCo refuses empty text; the entry of a body without a label holds the body's name.
fn mjcf(bodies: &[Body], files: &Files<'_>) -> ReadResult<Labels> {
    let document = xml_node::parse(files.text("mjcf/scene.xml")?)?;
    let custom = document.root_element().child("custom")?;
    let of = |body: &Body| {
        let entry = format!("{LABEL_PREFIX}{}", body.name);
        let text = custom.all("text").find(|text| text.attribute("name") == Some(&entry));
        let text = text.ok_or_else(|| ReadError::Absent(format!("text {entry}")))?.required("data")?;
        let label = if body.label.is_empty() && text == body.name { "" } else { text };
        Ok((body.name.clone(), label.to_owned()))
    };
    bodies.iter().map(of).collect()
}
