//! The birds that ship with Barbule: data only, embedded in the program.
//!
//! Everything of a bird lies in its folder `birds/NAME`, read through the same readers as users' files.

/// A bird: the texts of its folder.
#[derive(Debug, Clone, Copy)]
pub struct Bird {
    /// Its name, that of its folder.
    pub name: &'static str,
    /// Its Latin name and what else people call it, in lower case with - between the words.
    pub also: &'static [&'static str],
    /// Its title and what its numbers were held against.
    pub notes: &'static str,
    /// The species file of its barbules.
    pub species: Option<&'static str>,
    /// The scene of a close-up, the preset NAME.
    pub scene: Option<&'static str>,
    /// The name of the preset of a whole feather, NAME-feather.
    pub feather_name: &'static str,
    /// The scene of a whole feather.
    pub feather: Option<&'static str>,
    /// The scene of a feather without structural colour, the preset NAME.
    pub wing: Option<&'static str>,
    /// Sizes of the feather type NAME where they differ from the type `primary`.
    pub primary: Option<&'static str>,
    /// Further presets, names and scenes: necks, tails, whole birds.
    pub presets: &'static [(&'static str, &'static str)],
}

/// A name and the bytes of the file.
type Material = (&'static str, &'static [u8]);

/// Makes the lists of the names, the TOML files and the materials that folders have. Materials are apart from `BIRDS`, so that programs
/// which never ask for one do not hold them.
macro_rules! birds {
    ($($name:literal also $also:tt has [$($file:ident)*] presets [$($preset:literal)*] materials [$($material:literal)*])*) => {
        /// All birds, in the order in which they are listed to people.
        pub static BIRDS: &[Bird] = &[$(Bird {
            $($file: Some(include_str!(concat!("../birds/", $name, "/", stringify!($file), ".toml"))),)*
            ..Bird {
                name: $name,
                also: &$also,
                notes: include_str!(concat!("../birds/", $name, "/notes.md")),
                species: None,
                scene: None,
                feather_name: concat!($name, "-feather"),
                feather: None,
                wing: None,
                primary: None,
                presets: &[$(($preset, include_str!(concat!("../birds/", $name, "/", $preset, ".toml")))),*],
            }
        }),*];

        static MATERIALS: &[&[Material]] = &[$(&[$((
            concat!($name, "-", $material),
            include_bytes!(concat!("../birds/", $name, "/", $name, "-", $material, ".barbule")),
        )),*]),*];
    };
}

birds! {
    "rock-dove"
        also ["columba-livia", "rock-pigeon", "feral-pigeon", "common-pigeon", "pigeon", "dove"]
        has [species scene feather]
        presets ["rock-dove-neck" "dove-bird"]
        materials ["forest" "jade" "purple" "sea" "teal" "violet"]
    "starling"
        also ["sturnus-vulgaris", "european-starling", "common-starling"]
        has [species scene feather]
        presets ["starling-bird"]
        materials ["green"]
    "bronzewing"
        also ["phaps-chalcoptera", "common-bronzewing", "bronzewing-pigeon"]
        has [species scene feather]
        presets ["bronzewing-wing"]
        materials ["green" "red"]
    "hummingbird"
        also ["calypte-anna", "annas-hummingbird", "anna-hummingbird"]
        has [species scene feather]
        presets ["hummingbird-gorget"]
        materials ["anna"]
    "mallard"
        also ["anas-platyrhynchos", "mallard-duck", "wild-duck", "duck"]
        has [species scene feather]
        presets ["mallard-head"]
        materials ["lime" "lime-below"]
    "magpie"
        also ["pica-hudsonia", "black-billed-magpie", "american-magpie"]
        has [species scene feather]
        presets ["magpie-tail"]
        materials ["violet" "violet-below"]
    "peafowl"
        also ["pavo-cristatus", "indian-peafowl", "blue-peafowl", "common-peafowl", "peacock"]
        has [species scene feather]
        presets ["peacock" "peacock-film" "peacock-film-2005"]
        materials ["scaled-blue" "scaled-bronze" "scaled-green" "scaled-turquoise" "scaled-violet" "yellow" "yellow-below"]
    "osprey" also [] has [wing primary] presets [] materials []
    "turkey-vulture" also [] has [wing primary] presets [] materials []
    "rock-dove-wing" also [] has [wing primary] presets [] materials []
}

/// The shipped materials: name (`species-variant`, as in `starling-green`; `-below` for lower sides that differ from the
/// upper ones) and the bytes of the file, as `barbule characterize` writes it.
pub fn materials() -> impl Iterator<Item = (&'static str, &'static [u8])> + Clone {
    MATERIALS.iter().copied().flatten().copied()
}

/// The bytes of a shipped material.
#[must_use]
pub fn material(name: &str) -> Option<&'static [u8]> {
    materials().find(|(known, _)| *known == name).map(|(_, bytes)| bytes)
}

/// What an eye is made of, as a file: its name, what else it is called, and the text.
pub type Eye = (&'static str, &'static [&'static str], &'static str);

macro_rules! eyes {
    ($($name:literal also $also:tt)*) => {
        /// All eyes, in the order in which they are listed to people.
        pub static EYES: &[Eye] = &[$(($name, &$also, include_str!(concat!("../eyes/", $name, ".toml")))),*];
    };
}

eyes! {
    "average-uvs" also ["uvs", "avg.uv"]
    "average-vs" also ["vs", "avg.v"]
    "starling" also ["sturnus-vulgaris", "european-starling", "star"]
    "peafowl" also ["pavo-cristatus", "indian-peafowl", "peacock", "pfowl"]
    "blue-tit" also ["cyanistes-caeruleus", "eurasian-blue-tit", "bluetit"]
    "pigeon" also ["columba-livia", "rock-dove", "rock-pigeon"]
    "chicken" also ["gallus-gallus", "domestic-fowl"]
    "zebra-finch" also ["taeniopygia-guttata"]
}
