//! Compares visual meshes with the scene triangle by triangle, for the formats that store them as Wavefront files.

use std::collections::BTreeMap;

use rayon::prelude::*;

use glam::DVec3;
use roxmltree::Node;

use crate::{Body, ExportError};
use geometry::TexturedMesh;

use super::urdf::{mesh_file, package};
use super::xml_node::{self, XmlNode};
use super::{Difference, Files, ReadError, ReadResult, Tolerances, ceil_to_power_of_ten, larger, points};

/// Largest distance of a vertex from its position in the scene, per format, meters.
#[derive(Clone, Copy, Debug)]
pub struct VertexDeviations {
    pub urdf: f64,
    pub mjcf: f64,
    pub sdf: f64,
}

/// Largest distance of a corner of the mesh from the corner that was read, meters. Fails where the numbers of
/// triangles differ.
pub fn farthest_corner_m(
    mesh: &TexturedMesh,
    read: &BTreeMap<String, Vec<[DVec3; 3]>>,
) -> Result<f64, Difference> {
    let count = |found, of: String, wanted| Difference::Count { found, of, wanted };
    if read.len() != mesh.groups.len() {
        return Err(count(read.len(), "visual meshes".to_owned(), mesh.groups.len()));
    }
    let mut farthest_m: f64 = 0.0;
    for group in &mesh.groups {
        let name = &mesh.materials[group.material].name;
        let found = read.get(name).ok_or_else(|| Difference::NoVisualOf(name.clone()))?;
        if found.len() != group.triangles.len() {
            return Err(count(found.len(), format!("triangles of {name}"), group.triangles.len()));
        }
        let corners = group.triangles.iter().flatten().zip(found.iter().flatten());
        farthest_m =
            corners.map(|(v, at)| mesh.positions[*v as usize].distance(*at)).fold(farthest_m, larger);
    }
    Ok(farthest_m)
}

/// Paths of each body's visual meshes in one format, one per material.
type Paths = ReadResult<Vec<Vec<String>>>;

pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<VertexDeviations, ExportError> {
    let of = |format, paths: Paths| -> Result<f64, ExportError> {
        let paths = paths.map_err(|reason| ExportError::unreadable(format, reason))?;
        let worst: Vec<f64> = bodies
            .par_iter()
            .zip(&paths)
            .map(|(body, paths)| farthest_m(body, paths, files))
            .collect::<Result<_, Difference>>()
            .map_err(|difference| ExportError::mismatch(format, difference))?;
        Ok(ceil_to_power_of_ten(worst.into_iter().fold(0.0, larger)))
    };
    Ok(VertexDeviations {
        urdf: of("URDF", urdf(bodies, files))?,
        mjcf: of("MJCF", mjcf(bodies, files))?,
        sdf: of("SDF", sdf(bodies, files))?,
    })
}

fn farthest_m(body: &Body, paths: &[String], files: &Files<'_>) -> Result<f64, Difference> {
    let count = |owner: &str, found, of, wanted| {
        let owner = owner.to_owned();
        Difference::CountOf { owner, found, of, wanted }
    };
    let mesh = &body.visual;
    if paths.len() != mesh.groups.len() {
        return Err(count(&body.name, paths.len(), "visual meshes", mesh.groups.len()));
    }
    let mut farthest: f64 = 0.0;
    for (group, path) in mesh.groups.iter().zip(paths) {
        let found = triangles(files.text(path)?).map_err(|error| error.within(path))?;
        if found.len() != group.triangles.len() {
            return Err(count(path, found.len(), "triangles", group.triangles.len()));
        }
        for (found, wanted) in found.iter().zip(&group.triangles) {
            for (a, b) in found.iter().zip(wanted) {
                farthest = larger(farthest, a.distance(mesh.positions[*b as usize]));
            }
        }
        if farthest.is_nan() || farthest > Tolerances::BUNDLE.vertex_m {
            return Err(Difference::Vertex { path: path.clone(), off_m: farthest });
        }
    }
    Ok(farthest)
}

fn triangles(text: &str) -> ReadResult<Vec<[DVec3; 3]>> {
    let mut corners = Vec::new();
    let mut found = Vec::new();
    for line in text.lines() {
        if let Some(row) = line.strip_prefix("v ") {
            corners.extend(points(row)?);
        } else if let Some(face) = line.strip_prefix("f ") {
            let corner = |word: &str| {
                let index = word.split('/').next().and_then(|first| first.parse::<usize>().ok());
                index.and_then(|index| corners.get(index.checked_sub(1)?)).copied()
            };
            match face.split(' ').map(corner).collect::<Option<Vec<DVec3>>>().as_deref() {
                Some(&[a, b, c]) => found.push([a, b, c]),
                _ => return Err(ReadError::NotTriangle { face: face.to_owned(), corners: corners.len() }),
            }
        }
    }
    Ok(found)
}

fn urdf(bodies: &[Body], files: &Files<'_>) -> Paths {
    let package = package(files)?;
    let of = |body: &Body| {
        let name = &body.name;
        let document = xml_node::parse(files.text(&format!("urdf/{name}/{name}.urdf"))?)?;
        let path = |visual: Node<'_, '_>| {
            let mesh = visual.child("geometry")?.child("mesh")?;
            mesh_file(mesh.required("filename")?, &format!("urdf/{name}"), package.as_deref())
        };
        document.root_element().child("link")?.all("visual").map(path).collect()
    };
    bodies.iter().map(of).collect()
}

fn mjcf(bodies: &[Body], files: &Files<'_>) -> Paths {
    let document = xml_node::parse(files.text("mjcf/scene.xml")?)?;
    let root = document.root_element();
    let (assets, world) = (root.child("asset")?, root.child("worldbody")?);
    let of = |body: &Body| {
        let here = |element: &Node<'_, '_>| element.attribute("name") == Some(&body.name);
        let found = world.all("body").find(here).ok_or_else(|| ReadError::missing(&body.name))?;
        let path = |geom: Node<'_, '_>| {
            let name = geom.required("mesh")?;
            let mesh = assets.all("mesh").find(|mesh| mesh.attribute("name") == Some(name));
            let mesh = mesh.ok_or_else(|| ReadError::missing(format!("the mesh {name}")))?;
            if mesh.attribute("scale").is_some() {
                return Err(ReadError::wrong(format!("the mesh {name}"), "is scaled"));
            }
            Ok(format!("mjcf/assets/{}", mesh.required("file")?))
        };
        found.all("geom").filter(|geom| geom.attribute("group") == Some("2")).map(path).collect()
    };
    bodies.iter().map(of).collect()
}

fn sdf(bodies: &[Body], files: &Files<'_>) -> Paths {
    let of = |body: &Body| {
        let folder = format!("sdf/models/{}", body.name);
        let document = xml_node::parse(files.text(&format!("{folder}/model.sdf"))?)?;
        let path = |visual: Node<'_, '_>| {
            let uri = visual.child("geometry")?.child("mesh")?.child("uri")?.content();
            Ok(format!("{folder}/{uri}"))
        };
        document.root_element().child("model")?.child("link")?.all("visual").map(path).collect()
    };
    bodies.iter().map(of).collect()
}
