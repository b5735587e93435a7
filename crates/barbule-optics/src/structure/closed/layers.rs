//! Layers as rings in rings, or as slabs that what is around parts.

use std::f64::consts::PI;

use super::{Band, Closing, GAP_UM, inner, label, mean_gap, points, raised};
use crate::Result;
use crate::structure::section::{Medium, Section, refuse};

/// What lies under layers that light comes back from, once through and once back, with less than this part of its power is left out.
const HIDDEN: f64 = 0.05;

/// Where that is looked at, nm.
const SEEN_NM: [f64; 7] = [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0];

/// Where nothing lies above or below a slab within this, its faces give way to nothing, µm.
const FREE_UM: f64 = 1.0;

/// The boundaries of a section's layers.
type Curves = Vec<Vec<[f64; 2]>>;

impl Closing {
    /// The outline of a section with the walls' thickness: as thick as the cortex.
    pub(super) fn body(&mut self, section: &Section) -> Result<()> {
        let curves = curves(section)?;
        let body = Band { upper: curves[0].clone(), lower: curves[curves.len() - 1].clone() };
        self.push(&body, &section.media[1]);
        self.rings(section, &curves, [0, curves.len() - 1], vec![body]);
        self.inclusions.extend(section.inclusions.iter().cloned());
        self.changes.push(format!("its ends are closed by walls of {}", label(&section.media[1])));
        Ok(())
    }

    /// What the medium around parts, as bodies of their own in it.
    pub(super) fn slabs(&mut self, section: &Section) -> Result<()> {
        let curves = curves(section)?;
        let around = &section.media[0];
        let (mut names, mut walls): (Vec<String>, Option<String>) = (Vec::new(), None);
        for [top, bottom] in parted(&section.media) {
            let medium = &section.media[top + 1];
            let whole = Band { upper: curves[top].clone(), lower: curves[bottom].clone() };
            let bodies = if top == 0 {
                vec![whole]
            } else {
                // The slab above may come near.
                let room = Band { upper: curves[top - 1].clone(), lower: raised(&whole.lower, -FREE_UM) };
                let mut moved_um = 0.0;
                let bodies = inner(&room, &whole.upper, &whole.lower, 0.0, &mut moved_um);
                self.say_moved(medium, moved_um);
                bodies
            };
            for body in &bodies {
                self.push(body, medium);
            }
            names.push(label(medium));
            if bottom - top > 1 {
                walls.get_or_insert_with(|| label(medium));
                self.rings(section, &curves, [top, bottom], bodies);
            }
        }
        self.inclusions.extend(section.inclusions.iter().cloned());
        self.changes.push(match walls {
            Some(walls) => format!("its innermost layers end at walls of {walls}"),
            None => format!("{} end freely in {}", names.join(" and "), label(around)),
        });
        Ok(())
    }

    /// What lies between the next boundaries, ring in ring, within bodies between two of them.
    fn rings(
        &mut self,
        section: &Section,
        curves: &Curves,
        [mut top, mut bottom]: [usize; 2],
        bodies: Vec<Band>,
    ) {
        let cortex_um = if bottom - top > 1 { mean_gap(&curves[top], &curves[top + 1]) } else { 0.0 };
        let mut bands = bodies;
        let mut walls_um = cortex_um.max(GAP_UM);
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
            self.say_moved(medium, moved_um);
            walls_um = GAP_UM;
            for band in &bands {
                self.push(band, medium);
            }
        }
    }

    fn say_moved(&mut self, medium: &Medium, moved_um: f64) {
        if moved_um > 0.5e-3 {
            self.changes.push(format!(
                "{} keeps {:.0} nm from the boundaries around it, and is thinner by up to {:.1} nm for it",
                label(medium),
                1e3 * GAP_UM,
                1e3 * moved_um
            ));
        }
    }

    /// Takes off what touches the last slab from below and would need a gap, where hardly any light comes back from there.
    pub(super) fn leave_out_hidden(&mut self, section: &mut Section) -> Result<()> {
        curves(section)?;
        // An inclusion may lie in what is left out.
        let Some([top, mut bottom]) = parted(&section.media).pop().filter(|_| section.inclusions.is_empty())
        else {
            return Ok(());
        };
        let is_ring = |bottom: usize| section.media[bottom] == section.media[top + 1];
        while !is_ring(bottom) && returned(section, bottom - 1)? < HIDDEN {
            self.changes.push(format!(
                "the {} under {} is left out on both sides: {:.1} % of the light, at most, comes back through that",
                label(&section.media[bottom]),
                label(&section.media[bottom - 1]),
                1e2 * returned(section, bottom - 1)?
            ));
            bottom -= 1;
        }
        section.boundaries.truncate(bottom + 1);
        section.media.truncate(bottom + 1);
        let around = section.media[0].clone();
        section.media.push(around);
        Ok(())
    }
}

/// The boundaries of a section whose layers have a body in the medium around.
fn curves(section: &Section) -> Result<Curves> {
    if section.media[section.media.len() - 1] != section.media[0] {
        return refuse(
            "full waves are computed for barbules in air: the last medium must be the first one".into(),
        );
    }
    if section.boundaries.len() < 2 {
        return refuse("full waves need a bottom: give at least two boundaries".into());
    }
    Ok(section.boundaries.iter().map(points).collect())
}

/// Upper and lower boundary of each run of layers that the first medium parts: medium k lies between boundaries k − 1 and k.
fn parted(media: &[Medium]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (k, _) in media.iter().enumerate().filter(|(_, medium)| **medium != media[0]) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == k => run[1] = k,
            _ => runs.push([k - 1, k]),
        }
    }
    runs
}

/// The largest part of the power, over visible wavelengths, that is left after a way at normal incidence down to a boundary and back up.
fn returned(section: &Section, boundary: usize) -> Result<f64> {
    let mut most = 0.0_f64;
    for nm in SEEN_NM {
        let mut depth = 0.0;
        for k in 1..=boundary {
            let Medium::Pure(substance) = &section.media[k] else { return Ok(1.0) };
            let index = section.material(substance)?.index(nm)?;
            let [above, below] = [k - 1, k].map(|b| points(&section.boundaries[b]));
            depth += 4.0 * PI * index.im * mean_gap(&above, &below) / (1e-3 * nm);
        }
        most = most.max(libm::exp(-2.0 * depth));
    }
    Ok(most)
}
