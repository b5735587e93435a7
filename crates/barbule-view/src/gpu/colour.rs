//! At which wavelengths a picture is worked out, and what each gives of its colour: for `shaders/waves.wgsl`.

use std::f64::consts::PI;

use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::colour::{Illuminant, Observer, rgb_from_xyz};
use barbule_light::spectrum::sensor::{MOST_CHANNELS, Sensor};
use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, UNIFORM};
use crate::{Error, Result};

/// More wavelengths a picture does not have.
pub const MOST_WAVES: usize = 64;

/// What people see, nm: beyond, about a thousandth of a white's X, Y or Z lies on either side.
const SEEN_NM: std::ops::RangeInclusive<f64> = 390.0..=720.0;

/// Who sees a picture in daylight.
#[derive(Debug, Clone, PartialEq)]
pub enum Sight {
    /// People.
    People(Observer),
    /// An eye or camera, whose channels say how they look on a screen.
    Sensor(Sensor),
}

impl Default for Sight {
    fn default() -> Self {
        Self::People(Observer::default())
    }
}

impl Sight {
    /// The wavelengths that matter, nm.
    fn seen_nm(&self) -> std::ops::RangeInclusive<f64> {
        match self {
            Self::People(_) => SEEN_NM,
            Self::Sensor(sensor) => sensor.band().low_nm()..=sensor.band().high_nm(),
        }
    }

    /// What a reflectance of 1 at each wavelength gives of linear sRGB, where it is linear between them and held beyond.
    fn parts(&self, at: &Wavelengths) -> Vec<[f64; 3]> {
        match self {
            Self::People(observer) => observer.weights(at).rgb_parts().to_vec(),
            Self::Sensor(sensor) => of_sensor(sensor, at),
        }
    }

    /// How a reflectance, by nm, looks in linear sRGB.
    ///
    /// # Errors
    /// None: whole nm rise.
    pub fn shown(&self, reflectance: &dyn Fn(f64) -> f64) -> Result<[f64; 3]> {
        let at = Wavelengths::new((300..=830).map(f64::from).collect::<Vec<_>>())?;
        let mut sum = [0.0; 3];
        for (nm, parts) in at.nm().iter().zip(self.parts(&at)) {
            let value = reflectance(*nm);
            sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += value * part);
        }
        Ok(sum)
    }
}

