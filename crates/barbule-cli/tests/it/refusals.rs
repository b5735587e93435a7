//! What is refused, how it is said, and that nothing is left behind: bad arguments and bad files of every kind.
//!
//! Words that start with `@` are names in the test's own folder.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use barbule::io::encode_material;
use barbule::io::store::Store;
use barbule::scattering::statistics::Axes;
use barbule::spectrum::Wavelengths;

/// Command lines and a part of what must be said.
const LINES: &[(&str, &str)] = &[
    // The program.
    ("flim air/keratin:5/air", "'film'"),
    ("film", "STACK"),
    ("film air/keratin:5/air extra", "unexpected argument 'extra'"),
    ("film air/keratin:5/air --angels 3", "did you mean '--angles'"),
    ("render starling --brightness 2 -o @f.png", "unexpected argument '--brightness'; --help says"),
    ("--threads 0 film air/keratin:5/air", "--threads 0: give a number from 1 to 4096"),
    ("film air/keratin:5/air --seed -1", "'-1'"),
    ("film air/keratin:5/air --seed x", "invalid value 'x' for '--seed"),
    ("film air/keratin:5/air --threads 0", "--threads 0: give a number from 1 to 4096"),
    ("film air/keratin:5/air --threads 5000", "from 1 to 4096"),
    ("film air/keratin:5/air --threads many", "invalid value 'many'"),
    ("film air/keratin:5/air --memory lots", "unknown unit 'lots'"),
    ("film air/keratin:5/air --memory 5XB", "unknown unit 'xb'"),
    ("film air/keratin:5/air --memory 0", "write a size such as 8GiB"),
    ("film air/keratin:5/air --memory 1kB", "raise --memory"),
    ("film air/keratin:5/air --medium chitin", "write NAME=FILE"),
    ("film air/keratin:5/air --medium chitin=", "write NAME=FILE"),
    ("film air/keratin:5/air --medium chitin=@none.csv", "none.csv: no such file"),
    ("film air/keratin:5/air --medium chitin=@", "is a folder"),
    ("film air/keratin:5/air --medium 5x=@good.csv", "cannot name a medium"),
    (
        "spectrum air/keratin:5/air --medium air=@good.csv --wavelengths 500",
        "barbules are simulated in air, of index 1; let the first medium be the built-in air",
    ),
    ("film air/keratin:5/air --medium mix=@good.csv", "cannot name a medium"),
    // Sets of numbers.
    (
        "film air/keratin:5/air --wavelengths 299",
        "299 nm is outside 300 to 830 nm: the formula of keratin's index begins there",
    ),
    (
        "film air/keratin:5/air --wavelengths 831",
        "outside 300 to 830 nm: the tables of lights and of the eye end there",
    ),
    ("film air/keratin:5/air --wavelengths 400:700", "start:stop:step"),
    ("film air/keratin:5/air --wavelengths 400:700:0", "the step 0 does not lead"),
    ("film air/keratin:5/air --wavelengths 400:700:-5", "the step -5 does not lead from 400 to 700"),
    ("film air/keratin:5/air --wavelengths 400:700:0.0001", "over 100000 values"),
    ("film air/keratin:5/air --wavelengths 400,,500", "'' is not a number"),
    ("film air/keratin:5/air --wavelengths nan", "'nan' is not a number"),
    ("film air/keratin:5/air --angles 90", "90° is at or past grazing"),
    ("film air/keratin:5/air --angles=-95", "past grazing"),
    // Synonyms are named as they were typed.
    ("film air/keratin:5/air --angle 90", "--angle: 90° is at or past grazing"),
    ("film air/keratin:5/air --wavelength=299", "--wavelength: 299 nm is outside"),
    ("spectrum starling --angles 90", "--angles: 90° is at or past grazing"),
    ("far-field starling --wavelengths 299 --theta 0 --phi 0", "--wavelengths: 299 nm is outside"),
    ("film air/keratin:5/air --angles inf", "'inf' is not a number"),
    (
        "far-field starling --wavelength 550 --theta 0 --phi 0 --smooth 9",
        "an average over 9 µm: give 0.005 to 1 µm, or off",
    ),
    (
        "far-field hummingbird --wavelength 550 --theta 0 --phi 0 --smooth 0.05 --solver full-wave",
        "--smooth is of the fast simulation's formulas",
    ),
    ("far-field starling --wavelength 550 --theta 0 --phi 0 --window round", "'round'"),
    // Heights.
    ("diffract blazed --pitch 1 -o @f.png", "--pitch is of files, but blazed is a sample"),
    ("diffract @none.npy --pitch 1 -o @f.png", "none.npy: no such file"),
    ("diffract @good.csv --pitch 0 -o @f.png", "over 0 and up to 10000"),
    ("diffract blazed --wi 95,0 --wo 0,0", "--wi"),
    ("diffract blazed --orders 0 -o @f.grating", "--orders"),
    ("diffract blazed --obliquity cosine -o @f.png", "'cosine'"),
    ("diffract blazed --coherence 0 -o @f.png", "coherence, µm, is 0; give 0.5 to 1000"),
    // Stacks.
    ("film air", "write at least two media"),
    ("film keratin:5", "at least two media"),
    ("film air//air", "a medium is missing"),
    ("film air/keratin/air", "'keratin' needs a thickness in nm"),
    ("film air/keratine:5/air", "did you mean 'keratin'"),
    ("film air/keratin:-5/air", "the thickness -5 nm is not usable"),
    ("film air/keratin:1e300/air", "is not usable"),
    ("film air/keratin:x/air", "'x' is not a thickness"),
    ("film air/6*(keratin:5/air", "a bracket is not closed"),
    ("film air/keratin:5)/air", "never opened"),
    ("film air/0*(keratin:5)/air", "the count of a repetition"),
    ("film air/999999999*(keratin:5)/air", "the count of a repetition"),
    ("film air/99999*(keratin:5/air:5)/air", "over 100000 layers"),
    ("film air/mix(keratin,melanin):5/air", "a mixture is mix("),
    ("film air/mix(keratin,melanin,1.5):5/air", "outside 0 to 1"),
    ("film air/mix(keratin,melanin,0.5,cubic):5/air", "no mixing rule 'cubic'"),
    ("film air/1.5-0.2j:5/air", "has gain"),
    ("film melanin/keratin:5/air", "absorbs"),
    ("film @none.toml", "none.toml: no such file"),
    ("film @good.json", "is not a stack"),
    ("film air/keratin:5/air -o @", ".svg, .pdf or .png"),
    ("film air/keratin:5/air -o @no/f.svg", "does not exist"),
    ("film air/keratin:5/air -o @f.eps", ".svg, .pdf or .png"),
    ("film air/keratin:5/air --csv @no/f.csv", "does not exist"),
    ("film air/keratin:5/air --csv @f.svg -o @f.svg", "give two names"),
    ("film air/keratin:5/air --csv @f.svg", "end the name with .csv"),
    ("film air/keratin:5/air --csv @f.xlsx", "tables are written as CSV"),
    ("film air/keratin:5/air --csv @f.json", "end the name with .csv"),
    ("film air/keratin:5/air --csv -", "--csv -: name a file"),
    ("film air/keratin:5/air --csv @good.zarr/t.csv", "inside a campaign store"),
    ("film air/keratin:5/air --csv @good.csv/t.csv", "does not exist"),
    ("film air/keratin:5/air --medium q=@good.csv --csv @good.csv", "this command reads it"),
    ("film @large.toml", "over the limit of 4 MiB"),
    ("film air/q:5/air --medium q=@large.csv", "over the limit of 16 MiB"),
    ("film air/q:5/air --medium q=@large.yml", "over the limit of 4 MiB"),
    // Geometry.
    ("geometry", "STRUCTURE"),
    ("geometry starling", "say where to write"),
    ("geometry starling -o @f.svg --figure-size 85x60", "as in 85x60mm"),
    ("geometry starling -o @f.svg --figure-size 85xmm", "as in 85x60mm"),
    ("geometry starling -o @f.svg --figure-size 2x60mm", "2 by 60 mm; give 20 to 2000 mm"),
    ("geometry starling -o @f.svg --font-size 0", "give points from 3 to 72"),
    ("geometry starling -o @f.png --figure-dpi nan", "from 36 to 2400"),
    ("geometry starling -o @f.png --figure-size 2000x2000mm --figure-dpi 300", "is too large"),
    ("geometry starling --json --title x", "--output"),
    ("geometry starling -o @f.jpg", ".svg, .pdf, .png or .json"),
    ("geometry starling -o @no/f.svg", "does not exist"),
    ("geometry starlign -o @f.svg", "did you mean 'starling'"),
    ("geometry starling:grean -o @f.svg", "did you mean 'green'"),
    ("geometry starling: -o @f.svg", "no variant ''"),
    // Sides.
    ("far-field starling --wavelength 500 --theta 0 --phi 0 --side left", "possible values: above, below"),
    ("spectrum air/keratin --side below", "--side below: air/keratin: its lower side cannot be lit"),
    ("simulate mallard -o @f.zarr --side beneath", "possible values: above, below"),
    ("characterize starling --side", "possible values: above, below"),
    ("spectrum starling --mirror", "--mirror"),
    ("simulate @good.json -o @f.zarr --mirror --instances 5001", "give a number from 1 to 5000"),
    ("crystal starling", "made of layers"),
    ("crystal @none.toml", "no such file"),
    ("crystal mallard:gren", "did you mean 'green'"),
    ("crystal mallard --theta 90", "--theta: 90° is at or past grazing"),
    ("crystal mallard --phi -91", "--phi: -91° is at or past grazing"),
    ("crystal mallard --wavelength 0", "wavelength"),
    ("crystal mallard --solver magic", "possible values"),
    ("crystal mallard -o @f.png", "give --map or --field"),
    ("crystal mallard --map -o @f.txt", ".svg"),
    ("crystal mallard --map --solver fdtd -o @f.png", "multipole or rcwa"),
    ("crystal mallard --map --wavelengths 0 -o @f.png", "wavelength"),
    ("geometry mallard:gren -o @f.svg", "did you mean 'green'"),
    ("geometry starling --length 10 -o @f.svg", "--three-d"),
    ("geometry starling --three-d --length 0.1 -o @f.svg", "0.1 is not a length from 1 to 1000"),
    ("geometry starling --three-d --correlation 1,2,3 -o @f.svg", "one or two lengths"),
    ("geometry starling --three-d --correlation 0 -o @f.svg", "0.02 to 1000"),
    ("geometry starling --three-d --roughness=-1 -o @f.svg", "--roughness"),
    ("geometry starling --instance -1 -o @f.svg", "'-1'"),
    ("geometry @good.json --instance 1 -o @f.svg", "no instance 1"),
    ("geometry @none.json -o @f.svg", "no such file"),
    ("geometry @none.toml -o @f.svg", "no such file"),
    ("geometry @good.toml:puce -o @f.svg", "no variant 'puce'"),
    ("geometry @none/ -o @f.svg", "no such folder"),
    ("geometry @sections/ -o @f.svg", "one width"),
    ("geometry @empty/ -o @f.svg", "has no .json file"),
    ("geometry @good.csv -o @f.svg", "is no structure"),
    ("geometry @folder.json -o @f.svg", "is a folder"),
    ("geometry @good.json -o @good.json", "this command reads it"),
    ("geometry @sections -o @sections/c.json", "one of the sections"),
    ("geometry @good.json -o @good.zarr/u/f.svg", "inside a campaign store"),
    ("geometry @large.json -o @f.svg", "over the limit of 64 MiB"),
    ("geometry @many.json -o @f.svg", "over 4000000 commas and opening brackets"),
    ("geometry @large.toml -o @f.svg", "over the limit of 4 MiB"),
    // Species.
    ("species sparrow", "there is no species 'sparrow'"),
    ("species starling:puce", "no variant 'puce'"),
    ("species starling --toml -o @f.svg", "cannot be used with"),
    ("species -o @f.bmp", ".svg, .pdf or .png"),
    // Far fields.
    ("far-field starling", "--wavelength"),
    ("far-field starling --wavelength 500 --theta 0", "--phi"),
    ("far-field starling --wavelength 200 --theta 0 --phi 0", "outside 300 to 830"),
    ("far-field starling --wavelengths 400:700 --theta 0 --phi 0", "start:stop:step"),
    (
        "far-field starling --wavelength 520nm --theta 0 --phi 0",
        "--wavelength 520nm: '520nm' is not a number",
    ),
    ("far-field starling --wavelength 299 --theta 0 --phi 0", "--wavelength: 299 nm is outside"),
    ("far-field starling --wavelength 500 --theta 0,x --phi 0", "--theta 0,x: 'x' is not a number"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0:90:10", "--phi: 90° is at or past grazing"),
    (
        "far-field starling --wavelength 300:830:0.1 --theta 0 --phi 0 --memory 100MB",
        "5301 far fields on 400 azimuths need 159.7 MB of memory, but 100.0 MB are allowed",
    ),
    (
        "far-field starling --wavelength 300:830:0.1 --theta=-80:80:0.1 --phi=-80:80:0.1 --json",
        "raise --memory",
    ),
    (
        "far-field starling --wavelength 400:700:10 --theta 0 --phi 0,10 -o @f.svg",
        "--output: 62 far fields that differ in more than one",
    ),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 -o @f.bmp", ".svg, .pdf or .png"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 -o @f.svg --csv @f.svg", "give two names"),
    ("species @good.json --toml", "is no species, so it has no species file"),
    ("species @none.toml", "none.toml: no such file"),
    ("species @good.toml:puce", "no variant 'puce'"),
    ("species sturnus-vulgarus", "did you mean 'sturnus-vulgaris'? (known are rock-dove, starling"),
    ("species @inclusions.json", "no top boundary"),
    ("far-field starling --wavelength 500 --theta 90 --phi 0", "past grazing"),
    ("far-field starling --wavelength 500 --theta 0 --phi=-91", "past grazing"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 --azimuths 1", "from 2 to 100000"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 --azimuths 100001", "from 2 to 100000"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 --solver exact", "fast"),
    ("far-field starling --wavelength 500 --theta 0 --phi 0 --window hann", "gaussian"),
    ("far-field @good.json --wavelength 500 --theta 0 --phi 0 --instance 2", "no instance 2"),
    ("far-field @inclusions.json --wavelength 500 --theta 0 --phi 0", "no top boundary"),
    ("far-field nobody --wavelength 500 --theta 0 --phi 0", "nobody"),
    ("far-field short:x --wavelength 500 --theta 0 --phi 0", "short"),
    // Spectra.
    ("spectrum", "STRUCTURE"),
    ("spectrum starling --angle 95", "past grazing"),
    ("spectrum starling --plane beside", "across"),
    ("spectrum starling --collect cone:91", "cone:5"),
    ("spectrum starling --collect sphere", "hemisphere"),
    ("spectrum starling --polarization 0", "write mean, 1 or 2"),
    ("spectrum starling --instances 0", "from 1 to 10000"),
    ("spectrum starling --instances 10001", "from 1 to 10000"),
    ("spectrum starling --wavelengths 900", "outside 300 to 830"),
    ("spectrum starling --measured @none.csv", "no such file"),
    ("spectrum starling --measured @words.csv", "no lines of numbers"),
    ("spectrum starling -o @f.gif", ".svg, .pdf or .png"),
    ("spectrum starling --csv @no/f.csv", "does not exist"),
    // Campaigns.
    ("simulate starling", "--output"),
    ("simulate starling -o @no/s.zarr", "does not exist"),
    ("simulate starling -o @good.csv", "is not a campaign store"),
    ("simulate starling -o @empty/full", "is not a campaign store"),
    ("simulate starling -o @s.zarr --directions 20", "write NxM"),
    ("simulate starling -o @s.zarr --directions 1x9", "write NxM"),
    ("simulate starling -o @s.zarr --directions 201x9", "write NxM"),
    ("simulate starling -o @s.zarr --instances 0", "from 1 to 10000"),
    ("simulate starling -o @s.zarr --tilt 31", "degrees from 0 to 30"),
    ("simulate starling -o @s.zarr --tilt=-1", "degrees from 0 to 30"),
    ("simulate starling -o @s.zarr --tilt nan", "degrees from 0 to 30"),
    ("simulate starling -o @s.zarr --thin 21", "from 1 to 20"),
    ("simulate starling -o @s.zarr --shard 2/2", "0 <= i < n"),
    ("simulate starling -o @s.zarr --shard -1/2", "0 <= i < n"),
    ("simulate starling -o @s.zarr --shard 0/0", "0 <= i < n"),
    ("simulate starling -o @s.zarr --shard 1", "0 <= i < n"),
    ("simulate starling -o @s.zarr --shard 1/2/3", "0 <= i < n"),
    ("simulate starling -o @s.zarr --shard 0/100001", "at most 100000 parts"),
    ("simulate starling -o @s.zarr --simd mmx", "mmx"),
    ("simulate starling -o @s.zarr --keep-fields 401", "does not simulate"),
    ("simulate starling -o @s.zarr --keep-fields x", "not a number"),
    ("simulate starling -o @s.zarr --memory 1MB", "raise --memory"),
    ("simulate magpie:vilet -o @s.zarr", "did you mean 'violet'"),
    ("simulate starling -o @good.zarr", "made with other parameters"),
    ("simulate @none.zarr --status", "no such store"),
    ("simulate @good.csv --status", "is not a campaign store"),
    ("simulate @ --status", "is not a campaign store"),
    ("fit @none.zarr -o @f.barbule", "no such store"),
    ("fit @good.zarr", "--output"),
    ("fit @good.zarr -o @f.barbule", "4 of 4 units are missing or damaged"),
    ("fit @good.zarr -o @", "is a folder"),
    ("fit @good.zarr -o -", "outputs are files and have names"),
    ("fit @good.zarr -o @good.zarr/zarr.json", "inside a campaign store"),
    ("fit @good.zarr -o @good.zarr/m.barbule", "inside a campaign store"),
    ("simulate starling -o @good.zarr/inner.zarr", "inside a campaign store"),
    ("simulate starling -o .", "as in S.zarr"),
    ("simulate starling -o @empty/..", "as in S.zarr"),
    ("fit @good.zarr -o @f.barbule --sigma 0", "--sigma: sigma is 0, but must lie between 0.002 and 0.25"),
    ("fit @good.zarr -o @f.barbule --fit best", "marginal"),
    ("fit @good.zarr -o @f.barbule --lobe three", "ggx"),
    ("characterize starling -o @no/f.barbule", "does not exist"),
    (
        "characterize starling -o @f.barbule --sigma 1",
        "--sigma: sigma is 1, but must lie between 0.002 and 0.25",
    ),
    ("characterize starling -o @f.barbule --sigma 0.3", "--sigma: sigma is 0.3, but must lie between"),
    ("fit @good.zarr -o @f.barbule --sigma 0.001", "--sigma: sigma is 0.001, but must lie between"),
    ("characterize starling -o @f.barbule --wavelengths 300:830:1", "531 values, over the limit of 512"),
    (
        "characterize starling -o @f.barbule --wavelengths 400:500:1 --directions 200x200",
        "4040000 nodes, over the limit of 4000000",
    ),
    ("characterize starling -o @f.barbule --keep-store @none", "no such folder"),
    ("characterize starling -o @f.barbule --memory 1MB", "raise --memory"),
    ("characterize starling --cache @good.csv", "cannot be made"),
    ("cache --cache @good.csv", "a cache is a folder"),
    ("cache mallard", "unexpected argument"),
    // Lobes.
    ("lobes starling", "give -o FIG for the figure, or --json"),
    ("lobes starling -o @f.doc", ".svg, .pdf or .png"),
    ("lobes starling --parameters --fits -o @f.svg", "cannot be used with"),
    ("lobes starling --instances 1000 -o @f.svg", "give at most"),
    ("lobes @none.barbule -o @f.svg", "no such file"),
    ("lobes nobody -o @f.svg", "nobody"),
    // Pictures.
    ("render starling", "--output"),
    ("render starling -o @f.bmp", "written as .png, .jpg, .webp or .exr"),
    ("render starling -o @no/f.png", "does not exist"),
    ("render starlign -o @f.png", "did you mean 'starling'"),
    ("render starling:puce -o @f.png", "no variant 'puce'"),
    ("render starling -o @f.png --size 100", "as in 1280x800"),
    ("render starling -o @f.png --size 0x5", "0"),
    ("render starling -o @f.png --size 999999x999999", "999999"),
    (
        "render mallard -o @f.png --size 16384x16384 --samples 1 --memory 1GB",
        "needs 71430 MB of memory, but 1000 MB are allowed",
    ),
    ("render mallard -o @f.exr --size 1000x1000 --memory 100MB", "raise --memory, or give a smaller --size"),
    ("render @large.toml -o @f.png", "over the limit of 4 MiB"),
    ("render starling -o @good.zarr/f.png", "inside a campaign store"),
    ("render starling -o @f.png --samples 0", "give 1 to 16777216"),
    ("render starling -o @f.png --time soon", "30s, 5m or 1h"),
    ("render starling -o @f.png --time=-3s", "30s, 5m or 1h"),
    ("render starling -o @f.png --noise 0", "over 0 and up to 100"),
    ("render starling -o @f.png --noise nan", "over 0 and up to 100"),
    ("render starling -o @f.png --light 10", "azimuth and elevation"),
    ("render starling -o @f.png --light 10,100", "--light: light.elevation_deg is 100, outside -90 to 90"),
    ("render starling -o @f.png --view 1,2,3,4", "give azimuth, elevation"),
    ("render starling -o @f.png --view 1,2,-3", "--view: camera.width_mm is -3, outside 0.05 to 2000"),
    ("render starling -o @f.png --frames 0", "give 1 to 9999"),
    ("render starling -o @f.png --frames 2 --arc sun=3", "what moves is light, camera or feather"),
    ("render starling -o @f.png --frames 2 --path light=1,2/3,99", "light.elevation_deg is 99"),
    ("render starling -o @f.png --exposure bright", "give a factor from 0.000001 to 1000000, or auto"),
    ("render starling -o @f.png --background @none.png", "no such file"),
    (
        "render starling -o @f.png --background grey",
        "'grey' is no background; give sky, none, a colour as in #808080, or a .png or .exr",
    ),
    ("render starling -o @f.png --background skye", "did you mean 'sky'?"),
    ("render starling -o @f.png --spectral 500", "end the name with .exr"),
    ("render starling -o @f.exr --spectral 500,499", "must rise by 1 nm"),
    ("render starling -o @f.png --material @none.barbule", "no such file"),
    ("render starling -o @f.png --material sparrow", "sparrow"),
    ("render @none.toml -o @f.png", "no such file"),
    ("completions fishbowl", "fishbowl"),
    ("man rendre", "did you mean 'render'?; barbule man --list names all pages"),
    ("man bench sing", "'bench sing': no such command"),
];

/// A file of a kind with one change, and a part of what must be said of it.
type Change = (&'static str, &'static str, &'static str);

const SECTION: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a",
 "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}, {"x": [-1, 0, 1], "z": [-1, -1, -1]}],
 "media": ["air", "keratin", "melanin"],
 "inclusions": [{"circle": {"x": 0.0, "z": -0.5, "radius": 0.2}, "medium": "melanin"}]}"#;

/// Read by `geometry`.
const SECTIONS: &[Change] = &[
    ("{\"barbule\": 1", "[{\"barbule\": 1", "is not JSON"),
    ("\"barbule\": 1", "\"barbule\": 2", "reads format 1 only"),
    ("\"barbule\": 1, ", "", "the format's version"),
    ("\"um\"", "\"nm\"", "must be 'um'"),
    ("\"units\": \"um\", ", "", "units is missing"),
    ("\"width\": 2.0", "\"width\": -2.0", "width is -2"),
    ("\"width\": 2.0", "\"width\": 3.0", "boundaries[0] spans 2"),
    ("\"width\": 2.0", "\"widht\": 2.0", "did you mean 'width'"),
    ("\"width\": 2.0", "\"width\": \"2\"", "width"),
    ("\"x\": [-1, 0, 1], ", "", "boundaries[0]"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, 0]", "x has 3 values and z 2"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, NaN, 0]", "JSON has no NaN"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, 1e400, 0]", "is not JSON"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, \"a\", 0]", "z[1]"),
    ("\"z\": [0, 0, 0]", "\"z\": [0, -2, 0]", "crosses boundaries[0]"),
    ("\"z\": [0, 0, 0]", "\"z\": [-3, -3, -3]", "from the top down"),
    ("\"x\": [-1, 0, 1]", "\"x\": [-1, 1, 0]", "x must increase"),
    ("\"x\": [-1, 0, 1]", "\"x\": [-1, 0, 5000]", "outside -1000 to 1000"),
    ("[\"air\", \"keratin\", \"melanin\"]", "[\"air\", \"keratin\"]", "3 in all"),
    ("[\"air\", \"keratin\"", "[\"air\", \"keratine\"", "did you mean 'keratin'"),
    ("[\"air\", \"keratin\"", "[\"air\", {\"index\": [1.5]}", "an index is [n, k]"),
    ("[\"air\", \"keratin\"", "[\"air\", {\"index\": [1.5, -1]}", "gain"),
    ("[\"air\", \"keratin\"", "[\"air\", {\"mix\": [\"air\"], \"x\": [0], \"fraction\": [0]}", "two media"),
    (
        "[\"air\", \"keratin\"",
        "[\"air\", {\"mix\": [\"air\", \"keratin\"], \"x\": [0], \"fraction\": [2]}",
        "outside 0 to 1",
    ),
    ("\"radius\": 0.2", "\"radius\": 0", "circle.radius is 0"),
    ("\"radius\": 0.2", "\"radius\": 0.7", "crosses or touches boundaries[1]"),
    (", \"medium\": \"melanin\"", "", "the medium inside"),
    (
        "\"circle\": {\"x\": 0.0, \"z\": -0.5, \"radius\": 0.2}",
        "\"x\": [0, 1], \"z\": [0, 1]",
        "fewer than 3",
    ),
    ("\"name\": \"a\"", "\"name\": \"a\", \"materials\": {\"chitin\": \"no.csv\"}", "no such file"),
    ("\"name\": \"a\"", "\"name\": \"a\", \"lattice\": {}", "lattice.rod is missing"),
];

