//! Batches of directions and wavelengths, as the kernels of materials take them: some rows at a time, wavelengths in fours.

use std::sync::atomic::{AtomicBool, Ordering};

use barbule::brdf::FeatherBrdf;
use barbule::characterize::WAVELENGTHS_NM;
use barbule::{DVec3, Error, Result};
use rayon::prelude::*;

/// Directions that one thread does in a row.
const BLOCK: usize = 1024;
/// Wavelengths that the kernel does at once.
const LANES: usize = 4;
/// Fours of wavelengths whose arguments are gathered at a time: few enough for the nearest cache.
const GATHERED: usize = 128;

/// Rows of numbers, one for all or one for each value.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a, T> {
    values: &'a [T],
    width: usize,
    step: usize,
}

impl<'a, T: Copy> Rows<'a, T> {
    pub(crate) fn new(name: &str, values: &'a [T], width: usize, count: usize) -> Result<Self> {
        let step = if values.len() == width { 0 } else { width };
        if values.len() != width && values.len() != width * count {
            let rows = values.len() / width.max(1);
            return Err(Error::input(format!("'{name}' has {rows} rows for {count} values")));
        }
        Ok(Self { values, width, step })
    }

    pub(crate) fn at(&self, row: usize) -> &'a [T] {
        &self.values[row * self.step..][..self.width]
    }

    fn is_one(&self) -> bool {
        self.step == 0
    }
}

pub(crate) fn vector(row: &[f64]) -> DVec3 {
    DVec3::new(row[0], row[1], row[2])
}

pub(crate) fn is_unit(w: DVec3) -> bool {
    (0.999..=1.001).contains(&w.length_squared())
}

fn is_wavelength(nm: f64) -> bool {
    WAVELENGTHS_NM.contains(&nm)
}

/// Refuses directions that are no unit vectors, with the first of them.
pub(crate) fn check_unit(name: &str, rows: Rows<'_, f64>) -> Result<()> {
    let bad = rows.values.par_chunks_exact(3).position_first(|w| !is_unit(vector(w)));
    bad.map_or(Ok(()), |row| {
        let [x, y, z] = [0, 1, 2].map(|k| rows.values[3 * row + k]);
        Err(Error::input(format!(
            "'{name}' in row {row} is ({x}, {y}, {z}), of length {:.3}; give unit vectors",
            vector(&[x, y, z]).length()
        )))
    })
}

/// Refuses what is no wavelength.
pub(crate) fn check_nm(name: &str, rows: Rows<'_, f64>) -> Result<()> {
    let bad = rows.values.par_iter().find_first(|nm| !is_wavelength(**nm));
    bad.map_or(Ok(()), |bad| {
        let (low, high) = (WAVELENGTHS_NM.start(), WAVELENGTHS_NM.end());
        Err(Error::input(format!("'{name}' holds {bad}; give {low} to {high} nm")))
    })
}

/// A batch of evaluations, as rows.
pub(crate) struct Batch<'a> {
    nm: Rows<'a, f64>,
    wi: Rows<'a, f64>,
    wo: Rows<'a, f64>,
    count: usize,
}

impl<'a> Batch<'a> {
    pub(crate) fn new(
        nm: &'a [f64],
        waves: usize,
        wi: &'a [f64],
        wo: &'a [f64],
        count: usize,
    ) -> Result<Self> {
        if waves == 0 {
            return Err(Error::input("'wavelengths_nm' is empty; give at least one"));
        }
        Ok(Self {
            nm: Rows::new("wavelengths_nm", nm, waves, count)?,
            wi: Rows::new("wi", wi, 3, count)?,
            wo: Rows::new("wo", wo, 3, count)?,
            count,
        })
    }

    /// Refuses what is no wavelength or no direction.
    pub(crate) fn check(&self) -> Result<()> {
        check_nm("wavelengths_nm", self.nm)?;
        check_unit("wi", self.wi)?;
        check_unit("wo", self.wo)
    }

    /// Four wavelengths of a row from the `first` on; the last one stands for those that there are not.
    fn lanes(&self, row: usize, first: usize) -> [f32; LANES] {
        let nm = self.nm.at(row);
        std::array::from_fn(|lane| nm[(first + lane).min(nm.len() - 1)] as f32)
    }

