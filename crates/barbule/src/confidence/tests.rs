use super::*;
use crate::campaign::spectrum::{Collect, Individuals, Spectra, SpectrumRequest, spectra_and_individuals};
use crate::progress::Unobserved;

/// What a structure's spectrum is at normal incidence, and its intervals.
fn sure(text: &str, instances: usize, uncertain: &[&str]) -> Result<(Vec<Intervals>, Spectra, Individuals)> {
    let opening = Opening::default();
    let structure = crate::open::structure(text, &opening, &Unobserved)?;
    let request = SpectrumRequest {
        wavelengths: Wavelengths::new((400..=700).step_by(5).map(f64::from).collect::<Vec<_>>())?,
        directions: vec![(0.0, 0.0)],
        instances: structure.count().map_or(instances, |count| count.min(instances)),
        seed: 1,
        collect: Collect::Hemisphere,
        polarization: [0.5, 0.5],
    };
    let (spectra, individuals) = spectra_and_individuals(&structure, &request, &Unobserved)?;
    let looks = [Look::of(&Spectrum::new(request.wavelengths.clone(), spectra.mean[0].clone())?)];
    let simulated = Simulated {
        at: &request.wavelengths,
        means: &spectra.mean,
        curves: &[(0..individuals.count()).map(|i| individuals.of(i, 0).to_vec()).collect()],
        looks: &looks,
    };
    let uncertain = uncertain.iter().map(|text| Uncertain::parse(text)).collect::<Result<Vec<_>>>()?;
    let simulate = |moved: Structure, progress: &dyn Progress| {
        Ok(spectra_and_individuals(&moved, &request, progress)?.0.mean)
    };
    let found = intervals(text, &opening, &simulate, 1, simulated, &uncertain, &Unobserved)?;
    Ok((found, spectra, individuals))
}

fn number<'a>(found: &'a [Intervals], name: &str) -> &'a Known {
    found[0].numbers.iter().find(|known| known.name == name).unwrap()
}

/// A film's peak λ = 2nd/(m + ½) moves with thickness and index as it must: dλ/λ = dd/d = dn/n, less dispersion.
#[test]
fn a_films_peak_is_as_uncertain_as_its_thickness_and_its_index() {
    let (found, ..) = sure("air/keratin:260/air", 1, &["layer1=2%", "keratin=1%"]).unwrap();
    let peak = number(&found, "peak_nm");
    // n = 1.532 + 5890/λ²: dλ/λ·(1 + 2·5890/(nλ²)) = dd/d.
    let n = 1.532 + 5890.0 / (peak.value * peak.value);
    let slower = 1.0 + 2.0 * (n - 1.532) / n;
    for (part, relative) in peak.parts.iter().zip([0.02, 0.01]) {
        let expected = peak.value * relative / slower;
        let found = part.std.unwrap();
        assert!((found / expected - 1.0).abs() < 0.05, "{}: {found}, not {expected}", part.name);
    }
    let both = peak.parts.iter().map(|part| part.std.unwrap().powi(2)).sum::<f64>().sqrt();
    assert!((peak.high - peak.low - 2.0 * 1.96 * both).abs() < 1e-3 * both, "{peak:?}");
    assert_eq!((peak.of_individuals, peak.individuals_enough), (None, None));
    assert!(number(&found, "delta_e_2000").high > 2.0);
}

/// Resampled means of n individuals vary by their standard deviation over √n; n for an interval follows.
#[test]
fn means_of_individuals_vary_as_the_law_of_large_numbers_says() {
    let (found, spectra, individuals) = sure("air/keratin:260±4%/air", 40, &[]).unwrap();
    let mean = number(&found, "mean_reflectance");
    let of = |i: usize| {
        let spectrum = Spectrum::new(
            Wavelengths::new((400..=700).step_by(5).map(f64::from).collect::<Vec<_>>()).unwrap(),
            individuals.of(i, 0).to_vec(),
        );
        Look::of(&spectrum.unwrap()).mean_reflectance
    };
    let all: Vec<f64> = (0..40).map(of).collect();
    let centre = all.iter().sum::<f64>() / 40.0;
    let std = (all.iter().map(|v| (v - centre) * (v - centre)).sum::<f64>() / 39.0).sqrt();
    let found_std = mean.of_individuals.unwrap();
    assert!((found_std / (std / 40f64.sqrt()) - 1.0).abs() < 0.1, "{found_std} {std}");
    assert!(mean.low < centre && centre < mean.high && spectra.mean[0].len() == 61);
    let peak = number(&found, "peak_nm");
    let half = 0.5 * (peak.high - peak.low);
    let expected = 40.0 * (half / peak.enough).powi(2);
    assert!((peak.individuals_enough.unwrap() as f64 - expected).abs() <= 1.0, "{peak:?}");
}

/// The interval of the mean of 20 holds what many more individuals have: in 19 of 20 seeds or so.
#[test]
fn intervals_hold_the_mean_of_very_many() {
    let structure = crate::structure::Structure::flat("air/keratin:260±6%/air").unwrap();
    let at = Wavelengths::new((400..=700).step_by(10).map(f64::from).collect::<Vec<_>>()).unwrap();
    let request = |seed, instances| SpectrumRequest {
        wavelengths: at.clone(),
        directions: vec![(0.0, 0.0)],
        instances,
        seed,
        collect: Collect::Hemisphere,
        polarization: [0.5, 0.5],
    };
    let of = |mean: &[f64]| Look::of(&Spectrum::new(at.clone(), mean.to_vec()).unwrap());
    let (all, many) = spectra_and_individuals(&structure, &request(1, 1200), &Unobserved).unwrap();
    let truth = of(&all.mean[0]).peak.unwrap().nm;
    let held = (0..60).filter(|group| {
        let curves: Vec<Vec<f64>> = (0..20).map(|i| many.of(20 * group + i, 0).to_vec()).collect();
        let mean: Vec<f64> = (0..at.len()).map(|w| curves.iter().map(|c| c[w]).sum::<f64>() / 20.0).collect();
        let looks = [of(&mean)];
        let simulated = Simulated { at: &at, means: &[mean], curves: &[curves], looks: &looks };
        let found = of_direction(0, *group as u64, simulated, &[], &[]).unwrap();
        let peak = found.numbers.iter().find(|known| known.name == "peak_nm").unwrap();
        peak.low <= truth && truth <= peak.high
    });
    // Of 60 intervals of 95 % 57; percentiles of 20 are a little too narrow (93 %).
    let held = held.count();
    assert!((51..=60).contains(&held), "{held} of 60");
}

#[test]
fn inputs_that_are_not_there_are_refused_with_those_that_are() {
    for (text, uncertain, says) in [
        ("air/keratin:260/air", vec!["layer2=3"], "its layers are layer1 to layer1"),
        ("air/keratin:260/air", vec!["keratine=0.01"], "neither a medium nor a layer"),
        ("starling", vec!["cortx_um=2%"], "did you mean 'cortex_um'?"),
        ("starling", vec!["cortex_um=2%", "cortex_um=1%"], "is uncertain twice"),
        ("air/keratin:260/air", vec!["layer1=300"], "layer 1"),
        ("starling", vec!["cortex_um=0"], "standard deviation over 0"),
        ("starling", vec!["cortex_um"], "write NAME=STD or NAME=STD%"),
    ] {
        let error = sure(text, 2, &uncertain).unwrap_err();
        let message = error.to_string();
        assert!(error.is_input() && message.contains(says) && message.len() < 600, "{message}");
    }
}
