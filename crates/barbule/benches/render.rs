//! The renderer in figures: paths per second and core on a close-up of barbules, and how they divide.
//! `cargo bench -p barbule --bench render [PRESET]`

#![allow(clippy::print_stdout)] // its output is its result

use std::sync::Arc;
use std::time::Instant;

use barbule::brdf::{FeatherBrdf, Options, example};
use barbule::observer::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::Integrator;
use barbule::render::run::{Goal, run};
use barbule::scene::preset;

/// Paths per second of wall time.
fn measure(threads: usize, size: [u32; 2], samples: u32, integrator: &Integrator<'_>) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut film = Film::new(size).expect("a film");
    let goal = Goal { samples, noise: None, time: None };
    let begun = Instant::now();
    pool.install(|| run(integrator, &mut film, 1, goal, &Unobserved, &mut |_| Ok(()))).expect("a picture");
    film.samples() as f64 / begun.elapsed().as_secs_f64()
}

fn main() {
    let wanted = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_else(|| "starling".into());
    let begun = Instant::now();
    let brdf = Arc::new(FeatherBrdf::new(&example(50), Options::default()).expect("a material"));
    println!("material ready in {:.2} s", begun.elapsed().as_secs_f64());
    let begun = Instant::now();
    let (scene, counts) = preset::named(&wanted).expect("a preset").scene(brdf, 1).expect("a scene");
    println!(
        "{wanted}: {} barbs, {} barbules, {} primitives grown in {:.2} s",
        counts.barbs,
        counts.barbules,
        scene.geometry.primitives(),
        begun.elapsed().as_secs_f64()
    );
    let begun = Instant::now();
    let integrator = Integrator::new(&scene);
    println!("hierarchy built in {:.2} s", begun.elapsed().as_secs_f64());
    for threads in [1, 2] {
        let speed = measure(threads, [640, 400], 8, &integrator);
        println!("{threads} thread(s): {:.3} M paths/s", 1e-6 * speed);
    }
}
