//! The laws of Osorio & Ham (2002, *J. exp. Biol.* 205, 2017) on rendered feathers. Poses are those in which the feathers show their beam,
//! as `crates/barbule/examples/feather_laws.rs` finds them; it has more of them, and more feathers.

use barbule::spectrum::angle_law::AngleLaw;

use crate::measure::laws::{Patch, Pose, beam_and_white, height, modulation, peak_nm};

const fn pose(between_deg: f64, roll_deg: f64, turn_deg: f64) -> Pose {
    Pose { between_deg, turn_deg, roll_deg }
}

/// For a fixed viewer the peak's wavelength does not depend on how the feather is turned, only on the angle E between light and viewer, and
/// falls with it as that of layers does; under light from everywhere the modulation is smaller.
#[test]
fn a_starlings_peak_depends_on_the_angle_between_light_and_viewer_alone() {
    let patch = Patch::of("starling", 1.0);
    let (mut means, mut deepest) = (vec![], 0.0_f64);
    for (between, poses) in [
        (10.0, [(45.0, 15.0), (90.0, 10.0), (90.0, 20.0)]),
        (40.0, [(45.0, 30.0), (90.0, 25.0), (90.0, 35.0)]),
        (70.0, [(45.0, 50.0), (90.0, 40.0), (90.0, 50.0)]),
    ] {
        let spectra = poses.map(|(roll, turn)| patch.lit(pose(between, roll, turn), None, 32));
        let peaks = spectra.each_ref().map(|spectrum| peak_nm(spectrum, [450.0, 620.0]));
        let mean = peaks.iter().sum::<f64>() / 3.0;
        println!("E = {between}°: {peaks:.1?}");
        assert!(peaks.iter().all(|nm| (nm - mean).abs() < 6.0), "{peaks:?}");
        means.push((0.5 * f64::to_radians(between), mean));
        deepest = spectra.iter().map(modulation).fold(deepest, f64::max);
    }
    let law = AngleLaw::fit(&means).unwrap();
    println!("{:.1} nm at the normal, n = {:.2?}, rms {:.1} nm", law.normal_nm.value, law.index, law.rmse_nm);
    let slope = law.line.b_nm_per_deg.value;
    assert!((0.3..0.7).contains(&slope) && law.rmse_nm < 2.5, "{means:?}");
    let sky = modulation(&patch.under_sky(pose(0.0, 0.0, 0.0), 32));
    println!("modulation {deepest:.3}, under a sky {sky:.3}");
    assert!(sky < 0.95 * deepest, "{sky} under a sky, {deepest} under a lamp");
}

/// The white gloss of a hummingbird's barbs and the coloured beam of its barbules are two lobes that are fixed to the feather, whatever the
/// angle between light and viewer: the beam before the vane's mirror position, the gloss beyond it, where next to nothing of the beam is
/// left. (Nearer to the beam, whose colour changes across it, gloss cannot be told from what remains of it.)
#[test]
fn a_hummingbirds_gloss_is_beside_its_coloured_beam() {
    let patch = Patch::of("hummingbird", 0.35);
    for between in [10.0, 50.0] {
        let at = |beyond: f64, part| patch.lit(pose(between, 0.0, 0.5 * between + beyond), part, 16);
        let beams = (-7..=0).map(|k| 5.0 * f64::from(k)).map(|turn| (turn, at(turn, None)));
        let (beam_at, beam) = beams.max_by(|a, b| height(&a.1).total_cmp(&height(&b.1))).unwrap();
        let mean = |turns: &[f64], part: Option<&'static str>, which: usize| {
            turns.iter().map(|turn| beam_and_white(&at(*turn, part), &beam)[which]).sum::<f64>()
                / turns.len() as f64
        };
        let lobe = [15.0, 20.0, 25.0, 30.0];
        let gloss = mean(&lobe, Some("barbs"), 1) / mean(&[0.0, 45.0], Some("barbs"), 1);
        let colour = mean(&lobe, None, 0);
        println!(
            "E = {between}°: beam at {beam_at}°, gloss over its sides {gloss:.2}, colour there {colour:.3}"
        );
        assert!((-25.0..=-15.0).contains(&beam_at) && gloss > 1.1 && colour < 0.03);
    }
}
