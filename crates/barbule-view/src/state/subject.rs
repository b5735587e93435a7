//! What is open: a material, a grating, a species, a stack, other structures, or a scene.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use barbule::characterize::{Found, species_of};
use barbule::error::shortened;
use barbule::io::{
    GratingFile, InputKind, kind_of, read_flat_stack, read_grating, read_lattice, read_species_file,
};
use barbule::material::Library;
use barbule::open::{self, Opening};
use barbule::progress::Progress;
use barbule::scene::description::SceneDescription;
use barbule::scene::preset;
use barbule::stack::Stack;
use barbule::structure::{Lattice, SAMPLES, Side, SpeciesFile, Structure, species_name, species_names};
use barbule::{Error, Result};

use super::slider::Slider;
use super::species::SpeciesSizes;
use super::stack::StackSizes;
use super::view::Mode;

/// Something that is looked at, with the sizes that were moved in it. A copy costs little: what is large is shared.
#[derive(Debug, Clone)]
pub struct Subject {
    text: String,
    side: Side,
    what: What,
}

/// What is looked at.
#[derive(Debug, Clone)]
pub enum What {
    /// A material from a file, and the species that it was made of where it records one.
    Material(Arc<Found>, Option<Box<SpeciesSizes>>),
    /// A grating.
    Grating(Grating),
    /// A species, built in or of a file.
    Species(Box<SpeciesSizes>),
    /// Flat layers.
    Stack(Box<StackSizes>),
    /// A photonic crystal alone.
    Lattice(Box<Lattice>, Arc<Structure>),
    /// Sections as they are.
    Sections(Arc<Structure>),
    /// A scene.
    Scene(Arc<SceneDescription>),
}

/// A grating.
#[derive(Debug, Clone)]
pub enum Grating {
    /// Of a file.
    File(Arc<GratingFile>),
    /// A sample of heights that is built in, by its name; its powers are computed.
    Sample(&'static str),
}

impl Subject {
    /// Opens what people type: a material or grating by its file; a species, built in or of a file, and a variant of it; a stack, as
    /// text or of a file; sections and lattices by their files; a scene by its file; a preset that no species is called; a sample of
    /// heights. A preset's name is the preset, unless it is a species' own. ` (below)` behind a structure is its lower side. Built-in names come before files.
    ///
    /// # Errors
    /// None of these (the nearest is offered), or a file that is damaged.
    pub fn open(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Self> {
        let text = text.trim();
        let (upper, side) = match text.strip_suffix(Side::BELOW) {
            Some(upper) => (upper, Side::Below),
            None => (text, Side::Above),
        };
        let what = what(upper, opening, progress)?;
        let subject = Self { text: text.to_owned(), side, what };
        if side == Side::Below {
            // Refused here, rather than where it is first drawn.
            subject.structure()?;
        }
        Ok(subject)
    }

    /// As it was typed.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What it is.
    #[must_use]
    pub fn what(&self) -> &What {
        &self.what
    }

    /// Which side of a structure is lit.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// What it is, in a word or two.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self.what {
            What::Material(..) => "material",
            What::Grating(_) => "grating",
            What::Species(_) => "species",
            What::Stack(_) => "stack",
            What::Lattice(..) => "photonic crystal",
            What::Sections(_) => "sections",
            What::Scene(_) => "scene",
        }
    }

    /// What it is called where it is shown: with its variant and side, and the sizes that were moved.
    #[must_use]
    pub fn title(&self) -> String {
        let name = match &self.what {
            What::Species(sizes) => sizes.original().title(),
            What::Stack(sizes) => shortened(&sizes.text()),
            What::Material(..)
            | What::Grating(_)
            | What::Lattice(..)
            | What::Sections(_)
            | What::Scene(_) => shortened(self.text.strip_suffix(Side::BELOW).unwrap_or(&self.text)),
        };
        let own = match &self.what {
            What::Species(sizes) | What::Material(_, Some(sizes)) if !sizes.moved().is_empty() => ", changed",
            _ => "",
        };
        let side = if self.side == Side::Below { Side::BELOW } else { "" };
        format!("{name}{side}{own}")
    }

