//! The numbers of a reflectance's colour: where its peak lies and how wide it is, how bright and saturated it is, and
//! what a person sees.
//!
//! Those that ornithologists compare are pavo's (Maia et al. 2019, *Methods Ecol. Evol.* 10, 1097): B2, S8, H1 and
//! the full width at half maximum.

use serde::ser::{Serialize, Serializer};

use super::Spectrum;
use super::colour::{Observer, chromaticity, display, held, known_share};
use super::fields::{Field, Fields};
use super::hue::{Dominant, dominant, hue_deg};

/// Half the width in nm of the window in which a parabola is fitted before peaks are looked for (Savitzky–Golay);
/// samples 6 nm apart or more are left as they are.
const SMOOTHING_NM: f64 = 10.0;

/// Samples closer than this are averaged first, in nm: spectrometers oversample.
const FINEST_NM: f64 = 1.0;

/// A local maximum counts when the curve falls on both sides by this part of its whole range: noise does not.
const PROMINENCE: f64 = 0.01;

/// The part of each of X, Y and Z of white that a spectrum must cover to have a colour.
const COLOUR_NEEDS: f64 = 0.9;

/// The brightest channel of a normalized colour, linear.
const NORMALIZED: f64 = 0.9;

/// How a reflectance looks, in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// The wavelengths between which all is measured, nm.
    pub range_nm: [f64; 2],
    /// The highest local maximum; none where the reflectance only rises or falls.
    pub peak: Option<Peak>,
    /// The peak's width; none where one side stays above the half level.
    pub half_width: Option<HalfWidth>,
    /// Mean over the range (pavo's B2).
    pub mean_reflectance: f64,
    /// (highest − lowest) / mean over the range (pavo's S8); none of a reflectance whose mean is not positive.
    pub saturation: Option<f64>,
    /// The wavelength of the highest sample in nm (pavo's H1), be it at an end.
    pub hue_nm: f64,
    /// What a person sees; none where too much of what the eye sees is unknown.
    pub colour: Option<Colour>,
    /// What to tell people about the colour: over which wavelengths the ends are held, or why there is none.
    pub colour_note: Option<String>,
}

/// A local maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Its wavelength, nm.
    pub nm: f64,
    /// Its height.
    pub reflectance: f64,
}

/// Where a peak falls to its half level: half-way between its height and the lowest reflectance of the range, as
/// pavo's HM and FWHM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfWidth {
    /// The half level.
    pub level: f64,
    /// The wavelengths on both sides where the curve first crosses it, nm.
    pub between_nm: [f64; 2],
}

impl HalfWidth {
    /// The full width at half maximum, nm.
    #[must_use]
    pub fn nm(&self) -> f64 {
        self.between_nm[1] - self.between_nm[0]
    }
}

/// What the 1931 2° observer sees under D65.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// X, Y, Z; a perfect white has Y = 1, so Y is the luminous reflectance.
    pub xyz: [f64; 3],
    /// x and y of the chromaticity diagram; none of black.
    pub xy: Option<[f64; 2]>,
    /// Linear sRGB, which may leave 0 to 1.
    pub linear_rgb: [f64; 3],
    /// Dominant wavelength and excitation purity; none of greys.
    pub dominant: Option<Dominant>,
    /// Oklab's hue angle, 0 to 360°.
    pub hue_deg: f64,
}

impl Colour {
    /// sRGB at the reflectance's own luminance.
    #[must_use]
    pub fn srgb(&self) -> [u8; 3] {
        display(self.linear_rgb)
    }

    /// sRGB as bright as a screen can show it, so that hues can be compared.
    #[must_use]
    pub fn srgb_normalized(&self) -> [u8; 3] {
        let most = self.linear_rgb.into_iter().fold(1e-6, f64::max);
        display(self.linear_rgb.map(|c| NORMALIZED * c / most))
    }
}

