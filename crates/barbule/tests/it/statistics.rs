//! Fields of simulated barbules against the theory of speckle, and synthesized instances against the simulated ones.
//! `target/release/examples/statistics_tables` prints what is held here.

use std::sync::OnceLock;

use crate::measure::speckle::{Species, contrasts, correlations, fitted, simulate, speckle, synthesized};

/// The species of the usual run, simulated once for all tests.
const QUICK: [&str; 3] = ["rock-dove", "starling", "bronzewing"];

fn quick() -> &'static [Species] {
    static SPECIES: OnceLock<Vec<Species>> = OnceLock::new();
    SPECIES.get_or_init(|| QUICK.into_iter().map(simulate).collect())
}

/// Bounds that depend on the barbule's form.
struct Bounds {
    /// Of |φ_eff − φ_i|, degrees: median and largest.
    apart_deg: [f64; 2],
    /// Of the relative differences of 1/e lengths: median of the fields', median and largest of the intensities'.
    lengths: [f64; 3],
}

/// A barbule whose top is nearly flat. Reached: 0.59°, 6.4° (starling); 10.5 %, 10.6 % (starling) and 30 % (bronzewing, 694 nm): where
/// there is a steady part, intensities vary partly as the noise itself, whose autocovariance is wider than its square.
const FLAT: Bounds = Bounds { apart_deg: [0.8, 7.0], lengths: [0.11, 0.115, 0.31] };

/// The rock dove's arch reflects each wavelength from a place of its own, and its steady part changes its phase over the
/// lobe, which only fields show; intensities vary beside it, more slowly than the fields. Reached: 0.78°, 17.1°; 13 % and 27 %.
const ARCH: Bounds = Bounds { apart_deg: [1.0, 20.0], lengths: [f64::INFINITY, 0.16, 0.28] };

fn bounds(species: &Species) -> &'static Bounds {
    if species.is_arched { &ARCH } else { &FLAT }
}

fn holds_speckle(species: &Species) {
    let found = speckle(species);
    let ([steep, oblique], [near, far], v) = (found.rejected, found.ratio, found.steady);
    // 1 % for normal fields; the rest is the barbules' own spread of slopes and, oblique, a phase they share.
    assert!(steep < 0.1 && oblique < 0.12, "{}: {steep} {oblique}", species.name);
    assert!(near[1] > 0.9 && near[2] < 1.1 && (far[0] - 1.0).abs() < 0.06, "{near:?} {far:?}");
    assert!(v[0].abs() < 0.01 && v[1] < 0.05 && v[2] > v[1] && v[3] > v[2], "{v:?}");
}

fn holds_parameters(species: &Species) {
    let (found, bounds) = (fitted(species), bounds(species));
    let [m, phi, l] = found.polarizations;
    for (apart, bound) in found.apart_deg.iter().zip(bounds.apart_deg) {
        assert!(*apart < bound, "{apart} {bound}");
    }
    assert!(found.grazing > 3.0, "{}: {}", species.name, found.grazing);
    assert!((m - 1.0).abs() < 0.04 && phi < 0.1 && (l - 1.0).abs() < 0.01, "{m} {phi} {l}");
}

fn holds_synthesis(species: &Species) {
    let (found, bounds) = (synthesized(species), bounds(species));
    let [simulated, drawn] = found.contrast;
    assert!((simulated - drawn).abs() < 0.05 && found.contrast_apart < 0.12, "{found:?}");
    // About the mirror direction, on the shoulders, in the wings. Each barbule's own slope lets wings vary more than speckle
    // does: by 1.6 times their mean for the starling, and so uncertainly.
    for [simulated, drawn] in &found.regions {
        assert!((simulated - drawn).abs() < 0.07 * (simulated * simulated).max(1.0), "{found:?}");
    }
    let [simulated, drawn] = found.correlation;
    assert!((drawn - simulated).abs() < 0.05, "{drawn} {simulated}");
    assert!((found.energy - 1.0).abs() < 0.01, "{}", found.energy);
    // The seed finds 1.70 (S.31); pure scaling with the wavelength would give 1.735.
    assert!((1.6..1.8).contains(&found.longest_length), "{}", found.longest_length);
    // Of fields and of intensities at each of three (λ, φ_i).
    let apart = |part: usize| {
        let mut apart = found.lengths.map(|pairs| {
            let [simulated, drawn] = pairs[part];
            (drawn / simulated - 1.0).abs()
        });
        apart.sort_by(f64::total_cmp);
        apart
    };
    let ([_, fields, _], [_, intensities, largest]) = (apart(0), apart(1));
    let [of_fields, of_intensities, of_largest] = bounds.lengths;
    assert!(fields < of_fields && intensities < of_intensities, "{fields} {intensities}");
    assert!(largest < of_largest, "{largest}");
}

#[test]
fn fields_are_the_speckle_that_instances_are_made_of() {
    quick().iter().for_each(holds_speckle);
}

#[test]
fn parameters_behave_as_published() {
    quick().iter().for_each(holds_parameters);
}

#[test]
fn synthesized_instances_vary_as_the_simulated_ones() {
    quick().iter().for_each(holds_synthesis);
}

/// Mean over pairs: 50 instances say a correlation to 0.1 only. The rock dove's film and gap interfere, so that its wavelengths
/// correlate in no order.
#[test]
fn glints_have_the_colours_of_the_simulated_ones() {
    for species in quick() {
        let [published, found] = correlations(species);
        for [simulated, synthesized, apart] in [found.mirror, found.lobe, found.turned] {
            let [mean, most] = if species.is_arched { [0.15, 0.3] } else { [0.1, 0.16] };
            assert!((simulated - synthesized).abs() < mean, "{}: {found:?}", species.name);
            assert!(apart < most, "{}: {found:?}", species.name);
        }
        let [simulated, synthesized, _] = published.mirror;
        assert!(synthesized > simulated + 0.1, "{}: {published:?}", species.name);
    }
}

/// From normal incidence to 70°, in three wavelengths, to 30° beside the mirror direction: a material of 50 barbules is about as near to
/// 200 others as those 50 themselves.
#[test]
fn glints_vary_as_many_other_barbules_do() {
    for species in quick() {
        let found = contrasts(species, 200);
        println!("{}: {found:?}", species.name);
        let [simulated, synthesized] = found.mean;
        assert!((simulated - synthesized).abs() < 0.06, "{}: {found:?}", species.name);
        assert!(found.apart < 1.2 * found.sampled, "{}: {found:?}", species.name);
    }
}

#[test]
#[ignore = "takes as long as the others together"]
fn hummingbirds_keep_the_same_laws() {
    let hummingbird = simulate("hummingbird");
    holds_speckle(&hummingbird);
    holds_parameters(&hummingbird);
    holds_synthesis(&hummingbird);
}