/// Changes of the starling's species file, read by `geometry`.
const SPECIES: &[Change] = &[
    ("barbule = 1", "barbule = 7", "reads format 1 only"),
    ("barbule = 1", "barbule == 1", "is not TOML"),
    ("name = \"starling\"", "nmae = \"starling\"", "did you mean 'name'"),
    ("generator = \"starling\"", "generator = \"starlign\"", "did you mean 'starling'"),
    ("default = \"green\"", "default = \"grene\"", "did you mean 'green'"),
    ("width_um = 25.0", "width_um = 0.0", "outside 1 to 200"),
    ("width_um = 25.0", "width_um = 25000", "outside 1 to 200; did you mean 25 (25000 nm)?"),
    (
        "cortex_um = 0.300",
        "cortex_um = 300",
        "variants[0].cortex_um is 300, outside 0.001 to 10; did you mean 0.3 (300 nm)?",
    ),
    (
        "[parameters]",
        "[parameters]\ncortex_um = 0.2",
        "no effect on variant 'aqua', which gives cortex_um too",
    ),
    ("cortex_um = 0.300\n", "", "variants[0].cortex_um is missing"),
    ("width_um = 25.0", "width_um = nan", "not a finite number"),
    ("width_um = 25.0", "width_um = \"25\"", "the text '25'"),
    ("width_um = 25.0\n", "", "width_um is missing"),
    ("width_um = 25.0", "widht_um = 25.0", "did you mean 'width_um'"),
    ("core_fraction_low = 0.3", "core_fraction_low = 0.8", "swap them"),
    ("point_spacing_um = 0.03", "point_spacing_um = 1e-9", "outside 0.005 to 1"),
    ("thickness_um = 4.0", "thickness_um = 0.5", "too little room"),
    ("[parameters]", "[lattice]\n[parameters]", "a lattice alone"),
    ("name = \"aqua\"\n", "", "variants[0].name is missing"),
    ("name = \"aqua\"", "name = \"green\"", "a second time"),
];

