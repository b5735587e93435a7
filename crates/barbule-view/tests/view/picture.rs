//! Frames without a window: a flat piece of barbules, pixel by pixel against the renderer's own parts.

use barbule_appearance::brdf::fixtures::example;
use barbule_appearance::brdf::{BrdfTables, FeatherBrdf, Options, PlainBrdf};
use barbule_appearance::bsdf::{
    self, Arch, BarbuleSurface, Clad, Hit, Keratin, Layout, Reflectance, Surface,
};
use barbule_appearance::render::tone::to_bytes;
use barbule_appearance::scene::description::ToneWord;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::Observer;
use barbule_light::spectrum::dense::Lambdas;
use barbule_view::gpu::{
    Cells, Coat, Developer, Dress, Exposure, Eye, Feather, Film, Gpu, Mesh, PackedTables, Sight, Surfaces,
    Target, Trim, View, Waves, WavesOnGpu,
};
use barbule_view::scene::{Naming, Part, Shape, Vertex};
use glam::{DVec3, Mat4, Vec3};

/// Columns and rows.
const SIZE: u32 = 64;
/// Side of the piece, mm.
const SIDE_MM: f64 = 0.1;
/// The surface's name.
const NAME: u64 = 0x0123_4567_89ab_cdef;
const LAYOUT: Layout =
    Layout { uv_mm: [SIDE_MM; 2], width_mm: 0.025, length_mm: 0.4, cell_mm: 0.03, swelling: 0.0 };
/// Half precision of light, rounded to eight bits: one step beside the exact value.
const STEPS: i32 = 2;

/// One adapter, all that a frame needs.
struct Frame {
    gpu: Gpu,
    surfaces: Surfaces,
    dress: Dress,
    mesh: [Mesh; 2],
    waves: Waves,
    feather: Feather,
    tables: BrdfTables,
}

/// A piece in the plane z = 0, barbules along y, its upper side on +z; then seen from below.
fn meshes(gpu: &Gpu) -> [Mesh; 2] {
    [[[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]].map(|faces| Mesh::new(gpu, &piece(faces)).unwrap())
}

fn piece(faces: [[u32; 3]; 2]) -> Shape {
    let corner = |u: f32, v: f32| Vertex {
        position_mm: [SIDE_MM as f32 * (v - 0.5), SIDE_MM as f32 * (u - 0.5), 0.0],
        normal: [0.0, 0.0, 1.0],
        tangent: [0.0, 1.0, 0.0],
        place: [u, v],
        swelling: 0.0,
        half_width_mm: 0.0125,
        part: Part::Distal.code(0),
        name: [NAME as u32, (NAME >> 32) as u32],
    };
    let vertices = vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)];
    Shape { vertices, triangles: faces.to_vec(), naming: Naming::Clad(LAYOUT) }
}

fn keratin() -> Keratin {
    Keratin::new(0.3, 1.56, Reflectance::of_colour([0.3, 0.15, 0.05]).unwrap()).unwrap()
}

fn trim(keratin: &Keratin, cells: bsdf::Cells) -> Trim<'_> {
    Trim { cells, keratin }
}

impl Frame {
    fn new() -> Option<Self> {
        let gpu = match Gpu::new(None) {
            Ok(gpu) => gpu,
            Err(error) => {
                println!("skipped: {error}");
                return None;
            }
        };
        let tables = BrdfTables::new(&example(8), Options::default()).unwrap();
        let packed = PackedTables::new(&tables, gpu.most_texels_along()).unwrap();
        let surfaces = Surfaces::new(&gpu).unwrap();
        let keratin = keratin();
        let trim = trim(&keratin, bsdf::Cells::default());
        let dress = Dress::new(&gpu, &trim, &Sight::default()).unwrap();
        Some(Self {
            mesh: meshes(&gpu),
            waves: Waves::new(packed.wavelengths_nm(), &Sight::default(), 16).unwrap(),
            feather: Feather::new(&gpu, &packed).unwrap(),
            surfaces,
            dress,
            gpu,
            tables,
        })
    }

    /// The pixels, row by row, 8 bits.
    fn drawn(&self, view: &View, mesh: usize, exposure: &Exposure) -> Vec<[u8; 4]> {
        self.drawn_in(
            Coat::Feather(&self.feather, &WavesOnGpu::new(&self.gpu, &self.waves)),
            view,
            mesh,
            exposure,
        )
    }

