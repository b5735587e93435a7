//! Surfaces as heights over the plane: what diffraction gratings and scales of snakes are.

use crate::math::dense::Dense;
use crate::math::rng::Stream;
use crate::{Error, Result};

/// Most heights of a field.
pub const MOST_HEIGHTS: usize = 1 << 26;

/// Built-in samples: the scales of a corn snake and of a sunbeam snake, a blazed grating and a sinusoidal one.
pub const SAMPLES: [&str; 4] = ["elaphe", "xenopeltis", "blazed", "sinusoid"];

/// Heights over a patch that repeats along both axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Heightfield {
    /// Heights along x and y; 1 along an axis along which nothing changes.
    cells: [usize; 2],
    /// Sides of the patch, µm.
    size_um: [f64; 2],
    /// Outwards, x fastest.
    height_um: Vec<f64>,
}

/// What is done to measured heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cleaning {
    /// Subtract the quadratic surface that fits best.
    pub detrend: bool,
    /// Clip heights at these fractions of their distribution from below and above.
    pub clip: f64,
    /// Fade heights to their mean towards the edges over this part of the sides, so that the patch repeats without steps.
    pub taper: f64,
}

impl Default for Cleaning {
    fn default() -> Self {
        Self { detrend: true, clip: 0.001, taper: 0.05 }
    }
}

impl Heightfield {
    /// Heights (µm, x fastest) over a patch, with the middle of their range at 0: a constant changes nothing but a phase.
    ///
    /// # Errors
    /// Counts that do not fit each other, too many or infinite heights, sides that are not positive.
    pub fn new(cells: [usize; 2], size_um: [f64; 2], height_um: Vec<f64>) -> Result<Self> {
        let count = cells[0].checked_mul(cells[1]).filter(|count| (1..=MOST_HEIGHTS).contains(count));
        if count != Some(height_um.len()) {
            return Err(Error::input(format!(
                "{} heights do not fill {} × {} cells (at most {MOST_HEIGHTS})",
                height_um.len(),
                cells[0],
                cells[1]
            )));
        }
        if !size_um.iter().all(|side| *side > 0.0 && side.is_finite()) {
            return Err(Error::input(format!(
                "the patch of a heightfield is {} × {} µm; give positive sides",
                size_um[0], size_um[1]
            )));
        }
        if let Some(bad) = height_um.iter().position(|height| !height.is_finite() || height.abs() > 1e4) {
            return Err(Error::input(format!(
                "the height at column {}, row {} is not a finite number of at most 10000 µm",
                bad % cells[0],
                bad / cells[0]
            )));
        }
        let mut field = Self { cells, size_um, height_um };
        field.centre();
        Ok(field)
    }

    /// Heights along x and y.
    #[must_use]
    pub fn cells(&self) -> [usize; 2] {
        self.cells
    }

    /// Sides of the patch, µm.
    #[must_use]
    pub fn size_um(&self) -> [f64; 2] {
        self.size_um
    }

    /// The heights, x fastest, µm.
    #[must_use]
    pub fn height_um(&self) -> &[f64] {
        &self.height_um
    }

