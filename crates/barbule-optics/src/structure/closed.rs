//! Layered and lattice sections made of closed regions alone, for solvers that take nothing else.
//!
//! Nothing meets in a point: layers become rings in rings. The body is the outline of the first medium under the top, closed by
//! walls of it; in it lies the next layer between its two boundaries, and so on inwards, so that interfaces along normals are the
//! layers' own. Where the media are not the same above and below, the lower end of a layer keeps a gap of its host.

use super::lattice::TOUCHING_UM;
use super::section::{Inclusion, Loop, Medium, Parts, Polyline, Section, Substance, refuse};
use crate::material::{Library, Table};
use crate::{Complex64, Result};

/// Regions stay this far from their hosts' other boundaries, µm.
pub const GAP_UM: f64 = 0.010;

/// How thick the host of a crystal is, µm.
const HOST_UM: f64 = 4.0;

/// How far under the rods the absorbing region begins, µm.
const UNDER_RODS_UM: f64 = 0.1;

/// k of the absorbing region.
const ABSORPTION: f64 = 0.05;

/// Rods that touch are made smaller by this, µm.
const SHRUNK_UM: f64 = 0.001;

/// The name of the absorbing medium.
const ABSORBER: &str = "absorbing-host";

/// What lies under a crystal's rods, where the fast simulation has a half-space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beneath {
    /// The host with k = 0.05: its bottom reflects less than 0.1 %.
    #[default]
    Absorbing,
    /// The host alone, down to its bottom.
    Host,
}

/// A section in closed regions, and what both kinds of solvers compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed {
    /// Of inclusions alone.
    pub regions: Section,
    /// The section for the fast simulation: mixtures are as uniform as in the regions.
    pub fast: Section,
    /// What is not as it was, in sentences.
    pub changes: Vec<String>,
}

impl Section {
    /// This section as closed regions that do not touch.
    ///
    /// # Errors
    /// The last medium of a layered section is not air, or regions that cannot be told apart.
    pub fn closed(&self, beneath: Beneath) -> Result<Closed> {
        if self.boundaries.is_empty() {
            return Ok(Closed { regions: self.clone(), fast: self.clone(), changes: Vec::new() });
        }
        let mut closing =
            Closing { library: self.library.clone(), inclusions: Vec::new(), changes: Vec::new() };
        let fast = self.uniform(&mut closing)?;
        match &self.crystal {
            Some(_) => closing.crystal(self, beneath)?,
            None => closing.layers(&fast)?,
        }
        let Closing { library, inclusions, changes } = closing;
        let parts = Parts {
            name: self.name.clone(),
            width_um: Some(self.width_um),
            media: vec![self.media[0].clone()],
            inclusions,
            source: format!("{}, its regions closed", self.source),
            ..Parts::default()
        };
        let mut regions = Self::new(parts, library)?;
        regions.materials.clone_from(&self.materials);
        Ok(Closed { regions, fast, changes })
    }

    /// The same with mixtures as uniform as their mean and crystals as regular everywhere.
    fn uniform(&self, closing: &mut Closing) -> Result<Self> {
        let mut uniform = self.clone();
        let media = uniform.media.iter_mut().chain(uniform.inclusions.iter_mut().map(|i| &mut i.medium));
        for medium in media {
            if let Medium::Mixture { first, second, x_um, fraction } = medium {
                let mean = mean(x_um, fraction, self.width_um);
                let [a, b] = [&*first, &*second].map(Substance::label);
                let all = format!("mix({a},{b},{mean:.6})");
                // Indices have no names that expressions could hold.
                if [&*first, &*second].iter().any(|s| matches!(s, Substance::Index(_))) {
                    return refuse(format!("a mixture of {a} and {b} has no uniform mean; name both media"));
                }
                closing.changes.push(format!("the mixture of {a} and {b} is uniform: {mean:.3} of {b}"));
                *medium = Medium::Pure(Substance::Named(all));
            }
        }
        if uniform.crystal.as_mut().is_some_and(|crystal| crystal.regularity.take().is_some()) {
            closing.changes.push("the crystal is regular everywhere".into());
        }
        Ok(uniform)
    }
}

