//! Far fields as a document, as rows, and as words.

use std::fmt::Write as _;

use barbule::Complex64;
use barbule::scattering::far_field::{FarField, IncidentLight, Polarization};
use barbule::solve::far_fields::{Effort, Exact, Scattered};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::{Fields, Mirror};

impl Fields<'_> {
    /// Every far field with its wavelength (nm), θ_i and φ_i (degrees as typed), φ_i fastest.
    fn cases(&self) -> impl Iterator<Item = ([f64; 3], &Scattered)> {
        let (thetas, phis) = (self.theta_deg.len(), self.phi_deg.len());
        self.found.iter().enumerate().map(move |(index, found)| {
            let (rest, phi) = (index / phis, self.phi_deg[index % phis]);
            ([self.wavelengths_nm[rest / thetas], self.theta_deg[rest % thetas], phi], found)
        })
    }
}

/// The contract's JSON. Of several far fields every value has the axes `[wavelength][theta][phi]` before its own, and the
/// axes stand beside: `wavelength_nm`, `theta_deg`, `phi_deg`.
pub(super) struct Document<'a>(pub(super) &'a Fields<'a>);

impl Serialize for Document<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(fields) = self;
        let shape = [fields.wavelengths_nm.len(), fields.theta_deg.len(), fields.phi_deg.len()];
        let mut map = serializer.serialize_map(None)?;
        let sizes: &[usize] = if fields.found.len() == 1 {
            &[]
        } else {
            map.serialize_entry("wavelength_nm", fields.wavelengths_nm)?;
            map.serialize_entry("theta_deg", fields.theta_deg)?;
            map.serialize_entry("phi_deg", fields.phi_deg)?;
            &shape
        };
        let found = fields.found;
        if let Some(first) = found.first() {
            map.serialize_entry("phi_out_deg", &phi_out_deg(&first.far))?;
        }
        let power = |found: &Scattered| match found.far.light {
            IncidentLight::Beam { power_um } => Some(power_um),
            IncidentLight::PlaneWave => None,
        };
        map.serialize_entry("incident_power", &Stacked { found, sizes, of: &power })?;
        for (polarization, name) in Polarization::BOTH.into_iter().zip(["polarization_1", "polarization_2"]) {
            map.serialize_entry(name, &Polarized { found, sizes, polarization })?;
        }
        let efforts: Vec<Effort> = found.iter().filter_map(|found| found.effort).collect();
        if !efforts.is_empty() {
            let found = &efforts[..];
            let unknowns = |effort: &Effort| effort.unknowns;
            let elements = |effort: &Effort| effort.elements_per_wavelength;
            let seconds = |effort: &Effort| effort.seconds;
            let memory = |effort: &Effort| effort.memory_bytes;
            map.serialize_entry("unknowns", &Stacked { found, sizes, of: &unknowns })?;
            map.serialize_entry("elements_per_wavelength", &Stacked { found, sizes, of: &elements })?;
            map.serialize_entry("seconds", &Stacked { found, sizes, of: &seconds })?;
            map.serialize_entry("memory_bytes", &Stacked { found, sizes, of: &memory })?;
        }
        if fields.mirrors.is_empty() {
            return map.end();
        }
        let mirror = |mirror: &Mirror| mirror.fraction;
        map.serialize_entry("mirror_fraction", &Stacked { found: fields.mirrors, sizes, of: &mirror })?;
        let flagged = |mirror: &Mirror| mirror.is_flagged();
        map.serialize_entry("flagged", &Stacked { found: fields.mirrors, sizes, of: &flagged })?;
        map.end()
    }
}

/// What leaves for one incident polarization.
struct Polarized<'a> {
    found: &'a [Scattered],
    sizes: &'a [usize],
    polarization: Polarization,
}

impl Serialize for Polarized<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { found, sizes, polarization } = *self;
        let p = polarization.index();
        let complex = |along: usize| {
            move |found: &Scattered| {
                let values: &[Complex64] = &found.far.amplitudes[p][along];
                values.iter().map(|z| [z.re, z.im]).collect::<Vec<_>>()
            }
        };
        let intensity = |found: &Scattered| found.far.per_radian(polarization);
        let reflected = |found: &Scattered| found.reflected.map(|both| both[p]);
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("intensity", &Stacked { found, sizes, of: &intensity })?;
        map.serialize_entry("e1", &Stacked { found, sizes, of: &complex(0) })?;
        map.serialize_entry("e2", &Stacked { found, sizes, of: &complex(1) })?;
        map.serialize_entry("reflected_fraction", &Stacked { found, sizes, of: &reflected })?;
        let exact: Vec<Exact> = found.iter().filter_map(|found| found.exact).collect();
        if !exact.is_empty() {
            let found = &exact[..];
            let scattered = |exact: &Exact| exact.scattered_um[p];
            let extinction = |exact: &Exact| exact.extinction_um.map(|both| both[p]);
            let absorbed = |exact: &Exact| exact.absorbed_um[p];
            map.serialize_entry("scattered", &Stacked { found, sizes, of: &scattered })?;
            map.serialize_entry("extinction", &Stacked { found, sizes, of: &extinction })?;
            map.serialize_entry("absorbed", &Stacked { found, sizes, of: &absorbed })?;
        }
        map.end()
    }
}

