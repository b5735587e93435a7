//! Grey values on pixels: smoothing, sampling between pixels, slopes.

use barbule_base::{Error, Result};
use image::{ImageBuffer, Luma};
use imageproc::filter::gaussian_blur_f32;

/// The least and the largest side of a picture that is traced, px, and the most pixels.
pub const LEAST_SIDE: usize = 32;
/// A micrograph of 4096 × 4096.
pub const MOST_PIXELS: usize = 1 << 24;

/// A grey picture. Pixel (i, j) covers the square from (i, j) to (i + 1, j + 1); its value stands at its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct Grey {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Row by row from the top; 0 is black and 1 white, as the file has them.
    pub(super) values: Vec<f32>,
}

impl Grey {
    /// A picture of `width × height` values, row by row from the top.
    ///
    /// # Errors
    /// A side under 32 pixels, over 16,777,216 pixels, another number of values, or one that is not finite.
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Result<Self> {
        check_size([width, height])?;
        if values.len() != width * height {
            return Err(Error::input(format!(
                "has {} values for {width} × {height} pixels; give one for each",
                values.len()
            )));
        }
        if let Some(bad) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::input(format!(
                "is {} at pixel {}, {}; all values must be finite",
                values[bad],
                bad % width,
                bad / width
            )));
        }
        Ok(Self { width, height, values })
    }

    /// Width and height, px.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The values, row by row from the top.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The part from column `left` and row `top` on, `width × height` pixels.
    ///
    /// # Errors
    /// It leaves the picture or is too small.
    pub fn part(&self, [left, top, width, height]: [usize; 4]) -> Result<Self> {
        let fits =
            |from: usize, length: usize, all: usize| from.checked_add(length).is_some_and(|end| end <= all);
        if !fits(left, width, self.width) || !fits(top, height, self.height) {
            return Err(Error::input(format!(
                "`crop` {left},{top},{width},{height} leaves the picture of {} × {} pixels",
                self.width, self.height
            ))
            .naming(&["crop"]));
        }
        let rows = (top..top + height).flat_map(|y| {
            let from = y * self.width + left;
            self.values[from..from + width].iter().copied()
        });
        Self::new(width, height, rows.collect())
    }

    pub(super) fn at(&self, x: usize, y: usize) -> f64 {
        f64::from(self.values[y * self.width + x])
    }

    /// The value between pixels at a place in px, bilinear; beyond the border that of the border.
    pub(super) fn sample(&self, x: f64, y: f64) -> f64 {
        let axis = |at: f64, count: usize| {
            let at = (at - 0.5).clamp(0.0, (count - 1) as f64);
            let first = (at as usize).min(count - 2);
            (first, at - first as f64)
        };
        let ((i, u), (j, v)) = (axis(x, self.width), axis(y, self.height));
        let row = |j: usize| self.at(i, j) * (1.0 - u) + self.at(i + 1, j) * u;
        row(j) * (1.0 - v) + row(j + 1) * v
    }

    /// The slope at a pixel by central differences, per px.
    pub(super) fn slope(&self, x: usize, y: usize) -> [f64; 2] {
        let (left, right) = (x.saturating_sub(1), (x + 1).min(self.width - 1));
        let (up, down) = (y.saturating_sub(1), (y + 1).min(self.height - 1));
        [
            (self.at(right, y) - self.at(left, y)) / (right - left) as f64,
            (self.at(x, down) - self.at(x, up)) / (down - up) as f64,
        ]
    }

    /// Convolved with a Gaussian of a standard deviation in px.
    pub(super) fn smoothed(&self, deviation: f64) -> Self {
        let (width, height) = (self.width as u32, self.height as u32);
        let buffer = ImageBuffer::<Luma<f32>, _>::from_raw(width, height, self.values.clone());
        match buffer {
            Some(buffer) if deviation > 0.0 => {
                Self { values: gaussian_blur_f32(&buffer, deviation as f32).into_raw(), ..*self }
            }
            _ => self.clone(),
        }
    }

    /// The standard deviation of the noise from pixel to pixel, after Immerkær (Computer Vision and Image Understanding 64, 300, 1996):
    /// the median of a second difference that planes and straight edges along x or y do not feel.
    pub(super) fn noise(&self) -> f64 {
        let step = ((self.width * self.height) / 200_000 + 1).max(1);
        let inner = (1..self.height - 1).flat_map(|y| (1..self.width - 1).map(move |x| (x, y)));
        let mut seen: Vec<f64> = inner
            .step_by(step)
            .map(|(x, y)| {
                let at = |i: usize, j: usize| self.at(x + i - 1, y + j - 1);
                let corners = at(0, 0) + at(2, 0) + at(0, 2) + at(2, 2);
                let sides = at(1, 0) + at(0, 1) + at(2, 1) + at(1, 2);
                (corners - 2.0 * sides + 4.0 * at(1, 1)).abs()
            })
            .collect();
        // The sum of squares of the weights is 36; a normal number's absolute value has its median at 0.6745 of its deviation.
        part(&mut seen, 0.5) / (6.0 * 0.6745)
    }
}

/// Refuses a size that is not traced.
///
/// # Errors
/// A side under 32 pixels, over 16,777,216 pixels.
pub fn check_size([width, height]: [usize; 2]) -> Result<()> {
    if width < LEAST_SIDE || height < LEAST_SIDE || width.saturating_mul(height) > MOST_PIXELS {
        return Err(Error::input(format!(
            "has {width} × {height} pixels; a picture to trace has at least {LEAST_SIDE} a side and at most {MOST_PIXELS} in all"
        )));
    }
    Ok(())
}

/// The value below which a part of the values lie, 0 to 1; 0 of none.
pub(super) fn part(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = (part * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}