/// The mean of a fraction over the width.
fn mean(x_um: &[f64], fraction: &[f64], width_um: f64) -> f64 {
    const SAMPLES: u32 = 1000;
    let at = |i: u32| width_um * ((f64::from(i) + 0.5) / f64::from(SAMPLES) - 0.5);
    let sum: f64 = (0..SAMPLES).map(|i| super::section::profile(x_um, fraction, at(i))).sum();
    sum / f64::from(SAMPLES)
}

struct Closing {
    library: Library,
    inclusions: Vec<Inclusion>,
    changes: Vec<String>,
}

/// A region between an upper and a lower curve.
#[derive(Debug, Clone)]
struct Band {
    upper: Vec<[f64; 2]>,
    lower: Vec<[f64; 2]>,
}

impl Band {
    fn ends(&self) -> [f64; 2] {
        [self.upper[0][0], self.upper[self.upper.len() - 1][0]]
    }

    fn outline(&self) -> Loop {
        let points = self.upper.iter().chain(self.lower.iter().rev());
        let (x_um, z_um) = points.map(|p| (p[0], p[1])).unzip();
        Loop::polygon(x_um, z_um)
    }
}

impl Closing {
    /// The outline of a section with the walls' thickness: as thick as the cortex.
    fn layers(&mut self, section: &Section) -> Result<()> {
        let last = section.media.len() - 1;
        if section.media[last] != section.media[0] {
            return refuse(
                "full waves are computed for barbules in air: the last medium must be the first one".into(),
            );
        }
        let curves: Vec<Vec<[f64; 2]>> = section.boundaries.iter().map(points).collect();
        if curves.len() < 2 {
            return refuse("full waves need a bottom: give at least two boundaries".into());
        }
        let body = Band { upper: curves[0].clone(), lower: curves[curves.len() - 1].clone() };
        let mut bottom = curves.len() - 1;
        let mut top = 0;
        self.push(&body, &section.media[1]);
        let cortex_um = if curves.len() > 2 { mean_gap(&curves[0], &curves[1]) } else { 0.0 };
        let mut bands = vec![body];
        let mut walls_um = cortex_um.max(GAP_UM);
        // Rings inwards: what lies between the next boundaries, in its host.
        while bottom - top > 1 {
            let host = &section.media[top + 1];
            let is_ring = section.media[bottom] == *host;
            if is_ring && bottom - top == 2 {
                // The same medium above and below one line.
                break;
            }
            top += 1;
            let lower = if is_ring {
                bottom -= 1;
                curves[bottom].clone()
            } else {
                raised(&curves[bottom], GAP_UM)
            };
            let medium = &section.media[top + 1];
            if !is_ring {
                self.changes.push(format!(
                    "{} keeps {:.0} nm of {} under it",
                    label(medium),
                    1e3 * GAP_UM,
                    label(host)
                ));
            }
            let mut moved_um = 0.0_f64;
            let within = |host: &Band| inner(host, &curves[top], &lower, walls_um, &mut moved_um);
            bands = bands.iter().flat_map(within).collect();
            if moved_um > 0.5e-3 {
                self.changes.push(format!(
                    "{} keeps {:.0} nm from the boundaries around it, and is thinner by up to {:.1} nm for it",
                    label(medium),
                    1e3 * GAP_UM,
                    1e3 * moved_um
                ));
            }
            walls_um = GAP_UM;
            for band in &bands {
                self.push(band, medium);
            }
        }
        self.inclusions.extend(section.inclusions.iter().cloned());
        self.changes.push(format!("its ends are closed by walls of {}", label(&section.media[1])));
        Ok(())
    }

    fn push(&mut self, band: &Band, medium: &Medium) {
        self.inclusions.push(Inclusion {
            outline: band.outline(),
            medium: medium.clone(),
            holes: Vec::new(),
        });
    }