    /// The numbers that can be moved in it.
    #[must_use]
    pub fn sliders(&self) -> Vec<Slider> {
        match &self.what {
            What::Species(sizes) | What::Material(_, Some(sizes)) => sizes.sliders(),
            What::Stack(sizes) => sizes.sliders(),
            _ => Vec::new(),
        }
    }

    /// What was moved: values by the keys of their sliders.
    #[must_use]
    pub fn moved(&self) -> BTreeMap<String, f64> {
        match &self.what {
            What::Species(sizes) | What::Material(_, Some(sizes)) => sizes.moved().clone(),
            What::Stack(sizes) => sizes.moved().clone(),
            _ => BTreeMap::new(),
        }
    }

    /// Puts numbers in the place of those that were moved before; all others are as they were at first.
    ///
    /// # Errors
    /// There is no such number, one is outside its range, or they make no structure; then nothing has changed.
    pub fn put(&mut self, moved: &BTreeMap<String, f64>) -> Result<()> {
        match &mut self.what {
            What::Species(sizes) | What::Material(_, Some(sizes)) => sizes.put(moved),
            What::Stack(sizes) => sizes.put(moved),
            _ => match moved.keys().next() {
                None => Ok(()),
                Some(key) => Err(Error::input(format!(
                    "{} is a {} without sizes of its own, so '{}' cannot be moved; open a species or a stack",
                    shortened(&self.text),
                    self.kind(),
                    shortened(key)
                ))),
            },
        }
    }

    /// The structure as it is; none of gratings, scenes and materials that record no species.
    ///
    /// # Errors
    /// A stack over 1 mm thick, or a lower side that no light comes to.
    pub fn structure(&self) -> Result<Option<Structure>> {
        let upper = match &self.what {
            What::Species(sizes) | What::Material(_, Some(sizes)) => {
                Structure::Species(Box::new(sizes.model().clone()))
            }
            What::Stack(sizes) => sizes.structure()?,
            What::Lattice(_, structure) | What::Sections(structure) => structure.as_ref().clone(),
            What::Material(_, None) | What::Grating(_) | What::Scene(_) => return Ok(None),
        };
        match self.side {
            Side::Above => Ok(Some(upper)),
            Side::Below => upper.underside().map(Some).map_err(|error| error.at(shortened(&self.text))),
        }
    }

    /// The stack as it is, where it is one and its upper side is lit: films are computed exactly.
    #[must_use]
    pub fn stack(&self) -> Option<&Stack> {
        match &self.what {
            What::Stack(sizes) if self.side == Side::Above => Some(sizes.stack()),
            _ => None,
        }
    }

    /// Whether something was moved, so that a material that was made of it before is another's.
    #[must_use]
    pub fn is_moved(&self) -> bool {
        !self.moved().is_empty()
    }

    /// What it can be shown on.
    #[must_use]
    pub fn modes(&self) -> &'static [Mode] {
        match self.what {
            What::Grating(_) => &[Mode::Sphere, Mode::Snake],
            What::Scene(_) => &[Mode::Scene],
            What::Stack(_)
            | What::Lattice(..)
            | What::Sections(_)
            | What::Material(..)
            | What::Species(_) => &[Mode::Sphere, Mode::Vane, Mode::Feather, Mode::Scene],
        }
    }
}