const STACK: &str = "entry = \"air\"\nexit = \"keratin\"\n\
    layers = [{ medium = \"keratin\", thickness_nm = 5 }, { repeat = 2, layers = [{ medium = \"air\", thickness_nm = 9 }] }]\n";

/// Read by `film`.
const STACKS: &[Change] = &[
    ("entry = \"air\"\n", "", "give either stack"),
    ("entry", "stack = \"air/keratin\"\nentry", "and not both"),
    ("exit", "exti", "unknown field `exti`"),
    ("thickness_nm = 5", "thickness_nm = -5", "the thickness -5 nm"),
    ("thickness_nm = 5", "thickness_nm = nan", "the thickness NaN nm"),
    ("thickness_nm = 5", "thickness_nm = \"5\"", "invalid type"),
    ("repeat = 2", "repeat = 0", "a count of 1 or more"),
    ("repeat = 2", "repeat = 99999999", "over 100000 layers"),
    ("repeat = 2, ", "", "or repeat and layers"),
    ("{ medium = \"keratin\"", "{ medium = \"kreatin\"", "did you mean 'keratin'"),
    ("entry", "materials = { glass = \"no.csv\" }\nentry", "no such file"),
    ("entry", "materials = { glass = [1.5] }\nentry", "the name of a file or an index [n, k]"),
    ("entry", "[[[", "is not a stack in TOML"),
];

