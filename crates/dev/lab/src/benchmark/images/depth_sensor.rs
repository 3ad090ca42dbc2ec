//! Depths as a structured-light camera measures them, from exact depths.
//!
//! - The sensor has [`SENSOR_SIDE_PX`] pixels on its longer side.
//! - Axial noise: normal, with the standard deviation that Nguyen, Izadi and Lovell (2012) measured of the first
//!   Kinect: 1.2 mm at 0.4 m, 3.5 mm at 1.5 m, 6.1 mm at 2 m. It grows with the square of the distance.
//! - Edges: each pixel reads the surface at a point 0.8 pixels (standard deviation) beside its center. Of pixels beside
//!   a step of the depth half have no measurement, and a quarter a depth between the two surfaces.
//! - Holes: round ones that cover 4 % of the image, at random places.
//! - Depths are whole millimeters, 0 = no measurement.
//!
//! Noise of adjacent pixels is independent; that of a sensor that matches blocks is not. Dark, shiny and transparent
//! surfaces are measured like others.

use imaging::DepthImage;
use rand::RngExt;
use runtime::seed::{Rng, child_rng};

/// Longer side of the sensor's image, pixels.
pub const SENSOR_SIDE_PX: u32 = 640;
/// Standard deviation of the place of a measurement, pixels.
const LATERAL_SIGMA_PX: f64 = 0.8;
/// Step between adjacent pixels that is an edge, as a share of the depth.
const EDGE_SHARE: f64 = 0.03;
const MISSING_AT_EDGES: f64 = 0.5;
const FLYING_AT_EDGES: f64 = 0.25;
/// Area of the holes, as a share of the image, and the range of their radii as shares of its longer side.
const HOLES_SHARE: f64 = 0.04;
const HOLE_RADIUS_SHARES: [f64; 2] = [0.004, 0.02];

/// The depths of an image of that number as the sensor measures them. Equal arguments give equal depths.
pub fn measured(exact: &DepthImage, number: u64) -> DepthImage {
    let mut rng = child_rng(number, "depth sensor");
    let longer = exact.width_px().max(exact.height_px());
    let side = |px: u32| (px * SENSOR_SIDE_PX / longer).max(1);
    let reduced = exact.resampled(side(exact.width_px()), side(exact.height_px()));
    let (width, height) = (reduced.width_px() as usize, reduced.height_px() as usize);
    let depths_m: Vec<f64> = reduced.depths_mm().iter().map(|mm| 1e-3 * f64::from(*mm)).collect();
    let at = |x: f64, y: f64| {
        let inside = |value: f64, size: usize| (value.round().max(0.0) as usize).min(size - 1);
        depths_m[inside(y, height) * width + inside(x, width)]
    };
    let mut measured_mm = vec![0_u16; width * height];
    for (index, measured_mm) in measured_mm.iter_mut().enumerate() {
        let (x, y) = ((index % width) as f64, (index / width) as f64);
        let around = [at(x - 1.0, y), at(x + 1.0, y), at(x, y - 1.0), at(x, y + 1.0)];
        let (near, far) = around.iter().fold((f64::INFINITY, 0.0_f64), |(n, f), d| (n.min(*d), f.max(*d)));
        let side = LATERAL_SIGMA_PX * normal(&mut rng);
        let up = LATERAL_SIGMA_PX * normal(&mut rng);
        let (noise, fate, between) = (normal(&mut rng), rng.random::<f64>(), rng.random::<f64>());
        let mut depth_m = at(x + side, y + up);
        if far - near > EDGE_SHARE * far {
            match fate {
                _ if fate < MISSING_AT_EDGES => depth_m = 0.0,
                _ if fate < MISSING_AT_EDGES + FLYING_AT_EDGES => depth_m = near + between * (far - near),
                _ => {}
            }
        }
        if depth_m > 0.0 {
            *measured_mm = (1e3 * (depth_m + axial_sigma_m(depth_m) * noise)).round().max(0.0) as u16;
        }
    }
    drill(&mut measured_mm, width, height, &mut rng);
    DepthImage::new(reduced.width_px(), reduced.height_px(), measured_mm).expect("a depth a pixel")
}

/// Standard deviation of a depth, meters (Nguyen, Izadi and Lovell 2012, equation 1).
fn axial_sigma_m(depth_m: f64) -> f64 {
    0.0012 + 0.0019 * (depth_m - 0.4).powi(2)
}

/// Removes the measurements of round holes.
fn drill(measured_mm: &mut [u16], width: usize, height: usize, rng: &mut Rng) {
    let longer = width.max(height) as f64;
    let mut drilled_px = 0.0;
    while drilled_px < HOLES_SHARE * (width * height) as f64 {
        let [low, high] = HOLE_RADIUS_SHARES;
        let radius = longer * (low + (high - low) * rng.random::<f64>());
        let (cx, cy) = (rng.random::<f64>() * width as f64, rng.random::<f64>() * height as f64);
        drilled_px += std::f64::consts::PI * radius * radius;
        for (index, measured_mm) in measured_mm.iter_mut().enumerate() {
            let (dx, dy) = ((index % width) as f64 - cx, (index / width) as f64 - cy);
            if dx * dx + dy * dy < radius * radius {
                *measured_mm = 0;
            }
        }
    }
}

/// A standard normal number (Box and Muller).
fn normal(rng: &mut Rng) -> f64 {
    let (a, b) = (rng.random::<f64>().max(1e-300), rng.random::<f64>());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_size_and_holes_the_stated_area() {
        for (depth_mm, sigma_m) in [(400_u16, 0.0012), (1500, 0.0035), (2000, 0.0061)] {
            let exact = DepthImage::new(640, 480, vec![depth_mm; 640 * 480]).expect("a depth a pixel");
            let seen = measured(&exact, 7);
            let off: Vec<f64> = (seen.depths_mm().iter().filter(|mm| **mm > 0))
                .map(|mm| 1e-3 * (f64::from(*mm) - f64::from(depth_mm)))
                .collect();
            let found = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
            assert!((found / sigma_m - 1.0).abs() < 0.05, "{found} m at {depth_mm} mm");
            let holes = 1.0 - seen.measured_share();
            assert!((0.02..0.06).contains(&holes), "{holes}");
            assert_eq!(seen, measured(&exact, 7));
            assert_ne!(seen, measured(&exact, 8));
        }
    }

    #[test]
    fn edges_lose_measurements_and_get_flying_pixels() {
        let step = (0..640 * 480).map(|index| if index % 640 < 320 { 800 } else { 1600 }).collect();
        let seen = measured(&DepthImage::new(640, 480, step).expect("a depth a pixel"), 3);
        let at_edge: Vec<u16> = (0..480).map(|y| seen.depths_mm()[y * 640 + 320]).collect();
        let share = |of: &dyn Fn(u16) -> bool| at_edge.iter().filter(|mm| of(**mm)).count() as f64 / 480.0;
        assert!((0.4..0.65).contains(&share(&|mm| mm == 0)));
        assert!((0.1..0.3).contains(&share(&|mm| (900..1500).contains(&mm))));
    }
}
