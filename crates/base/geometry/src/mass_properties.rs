//! Mass, center of mass and inertia of a visual mesh.
//!
//! Solids: exact integrals over the tetrahedra between a reference point and each face (Mirtich,
//! "Fast and accurate computation of polyhedral mass properties", 1996; Eberly's form), signed, so a
//! cavity wall with inward faces subtracts. Shells: the same integrals over the surface times a
//! thickness. Principal axes: cyclic Jacobi rotations.
//!
//! Input: meters and kg/m^3 in the object's frame; output in the same frame. A mesh may be a union of
//! overlapping closed shells. Their integrals are summed, so an overlap counts twice: a mug whose handle ends inside
//! its wall gains the mass of the buried ends, under 1 % for the catalog. Principal moments are positive and obey the
//! triangle inequality. O(triangles). Not applicable to open surfaces.

use glam::{DMat3, DQuat, DVec3};

use super::{MassProperties, TexturedMesh};

/// Failure to compute mass properties.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MassError {
    #[error(
        "the mesh encloses no volume ({volume_m3} m^3): its faces point inward or it is not closed; repair the mesh"
    )]
    NoVolume { volume_m3: f64 },
    #[error("the mesh has no surface; give it triangles")]
    NoSurface,
    #[error("density {density_kg_m3} kg/m^3 and thickness {thickness_m} m must be positive and finite")]
    BadSubstance { density_kg_m3: f64, thickness_m: f64 },
}

/// Mass properties of the volume the mesh encloses, filled with `density_kg_m3`.
pub fn solid_mass_properties(mesh: &TexturedMesh, density_kg_m3: f64) -> Result<MassProperties, MassError> {
    check_substance(density_kg_m3, 1.0)?;
    let reference = center(mesh)?;
    let mut moments = Moments::default();
    for [a, b, c] in corners(mesh, reference) {
        // Signed: tetrahedra over faces that point toward the reference point subtract, so any reference point gives
        // the volume.
        let volume = a.dot(b.cross(c)) / 6.0;
        // The fourth corner of the tetrahedron is the reference point, the origin here.
        moments.add(volume, (a + b + c) / 4.0, second_moment(a, b, c) * (volume / 20.0));
    }
    if moments.measure.is_nan() || moments.measure <= 0.0 {
        return Err(MassError::NoVolume { volume_m3: moments.measure });
    }
    Ok(moments.into_properties(reference, density_kg_m3))
}

/// Mass properties of a shell of `thickness_m` on the mesh's surface, for hollow bodies that are modeled as solids.
pub fn shell_mass_properties(
    mesh: &TexturedMesh,
    thickness_m: f64,
    density_kg_m3: f64,
) -> Result<MassProperties, MassError> {
    check_substance(density_kg_m3, thickness_m)?;
    let reference = center(mesh)?;
    let mut moments = Moments::default();
    for [a, b, c] in corners(mesh, reference) {
        let area = 0.5 * (b - a).cross(c - a).length();
        moments.add(area, (a + b + c) / 3.0, second_moment(a, b, c) * (area / 12.0));
    }
    if moments.measure.is_nan() || moments.measure <= 0.0 {
        return Err(MassError::NoSurface);
    }
    Ok(moments.into_properties(reference, density_kg_m3 * thickness_m))
}

fn check_substance(density_kg_m3: f64, thickness_m: f64) -> Result<(), MassError> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if positive(density_kg_m3) && positive(thickness_m) {
        Ok(())
    } else {
        Err(MassError::BadSubstance { density_kg_m3, thickness_m })
    }
}

/// Center of the box. Integration about it avoids cancellation between large numbers.
fn center(mesh: &TexturedMesh) -> Result<DVec3, MassError> {
    if mesh.triangle_count() == 0 {
        return Err(MassError::NoSurface);
    }
    let (low, high) = mesh.bounds();
    Ok(0.5 * (low + high))
}

fn corners(mesh: &TexturedMesh, reference: DVec3) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    mesh.triangles().map(move |t| t.map(|v| mesh.positions[v as usize] - reference))
}

