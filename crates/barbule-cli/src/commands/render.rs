//! `barbule render`: a picture of a preset or a scene.

mod birds;
mod checkpoints;
mod flags;
mod job;
mod lamps;
mod noise;
mod parts;
mod presets;

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use barbule::characterize::thinned;
use barbule::clock;
use barbule::io::{Folder, check_writable};
use barbule::open;
use barbule::picture::{
    Cleaner, Denoise, Quality, Set, bytes_needed, check_alpha, check_colours, check_kind, is_exr,
    part_bytes_needed,
};
use barbule::progress::Shard;
use barbule::render::film::check_size;
use barbule::render::planes::{Bands, Planes};
use barbule::render::run::{Ended, Goal, ROUND, TimeLimit};
use barbule::resolve::{foretell_files, read_files, read_named, resolve};
use barbule::scene::description::{
    Background, Bearing, Exposure, Foreseen, Motion, Moved, Named, ReadyScene, SceneDescription, Tone,
    ToneWord, USUAL_ARC_DEG, Under, ViewModel, WhiteBalance,
};
use barbule::scene::preset;
use barbule::{Error, Result, fields};

use self::checkpoints::Checkpoints;
use self::flags::Seer;
use self::job::{Job, Wardrobe};
use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::{materials, scene_arg, sets, shard};

/// Arguments of `barbule render`.
#[derive(Debug, clap::Args)]
#[command(after_help = presets::after_help())]
pub(crate) struct Args {
    #[arg(value_name = "PRESET|SPECIES:VARIANT|SCENE", help = scene_arg::HELP, required_unless_present = "list")]
    scene: Option<String>,
    /// Print the presets and what they show, and draw nothing
    #[arg(long, conflicts_with_all = ["scene", "output", "toml"])]
    list: bool,
    /// The picture: .png, .jpg, .webp or .exr
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["toml", "list"])]
    output: Option<PathBuf>,
    /// Print the scene as a file to start from, and draw nothing. With --json as JSON
    #[arg(long, conflicts_with = "output")]
    toml: bool,
    /// The scene by another of its models: peacock has film-2005 (as a picture of 2005 had it), film (thin films on every barbule) and
    /// barbule (simulated crystals)
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Another material than the scene's
    #[arg(long, value_name = "NAME|FILE|STRUCTURE", long_help = materials::HELP)]
    material: Option<String>,
    /// The lower sides of its barbules: default (the material's own where they are known, else keratin), keratin, or another material
    #[arg(long, value_name = "default|keratin|NAME|FILE|STRUCTURE")]
    under: Option<String>,
    /// Width and height in pixels [default: 1280x800]
    #[arg(long, value_name = "WxH", value_parser = flags::size)]
    size: Option<[u32; 2]>,
    /// Most samples per pixel [default: 16; 4096 with --noise or --time]
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// Samples and noise by a word: draft (8 samples), good (noise below 4 %) or final (below 1 %); --samples and --noise hold beside it
    #[arg(long, value_name = "draft|good|final", value_parser = flags::quality)]
    quality: Option<Quality>,
    /// Stop after this time, as in 30s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = flags::duration)]
    time: Option<Duration>,
    /// Stop where the noise is below this many percent of the brightness
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Azimuth and elevation of the key light, degrees
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true, value_parser = flags::light)]
    light: Option<Bearing>,
    /// Azimuth and elevation of the camera, degrees, and the width of the picture in mm
    #[arg(long, value_name = "AZ,EL[,MM]", allow_hyphen_values = true, value_parser = flags::view)]
    view: Option<flags::View>,
    /// Factor from radiance to the picture's values; auto: by what it shows, as bright as a grey card with highlights kept; auto-1.5: by 1.5
    /// stops darker; +1: by a stop brighter than the scene says
    #[arg(long, value_name = "X|auto|STOPS", allow_hyphen_values = true, value_parser = flags::exposure)]
    exposure: Option<flags::Exposed>,
    /// Take the noise away with Open Image Denoise, that of the system or that of a file; glints stay, and an EXR keeps what it was taken from
    #[arg(long, value_name = "LIBRARY", num_args = 0..=1, require_equals = true)]
    denoise: Option<Option<PathBuf>>,
    /// The curve from light to the screen: plain, or filmic with more contrast and highlights that turn white
    #[arg(long, value_name = "plain|filmic", value_parser = flags::tone)]
    tone: Option<ToneWord>,
    /// Which light looks white: none for daylight, auto for that of lamps and sky together, or a colour temperature in K
    #[arg(long, value_name = "none|auto|K", value_parser = flags::white_balance)]
    white_balance: Option<WhiteBalance>,
    /// How barbs are seen: with their rami and barbules, as one fibre each, or both side by side
    #[arg(long, value_name = "substructure|fibre|both", value_parser = flags::view_model)]
    view_model: Option<ViewModel>,
    /// What is seen behind the feather: sky, none (the picture is cut out), a colour #rrggbb, or a .png, .exr or .hdr
    #[arg(long, value_name = "sky|none|#RRGGBB|FILE", value_parser = flags::background)]
    background: Option<Background>,
    /// Who sees the picture: human, a bird in false colours (as `barbule birds` lists it), or a file of what channels answer to light
    #[arg(long, value_name = "human|bird:NAME|FILE", default_value = HUMAN, value_parser = flags::sensor)]
    sensor: Seer,
    /// With --sensor bird:NAME: the cones that red, green and blue show, each the mean of one or several [default: L+UV,M,S+UV]
    #[arg(long, value_name = "R,G,B")]
    false_colour: Option<String>,
    /// With --sensor bird:NAME: also write what people see, from the same paths
    #[arg(long, value_name = "FILE")]
    human: Option<PathBuf>,
    /// EXR: planes of radiance about these wavelengths, nm
    #[arg(long, value_name = "SET")]
    spectral: Option<String>,
    /// EXR: R, G and B stay negative where colours lie outside sRGB
    #[arg(long)]
    keep_gamut: bool,
    /// This many pictures F-0000, F-0001 … in which the key light swings, or what --arc and --path say
    #[arg(long, value_name = "N", default_value_t = 1)]
    frames: u32,
    /// Only part i of n (i from 0), for several processes: of the tiles of a picture, kept beside it until the same command without --shard
    /// joins all parts; or of the frames of a sequence, whose exposure is then to be a factor
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = shard::parse)]
    shard: Option<Shard>,
    /// Frames: light, camera or feather swings over this arc about where it stands; 360 goes once round (repeatable)
    #[arg(long, value_name = "WHAT=DEG", value_parser = flags::arc)]
    arc: Vec<(Moved, Motion)>,
    /// Frames: light or camera goes from place to place; camera=AZ,EL,MM zooms too (repeatable)
    #[arg(long, value_name = "WHAT=AZ,EL/AZ,EL…", value_parser = flags::path)]
    path: Vec<(Moved, Motion)>,
    /// Write the picture as it is so far every 5 seconds, or so often
    #[arg(long, value_name = "TIME", value_parser = flags::preview, num_args = 0..=1, require_equals = true,
        default_missing_value = "5s")]
    preview: Option<Duration>,
    /// Go on from F.checkpoint if it is there, and keep one until the picture is done
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    common: Common,
}