    /// Distance of neighbours along x and y, µm.
    #[must_use]
    pub fn pitch_um(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.size_um[axis] / self.cells[axis] as f64)
    }

    /// The largest distance from the middle of the range, µm.
    #[must_use]
    pub fn reach_um(&self) -> f64 {
        self.height_um.iter().fold(0.0, |reach, height| height.abs().max(reach))
    }

    /// The field turned by 90° from x towards y.
    #[must_use]
    pub fn turned(&self) -> Self {
        let [columns, rows] = self.cells;
        // What was at (x, y) comes to (−y, x).
        let at = |place: usize| {
            let (column, row) = (place % rows, place / rows);
            self.height_um[(rows - 1 - column) * columns + row]
        };
        Self {
            cells: [rows, columns],
            size_um: [self.size_um[1], self.size_um[0]],
            height_um: (0..columns * rows).map(at).collect(),
        }
    }

    /// Whether opposite edges fit each other: the mean step across them is no greater than the greatest mean step between
    /// neighbouring columns, and rows, inside.
    #[must_use]
    pub fn repeats(&self) -> bool {
        let [columns, rows] = self.cells;
        let step = |from: usize, to: usize, stride: usize, lines: usize, along: usize| {
            let apart = (0..lines).map(|line| {
                let of = |place: usize| self.height_um[place * along + line * stride];
                (of(to) - of(from)).abs()
            });
            apart.sum::<f64>()
        };
        [(columns, columns, rows, 1), (rows, 1, columns, columns)].into_iter().all(
            |(count, stride, lines, along)| {
                let inside = (1..count).map(|i| step(i - 1, i, stride, lines, along)).fold(0.0, f64::max);
                // Rounding is no step.
                step(count - 1, 0, stride, lines, along) <= inside * (1.0 + 1e-6) + 1e-9 * lines as f64
            },
        )
    }

    /// Measured heights made fit to repeat.
    ///
    /// # Errors
    /// Fractions out of range.
    pub fn cleaned(&self, cleaning: &Cleaning) -> Result<Self> {
        let Cleaning { detrend, clip, taper } = *cleaning;
        if !((0.0..0.5).contains(&clip) && (0.0..=0.5).contains(&taper)) {
            return Err(Error::input("cleaning heights: clip must be 0 to below 0.5, taper 0 to 0.5"));
        }
        let mut field = self.clone();
        if detrend {
            field.detrend();
        }
        if clip > 0.0 {
            let mut sorted = field.height_um.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let last = sorted.len() - 1;
            let at = |part: f64| sorted[(part * last as f64).round() as usize];
            let (low, high) = (at(clip), at(1.0 - clip));
            field.height_um.iter_mut().for_each(|height| *height = height.clamp(low, high));
        }
        if taper > 0.0 {
            let mean = field.height_um.iter().sum::<f64>() / field.height_um.len() as f64;
            let [columns, _] = field.cells;
            // 1 inside, a cosine's half to 0 at the edges; along an axis with one cell nothing has edges.
            let weight = |axis: usize, index: usize| {
                let count = field.cells[axis];
                let from_edge = (index.min(count - 1 - index) as f64 + 0.5) / (taper * count as f64);
                if count == 1 || from_edge >= 1.0 {
                    return 1.0;
                }
                0.5 - 0.5 * libm::cos(std::f64::consts::PI * from_edge)
            };
            let weights =
                [0, 1].map(|axis| (0..field.cells[axis]).map(|i| weight(axis, i)).collect::<Vec<_>>());
            for (place, height) in field.height_um.iter_mut().enumerate() {
                *height = mean + (*height - mean) * weights[0][place % columns] * weights[1][place / columns];
            }
        }
        field.centre();
        Ok(field)
    }

    /// Subtracts the quadratic surface of least squares.
    fn detrend(&mut self) {
        let [columns, rows] = self.cells;
        let centred = |index: usize, count: usize| (2.0 * index as f64 + 1.0) / count as f64 - 1.0;
        let terms = |place: usize| {
            let (x, y) = (centred(place % columns, columns), centred(place / columns, rows));
            [1.0, x, y, x * x, x * y, y * y]
        };
        let mut normal = Dense::zeros(6, 6);
        let mut right = Dense::zeros(6, 1);
        for (place, height) in self.height_um.iter().enumerate() {
            let terms = terms(place);
            for (i, a) in terms.iter().enumerate() {
                right[(i, 0)] += a * height;
                for (k, b) in terms.iter().enumerate() {
                    normal[(i, k)] += a * b;
                }
            }
        }
        // Along an axis of one cell some terms say the same: the least ridge keeps the system regular.
        for i in 0..6 {
            let ridge = 1e-12 * (normal[(i, i)] + self.height_um.len() as f64);
            normal[(i, i)] += ridge;
        }
        normal.solve(&mut right);
        for (place, height) in self.height_um.iter_mut().enumerate() {
            *height -= terms(place).iter().enumerate().map(|(i, term)| term * right[(i, 0)].re).sum::<f64>();
        }
    }

    fn centre(&mut self) {
        let range = |(low, high): (f64, f64), h: &f64| (low.min(*h), high.max(*h));
        let (low, high) = self.height_um.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
        let middle = f64::midpoint(low, high);
        self.height_um.iter_mut().for_each(|height| *height -= middle);
    }

    /// A ramp of period `period_um` that falls by `fall_um` along +x in each period.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn blazed(period_um: f64, fall_um: f64, periods: usize, per_period: usize) -> Result<Self> {
        let height = |i: usize| -fall_um * ((i % per_period) as f64 + 0.5) / per_period as f64;
        let side = period_um * periods as f64;
        Self::new([periods * per_period, 1], [side, side], (0..periods * per_period).map(height).collect())
    }

    /// a·cos(2πx/d) with d = `period_um`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn sinusoid(period_um: f64, amplitude_um: f64, periods: usize, per_period: usize) -> Result<Self> {
        let turn = |i: usize| std::f64::consts::TAU * (i % per_period) as f64 / per_period as f64;
        let side = period_um * periods as f64;
        let heights = (0..periods * per_period).map(|i| amplitude_um * libm::cos(turn(i))).collect();
        Self::new([periods * per_period, 1], [side, side], heights)
    }

    /// A built-in sample, of [`SAMPLES`]; the seed is that of the snakes.
    #[must_use]
    pub fn sample(name: &str, seed: u64) -> Option<Result<Self>> {
        match name {
            "elaphe" => Some(Self::fingers(&Fingers::ELAPHE, seed)),
            "xenopeltis" => Some(Self::fingers(&Fingers::XENOPELTIS, seed)),
            "blazed" => Some(Self::blazed(2.5, 0.24623, 26, 100)),
            "sinusoid" => Some(Self::sinusoid(2.5, 0.123, 26, 100)),
            _ => None,
        }
    }

    /// Fingers of scales in overlapping rows, as snakes have them: periodic over the patch.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn fingers(fingers: &Fingers, seed: u64) -> Result<Self> {
        fingers.field(seed)
    }
}

