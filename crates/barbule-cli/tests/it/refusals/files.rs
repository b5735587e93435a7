//! Files that are refused: good ones, each with one change.

/// A file of a kind with one change, and a part of what must be said of it.
pub(super) type Change = (&'static str, &'static str, &'static str);

pub(super) const SECTION: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a",
 "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}, {"x": [-1, 0, 1], "z": [-1, -1, -1]}],
 "media": ["air", "keratin", "melanin"],
 "inclusions": [{"circle": {"x": 0.0, "z": -0.5, "radius": 0.2}, "medium": "melanin"}]}"#;

/// Read by `geometry`.
pub(super) const SECTIONS: &[Change] = &[
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
pub(super) const SPECIES: &[Change] = &[
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

pub(super) const STACK: &str = "entry = \"air\"\nexit = \"keratin\"\n\
    layers = [{ medium = \"keratin\", thickness_nm = 5 }, { repeat = 2, layers = [{ medium = \"air\", thickness_nm = 9 }] }]\n";

/// Read by `film`.
pub(super) const STACKS: &[Change] = &[
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
pub(super) const TABLES: &[(&str, &str, &str)] = &[
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

pub(super) const SCENE: &str =
    "preset = \"starling\"\nexposure = 0.5\nsky = 0.7\n[light]\nelevation = 60.0\n[camera]\nwidth_mm = 4.4\n";

/// Read by `render`.
pub(super) const SCENES: &[Change] = &[
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
        "surfaces.x.type = \"diffuse\"\nobjects = [{sphere_mm = 1, surface = \"x\", under = \"keratin\"}]",
        "objects[0].under is given, but the object is no feather, coat or row",
    ),
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
    (
        "width_mm = 4.4",
        "projection = \"orthographic\"\nfocus_distance_mm = 8",
        "camera.focus_distance_mm is given, but an orthographic camera is sharp everywhere",
    ),
    (
        "width_mm = 4.4",
        "projection = \"orthographic\"\nf_number = 8",
        "camera.f_number is given, but an orthographic camera is sharp everywhere",
    ),
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
pub(super) const STORES: &[Change] = &[
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