/// The usual sensor.
const HUMAN: &str = "human";

/// Why nothing of a scene wears another material.
const NO_CLOTHES: &str =
    "the scene begins with no feather whose barbules wear a material; change its file, which --toml prints";

/// What of a scene takes less memory.
const SMALLER: &str =
    "smaller meshes, curves or pictures, or a smaller window or a coarser detail.level of a feather";

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        if self.list {
            return presets::print_list(&self.common, out);
        }
        let terminal = Terminal::new(&self.common).writing_nothing();
        let (description, is_changed) = self.description()?;
        drop(terminal);
        let size = self.size.or(description.size).unwrap_or([1280, 800]);
        check_size(size)?;
        if self.toml {
            return self.print_toml(description, is_changed, out);
        }
        let goal = self.goal()?;
        // What the flags ask for is refused before anything is read or made.
        self.check_moves()?;
        self.frame_descriptions(&description)?;
        let own = self.own_frames(description.exposure)?;
        let files: Vec<PathBuf> = own.clone().map(|frame| self.file(frame)).collect();
        let check = |flag: &str, file: &Path| {
            let fits = check_kind(file).and_then(|()| check_alpha(file, &description.background));
            fits.map_err(|e| e.at(flag)).and_then(|()| check_writable(file))
        };
        files.iter().try_for_each(|file| check("-o", file))?;
        own.clone()
            .filter_map(|frame| self.human_file(frame))
            .try_for_each(|file| check("--human", &file))?;
        let planes = self.planes()?;
        self.part_file(&self.file(0)).map_or(Ok(()), |file| check_writable(&file))?;
        let cleaner = self.cleaner()?;
        let mut description = description;
        self.read(&mut description, size, &planes)?;
        let (scene, wardrobe) = self.ready(description)?;
        let (wardrobe, planes) = (&wardrobe, &planes);
        let job = |file| Job { file, human: None, size, goal, wardrobe, planes, cleaner: None };
        if let (Some(shard), [file]) = (self.part(), &files[..]) {
            let report = self.draw_part(&scene, &job(file), shard)?;
            return if self.common.json { print_json(out, &[report]) } else { Ok(()) };
        }
        let set = self.set(&scene, &Terminal::new(&self.common).writing_nothing())?;
        let terminal = Terminal::new(&self.common).keeping_what_is_done();
        let checkpoints = Checkpoints::new(&self.common, self.resume);
        let (mut reports, mut all_done) = (Vec::new(), true);
        let mut exposure = scene.exposure;
        let frames = self.frames_of(&scene)?.into_iter().skip(own.start as usize);
        for (index, (frame, file)) in own.zip(frames.zip(&files)) {
            // A sequence that is exposed by a key is so by that of its first frame: it does not flicker.
            let frame = frame.changed(|scene| scene.exposure = exposure)?;
            let human = self.human_file(index);
            let job = Job { human: human.as_deref(), cleaner: cleaner.as_ref(), ..job(file) };
            let (report, used, ended) = self.picture(&frame, &set, &job, &checkpoints, &terminal)?;
            exposure = Exposure::Factor(used);
            reports.push(report);
            all_done &= ended == Ended::Done;
        }
        checkpoints.end(all_done, &files)?;
        if self.common.json {
            print_json(out, &reports)?;
        }
        Ok(())
    }

    /// Reads the files that the scene names, after refusing a picture or a scene that does not fit into memory.
    fn read(&self, scene: &mut SceneDescription, size: [u32; 2], planes: &Planes) -> Result<()> {
        let (folder, allowance) = (Folder(self.folder()), self.common.allowance());
        let what = format!("a picture of {}x{} pixels", size[0], size[1]);
        let needed = |size| match self.part() {
            Some(shard) => part_bytes_needed(size, planes, shard),
            None => bytes_needed(size, planes),
        };
        let (pixels, none) = (needed(size), needed([0; 2]));
        allowance.check(&what, pixels, "a smaller --size")?;
        let what = format!("{what} with the scene's objects and their pictures");
        // Most files say at their beginning what they hold; while they are read there are no pixels yet.
        let (foreseen, reading) = foretell_files(scene, &folder, self.common.seed);
        let before = scene.bytes(&foreseen) + pixels.max(none + reading);
        allowance.check(&what, before, SMALLER)?;
        read_files(scene, &folder, self.common.seed, &Terminal::new(&self.common))?;
        let read = scene.bytes(&Foreseen::new()) + pixels;
        allowance.check(&what, read, SMALLER)?;
        self.common.say_memory(&what, before.max(read));
        Ok(())
    }

    /// The scene with everything that it names read, and what its barbules are made of.
    fn ready(&self, description: SceneDescription) -> Result<(ReadyScene, Wardrobe)> {
        let mut wardrobe = Wardrobe::default();
        let mut dye = |name: &str| {
            let (material, hash) = materials::find(name, &self.common)?;
            if let Some(every) = thinned(&material) {
                self.common.say(&format!(
                    "the material {name} is thinned, a quick look: every {every} wavelengths and directions, {} instances",
                    material.info["campaign"]["instances"]
                ));
                wardrobe.thinned = wardrobe.thinned.max(Some(every));
            }
            wardrobe.names.push(name.to_owned());
            wardrobe.hashes.push(hash.clone());
            let worn = open::worn(&material, hash)?;
            self.check_range(name, &worn.brdf)?;
            Ok(worn)
        };
        let (folder, terminal) = (Folder(self.folder()), Terminal::new(&self.common));
        let scene = resolve(description, &folder, &mut dye, self.common.seed, &terminal)?;
        Ok((scene, wardrobe))
    }

    /// The scene with the changes that the flags ask for, and whether there are any.
    fn description(&self) -> Result<(SceneDescription, bool)> {
        let mut description = scene_arg::parse(&self.drawn()?, &self.common)?;
        let original = description.clone();
        self.say_undressed(&mut description);
        if let Some(material) = &self.material {
            description.set_material(material);
        }
        if let Some(under) = &self.under {
            description.set_under(&Under::named(under));
        }
        if let Some(bearing) = self.light {
            description.light.bearing = bearing;
            description.check().map_err(|e| e.at("--light"))?;
            if description.light.strength == 0.0 {
                self.common.idle(
                    "--light",
                    "the scene's key light has strength 0; its lamps are those of [[lights]]",
                );
            }
        }
        if let Some(flags::View { bearing, width_mm }) = self.view {
            description.camera.bearing = bearing;
            description.camera.position = None;
            description.camera.width_mm = width_mm.unwrap_or(description.camera.width_mm);
            description.uncover();
            description.check().map_err(|e| e.at("--view"))?;
        }
        if let (Some(view_model), Some(detail)) = (self.view_model, description.detail_mut()) {
            detail.view_model = view_model;
        }
        if let Some(exposure) = self.exposure {
            description.exposure = exposure.of(description.exposure);
            description.check().map_err(|e| e.at("--exposure"))?;
        }
        description.tone = self.tone.map_or(description.tone, Tone);
        description.white_balance = self.white_balance.unwrap_or(description.white_balance);
        if self.toml {
            description.size = self.size.or(description.size);
        }
        if let Some(background) = &self.background {
            description.background = background.clone();
            if self.is_preset() {
                description.leave_ground();
            }
            if let (Background::Picture(slot), false) = (&mut description.background, self.toml) {
                // It lies where the command runs, not where the scene does.
                read_named(
                    &mut Named::Backdrop(slot),
                    &Folder::default(),
                    self.common.seed,
                    &Terminal::new(&self.common),
                )
                .map_err(|e| e.at("--background"))?;
            }
        }
        if description.is_lit_from_behind() {
            self.common.say(&format!(
                "the key light stands at elevation {} degrees, behind the vane as the camera sees it: only the sky lights the barbules' upper sides",
                description.light.bearing.elevation_deg
            ));
        }
        let is_changed = description != original;
        Ok((description, is_changed))
    }

    /// Says which flags find no barbules or barbs that they would change.
    fn say_undressed(&self, description: &mut SceneDescription) {
        let is_dressed = description.dress_mut().is_some_and(|dress| dress.material().is_some());
        for (flag, is_given) in [("--material", self.material.is_some()), ("--under", self.under.is_some())] {
            if is_given && !is_dressed {
                self.common.idle(flag, NO_CLOTHES);
            }
        }
        if self.view_model.is_some() && description.detail_mut().is_none() {
            self.common.idle("--view-model", "the scene has no feather, and so no barbs");
        }
    }

    /// What is drawn.
    fn scene(&self) -> &str {
        self.scene.as_deref().unwrap_or_default()
    }

    /// The same, or the preset that shows it by the model that is asked for.
    fn drawn(&self) -> Result<String> {
        match &self.model {
            Some(model) => preset::by_model(self.scene(), model).map_err(|e| e.at("--model")),
            None => Ok(self.scene().to_owned()),
        }
    }

    /// Whether what is drawn is a preset, not a file of the user's.
    fn is_preset(&self) -> bool {
        let (scene, _) = self.scene().split_once(':').unwrap_or((self.scene(), ""));
        preset::names().any(|name| name == scene)
    }

    /// Where the files lie that a scene file names.
    fn folder(&self) -> PathBuf {
        Path::new(self.scene()).with_file_name("")
    }

    /// Prints the scene as a file, and says which flags it does not hold.
    fn print_toml(&self, scene: SceneDescription, is_changed: bool, out: &mut dyn Write) -> Result<()> {
        let of_drawing = [
            ("--samples", self.samples.is_some()),
            ("--quality", self.quality.is_some()),
            ("--time", self.time.is_some()),
            ("--noise", self.noise.is_some()),
            ("--denoise", self.denoise.is_some()),
            ("--false-colour", self.false_colour.is_some()),
            ("--human", self.human.is_some()),
            ("--sensor", !matches!(&self.sensor, Seer::Sensor(sensor) if sensor.is_human())),
            ("--spectral", self.spectral.is_some()),
            ("--keep-gamut", self.keep_gamut),
            ("--frames", self.frames != 1),
            ("--shard", self.shard.is_some()),
            ("--arc", !self.arc.is_empty()),
            ("--path", !self.path.is_empty()),
            ("--preview", self.preview.is_some()),
            ("--resume", self.resume),
        ];
        for (flag, _) in of_drawing.iter().filter(|(_, is_given)| *is_given) {
            self.common.idle(flag, "--toml prints a scene, which does not say it, and draws nothing");
        }
        let text = self.toml_text(scene, is_changed)?;
        match self.common.json {
            true => print_json(out, &fields::parse_toml(&text)?),
            false => print(out, text.trim_end()),
        }
    }

    /// A preset's own text, with its comments, or that of the scene that the command line describes, whose files are named as seen from
    /// here.
    fn toml_text(&self, mut scene: SceneDescription, is_changed: bool) -> Result<String> {
        if !is_changed && let Ok(text) = preset::toml(&self.drawn()?) {
            return Ok(text.to_owned());
        }
        let (folder, own) = (self.folder(), self.background.is_some());
        for (_, mut named) in scene.named_mut() {
            let is_given = own && matches!(named, Named::Backdrop(_));
            if let (Some(file), false) = (named.file(), is_given) {
                *file = folder.join(&*file).to_string_lossy().into_owned();
            }
        }
        scene.to_toml()
    }

    /// The frames that are asked for: one is the scene itself.
    fn frame_descriptions(&self, description: &SceneDescription) -> Result<Vec<SceneDescription>> {
        match self.moves()? {
            None => Ok(vec![description.clone()]),
            Some(moves) => description.frames(&moves, self.frames).map_err(|e| e.at("--frames")),
        }
    }

    /// The same of a scene that is ready.
    fn frames_of(&self, scene: &ReadyScene) -> Result<Vec<ReadyScene>> {
        match self.moves()? {
            None => Ok(vec![scene.clone()]),
            Some(moves) => scene.frames(&moves, self.frames).map_err(|e| e.at("--frames")),
        }
    }

    /// The frames that this process draws.
    fn own_frames(&self, exposure: Exposure) -> Result<Range<u32>> {
        let Some(shard) = self.shard else { return Ok(0..self.frames) };
        if self.frames == 1 {
            return Ok(0..1);
        }
        if exposure.factor().is_none() {
            return Err(Error::input(
                "--shard: a sequence is exposed as its first frame, which other processes do not see; give a factor by --exposure, as `exposure` of --json says it of the first frame",
            ));
        }
        let own = shard.range(self.frames as usize);
        // Not over the number of frames.
        Ok(own.start as u32..own.end as u32)
    }

    /// Refuses what is to be in two places at once, and says where nothing moves.
    fn check_moves(&self) -> Result<()> {
        for (index, (moved, _)) in self.path.iter().enumerate() {
            let mut others = self.path[..index].iter().chain(&self.arc);
            if others.any(|(other, _)| other == moved) {
                let word = moved.word();
                return Err(Error::input(format!(
                    "--path {word}: a path says where the {word} is in every frame; give one, and no --arc {word} beside it"
                )));
            }
        }
        if self.frames == 1 && !(self.arc.is_empty() && self.path.is_empty()) {
            self.common.idle("--arc or --path", "there is one frame; give --frames");
        }
        Ok(())
    }

    /// What moves from frame to frame; nothing where there is one.
    fn moves(&self) -> Result<Option<Vec<(Moved, Motion)>>> {
        if !(1..=9999).contains(&self.frames) {
            return Err(Error::input(format!("--frames {}: give 1 to 9999", self.frames)));
        }
        if self.frames == 1 {
            return Ok(None);
        }
        let mut moves: Vec<(Moved, Motion)> = self.arc.iter().chain(&self.path).cloned().collect();
        if moves.is_empty() {
            moves.push((Moved::Light, Motion::Arc(USUAL_ARC_DEG)));
        }
        Ok(Some(moves))
    }

    /// Who sees films, and what they keep beside what is seen, normals and depth.
    fn planes(&self) -> Result<Planes> {
        let sensor = self.seen_by()?;
        self.output.iter().try_for_each(|file| check_colours(file, &sensor).map_err(|e| e.at("-o")))?;
        let is_exr = self.output.as_deref().is_some_and(is_exr);
        let nm = match &self.spectral {
            Some(_) if !is_exr => {
                return Err(Error::input(
                    "--spectral: only an EXR has spectral planes; end the name with .exr",
                ));
            }
            Some(set) => sets::parse("--spectral", set)?,
            None => Vec::new(),
        };
        if self.keep_gamut && !is_exr {
            self.common
                .idle("--keep-gamut", "only an EXR keeps colours outside sRGB; end the name with .exr");
        }
        let of_screens = [("--tone", self.tone.is_some()), ("--white-balance", self.white_balance.is_some())];
        for (flag, _) in of_screens.iter().filter(|(_, is_given)| *is_given && is_exr) {
            self.common.idle(flag, "an EXR holds light as it is; write .png, .jpg or .webp");
        }
        let spectral = Bands::new(&nm, sensor.band()).map_err(|e| e.at("--spectral"))?;
        // A denoiser asks for albedo.
        Ok(Planes { sensor, compositing: is_exr || self.denoise.is_some(), spectral })
    }

    /// What takes the noise away, if anything is to.
    fn cleaner(&self) -> Result<Option<Cleaner>> {
        let denoise = match &self.denoise {
            None => Denoise::No,
            Some(None) => Denoise::BySystem,
            Some(Some(file)) => Denoise::By(file.clone()),
        };
        let is_human = matches!(&self.sensor, Seer::Sensor(sensor) if sensor.is_human());
        if denoise != Denoise::No && !is_human {
            return Err(Error::input(
                "--denoise: only pictures that people see are denoised; leave out --sensor",
            ));
        }
        // Noise is taken away when parts are joined.
        let denoise = if self.part().is_some() { Denoise::No } else { denoise };
        denoise.cleaner().map_err(|error| error.at("--denoise"))
    }

    fn goal(&self) -> Result<Goal> {
        if let Some(noise) = self.noise
            && !(noise > 0.0 && noise <= 100.0)
        {
            return Err(Error::input(format!("--noise {noise}: give percent, over 0 and up to 100")));
        }
        if self.time.is_some() && self.part().is_some() {
            return Err(Error::input(
                "--time: parts of a picture end by --samples or --noise, so that together they are the picture of one process; leave it out",
            ));
        }
        let open_ended = self.time.is_some() || self.noise.is_some();
        let percent = self.noise.map(|percent| percent / 100.0);
        let (samples, noise) = match self.quality {
            Some(quality) => quality.with(self.samples, percent),
            None => (self.samples.unwrap_or(if open_ended { 4096 } else { 16 }), percent),
        };
        if !(1..=1 << 24).contains(&samples) {
            return Err(Error::input(format!("--samples {samples}: give 1 to 16777216")));
        }
        let round = if self.preview.is_some() { 1 } else { ROUND };
        let time = self.time.map(|most| TimeLimit { most, clock: clock::system });
        Ok(Goal { samples, noise, time, round })
    }

    /// The file of a frame: `F.png`, or `F-0007.png` in a sequence.
    fn file(&self, frame: u32) -> PathBuf {
        self.numbered(self.output.clone().unwrap_or_default(), frame)
    }

    /// Likewise of what people see.
    fn human_file(&self, frame: u32) -> Option<PathBuf> {
        self.human.clone().map(|file| self.numbered(file, frame))
    }

    fn numbered(&self, output: PathBuf, frame: u32) -> PathBuf {
        if self.frames == 1 {
            return output;
        }
        let part = |s: Option<&std::ffi::OsStr>| s.unwrap_or_default().to_string_lossy().into_owned();
        let name = format!("{}-{frame:04}.{}", part(output.file_stem()), part(output.extension()));
        output.with_file_name(name)
    }

    /// What all frames share: the objects with their hierarchy, and the sky.
    fn set(&self, scene: &ReadyScene, terminal: &Terminal) -> Result<Set> {
        let begun = Instant::now();
        let set = Set::new(scene, self.common.seed, terminal)?;
        let counts = set.counts();
        self.common.explain(&format!(
            "{} barbs, {} barbules, {} primitives; ready in {:.2} s",
            counts.barbs,
            counts.barbules,
            set.primitives(),
            begun.elapsed().as_secs_f64()
        ));
        Ok(set)
    }
}
