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
    // As if the deviation were known: Student's t of 39 degrees of freedom is 2.0227.
    let half = 0.5 * (peak.high - peak.low) / (2.0227 / 1.96);
    let expected = 40.0 * (half / peak.enough).powi(2);
    assert!((peak.individuals_enough.unwrap() as f64 - expected).abs() <= 1.0, "{peak:?}");
}

/// Intervals of the means of 3, 5 and 20 hold what very many more individuals have about as often as they say: of the peak, and of the
/// colour's Y. Percentiles alone hold Y in 64, 80 and 90 of 100.
#[test]
fn intervals_hold_the_mean_of_very_many() {
    let structure = crate::structure::Structure::flat("air/keratin:260±6%/air").unwrap();
    let at = Wavelengths::new((400..=700).step_by(10).map(f64::from).collect::<Vec<_>>()).unwrap();
    let request = SpectrumRequest {
        wavelengths: at.clone(),
        directions: vec![(0.0, 0.0)],
        instances: 1200,
        seed: 1,
        collect: Collect::Hemisphere,
        polarization: [0.5, 0.5],
    };
    let of = |mean: &[f64]| Look::of(&Spectrum::new(at.clone(), mean.to_vec()).unwrap());
    let (all, many) = spectra_and_individuals(&structure, &request, &Unobserved).unwrap();
    let truth = of(&all.mean[0]);
    let truths =
        [("peak_nm", truth.peak.unwrap().nm), ("luminous_reflectance", truth.colour.unwrap().xyz[1])];
    for (count, least) in [(3, 78), (5, 80), (20, 88)] {
        let groups = 60;
        let held = |group: usize| {
            let curves: Vec<Vec<f64>> = (0..count).map(|i| many.of(count * group + i, 0).to_vec()).collect();
            let mean: Vec<f64> =
                (0..at.len()).map(|w| curves.iter().map(|c| c[w]).sum::<f64>() / count as f64).collect();
            let looks = [of(&mean)];
            let simulated = Simulated { at: &at, means: &[mean], curves: &[curves], looks: &looks };
            let found = of_direction(0, group as u64, simulated, &[], &[]).unwrap();
            truths.map(|(name, truth)| {
                let known = found.numbers.iter().find(|known| known.name == name).unwrap();
                known.low <= truth && truth <= known.high
            })
        };
        let all: Vec<[bool; 2]> = (0..groups).map(held).collect();
        for (k, (name, _)) in truths.iter().enumerate() {
            let percent = 100 * all.iter().filter(|held| held[k]).count() / groups;
            assert!(percent >= least, "{name} of {count}: {percent} %");
        }
    }
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
