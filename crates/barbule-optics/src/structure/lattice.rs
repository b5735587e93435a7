//! Photonic crystals: rods along y, periodic in x, a few rows deep, in a host below a flat surface.

use std::ops::RangeInclusive;

use super::section::{Substance, material};
use crate::fields::{shown, typed_in_nm};
use crate::material::{Library, Material};
use crate::{Error, Result};

/// Rods may overlap by this much, µm, and count as touching.
pub const TOUCHING_UM: f64 = 1e-5;

/// A period has no more rods than this, over all rows.
pub const MOST_RODS: usize = 200;

/// Lengths that can be meant, µm.
const LENGTHS_UM: RangeInclusive<f64> = 1e-4..=100.0;

/// Places of rods that can be meant, µm.
const PLACES_UM: RangeInclusive<f64> = -100.0..=100.0;

/// The largest |n| of a medium and the largest k·d of a rod of diameter d (µm) at 550 nm that cylinder functions reach.
const LARGEST_INDEX: f64 = 100.0;
const LARGEST_LOSS_UM: f64 = 20.0;

/// A periodic structure in its host, which continues below as a half-space.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Period Δ along x.
    pub period_um: f64,
    /// The medium between the rods and below them.
    pub host: Substance,
    /// The medium that the light comes through; it must not absorb.
    pub incidence: Substance,
    /// Depth of the first row's z = 0 below the surface.
    pub depth_to_center_um: f64,
    /// Rows, each [`Self::row_pitch_um`] below the one above.
    pub rows: usize,
    /// Distance of rows.
    pub row_pitch_um: f64,
    /// Shift of every other row, in periods.
    pub row_shift: f64,
    /// The rods of a row.
    pub rods: Vec<Rod>,
    /// The materials that names mean.
    pub library: Library,
}

/// One rod in the period of a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Position in the period.
    pub x_um: f64,
    /// Offset within the row, down positive.
    pub z_um: f64,
    /// The rows that have it, from the first; all where `None`.
    pub rows: Option<usize>,
    /// Concentric circles, outermost first.
    pub circles: Vec<Circle>,
}

/// A circle of a rod and what fills it, up to the next one.
#[derive(Debug, Clone, PartialEq)]
pub struct Circle {
    /// Its diameter.
    pub diameter_um: f64,
    /// What is inside.
    pub medium: Substance,
}

impl Rod {
    fn diameter_um(&self) -> f64 {
        self.circles.first().map_or(0.0, |circle| circle.diameter_um)
    }
}

/// Where a rod of the stack is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Which of [`Lattice::rods`].
    pub rod: usize,
    /// Row, from 0.
    pub row: usize,
    /// Position along x, not reduced to one period.
    pub x_um: f64,
    /// Depth of the centre below the surface.
    pub depth_um: f64,
}

impl Lattice {
    /// Depth of z = 0 such that the first row's highest edge lies `cortex_um` below the surface.
    #[must_use]
    pub fn depth_under_cortex(cortex_um: f64, rods: &[Rod]) -> f64 {
        let edge = rods.iter().map(|rod| rod.z_um - 0.5 * rod.diameter_um()).fold(f64::INFINITY, f64::min);
        cortex_um - if edge.is_finite() { edge } else { 0.0 }
    }

    /// Every rod of one period, row by row.
    pub fn placed(&self) -> impl Iterator<Item = Placed> {
        (0..self.rows).flat_map(move |row| {
            let shift = if row % 2 == 1 { self.row_shift * self.period_um } else { 0.0 };
            self.rods.iter().enumerate().filter(move |(_, rod)| rod.rows.is_none_or(|rows| row < rows)).map(
                move |(index, rod)| Placed {
                    rod: index,
                    row,
                    x_um: rod.x_um + shift,
                    depth_um: self.depth_to_center_um + row as f64 * self.row_pitch_um + rod.z_um,
                },
            )
        })
    }

    /// Depth of the lowest edge of a rod; 0 without rods.
    #[must_use]
    pub fn bottom_um(&self) -> f64 {
        self.placed()
            .map(|placed| placed.depth_um + 0.5 * self.rods[placed.rod].diameter_um())
            .fold(0.0, f64::max)
    }

    /// The identity of everything that decides what it reflects, BLAKE3 in hexadecimal.
    #[must_use]
    pub fn hash(&self) -> String {
        crate::identity::hash("lattice", self)
    }

    /// The material of a substance of this lattice.
    ///
    /// # Errors
    /// A name that the library does not have; never for the lattice's own media.
    pub fn material(&self, substance: &Substance) -> Result<Material> {
        material(substance, &self.library)
    }

