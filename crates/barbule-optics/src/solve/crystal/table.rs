//! Tables of a crystal's orders over wavelengths and θ_i, as series in φ_i.

use rayon::prelude::*;

use super::solver::unless_cancelled;
use super::{Cell, CrystalSolver};
use crate::math::chebyshev;
use crate::progress::{OnlyStops, Progress};
use crate::scattering::orders::{JONES, OrderSeries, OrderTable, Piece};
use crate::structure::Lattice;
use crate::{Error, Result};

/// What a series leaves out of a Jones matrix's elements, at most.
const TOLERANCE: f64 = 3e-5;

/// Longer series are cut in two.
const MOST_TERMS: usize = 48;

/// A piece is halved so often at most; narrower resonances are refused.
const MOST_HALVINGS: usize = 6;

/// Rayleigh angles nearer to each other than this (in sinφ_i) count as one.
const DISTINCT: f64 = 1e-9;

/// Images under x → −x coincide when they differ by no more than this, µm.
const MIRROR_UM: f64 = 1e-9;

/// Solves a lattice for all wavelengths (nm), cosθ_i and azimuths; every (λ, θ_i) in parallel.
///
/// # Errors
/// As [`Cell::new`] and [`order_series`], or the user cancelled.
pub fn order_table(
    solver: &dyn CrystalSolver,
    lattice: &Lattice,
    wavelengths_nm: &[f64],
    cos_theta: &[f64],
    progress: &dyn Progress,
) -> Result<OrderTable> {
    let units = wavelengths_nm.len() * cos_theta.len();
    progress.begin("solving the crystal", units as u64);
    let cells = wavelengths_nm.iter().map(|&nm| Cell::new(lattice, nm)).collect::<Result<Vec<_>>>()?;
    let series = (0..units)
        .into_par_iter()
        .with_max_len(1)
        .map(|unit| {
            unless_cancelled(progress)?;
            let (wavelength, theta) = (unit / cos_theta.len(), unit % cos_theta.len());
            let theta_i = cos_theta[theta].clamp(0.0, 1.0).acos();
            let (cell, nm) = (&cells[wavelength], wavelengths_nm[wavelength]);
            let series = order_series(solver, cell, nm, theta_i, &OnlyStops(progress))?;
            progress.advance(1);
            Ok(series)
        })
        .collect::<Result<_>>()?;
    Ok(OrderTable { wavelengths_nm: wavelengths_nm.to_vec(), cos_theta: cos_theta.to_vec(), series })
}

/// Solves a cell for all azimuths at one wavelength (nm) and θ_i (rad).
///
/// # Errors
/// As [`CrystalSolver::respond`], a resonance over azimuths that the series cannot follow, or the user cancelled.
pub fn order_series(
    solver: &dyn CrystalSolver,
    cell: &Cell,
    wavelength_nm: f64,
    theta_i: f64,
    progress: &dyn Progress,
) -> Result<OrderSeries> {
    order_series_between(solver, cell, wavelength_nm, theta_i, [-1.0, 1.0], progress)
}

