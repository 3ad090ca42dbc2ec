//! Compares the marks of stand-ins that URDF, MJCF, SDF and GLB hold with those of the scene, in the files of the scene
//! and of the bodies. The USD reader compares its marks with the rest of the body.

use std::collections::BTreeSet;

use rayon::prelude::*;
use roxmltree::Node;

use crate::mjcf::STAND_IN_PREFIX;
use crate::xml::LABEL_NAMESPACE;
use crate::{Body, ExportError};

use super::xml_node::{self, XmlNode};
use super::{Files, ReadResult, glb};

/// Names of the bodies that are marked.
type Marks = BTreeSet<String>;

/// Fails with the first format whose marks differ.
pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<(), ExportError> {
    let wanted: Marks = bodies.iter().filter(|body| body.stand_in).map(|body| body.name.clone()).collect();
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
        let marks = marks.map_err(|reason| ExportError::Unreadable { format, reason })?;
        if marks != wanted {
            let difference = format!("the stand-ins are {marks:?} instead of {wanted:?}");
            return Err(ExportError::RoundTripMismatch { format, difference });
        }
    }
    Ok(())
}

fn urdf(files: &Files<'_>, path: &str) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text(path)?)?;
    let labels = document.root_element().all((LABEL_NAMESPACE, "label"));
    let marked = labels.filter(|label| label.attribute("stand_in") == Some("true"));
    marked.map(|label| Ok(label.required("link")?.to_owned())).collect()
}

fn mjcf(files: &Files<'_>, path: &str) -> ReadResult<Marks> {
    let document = xml_node::parse(files.text(path)?)?;
    let texts = document.root_element().all("custom").flat_map(|custom| custom.all("text"));
    let name_of =
        |text: Node<'_, '_>| Some(text.attribute("name")?.strip_prefix(STAND_IN_PREFIX)?.to_owned());
    Ok(texts.filter(|text| text.attribute("data") == Some("true")).filter_map(name_of).collect())
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
    let is_marked = |model: &Node<'_, '_>| model.attribute((LABEL_NAMESPACE, "stand_in")) == Some("true");
    let marked = above.all("model").filter(is_marked);
    marked.map(|model| Ok(model.required("name")?.to_owned())).collect()
}

fn glb_mesh(files: &Files<'_>, body: &Body) -> ReadResult<Marks> {
    let is_marked = glb::root_is_stand_in(files, &format!("glb/{}.glb", body.name))?;
    Ok(is_marked.then(|| body.name.clone()).into_iter().collect())
}