/// `#rrggbb`.
#[must_use]
pub fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Look {
    /// The numbers of a reflectance.
    #[must_use]
    pub fn of(reflectance: &Spectrum) -> Self {
        let (nm, values) = (reflectance.wavelengths().nm(), reflectance.values());
        let (first, last) = reflectance.wavelengths().range_nm();
        let smooth = smoothed(nm, values);
        let top = highest_peak(&smooth);
        let mean = mean(nm, values);
        let (low, high) = range(values.iter().copied());
        let highest = values.iter().position(|v| *v == high).unwrap_or_default();
        let share = known_share(reflectance.wavelengths());
        let seen = share >= COLOUR_NEEDS;
        let colour_note = if seen {
            held(reflectance.wavelengths())
        } else {
            Some(format!(
                "no colour: {first} to {last} nm are too little of what the eye sees; give wavelengths from 400 to 700 nm"
            ))
        };
        Self {
            range_nm: [first, last],
            peak: top.map(|(_, peak)| peak),
            half_width: top.and_then(|(at, peak)| half_width(&smooth, at, peak)),
            mean_reflectance: mean,
            saturation: (mean > 0.0).then(|| (high - low) / mean),
            hue_nm: nm[highest],
            colour: seen.then(|| colour(reflectance)),
            colour_note,
        }
    }

    /// Every number by its name, in the order of tables; lengths in nm, reflectances as parts of 1.
    ///
    /// `from_nm`, `to_nm`: the range. `peak_nm`, `peak_reflectance`: the highest local maximum. `half_level`,
    /// `half_width_nm`, `half_from_nm`, `half_to_nm`: half-way between it and the lowest reflectance. `mean_reflectance`,
    /// `saturation`, `hue_nm`: pavo's B2, S8, H1. `luminous_reflectance`, `x`, `y`, `X`, `Y`, `Z`, `dominant_nm`,
    /// `dominant_is_complementary`, `purity`, `hue_deg` (Oklab), `srgb` (at its own luminance), `srgb_normalized` (as
    /// bright as a screen can show it), under D65; `colour_note`: what part of the colour is continued, or why there is none.
    #[must_use]
    pub fn fields(&self) -> Fields {
        let number = |value: Option<f64>| Field::number(value);
        let word = Field::Word;
        let (colour, half) = (self.colour, self.half_width);
        let xyz = |c: usize| number(colour.map(|seen| seen.xyz[c]));
        let xy = |c: usize| number(colour.and_then(|seen| seen.xy).map(|xy| xy[c]));
        let pure = colour.and_then(|seen| seen.dominant);
        Fields(vec![
            ("from_nm", number(Some(self.range_nm[0]))),
            ("to_nm", number(Some(self.range_nm[1]))),
            ("peak_nm", number(self.peak.map(|p| p.nm))),
            ("peak_reflectance", number(self.peak.map(|p| p.reflectance))),
            ("half_level", number(half.map(|h| h.level))),
            ("half_width_nm", number(half.map(|h| h.nm()))),
            ("half_from_nm", number(half.map(|h| h.between_nm[0]))),
            ("half_to_nm", number(half.map(|h| h.between_nm[1]))),
            ("mean_reflectance", number(Some(self.mean_reflectance))),
            ("saturation", number(self.saturation)),
            ("hue_nm", number(Some(self.hue_nm))),
            ("luminous_reflectance", xyz(1)),
            ("dominant_nm", number(pure.map(|d| d.nm))),
            ("dominant_is_complementary", Field::Flag(pure.map(|d| d.is_complementary))),
            ("purity", number(pure.map(|d| d.purity))),
            ("hue_deg", number(colour.map(|seen| seen.hue_deg))),
            ("x", xy(0)),
            ("y", xy(1)),
            ("X", xyz(0)),
            ("Y", xyz(1)),
            ("Z", xyz(2)),
            ("srgb", word(colour.map(|seen| hex(seen.srgb())))),
            ("srgb_normalized", word(colour.map(|seen| hex(seen.srgb_normalized())))),
            ("colour_note", Field::Note(self.colour_note.clone())),
        ])
    }

    /// One line for people.
    #[must_use]
    pub fn words(&self) -> String {
        let percent = |v: f64| format!("{:.1} %", 100.0 * v);
        let mut parts = vec![match self.peak {
            Some(peak) => format!("peak {:.0} nm ({})", peak.nm, percent(peak.reflectance)),
            None => format!("no peak (highest at {:.0} nm)", self.hue_nm),
        }];
        if let Some(half) = self.half_width {
            parts.push(format!("half width {:.0} nm at {}", half.nm(), percent(half.level)));
        } else if self.peak.is_some() {
            parts.push("no half width (one side stays above it)".into());
        }
        parts.push(format!("mean {}", percent(self.mean_reflectance)));
        if let Some(saturation) = self.saturation {
            parts.push(format!("saturation S8 {saturation:.2}"));
        }
        if let Some(colour) = self.colour {
            parts.push(format!("Y {}", percent(colour.xyz[1])));
            if let Some([x, y]) = colour.xy {
                parts.push(format!("x {x:.3}, y {y:.3}"));
            }
            if let Some(pure) = colour.dominant {
                let kind = if pure.is_complementary { "complementary" } else { "dominant" };
                parts.push(format!("{kind} {:.0} nm, purity {:.2}", pure.nm, pure.purity));
            }
            parts.push(format!("hue {:.0}°", colour.hue_deg));
            parts.push(format!("sRGB {}, normalized {}", hex(colour.srgb()), hex(colour.srgb_normalized())));
        }
        parts.join(", ")
    }
}