    /// The host, 4 µm thick, with every rod that keeps its distance, and what is beneath them.
    fn crystal(&mut self, section: &Section, beneath: Beneath) -> Result<()> {
        let Some(layer) = &section.crystal else { return Ok(()) };
        let upper = points(section.top());
        let host = &section.media[1];
        let body = Band { lower: raised(&upper, -HOST_UM), upper };
        self.push(&body, host);
        let floor_um = layer.lattice.bottom_um() + UNDER_RODS_UM;
        if beneath == Beneath::Absorbing && floor_um + 10.0 * GAP_UM < HOST_UM {
            let top = lowered_along_normals(section.top(), floor_um);
            let bands = inner(&body, &top, &raised(&body.lower, GAP_UM), GAP_UM, &mut 0.0);
            let name = self.absorber(section, host)?;
            for band in &bands {
                self.push(band, &Medium::named(&name));
            }
            self.changes.push(format!(
                "{floor_um:.2} µm under the top the host absorbs with k = {ABSORPTION}, and ends at {HOST_UM} µm"
            ));
        } else {
            self.changes.push(format!("the host ends {HOST_UM} µm under the top"));
        }
        self.rods(section, &body)
    }

    fn absorber(&mut self, section: &Section, host: &Medium) -> Result<String> {
        let Medium::Pure(host) = host else {
            return refuse("the host of a crystal must be one medium".into());
        };
        let material = section.material(host)?;
        let rows: Result<Vec<(f64, Complex64)>> = (300..=830)
            .map(f64::from)
            .filter_map(|nm| material.index(nm).ok().map(|n| Ok((nm, n + Complex64::new(0.0, ABSORPTION)))))
            .collect();
        let table = Table::new(ABSORBER, &rows?).map_err(|error| error.at("the host of the crystal"))?;
        self.library.insert_table(ABSORBER, table)?;
        Ok(ABSORBER.to_owned())
    }

    fn rods(&mut self, section: &Section, body: &Band) -> Result<()> {
        let Some(layer) = &section.crystal else { return Ok(()) };
        let circles = layer.circles(section.top());
        let [left, right] = body.ends();
        // The outermost circle of each rod decides whether it stays and how far it shrinks.
        let outer: Vec<_> = circles.iter().filter(|circle| circle.circle == 0).collect();
        let stays = |circle: &super::BuriedCircle| {
            let room = (circle.x_um - left).min(right - circle.x_um) - circle.radius_um;
            let under = distance(section.top(), [circle.x_um, circle.z_um]) - circle.radius_um;
            room >= GAP_UM && under >= 0.5 * GAP_UM
        };
        // Under hills of the top its normals converge, and rods come closer than in the flat crystal: of two that would be half
        // in each other one is enough.
        let mut kept: Vec<&super::BuriedCircle> = Vec::new();
        let mut stay = Vec::with_capacity(outer.len());
        for &circle in &outer {
            let is_alone = kept.iter().filter(|other| (other.x_um - circle.x_um).abs() < 2.0).all(|other| {
                let apart = libm::hypot(other.x_um - circle.x_um, other.z_um - circle.z_um);
                apart > 0.5 * (other.radius_um + circle.radius_um)
            });
            stay.push(is_alone && stays(circle));
            if is_alone && stays(circle) {
                kept.push(circle);
            }
        }
        let scale = |circle: &super::BuriedCircle| {
            let near = kept.iter().filter(|other| (other.x_um - circle.x_um).abs() < 2.0);
            near.map(|other| {
                let apart = libm::hypot(other.x_um - circle.x_um, other.z_um - circle.z_um);
                let sum = other.radius_um + circle.radius_um;
                let is_clear = apart == 0.0 || apart >= sum + TOUCHING_UM.max(2.0 * SHRUNK_UM);
                if is_clear { 1.0 } else { (apart.min(sum) - 2.0 * SHRUNK_UM) / sum }
            })
            .fold(1.0, f64::min)
        };
        let scales: Vec<f64> =
            outer.iter().zip(&stay).map(|(circle, stays)| if *stays { scale(circle) } else { 0.0 }).collect();
        let cut = stay.iter().filter(|stays| !**stays).count();
        let shrunk = scales.iter().filter(|scale| **scale > 0.0 && **scale < 1.0).count();
        let mut rod = 0;
        for circle in &circles {
            rod += usize::from(circle.circle == 0);
            let scale = scales[rod - 1];
            if scale == 0.0 {
                continue;
            }
            let substance = &layer.lattice.rods[circle.rod].circles[circle.circle].medium;
            self.inclusions.push(Inclusion {
                outline: Loop::Circle {
                    x_um: circle.x_um,
                    z_um: circle.z_um,
                    radius_um: scale * circle.radius_um,
                },
                medium: Medium::Pure(substance.clone()),
                holes: Vec::new(),
            });
        }
        if cut > 0 {
            self.changes.push(format!("{cut} rods next to the ends, or half in another one, are left out"));
        }
        if shrunk > 0 {
            let area = |circle: &super::BuriedCircle| circle.radius_um * circle.radius_um;
            let all: f64 = outer.iter().map(|circle| area(circle)).sum();
            let left: f64 =
                outer.iter().zip(&scales).map(|(circle, scale)| scale * scale * area(circle)).sum();
            self.changes.push(format!(
                "{shrunk} rods that would touch are smaller; rods keep {:.1} % of their area",
                1e2 * left / all
            ));
        }
        Ok(())
    }
}

