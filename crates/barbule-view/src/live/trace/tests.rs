use super::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use barbule::Unobserved;
use barbule::open::Opening;
use barbule::picture::{Picture, PictureOptions};
use barbule::scene::description::SceneDescription;
use barbule::spectrum::sensor::Sensor;

/// Most time that a picture may go on after it was stopped; a tenth of it on a machine with nothing else to do.
const AT_ONCE: Duration = Duration::from_secs(1);

/// A ball under a lamp, exposed by what it shows.
const BALL: &str = "
    shows_feather = false
    sky = 0.5
    [light]
    azimuth_deg = 300
    elevation_deg = 40
    radius_deg = 5
    strength = 2
    [camera]
    azimuth_deg = 180
    elevation_deg = 20
    width_mm = 26
    [surfaces.skin]
    type = 'diffuse'
    colour = '#a05020'
    [[objects]]
    name = 'ball'
    surface = 'skin'
    sphere_mm = 10
";

fn job(text: &str, size: [u32; 2], samples: u32) -> TraceJob {
    TraceJob {
        scene: SceneDescription::parse(text).unwrap(),
        files: BTreeMap::new(),
        folder: "".into(),
        sensor: Sensor::human(),
        size,
        samples,
        denoise: false,
        is_moving: false,
        whole: false,
        opening: Opening::default(),
    }
}

fn until(condition: impl Fn() -> bool) -> Duration {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never happens");
        std::thread::sleep(Duration::from_millis(1));
    }
    start.elapsed()
}

/// All that is told until the picture is done, or is none.
fn told(tracer: &Tracer) -> Vec<TraceUpdate> {
    let (mut all, start) = (Vec::new(), Instant::now());
    while !matches!(all.last(), Some(TraceUpdate::Done | TraceUpdate::Failed(_))) {
        assert!(start.elapsed() < Duration::from_secs(60), "it never ends: {}", all.len());
        all.extend(tracer.updates());
        std::thread::sleep(Duration::from_millis(1));
    }
    all
}

fn last(updates: &[TraceUpdate]) -> &TracedPicture {
    let picture = |update: &TraceUpdate| matches!(update, TraceUpdate::Picture(_));
    match updates.iter().rfind(|update| picture(update)) {
        Some(TraceUpdate::Picture(picture)) => picture,
        _ => panic!("no picture"),
    }
}

/// The bytes of `barbule render`.
fn rendered(job: &TraceJob) -> Vec<u8> {
    let (ready, _) = job.ready(None, &Unobserved).unwrap();
    let options = PictureOptions {
        size: job.size,
        samples: job.samples,
        seed: job.opening.seed,
        planes: job.planes(),
        ..PictureOptions::default()
    };
    Picture::of(&ready, &options, &Unobserved).unwrap().rgb()
}

fn rgb(picture: &TracedPicture) -> Vec<u8> {
    picture.rgba.chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect()
}

#[test]
fn the_last_picture_has_the_bytes_of_the_renderer() {
    let tracer = Tracer::start(|| {}).unwrap();
    let feather = "preset = 'starling'\n[window]\nalong_mm = 12\nradius_mm = 0.3\n[camera]\nwidth_mm = 0.5";
    for (text, samples) in [(BALL, 5), (feather, 3)] {
        let job = job(text, [24, 16], samples);
        tracer.ask(job.clone());
        let all = told(&tracer);
        let picture = last(&all);
        assert_eq!((picture.size, picture.samples, picture.of), ([24, 16], f64::from(samples), samples));
        assert!(picture.noise.is_some() && !picture.is_small && picture.seconds > 0.0);
        assert_eq!(rgb(picture), rendered(&job));
        assert!(picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255));
        // Samples that are there are kept, and more of them make the same picture.
        tracer.change(|job| job.samples += 4);
        let more = TraceJob { samples: samples + 4, ..job };
        assert_eq!(rgb(last(&told(&tracer))), rendered(&more));
    }
    assert!(!tracer.is_busy());
}

#[test]
fn the_newest_view_wins_and_others_are_given_up() {
    let woken = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&woken);
    let tracer = Tracer::start(move || _ = count.fetch_add(1, Ordering::Relaxed)).unwrap();
    tracer.ask(job(BALL, [64, 48], 1 << 20));
    until(|| tracer.updates().iter().any(|update| matches!(update, TraceUpdate::Picture(_))));
    assert!(woken.load(Ordering::Relaxed) > 0);
    for azimuth_deg in 0..30 {
        tracer.change(|job| job.scene.camera.bearing.azimuth_deg = f64::from(azimuth_deg));
    }
    tracer.change(|job| job.samples = 2);
    let all = told(&tracer);
    let camera = last(&all).camera;
    let towards = (camera.eye - camera.target).normalize();
    let expected =
        SceneDescription::parse(&BALL.replace("azimuth_deg = 180", "azimuth_deg = 29")).unwrap().camera();
    assert!(towards.distance((expected.eye - expected.target).normalize()) < 1e-12);
    assert!(!all.iter().any(|update| matches!(update, TraceUpdate::Failed(_))));
}

