//! What people and birds see of a reflectance, in numbers and as a colour on the screen.

use barbule::Result;
use barbule::open;
use barbule::spectrum::colour::{Illuminant, Observer, display};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::vision::{Catches, FalseColour, Light, View};

use super::Told;
use crate::state::Seer;

/// Wavelengths that birds see, nm: from, to and step.
const BIRDS_NM: [u32; 3] = [300, 700, 4];

/// Somebody who looks at reflectances in daylight.
#[derive(Debug, Clone)]
pub struct Viewer {
    eye: Option<Box<View>>,
    /// Which cones of a bird a screen's red, green and blue show.
    shown: [Vec<usize>; 3],
    at: Wavelengths,
}

/// What is seen of a reflectance.
#[derive(Debug, Clone, PartialEq)]
pub struct Sight {
    /// Linear sRGB as people see it; it may leave 0 to 1.
    pub linear_rgb: [f64; 3],
    /// sRGB as people see it.
    pub srgb: [u8; 3],
    /// What each cone of a bird catches over what it catches of white, from long to short wavelengths or as its eye has them.
    pub catches: Option<Catches>,
    /// sRGB that shows a bird's cones in the false colours that its pictures have.
    pub bird_srgb: Option<[u8; 3]>,
}

impl Viewer {
    /// People, or a bird.
    ///
    /// # Errors
    /// There is no such eye.
    pub fn new(seer: &Seer) -> Result<Self> {
        match seer {
            Seer::People => Ok(Self { eye: None, shown: Default::default(), at: Wavelengths::usual() }),
            Seer::Bird(name) => {
                let [from, to, step] = BIRDS_NM;
                let at: Vec<f64> = (from..=to).step_by(step as usize).map(f64::from).collect();
                let view = View::new(open::eye(name)?, Light::named("D65")?)?;
                let shown = shown(&view);
                Ok(Self { eye: Some(Box::new(view)), shown, at: Wavelengths::new(at)? })
            }
        }
    }

    /// The wavelengths at which reflectances are computed for them.
    #[must_use]
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.at
    }

    /// The names of a bird's cones, in the order of catches.
    #[must_use]
    pub fn cones(&self) -> Vec<&str> {
        let cones = self.eye.iter().flat_map(|view| &view.eye.cones);
        cones.map(|cone| cone.name.as_str()).collect()
    }

    /// What they see of a reflectance. Wavelengths that are few make a rough colour; a bird needs those that it sees.
    ///
    /// # Errors
    /// A bird sees much where the reflectance is not known.
    pub fn sees(&self, reflectance: &Spectrum) -> Result<Sight> {
        let linear_rgb = Observer::under(Illuminant::D65).linear_rgb(reflectance);
        let catches = self.eye.as_ref().map(|view| view.catches(reflectance)).transpose()?;
        let bird_srgb = catches.as_ref().map(|caught| self.false_colour(caught));
        Ok(Sight { linear_rgb, srgb: display(linear_rgb), catches, bird_srgb })
    }

    fn false_colour(&self, caught: &Catches) -> [u8; 3] {
        let mean = |cones: &Vec<usize>| {
            cones.iter().map(|cone| caught.cones[*cone]).sum::<f64>() / cones.len().max(1) as f64
        };
        display(self.shown.each_ref().map(mean))
    }

    /// How far a bird tells two reflectances apart; none for people.
    #[must_use]
    pub fn tells(&self, one: &Spectrum, other: &Spectrum) -> Option<Told> {
        let view = self.eye.as_ref()?;
        Some(match view.compare(&[one.clone(), other.clone()]) {
            Ok(found) => Told::Jnd { delta_s: found.delta_s[0][1], delta_l: found.delta_l[0][1] },
            Err((_, error)) => Told::Unknown(error.to_string()),
        })
    }
}

/// Which cones red, green and blue show, as pictures of this eye do unless told otherwise.
fn shown(view: &View) -> [Vec<usize>; 3] {
    let words = FalseColour::usual(&view.eye).words(&view.eye);
    let mut parts = words.split(',').map(|part| {
        let place = |name: &str| view.eye.cones.iter().position(|cone| cone.name == name);
        part.split('+').filter_map(place).collect()
    });
    std::array::from_fn(|_| parts.next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::spectrum::look::Look;

    fn reflectance(at: &Wavelengths) -> Spectrum {
        let green = |nm: &f64| 0.1 + 0.8 * (-(nm - 540.0).powi(2) / 2000.0).exp();
        Spectrum::new(at.clone(), at.iter().map(green).collect()).unwrap()
    }

    #[test]
    fn people_see_what_the_library_says() {
        let people = Viewer::new(&Seer::People).unwrap();
        let reflectance = reflectance(people.wavelengths());
        let seen = people.sees(&reflectance).unwrap();
        let colour = Look::of(&reflectance).colour.unwrap();
        assert_eq!((seen.linear_rgb, seen.srgb, seen.catches), (colour.linear_rgb, colour.srgb(), None));
        assert!(people.cones().is_empty());
    }

    #[test]
    fn birds_catch_white_wholly_and_need_the_ultraviolet() {
        let starling = Viewer::new(&Seer::named("bird:starling").unwrap()).unwrap();
        let at = starling.wavelengths().clone();
        let white = Spectrum::new(at.clone(), vec![1.0; at.len()]).unwrap();
        let catches = starling.sees(&white).unwrap().catches.unwrap();
        assert_eq!((catches.cones.len(), starling.cones().len()), (4, 4));
        assert!(catches.cones.iter().all(|caught| (caught - 1.0).abs() < 1e-12));
        assert_eq!(starling.sees(&white).unwrap().bird_srgb, Some([255; 3]));
        // What is green to people is caught by the middle cones, which are shown as green.
        let [red, green, blue] = starling.sees(&reflectance(&at)).unwrap().bird_srgb.unwrap();
        assert!(green > red && green > blue, "{red} {green} {blue}");
        let visible = reflectance(&Wavelengths::usual());
        assert!(starling.sees(&visible).unwrap_err().to_string().contains("nothing is invented outside"));
        assert!(Viewer::new(&Seer::Bird("dodo-of-mauritius".into())).is_err());
    }
}
