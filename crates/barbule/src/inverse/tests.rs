//! What is simulated, made noisy and scaled is found again.

use super::planar::Planar;
use super::*;
use crate::Unobserved;
use crate::campaign::spectrum::Collect;
use crate::film::{Polarization, response};
use crate::instrument::Instrument;
use crate::math::rng::Stream;
use crate::spectrum::Wavelengths;
use crate::stack::Stack;
use crate::structure::SpeciesFile;

/// How spectra are made noisy: relative to their mean, with a correlation length in nm.
#[derive(Clone, Copy)]
struct Errors {
    part: f64,
    correlation_nm: f64,
}

const QUIET: Errors = Errors { part: 0.0, correlation_nm: 0.0 };

fn nm(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..).map(|k| from + step * f64::from(k)).take_while(|nm| *nm <= to + 1e-9).collect()
}

fn straight(degrees: f64) -> Vec<Beam> {
    vec![Beam { direction: (0.0, degrees.to_radians()), weight: 1.0 }]
}

/// What a stack reads, by [`response`], which keeps the whole balance and shares no derivative with the fit.
fn reading(
    text: &str,
    nm: &[f64],
    beams: Vec<Beam>,
    level: f64,
    errors: Errors,
    stream: &mut Stream,
) -> Reading {
    let stack = Stack::parse(text, &Library::builtin()).unwrap();
    let at = |&nm: &f64| -> f64 {
        let of =
            |beam: &Beam, polarization| response(&stack, nm, beam.angle(), polarization).unwrap().reflected;
        let both =
            |beam: &Beam| Polarization::BOTH.iter().map(|p| 0.5 * beam.weight * of(beam, *p)).sum::<f64>();
        beams.iter().map(both).sum()
    };
    let exact: Vec<f64> = nm.iter().map(at).collect();
    let size = errors.part * exact.iter().sum::<f64>() / exact.len() as f64;
    let kept =
        if errors.correlation_nm > 0.0 { (-(nm[1] - nm[0]) / errors.correlation_nm).exp() } else { 0.0 };
    let mut error = stream.normal();
    let noisy = exact.iter().map(|value| {
        error = kept * error + (1.0 - kept * kept).sqrt() * stream.normal();
        level * (value + size * error)
    });
    let noisy = noisy.collect();
    let curve = Spectrum::new(Wavelengths::new(nm.to_vec()).unwrap(), noisy).unwrap();
    Reading::new("m", &curve, &[], beams, None).unwrap()
}

fn fitted(text: &str, usual_nm: [f64; 2], readings: &[Reading], settings: &Settings) -> Fit {
    fit_stack(text, usual_nm, &Library::builtin(), readings, settings).unwrap().fit
}

fn holds(solution: &Solution, truth: &[f64]) -> usize {
    solution.sizes.iter().zip(truth).filter(|(size, true_)| (size.low..=size.high).contains(true_)).count()
}

/// Sizes of truths that lie within the intervals of the best solution, and of whichever that fits as well.
fn covered(fit: &Fit, truth: &[f64]) -> [usize; 2] {
    let as_good = fit.solutions.iter().filter(|solution| solution.as_good);
    [holds(&fit.solutions[0], truth), as_good.map(|solution| holds(solution, truth)).max().unwrap_or(0)]
}

/// 95 of 100 are expected; that fewer than 90 are is one in forty for an honest interval.
#[test]
fn films_are_found_within_their_intervals() {
    let mut found = [0; 2];
    for k in 0..100 {
        let mut stream = Stream::new(1, &[k]);
        let thickness = stream.uniform(80.0, 2500.0);
        let level = stream.uniform(0.3, 1.2);
        let errors = Errors { part: 0.03, correlation_nm: if k % 4 == 0 { 0.0 } else { 30.0 } };
        let text = format!("air/keratin:{thickness}/air");
        let reading = reading(&text, &nm(300.0, 700.0, 5.0), straight(0.0), level, errors, &mut stream);
        let fit = fitted(FILM, FILM_NM, &[reading], &Settings::default());
        let [best, any] = covered(&fit, &[thickness]);
        found[0] += best;
        found[1] += any;
    }
    assert!((90..=99).contains(&found[0]) && found[1] >= found[0], "{found:?}");
}

