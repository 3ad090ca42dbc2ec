//! Compares the marks of stand-ins that URDF, MJCF, SDF and GLB hold with those of the scene, in the files of the scene
//! and of the bodies. The USD reader compares its marks with the rest of the body.

use std::collections::BTreeMap;

use markup::xml::allowed_in_xml;
use rayon::prelude::*;
use roxmltree::Node;
use scene::StandIn;

use crate::body::{SHOWN_AS, STAND_IN, STANDS_FOR};
use crate::urdf::LABEL_NAMESPACE;
use crate::{Body, ExportError};

use super::xml_node::{self, XmlNode};
use super::{Difference, Files, ReadResult, glb};

/// The marks of bodies, by name.
type Marks = BTreeMap<String, StandIn>;

/// Fails with the first format whose marks differ.
pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<(), ExportError> {
    let of_bodies = |marks: fn(&Files<'_>, &Body) -> ReadResult<Marks>| -> ReadResult<Marks> {
        let each: Vec<Marks> = bodies.par_iter().map(|body| marks(files, body)).collect::<ReadResult<_>>()?;
        Ok(each.into_iter().flatten().collect())
    };
    let read = [
        ("URDF", of_bodies(|files, body| urdf(files, &format!("urdf/{0}/{0}.urdf", body.name)))),
        ("URDF", urdf(files, "urdf/scene.urdf")),
        ("MJCF", of_bodies(mjcf_object)),
        ("MJCF", mjcf(files, "mjcf/scene.xml")),
        ("SDF", of_bodies(sdf_model)),
        ("SDF", sdf_world(files)),
        ("GLB", of_bodies(glb_mesh)),
        ("GLB", glb::stand_ins(files)),
    ];
    for (format, marks) in read {
        let marks = marks.map_err(|reason| ExportError::unreadable(format, reason))?;
        // XML has no way to write most control characters.
        let words: fn(&str) -> String = if format == "GLB" { str::to_owned } else { allowed_in_xml };
        let wanted: Marks =
            bodies.iter().filter_map(|body| Some((body.name.clone(), held(body, words)?))).collect();
        if marks != wanted {
            let difference = Difference::StandIns { found: marks, wanted };
            return Err(ExportError::mismatch(format, difference));
        }
    }
    Ok(())
}

/// The mark of a body in the words that a format can hold.
pub(super) fn held(body: &Body, words: impl Fn(&str) -> String) -> Option<StandIn> {
    let StandIn { stands_for, shown_as } = body.stand_in.as_ref()?;
    Some(StandIn { stands_for: words(stands_for), shown_as: words(shown_as) })
}

/// The mark of which a format gives the parts by their names.
fn mark<'a>(part: impl Fn(&str) -> Option<&'a str>) -> Option<StandIn> {
    let words = |name: &str| part(name).unwrap_or_default().to_owned();
    (part(STAND_IN) == Some("true"))
        .then(|| StandIn { stands_for: words(STANDS_FOR), shown_as: words(SHOWN_AS) })
}

fn urdf(files: &Files<'_>, path: &str) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text(path)?)?;
    let labels = document.root_element().all((LABEL_NAMESPACE, "label"));
    let marked = labels.filter_map(|label| Some((label, mark(|part| label.attribute(part))?)));
    marked.map(|(label, mark)| Ok((label.required("link")?.to_owned(), mark))).collect()
}

fn mjcf(files: &Files<'_>, path: &str) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text(path)?)?;
    let texts = document.root_element().all("custom").flat_map(|custom| custom.all("text"));
    let texts: BTreeMap<&str, &str> =
        texts.filter_map(|text| Some((text.attribute("name")?, text.attribute("data")?))).collect();
    let prefix = format!("{STAND_IN}_");
    let names = texts.keys().filter_map(|text| text.strip_prefix(&prefix));
    let of = |name: &str| mark(|part| texts.get(format!("{part}_{name}").as_str()).copied());
    Ok(names.filter_map(|name| Some((name.to_owned(), of(name)?))).collect())
}

/// The table has no file of its own.
fn mjcf_object(files: &Files<'_>, body: &Body) -> ReadResult<Marks> {
    match body.movable {
        true => mjcf(files, &format!("mjcf/{0}/{0}.xml", body.name)),
        false => Ok(Marks::new()),
    }
}

fn sdf_model(files: &Files<'_>, body: &Body) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text(&format!("sdf/models/{}/model.sdf", body.name))?)?;
    sdf(document.root_element())
}

fn sdf_world(files: &Files<'_>) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text("sdf/world.sdf")?)?;
    sdf(document.root_element().child("world")?)
}

/// Of the models directly below an element.
fn sdf(above: Node<'_, '_>) -> ReadResult<Marks> {
    let models = above.all("model");
    let marked =
        models.filter_map(|model| Some((model, mark(|part| model.attribute((LABEL_NAMESPACE, part)))?)));
    marked.map(|(model, mark)| Ok((model.required("name")?.to_owned(), mark))).collect()
}

fn glb_mesh(files: &Files<'_>, body: &Body) -> ReadResult<Marks> {
    let mark = glb::root_stand_in(files, &format!("glb/{}.glb", body.name))?;
    Ok(mark.map(|mark| (body.name.clone(), mark)).into_iter().collect())
}