fn label(medium: &Medium) -> String {
    medium.substances().map(Substance::label).collect::<Vec<_>>().join(" and ")
}

fn points(curve: &Polyline) -> Vec<[f64; 2]> {
    curve.x_um.iter().zip(&curve.z_um).map(|(&x, &z)| [x, z]).collect()
}

fn raised(curve: &[[f64; 2]], by_um: f64) -> Vec<[f64; 2]> {
    curve.iter().map(|&[x, z]| [x, z + by_um]).collect()
}

/// A curve `depth_um` under another, along its normals, with x rising.
fn lowered_along_normals(curve: &Polyline, depth_um: f64) -> Vec<[f64; 2]> {
    let shifted = super::offset::under(curve, &vec![depth_um; curve.x_um.len()]);
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

/// The height of a curve at x.
fn height(curve: &[[f64; 2]], x: f64) -> f64 {
    let right = curve.partition_point(|p| p[0] <= x).clamp(1, curve.len() - 1);
    let (a, b) = (curve[right - 1], curve[right]);
    a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0]))
}

fn mean_gap(upper: &[[f64; 2]], lower: &[[f64; 2]]) -> f64 {
    let sum: f64 = upper.iter().map(|&[x, z]| z - height(lower, x)).sum();
    sum / upper.len() as f64
}

