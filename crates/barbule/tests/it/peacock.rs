//! A peacock's feather by its three models.

use barbule::io::Folder;
use barbule::open::{Opening, material, worn};
use barbule::render::planes::{Bands, Planes};
use barbule::scene::description::{Background, ObjectShape};
use barbule::scene::feather::VaneDisc;
use barbule::scene::preset;
use barbule::spectrum::sensor::Sensor;
use barbule::{Picture, PictureOptions, SceneDescription, Unobserved, resolve};

use crate::measure::peacock_film::{halved, row};

/// The table of docs/theory/peacock.md, held against numbers that were computed beforehand by another program.
#[test]
fn the_film_of_2005_departs_from_a_film_as_was_computed_beforehand() {
    for (angle, peak, highest, correlation, ratio) in [
        (0.0, Some(431.0), 0.148, Some(-0.67), Some(5.8)),
        (30.0, Some(410.0), 0.160, Some(-0.37), Some(4.6)),
        (45.0, None, 0.185, None, None),
        (60.0, None, 0.271, Some(0.57), Some(2.2)),
    ] {
        let found = row(angle).unwrap();
        println!(
            "{angle}: {} {:?} {} {:?} {} {}",
            found.peak_nm, found.colour, found.highest, found.film_colour, found.correlation, found.ratio
        );
        assert!(peak.is_none_or(|peak| (found.peak_nm - peak).abs() <= 3.0), "{}", found.peak_nm);
        assert!((found.highest - highest).abs() < 1e-3, "{}", found.highest);
        assert!(correlation.is_none_or(|c| (found.correlation - c).abs() < 0.02), "{}", found.correlation);
        assert!(ratio.is_none_or(|ratio| (found.ratio - ratio).abs() < 0.1), "{}", found.ratio);
    }
    let halved = halved().unwrap();
    assert!(
        halved.correlation > 0.999 && halved.absolute < 0.0155,
        "{} {}",
        halved.correlation,
        halved.absolute
    );
    assert!((halved.relative - 0.09).abs() < 0.005, "{}", halved.relative);
}

/// The mean wavelength of the light of 384 to 439 nm from a patch of the pupil, nm: straight on, and at 60°, each in the mirror of a wide
/// white lamp.
fn pupil_nm(model: &str) -> [f64; 2] {
    let name = preset::by_model("peacock", model).unwrap();
    [0.0, 60.0].map(|angle| {
        let bearing =
            |azimuth: f64| format!("azimuth_deg = {azimuth}\nelevation_deg = {}\n", 90.0 - angle);
        let text = format!(
            "preset = '{name}'\nsky = 0.0\n[light]\nstrength = 0.0\n[[lights]]\ntype = 'sun'\nradius_deg = 20.0\n\
             strength = 1.0\nilluminant = 'E'\n{}[camera]\nwidth_mm = 2.0\ntarget_mm = [0.0, {}, 0.0]\n{}",
            bearing(0.0),
            if model == "film-2005" { 66.0 } else { 0.0 },
            bearing(180.0),
        );
        let mut description = SceneDescription::parse(&text).unwrap();
        description.background = Background::Colour([0.0; 3]);
        if model == "film-2005" {
            description.objects.retain(|object| !matches!(object.shape, ObjectShape::Feather(_)));
        }
        for object in &mut description.objects {
            if let ObjectShape::Feather(of) = &mut object.shape {
                // About the pupil, where the disk's middle lies.
                of.window = VaneDisc { along_mm: 1186.0, radius_mm: Some(4.0) };
            }
        }
        let mut dye = |name: &str| {
            let found = material(name, &Opening::default(), &Unobserved)?;
            worn(&found.material, found.hash)
        };
        let ready = resolve::resolve(description, &Folder::default(), &mut dye, 1, &Unobserved).unwrap();
        let nm: Vec<f64> = (0..6).map(|k| 384.0 + 11.0 * f64::from(k)).collect();
        let sensor = Sensor::human();
        let spectral = Bands::new(&nm, sensor.band()).unwrap();
        let planes = Planes { sensor, compositing: false, spectral };
        let options = PictureOptions { size: [16, 16], samples: 32, planes, ..PictureOptions::default() };
        let picture = Picture::of(&ready, &options, &Unobserved).unwrap();
        let mut sums = vec![0.0; nm.len()];
        for at in 0..256 {
            let spectrum = picture.film().spectrum(at % 16, at / 16);
            sums.iter_mut().zip(spectrum).for_each(|(sum, value)| *sum += value);
        }
        let all: f64 = sums.iter().sum();
        assert!(all > 0.0, "{model} {angle}");
        sums.iter().zip(&nm).map(|(value, nm)| value * nm).sum::<f64>() / all
    })
}

/// By every model the pupil's blue moves to shorter wavelengths when it is seen obliquely.
#[test]
fn the_pupil_is_bluer_when_seen_obliquely() {
    for model in preset::models() {
        let [straight, oblique] = pupil_nm(model);
        println!("{model}: {straight:.1} nm, {oblique:.1} nm");
        assert!(oblique < straight - 4.0, "{model}: {straight} {oblique}");
    }
}

#[test]
fn models_are_refused_where_there_are_none() {
    let message = |scene: &str, model: &str| preset::by_model(scene, model).unwrap_err().to_string();
    assert!(message("starling", "film").contains("'starling' has no models"));
    assert!(message("peacock", "flim").contains("did you mean 'film'"));
    assert_eq!(preset::by_model("peacock", "barbule").unwrap(), "peacock");
    assert_eq!(preset::by_model("peacock", "film-2005").unwrap(), "peacock-film-2005");
    // Each is a preset, and all show a whole eye under the same camera.
    let camera =
        |model: &str| SceneDescription::named(&preset::by_model("peacock", model).unwrap()).unwrap().camera;
    assert!(preset::models().all(|model| camera(model) == camera("barbule")));
}
