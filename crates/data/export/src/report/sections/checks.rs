//! Table of the checks of the whole scene: measurement, requirement and verdict.

use crate::report::Report;
use crate::report::numbers::{at_most, degrees, mm, percent, significant, word};
use certificate::{BodyHealth, Fidelity, ObjectCertificate, ReasonCode};
use markup::html::{Cell, Html};

pub fn write(page: &mut Html, report: &Report<'_>) {
    let mut rows = poses(report);
    rows.extend(bodies(report));
    rows.extend(likeness(report));
    let tolerance = "names, numbers of hulls and labels equal; differences within the tolerances below";
    let parity = report.round_trip;
    let worst = [parity.usd, parity.urdf, parity.mjcf, parity.sdf]
        .iter()
        .map(|format| format.translation_m.max(format.hull_corner_m).max(format.center_of_mass_m))
        .fold(parity.glb.vertex_m, f64::max);
    rows.push(vec![
        Cell::Words("Every format has the same bodies".into()),
        Cell::Words(format!("5 formats, lengths differ by {} m", at_most(worst))),
        Cell::Words(tolerance.into()),
        Cell::Mark(true),
    ]);
    page.table("checks", &["Check", "Measured", "Asked", "Verdict"], rows);
}

/// Table of the colliding pairs.
pub fn collisions(page: &mut Html, report: &Report<'_>) {
    let rows = report.certificate.collisions.iter().map(|pair| {
        vec![Cell::Body(pair.a.clone()), Cell::Body(pair.b.clone()), Cell::Bad(mm(pair.depth_m))]
    });
    page.table("", &["One", "The other", "Depth"], rows.collect());
}

/// One check. It passes if the certificate has no reason with its code.
fn row(report: &Report<'_>, code: ReasonCode, check: &str, measured: String, asked: String) -> Vec<Cell> {
    let failed = report.certificate.reasons.iter().any(|reason| reason.code == code);
    vec![Cell::Words(check.to_owned()), Cell::Words(measured), Cell::Words(asked), Cell::Mark(!failed)]
}

/// A measurement without a requirement.
fn report_only(check: &str, measured: String, why: &str) -> Vec<Cell> {
    vec![
        Cell::Words(check.to_owned()),
        Cell::Words(measured),
        Cell::Words(why.to_owned()),
        Cell::Words("reported".into()),
    ]
}

fn poses(report: &Report<'_>) -> Vec<Vec<Cell>> {
    let certificate = report.certificate;
    let (metrics, limits, objects) = (&certificate.metrics, &certificate.thresholds, &certificate.objects);
    let of = |count: usize| format!("{count} of {}", objects.len());
    let depth = match certificate.collisions.iter().map(|pair| pair.depth_m).fold(0.0, f64::max) {
        0.0 => String::new(),
        deepest => format!(", the deepest by {}", mm(deepest)),
    };
    let min_over_objects = |value: fn(&ObjectCertificate) -> Option<f64>| {
        let values: Option<Vec<f64>> = objects.iter().map(value).collect();
        values.map(|values| values.into_iter().fold(f64::INFINITY, f64::min)).filter(|min| min.is_finite())
    };
    let supported = objects.iter().filter(|o| o.support_margin_m.is_some_and(|margin| margin >= 0.0)).count();
    let margin = min_over_objects(|object| object.support_margin_m)
        .map_or(String::new(), |margin| format!(", least margin {}", mm(margin)));
    let stays =
        |share: f64| format!("{} ({})", of((share * objects.len() as f64).round() as usize), percent(share));
    let restless = certificate.reasons.iter().filter(|reason| reason.code == ReasonCode::NotAtRest).count();
    let largest = |value: fn(&ObjectCertificate) -> f64| objects.iter().map(value).fold(0.0, f64::max);
    let rest = format!(
        "{}, moved by {} and overlapping by {} at most",
        of(objects.len().saturating_sub(restless)),
        mm(largest(|object| object.moved.after_shipping.distance_m)),
        mm(largest(|object| object.overlap_m)),
    );
    let rest_asked = format!(
        "each moves and overlaps less than {} of its smallest side and turns less than {} in {} s of gravity",
        percent(limits.rest_side_share),
        degrees(limits.rest_rotation_rad),
        limits.dss_duration_s
    );
    let dss = format!(
        "share of objects that stay within {} and {} of the shipped poses, as the paper counts",
        mm(limits.dss_displacement_m),
        degrees(limits.dss_rotation_rad)
    );
    let edge = min_over_objects(|object| Some(object.outline_margin_m))
        .map_or(String::new(), |margin| format!(", least margin {}", mm(margin)));
    let inside = objects.iter().filter(|object| object.inside_outline).count();
    vec![
        row(
            report,
            ReasonCode::Collision,
            "No pair of bodies collides (Col_S, Col_O)",
            format!(
                "{} of {} pairs ({}){depth}",
                certificate.collisions.len(),
                certificate.pairs,
                percent(metrics.col_o)
            ),
            format!(
                "none deeper than {} or {} of the wall",
                mm(limits.penetration_m),
                percent(limits.wall_share)
            ),
        ),
        row(
            report,
            ReasonCode::NotSupported,
            "Every object is supported from below (SS)",
            format!("{} ({}){margin}", of(supported), percent(metrics.ss)),
            format!(
                "center of mass above the contacts (gaps up to {}), widened by {}",
                mm(limits.contact_gap_m),
                mm(limits.support_dilation_m)
            ),
        ),
        row(report, ReasonCode::NotAtRest, "Every object rests under gravity", rest, rest_asked),
        report_only("Dynamic stability (DSS as shipped)", stays(metrics.dss_shipped), &dss),
        report_only(
            "Dynamic stability from the aligned poses (DSS as aligned)",
            stays(metrics.dss_aligned),
            "the result of the layout alone; the paper's figure compares with this",
        ),
        row(
            report,
            ReasonCode::OverTheEdge,
            "No object reaches over the edge of the table",
            format!("{}{edge}", of(inside)),
            format!("no hull reaches over the outline by more than {}", mm(limits.outline_m)),
        ),
    ]
}