/// What of the region between two curves lies in a host, away from its walls and its other boundaries: one band, or several
/// where it is too thin in between. The gap is kept along z; `moved_um` learns by how much a curve gave way at most.
fn inner(
    host: &Band,
    upper: &[[f64; 2]],
    lower: &[[f64; 2]],
    walls_um: f64,
    moved_um: &mut f64,
) -> Vec<Band> {
    let [left, right] = host.ends();
    let (left, right) = (left + walls_um, right - walls_um);
    let mut grid: Vec<f64> = [upper, lower].iter().flat_map(|curve| curve.iter().map(|p| p[0])).collect();
    grid.extend([left, right]);
    grid.retain(|x| (left..=right).contains(x));
    grid.sort_by(f64::total_cmp);
    grid.dedup_by(|a, b| *a - *b < 1e-6);
    let heights = |x: f64| {
        let top = height(upper, x).min(height(&host.upper, x) - GAP_UM);
        let bottom = height(lower, x).max(height(&host.lower, x) + GAP_UM);
        [top, bottom]
    };
    let is_open = |x: f64| {
        let [top, bottom] = heights(x);
        top - bottom >= GAP_UM
    };
    let mut bands = Vec::new();
    for run in grid.chunk_by(|a, b| is_open(*a) == is_open(*b)) {
        if run.len() < 3 || !is_open(run[0]) {
            continue;
        }
        let [from, to] = [run[0], run[run.len() - 1]];
        let cut = |curve: &[[f64; 2]], side: usize| -> Vec<[f64; 2]> {
            let inside = curve.iter().map(|p| p[0]).filter(|x| from + 1e-4 < *x && *x < to - 1e-4);
            let xs = std::iter::once(from).chain(inside).chain(std::iter::once(to));
            xs.map(|x| [x, heights(x)[side]]).collect()
        };
        let band = Band { upper: cut(upper, 0), lower: cut(lower, 1) };
        let moved = band.upper.iter().map(|p| height(upper, p[0]) - p[1]);
        let moved = moved.chain(band.lower.iter().map(|p| p[1] - height(lower, p[0])));
        *moved_um = moved.fold(*moved_um, f64::max);
        bands.push(band);
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{Structure, species_names};

    /// Points over a section's width and height.
    fn grid(section: &Section) -> impl Iterator<Item = [f64; 2]> {
        let half = 0.5 * section.width_um;
        (0..400).flat_map(move |i| {
            let x = half * (2.0 * (f64::from(i) + 0.5) / 400.0 - 1.0);
            (0..300).map(move |k| [x, 1.5 - 10.0 * (f64::from(k) + 0.5) / 300.0])
        })
    }

    #[test]
    fn regions_are_the_layers_of_the_section() {
        for name in species_names() {
            for instance in [0, 3] {
                let section = Structure::builtin(name).unwrap().instance(1, instance).unwrap();
                let closed =
                    section.closed(Beneath::Absorbing).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert!(closed.regions.boundaries.is_empty() && closed.regions.width_um == section.width_um);
                if section.crystal.is_some() {
                    continue;
                }
                let inside = 0.5 * section.width_um - 0.7;
                let (mut same, mut all) = (0, 0);
                for [x, z] in grid(&section).filter(|[x, _]| x.abs() < inside) {
                    let (a, b) = (closed.fast.medium_at(x, z), closed.regions.medium_at(x, z));
                    // Air around is not counted.
                    if z < section.top().height(x)
                        && z > section.boundaries[section.boundaries.len() - 1].height(x)
                    {
                        all += 1;
                        same += usize::from(a == b);
                    }
                }
                assert!(same * 1000 >= all * 995, "{name} {instance}: {same} of {all} points are the same");
            }
        }
    }

    #[test]
    fn every_rod_of_a_crystal_is_there() {
        for name in ["mallard", "magpie", "peafowl"] {
            let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
            let layer = section.crystal.as_ref().unwrap();
            let circles = layer.circles(section.top()).len();
            for (beneath, more) in [(Beneath::Absorbing, 2), (Beneath::Host, 1)] {
                let closed = section.closed(beneath).unwrap();
                let left_out = circles + more - closed.regions.inclusions.len();
                assert!(left_out * 20 <= circles, "{name}: {left_out} of {circles}");
                assert!(closed.fast.crystal.as_ref().unwrap().regularity.is_none());
            }
            let touching = closed_changes(&section);
            // Hollow rods of the magpie touch everywhere.
            assert!(name != "magpie" || touching.contains("would touch"), "{touching}");
        }
    }

    /// Circles of closed crystals: centre, radius, medium.
    fn closed_circles(closed: &Closed) -> Vec<([f64; 2], f64, &Medium)> {
        let circle = |inclusion: &'_ Inclusion| match inclusion.outline {
            Loop::Circle { x_um, z_um, radius_um } => Some(([x_um, z_um], radius_um)),
            Loop::Polygon(_) => None,
        };
        let inclusions = closed.regions.inclusions.iter();
        inclusions.filter_map(|i| circle(i).map(|(centre, radius)| (centre, radius, &i.medium))).collect()
    }

    #[test]
    fn rods_keep_their_distance_and_their_media() {
        for name in ["mallard", "magpie", "peafowl"] {
            let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
            let closed = section.closed(Beneath::Absorbing).unwrap();
            let mut circles = closed_circles(&closed);
            circles.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            let (mut least_um, mut compared) = (f64::INFINITY, 0);
            for (i, (a, r, medium)) in circles.iter().enumerate() {
                let mut is_innermost = true;
                let near = |other: &&([f64; 2], f64, &Medium)| (other.0[0] - a[0]).abs() < 1.0;
                let others = circles[i + 1..].iter().take_while(near);
                for (b, q, _) in others.chain(circles[..i].iter().rev().take_while(near)) {
                    let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
                    // Beside each other, or one in the other.
                    let gap = if apart < r.max(*q) { (r - q).abs() - apart } else { apart - r - q };
                    least_um = least_um.min(gap);
                    compared += 1;
                    is_innermost &= apart >= *r || q > r;
                }
                if is_innermost {
                    assert_eq!(closed.regions.medium_at(a[0], a[1]), *medium, "{name}, rod at {a:?}");
                }
            }
            assert!(compared > circles.len() && least_um > 0.99 * 2.0 * SHRUNK_UM, "{name}: {least_um} µm");
            // Between the rods and the absorbing region is the host, around the body air.
            let [x, top] = [0.0, section.top().height(0.0)];
            assert_eq!(closed.regions.medium_at(x, top + 0.1), &section.media[0]);
            let at = closed.regions.medium_at(x, top - 0.5 * GAP_UM);
            assert_eq!(at, &section.media[1], "{name}");
            let deep = closed.regions.medium_at(x, top - HOST_UM + 0.2);
            assert_eq!(deep, &Medium::named(ABSORBER), "{name}");
        }
    }

    /// Crossings of vertical lines with all curves: they come in pairs, and no two are nearer than the gap.
    #[test]
    fn layers_keep_their_gap_along_z() {
        for name in ["starling", "rock-dove", "bronzewing"] {
            let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
            let closed = section.closed(Beneath::Absorbing).unwrap();
            let polygons: Vec<Polyline> =
                closed.regions.inclusions.iter().map(|inclusion| inclusion.outline.corners()).collect();
            let half = 0.5 * section.width_um - 0.5;
            let (mut least_um, mut layered) = (f64::INFINITY, 0);
            for i in 0..500 {
                let x = half * (2.0 * (f64::from(i) + 0.43) / 500.0 - 1.0);
                let mut z = Vec::new();
                for corners in &polygons {
                    let count = corners.x_um.len();
                    for (i, k) in (0..count).map(|i| (i, (i + 1) % count)) {
                        let (a, b) = (corners.x_um[i], corners.x_um[k]);
                        if (a > x) != (b > x) {
                            let t = (x - a) / (b - a);
                            z.push(corners.z_um[i] + t * (corners.z_um[k] - corners.z_um[i]));
                        }
                    }
                }
                z.sort_by(f64::total_cmp);
                assert!(z.len() >= 2 && z.len().is_multiple_of(2), "{name} at {x}: {z:?}");
                layered += usize::from(z.len() >= 4);
                least_um = z.windows(2).map(|pair| pair[1] - pair[0]).fold(least_um, f64::min);
            }
            assert!(layered > 400, "{name}: layers at {layered} of 500 places");
            assert!(least_um > 0.9 * GAP_UM, "{name}: {least_um} µm");
        }
    }

    fn closed_changes(section: &Section) -> String {
        section.closed(Beneath::Absorbing).unwrap().changes.join("; ")
    }

    #[test]
    fn interfaces_that_give_way_are_said_to() {
        let said = closed_changes(&Structure::builtin("bronzewing").unwrap().instance(1, 0).unwrap());
        assert!(said.contains("melanin keeps 10 nm from the boundaries around it"), "{said}");
        let said = closed_changes(&Structure::builtin("starling").unwrap().instance(1, 0).unwrap());
        assert!(!said.contains("keeps 10 nm from"), "{said}");
    }

    #[test]
    fn a_layer_without_its_like_below_keeps_a_gap() {
        let section = Structure::builtin("rock-dove").unwrap().instance(1, 0).unwrap();
        let said = closed_changes(&section);
        assert!(said.contains("keeps 10 nm of air under it"), "{said}");
        assert!(said.contains("uniform: 0.890"), "{said}");
        let open = Structure::flat("air/keratin:500/melanin").unwrap().instance(1, 0).unwrap();
        assert!(open.closed(Beneath::Absorbing).is_err());
    }
}