/// What a text names that says nothing about sides.
fn what(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<What> {
    if text.is_empty() {
        return Err(Error::input(
            "nothing is named; give a species as starling:green, a stack as air/keratin:595/air, a preset, or a file",
        ));
    }
    let is_built_in = open::is_built_in(text);
    if let Some(found) = open::material_file(text)? {
        let species = species_of(&found.material, Library::builtin());
        let sizes = species.map(SpeciesSizes::of_model).transpose()?.map(Box::new);
        return Ok(What::Material(Arc::new(found), sizes));
    }
    let path = Path::new(text);
    let ends_with = |end: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(end));
    if !is_built_in && ends_with("grating") {
        return read_grating(path).map(|file| What::Grating(Grating::File(Arc::new(file))));
    }
    if let Some(sample) = SAMPLES.into_iter().find(|sample| *sample == text) {
        return Ok(What::Grating(Grating::Sample(sample)));
    }
    let name = text.split_once(':').map_or(text, |(name, _)| name);
    let is_preset = |name: &str| preset::names().any(|known| known == name);
    // Some presets are called as people also call a bird.
    if !species_names().any(|species| species == name) && is_preset(text) {
        return scene(text, opening, progress);
    }
    if is_built_in {
        let variant = text.split_once(':').map(|(_, variant)| variant);
        let file = SpeciesFile::builtin(species_name(name)?)?;
        let sizes = SpeciesSizes::of_file(file, variant, opening.media.library().clone())?;
        return Ok(What::Species(Box::new(sizes)));
    }
    if is_preset(name) {
        return scene(text, opening, progress);
    }
    if path.exists() {
        return of_path(text, path, opening, progress);
    }
    if let Some((file, variant)) = text.rsplit_once(':').filter(|(file, _)| Path::new(file).is_file()) {
        return species_file(Path::new(file), Some(variant), opening);
    }
    if text.contains('/') && !text.ends_with('/') && !ends_with("toml") && !ends_with("json") {
        let sizes = StackSizes::of_text(text, opening.media.library().clone())?;
        return Ok(What::Stack(Box::new(sizes)));
    }
    // Nothing of that name: the nearest of everything that there is, is offered.
    scene(text, opening, progress)
}