/// `sum v v^T + (sum v)(sum v)^T`: over a triangle the integral of x x^T is this times area / 12, over
/// the tetrahedron to the origin this times volume / 20.
fn second_moment(a: DVec3, b: DVec3, c: DVec3) -> DMat3 {
    let sum = a + b + c;
    outer(a) + outer(b) + outer(c) + outer(sum)
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Integrals of 1, x and x x^T.
#[derive(Default)]
struct Moments {
    measure: f64,
    first: DVec3,
    second: [DVec3; 3],
}

impl Moments {
    fn add(&mut self, measure: f64, centroid: DVec3, second: DMat3) {
        self.measure += measure;
        self.first += measure * centroid;
        self.second[0] += second.x_axis;
        self.second[1] += second.y_axis;
        self.second[2] += second.z_axis;
    }

    fn into_properties(self, reference: DVec3, density: f64) -> MassProperties {
        let center = self.first / self.measure;
        let [x, y, z] = self.second;
        let covariance = DMat3::from_cols(x, y, z) - outer(center) * self.measure;
        let (spread, axes) = symmetric_eigen(covariance);
        // Principal second moments are sums of squares; for flat bodies, rounding may make them slightly negative.
        let spread = (spread * density).max(DVec3::splat(1e-9 * (spread * density).max_element().abs()));
        MassProperties {
            mass_kg: self.measure * density,
            center_of_mass_m: reference + center,
            inertia_diagonal_kg_m2: DVec3::new(spread.y + spread.z, spread.z + spread.x, spread.x + spread.y),
            principal_axes_xyzw: axes,
        }
    }
}

/// Eigenvalues and the rotation whose columns are the eigenvectors (`object_from_principal`).
pub(crate) fn symmetric_eigen(mut m: DMat3) -> (DVec3, DQuat) {
    let mut axes = DMat3::IDENTITY;
    let scale = (m.x_axis.length() + m.y_axis.length() + m.z_axis.length()).max(f64::MIN_POSITIVE);
    for _ in 0..32 {
        let off = [(0, 1), (0, 2), (1, 2)];
        if off.iter().all(|&(p, q)| m.col(p)[q].abs() < 1e-15 * scale) {
            break;
        }
        // Cyclic Jacobi: a product of rotations stays a rotation, which a quaternion can hold.
        for (p, q) in off {
            let (pp, qq, pq) = (m.col(p)[p], m.col(q)[q], m.col(q)[p]);
            if pq == 0.0 {
                continue;
            }
            let theta = (qq - pp) / (2.0 * pq);
            // The smaller root of t^2 + 2 theta t = 1: a rotation by at most 45 degrees converges, and its formula
            // cancels no digits.
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (t * t + 1.0).sqrt();
            let sine = t * cosine;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cosine;
            turn.col_mut(q)[q] = cosine;
            turn.col_mut(q)[p] = sine;
            turn.col_mut(p)[q] = -sine;
            m = turn.transpose() * m * turn;
            axes *= turn;
        }
    }
    let values = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    let rotation = DQuat::from_mat3(&axes).normalize();
    // q and -q are the same rotation; one sign gives equal bytes for equal bodies.
    (values, if rotation.w < 0.0 { -rotation } else { rotation })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{block, shell_of_revolution, sphere, tube};
    use crate::{Material, Rgb, Solid};
    use glam::DVec2;
    use proptest::prelude::*;

    fn mesh(solid: Solid) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        mesh
    }

    fn inertia_in_object(p: &MassProperties) -> DMat3 {
        let axes = DMat3::from_quat(p.principal_axes_xyzw);
        axes * DMat3::from_diagonal(p.inertia_diagonal_kg_m2) * axes.transpose()
    }

    #[test]
    fn solid_block_has_the_analytic_inertia() {
        let p = solid_mass_properties(&mesh(block(DVec3::new(0.2, 0.1, 0.05))), 1000.0).expect("a block");
        assert!((p.mass_kg - 1.0).abs() < 1e-12);
        assert!((p.center_of_mass_m - DVec3::new(0.0, 0.0, 0.025)).length() < 1e-12);
        let expected = DVec3::new(0.01 + 0.0025, 0.04 + 0.0025, 0.04 + 0.01) / 12.0;
        let inertia = inertia_in_object(&p);
        for k in 0..3 {
            assert!((inertia.col(k)[k] - expected[k]).abs() < 1e-12, "{inertia}");
            assert!(inertia.col(k)[(k + 1) % 3].abs() < 1e-12);
        }
    }

    #[test]
    fn shell_mass_is_area_times_thickness_and_spherical_inertia_two_thirds() {
        let ball = mesh(sphere(0.1, 128));
        let p = shell_mass_properties(&ball, 0.001, 1000.0).expect("a ball");
        assert!((p.mass_kg - 4.0 * std::f64::consts::PI * 0.01).abs() < 1e-3 * p.mass_kg * 2.0);
        let moment = 2.0 / 3.0 * p.mass_kg * 0.01;
        assert!((p.inertia_diagonal_kg_m2.x / moment - 1.0).abs() < 2e-3);
    }

    #[test]
    fn mass_properties_reject_inverted_and_empty_meshes() {
        let mut inside_out = mesh(block(DVec3::ONE));
        for t in &mut inside_out.groups[0].triangles {
            t.swap(1, 2);
        }
        assert!(matches!(solid_mass_properties(&inside_out, 1.0), Err(MassError::NoVolume { .. })));
        assert_eq!(solid_mass_properties(&TexturedMesh::default(), 1.0), Err(MassError::NoSurface));
        assert!(shell_mass_properties(&mesh(block(DVec3::ONE)), -1.0, 1.0).is_err());
    }

    #[test]
    fn mass_of_a_mug_agrees_with_point_counting() {
        // Slow reference: midpoints of a fine grid, inside where the radius and height say so.
        let profile = [DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)];
        let mug = mesh(shell_of_revolution(&profile, 0.004, 0.006, 256));
        let p = solid_mass_properties(&mug, 2300.0).expect("a mug");
        let (step, mut mass, mut first, mut zz) = (0.0005, 0.0, DVec3::ZERO, 0.0);
        for (i, j, k) in (0..200).flat_map(|i| (0..160).flat_map(move |j| (0..160).map(move |k| (i, j, k)))) {
            let q = DVec3::new(f64::from(j) + 0.5, f64::from(k) + 0.5, f64::from(i) + 0.5) * step
                - DVec3::new(0.04, 0.04, 0.0);
            let r = q.truncate().length();
            if r < 0.04 && (r > 0.036 || q.z < 0.006) {
                let dm = 2300.0 * step * step * step;
                mass += dm;
                first += dm * q;
                zz += dm * r * r;
            }
        }
        assert!((p.mass_kg / mass - 1.0).abs() < 0.01);
        assert!((p.center_of_mass_m - first / mass).length() < 3e-4);
        assert!((inertia_in_object(&p).z_axis.z / zz - 1.0).abs() < 0.02);
    }

    proptest! {
        #[test]
        fn principal_moments_are_invariant_to_rigid_motion(yaw in -3.0..3.0_f64, tilt in -1.5..1.5_f64, x in -2.0..2.0_f64) {
            let solid = tube(&[DVec3::ZERO, DVec3::new(0.1, 0.05, 0.2), DVec3::new(0.3, 0.0, 0.25)], 0.02, 10);
            let here = solid_mass_properties(&mesh(solid.clone()), 700.0).expect("a bar");
            let turn = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(tilt);
            let moved = solid.rotated(turn).translated(DVec3::new(x, 1.0, -x));
            let there = solid_mass_properties(&mesh(moved), 700.0).expect("a bar");
            prop_assert!((here.mass_kg - there.mass_kg).abs() < 1e-9);
            let center = turn * here.center_of_mass_m + DVec3::new(x, 1.0, -x);
            prop_assert!((center - there.center_of_mass_m).length() < 1e-9);
            let sorted = |p: &MassProperties| {
                let mut d = p.inertia_diagonal_kg_m2.to_array();
                d.sort_by(f64::total_cmp);
                d
            };
            for (a, b) in sorted(&here).into_iter().zip(sorted(&there)) {
                prop_assert!((a - b).abs() < 1e-9 * (1.0 + a));
            }
            let [a, b, c] = sorted(&there);
            prop_assert!(a > 0.0 && a + b >= c);
            let rotated = DMat3::from_quat(turn);
            let expected = rotated * inertia_in_object(&here) * rotated.transpose();
            let got = inertia_in_object(&there);
            for k in 0..3 {
                prop_assert!((expected.col(k) - got.col(k)).length() < 1e-8);
            }
        }
    }
}