#[test]
fn multilayers_are_found_within_their_intervals() {
    let mut found = 0;
    for k in 0..15 {
        let mut stream = Stream::new(2, &[k]);
        let [melanin, keratin] = [stream.uniform(60.0, 180.0), stream.uniform(60.0, 180.0)];
        let errors = Errors { part: 0.03, correlation_nm: 10.0 };
        let text = format!("air/keratin:10/6*(melanin:{melanin}/keratin:{keratin})/keratin");
        let reading = reading(&text, &nm(300.0, 700.0, 10.0), straight(0.0), 0.7, errors, &mut stream);
        let open = "air/keratin:10/6*(melanin:?/keratin:?)/keratin";
        let fit = fitted(open, [40.0, 220.0], &[reading], &Settings::default());
        found += covered(&fit, &[melanin, keratin])[1];
    }
    assert!(found >= 26, "{found} of 30");
}

/// Of a narrow band and noise several orders fit; the true one is among them, and a wider band decides.
#[test]
fn what_a_narrow_band_leaves_open_is_said_and_a_wide_one_decides() {
    let errors = Errors { part: 0.15, correlation_nm: 0.0 };
    let of = |nm: &[f64], seed| {
        let text = "air/keratin:1220/air";
        let reading = reading(text, nm, straight(0.0), 0.5, errors, &mut Stream::new(seed, &[3]));
        fitted(FILM, FILM_NM, &[reading], &Settings::default())
    };
    let narrow = of(&nm(530.0, 570.0, 2.0), 4);
    let as_good = narrow.solutions.iter().filter(|solution| solution.as_good);
    assert!(as_good.clone().count() > 1);
    assert!(as_good.clone().any(|solution| holds(solution, &[1220.0]) == 1));
    assert!(
        narrow.doubts.iter().any(|doubt| doubt.contains("fit as well as each other")),
        "{:?}",
        narrow.doubts
    );
    let wide = of(&nm(300.0, 700.0, 2.0), 4);
    assert_eq!(wide.solutions.iter().filter(|solution| solution.as_good).count(), 1);
    assert_eq!(holds(&wide.solutions[0], &[1220.0]), 1);
    assert!(wide.solutions.windows(2).all(|pair| pair[0].worse_by <= pair[1].worse_by));
}

/// Every kind of place, against differences of the values.
#[test]
fn slopes_are_those_of_the_values() {
    let library = Library::builtin();
    let text = "air/keratin:200..400±5..20/3*(melanin:50..150/mix(keratin,air,0.2..0.6):80..90)/1.3..1.6";
    let template = Template::parse(text, LAYER_NM, &library).unwrap();
    let beams =
        vec![Beam { direction: (0.2, 0.4), weight: 0.7 }, Beam { direction: (0.0, 0.1), weight: 0.4 }];
    let reading =
        reading("air/keratin:300/air", &nm(320.0, 680.0, 40.0), beams, 1.0, QUIET, &mut Stream::new(1, &[]));
    let model = Planar::new(template, std::slice::from_ref(&reading), &library).unwrap();
    let sizes = [310.0, 12.0, 90.0, 0.35, 85.0, 1.45];
    assert_eq!(model.parameters().len(), sizes.len());
    let count = reading.nm().len();
    let (mut values, mut slopes) = (vec![0.0; count], vec![vec![0.0; count]; sizes.len()]);
    model.slopes(&sizes, &mut values, &mut slopes).unwrap();
    let mut alone = vec![0.0; count];
    model.values(&sizes, &mut alone).unwrap();
    assert!(values.iter().zip(&alone).all(|(a, b)| (a - b).abs() < 1e-13));
    for (k, slope) in slopes.iter().enumerate() {
        let step = 1e-4 * sizes[k];
        let moved = |sign: f64| {
            let mut to = sizes;
            to[k] += sign * step;
            let mut values = vec![0.0; count];
            model.values(&to, &mut values).unwrap();
            values
        };
        let (more, less) = (moved(1.0), moved(-1.0));
        let largest = slope.iter().map(|v| v.abs()).fold(0.0, f64::max);
        for i in 0..count {
            let difference = (more[i] - less[i]) / (2.0 * step);
            assert!((slope[i] - difference).abs() < 1e-5 * largest, "{k} {i}: {} {difference}", slope[i]);
        }
    }
}

