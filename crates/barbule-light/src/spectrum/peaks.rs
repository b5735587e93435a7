//! Peaks of a spectrum: where they lie, how high and wide they are, and how far they stand out.

use super::Spectrum;
use super::fields::{Field, Fields};

/// Half the width in nm of the window in which a parabola is fitted to what is measured (Savitzky–Golay); samples 6 nm
/// apart or more are left as they are.
const SMOOTHING_NM: f64 = 10.0;

/// Samples closer than this are averaged first, in nm: spectrometers oversample.
const FINEST_NM: f64 = 1.0;

/// A maximum counts when its prominence is this part of the curve's whole range: noise does not.
const PROMINENCE: f64 = 0.01;

/// Where a curve comes from, and so what its small bumps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Every sample is what it is: nothing is smoothed, which would turn narrow fringes over.
    Computed,
    /// With a spectrometer's noise, which is taken out: means over a nanometre, then the middle value of the parabola fitted within 10 nm
    /// on either side.
    Measured,
}

/// A maximum that stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Its wavelength, nm.
    pub nm: f64,
    /// Its height.
    pub reflectance: f64,
    /// By how much the curve falls on either side before it rises above the peak or ends, whichever side falls less; of a
    /// peak at an end, on its one side.
    pub prominence: f64,
    /// Whether the curve is highest at an end of its range, so that the peak itself may lie beyond.
    pub at_end: bool,
    /// Its half level and where the curve crosses it.
    pub half: HalfWidth,
}

/// Where a peak falls to its half level: half-way between its height and the lowest reflectance of the range, as
/// pavo's HM and FWHM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfWidth {
    /// The half level.
    pub level: f64,
    /// What becomes of the curve towards shorter and towards longer wavelengths.
    pub sides: [Side; 2],
}

/// One side of a peak, seen from its top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// The curve first crosses the half level at this wavelength, nm.
    Falls(f64),
    /// The range ends here, nm, and the curve is still above the half level.
    Ends(f64),
    /// Here, nm, the curve is higher than the peak and has not been down at its half level.
    Rises(f64),
}

impl Side {
    /// Where it crosses the half level, nm; none where it does not.
    #[must_use]
    pub fn crossing_nm(self) -> Option<f64> {
        if let Self::Falls(nm) = self { Some(nm) } else { None }
    }
}

impl HalfWidth {
    /// The full width at half maximum, nm; none where a side stays above the half level.
    #[must_use]
    pub fn nm(&self) -> Option<f64> {
        let [left, right] = self.sides.map(Side::crossing_nm);
        Some(right? - left?)
    }

    /// The width and its level for people, or why there is no width.
    #[must_use]
    pub fn words(&self) -> String {
        let level = format!("{:.1} %", 100.0 * self.level);
        if let Some(nm) = self.nm() {
            return format!("half width {nm:.0} nm at {level}");
        }
        let why = |side: Side| match side {
            Side::Falls(_) => None,
            Side::Ends(nm) => Some(format!("the range ends at {nm:.0} nm above {level}")),
            Side::Rises(nm) => Some(format!("towards {nm:.0} nm it rises again above {level}")),
        };
        let why: Vec<String> = self.sides.into_iter().filter_map(why).collect();
        format!("no half width ({})", why.join(", "))
    }
}

impl Peak {
    /// Every number by its name: `nm`, `reflectance`, `prominence`, `at_end`, `half_level`, `half_width_nm`, `half_from_nm`,
    /// `half_to_nm`; a side without crossing has none.
    #[must_use]
    pub fn fields(&self) -> Fields {
        let [from, to] = self.half.sides.map(Side::crossing_nm);
        Fields(vec![
            ("nm", Field::number(self.nm)),
            ("reflectance", Field::number(self.reflectance)),
            ("prominence", Field::number(self.prominence)),
            ("at_end", Field::Flag(Some(self.at_end))),
            ("half_level", Field::number(self.half.level)),
            ("half_width_nm", Field::number(self.half.nm())),
            ("half_from_nm", Field::number(from)),
            ("half_to_nm", Field::number(to)),
        ])
    }
}

/// All peaks of a curve from short to long wavelengths, those at its ends among them. Half levels are half-way to the
/// lowest value within `range_nm`, or of the whole curve.
#[must_use]
pub fn peaks(curve: &Spectrum, origin: Origin, range_nm: Option<[f64; 2]>) -> Vec<Peak> {
    let (nm, values) = (curve.wavelengths().nm(), curve.values());
    let points = match origin {
        Origin::Computed => nm.iter().zip(values).map(|(&nm, &value)| [nm, value]).collect(),
        Origin::Measured => smoothed(nm, values),
    };
    let [whole, inner] = [None, range_nm].map(|range| extent(&points, range));
    let least = PROMINENCE * (whole[1] - whole[0]);
    let falls = falls(&points);
    maxima(&points)
        .into_iter()
        .filter_map(|(first, last)| {
            let height = points[first][1];
            let [left, right] = falls[first];
            // Beyond an end nothing is known, so it does not count as a fall.
            let prominence = match (first == 0, last + 1 == points.len()) {
                (false, false) => height - left.max(right),
                (true, false) => height - right,
                (false, true) => height - left,
                (true, true) => 0.0,
            };
            if prominence < least || prominence <= 0.0 {
                return None;
            }
            let [nm, reflectance] = top(&points, first, last);
            let level = 0.5 * (reflectance + inner[0]);
            let at_end = first == 0 || last + 1 == points.len();
            Some(Peak { nm, reflectance, prominence, at_end, half: half_width(&points, first, level) })
        })
        .collect()
}

