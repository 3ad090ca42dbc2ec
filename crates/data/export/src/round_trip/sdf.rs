//! Reads `sdf/world.sdf` and compares each of its models with the model in its own folder.

use glam::{DMat3, DQuat, DVec3};

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use roxmltree::Node;

use super::xml_node::{self, XmlNode};
use super::{
    Files, ReadBody, ReadContact, ReadError, ReadHull, ReadResult, ReadScene, numbers, obj_hull, vector,
};
use crate::sdf::DRAKE_NAMESPACE;

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let document = xml_node::parse(files.text("sdf/world.sdf")?)?;
    let mut scene = ReadScene::new();
    for model in document.root_element().child("world")?.all("model") {
        let name = model.required("name")?;
        if name == "floor" {
            continue;
        }
        let body = read_model(files, model, "sdf")?;
        let folder = format!("sdf/models/{name}");
        let document = xml_node::parse(files.text(&format!("{folder}/model.sdf"))?)?;
        let standalone = read_model(files, document.root_element().child("model")?, &folder)?;
        let same = standalone.hulls == body.hulls
            && standalone.mass_kg == body.mass_kg
            && standalone.center_of_mass_m == body.center_of_mass_m
            && standalone.inertia_tensor_kg_m2 == body.inertia_tensor_kg_m2
            && standalone.contact == body.contact
            && standalone.movable == body.movable;
        if !same {
            let name = name.to_owned();
            return Err(ReadError::OtherThanOwn { whole: "world", name, own: "folder" });
        }
        scene.insert(name.to_owned(), body);
    }
    Ok(scene)
}

fn read_model(files: &Files<'_>, model: Node<'_, '_>, folder: &str) -> ReadResult<ReadBody> {
    let link = model.child("link")?;
    let inertial = link.child("inertial")?;
    let center = pose(inertial.child("pose")?)?;
    if center.rotation != DQuat::IDENTITY {
        return Err(ReadError::wrong("inertia", "is not along the link's axes"));
    }
    let inertia = inertial.child("inertia")?;
    let moment = |name: &str| inertia.child(name)?.text_number();
    let (xx, xy, xz) = (moment("ixx")?, moment("ixy")?, moment("ixz")?);
    let (yy, yz, zz) = (moment("iyy")?, moment("iyz")?, moment("izz")?);
    let path = |element: Node<'_, '_>| -> ReadResult<String> {
        let mesh = element.child("geometry")?.child("mesh")?;
        if mesh.child("scale").is_ok() {
            return Err(ReadError::wrong("a mesh", "is scaled"));
        }
        Ok(format!("{folder}/{}", mesh.child("uri")?.content()))
    };
    for visual in link.all("visual") {
        files.bytes(&path(visual)?)?;
    }
    let (mut hulls, mut contact) = (Vec::new(), None);
    for collision in link.all("collision") {
        hulls.push(match read_solid(collision)? {
            Some(solid) => ReadHull::Solid(solid),
            None => obj_hull(files.text(&path(collision)?)?)?,
        });
        let surface = read_surface(collision.child("surface")?)?;
        let surface = with_proximity(surface, collision, model.child("static")?.content() == "false")?;
        if contact.is_some_and(|contact| contact != surface) {
            return Err(ReadError::FrictionDiffers("hulls".to_owned()));
        }
        contact = Some(surface);
    }
    Ok(ReadBody {
        mass_kg: inertial.child("mass")?.text_number()?,
        center_of_mass_m: center.translation_m,
        inertia_tensor_kg_m2: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
        contact: contact.ok_or_else(|| ReadError::lacks("a model", "collision"))?,
        world_from_object: pose(model.child("pose")?)?,
        movable: Some(model.child("static")?.content() == "false"),
        hulls,
        visual: None,
        labels: None,
    })
}