/// One quantity of far fields, or of what belongs to each, as nested lists of these sizes; without sizes, that of the only one.
struct Stacked<'a, I, F> {
    found: &'a [I],
    sizes: &'a [usize],
    of: &'a F,
}

impl<I, T: Serialize, F: Fn(&I) -> T> Serialize for Stacked<'_, I, F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { found, sizes, of } = *self;
        match (sizes, found) {
            ([], [only, ..]) => of(only).serialize(serializer),
            ([], []) => serializer.serialize_none(),
            ([_, rest @ ..], _) => {
                let each = rest.iter().product::<usize>().max(1);
                serializer.collect_seq(found.chunks_exact(each).map(|found| Stacked {
                    found,
                    sizes: rest,
                    of,
                }))
            }
        }
    }
}

fn phi_out_deg(far: &FarField) -> Vec<f64> {
    far.azimuths.phi_o().iter().map(|phi| phi.to_degrees()).collect()
}

/// One row for each outgoing azimuth: intensities (1/rad, or µm/rad of a plane wave) and amplitudes of both incident
/// polarizations.
pub(super) fn csv(fields: &Fields<'_>) -> String {
    let mut text = String::from(
        "wavelength_nm,theta_deg,phi_deg,phi_out_deg,intensity_1,intensity_2,\
         e1_re_1,e1_im_1,e2_re_1,e2_im_1,e1_re_2,e1_im_2,e2_re_2,e2_im_2\n",
    );
    for ([nm, theta, phi], Scattered { far, .. }) in fields.cases() {
        let intensity = Polarization::BOTH.map(|p| far.per_radian(p));
        for (n, phi_out) in phi_out_deg(far).into_iter().enumerate() {
            // Writing to a string cannot fail, here and below.
            let _ = write!(text, "{nm},{theta},{phi},{phi_out},{},{}", intensity[0][n], intensity[1][n]);
            for component in far.amplitudes.iter().flatten() {
                let _ = write!(text, ",{},{}", component[n].re, component[n].im);
            }
            text.push('\n');
        }
    }
    text
}

/// One far field: its power, then azimuths and intensities as columns.
pub(super) fn table(found: &Scattered) -> String {
    let Scattered { far, reflected, exact, effort } = found;
    let intensity = Polarization::BOTH.map(|p| far.per_radian(p));
    let [first, second] = reflected.unwrap_or(far.radiated);
    let (unit, mut text) = match far.light {
        IncidentLight::PlaneWave if exact.is_some() => ("µm/rad", String::new()),
        IncidentLight::Beam { power_um } => (
            "1/rad",
            format!(
                "incident power {power_um:.6} µm, reflected fraction {first:.6} (polarization 1), {second:.6} (2)\n"
            ),
        ),
        IncidentLight::PlaneWave => {
            ("µm/rad", format!("reflected width {first:.6} µm (polarization 1), {second:.6} µm (2)\n"))
        }
    };
    if let Some(exact) = exact {
        for p in [0, 1] {
            let extinct = exact.extinction_um.map(|both| format!(", extinct {:.6}", both[p]));
            let _ = writeln!(
                text,
                "polarization {}: scattered {:.6}, absorbed {:.6}{} µm",
                p + 1,
                exact.scattered_um[p],
                exact.absorbed_um[p],
                extinct.unwrap_or_default()
            );
        }
    }
    if let Some(effort) = effort {
        let _ = writeln!(
            text,
            "{} unknowns, {} nodes per wavelength, {:.2} s",
            effort.unknowns, effort.elements_per_wavelength, effort.seconds
        );
    }
    let heading = |p: usize| format!("intensity {p} ({unit})");
    let _ = write!(text, "{:>9}  {:>20}  {:>20}", "φ_o (°)", heading(1), heading(2));
    for (n, phi) in phi_out_deg(far).into_iter().enumerate() {
        let _ = write!(text, "\n{phi:>9.3}  {:>20.5e}  {:>20.5e}", intensity[0][n], intensity[1][n]);
    }
    text
}

/// Several far fields, one in each row: what part is reflected, and where and how high the mean intensity peaks.
pub(super) fn summary(fields: &Fields<'_>) -> String {
    let (part, unit) = match fields.found.first().map(|found| found.far.light) {
        Some(IncidentLight::PlaneWave) => ("width (µm)", "µm/rad"),
        _ => ("reflected", "1/rad"),
    };
    let mut text = format!(
        "{:>8}  {:>8}  {:>8}  {:>12}  {:>12}  {:>13}  {:>16}",
        "λ (nm)",
        "θ_i (°)",
        "φ_i (°)",
        format!("{part} 1"),
        format!("{part} 2"),
        "peak φ_o (°)",
        format!("there ({unit})")
    );
    for ([nm, theta, phi], Scattered { far, reflected, .. }) in fields.cases() {
        let [first, second] = Polarization::BOTH.map(|p| far.per_radian(p));
        let mean = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b));
        let (peak, height) = phi_out_deg(far)
            .into_iter()
            .zip(mean)
            .fold((0.0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best });
        let [one, two] = reflected.unwrap_or(far.radiated);
        let _ = write!(
            text,
            "\n{nm:>8}  {theta:>8}  {phi:>8}  {one:>12.6}  {two:>12.6}  {peak:>13.3}  {height:>16.5e}"
        );
    }
    text + "\n--json or --csv gives all azimuths"
}