/// As [`order_series`], but only where sinφ_i lies between two values (and from there on to the next Rayleigh angles):
/// the same series there, and none elsewhere.
///
/// # Errors
/// As [`order_series`].
pub fn order_series_between(
    solver: &dyn CrystalSolver,
    cell: &Cell,
    wavelength_nm: f64,
    theta_i: f64,
    sines: [f64; 2],
    progress: &dyn Progress,
) -> Result<OrderSeries> {
    let n = cell.incidence_eps.sqrt();
    let (sin_theta, cos_theta) = theta_i.sin_cos();
    let mut series = OrderSeries {
        step: wavelength_nm * 1e-3 / (cell.period_um * n * cos_theta),
        mirrored: is_mirrored(cell),
        pieces: Vec::new(),
    };
    // κ of the host over that of the incidence medium.
    let host =
        (cell.host_eps.re - cell.incidence_eps * sin_theta * sin_theta).max(0.0).sqrt() / (n * cos_theta);
    let depth_um = cell.rods.iter().map(|r| r.depth_um + 0.5 * r.shells[0].diameter_um).fold(0.0, f64::max);
    // Twice the depth's phase in the host at normal incidence over that at another angle, per unit of its cosine.
    let twice = 2.0 * depth_um * n * cos_theta * std::f64::consts::TAU / (wavelength_nm * 1e-3);
    let mut wanted = [sines];
    if series.mirrored {
        // Where only φ ≥ 0 is kept it stands for both signs.
        let [a, b] = sines.map(f64::abs);
        let least = if sines[0] <= 0.0 && sines[1] >= 0.0 { 0.0 } else { a.min(b) };
        wanted = [[least, a.max(b)]];
    }
    let [[from, to]] = wanted;
    let ends = intervals(series.step, host);
    let meets = |between: &&[f64; 2]| between[1] >= from && between[0] <= to;
    progress.begin("solving the crystal", ends.array_windows::<2>().filter(meets).count() as u64);
    for between in ends.array_windows::<2>().filter(meets) {
        let whole =
            Piece { between: *between, part: [0.0, 1.0], first: 0, orders: 0, coefficients: Vec::new() };
        let Some(part) = part_kept(&whole, series.mirrored) else { continue };
        let mut waiting = vec![([part, 1.0], 0)];
        while let Some((part, halvings)) = waiting.pop() {
            let mut piece = Piece { part, ..whole.clone() };
            (piece.first, piece.orders) = propagating(series.step, piece.sine(0.0));
            let along = |x: f64| (host * host - piece.sine(x).powi(2)).max(0.0).sqrt();
            let phase = twice * (along(-1.0) - along(1.0)).abs();
            let last = halvings == MOST_HALVINGS;
            let mut count = 12 + (0.6 * phase).min(1e3) as usize;
            let kept = loop {
                count = count.min(MOST_TERMS);
                let terms = coefficients(solver, cell, wavelength_nm, theta_i, &piece, count, progress)?;
                let row = piece.orders * JONES;
                let largest =
                    terms.chunks_exact(row).map(|term| term.iter().fold(0.0, |m: f64, c| m.max(c.abs())));
                match chebyshev::needed(largest, TOLERANCE) {
                    Some(kept) => break Some(terms[..kept * row].to_vec()),
                    None if last && count == MOST_TERMS => {
                        return Err(unsettled(&piece, wavelength_nm, theta_i));
                    }
                    None if count == MOST_TERMS => break None,
                    None => count += count / 2,
                }
            };
            match kept {
                Some(coefficients) => series.pieces.push(Piece { coefficients, ..piece }),
                None => {
                    let middle = 0.5 * (part[0] + part[1]);
                    waiting.push(([middle, part[1]], halvings + 1));
                    waiting.push(([part[0], middle], halvings + 1));
                }
            }
        }
        progress.advance(1);
    }
    Ok(series)
}

/// The Rayleigh angles as sinφ_i with ±1, ascending; `host` is κ of the host over that of the incidence medium.
fn intervals(step: f64, host: f64) -> Vec<f64> {
    let reach = ((1.0 + host) / step).ceil() as i32;
    let mut ends: Vec<f64> = (-reach..=reach)
        .filter(|&m| m != 0)
        .flat_map(|m| [1.0, -1.0, host, -host].map(|k| f64::from(m) * step + k))
        .chain([host, -host])
        .filter(|s| s.abs() < 1.0 - DISTINCT)
        .chain([-1.0, 1.0])
        .collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|b, a| *b - *a < DISTINCT);
    ends
}

/// Where a piece starts in ψ/π when only sinφ_i ≥ 0 is kept; `None` if nothing of it is.
fn part_kept(whole: &Piece, mirrored: bool) -> Option<f64> {
    let [s0, s1] = whole.between;
    if !mirrored || s0 >= 0.0 {
        return Some(0.0);
    }
    (s1 > 0.0).then(|| 0.5 * (whole.position(0.0) + 1.0))
}

/// The lowest order that propagates at sinφ_i and how many do.
fn propagating(step: f64, sine: f64) -> (i32, usize) {
    let (low, high) = (((sine - 1.0) / step).ceil() as i32, ((sine + 1.0) / step).floor() as i32);
    // The mirror direction, whatever rounding says at grazing incidence.
    let (low, high) = (low.min(0), high.max(0));
    (low, (high - low) as usize + 1)
}

/// Whether x → −x maps the crystal onto itself.
fn is_mirrored(cell: &Cell) -> bool {
    let period = cell.period_um;
    cell.rods.iter().all(|rod| {
        cell.rods.iter().any(|other| {
            let across = (rod.x_um + other.x_um) / period;
            (across - across.round()).abs() * period < MIRROR_UM
                && (rod.depth_um - other.depth_um).abs() < MIRROR_UM
                && rod.shells.len() == other.shells.len()
                && rod
                    .shells
                    .iter()
                    .zip(&other.shells)
                    .all(|(a, b)| a.eps == b.eps && (a.diameter_um - b.diameter_um).abs() < MIRROR_UM)
        })
    })
}

