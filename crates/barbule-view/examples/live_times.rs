//! How long what is computed beside the viewer's window takes: films, individuals, the first colour of means, lobes, meshes.
//!
//! `target/release/examples/live_times` prints milliseconds of the wall's clock, the least of a few runs; half a minute.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what is built in

use std::sync::Arc;
use std::time::Instant;

use barbule::Unobserved;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::campaign::spectrum::Collect;
use barbule::characterize::Catalog;
use barbule::material::Library;
use barbule::open::Opening;
use barbule::progress::Shared;
use barbule::spectrum::Wavelengths;
use barbule::stack::Stack;
use barbule::structure::{Structure, species_names};
use barbule_view::live::{FilmJob, Found, HemisphereJob, IndividualJob, Job, MeanJob, direction_at, run};
use barbule_view::scene::{Bend, FeatherRequest, MOST_TRIANGLES, feather, snake, sphere, vane};
use barbule_view::state::State;

/// Runs of each, of which the least counts.
const RUNS: usize = 3;

fn main() {
    let film = FilmJob {
        stack: Stack::parse("air/20*(melanin:99/keratin:100)/keratin", &Library::builtin()).unwrap(),
        at: Wavelengths::usual(),
        angle: (0..9).map(|k| f64::from(10 * k).to_radians()).collect(),
        individuals: 1,
        seed: 1,
    };
    println!("film of 40 layers, 9 angles:       {:8.1} ms", least(|| whole(&Job::Film(film.clone()))));
    for name in species_names() {
        let structure = Structure::builtin(name).unwrap();
        let one = IndividualJob {
            structure: structure.clone(),
            seed: 1,
            index: 0,
            at: Wavelengths::usual(),
            wavelength_nm: Some(550.0),
            incident: [0.0, 0.3],
        };
        let colour = IndividualJob { wavelength_nm: None, ..one.clone() };
        let mean = MeanJob {
            structure,
            at: Wavelengths::usual(),
            angle: vec![0.0],
            individuals: 50,
            seed: 1,
            collect: Collect::Hemisphere,
        };
        println!(
            "{name:12} colour {:7.1} ms, with its lobe {:7.1} ms; mean's first colour {:7.1} ms",
            least(|| whole(&Job::Individual(Box::new(colour.clone())))),
            least(|| whole(&Job::Individual(Box::new(one.clone())))),
            least(|| first(&Job::Mean(Box::new(mean.clone()))))
        );
    }
    let found = Catalog::default().shipped(&Structure::builtin("starling").unwrap()).unwrap().unwrap();
    let brdf = Arc::new(FeatherBrdf::new(&found.material, Options::default()).unwrap());
    let incident = direction_at([0.2, 0.0]).unwrap();
    let lobe = HemisphereJob { brdf, incident, individual: None, side: 128, at: Wavelengths::usual() };
    println!(
        "lobe of 128 x 128 pixels:          {:8.1} ms",
        least(|| whole(&Job::Hemisphere(Box::new(lobe.clone()))))
    );
    meshes();
}

fn meshes() {
    println!(
        "sphere: {} triangles, {:.1} ms",
        sphere().unwrap().triangles.len(),
        least(|| drop(sphere().unwrap()))
    );
    let bent = || vane(&Bend::USUAL).unwrap();
    println!("vane: {} triangles, {:.1} ms", bent().triangles.len(), least(|| drop(bent())));
    println!(
        "snake: {} triangles, {:.1} ms",
        snake().unwrap().triangles.len(),
        least(|| drop(snake().unwrap()))
    );
    for (name, radius_mm) in
        [("starling", Some(2.5)), ("starling", None), ("mallard", Some(2.5)), ("peafowl", None)]
    {
        let state = State::open(name, &Opening::default(), &Unobserved).unwrap();
        let (of, mut window) = state.feather(&Unobserved).unwrap();
        window.radius_mm = radius_mm;
        let request =
            FeatherRequest { feather: &of, window, zones: None, seed: 1, most_triangles: MOST_TRIANGLES };
        let grown = || feather(&request, &Unobserved).unwrap();
        let (shape, detail) = grown();
        println!(
            "{name} {radius_mm:?} mm: {} triangles, {detail:?}, {:.1} ms",
            shape.triangles.len(),
            least(|| drop(grown()))
        );
    }
}

fn whole(job: &Job) {
    run(job, &Unobserved, &mut |_| {}).unwrap();
}

/// Until the first is found; the rest is stopped.
fn first(job: &Job) {
    let progress = Shared::default();
    let ended = run(job, &progress, &mut |found| {
        assert!(matches!(found, Found::Mean(_)));
        progress.cancel();
    });
    assert!(ended.is_err_and(|error| error.is_interrupted()));
}

/// Least milliseconds of a few runs.
fn least(work: impl Fn()) -> f64 {
    let run = |_| {
        let start = Instant::now();
        work();
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min)
}