    /// The same in another coat.
    fn drawn_in(&self, coat: Coat<'_>, view: &View, mesh: usize, exposure: &Exposure) -> Vec<[u8; 4]> {
        let gpu = &self.gpu;
        let film = Film::new(gpu, [SIZE; 2]).unwrap();
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let developer = Developer::new(gpu, format).unwrap();
        let target = Target::new(gpu, [SIZE; 2], format).unwrap();
        self.surfaces.look(gpu, view);
        developer.expose(gpu, exposure);
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.surfaces.draw(&mut encoder, &film, &self.mesh[mesh], |_| (coat, &self.dress));
        let loaded = developer.load(gpu, &film);
        developer.gather(&mut encoder, &loaded, 1);
        gpu.queue().submit([encoder.finish()]);
        target.draw(gpu, |pass| developer.develop(pass, &loaded)).unwrap();
        target.read(gpu).unwrap().as_chunks().0.to_vec()
    }
}

const EXPOSURE: Exposure = Exposure { stops: 1.0, tone: ToneWord::Filmic, behind: [0.0; 3] };

fn view(to_eye: Vec3, to_lamp: Vec3) -> View {
    // Flat over the picture, whatever the directions are.
    let scale = (2.0 / SIDE_MM) as f32;
    View {
        clip_from_scene: Mat4::from_translation(Vec3::new(0.0, 0.0, 0.5))
            * Mat4::from_scale(Vec3::new(scale, scale, 0.0)),
        eye: Eye::Towards(to_eye.normalize()),
        to_lamp: to_lamp.normalize(),
        lamp: 1.0,
        sky: [0.2, 0.3, 0.4],
        contrast: 1.0,
        cells: Cells::Clad(LAYOUT),
    }
}

/// Texture coordinates of a pixel.
fn uv(column: i32, row: i32) -> [f64; 2] {
    let size = f64::from(SIZE);
    [1.0 - (f64::from(row) + 0.5) / size, (f64::from(column) + 0.5) / size]
}

fn instance(uv: [f64; 2]) -> u64 {
    let hit = Hit { uv, uv_gradients: [DVec3::Y / SIDE_MM, DVec3::X / SIDE_MM], id: NAME, ..Hit::default() };
    LAYOUT.on_barbule(&hit).instance
}

fn assert_near(found: [u8; 4], linear: [f64; 3], what: &str) {
    let scale = f64::from(EXPOSURE.stops).exp2();
    let expected = to_bytes(EXPOSURE.tone, linear.map(|v| v * scale));
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((i32::from(found) - i32::from(expected)).abs() <= STEPS, "{what}: {found} {expected}");
    }
}

/// Every cell has the individual that the renderer draws there, and its colour.
#[test]
fn pixels_show_the_renderers_individuals() {
    let Some(frame) = Frame::new() else { return };
    let view = view(Vec3::new(0.1, 0.05, 1.0), Vec3::new(-0.25, -0.1, 1.0));
    let pixels = frame.drawn(&view, 0, &EXPOSURE);
    let plain = PlainBrdf::new(&frame.tables);
    let brdf = FeatherBrdf::from_tables(frame.tables.clone());
    let Eye::Towards(to_eye) = view.eye else { panic!("the eye is far away") };
    let (wi, wo) = (to_eye.as_dvec3(), view.to_lamp.as_dvec3());
    let nm = frame.waves.nm();
    let albedo: Vec<f64> = nm.iter().map(|nm| brdf.exact(*nm, wi).reflected()).collect();
    let albedo = frame.waves.linear_rgb(&albedo);
    let mut names = std::collections::BTreeSet::new();
    for (row, column) in (1..SIZE as i32 - 1).flat_map(|row| (1..SIZE as i32 - 1).map(move |k| (row, k))) {
        let name = instance(uv(column, row));
        // Not where cells meet.
        let about = [(1, 1), (1, -1), (-1, 1), (-1, -1)];
        if about.iter().any(|(c, r)| instance(uv(column + c, row + r)) != name) || !names.insert(name) {
            continue;
        }
        let of = |nm: &f64| plain.values(*nm, wi, wo, Some(name)).f;
        let f = frame.waves.linear_rgb(&nm.iter().map(of).collect::<Vec<_>>());
        let light =
            std::array::from_fn(|c| std::f64::consts::PI * wo.z * f[c] + f64::from(view.sky[c]) * albedo[c]);
        let found = pixels[(row * SIZE as i32 + column) as usize];
        assert_near(found, light, &format!("{} row {row} column {column}", frame.gpu));
    }
    assert!(names.len() >= 12, "{} individuals", names.len());
}