/// As [`Sight::parts`], of what a sensor's channels answer in daylight.
fn of_sensor(sensor: &Sensor, at: &Wavelengths) -> Vec<[f64; 3]> {
    let mut channels = vec![[0.0; MOST_CHANNELS]; at.len()];
    let band = sensor.band();
    for nm in band.each_nm() {
        let is_end = nm == band.low_nm() || nm == band.high_nm();
        let daylight =
            Illuminant::D65.power(nm) / Illuminant::D65.power(560.0) * if is_end { 0.5 } else { 1.0 };
        let (low, share) = at.place(nm);
        for (channel, curve) in sensor.channels().iter().enumerate() {
            let answer = daylight * curve.response.at(nm);
            channels[low][channel] += answer * (1.0 - share);
            if share > 0.0 {
                channels[low + 1][channel] += answer * share;
            }
        }
    }
    channels.iter().map(|of| rgb_from_xyz(sensor.xyz(of))).collect()
}

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
    /// At most `most` of the tables' own wavelengths, nm, evenly among those that are seen from the first to the last, as they look to
    /// somebody: a spectrum is linear between those that are taken, held beyond, and its colour that of the trapezoidal rule at 1 nm.
    ///
    /// # Errors
    /// `most` is not from 2 to [`MOST_WAVES`], or the wavelengths do not rise.
    pub fn new(tables_nm: &[f64], sight: &Sight, most: usize) -> Result<Self> {
        let (first, all) = seen(tables_nm, sight, most)?;
        let count = most.min(all);
        // Rounded to the nearest.
        let at = |k: usize| first + (2 * k * (all - 1) + count - 1) / (2 * (count - 1).max(1));
        Self::of_places(tables_nm, sight, &(0..count).map(at).collect::<Vec<_>>())
    }

    /// All of the seen wavelengths in turns of at most `most`, each of which is a picture by itself: every so many-th, from the first, the
    /// second, … Their mean is the picture by all.
    ///
    /// # Errors
    /// As [`Waves::new`].
    pub fn turns(tables_nm: &[f64], sight: &Sight, most: usize) -> Result<Vec<Self>> {
        let (first, all) = seen(tables_nm, sight, most)?;
        let turns = all.div_ceil(most);
        let turn = |from: usize| {
            let places: Vec<usize> = (first + from..first + all).step_by(turns).collect();
            Self::of_places(tables_nm, sight, &places)
        };
        (0..turns).map(turn).collect()
    }

    fn of_places(tables_nm: &[f64], sight: &Sight, places: &[usize]) -> Result<Self> {
        let nm: Vec<f64> = places.iter().map(|place| tables_nm[*place]).collect();
        let parts = sight.parts(&Wavelengths::new(nm.as_slice())?);
        let mut uniform = Uniform { count: [nm.len() as u32, 0, 0, 0], ..Uniform::zeroed() };
        for (((wave, place), nm), [r, g, b]) in uniform.all.iter_mut().zip(places).zip(&nm).zip(&parts) {
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

/// Where the wavelengths that are seen begin, and how many they are. Of tables that nobody sees, or that are of one visible wavelength, all
/// count.
fn seen(tables_nm: &[f64], sight: &Sight, most: usize) -> Result<(usize, usize)> {
    if !(2..=MOST_WAVES).contains(&most) {
        return Err(Error::input(format!("a picture of {most} wavelengths; give 2 to {MOST_WAVES}")));
    }
    let range = sight.seen_nm();
    let first = tables_nm.iter().position(|nm| range.contains(nm)).unwrap_or(0);
    Ok(match tables_nm.iter().filter(|nm| range.contains(*nm)).count() {
        0 | 1 => (0, tables_nm.len()),
        seen => (first, seen),
    })
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
            let waves = Waves::new(usual.nm(), &Sight::default(), most).unwrap();
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
        let waves = Waves::new(&tables, &Sight::default(), 16).unwrap();
        assert_eq!(
            [waves.nm()[0], *waves.nm().last().unwrap(), waves.nm().len() as f64],
            [396.0, 700.0, 16.0]
        );
        assert_eq!(waves.uniform.all[0].place[0], 12.0);
        let dark = Waves::new(&[310.0, 330.0, 350.0], &Sight::default(), 16).unwrap();
        assert_eq!(dark.nm().len(), 3);
    }

    #[test]
    fn tables_of_one_wavelength_have_one() {
        let waves = Waves::new(&[550.0], &Sight::default(), 16).unwrap();
        assert_eq!(waves.nm(), [550.0]);
    }

    #[test]
    fn too_many_wavelengths_are_refused() {
        let refused = Waves::new(&[500.0, 600.0], &Sight::default(), 65).unwrap_err().to_string();
        assert_eq!(refused, "a picture of 65 wavelengths; give 2 to 64");
    }

    /// No wavelength is lost, none is taken twice, and each turn shows white as white.
    #[test]
    fn turns_go_through_all_wavelengths() {
        let usual = Wavelengths::usual();
        for most in [2, 6, 8, 25, 50, 64] {
            let turns = Waves::turns(usual.nm(), &Sight::default(), most).unwrap();
            let mut all: Vec<f64> = turns.iter().flat_map(|turn| turn.nm().to_vec()).collect();
            all.sort_by(f64::total_cmp);
            assert_eq!(all, usual.nm());
            assert!(turns.iter().all(|turn| turn.nm().len() <= most));
            for turn in &turns {
                let white = turn.linear_rgb(&vec![1.0; turn.nm().len()]);
                assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-9), "{white:?}");
            }
        }
    }

    /// The human eye as a sensor shows colours as the observer does; a bird's shows white as white.
    #[test]
    fn sensors_see_as_the_observer() {
        let reflectance = |nm: f64| 0.5 + 0.4 * ((nm - 450.0) / 60.0).sin();
        let people = Sight::default().shown(&reflectance).unwrap();
        let sensor = Sight::Sensor(Sensor::human()).shown(&reflectance).unwrap();
        for (a, b) in people.into_iter().zip(sensor) {
            assert!((a - b).abs() < 2e-3, "{people:?} {sensor:?}");
        }
        let white = Sight::Sensor(Sensor::human()).shown(&|_| 1.0).unwrap();
        assert!(white.iter().all(|v| (v - 1.0).abs() < 1e-6), "{white:?}");
    }
}
