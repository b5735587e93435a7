//! A picture has the same bits however it is run: on any number of threads, interrupted, in parts, on a stage that others used.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::progress::{Progress, Shard, Unobserved};
use barbule::render::checkpoint;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Technique, Transport};
use barbule::render::planes::Planes;
use barbule::render::run::{Ended, Goal, is_done, run};

use crate::measure::picture::close_up;
use crate::small_scenes::{Ready, film, luminance};

fn starling() -> Ready {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut description = close_up();
    description.lone_feather_mut().unwrap().window.radius_mm = Some(0.7);
    description.camera.width_mm = 1.0;
    Ready::new(description.wearing(brdf).unwrap().scene(7).unwrap().0)
}

#[test]
fn the_picture_is_the_same_bits_for_any_number_of_threads() {
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| film(&starling().integrator(5, Technique::Both), [70, 40], 8))
    };
    let one = picture(1);
    assert!(luminance(&one).0 > 0.0);
    assert_eq!(one, picture(2));
    assert_eq!(one, picture(5));
}

/// Stops after some steps of progress.
struct Impatient(AtomicU64);

impl Progress for Impatient {
    fn begin(&self, _label: &str, _total: u64) {}
    fn advance(&self, steps: u64) {
        self.0.fetch_sub(steps.min(self.0.load(Ordering::SeqCst)), Ordering::SeqCst);
    }
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }
}

#[test]
fn an_interrupted_picture_goes_on_to_the_same_bits() {
    let scene = starling();
    let integrator = scene.integrator(5, Technique::Both);
    let goal = Goal { noise: Some(0.08), ..Goal::samples(36) };
    let mut whole = Film::new([70, 40]).unwrap();
    run(&integrator, &mut whole, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let name = checkpoint::name(&close_up(), 1, "", &Planes::default());
    let mut part = Film::new([70, 40]).unwrap();
    for patience in [8, 12, 6] {
        let ended =
            run(&integrator, &mut part, 3, goal, &Impatient(AtomicU64::new(patience)), &mut |_| Ok(()));
        assert_eq!(ended.unwrap(), Ended::Stopped);
        let bytes = checkpoint::write(&part, &name);
        part = checkpoint::read(&bytes, &name, Film::new([70, 40]).unwrap()).unwrap();
    }
    assert_ne!(part, whole);
    assert_eq!(run(&integrator, &mut part, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap(), Ended::Done);
    assert_eq!(part, whole);
}

/// Each part of a picture, stopped and read back on the way, with tiles that end by their noise: together they are the picture.
#[test]
fn parts_that_were_interrupted_are_together_the_picture() {
    let scene = starling();
    let integrator = scene.integrator(5, Technique::Both);
    let goal = Goal { noise: Some(0.08), ..Goal::samples(24) };
    let size = [100, 70];
    let mut whole = Film::new(size).unwrap();
    run(&integrator, &mut whole, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let name = checkpoint::name(&close_up(), 1, "", &Planes::default());
    for of in [1, 2, 5] {
        let mut joined = Film::new(size).unwrap();
        for shard in (0..of).map(|number| Shard::new(number, of).unwrap()) {
            let empty = || Film::part(size, Planes::default(), shard).unwrap();
            let mut part = empty();
            assert!(!is_done(&part, &goal));
            let patience = Impatient(AtomicU64::new(10));
            run(&integrator, &mut part, 3, goal, &patience, &mut |_| Ok(())).unwrap();
            part = checkpoint::read(&checkpoint::write(&part, &name), &name, empty()).unwrap();
            run(&integrator, &mut part, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap();
            assert!(is_done(&part, &goal));
            joined.join(part).unwrap();
        }
        assert!(joined == whole, "of {of}");
    }
}

/// A stage is made once: under other lamps and from elsewhere it shows what a stage of its own shows.
#[test]
fn one_stage_serves_every_light_and_camera() {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut description = close_up();
    description.lone_feather_mut().unwrap().window.radius_mm = Some(0.5);
    description.camera.width_mm = 0.8;
    let shared = Ready::new(description.clone().wearing(brdf.clone()).unwrap().scene(7).unwrap().0);
    let mut last = None;
    for turn_deg in [0.0, 120.0, 240.0] {
        let mut turned = description.clone();
        turned.light.bearing.azimuth_deg += turn_deg;
        turned.camera.bearing.azimuth_deg += 0.5 * turn_deg;
        let lighting = shared
            .lighting
            .with_lamps(turned.clone().wearing(brdf.clone()).unwrap().lamps().unwrap())
            .unwrap();
        let camera = turned.camera();
        let integrator = Integrator::new(&shared.stage, &lighting, &camera, Transport::default());
        let relit = film(&integrator, [40, 24], 4);
        let own = Ready::new(turned.wearing(brdf.clone()).unwrap().scene(7).unwrap().0);
        assert_eq!(relit, film(&own.integrator(5, Technique::Both), [40, 24], 4));
        assert_ne!(last.as_ref(), Some(&relit));
        last = Some(relit);
    }
}

/// The left tile sees only the sky, the right one also glinting barbules.
#[test]
fn a_noise_target_leaves_easy_tiles_early() {
    let mut scene = starling();
    // Sideways, until the feather's disc of 1.4 mm fills the right tile's half of a picture of 3 mm only.
    let aside = (scene.camera.target - scene.camera.eye).cross(scene.camera.up).normalize() * 0.75;
    scene.camera.width_mm = 3.0;
    scene.camera.eye -= aside;
    scene.camera.target -= aside;
    let integrator = scene.integrator(5, Technique::Both);
    let mut film = Film::new([64, 32]).unwrap();
    let goal = Goal { noise: Some(0.02), ..Goal::samples(64) };
    run(&integrator, &mut film, 1, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let hits = |x0: u32| (0..32 * 32).map(|i| film.pixel(x0 + i % 32, i / 32).hits).sum::<u32>();
    assert!(hits(0) < hits(32) / 20, "{} {}", hits(0), hits(32));
    assert_eq!([film.count(0, 0), film.count(32, 0)], [16, 64]);
}