/// Walls are keratin, sizes differ and cross-sections are arches as the renderer has them: its own surface at the pixels' middles.
#[test]
fn pixels_show_walls_sizes_and_arches() {
    let Some(frame) = Frame::new() else { return };
    // Grey, so that its colour is the same by any wavelengths.
    let keratin = Keratin::new(0.3, 1.56, Reflectance::of_colour([0.2; 3]).unwrap()).unwrap();
    let arch = Some(Arch { low: -0.9, high: 0.7, blur: 0.3 });
    let cells = bsdf::Cells { size: 0.03, barbule_size: 0.02, wall_mm: 0.006, arch };
    frame.dress.change(&frame.gpu, &trim(&keratin, cells), &Sight::default()).unwrap();
    let view = View { sky: [0.0; 3], ..view(Vec3::new(0.1, 0.05, 1.0), Vec3::new(-0.25, -0.1, 1.0)) };
    let pixels = frame.drawn(&view, 0, &EXPOSURE);
    let barbule = BarbuleSurface {
        brdf: FeatherBrdf::from_tables(frame.tables.clone()).into(),
        instances: true,
        below: None,
        under: keratin.clone(),
        cells,
        opacity: 1.0,
    };
    let surface = Surface::Clad(Box::new(Clad::new(barbule, LAYOUT).unwrap()));
    let Eye::Towards(to_eye) = view.eye else { panic!("the eye is far away") };
    let (wo, wi) = (to_eye.as_dvec3(), view.to_lamp.as_dvec3());
    // Half a pixel.
    let footprint = 0.5 * SIDE_MM / f64::from(SIZE);
    let shone = |column: i32, row: i32| -> [f64; 3] {
        let [u, v] = [DVec3::Y, DVec3::X].map(|axis| axis / SIDE_MM);
        let hit = Hit { uv: uv(column, row), uv_gradients: [u, v], id: NAME, footprint, ..Hit::default() };
        let of = |nm: &f64| surface.bind(&hit, wo, Lambdas::splat(*nm)).eval(wi).f[0];
        let values: Vec<f64> = frame.waves.nm().iter().map(of).collect();
        frame.waves.linear_rgb(&values).map(|v| std::f64::consts::PI * wi.z * v)
    };
    let mut checked = 0;
    for (row, column) in (1..SIZE as i32 - 1).flat_map(|row| (1..SIZE as i32 - 1).map(move |k| (row, k))) {
        let is_wall = |row: i32| {
            let hit =
                Hit { uv: uv(column, row), uv_gradients: [DVec3::Y, DVec3::X], id: NAME, ..Hit::default() };
            let place = LAYOUT.on_barbule(&hit).ribbon.place;
            place.min(1.0 - place) * LAYOUT.cell_mm < 0.5 * cells.wall_mm
        };
        let name = instance(uv(column, row));
        let about = [(1, 1), (1, -1), (-1, 1), (-1, -1)];
        let is_edge = about.iter().any(|(c, r)| instance(uv(column + c, row + r)) != name);
        if is_edge || (-1..=1).any(|k| is_wall(row + k) != is_wall(row)) || (row + column) % 5 != 0 {
            continue;
        }
        let found = pixels[(row * SIZE as i32 + column) as usize];
        assert_near(found, shone(column, row), &format!("{} row {row} column {column}", frame.gpu));
        checked += 1;
    }
    assert!(checked > 100, "{checked}");
}

/// Without contrast all is the mean; with no lamp and no sky, black; beside the mesh, what is behind.
#[test]
fn the_mean_is_even_and_what_is_not_lit_is_black() {
    let Some(frame) = Frame::new() else { return };
    let lit = view(Vec3::Z, Vec3::new(0.2, 0.1, 1.0));
    let mean = frame.drawn(&View { contrast: 0.0, ..lit }, 0, &EXPOSURE);
    assert!(mean.iter().all(|pixel| *pixel == mean[0]) && mean[0] != [0, 0, 0, 255], "{:?}", mean[0]);
    let dark = frame.drawn(&View { lamp: 0.0, sky: [0.0; 3], ..lit }, 0, &EXPOSURE);
    assert!(dark.iter().all(|pixel| *pixel == [0, 0, 0, 255]), "{:?}", dark[0]);
    let away = Mat4::from_translation(Vec3::new(3.0, 0.0, 0.5));
    let behind = Exposure { behind: [0.1, 0.2, 0.3], ..EXPOSURE };
    let empty = frame.drawn(&View { clip_from_scene: away, ..lit }, 0, &behind);
    assert_near(empty[5], [0.1, 0.2, 0.3], "behind");
}

