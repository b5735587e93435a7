//! The files that a traced picture becomes: lattice, species, section.

use serde_json::json;

use super::TracedImage;
use crate::io::section_json;
use crate::structure::{
    Circle, Inclusion, Lattice, Loop, Medium, Parts, Polyline, Rod, Section, SpeciesFile, Substance,
};
use crate::trace::Kind;
use crate::{Error, Result};

/// Rods that overlap by less than this part of their distance are taken to touch.
const TOUCH: f64 = 0.03;
/// Corners of outlines are at least so far from each other, px.
const APART_PX: f64 = 1.0;
/// How wide a barbule of traced layers is, µm.
const WIDTH_UM: f64 = 20.0;

impl TracedImage {
    /// The lattice.
    ///
    /// # Errors
    /// The picture was traced as something else, or a lattice of such measures cannot be, as one with rods that overlap.
    pub fn lattice(&self) -> Result<Lattice> {
        let Some(found) = self.traced.lattice.as_ref().filter(|_| self.traced.kind == Kind::Lattice) else {
            return Err(Error::input("was not traced as a lattice, so that there is none to write"));
        };
        let um = |px: f64| px * self.nm_per_px * 1e-3;
        let [period, pitch] = [um(found.period.mean), um(found.row_pitch.mean)];
        let beside = pitch.hypot(found.row_shift.mean * period);
        let nearest = if found.rows > 1 { period.min(beside) } else { period };
        let diameter = um(found.diameter.mean);
        // Rods that touch come out a little too large as easily as too small.
        let diameter = if diameter < (1.0 + TOUCH) * nearest { diameter.min(nearest) } else { diameter };
        let class = |index: usize| Substance::named(&self.media[self.traced.around_rods[index]]);
        let mut circles = vec![Circle {
            diameter_um: diameter,
            medium: Substance::named(&self.media[self.media.len() - 1]),
        }];
        if found.hollow.mean > 0.0 {
            circles.push(Circle { diameter_um: um(found.hollow.mean), medium: class(1) });
        }
        let rods = vec![Rod { x_um: 0.0, z_um: 0.0, rows: None, circles }];
        let lattice = Lattice {
            period_um: period,
            host: class(0),
            incidence: Substance::named("air"),
            depth_to_center_um: Lattice::depth_under_cortex(self.cortex_nm * 1e-3, &rods),
            rows: found.rows,
            row_pitch_um: if found.rows > 1 { pitch } else { period },
            row_shift: found.row_shift.mean,
            rods,
            library: self.library.clone(),
        };
        lattice.check().map_err(|error| error.at("the traced lattice"))?;
        Ok(lattice)
    }

    /// The text of a file that simulates: a lattice as TOML or JSON, layers as a species (TOML) or a section (JSON), a section as JSON.
    /// `source` says where it comes from.
    ///
    /// # Errors
    /// A section cannot be TOML; or what was traced is no structure that can be simulated.
    pub fn file(&self, is_json: bool, source: &str) -> Result<String> {
        match (self.traced.kind, is_json) {
            (Kind::Lattice, _) => self.lattice_text(is_json, source),
            (Kind::Layers, false) => self.species_text(source),
            (_, true) => Ok(format!("{}\n", section_json(&self.section(source)?))),
            (Kind::Section, false) => Err(Error::input(
                "was traced as a section, which is written as .json; end the output's name with that",
            )),
        }
    }

    fn lattice_text(&self, is_json: bool, source: &str) -> Result<String> {
        let lattice = self.lattice()?;
        let rod = &lattice.rods[0];
        let circles: Vec<(f64, String)> =
            rod.circles.iter().map(|circle| (rounded(circle.diameter_um), circle.medium.label())).collect();
        let [period, cortex, pitch] =
            [lattice.period_um, self.cortex_nm * 1e-3, lattice.row_pitch_um].map(rounded);
        let shift = (lattice.row_shift * 1e4).round() / 1e4;
        if is_json {
            let circles: Vec<_> =
                circles.iter().map(|(d, medium)| json!({"diameter": d, "medium": medium})).collect();
            let document = json!({"lattice": {
                "period": period, "host": lattice.host.label(), "incidence": "air", "cortex": cortex, "rows": lattice.rows,
                "row_pitch": pitch, "row_shift": shift, "rod": [{"circles": circles}],
            }});
            return Ok(format!("{document}\n"));
        }
        let circles: Vec<String> = circles
            .iter()
            .map(|(d, medium)| format!("{{ diameter = {d}, medium = {} }}", text(medium)))
            .collect();
        let measured = self.traced.lattice.as_ref().map_or(String::new(), |found| {
            format!(
                "# {} rods; standard deviations: period {:.1} nm, row pitch {:.1} nm, diameter {:.1} nm\n",
                self.traced.rods.len(),
                found.period.std * self.nm_per_px,
                found.row_pitch.std * self.nm_per_px,
                found.diameter.std * self.nm_per_px
            )
        });
        Ok(format!(
            "# {}\n{measured}[lattice]\nperiod = {period}\nhost = {}\nincidence = \"air\"\ncortex = {cortex}\nrows = {}\nrow_pitch = {pitch}\nrow_shift = {shift}\n\n[[lattice.rod]]\ncircles = [ {} ]\n",
            one_line(source),
            text(&lattice.host.label()),
            lattice.rows,
            circles.join(", ")
        ))
    }