/// The least of a few, since whatever else a machine does delays threads.
#[test]
fn it_stops_within_a_tenth_of_a_second() {
    let tracer = Tracer::start(|| {}).unwrap();
    let stopped = |_| {
        tracer.ask(job(BALL, [64, 48], 1 << 20));
        until(|| !tracer.updates().is_empty());
        tracer.stop();
        until(|| !tracer.is_busy())
    };
    let took = (0..4).map(stopped).min().unwrap();
    assert!(took < AT_ONCE, "{took:?}");
    assert!(tracer.updates().is_empty() && !tracer.change(|_| {}));
    let dropped = |_| {
        let tracer = Tracer::start(|| {}).unwrap();
        tracer.ask(job(BALL, [64, 48], 1 << 20));
        until(|| !tracer.updates().is_empty());
        let start = Instant::now();
        drop(tracer);
        start.elapsed()
    };
    let took = (0..4).map(dropped).min().unwrap();
    assert!(took < AT_ONCE, "{took:?}");
}

#[test]
fn a_pause_keeps_what_is_there() {
    let tracer = Tracer::start(|| {}).unwrap();
    let job = job(BALL, [48, 32], 96);
    tracer.ask(job.clone());
    until(|| tracer.progress().is_some_and(|now| now.done > 0));
    tracer.pause(true);
    until(|| !tracer.is_busy());
    assert!(tracer.is_paused() && tracer.progress().is_none());
    let _ = tracer.updates();
    std::thread::sleep(Duration::from_millis(20));
    assert!(tracer.updates().is_empty());
    tracer.pause(false);
    assert_eq!(rgb(last(&told(&tracer))), rendered(&job));
}

/// A desk without threads, for what a studio does in one.
fn desk() -> Desk {
    Desk {
        state: Mutex::default(),
        tracing: Condvar::new(),
        developing: Condvar::new(),
        wake: Box::new(|| {}),
    }
}

fn negative(studio: &mut Studio, desk: &Desk, job: &TraceJob) -> Negative {
    studio.trace(1, job, &Shared::default(), desk).unwrap();
    desk.state().negative.take().unwrap()
}

#[test]
fn what_stands_is_grown_once_for_all_cameras_and_lamps() {
    let (mut studio, desk) = (Studio::default(), desk());
    let mut job = job(BALL, [16, 12], 2);
    assert_eq!(negative(&mut studio, &desk, &job).set, 1);
    job.scene.camera.bearing.azimuth_deg = 90.0;
    job.scene.light.bearing.elevation_deg = 80.0;
    job.size = [20, 10];
    assert_eq!(negative(&mut studio, &desk, &job).set, 1);
    job.scene.sky =
        barbule::scene::description::SkyDescription::Gradient { zenith: 1.0, horizon: 1.0, below: 0.0 };
    assert_eq!(negative(&mut studio, &desk, &job).set, 2);
}

/// A feather is as fine as its picture shows, but not while a hand moves the camera.
#[test]
fn finer_feathers_grow_once_the_hand_lets_go() {
    let near = job("preset = 'starling-feather'\n[camera]\nwidth_mm = 1", [8, 8], 1);
    let far = job("preset = 'starling-feather'\n[camera]\nwidth_mm = 60", [8, 8], 1);
    assert!(far.shows_the_same_as(&near) && !far.stand().serves(&near) && far.stand().serves(&far));
    assert!(far.stand().serves(&TraceJob { is_moving: true, ..near }));
    let starling = job("preset = 'starling'", [8, 8], 1);
    assert!(
        !far.shows_the_same_as(&starling) && !far.stand().serves(&TraceJob { is_moving: true, ..starling })
    );
}

/// A film that is developed only otherwise keeps its samples.
#[test]
fn other_exposures_need_no_other_samples() {
    let (mut studio, desk) = (Studio::default(), desk());
    let mut job = job(BALL, [16, 12], 2);
    let first = negative(&mut studio, &desk, &job).film;
    job.scene.exposure = barbule::scene::description::Exposure::Factor(0.3);
    assert!(Arc::ptr_eq(&first, &negative(&mut studio, &desk, &job).film));
    job.scene.light.strength = 1.0;
    assert!(!Arc::ptr_eq(&first, &negative(&mut studio, &desk, &job).film));
}