/// The solid of a collision; `None` where it is a mesh.
fn read_solid(collision: Node<'_, '_>) -> ReadResult<Option<SimpleSolid>> {
    let geometry = collision.child("geometry")?;
    let Some(shape) = geometry.children().find(Node::is_element).filter(|shape| !shape.has_tag_name("mesh"))
    else {
        return Ok(None);
    };
    let number = |name: &str| shape.child(name)?.text_number();
    let kind = match shape.tag_name().name() {
        "box" => SimpleSolidKind::Box { half_m: 0.5 * vector(&shape.child("size")?.content())? },
        "sphere" => SimpleSolidKind::Sphere { radius_m: number("radius")? },
        "cylinder" => {
            SimpleSolidKind::Cylinder { radius_m: number("radius")?, half_length_m: 0.5 * number("length")? }
        }
        "capsule" => {
            SimpleSolidKind::Capsule { radius_m: number("radius")?, half_length_m: 0.5 * number("length")? }
        }
        other => return Err(ReadError::CollisionKind(other.to_owned())),
    };
    Ok(Some(SimpleSolid { kind, object_from_solid: pose(collision.child("pose")?)? }))
}

/// Contact parameters. Friction must be equal for all physics engines of Gazebo.
fn read_surface(surface: Node<'_, '_>) -> ReadResult<ReadContact> {
    let friction = surface.child("friction")?;
    let (ode, bullet) = (friction.child("ode")?, friction.child("bullet")?);
    let dynamic_friction = ode.child("mu")?.text_number()?;
    let others = [(ode, "mu2"), (bullet, "friction"), (bullet, "friction2")];
    for (engine, name) in others {
        if engine.child(name)?.text_number()? != dynamic_friction {
            return Err(ReadError::FrictionDiffers(format!("mu and {name}")));
        }
    }
    let torsional = friction.child("torsional")?;
    let radius_m = torsional.child("patch_radius")?.text_number()?;
    // Torque over normal force of a contact patch in Gazebo is 3 pi / 16 times coefficient times radius.
    let lever = 3.0 * std::f64::consts::PI / 16.0 * torsional.child("coefficient")?.text_number()?;
    Ok(ReadContact {
        dynamic_friction,
        static_friction: None,
        restitution: Some(surface.child("bounce")?.child("restitution_coefficient")?.text_number()?),
        rolling_friction_m: Some(bullet.child("rolling_friction")?.text_number()?),
        torsional_friction_m: Some(lever * radius_m),
    })
}

/// Adds the static friction of Drake's elements. Its dynamic friction must be that of the surface, and movable models
/// must be compliant.
fn with_proximity(
    surface: ReadContact,
    collision: Node<'_, '_>,
    is_movable: bool,
) -> ReadResult<ReadContact> {
    let proximity = collision.child((DRAKE_NAMESPACE, "proximity_properties"))?;
    if proximity.child((DRAKE_NAMESPACE, "mu_dynamic"))?.text_number()? != surface.dynamic_friction {
        return Err(ReadError::FrictionDiffers("mu and drake:mu_dynamic".to_owned()));
    }
    proximity
        .child((DRAKE_NAMESPACE, if is_movable { "compliant_hydroelastic" } else { "rigid_hydroelastic" }))?;
    let static_friction = Some(proximity.child((DRAKE_NAMESPACE, "mu_static"))?.text_number()?);
    Ok(ReadContact { static_friction, ..surface })
}

/// Parses a position, and roll, pitch, yaw about the fixed axes.
fn pose(element: Node<'_, '_>) -> ReadResult<Pose> {
    let text = element.content();
    match numbers(&text)?.as_slice() {
        &[x, y, z, roll, pitch, yaw] => Ok(Pose {
            translation_m: DVec3::new(x, y, z),
            rotation: DQuat::from_rotation_z(yaw)
                * DQuat::from_rotation_y(pitch)
                * DQuat::from_rotation_x(roll),
        }),
        _ => Err(ReadError::NotA { text, kind: "pose" }),
    }
}
