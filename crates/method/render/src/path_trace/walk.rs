//! Light along one ray: a path from the eye over surfaces to the lights (Kajiya, "The rendering equation", 1986).
//!
//! At every matte or glossy surface the key light and the room are sampled, and the continued path counts what it meets
//! by chance; both are weighted by the power heuristic (Veach and Guibas 1995). Glass bends a path that has met glass
//! alone since the eye. For all other paths, those to the lights among them, glass tints and mirrors but does not bend,
//! so that both ways of finding a light agree and its shadow is neither black nor full of bright specks.

use glam::{Vec3, Vec3A};

use super::backdrop_seen::{BackdropHit, BackdropSeen};
use super::glass::{self, GLASS_INDEX};
use super::key_light::KeyLight;
use super::lobes::{Lobes, cosine_direction};
use super::sequence::Samples;
use super::sky_light::SkyLight;
use super::traced_scene::{TracedScene, TracedSurface, off};
use crate::forward::backdrop::Ray;

/// Objects and lights of an image.
pub struct Walk<'s, 'a> {
    pub scene: &'s TracedScene<'a>,
    pub key: &'s KeyLight,
    pub sky: &'s SkyLight,
    pub backdrop: &'s BackdropSeen,
    /// Largest number of surfaces that a path meets.
    pub max_bounces: u32,
}

/// A ray through a pixel.
pub struct EyeRay {
    /// With a direction one unit of depth long.
    pub ray: Ray,
    /// Height in the image, 0 = top.
    pub fraction: f32,
    /// Width of a pixel at one unit of depth, and how it grows with depth, meters.
    pub pixel_size_m: [f32; 2],
}

/// Bounces after which a path may end by chance.
const ROULETTE_FROM: u32 = 4;
/// Largest probability of going on.
const MAX_SURVIVAL: f32 = 0.95;
/// Smallest share of paths that glass mirrors at the first surface, so that highlights on glass are found.
const MIN_MIRRORED: f32 = 0.25;

/// The part of a path that is still to be walked.
struct Path {
    origin: Vec3A,
    direction: Vec3A,
    /// Share of light from ahead that reaches the eye.
    throughput: Vec3,
    light: Vec3,
    /// Probability per solid angle of the direction, where lights were sampled at its start.
    density: Option<f32>,
    /// Whether the disk of the key light counts where it is met.
    meets_key: bool,
    /// Whether the path has met glass alone, and passed it.
    sees_backdrop: bool,
    /// Whether the path has met glass alone.
    bends: bool,
    /// Bodies of glass around the path.
    inside: u32,
    /// Radiance in place of what is ahead where that is no object.
    open: Option<Vec3>,
}

/// Whether a path goes on.
#[derive(PartialEq, Eq)]
enum Step {
    On,
    End,
}

impl Walk<'_, '_> {
    /// Light toward the eye, before exposure.
    pub fn light(&self, eye: &EyeRay, samples: &mut Samples) -> Vec3 {
        let mut path = Path {
            origin: eye.ray.origin,
            direction: eye.ray.direction.normalize(),
            throughput: Vec3::ONE,
            light: Vec3::ZERO,
            density: None,
            meets_key: true,
            sees_backdrop: true,
            bends: true,
            inside: 0,
            open: None,
        };
        for bounce in 0..self.max_bounces.max(1) {
            let choice = samples.pair();
            let step = match self.scene.nearest(path.origin, path.direction) {
                Some(surface) => self.at_surface(&mut path, &surface, choice.x, bounce, samples),
                None => self.at_no_object(&mut path, eye, samples),
            };
            if step == Step::End || path.throughput.max_element() <= 0.0 {
                break;
            }
            if bounce >= ROULETTE_FROM {
                let survival = path.throughput.max_element().min(MAX_SURVIVAL);
                if choice.y >= survival {
                    break;
                }
                path.throughput /= survival;
            }
        }
        path.light
    }

    fn at_surface(
        &self,
        path: &mut Path,
        surface: &TracedSurface,
        choice: f32,
        bounce: u32,
        samples: &mut Samples,
    ) -> Step {
        path.open = None;
        if surface.is_opaque() {
            return self.at_body(path, surface, choice, samples);
        }
        let body = glass::body(surface.material.opacity);
        if choice < body {
            return self.at_body(path, surface, choice / body, samples);
        }
        self.at_glass(path, surface, (choice - body) / (1.0 - body), bounce);
        Step::On
    }