/// A film whose thickness spreads, by equally likely individuals, against the quadrature of the fit.
#[test]
fn spreading_films_are_averaged_as_their_individuals_are() {
    let at = nm(300.0, 700.0, 8.0);
    let count = 1000;
    let mut mean = vec![0.0; at.len()];
    for k in 0..count {
        let deviate = crate::math::normal::quantile((f64::from(k) + 0.5) / f64::from(count));
        let thickness = 700.0 + 35.0 * deviate.clamp(-3.0, 3.0);
        let one = Stack::parse(&format!("air/keratin:{thickness}/air"), &Library::builtin()).unwrap();
        for (mean, &nm) in mean.iter_mut().zip(&at) {
            *mean += response(&one, nm, 0.0, Polarization::S).unwrap().reflected / f64::from(count);
        }
    }
    let curve = Spectrum::new(Wavelengths::new(at).unwrap(), mean).unwrap();
    let reading = Reading::new("m", &curve, &[], straight(0.0), None).unwrap();
    let fit = fitted("air/keratin:200..1500±?/air", FILM_NM, &[reading], &Settings::default());
    let [thickness, spread] = [0, 1].map(|k| fit.solutions[0].sizes[k].value);
    // Beyond ±3 deviations the fit has nobody, and the individuals 0.3 % at these.
    assert!((thickness - 700.0).abs() < 0.02 && (spread - 35.0).abs() < 0.2, "{thickness} {spread}");
}

#[test]
fn angles_instruments_levels_and_offsets_are_taken_together() {
    let mut stream = Stream::new(5, &[]);
    let probe = Instrument::parse("probe:20").unwrap();
    let beams = |turned: f64| -> Vec<Beam> {
        let light = probe.planar(turned.to_radians(), 10.0);
        light.iter().map(|l| Beam { direction: (0.0, l.angle), weight: l.weight }).collect()
    };
    let readings: Vec<Reading> = [0.0, 5.0]
        .iter()
        .zip([0.4, 0.9])
        .map(|(turned, level)| {
            let text = "air/keratin:643/melanin";
            reading(text, &nm(300.0, 700.0, 5.0), beams(*turned), level, QUIET, &mut stream)
        })
        .collect();
    let open = "air/keratin:?/melanin";
    let fit = fitted(open, FILM_NM, &readings, &Settings { offset: true, ..Settings::default() });
    let best = &fit.solutions[0];
    assert!((best.sizes[0].value - 643.0).abs() < 1e-3, "{best:?}");
    for ([level, offset], expected) in best.levels.iter().zip([0.4, 0.9]) {
        assert!((level - expected).abs() < 1e-4 && offset.abs() < 1e-5, "{level} {offset}");
    }
    // A parallel beam at the same angle has another thickness: the cone shortens paths.
    let blind: Vec<Reading> =
        readings.iter().map(|r| Reading { beams: straight(0.0), ..r.clone() }).collect();
    let off = fitted(open, FILM_NM, &blind, &Settings::default()).solutions[0].sizes[0].value;
    assert!(off < 640.0, "{off}");
}

