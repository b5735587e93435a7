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
use super::orders::{LEAST_CORRELATION, Lost, follow, nearest_to_normal, outwards};
use super::peaks::{Origin, Peak, highest, peaks};
use crate::error::counted;

/// The part of each of X, Y and Z of white that a spectrum must cover to have a colour.
pub const COLOUR_NEEDS: f64 = 0.9;

/// The brightest channel of a normalized colour, linear.
const NORMALIZED: f64 = 0.9;

/// How a reflectance looks, in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// The wavelengths between which all is measured, nm.
    pub range_nm: [f64; 2],
    /// The peak: the highest local maximum, or in a series of angles the one that is followed. None where the reflectance
    /// only rises or falls, or where it is [`Self::lost`].
    pub peak: Option<Peak>,
    /// The highest local maximum, of whatever order.
    pub highest: Option<Peak>,
    /// All peaks from short to long wavelengths.
    pub peaks: Vec<Peak>,
    /// Where a peak was looked for, nm; none: everywhere.
    pub peak_range_nm: Option<[f64; 2]>,
    /// Why the peak that is followed through a series of angles is not found here.
    pub lost: Option<Lost>,
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
    /// The numbers of a computed reflectance.
    #[must_use]
    pub fn of(reflectance: &Spectrum) -> Self {
        Self::with_peak_in(reflectance, Origin::Computed, None)
    }

    /// The numbers of a reflectance whose peak is the highest within a range of wavelengths in nm; half levels are half-way to
    /// the lowest reflectance in that range.
    #[must_use]
    pub fn with_peak_in(reflectance: &Spectrum, origin: Origin, peak_range_nm: Option<[f64; 2]>) -> Self {
        let (nm, values) = (reflectance.wavelengths().nm(), reflectance.values());
        let (first, last) = reflectance.wavelengths().range_nm();
        let peaks = peaks(reflectance, origin, peak_range_nm);
        let top = highest(&peaks, peak_range_nm);
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
            peak: top,
            highest: top,
            peaks,
            peak_range_nm,
            lost: None,
            mean_reflectance: mean,
            saturation: (mean > 0.0).then(|| (high - low) / mean),
            hue_nm: nm[highest],
            colour: seen.then(|| colour(reflectance)),
            colour_note,
        }
    }

    /// The numbers of a series of reflectances at several angles of incidence: the peak of each is the one that the peak of
    /// the angle nearest to the normal has become ([`follow`]), within one order of interference.
    #[must_use]
    pub fn series(
        angles_deg: &[f64],
        reflectances: &[Spectrum],
        origin: Origin,
        peak_range_nm: Option<[f64; 2]>,
    ) -> Vec<Self> {
        let one = |reflectance| Self::with_peak_in(reflectance, origin, peak_range_nm);
        let mut looks: Vec<Self> = reflectances.iter().map(one).collect();
        let Some(start) = looks.get(nearest_to_normal(angles_deg)).and_then(|look| look.peak) else {
            return looks;
        };
        let all: Vec<Vec<Peak>> = looks.iter().map(|look| look.peaks.clone()).collect();
        for (look, found) in looks.iter_mut().zip(follow(angles_deg, reflectances, &all, start)) {
            (look.peak, look.lost) = (found.peak.ok(), found.peak.err());
        }
        looks
    }

    /// Whether the highest local maximum is another one than the peak.
    #[must_use]
    pub fn highest_is_another(&self) -> bool {
        self.highest.is_some() && self.highest != self.peak
    }

    /// Every number by its name, in the order of tables; lengths in nm, reflectances as parts of 1.
    ///
    /// `from_nm`, `to_nm`: the range. `peak_nm`, `peak_reflectance`: the highest local maximum, or in a series of angles the
    /// one that is followed. `half_level`, `half_width_nm`, `half_from_nm`, `half_to_nm`: half-way between it and the lowest
    /// reflectance. `highest_nm`, `highest_reflectance`: the highest local maximum; `highest_is_another_order`: whether the
    /// peak is another one. `mean_reflectance`,
    /// `saturation`, `hue_nm`: pavo's B2, S8, H1. `luminous_reflectance`, `x`, `y`, `X`, `Y`, `Z`, `dominant_nm`,
    /// `dominant_is_complementary`, `purity`, `hue_deg` (Oklab), `srgb` (at its own luminance), `srgb_normalized` (as
    /// bright as a screen can show it), under D65; `peaks`: all of them ([`Peak::fields`]); `colour_note`: what part of the colour
    /// is continued, or why there is none.
    #[must_use]
    pub fn fields(&self) -> Fields {
        let number = |value: Option<f64>| Field::number(value);
        let word = Field::Word;
        let (colour, half) = (self.colour, self.peak.map(|peak| peak.half));
        let side = |at: usize| number(half.and_then(|half| half.sides[at].crossing_nm()));
        let xyz = |c: usize| number(colour.map(|seen| seen.xyz[c]));
        let xy = |c: usize| number(colour.and_then(|seen| seen.xy).map(|xy| xy[c]));
        let pure = colour.and_then(|seen| seen.dominant);
        Fields(vec![
            ("from_nm", number(Some(self.range_nm[0]))),
            ("to_nm", number(Some(self.range_nm[1]))),
            ("peak_nm", number(self.peak.map(|p| p.nm))),
            ("peak_reflectance", number(self.peak.map(|p| p.reflectance))),
            ("half_level", number(half.map(|h| h.level))),
            ("half_width_nm", number(half.and_then(|h| h.nm()))),
            ("half_from_nm", side(0)),
            ("half_to_nm", side(1)),
            ("highest_nm", number(self.highest.map(|p| p.nm))),
            ("highest_reflectance", number(self.highest.map(|p| p.reflectance))),
            ("highest_is_another_order", Field::Flag(self.highest.map(|_| self.highest_is_another()))),
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
            ("peaks", Field::List(self.peaks.iter().map(Peak::fields).collect())),
            ("colour_note", Field::Note(self.colour_note.clone())),
        ])
    }

    /// One line for people.
    #[must_use]
    pub fn words(&self) -> String {
        let percent = |v: f64| format!("{:.1} %", 100.0 * v);
        let at = |peak: Peak| format!("{:.0} nm ({})", peak.nm, percent(peak.reflectance));
        let mut parts = vec![match (self.peak, self.highest) {
            (Some(peak), Some(other)) if peak != other => {
                format!("peak {}, of another order a higher one at {}", at(peak), at(other))
            }
            (Some(peak), _) => format!("peak {}", at(peak)),
            (None, Some(other)) => format!("no peak of this order (of another one at {})", at(other)),
            (None, None) => match self.peak_range_nm {
                Some([from, to]) => {
                    format!("no peak from {from} to {to} nm (highest at {:.0} nm)", self.hue_nm)
                }
                None => format!("no peak (highest at {:.0} nm)", self.hue_nm),
            },
        }];
        parts.extend(self.peak.map(|peak| peak.half.words()));
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

/// What to tell people of the peaks of a series of angles ([`Look::series`]): from which angle on the highest is of another
/// order than the peak of the angle nearest to the normal, and where that one is lost.
#[must_use]
pub fn order_notes(angles_deg: &[f64], looks: &[Look]) -> Vec<String> {
    let normal = nearest_to_normal(angles_deg);
    let Some(start) = looks.get(normal).and_then(|look| look.peak) else { return Vec::new() };
    let whose = format!("the peak of {}° ({:.0} nm)", angles_deg[normal], start.nm);
    // The angles of which something holds, in words, and the innermost of them.
    let first = |holds: &dyn Fn(&Look) -> bool| {
        let places: Vec<usize> = outwards(angles_deg).filter(|&at| at < looks.len()).collect();
        let held: Vec<usize> = places.iter().copied().filter(|&at| holds(&looks[at])).collect();
        let (&at, others) = held.split_first()?;
        let begin = places.iter().position(|&place| place == at)?;
        let angle = angles_deg[at];
        let words = match others.len() {
            0 => format!("at {angle}°"),
            _ if held == places[begin..] => format!("from {angle}°"),
            more => format!("at {angle}° and {}", counted(more, "further angle")),
        };
        Some((words, &looks[at]))
    };
    let mut notes = Vec::new();
    if let Some((place, look)) = first(&|look| look.peak.is_some() && look.highest_is_another())
        && let (Some(peak), Some(other)) = (look.peak, look.highest)
    {
        notes.push(format!(
            "{place} the highest peak is of another order: {:.0} nm; {whose} is at {:.0} nm there",
            other.nm, peak.nm
        ));
    }
    if let Some((place, look)) = first(&|look| look.lost.is_some()) {
        notes.push(match look.lost {
            Some(Lost::Outside(nm)) => format!("{place} {whose} lies outside the wavelengths, near {nm:.0} nm"),
            Some(Lost::Gone(nm)) => format!("{place} {whose} is no peak any more, where it would lie near {nm:.0} nm"),
            Some(Lost::Unlike(Some(correlation))) => format!(
                "{place} the spectrum is too unlike the one before to follow {whose} (correlation {correlation:.2}, under {LEAST_CORRELATION})"
            ),
            Some(Lost::Unlike(None)) | None => format!("{place} the spectrum has too little variation to follow {whose}"),
        });
    }
    notes
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

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::super::peaks::Side;
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
            let peak = look.peak.unwrap();
            let (half, width) = (peak.half, peak.half.nm().unwrap());
            // Parabolas through a bell: second order in the step over σ.
            assert!(
                (peak.nm - 533.3).abs() < 0.15 && (peak.reflectance - 0.25).abs() < 3e-4,
                "{step}: {peak:?}"
            );
            assert!((half.level - 0.15).abs() < 3e-4, "{step}: {half:?}");
            assert!((width - 30.0 * (8.0 * 2f64.ln()).sqrt()).abs() < 0.7, "{step}: {half:?}");
            let area = 0.2 * 30.0 * std::f64::consts::TAU.sqrt();
            let span = look.range_nm[1] - look.range_nm[0];
            assert!((look.mean_reflectance - (0.05 + area / span)).abs() < 1e-6);
            assert!((look.saturation.unwrap() - 0.2 / look.mean_reflectance).abs() < 2e-2);
            assert!((look.hue_nm - 533.3).abs() <= 0.5 * step);
        }
    }

    /// What smoothing over ±10 nm would turn over, and the edge of a mirror's band, where a parabola would overshoot.
    #[test]
    fn computed_peaks_are_those_of_the_curve_itself() {
        let fringe = |nm: f64| 0.1 * (1.0 + libm::cos(std::f64::consts::TAU * 24_000.0 / nm));
        for step in [1.0, 0.5] {
            let look = Look::of(&sampled(450.0, 600.0, step, fringe));
            let inner: Vec<_> = look.peaks.iter().filter(|peak| !peak.at_end).collect();
            // 24 µm over a whole number.
            assert!(inner.len() >= 12, "{step}: {}", inner.len());
            for peak in inner {
                let order = 24_000.0 / peak.nm;
                assert!((order - order.round()).abs() < 0.02 && peak.reflectance > 0.19, "{step}: {peak:?}");
            }
        }
        for step in [1.0, 2.0, 5.0] {
            let band = |nm: f64| {
                let beyond = ((nm - 520.0).abs() - 40.0).max(0.0);
                0.999 / (1.0 + (beyond / 4.0).powi(2))
            };
            for peak in Look::of(&sampled(450.0, 600.0, step, |nm| band(nm) + 1e-6 * nm)).peaks {
                assert!(peak.reflectance < 1.0, "{step}: {peak:?}");
            }
        }
    }

    #[test]
    fn noise_moves_the_peak_little_and_makes_none_on_a_slope() {
        let noise = |nm: f64| 0.002 * (nm * 12.9898).sin() * (nm * 78.233).cos();
        let of = |curve: Spectrum| Look::with_peak_in(&curve, Origin::Measured, None);
        let peak = of(sampled(300.0, 700.0, 0.3, |nm| bell(nm) + noise(nm))).peak.unwrap();
        assert!((peak.nm - 533.3).abs() < 3.0, "{peak:?}");
        let slope = of(sampled(300.0, 700.0, 0.3, |nm| nm / 1000.0 + 0.2 * noise(nm)));
        assert_eq!(slope.peak, None);
        // Its end is highest, which is no peak but may be part of one.
        assert!(
            slope.peaks.len() == 1 && slope.peaks[0].at_end && slope.peaks[0].nm > 699.0,
            "{:?}",
            slope.peaks
        );
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
        assert_eq!(shelf.peak.unwrap().half.sides[1], Side::Ends(460.0));
        assert!(
            shelf.words().contains("no half width (the range ends at 460 nm above 50.0 %)"),
            "{}",
            shelf.words()
        );
    }

    #[test]
    fn all_peaks_are_listed_with_their_prominence_and_the_sides_of_their_half_width() {
        let at = |nm: f64, at: f64, width: f64| (-0.5 * ((nm - at) / width).powi(2)).exp();
        let look = Look::of(&sampled(300.0, 700.0, 2.0, |nm| {
            0.1 + 0.2 * at(nm, 400.0, 25.0) + 0.3 * at(nm, 490.0, 25.0) + 0.4 * at(nm, 720.0, 25.0)
        }));
        let [blue, green, red] = look.peaks[..] else { panic!("{:?}", look.peaks) };
        assert!((blue.nm - 400.0).abs() < 3.0 && (green.nm - 490.0).abs() < 3.0 && red.nm == 700.0);
        assert_eq!((blue.at_end, green.at_end, red.at_end), (false, false, true));
        assert_eq!(look.peak, Some(green), "an end is no peak");
        // The dip between the first two, at 443 nm, is where their bells are 1.72 and 1.88 widths away.
        let dip = 0.1 + 0.2 * at(443.0, 400.0, 25.0) + 0.3 * at(443.0, 490.0, 25.0);
        assert!((blue.prominence - (blue.reflectance - dip)).abs() < 2e-3, "{blue:?} {dip}");
        assert!((green.prominence - 0.3).abs() < 3e-3, "{green:?}");
        assert!((red.prominence - (red.reflectance - 0.1)).abs() < 2e-3, "{red:?}");
        assert!(blue.half.nm().is_some() && matches!(red.half.sides, [Side::Falls(_), Side::Ends(700.0)]));
        // A shoulder that rises to a higher peak before it is half as high has no width of its own.
        let close =
            Look::of(&sampled(300.0, 700.0, 2.0, |nm| 0.3 * at(nm, 440.0, 25.0) + 0.4 * at(nm, 510.0, 25.0)));
        let [shoulder, _] = close.peaks[..] else { panic!("{:?}", close.peaks) };
        assert!(matches!(shoulder.half.sides, [Side::Falls(_), Side::Rises(_)]), "{shoulder:?}");
        assert!(shoulder.half.words().contains("it rises again above"));
        let fields = look.fields();
        let Some((_, Field::List(listed))) = fields.0.iter().find(|(name, _)| *name == "peaks") else {
            panic!()
        };
        assert_eq!((listed.len(), listed[2].csv_header().split(',').count()), (3, 8));
        assert!(
            listed[2].csv_cells().contains(",true,") && listed[2].csv_cells().ends_with(','),
            "{listed:?}"
        );
    }

    #[test]
    fn a_range_says_which_peak_is_meant_and_from_where_half_levels_are_measured() {
        // A violet peak, and a dip to 0.011 beside it.
        let at = |nm: f64, at: f64, width: f64| (-0.5 * ((nm - at) / width).powi(2)).exp();
        let two = |nm: f64| bell(nm) + 0.3 * at(nm, 360.0, 15.0) - 0.04 * at(nm, 310.0, 12.0);
        let all = sampled(300.0, 700.0, 4.0, two);
        let green = Look::with_peak_in(&all, Origin::Computed, Some([400.0, 700.0]));
        assert!((green.peak.unwrap().nm - 533.3).abs() < 0.5 && !green.highest_is_another());
        assert!((green.peak.unwrap().half.level - 0.15).abs() < 1e-3, "{green:?}");
        assert!(
            (Look::of(&all).peaks.last().unwrap().half.level - 0.13).abs() < 3e-3,
            "{:?}",
            Look::of(&all).peaks
        );
        let none = Look::with_peak_in(&all, Origin::Computed, Some([580.0, 700.0]));
        assert!(
            none.peak.is_none() && none.words().starts_with("no peak from 580 to 700 nm"),
            "{}",
            none.words()
        );
    }

    /// Two bells move from 540 and 340 nm towards the blue, and the violet one, the lower one first, outgrows the other.
    #[test]
    fn a_series_follows_one_peak_and_says_where_another_is_higher_or_it_is_lost() {
        let angles = [0.0, 20.0, 40.0, 60.0];
        let curves: Vec<Spectrum> = [(1.0, 0.1), (0.97, 0.15), (0.91, 0.25), (0.84, 0.3)]
            .map(|(factor, violet)| {
                let at = |nm: f64, at: f64| (-0.5 * ((nm - at * factor) / 20.0).powi(2)).exp();
                sampled(300.0, 700.0, 4.0, |nm| 0.05 + 0.2 * at(nm, 540.0) + violet * at(nm, 370.0))
            })
            .to_vec();
        let looks = Look::series(&angles, &curves, Origin::Computed, None);
        let nm: Vec<f64> = looks.iter().map(|look| look.peak.unwrap().nm).collect();
        for (found, expected) in nm.iter().zip([540.0, 523.8, 491.4, 453.6]) {
            assert!((found - expected).abs() < 1.5, "{nm:?}");
        }
        let other: Vec<bool> = looks.iter().map(Look::highest_is_another).collect();
        assert_eq!(other, [false, false, true, true]);
        assert_eq!(
            order_notes(&angles, &looks),
            [
                "from 40° the highest peak is of another order: 337 nm; the peak of 0° (540 nm) is at 491 nm there"
            ]
        );
        assert!(
            looks[2]
                .words()
                .starts_with("peak 491 nm (25.0 %), of another order a higher one at 337 nm (30.0 %)")
        );
        let violet = Look::series(&angles, &curves, Origin::Computed, Some([300.0, 400.0]));
        assert_eq!(violet[3].highest, violet[3].peak, "at 311 nm, still inside");
        let cut: Vec<Spectrum> = curves.iter().map(|curve| curve.within([330.0, 700.0]).unwrap()).collect();
        let violet = Look::series(&angles, &cut, Origin::Computed, Some([330.0, 400.0]));
        assert!(
            violet[3].peak.is_none() && matches!(violet[3].lost, Some(Lost::Outside(_))),
            "{:?}",
            violet[3]
        );
        let notes = order_notes(&angles, &violet);
        assert!(
            notes[0].starts_with("at 60° the peak of 0° (370 nm) lies outside the wavelengths, near 3"),
            "{notes:?}"
        );
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
            (400.0, 694.0, true, false),
            (300.0, 700.0, true, false),
            (415.0, 700.0, true, true),
            (300.0, 650.0, true, true),
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
        assert!(fields.csv_cells().starts_with("400,700,,,,,,,,,,0.55,"));
    }
}
