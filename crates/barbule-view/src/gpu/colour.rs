//! At which wavelengths a picture is worked out, and what each gives of its colour: for `shaders/waves.wgsl`.

use std::f64::consts::PI;

use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::Observer;
use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, UNIFORM};
use crate::{Error, Result};

/// More wavelengths a picture does not have.
pub const MOST_WAVES: usize = 64;

/// What people see, nm: beyond, about a thousandth of a white's X, Y or Z lies on either side.
const SEEN_NM: std::ops::RangeInclusive<f64> = 390.0..=720.0;

/// `Wave` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Wave {
    parts: [f32; 4],
    place: [f32; 4],
}

/// `Waves` of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Uniform {
    count: [u32; 4],
    all: [Wave; MOST_WAVES],
}

/// Wavelengths of a material's tables and what each gives of linear sRGB.
#[derive(Debug, Clone, PartialEq)]
pub struct Waves {
    uniform: Uniform,
    nm: Vec<f64>,
    parts: Vec<[f64; 3]>,
}

/// The same on the graphics card.
#[derive(Debug, Clone)]
pub struct WavesOnGpu {
    group: wgpu::BindGroup,
    buffer: wgpu::Buffer,
}

impl Waves {
    /// At most `most` of the tables' own wavelengths, nm, evenly among those that people see from the first to the last, as an
    /// observer sees them: a spectrum is linear between those that are taken, held beyond, and its colour that of the trapezoidal
    /// rule at 1 nm.
    ///
    /// # Errors
    /// `most` is not from 2 to [`MOST_WAVES`], or the wavelengths do not rise.
    pub fn new(tables_nm: &[f64], observer: Observer, most: usize) -> Result<Self> {
        if !(2..=MOST_WAVES).contains(&most) {
            return Err(Error::input(format!("a picture of {most} wavelengths; give 2 to {MOST_WAVES}")));
        }
        let first = tables_nm.iter().position(|nm| SEEN_NM.contains(nm)).unwrap_or(0);
        // Of tables that nobody sees, or that are of one visible wavelength, all are taken.
        let (first, all) = match tables_nm.iter().filter(|nm| SEEN_NM.contains(*nm)).count() {
            0 | 1 => (0, tables_nm.len()),
            seen => (first, seen),
        };
        let count = most.min(all);
        // Rounded to the nearest.
        let at = |k: usize| first + (2 * k * (all - 1) + count - 1) / (2 * (count - 1).max(1));
        let places: Vec<usize> = (0..count).map(at).collect();
        let nm: Vec<f64> = places.iter().map(|place| tables_nm[*place]).collect();
        let weights = observer.weights(&Wavelengths::new(nm.as_slice())?);
        let parts = weights.rgb_parts().to_vec();
        let mut uniform = Uniform { count: [count as u32, 0, 0, 0], ..Uniform::zeroed() };
        for (((wave, place), nm), [r, g, b]) in uniform.all.iter_mut().zip(&places).zip(&nm).zip(&parts) {
            wave.parts = [*r, *g, *b, 2000.0 * PI / nm].map(|v| v as f32);
            wave.place = [*place as f32, 0.0, *nm as f32, 0.0];
        }
        Ok(Self { uniform, nm, parts })
    }

    /// Those that were taken, nm.
    #[must_use]
    pub fn nm(&self) -> &[f64] {
        &self.nm
    }

    /// Linear sRGB of values at these wavelengths; of 1 at all of them (1, 1, 1).
    #[must_use]
    pub fn linear_rgb(&self, values: &[f64]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (value, parts) in values.iter().zip(&self.parts) {
            for (sum, part) in sum.iter_mut().zip(parts) {
                *sum += value * part;
            }
        }
        sum
    }
}

impl WavesOnGpu {
    /// The layout of the group that the wavelengths are: group 0 of every shader that makes colours.
    #[must_use]
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        gpu.layout("waves", &[UNIFORM])
    }

    /// Uploads them.
    #[must_use]
    pub fn new(gpu: &Gpu, waves: &Waves) -> Self {
        let buffer = gpu.uniform("waves", bytemuck::bytes_of(&waves.uniform));
        let group = gpu.bound("waves", &Self::layout(gpu), &[buffer.as_entire_binding()]);
        Self { group, buffer }
    }

    /// Others in their place.
    pub fn change(&self, gpu: &Gpu, waves: &Waves) {
        gpu.queue().write_buffer(&self.buffer, 0, bytemuck::bytes_of(&waves.uniform));
    }

    /// What a pass binds as its group 0.
    #[must_use]
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_the_tables_own_from_end_to_end_and_white_is_white() {
        let usual = Wavelengths::usual();
        for most in [2, 9, 16, 25, 50, 64] {
            let waves = Waves::new(usual.nm(), Observer::default(), most).unwrap();
            assert_eq!(waves.nm().len(), most.min(50));
            assert_eq!([waves.nm()[0], *waves.nm().last().unwrap()], [400.0, 694.0]);
            assert!(waves.nm().windows(2).all(|pair| pair[1] > pair[0]));
            for (wave, nm) in waves.uniform.all.iter().zip(waves.nm()) {
                assert_eq!(usual.nm()[wave.place[0] as usize], *nm);
            }
            let white = waves.linear_rgb(&vec![1.0; waves.nm().len()]);
            assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-9), "{white:?}");
        }
    }

    /// Tables reach into the ultraviolet for birds' sake.
    #[test]
    fn wavelengths_that_nobody_sees_are_left_out() {
        let tables: Vec<f64> = (0..51).map(|k| 300.0 + 8.0 * f64::from(k)).collect();
        let waves = Waves::new(&tables, Observer::default(), 16).unwrap();
        assert_eq!(
            [waves.nm()[0], *waves.nm().last().unwrap(), waves.nm().len() as f64],
            [396.0, 700.0, 16.0]
        );
        assert_eq!(waves.uniform.all[0].place[0], 12.0);
        let dark = Waves::new(&[310.0, 330.0, 350.0], Observer::default(), 16).unwrap();
        assert_eq!(dark.nm().len(), 3);
    }

    #[test]
    fn tables_of_one_wavelength_have_one() {
        let waves = Waves::new(&[550.0], Observer::default(), 16).unwrap();
        assert_eq!(waves.nm(), [550.0]);
    }

    #[test]
    fn too_many_wavelengths_are_refused() {
        let refused = Waves::new(&[500.0, 600.0], Observer::default(), 65).unwrap_err().to_string();
        assert_eq!(refused, "a picture of 65 wavelengths; give 2 to 64");
    }
}