#[test]
fn scatter_between_samples_widens_intervals_and_is_given() {
    let at = nm(300.0, 700.0, 5.0);
    let mut stream = Stream::new(6, &[]);
    let errors = Errors { part: 0.002, correlation_nm: 0.0 };
    let thicknesses = [590.0, 600.0, 615.0, 595.0];
    let samples: Vec<Spectrum> = thicknesses
        .iter()
        .map(|d| reading(&format!("air/keratin:{d}/air"), &at, straight(0.0), 1.0, errors, &mut stream).mean)
        .collect();
    let mean = (0..at.len()).map(|i| samples.iter().map(|s| s.values()[i]).sum::<f64>() / 4.0).collect();
    let mean = Spectrum::new(Wavelengths::new(at).unwrap(), mean).unwrap();
    let several = Reading::new("m", &mean, &samples, straight(0.0), None).unwrap();
    let fit = fitted(FILM, FILM_NM, &[several], &Settings::default());
    let best = &fit.solutions[0];
    // The deviation of the thicknesses themselves is 10.8 nm; t of 3 degrees of freedom 3.18.
    let std = best.between_samples.as_ref().unwrap()[0];
    assert!((std / 10.8 - 1.0).abs() < 0.1, "{std}");
    let half = 0.5 * (best.sizes[0].high - best.sizes[0].low);
    assert!((half / (3.182 * std / 2.0) - 1.0).abs() < 0.1, "{half}");
    assert_eq!(holds(best, &[600.0]), 1);
}

#[test]
fn what_does_not_decide_is_said_or_refused() {
    let mut stream = Stream::new(8, &[]);
    let at = nm(300.0, 700.0, 5.0);
    let noise: Vec<f64> = at.iter().map(|_| 0.05 + 0.01 * stream.normal()).collect();
    let curve = Spectrum::new(Wavelengths::new(at.clone()).unwrap(), noise).unwrap();
    let reading = Reading::new("m", &curve, &[], straight(0.0), None).unwrap();
    // Only what is thinner than a fringe: nothing in noise says how thin.
    let fit = fitted("air/keratin:5..15/air", FILM_NM, &[reading], &Settings::default());
    assert!(
        fit.doubts.iter().any(|d| d.contains("does not decide thickness_nm: every value from 5 to 15")),
        "{:?}",
        fit.doubts
    );
    assert!(fit.doubts.iter().any(|d| d.contains("of the variance is explained")), "{:?}", fit.doubts);

    let library = Library::builtin();
    let refused = |readings: &[Reading], text: &str| {
        fit_stack(text, FILM_NM, &library, readings, &Settings::default()).unwrap_err().to_string()
    };
    let flat = Spectrum::new(Wavelengths::new(at).unwrap(), vec![0.3; 81]).unwrap();
    let flat = Reading::new("grey", &flat, &[], straight(0.0), None).unwrap();
    assert!(refused(&[flat], FILM).contains("grey: is 0.3 at all wavelengths"));
    let few = Spectrum::new(Wavelengths::new([400.0, 500.0, 600.0]).unwrap(), vec![0.1, 0.2, 0.1]).unwrap();
    let few = Reading::new("few", &few, &[], straight(0.0), None).unwrap();
    assert!(refused(&[few], FILM).contains("3 measured samples do not decide 2 numbers and their errors"));
    assert!(refused(&[], FILM).contains("there are 0 measured spectra"));
}

/// A table of crystals between which a lattice lies that is none of them.
#[test]
fn a_lattice_is_found_between_those_that_are_simulated() {
    let file = SpeciesFile::builtin("mallard").unwrap();
    let lattice = file.model(None, Library::builtin()).unwrap().lattice().unwrap();
    let subject = Subject::Lattice(Box::new(lattice));
    let open = [Open::parse("row_pitch_um=0.16..0.20").unwrap()];
    let parameters = subject.parameters(&open).unwrap();
    let Subject::Lattice(truth) = subject.with(&parameters, &[0.1763]).unwrap() else { panic!() };
    let at = nm(400.0, 700.0, 10.0);
    let solver = crate::solve::crystal::Multipole::default();
    let exact = crate::solve::crystal::sweep(&solver, &truth, &at, 0.0, &[0.0], &Unobserved).unwrap();
    let values = exact.iter().map(|[a, b]| 0.3 * (a + b)).collect();
    let curve = Spectrum::new(Wavelengths::new(at).unwrap(), values).unwrap();
    let reading = Reading::new("m", &curve, &[], straight(0.0), None).unwrap();
    let simulation = Simulation { instances: 1, seed: 1, collect: Collect::Hemisphere };
    let settings = Settings::default();
    let found = fit_structure(&subject, &open, &simulation, &[reading], &settings, &Unobserved).unwrap();
    let best = &found.fit.solutions[0];
    assert!((best.sizes[0].value - 0.1763).abs() < 2e-5, "{best:?}");
    assert!((best.levels[0][0] - 0.6).abs() < 1e-3 && found.table_error < 1e-4, "{}", found.table_error);
    let written = found.best.toml().unwrap();
    assert!(written.contains("row_pitch = 0.176"), "{written}");
}

