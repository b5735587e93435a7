//! A feather's vane as a surface, seen from so far that a pixel holds several barbs.
//!
//! A hit is the ramus, a barbule to the left or right, or a gap, with the weights that
//! [`masking`](super::masking) gives the viewer's direction; which of them, and where on its section the ray meets it, is drawn from a
//! hash of the hit's place. So one hit has one scattering function, and the mean over the hits of a pixel is the mixture of all
//! parts over their visible widths. Gaps are what passes unchanged. What the part scatters is multiplied by the share of it that the
//! light reaches as well, which makes masking reciprocal; that light is lost which one barb keeps from another.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::DVec3;

use super::barb::{Row, Substance, tents};
use super::frame::Frame;
use super::hair::FibreSection;
use super::hit::{Hit, OnRibbon};
use super::masking::{Barbs, Barbules, LEFT, MaskingTable, PARTS, PartSeen, RAMUS};
use super::{Bsdf, Shade};
use crate::math::rng::{hash, split_mix, unit_of};
use crate::spectrum::dense::Lambdas;

/// A vane: the surface of a mesh whose frame's y is the barbs' direction and z the vane's normal.
#[derive(Debug, Clone)]
pub struct VaneSurface {
    barbs: Barbs,
    table: Arc<MaskingTable>,
    /// Of the rami, of the barbules to their left (−x) and to their right.
    substances: [Substance; PARTS],
    /// The barbules' rows, if they bend and differ from each other.
    rows: Option<[Row; 2]>,
    /// Length of a barbule's cell, mm; 0 where a barbule is one.
    cell_mm: f64,
}

/// What shades a part from directions.
pub(super) struct Masked<'a> {
    table: &'a MaskingTable,
    part: usize,
    frame: Frame,
    seen: PartSeen,
}

impl Masked<'_> {
    /// Share of what is seen that light from a direction reaches.
    #[inline]
    pub(super) fn share(&self, wi: DVec3) -> f64 {
        self.seen.lit(&self.table.part(self.part, self.frame.to_local(wi)))
    }
}

impl VaneSurface {
    /// Builds the masking table, which takes about 0.15 s.
    ///
    /// - `barbs`: lengths in any one unit
    /// - `substances`: of the rami, of the barbules to their left (−x) and to their right
    /// - `cell_mm`: length of a barbule's cell; 0 where a barbule is one
    #[must_use]
    pub fn new(barbs: Barbs, substances: [Substance; PARTS], cell_mm: f64) -> Self {
        Self { barbs, table: Arc::new(MaskingTable::new(&barbs)), substances, rows: None, cell_mm }
    }

    /// The same with barbules that bend and differ from each other as those of these rows, to the left and to the right. Masking
    /// is still that of the mean.
    #[must_use]
    pub fn with_rows(self, rows: [Row; 2]) -> Self {
        Self { rows: Some(rows), ..self }
    }

    /// The axes of a barbule of this name, in the frame of the barb.
    fn axes(&self, which: usize, side: f64, name: u64) -> [DVec3; 3] {
        let Some(rows) = &self.rows else { return self.barbs.barbules[which].axes(side) };
        let (row, t) = (&rows[which], unit_of(split_mix(name ^ 1)));
        let [swing, turn] = tents(name);
        let [raise, bow] = tents(split_mix(name));
        let lift = row.lift_at(t) + row.disorder.lift * (raise + row.bow_at(t) * bow);
        let drawn = Barbules {
            angle: row.angle_at(t) + row.disorder.angle * swing,
            lift,
            tilt: row.tilt_at(t) + row.disorder.turn * turn,
            ..self.barbs.barbules[which]
        };
        drawn.axes(side)
    }

    /// Its masking.
    #[must_use]
    pub fn masking(&self) -> &MaskingTable {
        &self.table
    }

    /// See [`super::Surface::opacity`]: what is not gaps. The same from both ends of a line.
    #[inline(never)]
    pub(super) fn opacity(&self, hit: &Hit, wo: DVec3) -> f64 {
        (1.0 - self.table.seen(hit.frame.to_local(wo))[PARTS]).clamp(0.0, 1.0)
    }

    /// At a hit, seen from `wo`.
    #[inline(never)] // much code, for few of a picture's surfaces
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        let local = hit.frame.to_local(wo);
        let name = hash(hit.id, &hit.position.to_array().map(f64::to_bits));
        let part = self.part(local, unit_of(name));
        let seen = self.table.part(part, local);
        let (offset, normal) = self.table.place(part, &seen, local, unit_of(split_mix(name)));
        let axes = match part {
            RAMUS => [DVec3::X, DVec3::Y, DVec3::Z],
            LEFT => self.axes(0, -1.0, name),
            _ => self.axes(1, 1.0, name),
        };
        let [x, y, z] = axes.map(|axis| hit.frame.to_world(axis));
        let frame = Frame { x, y, z };
        let bsdf = match &self.substances[part] {
            Substance::Fibre(hair) => {
                hair.bind_section(&FibreSection { axis: y, up: z, offset, pigment: 1.0 }, wo, wavelengths)
            }
            Substance::Keratin(keratin) => {
                let normal = hit.frame.to_world(normal);
                keratin.bind(&Hit { normal, frame: Frame::new(normal, y), ..*hit }, wo, wavelengths)
            }
            Substance::Plate(plate) => plate.bind(&self.cell(hit, frame, name), wo, wavelengths),
        };
        bsdf.shaded(Shade::Masked(Masked { table: &self.table, part, frame: hit.frame, seen }))
    }

    /// Which part is seen, by a uniform number.
    fn part(&self, local: DVec3, u: f64) -> usize {
        let seen = self.table.seen(local);
        let mut rest = u * seen[..PARTS].iter().sum::<f64>();
        let mut part = RAMUS;
        while part < PARTS - 1 && rest >= seen[part] {
            rest -= seen[part];
            part += 1;
        }
        part
    }

    /// Any place of any cell of any barbule. So many are in a pixel that of their instances the mean is seen.
    fn cell(&self, hit: &Hit, frame: Frame, name: u64) -> Hit {
        let name = split_mix(!name);
        let ribbon = OnRibbon {
            cell: name,
            place: unit_of(name),
            cell_length: self.cell_mm,
            contrast: 0.0,
            ..OnRibbon::default()
        };
        Hit {
            normal: frame.z,
            vane_normal: hit.frame.z,
            frame,
            ribbon,
            id: split_mix(name),
            instance: name,
            ..*hit
        }
    }
}
