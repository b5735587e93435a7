//! `barbule lobes`: pictures of a material's BRDF, its parameters, its noise and its fits.

use std::io::Write;
use std::path::Path;

use barbule::brdf::FeatherMaterial;
use barbule::figures;
use barbule::io::store::Store;
use barbule::plot::Drawing;
use barbule::scattering::statistics::Statistics;
use barbule::{Error, Result};

use crate::common::Common;
use crate::figure::FigureArgs;
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::Provenance;

/// Most instances in one picture.
const MOST_INSTANCES: usize = 20;

/// Arguments of `barbule lobes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule lobes starling -o lobes.png --instances 3")]
#[command(mut_arg("output", |output| output.required(true)))]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    material: String,
    #[command(flatten)]
    figure: FigureArgs,
    /// Draw maps of m_eff, φ_eff − φ_i and F_eff over cosθ_i and cosφ_i
    #[arg(long, group = "what")]
    parameters: bool,
    /// Draw simulated and fitted U and V at 0° and 70°
    #[arg(long, group = "what")]
    fits: bool,
    /// Draw a single barbule's field over x_o for three φ_i and three wavelengths
    #[arg(long, group = "what")]
    fields: bool,
    /// Draw the noise: autocovariances, spectrum and some functions
    #[arg(long, group = "what")]
    noise: bool,
    /// Instances below the smooth lobes, and as many simulated beside synthesized ones [default: 3, synthesized only]
    #[arg(long, value_name = "N", conflicts_with = "what")]
    instances: Option<usize>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, _out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.figure.check_rigid(&self.common)?;
        let Some(path) = self.figure.path() else { return Err(Error::input("name the figure with -o")) };
        let instances = self.instances.unwrap_or(3);
        if instances > MOST_INSTANCES {
            return Err(Error::input(format!(
                "--instances {instances}: give at most {MOST_INSTANCES}, one row of the picture each"
            )));
        }
        let (material, hash) = materials::find(&self.material, &self.common)?;
        let title = self.figure.title(figures::title(&material));
        let (catalog, progress) = (materials::catalog(&self.common), Terminal::new(&self.common));
        let barbules = || materials::barbules(&material, &catalog, &progress, &self.common);
        let drawing = if self.parameters {
            figures::tiled(figures::parameters(&material)?, 3, &title)
        } else if self.noise {
            let barbules =
                barbules().inspect_err(|error| self.common.say(&format!("no single barbules: {error}"))).ok();
            figures::tiled(figures::noise(&material, barbules.as_ref())?, 2, &title)
        } else if self.fields {
            figures::tiled(figures::fields(&material, &barbules()?)?, 2, &title)
        } else if self.fits {
            let beside = Path::new(&self.material).with_extension("zarr");
            let statistics = if beside.is_dir() {
                stored(&material, &beside)?
            } else {
                figures::statistics_of_fits(&material, &barbules()?)?
            };
            figures::tiled(figures::fits(&material, &statistics), 2, &title)
        } else {
            let above = figures::hemispheres(&material, instances)?;
            let above = above.under(self.figure.title.as_deref().unwrap_or(""));
            match self.instances.filter(|count| *count > 0).map(|count| (count, barbules())) {
                Some((count, Ok(barbules))) => below(above, figures::instances(&material, count, &barbules)?),
                Some((_, Err(error))) => {
                    self.common.say(&format!("synthesized instances only: {error}"));
                    above
                }
                None => above,
            }
        };
        Provenance::new(&self.common)
            .with("material", &self.material)
            .with("material_hash", hash)
            .write_figure(path, &self.figure.page()?.place(drawing))
    }
}

/// The statistics of the store that a material was fitted to.
fn stored(material: &FeatherMaterial, beside: &Path) -> Result<Statistics> {
    let statistics = Store::open(beside)?.statistics()?;
    if statistics.axes != material.axes {
        return Err(Error::input(format!(
            "{}: has other wavelengths or directions than the material; fit the material from this store, or move it away",
            beside.display()
        )));
    }
    Ok(statistics)
}

/// One drawing below another.
fn below(above: Drawing, below: Drawing) -> Drawing {
    let mut page = Drawing::new(above.width.max(below.width), above.height + below.height);
    let height = above.height;
    page.place(above, [0.0, 0.0]);
    page.place(below, [0.0, height]);
    page
}