fn bodies(report: &Report<'_>) -> Vec<Vec<Cell>> {
    let (bodies, limits) = (&report.certificate.bodies, &report.certificate.thresholds.health);
    let range = |value: fn(&BodyHealth) -> f64| {
        bodies
            .iter()
            .map(value)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let closed = bodies.iter().filter(|body| body.watertight).count();
    let sides = range(|body| body.size_m.into_iter().fold(0.0, f64::max));
    let densities = range(|body| body.density_kg_m3);
    let friction = report
        .bodies
        .iter()
        .map(|body| body.friction.static_coefficient)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let between = |(low, high): (f64, f64), unit: &str| {
        format!("{} to {} {unit}", significant(low), significant(high)).trim_end().to_owned()
    };
    let pair = |[low, high]: [f64; 2]| (low, high);
    vec![
        row(
            report,
            ReasonCode::OpenMesh,
            "Every mesh is closed",
            format!("{closed} of {}", bodies.len()),
            "every edge has a face on either side".into(),
        ),
        row(
            report,
            ReasonCode::MissingCollider,
            "Hulls cover their mesh",
            format!("at most {} outside", mm(range(|body| body.uncovered_m).1)),
            format!(
                "at most {}, or {} of its longest side",
                mm(limits.uncovered_m),
                percent(limits.uncovered_share)
            ),
        ),
        row(
            report,
            ReasonCode::ProtrudingCollider,
            "Hulls do not stick out",
            format!("at most {}", mm(range(|body| body.hull_excess_m).1)),
            format!("at most {}", mm(limits.hull_excess_m)),
        ),
        row(
            report,
            ReasonCode::ClosedOpening,
            "Hulls leave openings open",
            format!("at least {}", percent(range(|body| body.hull_fit.open_share).0)),
            format!("at least {}", percent(limits.open_share)),
        ),
        // Without it there is no certificate.
        vec![
            Cell::Words("Longest sides are those of objects on tables".into()),
            Cell::Words(format!("longest sides {}", between(sides, "m"))),
            Cell::Words(between(pair(limits.longest_side_m), "m")),
            Cell::Mark(true),
        ],
        row(
            report,
            ReasonCode::ImplausibleDensity,
            "Densities are those of solid objects",
            between(densities, "kg/m³"),
            between(pair(limits.density_kg_m3), "kg/m³"),
        ),
        row(
            report,
            ReasonCode::ImplausibleFriction,
            "Friction coefficients are those of surfaces",
            format!("static {}", between(friction, "")),
            format!("0 to {}, dynamic no more than static", significant(limits.friction)),
        ),
    ]
}

fn likeness(report: &Report<'_>) -> Vec<Vec<Cell>> {
    let certificate = report.certificate;
    let fidelity = &certificate.fidelity;
    let (appearance, limits) = (&fidelity.appearance, &certificate.thresholds);
    let percent_of = |share: f64| percent((1e3 * share).round() / 1e3);
    let scale = match certificate.scale_error {
        Some(share) => format!("standard error {}", percent(share)),
        None => "given, or set by one object".to_owned(),
    };
    // The three limits share one code; each row is judged by its own.
    let judged = |check: &str, measured: String, limit: String, holds: bool| {
        let limit = match fidelity.is_judged {
            true => limit,
            false => format!("{limit}, if the image were given; the program rendered this one"),
        };
        let verdict = if fidelity.is_judged { Cell::Mark(holds) } else { Cell::Words("reported".into()) };
        vec![Cell::Words(check.to_owned()), Cell::Words(measured), Cell::Words(limit), verdict]
    };
    vec![
        judged(
            "Silhouettes agree with the reference image",
            format!("mean intersection over union {:.3}", fidelity.silhouette_iou),
            format!("at least {}", limits.silhouette_iou),
            fidelity.silhouette_iou >= limits.silhouette_iou,
        ),
        judged(
            "The scene shows the objects of the reference image",
            format!("{} of their pixels are missed", percent_of(fidelity.missed.share)),
            format!("at most {}", percent(limits.missed_share)),
            fidelity.missed.share <= limits.missed_share,
        ),
        judged(
            "The reference image shows the objects of the scene",
            format!("{} of their pixels are invented", percent_of(fidelity.invented.share)),
            format!("at most {}", percent(limits.invented_share)),
            fidelity.invented.share <= limits.invented_share,
        ),
        report_only(
            "Colors where scene and reference image show the same object",
            match fidelity.color_difference {
                Some(apart) => format!("mean CIELAB difference {apart:.1}"),
                None => "no object shows in its place".to_owned(),
            },
            "the difference of their light is part of it",
        ),
        report_only("Methods of reconstruction", methods(fidelity), "objects by method"),
        report_only(
            "Features of scene and reference image",
            format!("similarity {:.3}", appearance.similarity),
            &format!(
                "scores of {} ({}) compare with each other only",
                appearance.extractor, appearance.model
            ),
        ),
        report_only(
            "Sizes and boxes of the objects give the same scale",
            scale,
            "the disagreement of the objects",
        ),
    ]
}

fn methods(fidelity: &Fidelity) -> String {
    let each = fidelity
        .methods
        .iter()
        .map(|made| format!("{} {} ({})", made.objects, word(made.method), percent(made.share)));
    each.collect::<Vec<_>>().join(", ")
}