/// A starling's cortex from a spectrum of other individuals, each a little different.
#[test]
fn a_starlings_cortex_is_found() {
    let file = SpeciesFile::builtin("starling").unwrap();
    let model = file.model(Some("green"), Library::builtin()).unwrap();
    let subject = Subject::Species { file: Box::new(file), model: Box::new(model) };
    let at = Wavelengths::new(nm(300.0, 700.0, 20.0)).unwrap();
    let request = crate::campaign::spectrum::SpectrumRequest {
        wavelengths: at.clone(),
        directions: vec![(0.0, 0.0)],
        instances: 12,
        seed: 9,
        collect: Collect::Hemisphere,
        polarization: [0.5; 2],
    };
    let parameters = subject.parameters(&[]).unwrap();
    assert_eq!(parameters[0].name, "cortex_um");
    let Subject::Species { model: truth, .. } = subject.with(&parameters, &[0.351]).unwrap() else {
        panic!()
    };
    let truth = crate::structure::Structure::Species(truth);
    let spectra = crate::campaign::spectrum::spectra(&truth, &request, &Unobserved).unwrap();
    let curve = Spectrum::new(at, spectra.mean[0].iter().map(|v| 0.5 * v).collect()).unwrap();
    let reading = Reading::new("m", &curve, &[], straight(0.0), None).unwrap();
    let simulation = Simulation { instances: 4, seed: 1, collect: Collect::Hemisphere };
    let found =
        fit_structure(&subject, &[], &simulation, &[reading], &Settings::default(), &Unobserved).unwrap();
    let size = found.fit.solutions[0].sizes[0];
    // 12 and 4 individuals differ by chance in about 1 % of their thickness.
    assert!((size.value - 0.351).abs() < 0.006, "{size:?}");
    let again = SpeciesFile::parse(&found.best.toml().unwrap()).unwrap();
    let Subject::Species { model, .. } = &found.best else { panic!() };
    assert_eq!(again.model(None, Library::builtin()).unwrap().parameters, model.parameters);
}

#[test]
fn unknown_and_impossible_sizes_are_refused() {
    let file = SpeciesFile::builtin("mallard").unwrap();
    let model = file.model(None, Library::builtin()).unwrap();
    let lattice = Subject::Lattice(Box::new(model.lattice().unwrap()));
    let species = Subject::Species { file: Box::new(file), model: Box::new(model) };
    let refused = |subject: &Subject, keys: &[&str]| {
        let open: Vec<Open> = keys.iter().map(|key| Open::parse(key).unwrap()).collect();
        let message = subject.parameters(&open).unwrap_err().to_string();
        assert!(message.len() < 600, "{message}");
        message
    };
    assert!(refused(&species, &["perod_um"]).contains("did you mean 'period_um'"));
    assert!(refused(&species, &["rows"]).contains("has no size 'rows'"));
    assert!(refused(&lattice, &["hollow_um"]).contains("has no size 'hollow_um'"));
    assert!(refused(&species, &["row_shift=0..2"]).contains("it may be 0 to 1"));
    assert!(refused(&species, &["core_diameter_um"]).contains("say where to look"));
    assert!(refused(&species, &["cortex_um", "cortex_um"]).contains("open twice"));
    // Rods of 0.3 µm in a period of 0.2 µm overlap.
    assert!(refused(&species, &["rod_diameter_um=0.1..0.3"]).contains("give another range"));
    // Without a range it is as wide as the lattice allows.
    let open = Open::parse("rod_diameter_um").unwrap();
    let free = species.parameters(std::slice::from_ref(&open)).unwrap();
    assert!(free[0].low < 0.11 && free[0].high > 0.14 && free[0].high < 0.2, "{free:?}");
    assert!(Open::parse("a=2..1").is_err() && Open::parse("a=x").is_err());
}