fn scene(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<What> {
    open::description(text, opening, progress).map(|scene| What::Scene(Arc::new(scene)))
}

/// What a file or folder is, by what is in it.
fn of_path(text: &str, path: &Path, opening: &Opening, progress: &dyn Progress) -> Result<What> {
    let media = opening.media.library();
    match kind_of(path)? {
        InputKind::Scene => scene(text, opening, progress),
        InputKind::Species => species_file(path, None, opening),
        InputKind::Stack => match read_flat_stack(path, media)? {
            Some(flat) => Ok(What::Stack(Box::new(StackSizes::of_flat(flat)?))),
            None => Err(Error::input("is no stack that can be read").in_file(path)),
        },
        InputKind::Lattice => {
            let lattice = read_lattice(path, media)?;
            let structure = open::structure(text, opening, progress)?;
            Ok(What::Lattice(Box::new(lattice), Arc::new(structure)))
        }
        // What is none of them is refused by who reads sections, with what it is.
        _ => open::structure(text, opening, progress).map(|found| What::Sections(Arc::new(found))),
    }
}

fn species_file(path: &Path, variant: Option<&str>, opening: &Opening) -> Result<What> {
    let (file, media) = read_species_file(path, opening.media.library())?;
    let sizes = SpeciesSizes::of_file(file, variant, media).map_err(|error| error.in_file(path))?;
    Ok(What::Species(Box::new(sizes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::structure::species_toml;

    fn opened(text: &str) -> Result<Subject> {
        Subject::open(text, &Opening::default(), &Unobserved)
    }

    fn kind(text: &str) -> &'static str {
        opened(text).unwrap_or_else(|error| panic!("{text}: {error}")).kind()
    }

    #[test]
    fn every_kind_of_thing_is_opened_by_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path.to_string_lossy().into_owned()
        };
        for (text, expected) in [
            ("starling", "species"),
            ("Sturnus vulgaris", "species"),
            ("rock-dove:purple", "species"),
            ("rock-dove (below)", "species"),
            ("air/6*(melanin:99/keratin:100)/air", "stack"),
            ("air/keratin", "stack"),
            ("starling-feather", "scene"),
            ("snake", "scene"),
            ("xenopeltis", "grating"),
        ] {
            assert_eq!(kind(text), expected, "{text}");
        }
        let species = file("mine.toml", species_toml("bronzewing").unwrap().as_bytes());
        assert_eq!(kind(&species), "species");
        assert_eq!(opened(&format!("{species}:pink")).unwrap().title(), "bronzewing:pink");
        assert_eq!(kind(&file("stack.toml", b"stack = 'air/keratin:595/air'")), "stack");
        assert_eq!(kind(&file("scene.toml", b"preset = 'starling'")), "scene");
        let lattice = "[lattice]\nperiod = 0.2\ncortex = 0.1\n[[lattice.rod]]\ncircles = [{ diameter = 0.1, medium = 'melanin' }]";
        assert_eq!(kind(&file("lattice.toml", lattice.as_bytes())), "photonic crystal");
        let section = Structure::flat("air/keratin:300/air").unwrap().instance(1, 0).unwrap();
        barbule::io::write_section(&folder.path().join("one.json"), &section).unwrap();
        assert_eq!(kind(&folder.path().join("one.json").to_string_lossy()), "sections");
        let bytes = barbule_birds_material();
        let material = opened(&file("a.barbule", &bytes)).unwrap();
        assert_eq!((material.kind(), material.sliders().len() > 5), ("material", true));
        assert_eq!(material.structure().unwrap().unwrap().name(), "starling:green");
    }

    /// The bytes of a material that ships.
    fn barbule_birds_material() -> Vec<u8> {
        let starling = Structure::builtin("starling:green").unwrap();
        let found = barbule::characterize::Catalog::default().shipped(&starling).unwrap().unwrap();
        found.bytes().unwrap()
    }

    #[test]
    fn what_names_nothing_is_refused_and_the_nearest_is_offered() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("a.txt");
        std::fs::write(&other, "x").unwrap();
        for (text, words) in [
            ("", "nothing is named"),
            ("starlign", "did you mean 'starling'?"),
            ("starling-feathers", "did you mean 'starling-feather'?"),
            ("starling:grean", "did you mean 'green'?"),
            ("air/keratine:5/air", "did you mean 'keratin'?"),
            ("air/keratin:x/air", "is not a thickness in nm"),
            ("nowhere.toml", "no such file"),
            ("nowhere.barbule", "nowhere.barbule"),
            ("nowhere.grating", "nowhere.grating"),
            (&other.to_string_lossy(), "is no structure"),
        ] {
            let refused = opened(text).unwrap_err();
            assert!(
                refused.to_string().contains(words) && !refused.to_string().contains('\n'),
                "{text}: {refused}"
            );
        }
    }

    #[test]
    fn sizes_are_moved_where_there_are_some() {
        let mut starling = opened("starling").unwrap();
        let moved = BTreeMap::from([("cortex_um".to_owned(), 0.2)]);
        starling.put(&moved).unwrap();
        assert_eq!((starling.moved(), starling.title()), (moved.clone(), "starling:green, changed".into()));
        let Structure::Species(model) = starling.structure().unwrap().unwrap() else { panic!() };
        assert_ne!(
            model,
            SpeciesFile::builtin("starling").unwrap().model(None, Library::builtin()).unwrap().into()
        );
        let mut scene = opened("starling-feather").unwrap();
        assert!(scene.put(&BTreeMap::new()).is_ok() && scene.structure().unwrap().is_none());
        let refused = scene.put(&moved).unwrap_err().to_string();
        assert!(
            refused.contains("a scene without sizes of its own, so 'cortex_um' cannot be moved"),
            "{refused}"
        );
    }

    #[test]
    fn lower_sides_are_structures_and_their_stacks_no_films() {
        let below = opened("rock-dove:forest (below)").unwrap();
        assert_eq!(below.title(), "rock-dove:forest (below)");
        assert_eq!(below.structure().unwrap().unwrap().name(), "rock-dove:forest (below)");
        let stack = "air/keratin:300/air";
        assert!(opened(stack).unwrap().stack().is_some());
        assert!(opened(&format!("{stack} (below)")).unwrap().stack().is_none());
        let refused = opened("air/keratin:300/melanin (below)").unwrap_err().to_string();
        assert!(refused.starts_with("air/keratin:300/melanin (below): "), "{refused}");
    }
}
