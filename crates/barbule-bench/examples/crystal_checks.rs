//! The crystal solvers against each other and against laws, as docs/theory/crystals.md shows them.
//!
//! `target/release/examples/crystal_checks WHAT` (after `cargo build --release --workspace --examples`), where WHAT is
//! - `convergence FIGURE`: a figure of the error of R against multipoles, orders, slices and cells, a few minutes
//! - `agreement`: tables of the three solvers against each other and against flat layers, a few minutes
//! - `treams`: a table of the three solvers against the stored answers of an independent program
//! - `energy SOLVER POINTS`: |R + T + A − 1| over random waves on random crystals

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

#[path = "../../barbule/tests/it/measure/treams.rs"]
mod treams;

use std::path::Path;

use barbule::io::write_whole;
use barbule::material::Library;
use barbule::plot::{Axis, Curve, Drawing, Figure, Format, Mark};
use barbule::progress::Unobserved;
use barbule::solve::crystal::fdtd::Layer;
use barbule::solve::crystal::planar::jones;
use barbule::solve::crystal::rcwa::profile::{Body, Outline};
use barbule::solve::crystal::{
    Cell, CellRod, CrystalResponse, CrystalSolver, Fdtd, Incidence, Multipole, Rcwa, Shell, Surroundings,
};
use barbule::structure::SpeciesModel;
use barbule::{Complex64, Error, Result};
use barbule_bench::crystal::balance::balance;

const CRYSTALS: [&str; 3] = ["mallard:lime", "magpie:violet", "peafowl:yellow"];

/// What the multipoles ask of themselves as the reference.
const REFERENCE: Multipole = Multipole { tolerance: 1e-11 };

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["convergence", figure] => convergence(Path::new(figure)),
        ["agreement"] => agreement(),
        ["treams"] => against_treams(),
        ["energy", solver, points] => energy(solver, points),
        _ => Err(Error::input("give 'convergence FIGURE', 'agreement', 'treams' or 'energy SOLVER POINTS'")),
    }
}

fn cell(name: &str, wavelength_nm: f64) -> Result<Cell> {
    let (species, variant) = name.split_once(':').map_or((name, None), |(s, v)| (s, Some(v)));
    let lattice = SpeciesModel::builtin(species, variant, Library::builtin())?.lattice();
    Cell::new(&lattice.ok_or_else(|| Error::input(format!("{name} is no crystal")))?, wavelength_nm)
}

fn wave(wavelength_nm: f64, theta_deg: f64, phi_deg: f64) -> Incidence {
    Incidence { wavelength_nm, theta_i: theta_deg.to_radians(), phi_i: phi_deg.to_radians() }
}

fn rcwa(orders: usize, slices: usize) -> Rcwa {
    Rcwa { orders, slices, estimate: false }
}

fn fdtd(cells_per_um: f64) -> Fdtd {
    Fdtd { cells_per_um, estimate: false, ..Fdtd::default() }
}

/// The largest difference of each solver from the independent program, by crystal.
fn against_treams() -> Result<()> {
    let modes = |orders, slices| Rcwa { orders, slices, estimate: false };
    let grid = |cells_per_um| Fdtd { cells_per_um, estimate: false, ..Fdtd::default() };
    let every = |_: &treams::Case| true;
    let columns = [
        ("multipoles, default tolerance, 5 waves", treams::largest(&Multipole::default(), every)),
        ("Fourier modes, 10 orders, 24 slices, 5 waves", treams::largest(&modes(10, 24), every)),
        ("the same at 450 nm", treams::largest(&modes(10, 24), treams::is_at_450_nm)),
        ("20 orders, 48 slices, at 450 nm", treams::largest(&modes(20, 48), treams::is_at_450_nm)),
        ("FDTD, 60 cells/µm, at 450 nm", treams::largest(&grid(60.0), treams::is_at_450_nm)),
        ("FDTD, 120 cells/µm, at 450 nm", treams::largest(&grid(120.0), treams::is_at_450_nm)),
    ];
    let mut names: Vec<String> = Vec::new();
    for case in treams::cases() {
        if !names.contains(&case.cell_name) {
            names.push(case.cell_name);
        }
    }
    println!("| largest difference | {} |", names.join(" | "));
    let row = |name: &str, cell: &dyn Fn(&str) -> f64| {
        let cells: Vec<String> = names.iter().map(|name| format!("{:.1e}", cell(name))).collect();
        println!("| {name} | {} |", cells.join(" | "));
    };
    for (name, found) in &columns {
        row(name, &|cell| found[cell]);
    }
    let own = |cell: &str| {
        treams::cases()
            .iter()
            .filter(|case| case.cell_name == cell)
            .map(|case| case.error)
            .fold(0.0, f64::max)
    };
    row("treams, its own", &own);
    Ok(())
}

