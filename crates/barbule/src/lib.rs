//! From the nanostructure of a bird's feather to its reflectance, its BRDF and its picture.
//!
//! ```text
//! structure ──► solve ──► scattering ──► brdf ──► bsdf ──► scene ──► render
//! (sections)   (waves)   (statistics)  (material)        (feather)  (picture)
//! ```
//!
//! From a species to a picture, thinned so that it takes a second:
//!
//! ```
//! use barbule::brdf::fit::FitOptions;
//! use barbule::characterize::{CampaignOptions, Catalog, Execution, characterize};
//! use barbule::io::Folder;
//! use barbule::{Picture, PictureOptions, SceneDescription, Structure, Unobserved, Worn, resolve};
//!
//! # fn main() -> barbule::Result<()> {
//! let options = CampaignOptions { thin: Some(10), ..CampaignOptions::default() };
//! let plan = options.plan(Structure::builtin("starling:pink")?)?;
//! let made = characterize(&plan, &FitOptions::default(), &Catalog::default(), &Execution::default(), &Unobserved)?;
//!
//! let scene = SceneDescription::named("starling")?;
//! let mut dye = |_: &str| Worn::new(&made.material, "pink".into());
//! let scene = resolve(scene, &Folder::default(), &mut dye, 1, &Unobserved)?;
//! let small = PictureOptions { size: [48, 30], samples: 4, ..PictureOptions::default() };
//! let picture = Picture::of(&scene, &small, &Unobserved)?;
//! picture.save(std::env::temp_dir().join("pink.png"))?;
//! # Ok(())
//! # }
//! ```
//!
//! What people type, files of their own among them, is opened by [`open`]; [`characterize()`] and [`Picture`] do the rest.
//!
//! This crate is the façade over five others, each of which compiles alone: what it re-exports from `barbule-base`,
//! `barbule-light`, `barbule-optics`, `barbule-appearance` and `barbule-trace` is all there is. Modules use each other along the arrows of
//! `ARCHITECTURE.md`, which the compiler holds between crates and a test inside them; [`io`] alone touches files.
//!
//! # Conventions
//!
//! Time runs as exp(−jωt), so absorbing media have Im n > 0. A barbule's frame is x across, y along, z out of the top
//! surface. Directions are unit vectors that point away from the surface,
//! ω = (cosθ sinφ, sinθ, cosθ cosφ). Lengths are µm in structures and simulations, wavelengths nm in vacuum, angles
//! radians; feather-scale lengths are mm. Magnetic fields are scaled by the vacuum impedance.

pub mod atlas;
pub mod campaign;
pub mod characterize;
pub mod clock;
pub mod confidence;
pub mod diffraction;
pub mod export;
#[cfg(feature = "figures")]
pub mod figures;
pub mod inverse;
pub mod io;
pub mod keys;
pub mod open;
pub mod picture;
#[cfg(feature = "figures")]
pub mod plot;
pub mod reading;
pub mod resolve;
pub mod traced;
#[cfg(all(feature = "figures", feature = "full-waves"))]
pub mod validate;

pub use barbule_appearance::{brdf, bsdf, render, scene};
pub use barbule_base::{error, fields, identity, math, progress};
pub use barbule_light::{film, fresnel, instrument, material, scattering, spectrum, stack, vision};
pub use barbule_optics::{solve, structure};
pub use barbule_trace::trace;

/// Re-exported, so that callers have the version that this crate takes:
///
/// ```
/// use barbule::Complex64;
///
/// // Absorbing media have Im n > 0. What melanin in air reflects along the normal:
/// let melanin = Complex64::new(1.7, 0.1);
/// let reflected = ((melanin - 1.0) / (melanin + 1.0)).norm_sqr();
/// assert!((reflected - 0.0685).abs() < 1e-4);
/// ```
pub use barbule_base::Complex64;

/// ```
/// use barbule::{Error, Structure};
///
/// // One sentence for people: where, what was found, what to do. Its kind says who can mend it.
/// let error: Error = Structure::builtin("sparrow").unwrap_err();
/// assert!(error.is_input() && error.to_string().contains("sparrow"));
/// ```
pub use barbule_base::Error;

/// ```
/// use barbule::{Structure, Wavelengths};
///
/// fn widths(names: &[&str]) -> barbule::Result<Vec<f64>> {
///     names.iter().map(|name| Ok(Structure::builtin(name)?.instance(1, 0)?.width_um)).collect()
/// }
/// assert_eq!(widths(&["starling", "mallard"])?.len(), 2);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use barbule_base::Result;