/// Tables of a medium, read by `film --medium`.
const TABLES: &[(&str, &str, &str)] = &[
    ("csv", "", "no lines of numbers"),
    ("csv", "400,1.5,0\n500,x,0", "line 2, column 2: 'x'"),
    ("csv", "400,1.5,0\n500,1.5", "but line 1 has 3"),
    ("csv", "400,1.5,0,7", "has over 3 columns"),
    ("csv", "500,1.5,0\n400,1.5,0", "wavelengths rise"),
    ("csv", "0.4,1.5,0\n0.5,1.5,0", "look like micrometres"),
    ("csv", "400,1.5,-1", "has gain"),
    ("csv", "400,nan,0", "not a finite number"),
    ("csv", "400,1.5,0\n401,1.5,0", "outside the table"),
    ("csv", "\u{0}\u{1}", "no lines of numbers"),
    ("yml", "DATA: [", "is not YAML"),
    ("yml", "a: 1", "no list DATA"),
    ("yml", "DATA: []", "DATA is empty"),
    ("yml", "DATA:\n - {type: formula 1}\n", "tabulate the formula"),
    ("yml", "DATA:\n - {type: tabulated nk, data: \"0.4 1.5\"}\n", "is not 3 numbers"),
    ("yml", "a: &x 1\nDATA: *x\n", "uses YAML aliases"),
];

