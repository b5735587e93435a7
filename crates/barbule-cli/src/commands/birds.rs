//! `barbule birds`: whose eyes are known, what their cones answer to, and where those numbers come from.

use std::io::Write;

use barbule::vision::{Cone, Eye};
use barbule::{Result, figures, open};
use serde_json::{Value, json};

use crate::common::{Common, print, print_json};
use crate::figure::FigureArgs;
use crate::provenance::Provenance;

/// Arguments of `barbule birds`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule birds\n  barbule birds starling -o cones.svg\n  \
    barbule birds blue-tit --json\n\n\
    Sensitivities are answers to quanta, 1 at their peaks, from 300 to 700 nm. A file of your own: docs/formats/bird.md.")]
pub(crate) struct Args {
    /// A bird, or a file of an eye [default: all that are built in]
    #[arg(value_name = "NAME|FILE")]
    bird: Option<String>,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.figure.check(&self.common)?;
        let Some(name) = &self.bird else { return self.list(out) };
        let eye = open::eye(name)?;
        if let Some(path) = self.figure.path() {
            let title = self.figure.title(title(&eye));
            let drawing = figures::sensitivities(&title, &eye, &self.figure.page()?);
            Provenance::new(&self.common).write_figure(path, &drawing)?;
            self.common.wrote(path, &format!("sensitivities of the cones of {}", eye.name));
        }
        if self.common.json {
            return print_json(out, &document(&eye));
        }
        print(out, &title(&eye))?;
        for cone in eye.all_cones() {
            let source = if cone.source.is_empty() { String::new() } else { format!(": {}", cone.source) };
            print(out, &format!("  {} {:.0} nm{source}", cone.name, cone.peak_nm))?;
        }
        let numbers: Vec<String> = eye.cones.iter().map(|cone| cone.abundance.to_string()).collect();
        print(
            out,
            &format!(
                "  cones {}, Weber fraction {}, of double cones {}",
                numbers.join(":"),
                eye.weber,
                eye.weber_double
            ),
        )?;
        eye.sources.iter().try_for_each(|source| print(out, &format!("  source: {source}")))
    }

    fn list(&self, out: &mut dyn Write) -> Result<()> {
        if self.figure.path().is_some() {
            self.common.idle("-o", "a figure is of one bird; name it");
        }
        let eyes = open::eye_names().map(|name| Ok((name, open::eye(name)?))).collect::<Result<Vec<_>>>()?;
        if self.common.json {
            let row = |(name, eye): &(&str, Eye)| {
                json!({
                    "name": name, "title": eye.name, "latin": eye.latin,
                    "cones": eye.cones.iter().map(|c| json!({"name": c.name, "peak_nm": c.peak_nm})).collect::<Vec<_>>(),
                })
            };
            return print_json(out, &json!({ "birds": eyes.iter().map(row).collect::<Vec<_>>() }));
        }
        for (name, eye) in &eyes {
            let peaks: Vec<String> =
                eye.cones.iter().map(|cone| format!("{} {:.0}", cone.name, cone.peak_nm)).collect();
            print(out, &format!("{name:<12}  {}: {} nm", title(eye), peaks.join(", ")))?;
        }
        Ok(())
    }
}

fn title(eye: &Eye) -> String {
    if eye.latin.is_empty() { eye.name.clone() } else { format!("{} ({})", eye.name, eye.latin) }
}

fn document(eye: &Eye) -> Value {
    let nm: Vec<f64> = (300..=700).map(f64::from).collect();
    let cone = |cone: &Cone| {
        json!({
            "name": cone.name,
            "peak_nm": cone.peak_nm,
            "abundance": cone.abundance,
            "source": cone.source,
            "sensitivity": nm.iter().map(|nm| cone.sensitivity.at(*nm)).collect::<Vec<_>>(),
        })
    };
    json!({
        "name": eye.name,
        "latin": eye.latin,
        "wavelength_nm": nm,
        "cones": eye.cones.iter().map(cone).collect::<Vec<_>>(),
        "double": eye.double.as_ref().map(cone),
        "weber": eye.weber,
        "weber_double": eye.weber_double,
        "source": eye.sources.join("; "),
    })
}