/// Orders and slices at which the other is fine.
const FINE: [usize; 2] = [40, 128];

/// Errors of R at 500 nm, θ = 20°, φ = 30°, against multipoles, orders, slices and cells.
fn convergence(path: &Path) -> Result<()> {
    let incidence = wave(500.0, 20.0, 30.0);
    let label = |text: &str| (Axis::logarithmic(text), Axis::logarithmic("largest error of R"));
    let chart = |title: &str, (x, y): (Axis, Axis)| {
        let mut figure = Figure::new(title, x, y);
        figure.size = [330.0, 260.0];
        figure
    };
    let multipoles = (Axis::new("multipoles M (orders −M … M)"), label("").1);
    let mut figures = [
        chart("Cylinder multipoles", multipoles),
        chart(&format!("Fourier modes, {} slices", FINE[1]), label("orders N (−N … N)")),
        chart(&format!("Fourier modes, {} orders", FINE[0]), label("slices per rod")),
        chart("FDTD", label("cells per µm")),
    ];
    for name in CRYSTALS {
        let cell = cell(name, incidence.wavelength_nm)?;
        let exact = REFERENCE.respond(&cell, &incidence)?;
        let prepared = REFERENCE.prepare(&cell, incidence.wavelength_nm, incidence.theta_i)?;
        let by_multipoles = |m: usize| prepared.respond_with(m, incidence.phi_i);
        let by_orders = |n: usize| rcwa(n, FINE[1]).respond(&cell, &incidence);
        let by_slices = |s: usize| rcwa(FINE[0], s).respond(&cell, &incidence);
        let by_cells = |c: usize| fdtd(c as f64).respond(&cell, &incidence);
        type Solve<'a> = (&'a dyn Fn(usize) -> Result<CrystalResponse>, &'a [usize]);
        let sweeps: [Solve; 4] = [
            (&by_multipoles, &[1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32]),
            (&by_orders, &[4, 6, 8, 12, 16, 24, 40]),
            (&by_slices, &[4, 8, 16, 32, 64, 128]),
            (&by_cells, &[50, 75, 100, 150, 200]),
        ];
        for (panel, (figure, (solve, sizes))) in figures.iter_mut().zip(sweeps).enumerate() {
            let error = |&size: &usize| {
                solve(size).map(|found| [size as f64, found.distance(&exact, incidence.phi_i)])
            };
            let points = sizes.iter().map(error).collect::<Result<Vec<_>>>()?;
            let errors: Vec<String> =
                points.iter().map(|[size, error]| format!("{size} {error:.1e}")).collect();
            println!("{name}, {}: {}", figure.title, errors.join(", "));
            let title = match panel {
                0 => exponential(name, &points),
                // The orders, which are not infinite, leave a floor.
                2 => power(name, &points, 2.5 * points[points.len() - 1][1]),
                _ => power(name, &points, 0.0),
            };
            figure.curves.push(Curve { mark: Mark::Both, ..Curve::line(title, points) });
        }
    }
    let panels = figures.map(|figure| figure.draw());
    let widest = panels.iter().map(|p| p.width).fold(0.0, f64::max);
    let highest = panels.iter().map(|p| p.height).fold(0.0, f64::max);
    let mut page = Drawing::new(2.0 * widest, 2.0 * highest);
    for (index, panel) in panels.into_iter().enumerate() {
        page.place(panel, [(index % 2) as f64 * widest, (index / 2) as f64 * highest]);
    }
    write_whole(path, &page.encode(Format::of(path)?, &[])?)
}