/// Directions and points in space, re-exported from `glam`:
///
/// ```
/// use barbule::DVec3;
///
/// // The direction that a mirror in the plane of the barbule sends light to.
/// let light = DVec3::new(0.3, 0.2, 1.0).normalize();
/// let mirrored = DVec3::new(-light.x, -light.y, light.z);
/// assert!((light + mirrored).normalize().abs_diff_eq(DVec3::Z, 1e-12));
/// ```
pub use glam::DVec3;

/// ```
/// use barbule::{Progress, Unobserved};
///
/// // For work that nobody watches or stops.
/// let nobody: &dyn Progress = &Unobserved;
/// assert!(!nobody.is_cancelled());
/// ```
pub use progress::Unobserved;

/// ```
/// use barbule::{Progress, Structure};
///
/// struct Patience(std::time::Instant);
///
/// impl Progress for Patience {
///     fn begin(&self, label: &str, total: u64) { eprintln!("{label}: {total} steps") }
///     fn advance(&self, _steps: u64) {}
///     fn is_cancelled(&self) -> bool { self.0.elapsed().as_secs() > 60 }
/// }
/// # let patience: Box<dyn Progress> = Box::new(Patience(std::time::Instant::now()));
/// # assert!(!patience.is_cancelled());
/// ```
pub use progress::Progress;

/// ```
/// use barbule::{Complex64, Material};
///
/// let glass = Material::constant(Complex64::new(1.5, 0.0))?;
/// assert_eq!(glass.index(550.0)?.re, 1.5);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use material::Material;

/// ```
/// use barbule::{Structure, Unobserved};
///
/// // Endlessly many random barbules; the same seed and number are the same one everywhere.
/// let mallard = Structure::builtin("mallard")?;
/// assert_eq!(mallard.name(), "mallard:lime");
/// assert_eq!(mallard.instance(1, 7)?, mallard.instance(1, 7)?);
/// assert!(Structure::builtin("malard").unwrap_err().to_string().contains("did you mean 'mallard'?"));
/// # Ok::<(), barbule::Error>(())
/// ```
pub use structure::Structure;

/// ```
/// use barbule::Structure;
///
/// let section = Structure::builtin("starling")?.instance(1, 0)?;
/// assert_eq!(section.width_um, 25.0);
/// assert_eq!(section.boundaries.len() + 1, section.media.len());
/// # Ok::<(), barbule::Error>(())
/// ```
pub use structure::Section;

/// ```
/// use barbule::material::Library;
/// use barbule::film::{Polarization, response};
/// use barbule::{Complex64, Stack};
///
/// // A quarter-wave layer whose index is the root of the glass's does not reflect.
/// let coated = Stack::parse("1/1.224744871391589:112.268/1.5", &Library::builtin())?;
/// assert!(response(&coated, 550.0, 0.0, Polarization::S)?.reflected < 1e-9);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use stack::Stack;

/// ```
/// let visible = barbule::Wavelengths::new([400.0, 550.0, 700.0])?;
/// assert_eq!(visible.range_nm(), (400.0, 700.0));
/// assert!(barbule::Wavelengths::new([550.0, 400.0]).is_err());
/// # Ok::<(), barbule::Error>(())
/// ```
pub use spectrum::Wavelengths;

/// ```
/// use barbule::scattering::far_field::{Polarization, Window};
/// use barbule::solve::surface::{Accuracy, far_field};
/// use barbule::{FarField, Illumination, Structure};
///
/// let section = Structure::flat("air/keratin:320/melanin")?.instance(1, 0)?;
/// let light = Illumination { wavelength_nm: 532.0, theta_i: 0.0, phi_i: 0.5, window: Window::Gaussian };
/// let far: FarField = far_field(&section, &light, 400, &Accuracy::default())?;
/// let intensity = far.intensity(Polarization::First).unwrap();
/// // The strongest light leaves in the mirror direction φ_o = −φ_i.
/// let strongest = (0..400).max_by(|&a, &b| intensity[a].total_cmp(&intensity[b])).unwrap();
/// assert!((far.azimuths.phi_o()[strongest] + 0.5).abs() < 0.02);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use scattering::far_field::FarField;

/// ```
/// use barbule::Illumination;
/// use barbule::scattering::far_field::Window;
///
/// let light = Illumination { wavelength_nm: 500.0, theta_i: 0.0, phi_i: 0.0, window: Window::PlaneWave };
/// assert!((light.wave_number_per_um() - std::f64::consts::TAU / 0.5).abs() < 1e-12);
/// ```
pub use scattering::far_field::Illumination;