/// A snake's scale: rows of fingers that overlap like shingles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fingers {
    /// Heights along either side of the patch.
    pub cells: usize,
    /// Side of the patch, µm.
    pub size_um: f64,
    /// Distance of fingers along a row, µm, and how much it scatters.
    pub pitch_um: f64,
    /// Relative scatter of the pitch.
    pub jitter: f64,
    /// Distance of rows, µm.
    pub row_um: f64,
    /// Rows wave by this amplitude over this length, µm.
    pub wave_um: [f64; 2],
    /// Height of a finger, µm.
    pub height_um: f64,
    /// Relative scatter of their heights: what is white and diffuse about their light.
    pub unevenness: f64,
    /// Drop of a row's end onto the next one, µm.
    pub drop_um: f64,
    /// White noise, µm.
    pub noise_um: f64,
    /// A slow undulation, µm.
    pub undulation_um: f64,
    /// Grains and pits.
    pub grains: Grains,
}

/// Round grains that lie on a surface and as many pits: the tails of its distribution of heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grains {
    /// How many of either in a µm².
    pub per_um2: f64,
    /// Height of a grain and depth of a pit in its middle, µm.
    pub height_um: f64,
    /// Standard deviation of its Gaussian shape, µm.
    pub radius_um: f64,
}

impl Grains {
    /// Adds them at places of a square patch of this side, µm, that repeats.
    fn add_to(&self, heights: &mut [f64], cells: usize, size_um: f64, stream: &mut Stream) {
        const REACH: f64 = 4.0;
        let step = size_um / cells as f64;
        // Where the tails of both sides would meet, a patch is too small for any.
        if 2.0 * REACH * self.radius_um > size_um {
            return;
        }
        let count = (self.per_um2 * size_um * size_um).round() as usize;
        let around = (REACH * self.radius_um / step).ceil() as isize;
        for index in 0..2 * count {
            let height = if index % 2 == 0 { self.height_um } else { -self.height_um };
            let middle = [stream.uniform(0.0, size_um), stream.uniform(0.0, size_um)];
            let nearest = middle.map(|x| (x / step).round() as isize);
            // The shape is a product of those along x and y.
            let shape = [0, 1].map(|axis| {
                let away =
                    move |k: isize| ((nearest[axis] + k) as f64 * step - middle[axis]) / self.radius_um;
                (-around..=around).map(|k| libm::exp(-0.5 * away(k).powi(2))).collect::<Vec<_>>()
            });
            let cell = |axis: usize, k: usize| {
                (nearest[axis] + k as isize - around).rem_euclid(cells as isize) as usize
            };
            for (j, by_y) in shape[1].iter().enumerate() {
                let row = cell(1, j) * cells;
                for (i, by_x) in shape[0].iter().enumerate() {
                    heights[row + cell(0, i)] += height * by_x * by_y;
                }
            }
        }
    }
}