const SCENE: &str =
    "preset = \"starling\"\nexposure = 0.5\nsky = 0.7\n[light]\nelevation = 60.0\n[camera]\nwidth_mm = 4.4\n";

/// Read by `render`.
const SCENES: &[Change] = &[
    ("preset = \"starling\"\n", "", "preset"),
    ("\"starling\"", "\"starlign\"", "did you mean 'starling'"),
    ("exposure = 0.5", "exposre = 0.5", "did you mean 'exposure'"),
    ("exposure = 0.5", "exposure = nan", "exposure"),
    ("exposure = 0.5", "exposure = \"a\"", "exposure is 'a'; give a number or \"auto\""),
    ("width_mm = 4.4", "width = 4.4", "unknown key 'width', did you mean 'width_mm'?"),
    (
        "sky = 0.7",
        "[surfaces.h]\ntype = \"hair\"\nscale_tilt_deg = 20.5",
        "surfaces.h.scale_tilt_deg is 20.5, outside -20 to 20",
    ),
    ("sky = 0.7", "background = \"nothing\"", "give \"sky\", \"none\", or the table [background]"),
    ("sky = 0.7", "background = {colour = [1, 2, 3]}", "background.colour: give three numbers"),
    ("sky = 0.7", "background = {file = \"no.png\"}", "no such file"),
    ("sky = 0.7", "background = {file = \"good.csv\"}", "read from .png, .exr or .hdr"),
    ("sky = 0.7", "turn_deg = 1e9", "turn_deg is 1000000000, outside -3600 to 3600"),
    ("sky = 0.7", "detail.level = \"masked\"", "known are auto, barbules, barbs, vane, envelopes"),
    ("sky = 0.7", "detail.level = \"vanes\"", "detail.level is 'vanes', did you mean 'vane'?"),
    ("sky = 0.7", "lights = 3", "lights is the number 3"),
    ("sky = 0.7", "lights = [{type = \"lamp\"}]", "known are sun, point"),
    ("sky = 0.7", "lights = [{type = \"point\", strength = 1}]", "lights[0].distance_mm is missing"),
    (
        "sky = 0.7",
        "lights = [{type = \"point\", strength = 1, position_mm = [0, 0, 9], spectrum = \"words.csv\"}]",
        "lights[0].spectrum",
    ),
    (
        "sky = 0.7",
        "lights = [{type = \"sphere\", strength = 1, position_mm = [0, 0, 9], radius_mm = 10}]",
        "inside the sphere",
    ),
    ("sky = 0.7", "objects = [{sphere_mm = 1}]", "objects[0].surface is missing"),
    (
        "sky = 0.7",
        "objects = [{sphere_mm = 1, surface = \"shaft\"}]",
        "there is no table [surfaces.shaft] with a type",
    ),
    (
        "sky = 0.7",
        "objects = [{mesh = \"no.ply\", surface = \"x\"}]\nsurfaces.x = {type = \"dielectric\", index = 1.5}",
        "objects[0].mesh",
    ),
    (
        "sky = 0.7",
        "objects = [{mesh = \"good.csv\", surface = \"x\"}]\nsurfaces.x = {type = \"dielectric\", index = 1.5}",
        "meshes are read from .ply, .obj, .gltf or .glb",
    ),
    (
        "sky = 0.7",
        "surfaces.x = {type = \"dielectric\", index = 1.5, roughness = [0.1, 2]}",
        "surfaces.x.roughness[1] is 2, outside 0.02 to 1",
    ),
    ("sky = 0.7", "surfaces.x = {type = \"difuse\"}", "did you mean 'diffuse'"),
    (
        "sky = 0.7",
        "surfaces.rmaus = {melanin = 3}",
        "surfaces.rmaus has no type and is no part of a feather, did you mean 'ramus'?",
    ),
    (
        "sky = 0.7",
        "surfaces.x = {type = \"diffuse\", albedo = \"no.png\"}\nobjects = [{sphere_mm = 1, surface = \"x\"}]",
        "surfaces.x.albedo",
    ),
    (
        "sky = 0.7",
        "surfaces.x = {type = \"diffuse\", bump = \"no.png\", bump_um = 3}\nobjects = [{sphere_mm = 1, surface = \"x\"}]",
        "surfaces.x.bump",
    ),
    ("sky = 0.7", "surfaces.x = {type = \"diffuse\", bump = \"no.png\"}", "surfaces.x.bump_um is missing"),
    (
        "sky = 0.7",
        "surfaces.x = {type = \"map\", file = \"no.png\", surfaces = [\"y\"]}",
        "surfaces.x.surfaces[0] is 'y'",
    ),
    ("sky = 0.7", "shows_feather = 3", "shows_feather is the number 3"),
    ("width_mm = 4.4", "projection = \"ortographic\"", "did you mean 'orthographic'"),
    ("width_mm = 4.4", "position_mm = [0, 0]", "camera.position_mm has 2 numbers"),
    ("width_mm = 4.4", "position_mm = [0, 0, 0]\ntarget_mm = [0, 0, 0]", "are the same place"),
    ("width_mm = 4.4", "target_mm = [nan, 0, 0]", "camera.target_mm[0] is not a finite number"),
    ("width_mm = 4.4", "focal_length_mm = 0", "camera.focal_length_mm is 0, outside 5 to 5000"),
    ("width_mm = 4.4", "f_number = 0.5", "camera.f_number is 0.5, outside 1 to 1000"),
    ("width_mm = 4.4", "focus_distance_mm = -1", "camera.focus_distance_mm is -1"),
    ("sky = 0.7", "sky = -1.0", "sky"),
    ("elevation = 60.0", "elevation = 91.0", "light.elevation_deg is 91, outside -90 to 90"),
    ("width_mm = 4.4", "width_mm = 0.0", "camera.width_mm is 0, outside 0.05 to 2000"),
    ("sky = 0.7", "size = [0, 5]", "0"),
    ("sky = 0.7", "size = [10]", "size has 1 number; give two numbers"),
    ("sky = 0.7", "material = \"no.barbule\"", "no such file"),
    ("[light]", "[sky_image]\nfile = \"no.exr\"\n[light]", "leave one out"),
    ("sky = 0.7\n[light]", "[sky_image]\nfile = \"no.exr\"\n[light]", "no such file"),
    ("sky = 0.7\n[light]", "[sky_image]\nfile = \"good.csv\"\n[light]", "good.csv"),
    ("[light]", "[light", "line 4"),
];

