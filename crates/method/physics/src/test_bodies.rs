//! Bodies and settings the tests of this module share.

use glam::DVec3;

use super::metrics::CertifySettings;
use super::{Body, SettleSettings};
use geometry::convex_hull::convex_hull;
use geometry::mass_properties::solid_mass_properties;
use geometry::shapes::block;
use geometry::{Friction, Material, Pose, Rgb, Solid, TexturedMesh};

pub fn mesh(solid: Solid) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    mesh
}

/// A convex wooden body.
pub fn body(name: &str, solid: Solid, world_from_object: Pose) -> Body {
    let hull = convex_hull(&solid.positions, 64, 0.001).expect("a solid");
    Body {
        name: name.into(),
        hulls: vec![hull],
        world_from_object,
        mass: solid_mass_properties(&mesh(solid), 700.0).expect("a solid"),
        friction: Friction { static_coefficient: 0.5, dynamic_coefficient: 0.4 },
        restitution: 0.2,
        rolling_friction_m: 0.0003,
        fixed: false,
    }
}

/// The solid of [`table`]: 2 m square, its top at z = 0.
pub fn table_solid() -> Solid {
    block(DVec3::new(2.0, 2.0, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03))
}

pub fn table() -> Body {
    Body { fixed: true, ..body("table", table_solid(), Pose::IDENTITY) }
}

pub fn settle_settings() -> SettleSettings {
    SettleSettings {
        duration_s: 5.0,
        steps_per_s: 240.0,
        solver_iterations: 8,
        contact_frequency_hz: 350.0,
        length_unit_m: 0.02,
        damping_per_s: 0.05,
        rest_speed_m_s: 0.0005,
        rest_time_s: 0.25,
    }
}

pub fn certify_settings() -> CertifySettings {
    CertifySettings {
        penetration_m: 0.001,
        wall_share: 0.25,
        min_wall_m: 0.0004,
        sample_spacing_m: 0.001,
        contact_gap_m: 0.001,
        support_dilation_m: 0.002,
        carrying_slope: 0.2,
        dss_displacement_m: 0.03,
        dss_rotation_rad: 30_f64.to_radians(),
        dss_duration_s: 5.0,
        rest_side_share: 0.25,
        rest_rotation_rad: 2_f64.to_radians(),
    }
}
