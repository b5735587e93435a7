//! What the window draws in real time against what the renderer draws of the scene that it exports.

use barbule::io::Folder;
use barbule::open::{Opening, material, worn};
use barbule::picture::development;
use barbule::render::picture::bytes;
use barbule::resolve::resolve;
use barbule::scene::description::{ReadyScene, SceneDescription};
use barbule::{Picture, PictureOptions, Unobserved};
use barbule_view::gpu::{Gpu, Target};
use barbule_view::live::{MaterialFound, ShowJob, show};
use barbule_view::show::look;
use barbule_view::stage::Stage;
use barbule_view::state::{Mode, Shown, State};

/// Columns and rows.
const SIZE: [u32; 2] = [48, 48];
/// Samples of the renderer's pixels.
const SAMPLES: u32 = 64;
/// Steps of 255 between the means of blocks of 8 × 8 pixels, in the mean over blocks: 0.35 on the ball, whose rim is of few pixels, and 0.17
/// on the vane.
const STEPS: f64 = 0.6;

fn opening() -> Opening {
    Opening { may_compute: false, ..Opening::default() }
}

/// The picture of the exported scene, sRGB bytes.
fn rendered(state: &State) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let (mut description, files) = state.scene(&Unobserved).unwrap();
    // The automatic one follows highlights, whose noise is the renderer's own.
    let fixed = SceneDescription::parse("preset = 'starling'\nexposure = 0.5").unwrap();
    description.exposure = fixed.exposure;
    for file in files {
        std::fs::write(folder.path().join(file.name), file.text).unwrap();
    }
    let mut dye = |name: &str| {
        let found = material(name, &opening(), &Unobserved)?;
        worn(&found.material, found.hash)
    };
    let scene: ReadyScene =
        resolve(description, &Folder(folder.path().into()), &mut dye, 1, &Unobserved).unwrap();
    let options = PictureOptions { size: SIZE, samples: SAMPLES, ..PictureOptions::default() };
    let picture = Picture::of(&scene, &options, &Unobserved).unwrap();
    bytes(picture.film(), &development(&scene, picture.film()).unwrap()).values
}

/// The picture of the stage at rest.
fn drawn(gpu: Gpu, state: &State) -> Vec<u8> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let found = material("starling", &opening(), &Unobserved).unwrap();
    let found = MaterialFound { found: found.into(), thinned: None };
    let mut made = None;
    show(&ShowJob::of(state, Some(&found)).unwrap(), &Unobserved, &mut |one| made = Some(one)).unwrap();
    let mut stage = Stage::new(gpu, format).unwrap();
    stage.put(&made.unwrap()).unwrap();
    stage.expose(-1.0);
    while stage.draw(SIZE, &look(state.view())).unwrap() {}
    let target = Target::new(stage.gpu(), SIZE, format).unwrap();
    target.draw(stage.gpu(), |pass| stage.paint(pass)).unwrap();
    let bytes = target.read(stage.gpu()).unwrap();
    bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

/// Means of blocks of 8 × 8 pixels, of each channel.
fn blocks(bytes: &[u8]) -> Vec<f64> {
    let [columns, rows] = SIZE.map(|side| side as usize / 8);
    let mut sums = vec![0.0; 3 * columns * rows];
    for (at, byte) in bytes.iter().enumerate() {
        let (pixel, channel) = (at / 3, at % 3);
        let (row, column) = (pixel / SIZE[0] as usize, pixel % SIZE[0] as usize);
        sums[3 * (row / 8 * columns + column / 8) + channel] += f64::from(*byte) / 64.0;
    }
    sums
}

/// Convex and bent surfaces have neither shadows nor light between parts, so both show the same: geometry, frames, tables, lamp and sky,
/// and tone.
#[test]
fn the_renderer_draws_what_the_window_shows() {
    let Ok(gpu) = Gpu::new(None) else {
        println!("skipped: there is no adapter");
        return;
    };
    for (mode, shown) in
        [(Mode::Sphere, Shown::Mean), (Mode::Vane, Shown::Mean), (Mode::Vane, Shown::Individuals)]
    {
        let mut state = State::open("starling", &opening(), &Unobserved).unwrap();
        state.choose(mode, &Unobserved).unwrap();
        state.look("shown", |view| view.shown = shown).unwrap();
        let (own, other) = (blocks(&drawn(gpu.clone(), &state)), blocks(&rendered(&state)));
        let apart: Vec<f64> = own.iter().zip(&other).map(|(a, b)| (a - b).abs()).collect();
        let mean = apart.iter().sum::<f64>() / apart.len() as f64;
        let most = apart.iter().copied().fold(0.0, f64::max);
        println!("{mode:?} {shown:?}: {mean:.2} steps in the mean, {most:.1} at most");
        assert!(mean < STEPS, "{mode:?} {shown:?}: {mean}");
    }
}
