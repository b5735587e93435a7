//! Who sees a picture: sensors, and birds with people beside them.

use barbule::brdf::FeatherBrdf;
use barbule::error::shortened;
use barbule::material::KERATIN_CLEAR_FROM_NM;
use barbule::picture::{Developed, development};
use barbule::render::film::Film;
use barbule::scene::description::ReadyScene;
use barbule::spectrum::sensor::Sensor;
use barbule::vision::{FalseColour, Light, View, false_colour, human_beside};
use barbule::{Error, Result, identity};

use super::Args;
use super::flags::Seer;
use super::job::Job;
use crate::provenance::Provenance;

impl Args {
    /// The sensor of the film.
    ///
    /// # Errors
    /// Flags of birds without one, or a false colour of a cone that the bird has not.
    pub(super) fn seen_by(&self) -> Result<Sensor> {
        let eye = match &self.sensor {
            Seer::Bird(eye) => eye,
            Seer::Sensor(sensor) => {
                let given =
                    [("--false-colour", self.false_colour.is_some()), ("--human", self.human.is_some())];
                return match given.iter().find(|(_, is_given)| *is_given) {
                    None => Ok(sensor.clone()),
                    Some((flag, _)) => Err(Error::input(format!(
                        "{flag}: is of pictures that a bird sees; give --sensor bird:NAME too, as in bird:starling"
                    ))),
                };
            }
        };
        let colours = match &self.false_colour {
            None => FalseColour::usual(eye),
            Some(text) => FalseColour::parse(text, eye).map_err(|error| error.at("--false-colour"))?,
        };
        false_colour(eye, &colours).map_err(|error| error.at("--sensor"))
    }

    /// Refuses a material that is not known where a bird sees, and says where another sensor sees more than its tables hold. To the human
    /// eye it is the dim ends of the spectrum.
    ///
    /// # Errors
    /// As above.
    pub(super) fn check_range(&self, name: &str, brdf: &FeatherBrdf) -> Result<()> {
        let (low, high) = brdf.wavelength_range_nm();
        let shortest = match &self.sensor {
            Seer::Sensor(sensor) if sensor.is_human() => return Ok(()),
            Seer::Sensor(sensor) => {
                let band = sensor.band();
                if band.low_nm() < low || band.high_nm() > high {
                    self.common.say(&format!(
                        "the sensor '{}' sees {} to {} nm, but the material is known from {low} to {high} nm: its end values are held outside",
                        shortened(sensor.name()),
                        band.low_nm(),
                        band.high_nm()
                    ));
                }
                band.low_nm()
            }
            Seer::Bird(eye) => {
                let view = View::new((**eye).clone(), Light::named("D65")?)?;
                view.check(&format!("the material {}", shortened(name)), [low, high]).map_err(|error| {
                    error.followed_by(
                        "; `barbule characterize` makes one from 300 to 700 nm unless told otherwise",
                    )
                })?;
                view.needed_nm()[0]
            }
        };
        if shortest < KERATIN_CLEAR_FROM_NM {
            self.common.say_guessed();
        }
        Ok(())
    }

    /// Writes what people see of a finished film of a bird's, if that is asked for.
    pub(super) fn write_human(&self, description: &ReadyScene, job: &Job<'_>, film: &mut Film) -> Result<()> {
        let (Some(file), Seer::Bird(eye)) = (job.human, &self.sensor) else { return Ok(()) };
        film.show_by(human_beside(eye)?)?;
        let mut development = development(description, film)?;
        development.keeps_gamut = self.keep_gamut;
        let picture = Developed::new(file, film, &development, &description.object_names())?;
        let provenance = self
            .provenance(description, job, film, development.exposure)
            .with("shown", "what people see")
            .with("pixel_hash", picture.pixel_hash());
        picture.write(&provenance.notes())?;
        self.common.wrote(file, "what people see, from the same paths");
        Ok(())
    }

    /// With who saw it, unless people did.
    pub(super) fn say_sensor(&self, provenance: Provenance, sensor: &Sensor) -> Provenance {
        if sensor.is_human() {
            return provenance;
        }
        let provenance =
            provenance.with("sensor", sensor.name()).with("sensor_hash", identity::hash("sensor", sensor));
        match &self.sensor {
            Seer::Sensor(_) => provenance,
            Seer::Bird(eye) => {
                let usual = || FalseColour::usual(eye).words(eye);
                provenance.with("false_colour", self.false_colour.clone().unwrap_or_else(usual))
            }
        }
    }
}