/// The highest peak within a range of wavelengths, or of all; ends are none. Of equal ones the first.
#[must_use]
pub fn highest(peaks: &[Peak], range_nm: Option<[f64; 2]>) -> Option<Peak> {
    let inside = |peak: &&Peak| range_nm.is_none_or(|[from, to]| (from..=to).contains(&peak.nm));
    let candidates = peaks.iter().filter(|peak| !peak.at_end).filter(inside);
    candidates.copied().reduce(|best, peak| if peak.reflectance > best.reflectance { peak } else { best })
}

/// The lowest and the highest value within a range of wavelengths, or of all; of all too where the range is empty.
fn extent(points: &[[f64; 2]], range_nm: Option<[f64; 2]>) -> [f64; 2] {
    let all = |inside: &dyn Fn(f64) -> bool| {
        let values = points.iter().filter(|p| inside(p[0])).map(|p| p[1]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    match range_nm.map(|[from, to]| all(&|nm| (from..=to).contains(&nm))) {
        Some(found) if found[0] <= found[1] => found,
        _ => all(&|_| true),
    }
}

/// The first and the last point of each maximum: a plateau is one. A curve that is flat throughout has none.
fn maxima(points: &[[f64; 2]]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = Some(0);
    for at in 1..points.len() {
        if points[at][1] < points[at - 1][1] {
            found.extend(start.map(|start| (start, at - 1)));
            start = None;
        } else if points[at][1] > points[at - 1][1] {
            start = Some(at);
        }
    }
    found.extend(start.filter(|start| *start > 0).map(|start| (start, points.len() - 1)));
    found
}

/// For each point the lowest value between it and the next higher one, to its left and to its right.
///
/// The stack holds points that fall from one to the next, so that each is visited once whatever the curve.
fn falls(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let one_way = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut before: Vec<[f64; 2]> = Vec::new();
        values
            .map(|value| {
                let mut low = value;
                while let Some([_, least]) = before.pop_if(|[height, _]| *height <= value) {
                    low = low.min(least);
                }
                before.push([value, low]);
                low
            })
            .collect()
    };
    let left = one_way(&mut points.iter().map(|p| p[1]));
    let right = one_way(&mut points.iter().rev().map(|p| p[1]));
    left.into_iter().zip(right.into_iter().rev()).map(|(left, right)| [left, right]).collect()
}

/// The top of a maximum: of a plateau its middle, of an end the end, else the vertex of the parabola through the
/// highest point and its neighbours, as far as the curve bends like one beyond them: beside an edge it is flat.
fn top(points: &[[f64; 2]], first: usize, last: usize) -> [f64; 2] {
    if first == 0 || last + 1 == points.len() {
        return points[if first == 0 { 0 } else { last }];
    }
    if first != last {
        return [0.5 * (points[first][0] + points[last][0]), points[first][1]];
    }
    let ([slope, bend], [x, y]) = (parabola(&points[first - 1..]), points[first]);
    let shift = -0.5 * slope / bend;
    let towards = if shift > 0.0 { Some(first) } else { first.checked_sub(2) };
    let beside = towards.and_then(|from| points.get(from..from + 3)).map_or(bend, |three| parabola(three)[1]);
    [x + shift, y + 0.5 * slope * shift * (beside / bend).clamp(0.0, 1.0)]
}

/// The slope at the second of the first three points of the parabola through them, and half its second derivative.
fn parabola(points: &[[f64; 2]]) -> [f64; 2] {
    let [[x0, y0], [x1, y1], [x2, y2]] = [points[0], points[1], points[2]];
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (right - left) / (x2 - x0);
    [left + bend * (x1 - x0), bend]
}

fn half_width(points: &[[f64; 2]], top: usize, level: f64) -> HalfWidth {
    let crossing = |above: [f64; 2], below: [f64; 2]| {
        above[0] + (below[0] - above[0]) * (above[1] - level) / (above[1] - below[1])
    };
    let side = |way: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut above = points[top];
        for point in way {
            if point[1] <= level {
                return Side::Falls(crossing(above, point));
            }
            if point[1] > points[top][1] {
                return Side::Rises(point[0]);
            }
            above = point;
        }
        Side::Ends(above[0])
    };
    let left = side(&mut points[..top].iter().rev().copied());
    let right = side(&mut points[top + 1..].iter().copied());
    HalfWidth { level, sides: [left, right] }
}

/// (nm, reflectance), rising, with the noise of finely sampled measurements taken out: means over [`FINEST_NM`], then the
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