#[test]
fn undersides_are_keratin() {
    let Some(frame) = Frame::new() else { return };
    let view = view(Vec3::new(0.2, 0.1, -1.0), Vec3::new(-0.1, 0.3, -1.0));
    let pixels = frame.drawn(&view, 1, &EXPOSURE);
    let whole = frame.drawn_in(Coat::Keratin, &view, 1, &EXPOSURE);
    assert_eq!(pixels, whole, "what has no coat is keratin, as undersides are");
    let keratin = keratin();
    let Eye::Towards(to_eye) = view.eye else { panic!("the eye is far away") };
    // The lower side's frame is the upper one's turned about y.
    let [wi, wo] = [to_eye, view.to_lamp].map(|w| DVec3::new(-1.0, 1.0, -1.0) * w.as_dvec3());
    let wavelengths = Wavelengths::new((360..=830).map(f64::from).collect::<Vec<_>>()).unwrap();
    let weights = Observer::default().weights(&wavelengths);
    let of = |nm: &f64| keratin.eval(wi, wo, Lambdas::splat(*nm)).0[0];
    let f = weights.linear_rgb(&wavelengths.nm().iter().map(of).collect::<Vec<_>>());
    let (boundary, _) = keratin.boundary();
    let at = 32.0 * wi.z;
    let low = (at as usize).min(31);
    let boundary = boundary[low] + (boundary[low + 1] - boundary[low]) * (at - low as f64);
    let of = |nm: &f64| boundary + (1.0 - boundary) * keratin.body().at(*nm);
    let albedo = weights.linear_rgb(&wavelengths.nm().iter().map(of).collect::<Vec<_>>());
    let light =
        std::array::from_fn(|c| std::f64::consts::PI * wo.z * f[c] + f64::from(view.sky[c]) * albedo[c]);
    assert_near(pixels[(SIZE * SIZE / 2 + SIZE / 2) as usize], light, "underside");
}

#[test]
fn meshes_that_are_none_are_refused() {
    let Some(frame) = Frame::new() else { return };
    let refused = Mesh::new(&frame.gpu, &piece([[0, 1, 2], [0, 1, 4]])).unwrap_err().to_string();
    assert!(refused.contains("corner 4 does not exist"), "{refused}");
}

/// The mean of frames is their mean: of two exposures' worth of light, each pixel is half way between.
#[test]
fn frames_are_gathered_into_their_mean() {
    let Some(frame) = Frame::new() else { return };
    let gpu = &frame.gpu;
    let (film, format) = (Film::new(gpu, [SIZE; 2]).unwrap(), wgpu::TextureFormat::Rgba8Unorm);
    let developer = Developer::new(gpu, format).unwrap();
    let target = Target::new(gpu, [SIZE; 2], format).unwrap();
    let (waves, loaded) = (WavesOnGpu::new(gpu, &frame.waves), developer.load(gpu, &film));
    let lit = View { contrast: 0.0, sky: [0.0; 3], ..view(Vec3::Z, Vec3::new(0.2, 0.1, 1.0)) };
    developer.expose(gpu, &Exposure { stops: -2.0, tone: ToneWord::Plain, behind: [0.0; 3] });
    let gathered = |lamps: &[f32]| {
        for (count, lamp) in (1..).zip(lamps) {
            frame.surfaces.look(gpu, &View { lamp: *lamp, ..lit });
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let coat = Coat::Feather(&frame.feather, &waves);
            frame.surfaces.draw(&mut encoder, &film, &frame.mesh[0], |_| (coat, &frame.dress));
            developer.gather(&mut encoder, &loaded, count);
            gpu.queue().submit([encoder.finish()]);
        }
        target.draw(gpu, |pass| developer.develop(pass, &loaded)).unwrap();
        target.read(gpu).unwrap()[..4].to_vec()
    };
    let (several, one) = (gathered(&[0.2, 1.0, 0.6, 0.2]), gathered(&[0.5]));
    assert!(several.iter().zip(&one).all(|(a, b)| a.abs_diff(*b) <= 1), "{several:?} {one:?}");
    assert!(one[..3].iter().any(|v| (20..250).contains(v)), "{one:?}");
}
