//! What a camera sees behind everything that stands in a scene.

use std::sync::Arc;

use crate::spectrum::colour::decode;
use crate::{Error, Result};

/// Behind the scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Backdrop {
    /// The lights that shine from infinity: sky and suns.
    #[default]
    Sky,
    /// Nothing: the picture is cut out.
    None,
    /// One colour on the screen: linear sRGB, 0 … 1, whatever the exposure.
    Colour([f64; 3]),
    /// Colours from the picture's upper edge to its lower one, evenly apart: sRGB, 0 … 1, whatever the exposure.
    Gradient(Vec<[f64; 3]>),
    /// A picture.
    Picture(BackdropPicture),
}

/// Linear sRGB of a gradient in this row of a picture so many rows high: the colours mixed as a screen has them, in even steps to the eye.
#[must_use]
pub fn gradient(colours: &[[f64; 3]], row: u32, height: u32) -> [f64; 3] {
    let last = colours.len().saturating_sub(1);
    let at = (f64::from(row) + 0.5) / f64::from(height.max(1)) * last as f64;
    let low = (at as usize).min(last.saturating_sub(1));
    match (colours.get(low), colours.get(low + 1)) {
        (Some(above), Some(below)) => {
            std::array::from_fn(|k| decode(above[k] + (below[k] - above[k]) * (at - low as f64)))
        }
        (one, _) => one.map_or([0.0; 3], |colour| colour.map(decode)),
    }
}

/// A picture behind a scene, scaled until it fills the frame, its middle in the frame's middle. A copy costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct BackdropPicture {
    size: [usize; 2],
    pixels: Arc<[[f32; 3]]>,
    is_radiance: bool,
}

impl BackdropPicture {
    /// From linear sRGB, row by row from the top. `is_radiance`: exposed as the scene is, else it is as bright on the
    /// screen as its values say, 0 … 1.
    ///
    /// # Errors
    /// Not as many pixels as the size says, none, or a value that is not finite.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>, is_radiance: bool) -> Result<Self> {
        if pixels.is_empty() || size[0].checked_mul(size[1]) != Some(pixels.len()) {
            return Err(Error::input(format!("a picture of {} x {} needs as many pixels", size[0], size[1])));
        }
        if pixels.iter().flatten().any(|value| !value.is_finite()) {
            return Err(Error::input("the picture has a value that is not finite"));
        }
        Ok(Self { size, pixels: pixels.into(), is_radiance })
    }

    /// How many pixels it has.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.pixels.len()
    }

    /// Whether it is exposed as the scene is.
    #[must_use]
    pub fn is_radiance(&self) -> bool {
        self.is_radiance
    }

    /// Its colour behind a pixel of a frame of this size, linear between its own pixels.
    #[must_use]
    pub fn behind(&self, x: u32, y: u32, frame: [u32; 2]) -> [f64; 3] {
        let [width, height] = self.size.map(|side| side as f64);
        let scale = (width / f64::from(frame[0])).min(height / f64::from(frame[1]));
        let place = |at: u32, side: u32, own: f64| {
            let centre = (f64::from(at) + 0.5 - 0.5 * f64::from(side)) * scale + 0.5 * own - 0.5;
            let centre = centre.clamp(0.0, own - 1.0);
            let low = (centre as usize).min(own as usize - 1);
            (low, (low + 1).min(own as usize - 1), centre - low as f64)
        };
        let (left, right, across) = place(x, frame[0], width);
        let (top, bottom, down) = place(y, frame[1], height);
        let value =
            |column: usize, row: usize, k: usize| f64::from(self.pixels[row * self.size[0] + column][k]);
        std::array::from_fn(|k| {
            let upper = value(left, top, k) * (1.0 - across) + value(right, top, k) * across;
            let lower = value(left, bottom, k) * (1.0 - across) + value(right, bottom, k) * across;
            upper * (1.0 - down) + lower * down
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_go_from_edge_to_edge() {
        let colours = [[0.0; 3], [0.5; 3], [1.0; 3]];
        let encoded = |row| crate::spectrum::colour::encode(gradient(&colours, row, 100)[1]);
        for (row, expected) in [(0, 0.005), (24, 0.245), (50, 0.505), (99, 0.995)] {
            assert!((encoded(row) - expected).abs() < 1e-9, "{row}: {}", encoded(row));
        }
        assert_eq!(gradient(&colours[2..], 7, 9), [1.0; 3]);
    }

    #[test]
    fn pictures_fill_the_frame_from_their_middle() {
        let ramp = |size: [usize; 2]| {
            let pixels = (0..size[0] * size[1]).map(|i| [(i % size[0]) as f32, (i / size[0]) as f32, 0.0]);
            BackdropPicture::new(size, pixels.collect(), false).unwrap()
        };
        let same = ramp([4, 3]);
        assert_eq!(same.behind(2, 1, [4, 3]), [2.0, 1.0, 0.0]);
        // Half as large: between four pixels. Twice as wide a picture loses both its sides.
        assert_eq!(same.behind(0, 0, [2, 1])[0], 0.5);
        assert_eq!(ramp([8, 3]).behind(0, 0, [4, 3]), [2.0, 0.0, 0.0]);
        assert!(BackdropPicture::new([2, 2], vec![[0.0; 3]; 3], false).is_err());
        assert!(BackdropPicture::new([1, 1], vec![[f32::NAN; 3]], false).is_err());
    }
}
