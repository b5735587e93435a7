//! Energy balance over random waves on random crystals: R + T + A = 1, whatever the rods and the direction.

use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::progress::Progress;
use barbule::solve::crystal::{Cell, CrystalSolver, Incidence};
use barbule::structure::{Circle, Lattice, Rod, SpeciesFile, Substance, crystal_species};
use barbule::{Error, Result};

/// Wavelengths of random waves, nm.
pub const WAVELENGTHS_NM: [f64; 2] = [300.0, 830.0];

/// |R + T + A − 1| over many points.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Ascending, one number per point that was solved, the larger of both polarizations.
    pub imbalance: Vec<f64>,
    /// The wave and the crystal of the largest.
    pub worst: String,
    /// Points that the solver refused, with their reasons.
    pub refused: Vec<String>,
}

impl Balance {
    /// The value below which this part (0 to 1) of the points lies; not a number without points.
    #[must_use]
    pub fn quantile(&self, part: f64) -> f64 {
        let last = self.imbalance.len().saturating_sub(1);
        self.imbalance.get((part * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }
}

/// Sends `points` random waves to crystals, in turn a built-in variant and one of [`lattice`]; θ_i and φ_i are even
/// within ± `reach` (rad), wavelengths within [`WAVELENGTHS_NM`].
///
/// # Errors
/// The built-in crystals cannot be read, or the user cancelled.
pub fn balance(
    solver: &dyn CrystalSolver,
    points: usize,
    reach: f64,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Balance> {
    let known = built_in()?;
    progress.begin("balancing", points as u64);
    let mut found = Balance { imbalance: Vec::new(), worst: String::new(), refused: Vec::new() };
    let mut largest = 0.0;
    for point in 0..points {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let mut stream = Stream::new(seed, &[point as u64]);
        let lattice =
            if point % 2 == 0 { known[point / 2 % known.len()].clone() } else { lattice(&mut stream) };
        let incidence = Incidence {
            wavelength_nm: stream.uniform(WAVELENGTHS_NM[0], WAVELENGTHS_NM[1]),
            theta_i: stream.uniform(-reach, reach),
            phi_i: stream.uniform(-reach, reach),
        };
        let response =
            Cell::new(&lattice, incidence.wavelength_nm).and_then(|cell| solver.respond(&cell, &incidence));
        match response {
            Ok(response) => {
                let imbalance = response.imbalance(incidence.phi_i);
                if imbalance > largest {
                    (largest, found.worst) = (imbalance, format!("{incidence:?}, {}", described(&lattice)));
                }
                found.imbalance.push(imbalance);
            }
            Err(error) => found.refused.push(format!("{error} ({incidence:?}, {})", described(&lattice))),
        }
        progress.advance(1);
    }
    found.imbalance.sort_by(f64::total_cmp);
    Ok(found)
}

/// The numbers of a lattice.
fn described(lattice: &Lattice) -> String {
    format!(
        "period {} µm, {} rows of {} µm, shift {}, depth {} µm, {:?}",
        lattice.period_um,
        lattice.rows,
        lattice.row_pitch_um,
        lattice.row_shift,
        lattice.depth_to_center_um,
        lattice.rods
    )
}

/// The crystals of all variants of all built-in species.
///
/// # Errors
/// A built-in file is broken.
pub fn built_in() -> Result<Vec<Lattice>> {
    let mut found = Vec::new();
    for species in crystal_species() {
        let file = SpeciesFile::builtin(species)?;
        for variant in file.variants() {
            found.extend(file.model(Some(variant), Library::builtin())?.lattice());
        }
    }
    Ok(found)
}

/// A random crystal of melanin in keratin under air: solid rods, hollow ones, touching hollow ones, or rods with air
/// channels between; one to five rows that may interleave, with any shift.
#[must_use]
pub fn lattice(stream: &mut Stream) -> Lattice {
    let kind = (4.0 * stream.unit()) as usize;
    let period_um = stream.uniform(0.1, 0.45);
    let touching = kind == 2;
    let diameter = if touching { period_um } else { period_um * stream.uniform(0.3, 0.9) };
    let row_shift = match kind {
        2 => 0.5,
        3 => 0.0,
        _ => stream.unit(),
    };
    let across = period_um * row_shift.min(1.0 - row_shift);
    let nearest = (diameter * diameter - across * across).max(0.0).sqrt().max(0.5 * diameter);
    let row_pitch_um = if touching { nearest } else { nearest * stream.uniform(1.02, 1.6) };
    let circle = |diameter_um: f64, medium: &str| Circle { diameter_um, medium: Substance::named(medium) };
    let mut circles = vec![circle(diameter, "melanin")];
    if kind == 1 || touching {
        circles.push(circle(diameter * stream.uniform(0.2, 0.9), "air"));
    }
    let rows = 1 + (5.0 * stream.unit()) as usize;
    let mut rods = vec![Rod { x_um: 0.0, z_um: 0.0, rows: None, circles }];
    if kind == 3 && rows > 1 {
        let room = period_um.hypot(row_pitch_um) - diameter;
        let channel = room.min(period_um).min(row_pitch_um) * stream.uniform(0.2, 0.95);
        rods.push(Rod {
            x_um: 0.5 * period_um,
            z_um: 0.5 * row_pitch_um,
            rows: Some(rows - 1),
            circles: vec![circle(channel, "air")],
        });
    }
    Lattice {
        period_um,
        host: Substance::named("keratin"),
        incidence: Substance::named("air"),
        depth_to_center_um: Lattice::depth_under_cortex(stream.uniform(0.005, 0.4), &rods),
        rows,
        row_pitch_um,
        row_shift,
        rods,
        library: Library::builtin(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::progress::Unobserved;
    use barbule::solve::crystal::{Multipole, Rcwa};

    #[test]
    fn random_crystals_are_crystals() {
        for seed in 0..300 {
            let lattice = lattice(&mut Stream::new(seed, &[]));
            lattice.check().unwrap_or_else(|error| panic!("{error}: {lattice:?}"));
        }
    }

    /// The same with 10⁴ points: the example `crystal_checks`.
    #[test]
    fn random_waves_on_random_crystals_keep_their_energy() {
        let reach = 89.9f64.to_radians();
        let found = balance(&Multipole::default(), 150, reach, 1, &Unobserved).unwrap();
        assert!(found.refused.is_empty(), "{:?}", found.refused);
        assert!(found.quantile(0.9) < 1e-12 && found.quantile(1.0) < 1e-10, "{:?}", found.imbalance);
        let modes = Rcwa { orders: 5, slices: 6, estimate: false };
        let found = balance(&modes, 60, reach, 2, &Unobserved).unwrap();
        assert!(found.refused.is_empty() && found.quantile(1.0) < 1e-9, "{found:?}");
    }
}