    /// Light that an opaque surface reflects, and the path beyond it.
    fn at_body(&self, path: &mut Path, surface: &TracedSurface, choice: f32, samples: &mut Samples) -> Step {
        let (right, up) = surface.normal.any_orthonormal_pair();
        let n = surface.normal;
        let to_local = |d: Vec3A| Vec3A::new(d.dot(right), d.dot(up), d.dot(n));
        let material = surface.material;
        let v = to_local(surface.toward_eye);
        let lobes = Lobes::new(v, surface.albedo, material.roughness, material.metalness);
        let start = surface.start(surface.lifted);
        let reflected = |direction: Vec3A| lobes.toward(to_local(direction));
        path.light += path.throughput * self.sampled_lights(start, reflected, true, samples);
        let Some(bounced) = lobes.sample(samples.pair(), choice) else { return Step::End };
        let l = bounced.l;
        path.direction = (l.x * right + l.y * up + l.z * n).normalize();
        path.origin = start;
        path.throughput *= bounced.weight;
        path.density = Some(bounced.density);
        (path.meets_key, path.sees_backdrop, path.bends) = (true, false, false);
        Step::On
    }

    /// Reflection or passage of a path at a surface of glass, chosen by a number in 0..1. The key light that glass
    /// mirrors is counted at once: few paths are mirrored, and each that met the key would be a bright speck.
    fn at_glass(&self, path: &mut Path, surface: &TracedSurface, choice: f32, bounce: u32) {
        let GlassPassage { index, mirrored, toward } = GlassPassage::new(path, surface);
        let start = surface.start(surface.point);
        // From inside bent glass no straight ray leads to the light.
        let is_counted = !path.bends || surface.is_front || surface.is_sheet;
        if is_counted && let Some((radiance, _)) = self.key.met(toward) {
            path.light += path.throughput * (mirrored * radiance) * self.arriving(start, toward);
        }
        let is_first = bounce == 0 && mirrored > 0.0;
        let share = if is_first { mirrored.max(MIN_MIRRORED) } else { mirrored };
        if choice < share {
            path.throughput *= mirrored / share;
            (path.origin, path.direction, path.density) = (start, toward, None);
            (path.meets_key, path.sees_backdrop) = (!is_counted, false);
            return;
        }
        let passing = (1.0 - mirrored) / (1.0 - share).max(1e-6);
        path.throughput *= glass::tint(surface.material, surface.albedo) * passing;
        if let Some(index) = index {
            let behind = |n: Vec3A| glass::refracted(path.direction, n, index);
            let direction = behind(surface.normal).filter(|d| d.dot(surface.flat_normal) < 0.0);
            path.direction = direction.or_else(|| behind(surface.flat_normal)).unwrap_or(path.direction);
        }
        if path.bends && !surface.is_sheet {
            let entered = path.inside + 1;
            path.inside = if surface.is_front { entered } else { path.inside.saturating_sub(1) };
        }
        path.origin = surface.start_behind();
    }

    /// Light of the key, if wanted, and of the room that a surface reflects, by `reflected`: reflectance times cosine,
    /// and the density with which the path goes on in a direction.
    fn sampled_lights(
        &self,
        start: Vec3A,
        reflected: impl Fn(Vec3A) -> (Vec3, f32),
        with_key: bool,
        samples: &mut Samples,
    ) -> Vec3 {
        let (of_key, of_sky) = (samples.pair(), samples.pair());
        let key = (with_key && self.key.shines()).then(|| self.key.sample(of_key));
        let mut light = Vec3::ZERO;
        for sample in [key, self.sky.sample(&self.backdrop.environment, of_sky)].into_iter().flatten() {
            let (reflected, density) = reflected(sample.direction);
            let weight = sample.density.map_or(1.0, |own| power(own, density));
            let seen = reflected * sample.weight * weight;
            if seen.max_element() > 0.0 {
                light += seen * self.arriving(start, sample.direction);
            }
        }
        light
    }

