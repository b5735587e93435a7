//! Gratings: how wide the light of an order is in pictures, and how bright it is by the scalar sum and by Maxwell's equations.

use barbule::io::Folder;
use barbule::solve::crystal::Rcwa;
use barbule::solve::diffraction::{OrderPower, ridge_orders};
use barbule::structure::{Fingers, Heightfield};
use barbule::{Picture, PictureOptions, SceneDescription, Unobserved, resolve};

/// Radius of the ball, mm.
const BALL_MM: f64 = 100.0;
const SIZE: [u32; 2] = [64, 36];

/// Second moment of the mirrored order's light across the plane of incidence, in squared direction cosines: a large ball of a sinusoidal
/// grating under a lamp of this angular radius, 60° from its normal, seen from as far on the other side. The picture is as wide as the order and no wider, so that most samples tell.
fn second_moment(radius_deg: f64, coherence_um: f64, width_mm: f64) -> f64 {
    let text = format!(
        "preset = 'starling'\nshows_feather = false\nsky = 0\nlights = []\nbackground = 'none'\nscatterings = 1\nexposure = 1\n\
         [light]\nazimuth_deg = 180\nelevation_deg = 30\nradius_deg = {radius_deg}\nstrength = 1\n\
         [camera]\nazimuth_deg = 0\nelevation_deg = 30\nroll_deg = 180\nwidth_mm = {width_mm}\nlens = 0\nprojection = 'orthographic'\n\
         target_mm = [0, 0, 0]\n\
         [surfaces.scale]\ntype = 'grating'\nsample = 'sinusoid'\ncoherence_um = {coherence_um}\n\
         [[objects]]\nsphere_mm = {BALL_MM}\nsurface = 'scale'\nrotate_deg = [90, 0, 0]\ntranslate_mm = [0, 0, -{BALL_MM}]\n"
    );
    let description = SceneDescription::parse(&text).unwrap();
    let mut none = |name: &str| panic!("no material is worn, but '{name}' asked for");
    let ready = resolve(description, &Folder::default(), &mut none, 1, &Unobserved).unwrap();
    let options = PictureOptions { size: SIZE, samples: 80, ..PictureOptions::default() };
    let picture = Picture::of(&ready, &options, &Unobserved).unwrap();
    let (mut whole, mut second) = (0.0, 0.0);
    for x in 0..SIZE[0] {
        let across_mm = ((f64::from(x) + 0.5) / f64::from(SIZE[0]) - 0.5) * width_mm;
        // A normal that leans by t turns the frequency by 2 cosθ t, and cosθ is ½.
        let cosine = across_mm / BALL_MM;
        for y in 0..SIZE[1] {
            let light = picture.film().xyz(x, y)[1];
            whole += light;
            second += light * cosine * cosine;
        }
    }
    second / whole
}

/// The lobe is the coherence's Gaussian (λ s_f/√2 in direction cosines) and the lamp's disc (a²/4 along an axis), each once.
#[test]
fn a_lamps_disc_widens_an_order_once() {
    let window = |wavelength_um: f64, coherence_um: f64| {
        (wavelength_um / (std::f64::consts::TAU * coherence_um)).powi(2) / 2.0
    };
    let disc = |radius_deg: f64| f64::to_radians(radius_deg).powi(2) / 4.0;
    let small = second_moment(0.1, 16.25, 4.0) - disc(0.1);
    // As much of the light as there is of each wavelength, which the eye sees about 560 nm and the grating's mirrored order favours red.
    assert!((window(0.55, 16.25)..window(0.61, 16.25)).contains(&small), "{small}");
    let sun = second_moment(0.266, 16.25, 4.4) - disc(0.266);
    assert!((sun / small - 1.0).abs() < 0.02, "{sun} {small}");
    let wide = second_moment(0.8, 16.25, 6.4) - small;
    assert!((wide / disc(0.8) - 1.0).abs() < 0.02, "{wide} {}", disc(0.8));
    // A window so wide that the lamp alone is seen.
    let lamp = second_moment(0.8, 200.0, 3.4);
    println!(
        "sun {:.4}, wide {:.4}, lamp {:.4}",
        sun / small - 1.0,
        wide / disc(0.8) - 1.0,
        lamp / disc(0.8) - 1.0
    );
    assert!((lamp / disc(0.8) - 1.0).abs() < 0.02, "{lamp} {}", disc(0.8));
}

/// What docs/theory/diffraction.md says of the samples, at 550 nm: ridges wider than the wavelength have their orders within a few hundredths, the
/// fingers of Xenopeltis, narrower than it, an order a fifth too bright and with the wrong polarization. Exact powers are those of
/// `examples/scalar_limits.rs`, within its own estimate of 3e-4.
#[test]
fn the_scalar_sum_holds_for_ridges_wider_than_the_wavelength() {
    let solver = Rcwa { orders: 22, slices: 20, estimate: false };
    let orders = |period: &Heightfield, deg: f64| {
        ridge_orders(period, 1.56, 550.0, deg.to_radians(), &solver).unwrap()
    };
    let sinusoid = orders(&Heightfield::sinusoid(2.5, 0.123, 1, 120).unwrap(), 0.0);
    let rows = orders(&Fingers::XENOPELTIS.along(120).unwrap(), 30.0);
    let elaphe = orders(&Fingers::ELAPHE.across(120).unwrap(), 0.0);
    for (name, found, misplaced) in [
        ("sinusoid", &sinusoid, 0.010),
        ("xenopeltis rows", &rows, 0.036),
        ("elaphe fingers", &elaphe, 0.014),
    ] {
        let share = found.misplaced(OrderPower::unpolarized);
        assert!((share - misplaced).abs() < 0.006, "{name}: {share} for {misplaced}");
    }
    let fingers = orders(&Fingers::XENOPELTIS.across(120).unwrap(), 30.0);
    let first = fingers.orders.iter().find(|order| order.m == 1).unwrap();
    let [scalar, exact] = first.unpolarized();
    assert!((scalar - 0.0106).abs() < 1e-4 && (exact - 0.00876).abs() < 3e-4, "{first:?}");
    assert!(first.scalar[0] > first.scalar[1] && first.exact[0] < 0.7 * first.exact[1], "{first:?}");
}