    /// Refuses what is no crystal.
    ///
    /// # Errors
    /// A length that is no length, circles that do not shrink, rods that overlap or cut the surface, too many rods, or
    /// an unknown medium; the message starts with the key.
    pub fn check(&self) -> Result<()> {
        length("lattice.period", self.period_um)?;
        if !(1..=MOST_RODS).contains(&self.rows) {
            return refuse(format!("lattice.rows is {}, outside 1 to {MOST_RODS}", self.rows));
        }
        if self.rows > 1 {
            length("lattice.row_pitch", self.row_pitch_um)?;
        }
        within("lattice.depth_to_center", self.depth_to_center_um, &PLACES_UM, " µm")?;
        within("lattice.row_shift", self.row_shift, &(-1.0..=1.0), " of the period")?;
        self.check_medium("lattice.host", &self.host, 0.0)?;
        self.check_medium("lattice.incidence", &self.incidence, 0.0)?;
        if self.rods.is_empty() {
            return refuse("lattice.rod is missing; give at least one rod".into());
        }
        for (index, rod) in self.rods.iter().enumerate() {
            self.check_rod(index, rod)?;
        }
        if self.rods.len() * self.rows > MOST_RODS {
            return refuse(format!(
                "lattice: {} rows of {} rods are more than {MOST_RODS} rods",
                self.rows,
                self.rods.len()
            ));
        }
        self.check_places()
    }

    fn check_rod(&self, index: usize, rod: &Rod) -> Result<()> {
        let place = format!("lattice.rod[{index}]");
        if rod.circles.is_empty() {
            return refuse(format!("{place}.circles is empty; give at least one circle"));
        }
        within(&format!("{place}.x"), rod.x_um, &PLACES_UM, " µm")?;
        within(&format!("{place}.z"), rod.z_um, &PLACES_UM, " µm")?;
        for (c, circle) in rod.circles.iter().enumerate() {
            let place = format!("{place}.circles[{c}]");
            length(&format!("{place}.diameter"), circle.diameter_um)?;
            if c > 0 && circle.diameter_um >= rod.circles[c - 1].diameter_um {
                return refuse(format!(
                    "{place}.diameter is {}, not below {} of the circle around it; list the outermost first",
                    circle.diameter_um,
                    rod.circles[c - 1].diameter_um
                ));
            }
            self.check_medium(&format!("{place}.medium"), &circle.medium, circle.diameter_um)?;
        }
        if rod.diameter_um() > self.period_um + TOUCHING_UM {
            let hint = match typed_in_nm(rod.diameter_um(), &(LENGTHS_UM.start() * 100.0..=self.period_um)) {
                none if none.is_empty() => "; make it smaller".to_owned(),
                hint => hint,
            };
            return refuse(format!(
                "{place} is {} µm wide, wider than the period of {} µm, so it overlaps itself{hint}",
                rod.diameter_um(),
                self.period_um
            ));
        }
        Ok(())
    }

    /// A medium that there is and that crystals can be solved with; in a circle of a diameter (µm), else 0.
    fn check_medium(&self, place: &str, substance: &Substance, diameter_um: f64) -> Result<()> {
        let material = self.material(substance).map_err(|e| e.at(place))?;
        // What a table does not reach is said when it is asked for.
        let Ok(index) = material.index(550.0) else { return Ok(()) };
        if index.norm() > LARGEST_INDEX || index.im * diameter_um > LARGEST_LOSS_UM {
            return refuse(format!(
                "{place} has the index {index} at 550 nm, more than crystals can be solved with; its modulus can be up to {LARGEST_INDEX}, k times the diameter up to {LARGEST_LOSS_UM} µm"
            ));
        }
        Ok(())
    }

    /// Rods below the surface, none in another.
    fn check_places(&self) -> Result<()> {
        let mut placed: Vec<Placed> = self.placed().collect();
        let name = |p: &Placed| format!("rod {} of row {}", p.rod, p.row);
        let radius = |p: &Placed| 0.5 * self.rods[p.rod].diameter_um();
        if let Some(cut) = placed.iter().find(|p| p.depth_um - radius(p) < -TOUCHING_UM) {
            return refuse(format!(
                "lattice: {} reaches {:.5} µm above the surface; raise the cortex or depth_to_center",
                name(cut),
                radius(cut) - cut.depth_um
            ));
        }
        placed.sort_by(|a, b| a.depth_um.total_cmp(&b.depth_um));
        let widest = self.rods.iter().map(Rod::diameter_um).fold(0.0, f64::max);
        for (index, a) in placed.iter().enumerate() {
            for b in placed[index + 1..].iter().take_while(|b| b.depth_um - a.depth_um < widest) {
                let across = (b.x_um - a.x_um) / self.period_um;
                let across = (across - across.round()) * self.period_um;
                let overlap = radius(a) + radius(b) - across.hypot(b.depth_um - a.depth_um);
                if overlap > TOUCHING_UM {
                    return refuse(format!(
                        "lattice: {} and {} overlap by {overlap:.5} µm; move them apart or make them smaller",
                        name(a),
                        name(b)
                    ));
                }
            }
        }
        Ok(())
    }
}

fn length(key: &str, value_um: f64) -> Result<()> {
    within(key, value_um, &LENGTHS_UM, " µm")
}

fn within(key: &str, value: f64, allowed: &RangeInclusive<f64>, unit: &str) -> Result<()> {
    if allowed.contains(&value) {
        return Ok(());
    }
    let hint = if unit == " µm" { typed_in_nm(value, allowed) } else { String::new() };
    refuse(format!("{key} is {}, outside {} to {}{unit}{hint}", shown(value), allowed.start(), allowed.end()))
}