/// Slope of a line through points, least squares.
fn slope(points: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let count = points.clone().count() as f64;
    let mean = |axis: usize| points.clone().map(|p| p[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let [above, below] =
        points.fold([0.0; 2], |[a, b], p| [a + (p[0] - x) * (p[1] - y), b + (p[0] - x).powi(2)]);
    above / below
}

/// A curve's name with its factor per multipole, above the reference's own errors.
fn exponential(name: &str, points: &[[f64; 2]]) -> String {
    let shown = points.iter().filter(|p| p[0] > 1.5 && p[1] > 1e-10).map(|p| [p[0], p[1].ln()]);
    format!("{name}: ×{:.2} per multipole", slope(shown).exp())
}

/// A curve's name with its order of convergence where errors are above a floor.
fn power(name: &str, points: &[[f64; 2]], floor: f64) -> String {
    let above = points.iter().filter(|p| p[1] > floor).map(|p| p.map(f64::ln));
    format!("{name}: order {:.1}", -slope(above))
}

/// Points at which solvers are compared.
fn waves() -> Vec<Incidence> {
    [(330.0, 20.0, 50.0), (400.0, 0.0, 0.0), (500.0, 20.0, 30.0), (500.0, 60.0, -60.0), (650.0, -40.0, 75.0)]
        .map(|(nm, theta, phi)| wave(nm, theta, phi))
        .to_vec()
}

/// The largest differences of R against the reference and of R + T + A from 1.
fn largest(solver: &dyn CrystalSolver, name: &str) -> Result<[f64; 2]> {
    let mut found = [0.0_f64; 2];
    for incidence in waves() {
        let cell = cell(name, incidence.wavelength_nm)?;
        let exact = REFERENCE.respond(&cell, &incidence)?;
        let response = solver.respond(&cell, &incidence)?;
        found[0] = found[0].max(response.distance(&exact, incidence.phi_i));
        found[1] = found[1].max(response.imbalance(incidence.phi_i));
    }
    Ok(found)
}

fn agreement() -> Result<()> {
    let named = |orders: usize, slices: usize| {
        (format!("Fourier modes, {orders} orders, {slices} slices"), rcwa(orders, slices))
    };
    println!("| largest difference of R / of R + T + A from 1 | {} |", CRYSTALS.join(" | "));
    println!("| --- | --- | --- | --- |");
    let row = |title: &str, solver: &dyn CrystalSolver| -> Result<()> {
        let cells = CRYSTALS.map(|name| largest(solver, name));
        let mut text = format!("| {title} |");
        for cell in cells {
            let [difference, balance] = cell?;
            text += &format!(" {difference:.0e} / {balance:.0e} |");
        }
        println!("{text}");
        Ok(())
    };
    row("multipoles, default tolerance", &Multipole::default())?;
    for (title, solver) in [named(8, 16), named(12, 24), named(20, 24), named(20, 48), named(40, 96)] {
        row(&title, &solver)?;
    }
    for cells in [50.0, 75.0, 100.0, 150.0] {
        row(&format!("FDTD, {cells} cells/µm"), &fdtd(cells))?;
    }
    println!(
        "\n| largest difference of J from flat layers | multipoles | Fourier modes | FDTD, 50 / 100 / 150 cells/µm |"
    );
    println!("| --- | --- | --- | --- |");
    planar_rods()?;
    planar_layers()?;
    estimates()
}

/// How the errors of R compare with the solvers' own estimates.
fn estimates() -> Result<()> {
    println!();
    let solvers: [(&str, &dyn CrystalSolver); 4] = [
        ("Fourier modes 8/16", &Rcwa { estimate: true, ..rcwa(8, 16) }),
        ("Fourier modes 12/24", &Rcwa { estimate: true, ..rcwa(12, 24) }),
        ("Fourier modes 20/24", &Rcwa { estimate: true, ..rcwa(20, 24) }),
        ("FDTD 75", &Fdtd { estimate: true, ..fdtd(75.0) }),
    ];
    for (title, solver) in solvers {
        let mut ratios = Vec::new();
        for name in CRYSTALS {
            for incidence in waves() {
                let cell = cell(name, incidence.wavelength_nm)?;
                let exact = REFERENCE.respond(&cell, &incidence)?;
                let response = solver.respond(&cell, &incidence)?;
                ratios.push(
                    response.distance(&exact, incidence.phi_i) / response.convergence.unwrap_or(f64::NAN),
                );
            }
        }
        ratios.sort_by(f64::total_cmp);
        println!(
            "{title}: true error of R over the estimate: {:.2} in the middle, {:.2} at most",
            ratios[ratios.len() / 2],
            ratios[ratios.len() - 1]
        );
    }
    Ok(())
}

/// The largest difference of zeroth orders from flat layers, and of other orders from nothing.
fn apart(response: &CrystalResponse, flat: &[[Complex64; 2]; 2]) -> f64 {
    let zero = [[Complex64::ZERO; 2]; 2];
    let differences = response.orders.iter().flat_map(|order| {
        let expected = if order.m == 0 { flat } else { &zero };
        (0..4).map(|i| (order.jones[i / 2][i % 2] - expected[i / 2][i % 2]).norm())
    });
    differences.fold(0.0, f64::max)
}

fn planar_row(title: &str, multipole: Option<f64>, modes: f64, cells: [f64; 3]) {
    let [a, b, c] = cells;
    let multipole = multipole.map_or("–".to_owned(), |error| format!("{error:.0e}"));
    println!("| {title} | {multipole} | {modes:.0e} | {a:.0e} / {b:.0e} / {c:.0e} |");
}

/// Rods of the host's own index: the flat surface.
fn planar_rods() -> Result<()> {
    for name in CRYSTALS {
        let (mut multipole, mut modes, mut cells) = (0.0_f64, 0.0_f64, [0.0_f64; 3]);
        for incidence in waves() {
            let crystal = cell(name, incidence.wavelength_nm)?;
            let eps = crystal.host_eps();
            let of_host = |rod: &CellRod| CellRod {
                shells: rod.shells.iter().map(|shell| Shell { eps, ..*shell }).collect(),
                ..rod.clone()
            };
            let cell = Cell::from_rods(crystal.surroundings(), crystal.rods().iter().map(of_host).collect())?;
            let flat = jones(1.0, &[], eps, &incidence)?;
            multipole = multipole.max(apart(&REFERENCE.respond(&cell, &incidence)?, &flat));
            modes = modes.max(apart(&rcwa(8, 16).respond(&cell, &incidence)?, &flat));
            for (error, per_um) in cells.iter_mut().zip([50.0, 100.0, 150.0]) {
                *error = error.max(apart(&fdtd(per_um).respond(&cell, &incidence)?, &flat));
            }
        }
        planar_row(&format!("{name}, rods of keratin"), Some(multipole), modes, cells);
    }
    Ok(())
}

/// Layers of melanin and of air as deep as a row of rods, in keratin.
fn planar_layers() -> Result<()> {
    let (mut modes, mut cells) = (0.0_f64, [0.0_f64; 3]);
    for incidence in waves() {
        let crystal = cell("mallard:lime", incidence.wavelength_nm)?;
        let melanin = crystal.rods()[0].shells[0].eps;
        let host = crystal.host_eps();
        let stack =
            [(host, 0.2801), (melanin, 0.1303), (host, 0.0502), (Complex64::ONE, 0.0604), (melanin, 0.0505)];
        let flat = jones(1.0, &stack, host, &incidence)?;
        let mut depth = 0.0;
        let (mut bodies, mut layers) = (Vec::new(), Vec::new());
        for (eps, thickness) in stack {
            // In two halves, so that the path is that of any slice.
            for x_um in [0.0, 0.1] {
                let outline = Outline::Polygon(vec![
                    [-0.05, 0.0],
                    [0.0501, 0.0],
                    [0.0501, thickness],
                    [-0.05, thickness],
                ]);
                bodies.push(Body { x_um, depth_um: depth, outline, eps });
            }
            layers.push(Layer { top_um: depth, bottom_um: depth + thickness, eps });
            depth += thickness;
        }
        let around = Surroundings::new(0.2, 1.0, host)?;
        modes = modes.max(apart(&rcwa(8, 16).respond_to(&around, &bodies, &incidence)?, &flat));
        let empty = Cell::from_rods(Surroundings::new(0.05, 1.0, host)?, Vec::new())?;
        for (error, per_um) in cells.iter_mut().zip([50.0, 100.0, 150.0]) {
            *error = error.max(apart(&fdtd(per_um).respond_to(&empty, &layers, &incidence)?, &flat));
        }
    }
    planar_row("five layers of keratin, melanin, air", None, modes, cells);
    Ok(())
}

fn energy(solver: &str, points: &str) -> Result<()> {
    let points = points.parse().map_err(|_| Error::input(format!("'{points}' is no number of points")))?;
    // FDTD refuses what is nearer to the horizon.
    let (solver, reach): (Box<dyn CrystalSolver>, f64) = match solver {
        "multipole" => (Box::new(Multipole::default()), 89.9),
        "rcwa" => (Box::new(rcwa(8, 12)), 89.9),
        "fdtd" => (Box::new(Fdtd { estimate: false, ..Fdtd::default() }), 60.0),
        _ => return Err(Error::input(format!("no solver '{solver}'; give multipole, rcwa or fdtd"))),
    };
    let found = balance(&*solver, points, reach.to_radians(), 1, &Unobserved)?;
    println!("{} points within ±{reach}°, {} refused", found.imbalance.len(), found.refused.len());
    for part in [0.5, 0.9, 0.99, 0.999, 1.0] {
        println!("{:>5} % of |R + T + A − 1| ≤ {:.1e}", 100.0 * part, found.quantile(part));
    }
    println!("largest: {}", found.worst);
    for reason in found.refused.iter().take(5) {
        println!("refused: {reason}");
    }
    Ok(())
}