#[test]
fn large_pictures_are_small_at_first() {
    let (mut studio, desk) = (Studio::default(), desk());
    let job = job(BALL, [160, 120], 1);
    desk.state().is_paused = true;
    let refused = studio.trace(1, &job, &Shared::default(), &desk).unwrap_err();
    let small = desk.state().negative.take().unwrap();
    assert!(refused.is_interrupted() && small.is_small && small.holds_exposure);
    assert_eq!(small.film.size(), [20, 15]);
}

/// The exposure holds while the camera moves, and is found anew once it stands or a lamp moves.
#[test]
fn pictures_do_not_flicker_while_the_camera_moves() {
    let tracer = Tracer::start(|| {}).unwrap();
    tracer.ask(job(BALL, [24, 16], 4));
    let exposure = last(&told(&tracer)).exposure;
    let moved = |change: &dyn Fn(&mut TraceJob)| {
        tracer.change(change);
        last(&told(&tracer)).exposure
    };
    let turned = |job: &mut TraceJob, is_moving: bool| {
        (job.is_moving, job.scene.camera.bearing.azimuth_deg) = (is_moving, 300.0);
    };
    assert_eq!(moved(&|job| turned(job, true)), exposure);
    assert_ne!(moved(&|job| turned(job, false)), exposure);
    let settled = moved(&|job| turned(job, false));
    assert_ne!(
        moved(&|job| {
            turned(job, true);
            job.scene.light.strength = 0.5;
        }),
        settled
    );
}

#[test]
fn what_is_not_there_or_too_large_is_one_sentence() {
    let tracer = Tracer::start(|| {}).unwrap();
    let refused = |text: &str, size: [u32; 2]| {
        tracer.ask(job(text, size, 1));
        match told(&tracer).pop() {
            Some(TraceUpdate::Failed(error)) => error.to_string(),
            _ => panic!("{text}"),
        }
    };
    let missing = refused(&BALL.replace("sphere_mm = 10", "mesh = 'nowhere.ply'"), [16, 16]);
    assert!(missing.contains("nowhere.ply") && !missing.contains('\n'), "{missing}");
    let unknown = refused("preset = 'starling'\nmaterial = 'starlign'", [16, 16]);
    assert!(unknown.contains("did you mean"), "{unknown}");
    let large = refused(BALL, [16384, 16384]);
    assert!(large.contains("MB of memory") && large.contains("smaller picture"), "{large}");
    assert!(refused(BALL, [0, 16]).contains("each side must be"));
    // The next one is traced all the same, and a film for which there is no room is refused though all else is there.
    tracer.ask(job(BALL, [16, 16], 1));
    assert!(matches!(told(&tracer).last(), Some(TraceUpdate::Done)));
    assert!(refused(BALL, [16384, 16384]).contains("MB of memory"));
}

#[test]
fn files_in_memory_are_read_before_those_of_the_folder() {
    let species = barbule::structure::species_toml("starling").unwrap().to_owned();
    let mut job = job("preset = 'starling'\nmaterial = 'my-starling.toml'", [8, 8], 1);
    job.files.insert("my-starling.toml".into(), species);
    let (ready, thinned) = job.ready(None, &Unobserved).unwrap();
    assert_eq!((ready.material(), thinned), (Some("my-starling.toml"), None));
    let damaged = TraceJob { files: BTreeMap::from([("my-starling.toml".into(), "x".into())]), ..job };
    assert!(damaged.ready(None, &Unobserved).unwrap_err().to_string().contains("my-starling.toml"));
}

#[test]
fn places_of_the_scene_are_where_the_picture_shows_them() {
    let tracer = Tracer::start(|| {}).unwrap();
    tracer.ask(job(BALL, [48, 48], 8));
    let all = told(&tracer);
    let picture = last(&all);
    let place = picture.place([0.5, 0.5]).unwrap();
    assert!((place.length() - 10.0).abs() < 0.2, "{place}");
    assert!(place.normalize().distance((picture.camera.eye - picture.camera.target).normalize()) < 0.1);
    assert!(picture.place([0.01, 0.01]).is_none() && picture.place([1.2, 0.5]).is_none());
}

/// Of a lack of the denoiser people hear, and the picture comes all the same.
#[test]
fn a_picture_is_denoised_where_the_system_can() {
    let tracer = Tracer::start(|| {}).unwrap();
    tracer.ask(TraceJob { denoise: true, ..job(BALL, [32, 24], 4) });
    let all = told(&tracer);
    let note = all.iter().find_map(|update| match update {
        TraceUpdate::Note(note) => Some(note.clone()),
        _ => None,
    });
    match (&last(&all).denoised_by, note) {
        (Some(name), None) => assert!(name.contains("Open Image Denoise")),
        (None, Some(note)) => assert!(note.contains("Open Image Denoise") && !note.contains('\n'), "{note}"),
        other => panic!("{other:?}"),
    }
}