    /// Layers as a species of the generator `multilayer`: means and spreads.
    fn species_text(&self, source: &str) -> Result<String> {
        let medium = |index: usize| self.media[self.traced.bands.classes[index]].as_str();
        let last = self.traced.bands.classes.len() - 1;
        let mut layers = String::new();
        for (name, thickness) in self.layers_nm() {
            layers += &format!(
                "    {{ medium = {}, thickness_um = {} }}, # ± {:.1} nm along the picture\n",
                text(name),
                rounded(thickness.mean * 1e-3),
                thickness.std
            );
        }
        let above = if medium(0) == "air" {
            String::new()
        } else {
            format!(
                "# above the first layer the picture has {}, which its border cuts: the file has air there\n",
                medium(0)
            )
        };
        let out = format!(
            "# {}\n{above}barbule = 1\nname = {}\ngenerator = \"multilayer\"\nsource = {}\n\n[parameters]\nwidth_um = {WIDTH_UM:.1}\nlayers = [\n{layers}]\ncore = {}\nlower = \"none\"\n",
            one_line(source),
            text(&self.name),
            text(source),
            text(medium(last))
        );
        let file = SpeciesFile::parse(&out).and_then(|file| file.model(None, self.library.clone()));
        file.map_err(|error| error.at("the traced layers"))?;
        Ok(out)
    }

    /// The section: boundaries from side to side, whole regions as inclusions. x runs along the picture from its middle, z upwards from
    /// the top's mean. Where no air lies over it, the picture's upper border is its top.
    ///
    /// # Errors
    /// Outlines that cross: two regions touch.
    pub fn section(&self, source: &str) -> Result<Section> {
        let traced = &self.traced;
        let scale = self.nm_per_px * 1e-3;
        let [width, height] = traced.flat.size().map(|side| side as f64);
        let middle = [0.5 * width, 0.5 * height];
        // Layers lie level in a section.
        let (sin, cos) =
            if traced.kind == Kind::Layers { traced.turn_deg.to_radians().sin_cos() } else { (0.0, 1.0) };
        let place = |p: &[f64; 2]| {
            let [u, v] = [p[0] - middle[0], p[1] - middle[1]];
            [scale * (cos * u + sin * v), -scale * (cos * v - sin * u)]
        };
        let mut media: Vec<Medium> =
            traced.bands.classes.iter().map(|c| Medium::named(&self.media[*c])).collect();
        let mut curves: Vec<Vec<[f64; 2]>> =
            traced.bands.boundaries.iter().map(|b| b.iter().map(place).collect()).collect();
        let half = scale * middle[0];
        if media.is_empty() {
            media.push(Medium::named(&self.media[traced.around_rods[0]]));
        }
        if media[0] != Medium::named("air") || curves.is_empty() {
            if media[0] != Medium::named("air") {
                media.insert(0, Medium::named("air"));
            }
            let top = scale * middle[1];
            curves.insert(0, vec![[-half, top], [0.0, top], [half, top]]);
        }
        let width_um = curves[0].first().zip(curves[0].last()).map(|(a, b)| b[0] - a[0]);
        let level = curves[0].iter().map(|p| p[1]).sum::<f64>() / curves[0].len().max(1) as f64;
        let polyline = |points: &[[f64; 2]]| Polyline {
            x_um: points.iter().map(|p| rounded(p[0])).collect(),
            z_um: points.iter().map(|p| rounded(p[1] - level)).collect(),
        };
        let inclusions = traced
            .inclusions
            .iter()
            .map(|(class, outline)| {
                let corners: Vec<[f64; 2]> = outline.thinned(APART_PX).corners.iter().map(place).collect();
                let line = polyline(&corners);
                Inclusion {
                    outline: Loop::polygon(line.x_um, line.z_um),
                    medium: Medium::named(&self.media[*class]),
                    holes: Vec::new(),
                }
            })
            .collect();
        let parts = Parts {
            name: self.name.clone(),
            width_um,
            boundaries: curves.iter().map(|curve| polyline(curve)).collect(),
            media,
            inclusions,
            crystal: None,
            source: source.to_owned(),
        };
        Section::new(parts, self.library.clone()).map_err(|error| {
            error.at("the traced section").followed_by("; other thresholds may part what touches")
        })
    }
}

/// To a thousandth of a nanometre.
fn rounded(um: f64) -> f64 {
    (um * 1e6).round() / 1e6
}

/// A text as TOML has it.
fn text(words: &str) -> String {
    json!(words).to_string()
}

fn one_line(words: &str) -> String {
    words.chars().map(crate::error::visible).collect()
}
