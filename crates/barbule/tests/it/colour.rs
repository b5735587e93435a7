//! Colours against the `colour-science` package.

use barbule::spectrum::colour::{Illuminant, Observer, chromaticity};
use barbule::spectrum::{Spectrum, Wavelengths};

#[derive(serde::Deserialize)]
struct Reference {
    cases: Vec<Case>,
}

#[derive(serde::Deserialize)]
struct Case {
    spectrum: String,
    illuminant: String,
    nm: Vec<f64>,
    values: Vec<f64>,
    xyz: [f64; 3],
    xy: [f64; 2],
    linear_srgb: Option<[f64; 3]>,
}

#[test]
fn colours_agree_with_colour_science() {
    let reference: Reference = serde_json::from_str(include_str!("data/colour.json")).unwrap();
    let (mut worst_xy, mut worst_xyz, mut worst_rgb) = (0.0_f64, 0.0_f64, 0.0_f64);
    for case in reference.cases {
        let spectrum = Spectrum::new(Wavelengths::new(case.nm).unwrap(), case.values).unwrap();
        let observer = Observer::under(Illuminant::named(&case.illuminant).unwrap());
        let xyz = observer.xyz(&spectrum);
        let xy = chromaticity(xyz);
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        worst_xy = worst_xy.max(largest(&xy, &case.xy));
        worst_xyz = worst_xyz.max(largest(&xyz, &case.xyz));
        if let Some(rgb) = case.linear_srgb {
            worst_rgb = worst_rgb.max(largest(&observer.linear_rgb(&spectrum), &rgb));
        }
        // Reached: 3.9e-7.
        assert!(worst_xy < 4e-7, "{} under {}: {xy:?}, not {:?}", case.spectrum, case.illuminant, case.xy);
    }
    // They weigh the first and the last of the 471 rows fully, the trapezoidal rule by half.
    assert!(worst_xyz < 4e-6, "{worst_xyz:e}");
    // Theirs uses the standard's matrix, which is rounded to four decimals, and keeps D65's own small offset.
    assert!(worst_rgb < 3e-4, "{worst_rgb:e}");
}