    /// Share of light from infinity that passes objects and floor.
    fn arriving(&self, start: Vec3A, toward_light: Vec3A) -> Vec3 {
        if toward_light.z < 0.0 && self.backdrop.is_room() {
            return Vec3::ZERO;
        }
        self.scene.arriving(start, toward_light)
    }

    /// Light of a path that meets no object.
    fn at_no_object(&self, path: &mut Path, eye: &EyeRay, samples: &mut Samples) -> Step {
        if let Some(open) = path.open.take() {
            path.light += path.throughput * open;
            return Step::End;
        }
        let seen = if path.sees_backdrop {
            let depth = eye.ray.direction.length();
            let ray = Ray { origin: path.origin, direction: depth * path.direction };
            self.backdrop.ahead(&ray, eye)
        } else {
            self.backdrop.around(path.origin, path.direction)
        };
        match seen {
            BackdropHit::Light(light) => {
                path.light += path.throughput * light;
                Step::End
            }
            BackdropHit::Sky => {
                path.light += path.throughput * self.sky_met(path);
                Step::End
            }
            BackdropHit::Matte { point, normal, key, ambient, open } => {
                let start = off(point, normal);
                let toward_key = self.key.sample(samples.pair()).direction;
                path.light += path.throughput * key * self.arriving(start, toward_key);
                let (right, up) = normal.any_orthonormal_pair();
                if open.is_none() {
                    let reflected = |direction: Vec3A| {
                        let density = direction.dot(normal).max(0.0) * std::f32::consts::FRAC_1_PI;
                        (ambient * density, density)
                    };
                    path.light += path.throughput * self.sampled_lights(start, reflected, false, samples);
                }
                let l = cosine_direction(samples.pair());
                path.origin = start;
                path.direction = (l.x * right + l.y * up + l.z * normal).normalize();
                path.throughput *= ambient;
                path.density = Some(l.z * std::f32::consts::FRAC_1_PI);
                path.open = open;
                (path.meets_key, path.sees_backdrop, path.bends) = (false, false, false);
                Step::On
            }
        }
    }

    /// Light at infinity in a direction, weighted with the chance of having been sampled.
    fn sky_met(&self, path: &Path) -> Vec3 {
        let weight = |own: f32| path.density.map_or(1.0, |density| power(density, own));
        let sky = self.sky.radiance(&self.backdrop.environment, path.direction)
            * weight(self.sky.density(path.direction));
        let key = self.key.met(path.direction).filter(|_| path.meets_key);
        sky + key.map_or(Vec3::ZERO, |(radiance, own)| radiance * weight(own))
    }
}

/// A surface of glass as a path meets it.
struct GlassPassage {
    /// Refractive index behind it over that before it, where it bends the path.
    index: Option<f32>,
    /// Share that is mirrored.
    mirrored: f32,
    /// Direction of what is mirrored.
    toward: Vec3A,
}

impl GlassPassage {
    fn new(path: &Path, surface: &TracedSurface) -> Self {
        let leaves = !surface.is_front;
        // Glass in glass, such as water in a tumbler, has no interface; a sheet has two at once.
        let is_interface = path.inside == u32::from(leaves);
        let is_bent = path.bends && !surface.is_sheet;
        let index = if leaves { 1.0 / GLASS_INDEX } else { GLASS_INDEX };
        let cosine = -path.direction.dot(surface.normal);
        let mirrored = match is_bent {
            true if is_interface => glass::fresnel(cosine, index),
            true if path.inside > 0 => 0.0,
            _ => 1.0 - glass::passing(surface.flat_normal.dot(path.direction).abs(), surface.is_sheet),
        };
        let mut toward = glass::mirrored(path.direction, surface.normal);
        if toward.dot(surface.flat_normal) <= 0.0 {
            toward = glass::mirrored(path.direction, surface.flat_normal);
        }
        let index = (is_bent && is_interface).then_some(index);
        Self { index, mirrored, toward: toward.normalize() }
    }
}

/// Weight of a sample of density `own` beside one of density `other` (Veach's power heuristic).
fn power(own: f32, other: f32) -> f32 {
    if other <= 0.0 {
        return 1.0;
    }
    // By the ratio: squares of narrow lobes would overflow.
    let ratio = other / own.max(1e-20);
    1.0 / (1.0 + ratio * ratio)
}
