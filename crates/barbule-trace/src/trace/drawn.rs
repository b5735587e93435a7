//! Micrographs of sections that are known: what tests and the documentation trace.

use barbule_base::Result;
use barbule_base::math::rng::Stream;

use super::field::{Grey, check_size};

/// A part of a section, in px of the picture; later ones cover earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A disc.
    Disc {
        /// Its centre.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
    },
    /// All below a line: y over `height` + `slope`·x + `bow`·x², x from the picture's middle.
    Below {
        /// y in the middle.
        height: f64,
        /// dy/dx there.
        slope: f64,
        /// Half the second derivative, 1/px.
        bow: f64,
    },
}

/// What the microscope and the stain do to a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Micrograph {
    /// Width and height, px.
    pub size: [usize; 2],
    /// Grey of air, keratin and melanin, 0 to 1.
    pub levels: [f64; 3],
    /// How much the light falls from one corner to the opposite one, a part of it.
    pub shading: f64,
    /// How much the stain of keratin and melanin changes from left to right, a part of their darkness.
    pub stain: f64,
    /// Standard deviation of the Gaussian that blurs, px.
    pub blur: f64,
    /// Standard deviation of the noise, a part of white.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for Micrograph {
    fn default() -> Self {
        Self {
            size: [640, 480],
            levels: [0.85, 0.55, 0.18],
            shading: 0.25,
            stain: 0.1,
            blur: 1.0,
            noise: 0.03,
            seed: 1,
        }
    }
}

/// Samples along each side of a pixel: edges are right to a sixteenth of a pixel, the mean over an outline to far less.
const SAMPLES: usize = 8;

impl Micrograph {
    /// The picture of a section: `around` (0 air, 1 keratin, 2 melanin) with shapes of these media over it.
    ///
    /// # Errors
    /// A size that is not traced.
    pub fn of(&self, around: usize, shapes: &[(Shape, usize)]) -> Result<Grey> {
        check_size(self.size)?;
        let [width, height] = self.size;
        let mut values = Vec::with_capacity(width * height);
        let mut row = vec![around; width * SAMPLES];
        let mut sums = vec![0.0; width];
        for y in 0..height {
            sums.fill(0.0);
            for sub in 0..SAMPLES {
                row.fill(around);
                let at = y as f64 + (sub as f64 + 0.5) / SAMPLES as f64;
                shapes.iter().for_each(|(shape, medium)| self.cover(&mut row, at, shape, *medium));
                for (x, sum) in sums.iter_mut().enumerate() {
                    let media = &row[x * SAMPLES..(x + 1) * SAMPLES];
                    *sum += media.iter().map(|medium| self.darkened(*medium, x)).sum::<f64>();
                }
            }
            values.extend(sums.iter().map(|sum| (sum / (SAMPLES * SAMPLES) as f64) as f32));
        }
        let mut grey = Grey::new(width, height, values)?.smoothed(self.blur);
        let mut noise = Stream::new(self.seed, &[]);
        for (at, value) in grey.values.iter_mut().enumerate() {
            let [x, y] = [at % width, at / width];
            let [u, v] = [x as f64 / width as f64 - 0.5, y as f64 / height as f64 - 0.5];
            // A slope from corner to corner and a hollow in the middle.
            let light = 1.0 - self.shading * (0.5 * (u + v) + 0.6 * (u * u + v * v - 0.2));
            *value = (f64::from(*value) * light + self.noise * noise.normal()).clamp(0.0, 1.0) as f32;
        }
        Ok(grey)
    }

    /// The grey of a medium in a column.
    fn darkened(&self, medium: usize, x: usize) -> f64 {
        let stain = 1.0 + self.stain * (x as f64 / self.size[0] as f64 - 0.5);
        self.levels[0] - (self.levels[0] - self.levels[medium]) * stain
    }

    /// Puts a medium where a shape covers the samples of a line.
    fn cover(&self, row: &mut [usize], y: f64, shape: &Shape, medium: usize) {
        let place = |sample: usize| (sample as f64 + 0.5) / SAMPLES as f64;
        match shape {
            Shape::Disc { center, radius } => {
                let half = radius * radius - (y - center[1]) * (y - center[1]);
                if half <= 0.0 {
                    return;
                }
                let end = |x: f64| (x * SAMPLES as f64 + 0.5).clamp(0.0, row.len() as f64) as usize;
                let [from, to] = [end(center[0] - half.sqrt()), end(center[0] + half.sqrt())];
                row[from..to].fill(medium);
            }
            Shape::Below { height, slope, bow } => {
                let middle = 0.5 * self.size[0] as f64;
                for (sample, at) in row.iter_mut().enumerate() {
                    let x = place(sample) - middle;
                    if y > height + slope * x + bow * x * x {
                        *at = medium;
                    }
                }
            }
        }
    }
}

/// Rods on a lattice, in px: `rows` rows of as many rods as fit between `from` and `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rods {
    /// The picture's place about which the lattice is turned.
    pub middle: [f64; 2],
    /// Distance of neighbours in a row.
    pub period: f64,
    /// Distance of rows.
    pub pitch: f64,
    /// By how much of the period every other row is moved.
    pub shift: f64,
    /// Outer diameter.
    pub diameter: f64,
    /// Diameter of the air inside, 0 for none.
    pub hollow: f64,
    /// How many rows there are.
    pub rows: usize,
    /// How many rods there are in a row.
    pub columns: usize,
    /// Turn, degrees, from +x towards +y.
    pub turn_deg: f64,
    /// Standard deviation of diameters, a part of them, and of places, half this part of the period.
    pub spread: f64,
    /// Seed of the spread.
    pub seed: u64,
}

impl Rods {
    /// The discs, and the outer diameter of each.
    #[must_use]
    pub fn shapes(&self) -> (Vec<(Shape, usize)>, Vec<f64>) {
        let mut random = Stream::new(self.seed, &[1]);
        let (mut shapes, mut diameters) = (Vec::new(), Vec::new());
        let (sin, cos) = self.turn_deg.to_radians().sin_cos();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let odd = self.shift * (row % 2) as f64;
                let x =
                    (column as f64 + odd - 0.5 * (self.columns - 1) as f64 - 0.5 * self.shift) * self.period;
                let y = (row as f64 - 0.5 * (self.rows - 1) as f64) * self.pitch;
                let [a, b] = [x, y].map(|at| at + 0.5 * self.spread * self.period * random.normal());
                let center = [self.middle[0] + cos * a - sin * b, self.middle[1] + sin * a + cos * b];
                let size = 1.0 + self.spread * random.normal();
                shapes.push((Shape::Disc { center, radius: 0.5 * size * self.diameter }, 2));
                diameters.push(size * self.diameter);
                if self.hollow > 0.0 {
                    shapes.push((Shape::Disc { center, radius: 0.5 * size * self.hollow }, 0));
                }
            }
        }
        (shapes, diameters)
    }
}