/// Changes of a store's zarr.json, read by `simulate --status`.
const STORES: &[Change] = &[
    ("\"barbule_store\": 5", "\"barbule_store\": 9", "not a campaign store of this version (its layout is 9"),
    ("\"barbule_store\": 5,", "", "not a campaign store of this version"),
    ("\"barbule_store\": 5", "\"barbule_store\": 3", "its layout is 3, this program's is 5"),
    ("\"kept_nm\": []", "\"kept_nm\": [], \"sides\": \"left\"", "'sides' is not 'both', all it can be"),
    ("\"kept_nm\": []", "\"kept_nm\": [], \"sides\": \"both\"", "another shape than its axes say"),
    ("{", "", "zarr.json is damaged"),
    ("\"instances\": 2", "\"instances\": 0", "'instances' is no number from 1 to 10000"),
    ("\"instances\": 2", "\"instances\": 99999999999", "'instances' is no number from 1 to 10000"),
    ("\"cos_theta_i\"", "\"cos_theta\"", "'cos_theta_i' is missing or damaged"),
    ("450.0", "4500.0", "4500, outside 300 to 830"),
    ("450.0", "\"x\"", "'wavelengths_nm' is missing or damaged"),
    ("450.0", "451.0", "do not match their checksum"),
    ("0.5", "0.6", "do not match their checksum"),
    ("\"simd\": \"scalar\"", "\"simd\": \"avx2\"", "do not match their checksum"),
    ("450.0,", "450.0, 451.0,", "another shape than its axes say"),
    ("\"campaign\": {", "\"campaign\": {\"seed\": 7,", "do not match their checksum"),
    ("\"kept_nm\": []", "\"kept_nm\": [500.0]", "no wavelength of it"),
    ("\"kept_nm\": []", "\"kept_nm\": [450.0]", "no such file"),
];