fn refuse<T>(message: String) -> Result<T> {
    Err(Error::input(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(diameter_um: f64) -> Rod {
        let circle = Circle { diameter_um, medium: Substance::named("melanin") };
        Rod { x_um: 0.0, z_um: 0.0, rows: None, circles: vec![circle] }
    }

    fn hexagonal(diameter_um: f64) -> Lattice {
        Lattice {
            period_um: 0.18,
            host: Substance::named("keratin"),
            incidence: Substance::named("air"),
            depth_to_center_um: 0.22,
            rows: 3,
            row_pitch_um: 0.18 * 0.75f64.sqrt(),
            row_shift: 0.5,
            rods: vec![solid(diameter_um)],
            library: Library::builtin(),
        }
    }

    fn refusal(lattice: &Lattice) -> String {
        let error = lattice.check().unwrap_err();
        assert!(error.is_input(), "{error}");
        error.to_string()
    }

    #[test]
    fn rows_are_placed_below_each_other_every_other_shifted() {
        let mut lattice = hexagonal(0.18);
        lattice.rods.push(Rod { x_um: 0.09, z_um: 0.05, rows: Some(2), ..solid(0.001) });
        let placed: Vec<Placed> = lattice.placed().collect();
        assert_eq!(placed.len(), 5);
        assert_eq!((placed[0].x_um, placed[2].x_um, placed[4].x_um), (0.0, 0.09, 0.0));
        assert!((placed[4].depth_um - 0.22 - 2.0 * lattice.row_pitch_um).abs() < 1e-15);
        assert!((placed[3].depth_um - placed[2].depth_um - 0.05).abs() < 1e-15);
        assert!((Lattice::depth_under_cortex(0.13, &lattice.rods) - 0.22).abs() < 1e-15);
        assert!((lattice.bottom_um() - placed[4].depth_um - 0.09).abs() < 1e-15);
    }

    #[test]
    fn touching_rods_are_a_crystal_and_overlapping_ones_are_not() {
        hexagonal(0.18).check().unwrap();
        hexagonal(0.18 + 0.9 * TOUCHING_UM).check().unwrap();
        assert!(refusal(&hexagonal(0.1801)).contains("overlap"));
        let closer = Lattice { row_pitch_um: 0.15, ..hexagonal(0.18) };
        assert!(refusal(&closer).contains("rod 0 of row 0 and rod 0 of row 1 overlap by 0.00507 µm"));
        let straight = Lattice { row_shift: 0.0, ..closer };
        assert!(refusal(&straight).contains("overlap by 0.03"));
    }

    #[test]
    fn lengths_in_nm_are_recognized() {
        let in_nm = Lattice { period_um: 205.0, ..hexagonal(0.1) };
        assert_eq!(
            refusal(&in_nm),
            "lattice.period is 205, outside 0.0001 to 100 µm; did you mean 0.205 (205 nm)?"
        );
        assert!(refusal(&hexagonal(130.0)).contains("diameter is 130, outside"));
        assert!(refusal(&hexagonal(90.0)).ends_with("overlaps itself; did you mean 0.09 (90 nm)?"));
        assert!(refusal(&hexagonal(0.2)).ends_with("make it smaller"));
        let mut apart = hexagonal(0.1);
        apart.rods[0].x_um = 1e16;
        assert!(refusal(&apart).contains("rod[0].x is 1e16, outside -100 to 100 µm"));
    }

    #[test]
    fn what_is_no_crystal_is_refused_by_key() {
        assert!(refusal(&Lattice { period_um: 0.0, ..hexagonal(0.1) }).contains("lattice.period is 0"));
        assert!(refusal(&hexagonal(-0.1)).contains("rod[0].circles[0].diameter is -0.1"));
        assert!(
            refusal(&Lattice { depth_to_center_um: 0.04, ..hexagonal(0.1) }).contains("0.01000 µm above")
        );
        assert!(refusal(&Lattice { rows: 0, ..hexagonal(0.1) }).contains("lattice.rows is 0"));
        assert!(refusal(&Lattice { row_pitch_um: f64::NAN, ..hexagonal(0.1) }).contains("row_pitch is NaN"));
        let unknown = Lattice { host: Substance::named("keratine"), ..hexagonal(0.1) };
        assert!(refusal(&unknown).contains("did you mean 'keratin'"));
        let far = Lattice { row_shift: 1e300, ..hexagonal(0.1) };
        assert!(refusal(&far).contains("row_shift is 1e300, outside -1 to 1 of the period"));
        let mut metal = hexagonal(0.1);
        metal.rods[0].circles[0].medium = Substance::Index(crate::Complex64::new(1.0, 1e9));
        assert!(refusal(&metal).contains("rod[0].circles[0].medium has the index 1+1000000000i at 550 nm"));
        let mut inside_out = hexagonal(0.1);
        inside_out.rods[0].circles.push(Circle { diameter_um: 0.1, medium: Substance::named("air") });
        assert!(refusal(&inside_out).contains("circles[1].diameter is 0.1, not below 0.1"));
    }
}