/// ```
/// use barbule::spectrum::dense::DenseSpectrum;
/// use barbule::spectrum::sensor::{Band, Curve};
/// use barbule::render::planes::Planes;
/// use barbule::{PictureOptions, Sensor};
///
/// // A camera with a filter that passes ultraviolet light.
/// let passed = DenseSpectrum::new(|nm| (-(nm - 360.0) * (nm - 360.0) / 450.0).exp());
/// let channels = vec![Curve { name: "UV".into(), response: passed }];
/// let sensor = Sensor::new("filtered camera", Band::new(300, 420)?, channels)?;
/// let planes = Planes { sensor, ..Planes::default() };
/// let options = PictureOptions { planes, ..PictureOptions::default() };
/// assert_eq!(PictureOptions::default().planes.sensor, Sensor::human());
/// # assert_ne!(options, PictureOptions::default());
/// # Ok::<(), barbule::Error>(())
/// ```
pub use spectrum::sensor::Sensor;

/// ```
/// use barbule::characterize::Catalog;
/// use barbule::{FeatherMaterial, Structure};
///
/// let shipped = Catalog::default().shipped(&Structure::builtin("starling")?)?.unwrap();
/// let material: FeatherMaterial = shipped.material;
/// assert_eq!(material.axes.wavelengths_nm().len(), 51);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use brdf::FeatherMaterial;

/// ```
/// use barbule::brdf::Options;
/// use barbule::characterize::Catalog;
/// use barbule::{DVec3, FeatherBrdf, Structure};
///
/// let starling = Catalog::default().shipped(&Structure::builtin("starling")?)?.unwrap();
/// let brdf = FeatherBrdf::new(&starling.material, Options::default())?;
/// let (wi, wo) = (DVec3::new(0.3, 0.0, 1.0).normalize(), DVec3::new(-0.3, 0.0, 1.0).normalize());
/// // Of four wavelengths at once, sr⁻¹: the mean over barbules, and what barbule number 7 does.
/// let mean = brdf.eval([450.0, 500.0, 550.0, 600.0], wi, wo, None);
/// let seventh = brdf.eval([450.0, 500.0, 550.0, 600.0], wi, wo, Some(7));
/// assert!(mean[1] > 0.0 && mean != seventh);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use brdf::FeatherBrdf;

/// ```
/// use barbule::SceneDescription;
///
/// let closer = SceneDescription::parse("preset = \"starling\"\n[camera]\nwidth_mm = 1.7\n")?;
/// assert_eq!(closer.material(), Some("starling"));
/// # Ok::<(), barbule::Error>(())
/// ```
pub use scene::description::SceneDescription;

/// ```no_run
/// use barbule::brdf::fit::FitOptions;
/// use barbule::characterize::{CampaignOptions, Catalog, Execution};
/// use barbule::{Structure, Unobserved, characterize};
///
/// // A material of a tenth of the wavelengths and directions; `Catalog` may remember it in a folder.
/// let options = CampaignOptions { thin: Some(10), ..CampaignOptions::default() };
/// let plan = options.plan(Structure::flat("air/keratin:320/melanin")?)?;
/// let made = characterize(&plan, &FitOptions::default(), &Catalog::default(), &Execution::default(), &Unobserved)?;
/// println!("{} wavelengths", made.material.axes.wavelengths_nm().len());
/// # Ok::<(), barbule::Error>(())
/// ```
pub use characterize::characterize;

/// ```
/// use barbule::characterize::Catalog;
/// use barbule::io::Folder;
/// use barbule::{Picture, PictureOptions, SceneDescription, Structure, Unobserved, Worn, resolve};
///
/// let shipped = Catalog::default().shipped(&Structure::builtin("starling")?)?.unwrap();
/// let mut wears = |_: &str| Worn::new(&shipped.material, "starling:green".into());
/// let scene = resolve(SceneDescription::named("starling")?, &Folder::default(), &mut wears, 1, &Unobserved)?;
/// let options = PictureOptions { size: [16, 10], samples: 1, ..PictureOptions::default() };
/// let picture = Picture::of(&scene, &options, &Unobserved)?;
/// assert_eq!(picture.rgb().len(), 16 * 10 * 3);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use picture::{Picture, PictureOptions};

/// ```
/// use barbule::characterize::Catalog;
/// use barbule::io::Folder;
/// use barbule::{SceneDescription, Structure, Unobserved, Worn, resolve};
///
/// // A scene names its materials and files; `resolve` reads the files, and asks for each material by its name.
/// let mut asked = Vec::new();
/// let mut wears = |name: &str| {
///     asked.push(name.to_owned());
///     let shipped = Catalog::default().shipped(&Structure::builtin(name)?)?.unwrap();
///     Worn::new(&shipped.material, name.to_owned())
/// };
/// resolve(SceneDescription::named("starling")?, &Folder::default(), &mut wears, 1, &Unobserved)?;
/// assert_eq!(asked, ["starling"]);
/// # Ok::<(), barbule::Error>(())
/// ```
pub use resolve::{Worn, resolve};

#[cfg(doctest)]
#[doc = include_str!("../../../docs/guide/rust.md")]
struct GuideForRust;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/api.md")]
struct ThreeInterfaces;