/// The program's exit code and message, as a panic would be seen.
fn run(words: &[String]) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let all = std::iter::once("barbule".to_owned()).chain(words.iter().cloned());
    let code = barbule_cli::run(all, &mut out, &mut err);
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (code, text(out), text(err))
}

fn changed(good: &str, (from, to, _): &Change) -> String {
    assert!(good.contains(from), "{from}");
    good.replacen(from, to, 1)
}

fn axes() -> Axes {
    Axes::new(&Wavelengths::new([450.0, 550.0]).unwrap(), vec![0.5, 1.0], vec![0.5, 1.0]).unwrap()
}

fn make_store(path: &Path) {
    let description = serde_json::json!({"structure": {"species": "nobody"}});
    Store::create(path, &axes(), 2, "nobody", &description, &[], "scalar").unwrap();
}

/// Makes all files and gives the command lines that read them.
fn prepared(folder: &Path) -> Vec<(String, &'static str)> {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("good.csv", b"300,1.5,0\n830,1.5,0\n");
    write("words.csv", b"no numbers\n");
    write("good.json", SECTION.as_bytes());
    write(
        "inclusions.json",
        br#"{"barbule": 1, "units": "um", "inclusions": [{"circle": {"x": 1, "z": 0, "radius": 0.5}, "medium": "melanin"}]}"#,
    );
    for (name, mebibytes) in [("large.toml", 4), ("large.yml", 4), ("large.csv", 16), ("large.json", 64)] {
        let file = std::fs::File::create(folder.join(name)).unwrap();
        file.set_len((mebibytes << 20) + 1).unwrap();
    }
    write("many.json", &vec![b','; 4_000_001]);
    for name in ["empty", "folder.json", "full", "sections"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    write("full/mine.txt", b"x");
    write("sections/a.json", SECTION.as_bytes());
    write("sections/b.json", SECTION.replace("2.0", "4.0").replace("[-1, 0, 1]", "[-2, 0, 2]").as_bytes());
    make_store(&folder.join("good.zarr"));
    let mut lines: Vec<(String, &'static str)> =
        LINES.iter().map(|(line, part)| (line.replace("@empty/full", "@full"), *part)).collect();
    let mut species = Vec::new();
    barbule_cli::run(["barbule", "species", "starling", "--toml"], &mut species, &mut Vec::new());
    let species = String::from_utf8(species).unwrap();
    write("good.toml", species.as_bytes());
    let mut add = |kind: &str, end: &str, good: &str, changes: &'static [Change], command: &str| {
        for (index, change) in changes.iter().enumerate() {
            let name = format!("{kind}-{index}.{end}");
            write(&name, changed(good, change).as_bytes());
            lines.push((command.replace("FILE", &format!("@{name}")), change.2));
        }
    };
    add("section", "json", SECTION, SECTIONS, "geometry FILE -o @f.svg");
    add("species", "toml", &species, SPECIES, "geometry FILE -o @f.svg");
    add("stack", "toml", STACK, STACKS, "film FILE -o @f.svg");
    add("scene", "toml", SCENE, SCENES, "render FILE -o @f.png --samples 1");
    for (index, (end, text, part)) in TABLES.iter().enumerate() {
        write(&format!("table-{index}.{end}"), text.as_bytes());
        lines.push((format!("film air/chitin:5/air --medium chitin=@table-{index}.{end} -o @f.svg"), part));
    }
    for (index, change) in STORES.iter().enumerate() {
        let store = folder.join(format!("store-{index}.zarr"));
        make_store(&store);
        let file = store.join("zarr.json");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, changed(&text, change)).unwrap();
        lines.push((format!("simulate @store-{index}.zarr --status"), change.2));
        lines.push((format!("fit @store-{index}.zarr -o @f.barbule"), change.2));
    }
    let array = folder.join("array.zarr");
    make_store(&array);
    let text = std::fs::read_to_string(array.join("u/zarr.json")).unwrap();
    std::fs::write(array.join("u/zarr.json"), text.replace("crc32c", "gzip")).unwrap();
    lines.push(("simulate @array.zarr --status".into(), "'u' has another codecs"));
    let lacking = folder.join("lacking.zarr");
    make_store(&lacking);
    std::fs::remove_file(lacking.join("v/zarr.json")).unwrap();
    lines.push(("fit @lacking.zarr -o @f.barbule".into(), "v/zarr.json: no such file"));
    let good = encode_material(&barbule::brdf::fixtures::example(2)).unwrap();
    let altered = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let materials: [(&str, Vec<u8>, &'static str); 6] = [
        ("nothing", Vec::new(), "is not a material file"),
        ("text", b"this is a text, not a material".to_vec(), "is not a material file"),
        ("long-header", [&u64::MAX.to_le_bytes()[..], b"{}"].concat(), "is not a material file"),
        ("cut", good[..good.len() / 2].to_vec(), "is not a material file"),
        ("last-byte", altered(good.len() - 1), "checksum does not match"),
        ("middle", altered(good.len() * 3 / 4), "checksum does not match"),
    ];
    for (name, bytes, part) in materials {
        write(&format!("{name}.barbule"), &bytes);
        lines.push((format!("lobes @{name}.barbule -o @f.svg"), part));
        lines.push((format!("render starling --material @{name}.barbule -o @f.png"), part));
    }
    lines
}

fn names(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path.clone());
            }
            found.insert(path);
        }
    }
    found
}

