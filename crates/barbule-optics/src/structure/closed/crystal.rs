//! Crystals as rods in a body, and the flat crystal whose rods are those.

use super::{Band, Beneath, Closing, GAP_UM, inner, points, raised};
use crate::material::Table;
use crate::structure::BuriedCircle;
use crate::structure::crystal::CrystalLayer;
use crate::structure::lattice::{Circle, Lattice, Rod, TOUCHING_UM};
use crate::structure::section::{Inclusion, Loop, Medium, Polyline, Section, refuse};
use crate::{Complex64, Result};

/// How thick the host of a crystal is, µm.
const HOST_UM: f64 = 4.0;

/// How far under the rods the absorbing regions begin, µm.
const UNDER_RODS_UM: f64 = 0.1;

/// k of the absorbing host, deep.
pub const ABSORPTION: f64 = 0.1;

/// It rises to that by these parts, which are sums of binomial coefficients …
pub const RAMP: [f64; 4] = [0.125, 0.5, 0.875, 1.0];

/// … every so many µm, a quarter of the wave in keratin in the middle of the spectrum: what one step sends back the next ones take away.
pub const RAMP_STEP_UM: f64 = 0.08;

/// Rods that touch are made smaller by this, µm.
pub(super) const SHRUNK_UM: f64 = 0.001;

/// Rods farther apart along x than this are not compared, µm.
const NEAR_UM: f64 = 2.0;

/// A rod of which less than this is left in a flat crystal has no part in it.
const LEAST_SCALE: f64 = 1e-3;

impl Closing {
    /// The host, 4 µm thick, with every rod that keeps its distance, and what is beneath them; and the flat crystal whose rods are as
    /// large as those, where some became smaller.
    pub(super) fn crystal(&mut self, section: &Section, beneath: Beneath) -> Result<Option<Lattice>> {
        let Some(layer) = &section.crystal else { return Ok(None) };
        let upper = points(section.top());
        let host = &section.media[1];
        let body = Band { lower: raised(&upper, -HOST_UM), upper };
        self.push(&body, host);
        let floor_um = layer.lattice.bottom_um() + UNDER_RODS_UM;
        let ramp_um = RAMP_STEP_UM * RAMP.len() as f64;
        if beneath == Beneath::Absorbing && floor_um + 2.0 * ramp_um < HOST_UM {
            self.absorbing(section, &body, floor_um)?;
            self.changes.push(format!(
                "{floor_um:.2} µm under the top the host absorbs more and more, up to k = {ABSORPTION}, and ends at {HOST_UM} µm"
            ));
        } else {
            self.changes.push(format!("the host ends {HOST_UM} µm under the top"));
        }
        self.rods(section, layer, &body)
    }

    /// The host under the rods, absorbing more in each ring of the one around.
    fn absorbing(&mut self, section: &Section, body: &Band, floor_um: f64) -> Result<()> {
        let mut bands = vec![body.clone()];
        let mut top = lowered_along_normals(section.top(), floor_um);
        for (step, part) in RAMP.iter().enumerate() {
            let medium = self.absorber(section, step + 1, part * ABSORPTION)?;
            let within =
                |host: &Band| inner(host, &top, &raised(&host.lower, RAMP_STEP_UM), RAMP_STEP_UM, &mut 0.0);
            bands = bands.iter().flat_map(within).collect();
            for band in &bands {
                self.push(band, &medium);
            }
            top = raised(&top, -RAMP_STEP_UM);
        }
        Ok(())
    }

    fn absorber(&mut self, section: &Section, number: usize, k: f64) -> Result<Medium> {
        let Medium::Pure(host) = &section.media[1] else {
            return refuse("the host of a crystal must be one medium".into());
        };
        let material = section.material(host)?;
        let rows: Vec<(f64, Complex64)> = (300..=830)
            .map(f64::from)
            .filter_map(|nm| material.index(nm).ok().map(|n| (nm, n + Complex64::new(0.0, k))))
            .collect();
        let name = format!("absorbing-host-{number}");
        let table = Table::new(&name, &rows).map_err(|error| error.at("the host of the crystal"))?;
        self.library.insert_table(&name, table)?;
        Ok(Medium::named(&name))
    }

    fn rods(&mut self, section: &Section, layer: &CrystalLayer, body: &Band) -> Result<Option<Lattice>> {
        let circles = layer.circles(section.top());
        // The outermost circle of each rod decides whether it stays and how far it shrinks.
        let outer: Vec<&BuriedCircle> = circles.iter().filter(|circle| circle.circle == 0).collect();
        let scales = scales(section.top(), body, &outer);
        let mut rod = 0;
        for circle in &circles {
            rod += usize::from(circle.circle == 0);
            let scale = scales[rod - 1];
            if scale == 0.0 {
                continue;
            }
            let substance = &layer.lattice.rods[circle.rod].circles[circle.circle].medium;
            let (x_um, z_um) = (circle.x_um, circle.z_um);
            self.inclusions.push(Inclusion {
                outline: Loop::Circle { x_um, z_um, radius_um: scale * circle.radius_um },
                medium: Medium::Pure(substance.clone()),
                holes: Vec::new(),
            });
        }
        let cut = scales.iter().filter(|scale| **scale == 0.0).count();
        if cut > 0 {
            self.changes.push(format!("{cut} rods next to the ends, or half in another one, are left out"));
        }
        let shrunk = scales.iter().filter(|scale| **scale > 0.0 && **scale < 1.0).count();
        if shrunk > 0 {
            let area = |circle: &BuriedCircle| circle.radius_um * circle.radius_um;
            let all: f64 = outer.iter().map(|circle| area(circle)).sum();
            let left: f64 =
                outer.iter().zip(&scales).map(|(circle, scale)| scale * scale * area(circle)).sum();
            self.changes.push(format!(
                "{shrunk} rods that would touch are smaller, and keep {:.1} % of all rods' area; the flat crystal's rods are as small, row by row",
                1e2 * left / all
            ));
        }
        let flat = as_kept(&layer.lattice, section.width_um, &outer, &scales);
        if flat.as_ref().is_some_and(|lattice| lattice.rods.is_empty()) {
            return refuse(
                "no rod of the crystal keeps its place under so curved a top; make it flatter".into(),
            );
        }
        Ok(flat)
    }
}

