//! Pictures on surfaces.

use std::sync::Arc;

use crate::{Error, Result};

/// A picture whose values are linear between the middles of its texels and repeat beyond its edges. A copy costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    pub(super) size: [usize; 2],
    pub(super) texels: Arc<[[f32; 3]]>,
}

impl Texture {
    /// From values 0 … 1, row by row from the top. Linear sRGB where they are colours.
    ///
    /// # Errors
    /// Not as many texels as the size says, none, or a value outside 0 … 1.
    pub fn new(size: [usize; 2], texels: Vec<[f32; 3]>) -> Result<Self> {
        if texels.is_empty() || size[0].checked_mul(size[1]) != Some(texels.len()) {
            return Err(Error::input(format!("a texture of {} x {} needs as many texels", size[0], size[1])));
        }
        if texels.iter().flatten().any(|value| !(0.0..=1.0).contains(value)) {
            return Err(Error::input("a texture has a value outside 0 to 1"));
        }
        Ok(Self { size, texels: texels.into() })
    }

    /// The same in a mirror: left is right.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let rows = self.texels.chunks(self.size[0]);
        Self { size: self.size, texels: rows.flat_map(|row| row.iter().rev().copied()).collect() }
    }

    /// Memory that its values take, however often it is copied.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.texels[..])
    }

    /// The texel that texture coordinates lie in.
    #[inline]
    fn nearest(&self, [u, v]: [f64; 2]) -> [f32; 3] {
        let place =
            |value: f64, side: usize| (((value - value.floor()) * side as f64) as usize).min(side - 1);
        self.texels[place(1.0 - v, self.size[1]) * self.size[0] + place(u, self.size[0])]
    }

    /// The highest value of a grey picture whose pixels are 0, 1, 2 … of 255.
    ///
    /// # Errors
    /// A pixel that is not grey.
    pub fn highest_value(&self) -> Result<usize> {
        if self.texels.iter().any(|[r, g, b]| r != g || g != b) {
            return Err(Error::input("has a pixel that is not grey; a map's pixels are 0, 1, 2 … of 255"));
        }
        Ok(self.texels.iter().map(|[value, ..]| index(*value)).max().unwrap_or_default())
    }

    /// The value, of 255, of the texel that texture coordinates lie in.
    #[inline]
    pub(super) fn value_at(&self, uv: [f64; 2]) -> usize {
        index(self.nearest(uv)[0])
    }

    /// How fast the mean of the three values grows with u and with v: differences over two texels, so that slopes are
    /// continuous.
    #[inline]
    pub(super) fn slopes(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let mean = |u: f64, v: f64| self.at([u, v]).iter().sum::<f64>() / 3.0;
        let [du, dv] = self.size.map(|side| 1.0 / side as f64);
        [(mean(u + du, v) - mean(u - du, v)) / (2.0 * du), (mean(u, v + dv) - mean(u, v - dv)) / (2.0 * dv)]
    }

    /// The value at texture coordinates: u to the right, v upwards.
    #[inline]
    #[must_use]
    pub fn at(&self, uv: [f64; 2]) -> [f64; 3] {
        let place = |value: f64, side: usize| {
            let at = (value - value.floor()) * side as f64 - 0.5;
            let low = at.floor();
            let wrapped = |index: i64| index.rem_euclid(side as i64) as usize;
            (wrapped(low as i64), wrapped(low as i64 + 1), at - low)
        };
        let (left, right, across) = place(uv[0], self.size[0]);
        let (top, bottom, down) = place(1.0 - uv[1], self.size[1]);
        let texel = |column: usize, row: usize| self.texels[row * self.size[0] + column].map(f64::from);
        let corners = [texel(left, top), texel(right, top), texel(left, bottom), texel(right, bottom)];
        let mut value = [0.0; 3];
        for (k, value) in value.iter_mut().enumerate() {
            let upper = corners[0][k] * (1.0 - across) + corners[1][k] * across;
            let lower = corners[2][k] * (1.0 - across) + corners[3][k] * across;
            *value = upper * (1.0 - down) + lower * down;
        }
        value
    }
}

/// A grey picture whose pixels of value i (of 255) stand for the i-th of several things. Edges are sharp.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberMap(Texture);

impl NumberMap {
    /// A map of `count` things, which are called `things`.
    ///
    /// # Errors
    /// A pixel that is not grey, or one whose number none of them has.
    pub fn new(picture: Texture, count: usize, things: &str) -> Result<Self> {
        let highest = picture.highest_value()?;
        if highest >= count {
            return Err(Error::input(format!(
                "has a pixel of value {highest} (of 255), but the map has {count} {things}, from 0"
            )));
        }
        Ok(Self(picture))
    }

    /// The number at texture coordinates.
    #[inline]
    #[must_use]
    pub fn at(&self, uv: [f64; 2]) -> usize {
        self.0.value_at(uv)
    }
}

fn index(value: f32) -> usize {
    (f64::from(value) * 255.0).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_stand_upright_and_repeat() {
        let texels = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]];
        let texture = Texture::new([2, 2], texels).unwrap();
        assert_eq!(texture.at([0.75, 0.25]), [1.0, 1.0, 0.5]);
        assert_eq!(texture.at([0.75, 0.75]), [1.0, 0.0, 0.0]);
        assert_eq!(texture.at([3.75, -2.75]), texture.at([0.75, 0.25]));
        assert_eq!(texture.at([0.5, 0.5]), [0.5, 0.5, 0.125]);
        for (uv, texel) in
            [([0.1, 0.4], [0.0, 1.0, 0.0]), ([0.6, 0.4], [1.0, 1.0, 0.5]), ([-0.4, 1.9], [1.0, 0.0, 0.0])]
        {
            assert_eq!(texture.nearest(uv), texel, "{uv:?}");
        }
        assert!(Texture::new([2, 2], vec![[0.0; 3]; 3]).is_err());
        assert!(Texture::new([1, 1], vec![[1.5, 0.0, 0.0]]).is_err());
        assert!(Texture::new([1, 1], vec![[f32::NAN, 0.0, 0.0]]).is_err());
    }
}