/// Chebyshev coefficients `[term][order][JONES]` of a piece from as many nodes.
fn coefficients(
    solver: &dyn CrystalSolver,
    cell: &Cell,
    wavelength_nm: f64,
    theta_i: f64,
    piece: &Piece,
    count: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let phi_i: Vec<f64> = chebyshev::nodes(count).map(|x| piece.sine(x).asin()).collect();
    let responses = solver.respond_to_azimuths(cell, wavelength_nm, theta_i, &phi_i, progress)?;
    let row = piece.orders * JONES;
    let mut samples = vec![0.0; count * row];
    for (sample, response) in samples.chunks_exact_mut(row).zip(&responses) {
        for order in &response.orders {
            let Ok(at) = usize::try_from(order.m - piece.first) else { continue };
            let Some(own) = sample.as_chunks_mut::<JONES>().0.get_mut(at) else { continue };
            for (value, z) in own.as_chunks_mut::<2>().0.iter_mut().zip(order.jones.as_flattened()) {
                *value = [z.re, z.im];
            }
        }
    }
    Ok(chebyshev::coefficients(&samples, row))
}

/// What is said of a resonance narrower than the smallest piece.
fn unsettled(piece: &Piece, wavelength_nm: f64, theta_i: f64) -> Error {
    let [from, to] = [-1.0, 1.0].map(|x| piece.sine(x).asin().to_degrees());
    Error::not_settled(format!(
        "the orders of the crystal change too fast for a table at {wavelength_nm} nm, theta {:.4}°, between phi {from:.4}° and {to:.4}°; change the lattice or give a medium some absorption",
        theta_i.to_degrees()
    ))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::Complex64;
    use crate::material::Library;
    use crate::math::rng::Stream;
    use crate::progress::Unobserved;
    use crate::scattering::orders::Jones;
    use crate::solve::crystal::{CrystalResponse, Incidence, Multipole, Order, cells};
    use crate::structure::{SpeciesFile, crystal_species};

    /// Counts the azimuths that a solver is asked for.
    struct Counted(AtomicUsize);

    impl CrystalSolver for Counted {
        fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<CrystalResponse> {
            Multipole::default().respond(cell, incidence)
        }

        fn respond_to_azimuths(
            &self,
            cell: &Cell,
            nm: f64,
            theta: f64,
            phi: &[f64],
            progress: &dyn Progress,
        ) -> Result<Vec<CrystalResponse>> {
            self.0.fetch_add(phi.len(), Ordering::Relaxed);
            Multipole::default().respond_to_azimuths(cell, nm, theta, phi, progress)
        }
    }

    fn lattices() -> Vec<(String, Lattice)> {
        let mut all = Vec::new();
        for species in crystal_species() {
            let file = SpeciesFile::builtin(species).unwrap();
            for variant in file.variants() {
                let model = file.model(Some(variant), Library::builtin()).unwrap();
                all.push((model.title(), model.lattice().unwrap()));
            }
        }
        all
    }

    fn evaluate(series: &OrderSeries, phi: f64) -> Vec<(i32, Jones)> {
        let mut found = Vec::new();
        series.evaluate(phi, &mut found);
        found.sort_by_key(|(m, _)| *m);
        found
    }

    /// The largest difference of an element from the solver's own answer, which has the same orders.
    fn error(series: &OrderSeries, cell: &Cell, nm: f64, theta: f64, phi: f64) -> f64 {
        let incidence = Incidence { wavelength_nm: nm, theta_i: theta, phi_i: phi };
        let exact = Multipole::default().respond(cell, &incidence).unwrap();
        let found = evaluate(series, phi);
        assert_eq!(found.len(), exact.orders.len(), "{nm} {theta} {phi}");
        let mut worst = 0f64;
        for ((m, jones), order) in found.iter().zip(&exact.orders) {
            assert_eq!(*m, order.m);
            assert!((series.sin_phi_o(*m, phi.sin()) - order.phi_o.sin()).abs() < 1e-9);
            for (a, b) in jones.as_flattened().iter().zip(order.jones.as_flattened()) {
                worst = worst.max((a - b).norm());
            }
        }
        worst
    }

    #[test]
    fn series_give_what_the_solver_gives_at_any_azimuth() {
        let mut stream = Stream::new(3, &[]);
        let (mut worst, mut solved, mut count) = (0f64, 0, 0);
        for (name, lattice) in lattices() {
            for nm in [stream.uniform(300.0, 400.0), stream.uniform(400.0, 694.0)] {
                let theta = stream.uniform(0.05, 1.0).acos();
                let cell = Cell::new(&lattice, nm).unwrap();
                let counted = Counted(AtomicUsize::new(0));
                let series = order_series(&counted, &cell, nm, theta, &Unobserved).unwrap();
                assert!(series.mirrored, "{name}");
                (solved, count) = (solved + counted.0.load(Ordering::Relaxed), count + 1);
                for _ in 0..12 {
                    let phi = stream.uniform(-FRAC_PI_2, FRAC_PI_2);
                    worst = worst.max(error(&series, &cell, nm, theta, phi));
                }
            }
        }
        let azimuths = solved / count;
        assert!(worst < 6e-5 && azimuths < 60, "{worst:e} with {azimuths} azimuths on average");
    }

    #[test]
    fn a_crystal_without_mirror_symmetry_is_solved_on_both_sides() {
        let mut cell = cells::peafowl(450.0);
        cell.rods[2].x_um += 0.02;
        let series = order_series(&Multipole::default(), &cell, 450.0, 0.4, &Unobserved).unwrap();
        assert!(!series.mirrored);
        for phi in [-1.4, -0.7, -0.1, 0.0, 0.3, 0.9, 1.5] {
            let found = error(&series, &cell, 450.0, 0.4, phi);
            assert!(found < 1e-4, "{phi}: {found:e}");
        }
    }

    #[test]
    fn grazing_light_is_mirrored_with_the_sign_of_e1_turned() {
        for (name, lattice) in lattices() {
            for (nm, theta) in [(330.0, 0.0), (550.0, 0.9)] {
                let cell = Cell::new(&lattice, nm).unwrap();
                let series = order_series(&Multipole::default(), &cell, nm, theta, &Unobserved).unwrap();
                for phi in [-FRAC_PI_2, FRAC_PI_2] {
                    let found = evaluate(&series, phi);
                    let (_, jones) = found.iter().find(|(m, _)| *m == 0).unwrap();
                    let limit = [[-Complex64::ONE, Complex64::ZERO], [Complex64::ZERO, Complex64::ONE]];
                    for (a, b) in jones.as_flattened().iter().zip(limit.as_flattened()) {
                        assert!((a - b).norm() < 1e-4, "{name} {nm} {phi}: {jones:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn an_order_appears_at_its_rayleigh_angle_without_ringing() {
        let cell = cells::mallard(340.0);
        let (nm, theta) = (340.0, 0.2);
        let series = order_series(&Multipole::default(), &cell, nm, theta, &Unobserved).unwrap();
        // sinφ_1 = 1.
        let rayleigh = (series.step - 1.0).asin();
        for step in 1..=40 {
            let distance = 10f64.powf(-0.2 * f64::from(step));
            for phi in [rayleigh - distance, rayleigh + distance] {
                if phi.abs() < 1.5 {
                    let found = error(&series, &cell, nm, theta, phi);
                    assert!(found < 1e-4, "{distance:e}: {found:e}");
                }
            }
        }
        assert_eq!(evaluate(&series, rayleigh - 1e-6).len(), 1);
        assert_eq!(evaluate(&series, rayleigh + 1e-6).len(), 2);
    }

    #[test]
    fn with_half_a_wavelength_of_period_there_is_one_order() {
        let cell = cells::mallard(400.0);
        let series = order_series(&Multipole::default(), &cell, 400.0, 0.0, &Unobserved).unwrap();
        assert!(series.pieces.iter().all(|piece| (piece.first, piece.orders) == (0, 1)));
    }

    /// One order whose amplitude jumps at φ_i = 0.1.
    struct Jump;

    impl CrystalSolver for Jump {
        fn respond(&self, _: &Cell, incidence: &Incidence) -> Result<CrystalResponse> {
            let side = Complex64::from((incidence.phi_i - 0.1).signum());
            let order = Order { m: 0, phi_o: -incidence.phi_i, jones: [[side; 2]; 2] };
            Ok(CrystalResponse {
                orders: vec![order],
                transmitted: [0.0; 2],
                absorbed: [0.0; 2],
                convergence: None,
            })
        }
    }

    #[test]
    fn what_a_series_cannot_follow_is_refused() {
        let error = order_series(&Jump, &cells::mallard(600.0), 600.0, 0.0, &Unobserved).unwrap_err();
        assert!(error.is_not_settled(), "{error}");
        let text = error.to_string();
        // 0.1 rad are 5.73 degrees.
        assert!(text.contains("too fast for a table at 600 nm, theta 0.0000°, between phi 5."), "{text}");
    }

    #[test]
    fn tables_do_not_depend_on_threads() {
        let (_, lattice) = lattices().remove(0);
        let table = || {
            order_table(&Multipole::default(), &lattice, &[400.0, 600.0], &[0.3, 1.0], &Unobserved).unwrap()
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (whole, single) = (table(), one.install(table));
        assert_eq!(whole, single);
        assert_eq!(whole.at(1, 0).step, whole.series[2].step);
    }
}