/// Texts that would run over many lines, move a terminal's cursor, or fill the screen.
const HOSTILE: [&str; 7] =
    ["a\nb", "\u{1b}[31mred\u{1b}[2J", "\r\n\t", "\u{202e}lanimret", "'\"`", "{}%s\\", "LONG"];

/// Command lines that read X in as many ways; none can be run.
const READERS: &[&str] = &[
    "X",
    "film X",
    "film air/X:5/air",
    "film air/keratin:X/air",
    "film air/keratin:5/air --X",
    "film air/keratin:5/air --wavelengths X",
    "film air/keratin:5/air --angles X",
    "film air/keratin:5/air --threads X",
    "film air/keratin:5/air --memory 5X",
    "film air/keratin:5/air --medium X",
    "film air/keratin:5/air --medium X=@good.csv",
    "film air/keratin:5/air --medium q=X",
    "film air/keratin:5/air -o X",
    "film air/keratin:5/air --csv @no/X",
    "film X.toml",
    "geometry X -o @f.svg",
    "geometry X.json -o @f.svg",
    "geometry starling:X -o @f.svg",
    "species X",
    "spectrum starling --collect X",
    "spectrum starling --polarization X",
    "spectrum starling --plane X",
    "spectrum starling --measured X",
    "far-field starling --wavelength X --theta 0 --phi 0",
    "far-field starling --wavelength 500 --theta X --phi 0",
    "simulate starling -o @s.zarr --directions X",
    "simulate starling -o @s.zarr --shard X",
    "simulate starling -o @s.zarr --simd X",
    "simulate starling -o @s.zarr --wavelengths X",
    "simulate starling -o X/s.zarr",
    "simulate X --status",
    "fit X -o @f.barbule",
    "crystal X",
    "crystal mallard --solver X",
    "lobes X -o @f.svg",
    "render X -o @f.png",
    "render starling:X -o @f.png",
    "render starling -o @f.png --material X",
    "render starling -o @f.png --size X",
    "render starling -o @f.png --light X",
    "render starling -o @f.png --exposure X",
    "render starling -o @f.png --background X",
    "render starling -o @f.png --frames 2 --arc X",
    "render starling -o @f.png --frames 2 --path X",
    "render starling -o @f.png --preview=X",
    "render starling -o @f.exr --spectral X",
    "render starling -o @f.png --view X",
    "render starling -o @f.png --time X",
    "completions X",
    "man X",
];

#[test]
fn whatever_is_typed_a_refusal_is_one_short_line_without_control_characters() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("good.csv"), "300,1.5,0\n830,1.5,0\n").unwrap();
    let here = format!("{}/", folder.path().display());
    let long = "9".repeat(6000);
    let mut wrong = Vec::new();
    for line in READERS {
        for hostile in HOSTILE.map(|text| text.replace("LONG", &long)) {
            let word = |word: &str| word.replace('@', &here).replace('X', &hostile);
            let words: Vec<String> = line.split_whitespace().map(word).collect();
            let (code, out, message) = run(&words);
            let sentence = message.strip_suffix('\n').unwrap_or(&message);
            let is_one = sentence.starts_with("barbule: ") && sentence.len() < 600;
            let clean = !sentence.chars().any(|c| c.is_control() || c == '\u{202e}');
            if code != 2 || !is_one || !clean || !out.is_empty() {
                wrong.push(format!("{line} {hostile:.20?}\n    {code:?} {}: {message:?}", sentence.len()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} lines:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(names(folder.path()).len(), 1);
}

#[cfg(unix)]
#[test]
fn pipes_without_a_writer_and_devices_are_no_inputs_and_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for name in ["p.json", "p.toml", "p.csv", "p.barbule"] {
        assert!(std::process::Command::new("mkfifo").arg(at(name)).status().unwrap().success());
    }
    let svg = at("f.svg");
    for line in [
        vec!["geometry", &at("p.json"), "-o", &svg],
        vec!["geometry", &at("p.toml"), "-o", &svg],
        vec!["film", "air/q:5/air", "--medium", &format!("q={}", at("p.csv"))],
        vec!["film", "air/q:5/air", "--medium", "q=/dev/zero"],
        vec!["spectrum", "starling", "--measured", &at("p.csv")],
        vec!["lobes", &at("p.barbule"), "-o", &svg],
        vec!["render", &at("p.toml"), "-o", &at("f.png")],
    ] {
        let words: Vec<String> = line.iter().map(|word| (*word).to_owned()).collect();
        let (code, _, message) = run(&words);
        assert!(code == 2 && message.contains("is a pipe or a device"), "{line:?}: {message}");
    }
}

#[test]
fn every_refusal_is_one_sentence_with_exit_code_2_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let lines = prepared(folder.path());
    assert!(lines.len() >= 150, "{}", lines.len());
    let before = names(folder.path());
    let here = format!("{}/", folder.path().display());
    let mut wrong = Vec::new();
    for (line, part) in &lines {
        let words: Vec<String> = line.split_whitespace().map(|w| w.replace('@', &here)).collect();
        let outcome = std::panic::catch_unwind(|| run(&words));
        let Ok((code, out, message)) = outcome else {
            wrong.push(format!("{line}\n    panics"));
            continue;
        };
        let sentence = message.trim_end();
        let is_one = sentence.starts_with("barbule: ") && !sentence.contains('\n') && sentence.len() < 600;
        if code != 2 || !is_one || !sentence.contains(part) || !out.is_empty() {
            wrong.push(format!("{line}\n    expected: {part}\n    {code:?} {}: {message}", out.len()));
        }
    }
    let left: Vec<_> = names(folder.path()).difference(&before).cloned().collect();
    assert!(wrong.is_empty(), "{} of {} lines:\n{}", wrong.len(), lines.len(), wrong.join("\n"));
    assert!(left.is_empty(), "{left:?}");
}