    /// f `[row, wavelength]`, in parallel. Arguments are looked at when they are read, which they are once.
    pub(crate) fn eval(&self, brdf: &FeatherBrdf, instance: Option<Rows<'_, u64>>) -> Result<Vec<f32>> {
        let waves = self.nm.width;
        let mut all = vec![0.0; self.count * waves];
        let is_bad = AtomicBool::new(false);
        all.par_chunks_mut(waves * BLOCK).enumerate().for_each_init(
            || Gathered::new(waves, instance.is_some()),
            |gathered, (block, chunk)| {
                let rows = gathered.rows;
                for (k, chunk) in chunk.chunks_mut(waves * rows).enumerate() {
                    if !gathered.gather(self, instance, block * BLOCK + k * rows, chunk.len() / waves) {
                        is_bad.store(true, Ordering::Relaxed);
                    }
                    gathered.eval(brdf, chunk);
                }
            },
        );
        if is_bad.into_inner() || self.count == 0 {
            self.check()?;
        }
        Ok(all)
    }

    pub(crate) fn pdf(&self, brdf: &FeatherBrdf) -> Vec<f64> {
        let waves = self.nm.width;
        let mut all = vec![0.0; self.count * waves];
        all.par_chunks_mut(waves * BLOCK).enumerate().for_each(|(block, chunk)| {
            for first in (0..waves).step_by(LANES) {
                self.fill_pdf(brdf, chunk, block * BLOCK, first);
            }
        });
        all
    }

    /// Fills the densities of rows from `row` on at up to four wavelengths from the `first` on.
    fn fill_pdf(&self, brdf: &FeatherBrdf, chunk: &mut [f64], row: usize, first: usize) {
        let waves = self.nm.width;
        let width = LANES.min(waves - first);
        let shared = (self.nm.is_one() && self.wi.is_one())
            .then(|| brdf.prepare(self.lanes(0, first), vector(self.wi.at(0))));
        for (k, to) in chunk.chunks_exact_mut(waves).enumerate() {
            let wo = vector(self.wo.at(row + k));
            let found = match &shared {
                Some(prepared) => prepared.pdfs(wo),
                None => brdf.pdfs(self.lanes(row + k, first), vector(self.wi.at(row + k)), wo),
            };
            to[first..first + width].copy_from_slice(&found[..width]);
        }
    }
}

/// Some rows as the kernel takes them: wavelengths in fours, of which the last one repeats the last wavelength.
struct Gathered {
    waves: usize,
    /// Rows at a time.
    rows: usize,
    pairs: Vec<[DVec3; 2]>,
    nm: Vec<[f32; LANES]>,
    names: Option<Vec<u64>>,
    values: Vec<[f32; LANES]>,
}

impl Gathered {
    fn new(waves: usize, has_names: bool) -> Self {
        let fours = waves.div_ceil(LANES);
        let rows = (GATHERED / fours).clamp(8, BLOCK);
        let values = vec![[0.0; LANES]; rows * fours];
        Self {
            waves,
            rows,
            pairs: Vec::with_capacity(rows),
            nm: Vec::with_capacity(rows * fours),
            names: has_names.then(|| Vec::with_capacity(rows)),
            values,
        }
    }

    /// Whether all are directions and wavelengths.
    fn gather(&mut self, batch: &Batch<'_>, names: Option<Rows<'_, u64>>, first: usize, rows: usize) -> bool {
        let at = first..first + rows;
        self.pairs.clear();
        self.pairs.extend(at.clone().map(|row| [vector(batch.wi.at(row)), vector(batch.wo.at(row))]));
        let mut is_good = self.pairs.iter().fold(true, |good, [wi, wo]| good & is_unit(*wi) & is_unit(*wo));
        self.nm.clear();
        for row in at.clone() {
            let nm = batch.nm.at(row);
            is_good &= nm.iter().fold(true, |good, nm| good & is_wavelength(*nm));
            let (fours, rest) = nm.as_chunks::<LANES>();
            self.nm.extend(fours.iter().map(|four| four.map(|nm| nm as f32)));
            if let Some(last) = rest.last() {
                self.nm.push(std::array::from_fn(|k| *rest.get(k).unwrap_or(last) as f32));
            }
        }
        if let (Some(to), Some(names)) = (&mut self.names, names) {
            to.clear();
            to.extend(at.map(|row| names.at(row)[0]));
        }
        is_good
    }

    /// Values of what was gathered last.
    fn eval(&mut self, brdf: &FeatherBrdf, to: &mut [f32]) {
        let names = self.names.as_deref();
        if let (fours, []) = to.as_chunks_mut::<LANES>()
            && self.waves.is_multiple_of(LANES)
        {
            return brdf.eval_all(&self.pairs, &self.nm, names, fours);
        }
        let values = &mut self.values[..self.nm.len()];
        brdf.eval_all(&self.pairs, &self.nm, names, values);
        let fours = values.len() / self.pairs.len();
        for (to, values) in to.chunks_exact_mut(self.waves).zip(values.chunks_exact(fours)) {
            to.copy_from_slice(&values.as_flattened()[..self.waves]);
        }
    }
}