impl Fingers {
    /// Corn snake: long fingers in rows far apart.
    pub const ELAPHE: Self = Self {
        cells: 1332,
        size_um: 65.0,
        pitch_um: 1.14,
        jitter: 0.05,
        row_um: 7.0,
        wave_um: [0.6, 16.0],
        height_um: 0.088,
        unevenness: 0.1,
        drop_um: 0.03,
        noise_um: 0.004,
        undulation_um: 0.025,
        grains: Grains { per_um2: 0.01, height_um: 0.117, radius_um: 0.3 },
    };

    /// Sunbeam snake: short fingers in close rows.
    pub const XENOPELTIS: Self = Self {
        pitch_um: 0.54,
        row_um: 1.45,
        wave_um: [0.7, 15.0],
        height_um: 0.084,
        unevenness: 0.1,
        drop_um: 0.06,
        grains: Grains { height_um: 0.135, ..Self::ELAPHE.grains },
        ..Self::ELAPHE
    };

    /// Height at a part of a row (0 at its root, 1 where the next begins), `off_um` beside the middle of a finger `tall` times as high as
    /// usual.
    fn rise_um(&self, part: f64, off_um: f64, pitch_um: f64, tall: f64) -> f64 {
        let taper = 1.0 - 0.4 * part;
        let across = 2.0 * off_um / (0.85 * pitch_um * taper);
        let ridge = if across.abs() < 1.0 { libm::sqrt(1.0 - across * across) } else { 0.0 };
        self.height_um * tall * taper * ridge - self.drop_um * part
    }

    /// One even finger across, as a period of ridges: at the middle of its length.
    ///
    /// # Errors
    /// As [`Heightfield::new`].
    pub fn across(&self, cells: usize) -> Result<Heightfield> {
        let off = |i: usize| self.pitch_um * ((i as f64 + 0.5) / cells as f64 - 0.5);
        let heights = (0..cells).map(|i| self.rise_um(0.5, off(i), self.pitch_um, 1.0)).collect();
        Heightfield::new([cells, 1], [self.pitch_um; 2], heights)
    }

    /// One row along the middle of a finger, as a period of ridges.
    ///
    /// # Errors
    /// As [`Heightfield::new`].
    pub fn along(&self, cells: usize) -> Result<Heightfield> {
        let part = |i: usize| (i as f64 + 0.5) / cells as f64;
        let heights = (0..cells).map(|i| self.rise_um(part(i), 0.0, self.pitch_um, 1.0)).collect();
        Heightfield::new([cells, 1], [self.row_um; 2], heights)
    }

