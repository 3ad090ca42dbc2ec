//! Checks of shapes and inertias.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::{finite, pose, positive};
use crate::model::error::{Refusal, refuse};
use crate::model::file::{InertiaFile, RoleFile, RoundFile, ShapeFile};
use crate::model::link::Inertia;
use crate::model::robot::Material;
use crate::model::shape::{Primitive, Shape, ShapeRole, frame_along, solid_inertia};

pub(super) fn shapes(path: &str, files: &[ShapeFile], materials: &[Material]) -> Result<Vec<Shape>, Refusal> {
    let shape = |(k, file)| shape(&format!("{path}.shapes[{k}]"), file, materials);
    files.iter().enumerate().map(shape).collect()
}

fn shape(path: &str, file: &ShapeFile, materials: &[Material]) -> Result<Shape, Refusal> {
    let Some(material) = materials.iter().position(|material| material.name == file.material) else {
        return refuse(format!("{path}.material"), format!("no material is named {:?}", file.material));
    };
    let role = match file.role {
        RoleFile::Both => ShapeRole::Both,
        RoleFile::Visual => ShapeRole::Visual,
        RoleFile::Collision => ShapeRole::Collision,
    };
    if file.pad && role == ShapeRole::Visual {
        return refuse(format!("{path}.pad"), "a pad must collide");
    }
    let (primitive, link_from_shape) = primitive(path, file)?;
    Ok(Shape { primitive, link_from_shape, material, role, is_pad: file.pad })
}

fn primitive(path: &str, file: &ShapeFile) -> Result<(Primitive, Isometry3<f64>), Refusal> {
    match (file.cuboid, file.cylinder, file.capsule, file.sphere) {
        (Some(cuboid), None, None, None) => {
            let path = format!("{path}.box");
            let half_size_m = Vector3::from(cuboid.size_m) / 2.0;
            for size_m in cuboid.size_m {
                positive(&format!("{path}.size_m"), size_m)?;
            }
            Ok((Primitive::Box { half_size_m }, pose(&path, cuboid.center_m, cuboid.rpy_deg)?))
        }
        (None, Some(file), None, None) => {
            let (frame, radius_m, half_length_m) = round(&format!("{path}.cylinder"), file)?;
            Ok((Primitive::Cylinder { radius_m, half_length_m }, frame))
        }
        (None, None, Some(file), None) => {
            let (frame, radius_m, half_length_m) = round(&format!("{path}.capsule"), file)?;
            Ok((Primitive::Capsule { radius_m, half_length_m }, frame))
        }
        (None, None, None, Some(sphere)) => {
            let path = format!("{path}.sphere");
            let radius_m = positive(&format!("{path}.radius_m"), sphere.radius_m)?;
            Ok((Primitive::Sphere { radius_m }, pose(&path, sphere.center_m, [0.0; 3])?))
        }
        _ => refuse(path, "state exactly one of box, cylinder, capsule and sphere"),
    }
}

fn round(path: &str, file: RoundFile) -> Result<(Isometry3<f64>, f64, f64), Refusal> {
    let from = Vector3::from(finite(&format!("{path}.from_m"), file.from_m)?);
    let to = Vector3::from(finite(&format!("{path}.to_m"), file.to_m)?);
    if (to - from).norm() < 1e-6 {
        return refuse(format!("{path}.to_m"), "must differ from from_m");
    }
    let (frame, half_length_m) = frame_along(from, to);
    Ok((frame, positive(&format!("{path}.radius_m"), file.radius_m)?, half_length_m))
}

pub(super) fn inertia(
    path: &str,
    file: Option<InertiaFile>,
    shapes: &[Shape],
) -> Result<Option<Inertia>, Refusal> {
    let path = format!("{path}.inertia");
    let Some(file) = file else {
        let problem = "a link with shapes needs an inertia";
        return if shapes.is_empty() { Ok(None) } else { refuse(path, problem) };
    };
    let mass_kg = positive(&format!("{path}.mass_kg"), file.mass_kg)?;
    match (file.center_m, file.moments_kg_m2) {
        (Some(center_m), Some([xx, xy, xz, yy, yz, zz])) => {
            let tensor_kg_m2 = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            check_tensor(&format!("{path}.moments_kg_m2"), &tensor_kg_m2)?;
            let center_m = Vector3::from(finite(&format!("{path}.center_m"), center_m)?);
            Ok(Some(Inertia { mass_kg, center_m, tensor_kg_m2 }))
        }
        (None, None) => match solid_inertia(shapes.iter(), mass_kg) {
            Some((center_m, tensor_kg_m2)) => Ok(Some(Inertia { mass_kg, center_m, tensor_kg_m2 })),
            None => refuse(path, "a link without shapes needs center_m and moments_kg_m2"),
        },
        _ => refuse(path, "state both center_m and moments_kg_m2, or neither"),
    }
}

/// A rigid body has positive principal moments, none above the sum of the other two.
fn check_tensor(path: &str, tensor: &Matrix3<f64>) -> Result<(), Refusal> {
    if !tensor.iter().all(|moment| moment.is_finite()) {
        return refuse(path, "must be finite");
    }
    let principal = tensor.symmetric_eigenvalues();
    if principal.min() <= 0.0 || 2.0 * principal.max() > principal.sum() * (1.0 + 1e-9) {
        let problem = format!("no rigid body has the principal moments {:?}", principal.as_slice());
        return refuse(path, problem);
    }
    Ok(())
}