impl Serialize for Look {
    /// The names and values of [`Look::fields`]; null where there is no such number.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.fields().serialize(serializer)
    }
}

fn colour(reflectance: &Spectrum) -> Colour {
    let weights = Observer::default().weights(reflectance.wavelengths());
    let xyz = weights.xyz(reflectance.values());
    let linear_rgb = weights.linear_rgb(reflectance.values());
    let xy = (xyz.iter().sum::<f64>() > 0.0).then(|| chromaticity(xyz));
    Colour { xyz, xy, linear_rgb, dominant: xy.and_then(dominant), hue_deg: hue_deg(linear_rgb) }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The mean over the range of what is linear between samples.
fn mean(nm: &[f64], values: &[f64]) -> f64 {
    if let [only] = values {
        return *only;
    }
    let area: f64 =
        nm.windows(2).zip(values.windows(2)).map(|(x, v)| 0.5 * (v[0] + v[1]) * (x[1] - x[0])).sum();
    area / (nm[nm.len() - 1] - nm[0])
}

/// (nm, reflectance), rising, with the noise of finely sampled spectra taken out: means over [`FINEST_NM`], then the
/// middle value of the parabola fitted within [`SMOOTHING_NM`] on either side.
fn smoothed(nm: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let points = binned(nm, values);
    let (mut from, mut to) = (0, 0);
    points
        .iter()
        .map(|&[at, value]| {
            while points[from][0] < at - SMOOTHING_NM {
                from += 1;
            }
            while to < points.len() && points[to][0] <= at + SMOOTHING_NM {
                to += 1;
            }
            let near = &points[from..to];
            [at, if near.len() > 3 { parabola_at(near, at).unwrap_or(value) } else { value }]
        })
        .collect()
}

/// Means of samples that lie closer than [`FINEST_NM`].
fn binned(nm: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let (mut start, mut count) = (f64::NEG_INFINITY, 0.0);
    for (&nm, &value) in nm.iter().zip(values) {
        match points.last_mut() {
            // A small tolerance, so that steps of 1 nm are not paired by a rounding.
            Some(last) if nm - start < FINEST_NM * (1.0 - 1e-9) => {
                count += 1.0;
                last[0] += (nm - last[0]) / count;
                last[1] += (value - last[1]) / count;
            }
            _ => {
                points.push([nm, value]);
                (start, count) = (nm, 1.0);
            }
        }
    }
    points
}

/// The value at `at` of the least-squares parabola through points; none where they do not fix one.
fn parabola_at(points: &[[f64; 2]], at: f64) -> Option<f64> {
    let mut moments = [0.0; 5];
    let mut sums = [0.0; 3];
    for [nm, value] in points {
        let x = (nm - at) / SMOOTHING_NM;
        let mut power = 1.0;
        for (k, moment) in moments.iter_mut().enumerate() {
            *moment += power;
            if k < 3 {
                sums[k] += power * value;
            }
            power *= x;
        }
    }
    // Cramer's rule for the constant of the normal equations.
    let [m0, m1, m2, m3, m4] = moments;
    let (c0, c1, c2) = (m2 * m4 - m3 * m3, m2 * m3 - m1 * m4, m1 * m3 - m2 * m2);
    let determinant = m0 * c0 + m1 * c1 + m2 * c2;
    let value = (sums[0] * c0 + sums[1] * c1 + sums[2] * c2) / determinant;
    (determinant > 1e-9 * m0 * m0 * m0 && value.is_finite()).then_some(value)
}

/// The highest local maximum that stands out, with its place; by the parabola through it and its neighbours.
fn highest_peak(points: &[[f64; 2]]) -> Option<(usize, Peak)> {
    let (low, high) = range(points.iter().map(|p| p[1]));
    let least = PROMINENCE * (high - low);
    let mut tops: Vec<(usize, usize)> = Vec::new();
    let mut start = 0;
    for at in 1..points.len() {
        // A plateau is one maximum.
        if points[at][1] != points[at - 1][1] {
            if points[at][1] < points[at - 1][1] && start > 0 {
                tops.push((start, at - 1));
            }
            start = if points[at][1] > points[at - 1][1] { at } else { 0 };
        }
    }
    tops.sort_by(|a, b| points[b.0][1].total_cmp(&points[a.0][1]));
    let (first, last) = tops.into_iter().find(|&top| stands_out(points, top, least))?;
    if first != last {
        let nm = 0.5 * (points[first][0] + points[last][0]);
        return Some((first, Peak { nm, reflectance: points[first][1] }));
    }
    let [[x0, y0], [x1, y1], [x2, y2]] = [points[first - 1], points[first], points[first + 1]];
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (right - left) / (x2 - x0);
    // The slope of the parabola at x1.
    let slope = left + bend * (x1 - x0);
    let shift = -0.5 * slope / bend;
    Some((first, Peak { nm: x1 + shift, reflectance: y1 + 0.5 * slope * shift }))
}

/// Whether the curve falls by `least` on both sides of a maximum before it rises above it. Both sides are walked in
/// step, so that many small maxima do not cost the square of their number.
fn stands_out(points: &[[f64; 2]], (first, last): (usize, usize), least: f64) -> bool {
    let height = points[first][1];
    let mut sides = [(false, first, false), (false, last, true)];
    loop {
        for (fell, at, up) in &mut sides {
            if *fell {
                continue;
            }
            let next = if *up { (*at + 1 < points.len()).then(|| *at + 1) } else { at.checked_sub(1) };
            let Some(next) = next else { return false };
            if points[next][1] > height {
                return false;
            }
            *fell = points[next][1] <= height - least;
            *at = next;
        }
        if sides.iter().all(|side| side.0) {
            return true;
        }
    }
}

fn half_width(points: &[[f64; 2]], top: usize, peak: Peak) -> Option<HalfWidth> {
    let (low, _) = range(points.iter().map(|p| p[1]));
    let level = 0.5 * (peak.reflectance + low);
    let crossing = |above: [f64; 2], below: [f64; 2]| {
        above[0] + (below[0] - above[0]) * (above[1] - level) / (above[1] - below[1])
    };
    let left = (0..top).rev().find(|&i| points[i][1] <= level)?;
    let right = (top + 1..points.len()).find(|&i| points[i][1] <= level)?;
    let between_nm = [crossing(points[left + 1], points[left]), crossing(points[right - 1], points[right])];
    Some(HalfWidth { level, between_nm })
}

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::*;

    fn sampled(first: f64, last: f64, step: f64, value: impl Fn(f64) -> f64) -> Spectrum {
        let count = ((last - first) / step).round() as usize + 1;
        let nm: Vec<f64> = (0..count).map(|i| first + i as f64 * step).collect();
        let values = nm.iter().map(|&x| value(x)).collect();
        Spectrum::new(Wavelengths::new(nm).unwrap(), values).unwrap()
    }

    /// A Gaussian on a pedestal: width at half height 2√(2 ln 2) σ.
    fn bell(nm: f64) -> f64 {
        0.05 + 0.2 * (-0.5 * ((nm - 533.3) / 30.0).powi(2)).exp()
    }

    #[test]
    fn a_bell_has_its_own_peak_and_width_at_any_sampling() {
        for step in [0.25, 1.0, 2.0, 4.0, 6.0, 10.0] {
            let look = Look::of(&sampled(300.0, 700.0, step, bell));
            let (peak, half) = (look.peak.unwrap(), look.half_width.unwrap());
            // Parabolas through a bell: second order in the step over σ.
            assert!(
                (peak.nm - 533.3).abs() < 0.15 && (peak.reflectance - 0.25).abs() < 3e-4,
                "{step}: {peak:?}"
            );
            assert!((half.level - 0.15).abs() < 3e-4, "{step}: {half:?}");
            assert!((half.nm() - 30.0 * (8.0 * 2f64.ln()).sqrt()).abs() < 0.7, "{step}: {half:?}");
            let area = 0.2 * 30.0 * std::f64::consts::TAU.sqrt();
            let span = look.range_nm[1] - look.range_nm[0];
            assert!((look.mean_reflectance - (0.05 + area / span)).abs() < 1e-6);
            assert!((look.saturation.unwrap() - 0.2 / look.mean_reflectance).abs() < 2e-2);
            assert!((look.hue_nm - 533.3).abs() <= 0.5 * step);
        }
    }

    #[test]
    fn noise_moves_the_peak_little_and_makes_none_on_a_slope() {
        let noise = |nm: f64| 0.002 * (nm * 12.9898).sin() * (nm * 78.233).cos();
        let peak = Look::of(&sampled(300.0, 700.0, 0.3, |nm| bell(nm) + noise(nm))).peak.unwrap();
        assert!((peak.nm - 533.3).abs() < 3.0, "{peak:?}");
        let slope = Look::of(&sampled(300.0, 700.0, 0.3, |nm| nm / 1000.0 + 0.2 * noise(nm)));
        assert_eq!(slope.peak, None);
        assert_eq!(slope.half_width, None);
        assert!(slope.words().starts_with("no peak (highest at 700 nm)"));
    }

    #[test]
    fn uneven_samples_of_a_parabola_give_its_vertex() {
        let nm = [400.0, 450.0, 480.0, 550.0, 570.0, 640.0];
        let values = nm.map(|x| 0.4 - 1e-5 * (x - 500.0f64).powi(2)).to_vec();
        let peak = Look::of(&Spectrum::new(Wavelengths::new(nm).unwrap(), values).unwrap()).peak.unwrap();
        assert!((peak.nm - 500.0).abs() < 1e-9 && (peak.reflectance - 0.4).abs() < 1e-12, "{peak:?}");
    }

    #[test]
    fn plateaus_shoulders_and_ends_are_told_apart() {
        let of = |values: &[f64]| {
            let nm: Vec<f64> = (0..values.len()).map(|i| 400.0 + 20.0 * i as f64).collect();
            Look::of(&Spectrum::new(Wavelengths::new(nm).unwrap(), values.to_vec()).unwrap())
        };
        assert_eq!(of(&[0.0, 1.0, 1.0, 0.0]).peak.unwrap().nm, 430.0);
        for none in [&[0.0, 1.0, 1.0, 2.0][..], &[1.0, 1.0, 0.0], &[0.0, 1.0], &[0.3], &[0.2, 0.2, 0.2]] {
            assert_eq!(of(none).peak, None, "{none:?}");
        }
        // The side that never falls to half has no width, though the peak is one.
        let shelf = of(&[0.0, 1.0, 0.8, 0.8]);
        assert!(shelf.peak.is_some() && shelf.half_width.is_none());
        assert!(shelf.words().contains("no half width"));
    }

    #[test]
    fn the_higher_of_two_peaks_is_taken_even_in_ultraviolet() {
        let two = |nm: f64| bell(nm) + 0.3 * (-0.5 * ((nm - 360.0) / 15.0).powi(2)).exp();
        assert!((Look::of(&sampled(300.0, 700.0, 4.0, two)).peak.unwrap().nm - 360.0).abs() < 0.5);
        assert!((Look::of(&sampled(420.0, 700.0, 4.0, two)).peak.unwrap().nm - 533.3).abs() < 0.5);
    }

    #[test]
    fn colours_are_given_only_where_most_of_what_the_eye_sees_is_known() {
        for (first, last, known, noted) in [
            (360.0, 830.0, true, false),
            (400.0, 694.0, true, true),
            (300.0, 700.0, true, true),
            (450.0, 650.0, false, true),
            (300.0, 400.0, false, true),
        ] {
            let look = Look::of(&sampled(first, last, 1.0, bell));
            assert_eq!((look.colour.is_some(), look.colour_note.is_some()), (known, noted), "{first} {last}");
        }
        let dark = Look::of(&sampled(300.0, 400.0, 5.0, bell));
        assert!(dark.colour_note.unwrap().starts_with("no colour: 300 to 400 nm are too little"));
    }

    #[test]
    fn a_grey_has_its_luminance_and_no_hue() {
        let colour = Look::of(&sampled(360.0, 830.0, 5.0, |_| 0.18)).colour.unwrap();
        assert!((colour.xyz[1] - 0.18).abs() < 1e-12);
        assert_eq!((hex(colour.srgb()), hex(colour.srgb_normalized())), ("#767676".into(), "#f3f3f3".into()));
        let black = Look::of(&sampled(360.0, 830.0, 5.0, |_| 0.0));
        assert_eq!((black.saturation, black.colour.unwrap().xy), (None, None));
        assert!(!black.fields().csv_cells().contains("NaN"));
    }

    #[test]
    fn what_a_slope_has_not_is_left_empty_in_tables() {
        let fields = Look::of(&sampled(400.0, 700.0, 5.0, |nm| nm / 1000.0)).fields();
        assert!(fields.csv_header().starts_with("from_nm,to_nm,peak_nm,peak_reflectance,half_level,"));
        assert!(fields.csv_header().ends_with(",srgb,srgb_normalized"));
        assert!(fields.csv_cells().starts_with("400,700,,,,,,,0.55,"));
    }
}