    fn field(&self, seed: u64) -> Result<Heightfield> {
        // Whole numbers of rows, fingers and waves, so that the patch repeats.
        let whole = |length: f64| (self.size_um / length).round().max(1.0);
        let (rows, fingers, waves) = (whole(self.row_um), whole(self.pitch_um), whole(self.wave_um[1]));
        let (row_um, pitch_um) = (self.size_um / rows, self.size_um / fingers);
        let mut stream = Stream::new(seed, &[0xf1]);
        let count = (rows * fingers) as usize;
        let shifts: Vec<f64> = (0..count).map(|_| self.jitter * pitch_um * stream.normal()).collect();
        let tall: Vec<f64> = (0..count).map(|_| (1.0 + self.unevenness * stream.normal()).max(0.0)).collect();
        let starts: Vec<f64> = (0..rows as usize).map(|_| stream.unit()).collect();
        let phase = stream.uniform(0.0, std::f64::consts::TAU);
        let step = self.size_um / self.cells as f64;
        let tau = std::f64::consts::TAU;
        let mut heights = Vec::with_capacity(self.cells * self.cells);
        for j in 0..self.cells {
            let y = j as f64 * step;
            for i in 0..self.cells {
                let x = i as f64 * step;
                let along = y - self.wave_um[0] * libm::sin(tau * waves * x / self.size_um + phase);
                let row = libm::floor(along / row_um);
                // 0 at a row's root, 1 where the next begins.
                let part = along / row_um - row;
                let index = row.rem_euclid(rows) as usize;
                let place = x / pitch_um + starts[index];
                let finger = libm::round(place);
                let number = index * fingers as usize + finger.rem_euclid(fingers) as usize;
                let off = (place - finger) * pitch_um - shifts[number];
                let slow = self.undulation_um * libm::sin(tau * (x + y) / self.size_um + phase);
                heights.push(
                    self.rise_um(part, off, pitch_um, tall[number]) + slow + self.noise_um * stream.normal(),
                );
            }
        }
        self.grains.add_to(&mut heights, self.cells, self.size_um, &mut stream);
        Heightfield::new([self.cells; 2], [self.size_um; 2], heights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blazed_grating_falls_along_x_and_its_middle_is_at_zero() {
        let field = Heightfield::blazed(2.5, 0.24623, 4, 100).unwrap();
        assert_eq!((field.cells(), field.size_um()), ([400, 1], [10.0, 10.0]));
        assert!(field.height_um()[..100].windows(2).all(|h| h[1] < h[0]));
        assert!((field.reach_um() - 0.5 * 0.24623 * 0.99).abs() < 1e-12);
        assert!((field.height_um()[0] + field.height_um()[99]).abs() < 1e-12);
    }

    #[test]
    fn four_quarter_turns_are_none_and_one_brings_x_to_y() {
        let field = Heightfield::new([3, 2], [3.0, 2.0], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let once = field.turned();
        assert_eq!((once.cells(), once.size_um()), ([2, 3], [2.0, 3.0]));
        // (0, 0) comes to the right end of the first row.
        assert_eq!(once.height_um()[1], field.height_um()[0]);
        assert_eq!(once.turned().turned().turned(), field);
    }

    #[test]
    fn snakes_have_their_pitches() {
        for (snake, pitch) in [(Fingers::ELAPHE, 1.14), (Fingers::XENOPELTIS, 0.54)] {
            let snake = Fingers { cells: 666, ..snake };
            let field = Heightfield::fingers(&snake, 1).unwrap();
            // The strongest wave along x shorter than 3 µm.
            let mut best = (0.0, 0);
            for j in 22..140 {
                let mut power = 0.0;
                for row in field.height_um().chunks_exact(666).step_by(37) {
                    let (mut re, mut im) = (0.0, 0.0);
                    for (i, height) in row.iter().enumerate() {
                        let turn = std::f64::consts::TAU * (i * j % 666) as f64 / 666.0;
                        re += height * turn.cos();
                        im += height * turn.sin();
                    }
                    power += re * re + im * im;
                }
                if power > best.0 {
                    best = (power, j);
                }
            }
            let found = 65.0 / f64::from(best.1 as u32);
            assert!((found / pitch - 1.0).abs() < 0.03, "{found} for {pitch}");
            // Fingers of 0.09 µm, and here and there two grains on one place.
            assert!((0.05..0.5).contains(&(2.0 * field.reach_um())), "{}", field.reach_um());
        }
    }

    /// Root mean square and range of 99.8 % without waves longer than 10 µm.
    fn rough(field: &Heightfield) -> (f64, f64) {
        let [columns, rows] = field.cells();
        // What a box of 10 µm blurs away.
        let half = (5.0 / field.pitch_um()[0]) as isize;
        let blurred = |values: &[f64], along: usize, across: usize, count: usize, lines: usize| {
            let mut out = vec![0.0; values.len()];
            for line in 0..lines {
                let at = |i: isize| values[i.rem_euclid(count as isize) as usize * along + line * across];
                let mut sum: f64 = (-half..=half).map(at).sum();
                for i in 0..count {
                    out[i * along + line * across] = sum / (2 * half + 1) as f64;
                    sum += at(i as isize + half + 1) - at(i as isize - half);
                }
            }
            out
        };
        let slow = blurred(field.height_um(), 1, columns, columns, rows);
        let slow = blurred(&slow, columns, 1, rows, columns);
        let mut fast: Vec<f64> = field.height_um().iter().zip(&slow).map(|(h, s)| h - s).collect();
        let rms = (fast.iter().map(|h| h * h).sum::<f64>() / fast.len() as f64).sqrt();
        fast.sort_by(f64::total_cmp);
        let at = |part: f64| fast[(part * (fast.len() - 1) as f64) as usize];
        (rms, at(0.999) - at(0.001))
    }

    /// Without waves longer than 10 µm: root mean square and the range of 99.8 % of the heights, as measured on atomic force
    /// micrographs of the two snakes' scales (37 and 227 nm, 40 and 265 nm).
    #[test]
    fn snakes_are_as_rough_as_measured() {
        let snakes = [(Fingers::ELAPHE, 0.037, 0.227), (Fingers::XENOPELTIS, 0.040, 0.265)];
        for ((snake, rms, range), seed) in snakes.into_iter().flat_map(|snake| [(snake, 1), (snake, 2)]) {
            let field = Heightfield::fingers(&snake, seed).unwrap();
            let (found, found_range) = rough(&field);
            assert!((found / rms - 1.0).abs() < 0.05, "rms {found} for {rms}, range {found_range}");
            assert!((found_range / range - 1.0).abs() < 0.05, "range {found_range} for {range}, rms {found}");
        }
    }

    #[test]
    fn cleaning_takes_off_slopes_dust_and_edges() {
        let [columns, rows] = [80, 60];
        let wave = |x: f64| 0.05 * (std::f64::consts::TAU * x).sin();
        let heights = (0..columns * rows).map(|place| {
            let (x, y) = ((place % columns) as f64 * 0.1, (place / columns) as f64 * 0.1);
            let dust = if place == 2003 { 3.0 } else { 0.0 };
            0.3 * x - 0.1 * y + 0.02 * x * x + 0.01 * x * y + wave(x) + dust
        });
        let raw = Heightfield::new([columns, rows], [8.0, 6.0], heights.collect()).unwrap();
        let clean = raw.cleaned(&Cleaning::default()).unwrap();
        assert!(raw.reach_um() > 1.0 && clean.reach_um() < 0.1, "{}", clean.reach_um());
        let step = clean.height_um().chunks_exact(columns).map(|row| (row[0] - row[columns - 1]).abs());
        assert!(step.fold(0.0, f64::max) < 0.01);
        // Inside, the wave is left.
        let row = &clean.height_um()[30 * columns..][..columns];
        assert!((row[42] - row[47] - (wave(4.2) - wave(4.7))).abs() < 0.01);
        assert!(raw.cleaned(&Cleaning { clip: 0.5, ..Cleaning::default() }).is_err());
    }

    #[test]
    fn whole_periods_repeat_and_tilted_patches_do_not() {
        assert!(Heightfield::blazed(2.5, 0.2, 3, 50).unwrap().repeats());
        assert!(Heightfield::sinusoid(2.5, 0.1, 3, 50).unwrap().repeats());
        let snake = Fingers { cells: 200, size_um: 15.0, ..Fingers::XENOPELTIS };
        let snake = Heightfield::fingers(&snake, 2).unwrap();
        assert!(snake.repeats() && snake.turned().repeats());
        let tilted = snake.height_um().iter().enumerate();
        for slope in [[2e-3, 0.0], [0.0, 2e-3]] {
            let tilt = |place: usize| slope[0] * (place % 200) as f64 + slope[1] * (place / 200) as f64;
            let heights = tilted.clone().map(|(place, height)| height + tilt(place)).collect();
            let field = Heightfield::new([200, 200], [15.0; 2], heights).unwrap();
            assert!(!field.repeats() && field.cleaned(&Cleaning::default()).unwrap().repeats());
        }
        // Half a period too many.
        let half = (0..75).map(|i| 0.1 * libm::sin(std::f64::consts::TAU * f64::from(i) / 50.0)).collect();
        assert!(Heightfield::new([75, 1], [3.75, 3.75], half).unwrap().repeats());
        let quarter = (0..62).map(|i| 0.1 * libm::sin(std::f64::consts::TAU * f64::from(i) / 50.0)).collect();
        assert!(!Heightfield::new([62, 1], [3.1, 3.1], quarter).unwrap().repeats());
    }

    #[test]
    fn heights_that_make_no_sense_are_refused() {
        for (cells, size, heights) in [
            ([2, 2], [1.0, 1.0], vec![0.0; 3]),
            ([0, 2], [1.0, 1.0], vec![]),
            ([usize::MAX, 2], [1.0, 1.0], vec![0.0]),
            ([1, 1], [0.0, 1.0], vec![0.0]),
            ([2, 1], [1.0, 1.0], vec![0.0, f64::NAN]),
        ] {
            assert!(Heightfield::new(cells, size, heights).is_err());
        }
    }
}