/// By which factor each rod shrinks to keep clear of its neighbours; 0 for those that are left out.
fn scales(top: &Polyline, body: &Band, outer: &[&BuriedCircle]) -> Vec<f64> {
    let [left, right] = body.ends();
    let stays = |circle: &BuriedCircle| {
        let room = (circle.x_um - left).min(right - circle.x_um) - circle.radius_um;
        let under = distance(top, [circle.x_um, circle.z_um]) - circle.radius_um;
        room >= GAP_UM && under >= 0.5 * GAP_UM
    };
    let apart = |a: &BuriedCircle, b: &BuriedCircle| libm::hypot(a.x_um - b.x_um, a.z_um - b.z_um);
    let is_near = |a: &BuriedCircle, b: &BuriedCircle| (a.x_um - b.x_um).abs() < NEAR_UM;
    // Under hills of the top its normals converge, and rods come closer than in the flat crystal: of two that would be half
    // in each other one is enough.
    let mut kept: Vec<&BuriedCircle> = Vec::new();
    let mut stay = Vec::with_capacity(outer.len());
    for &circle in outer {
        let mut near = kept.iter().filter(|other| is_near(other, circle));
        let is_alone = near.all(|other| apart(other, circle) > 0.5 * (other.radius_um + circle.radius_um));
        stay.push(is_alone && stays(circle));
        if is_alone && stays(circle) {
            kept.push(circle);
        }
    }
    let scale = |circle: &BuriedCircle| {
        let near = kept.iter().filter(|other| is_near(other, circle));
        near.map(|other| {
            let (apart, sum) = (apart(other, circle), other.radius_um + circle.radius_um);
            let is_clear = apart == 0.0 || apart >= sum + TOUCHING_UM.max(2.0 * SHRUNK_UM);
            if is_clear { 1.0 } else { (apart.min(sum) - 2.0 * SHRUNK_UM) / sum }
        })
        .fold(1.0, f64::min)
    };
    outer.iter().zip(&stay).map(|(circle, stays)| if *stays { scale(circle) } else { 0.0 }).collect()
}

/// The flat crystal whose rods have, row by row, the mean area of those that are there; `None` where all rods are whole. The mean is that
/// over the middle half of the width, on which 95 % of a beam's power falls, and a rod that is left out has no area.
fn as_kept(lattice: &Lattice, width_um: f64, outer: &[&BuriedCircle], scales: &[f64]) -> Option<Lattice> {
    let mean = |row: usize, rod: usize, half_um: f64| -> Option<f64> {
        let of_this =
            |circle: &BuriedCircle| (circle.row, circle.rod) == (row, rod) && circle.x_um.abs() <= half_um;
        let found = outer.iter().zip(scales).filter(|(circle, _)| of_this(circle));
        let (count, sum) = found.fold((0.0, 0.0), |(n, sum), (_, scale)| (n + 1.0, sum + scale * scale));
        (count > 0.0).then(|| libm::sqrt(sum / count))
    };
    let mut is_whole = true;
    let mut rods = Vec::new();
    for placed in lattice.placed() {
        let of = |half_um: f64| mean(placed.row, placed.rod, half_um);
        let scale = of(0.25 * width_um).or_else(|| of(f64::INFINITY)).unwrap_or(0.0);
        is_whole &= scale == 1.0;
        if scale < LEAST_SCALE {
            continue;
        }
        let circles = lattice.rods[placed.rod]
            .circles
            .iter()
            .map(|circle| Circle { diameter_um: scale * circle.diameter_um, medium: circle.medium.clone() });
        rods.push(Rod {
            x_um: placed.x_um,
            z_um: placed.depth_um - lattice.depth_to_center_um,
            rows: None,
            circles: circles.collect(),
        });
    }
    (!is_whole).then(|| Lattice { rows: 1, row_shift: 0.0, rods, ..lattice.clone() })
}

/// A curve `depth_um` under another, along its normals, with x rising.
fn lowered_along_normals(curve: &Polyline, depth_um: f64) -> Vec<[f64; 2]> {
    let shifted = crate::structure::offset::under(curve, &vec![depth_um; curve.x_um.len()]);
    points(&shifted)
}

fn distance(curve: &Polyline, at: [f64; 2]) -> f64 {
    let near = curve.x_um.partition_point(|&x| x < at[0] - 2.0).saturating_sub(1);
    let pairs = points(curve);
    pairs[near..]
        .windows(2)
        .take_while(|pair| pair[0][0] <= at[0] + 2.0)
        .map(|pair| {
            let (dx, dz) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let along = ((at[0] - pair[0][0]) * dx + (at[1] - pair[0][1]) * dz) / (dx * dx + dz * dz);
            let t = along.clamp(0.0, 1.0);
            libm::hypot(at[0] - pair[0][0] - t * dx, at[1] - pair[0][1] - t * dz)
        })
        .fold(f64::INFINITY, f64::min)
}
