use super::*;
use crate::scene::description::{Foreseen, ObjectShape, SceneDescription};

fn scene(row: &str, beside: &str) -> Result<SceneDescription> {
    SceneDescription::parse(&format!(
        "preset = 'osprey'\nshows_feather = false\n[[objects]]\nname = 'tail'\n{beside}\nrow = {{{row}}}"
    ))
}

const STATIONS: &str = "stations = [{position_mm = [1, 0, 0], direction = [0, -1, 0]}, \
     {position_mm = [6, 0, 0], direction = [0.4, -1, 0], scale = 0.8, kind = 1}]";
const HAIR: &str = "{type = 'hair'}";

fn dress() -> String {
    format!("dress = {{distal = {HAIR}, proximal = {HAIR}}}")
}

/// A row of two kinds with its mirror image.
fn tail() -> SceneDescription {
    let zone =
        format!("{{across = [0, 1], ring = {{centre_mm = [2, 9], radii_mm = [0, 3]}}, distal = {HAIR}}}");
    let kind = format!("{{feather = 'semiplume', {}}}", dress());
    let row = format!("count = 5, {STATIONS}, mirror = true, variants = 2, feathers = [{kind}]");
    let beside = format!("feather = 'covert'\ndetail = {{level = 'vane'}}\nzones = [{zone}]\n{}", dress());
    scene(&row, &beside).unwrap()
}

/// Every part at the places of its variant, each feather once; names for all; the scene comes back from its text; the same on any number
/// of threads.
#[test]
fn a_row_is_its_variants_at_their_places() {
    let scene = tail();
    assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
    let ready = scene.clone().wearing(None).unwrap();
    let (objects, counts) = ready.objects(3).unwrap();
    // Two kinds of two variants on two sides, each a shaft, two vanes and two of down.
    assert_eq!((objects.len(), scene.object_names().len()), (40, 40));
    assert_eq!(scene.object_names()[1], "tail left vane");
    for part in 0..5 {
        let places: usize = (0..8).map(|variant| objects[5 * variant + part].geometry.places.len()).sum();
        assert_eq!(places, 10);
    }
    assert!(counts.barbs > 0 && scene.bytes(&Foreseen::new()) > 0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let (again, _) = pool.install(|| ready.objects(3)).unwrap();
    for (one, other) in objects.iter().zip(&again) {
        let (one, other) = (&one.geometry, &other.geometry);
        assert_eq!((&one.places, &one.meshes), (&other.places, &other.meshes));
        assert_eq!(one.ribbon_nodes, other.ribbon_nodes);
    }
}

/// A row that stands twice has twice as many feathers, at places of both.
#[test]
fn rows_stand_in_several_places() {
    let beside = format!("instances = [{{}}, {{translate_mm = [0, 50, 0]}}]\n{}", dress());
    let scene =
        scene(&format!("count = 3, variants = 1, {}", STATIONS.replace(", kind = 1", "")), &beside).unwrap();
    let (objects, _) = scene.wearing(None).unwrap().objects(3).unwrap();
    let places = &objects[0].geometry.places;
    assert_eq!(places.len(), 6);
    for i in 0..3 {
        assert!((places[i].shift + DVec3::Y * 50.0 - places[3 + i].shift).length() < 1e-12);
        assert_ne!(places[i].id, places[3 + i].id);
    }
}

#[test]
fn zones_of_mirror_images_are_mirrored() {
    let scene = tail();
    let ObjectShape::Row(of) = &scene.objects[0].shape else { panic!() };
    let mirrored = of.first.one(of.first.feather, of.detail).with_zones_mirrored().unwrap();
    assert_eq!(mirrored.zones[0].across, [-1.0, 0.0]);
    assert_eq!(mirrored.zones[0].ring.unwrap().centre_mm, [-2.0, 9.0]);
    let picture = Texture::new([2, 2], [0.0, 0.25, 0.5, 1.0].map(|value| [value; 3]).to_vec()).unwrap();
    let expected = Texture::new([2, 2], [0.25, 0.0, 1.0, 0.5].map(|value| [value; 3]).to_vec()).unwrap();
    assert_eq!(picture.mirrored(), expected);
}

#[test]
fn bad_rows_are_refused_by_key() {
    let message =
        |row: &str, beside: &str| scene(row, &format!("{}\n{beside}", dress())).unwrap_err().to_string();
    let plain = STATIONS.replace(", kind = 1", "");
    let with = |more: &str| message(&format!("count = 5, {plain}{more}"), "");
    assert!(message(STATIONS, "").contains("objects[0].row.count is missing"));
    assert!(message("count = 5", "").contains("objects[0].row.stations is missing"));
    assert!(message("count = 5, stations = []", "").contains("give 1 to 100 of them"));
    let large = message(&format!("count = 2001, {plain}"), "");
    assert!(large.contains("objects[0].row.count is 2001, outside 1 to 2000"), "{large}");
    let kind = message(&format!("count = 5, {STATIONS}"), "");
    assert!(kind.contains("objects[0].row.stations[1].kind is 1, but the row has 1 kinds"), "{kind}");
    assert!(with(", over = 'frist'").contains("did you mean 'first'"));
    assert!(with(", roll_deg = 50").contains("objects[0].row.roll_deg is 50, outside 0 to 45"));
    assert!(with(", variants = 0").contains("variants is 0"));
    let at = |station: &str| {
        message(&format!("count = 5, stations = [{{position_mm = [0, 0, 0], {station}}}]"), "")
    };
    assert!(at("direction = [0, 0, 0]").contains("stations[0].direction has no length"));
    let along = at("direction = [0, 0, 2]");
    assert!(along.contains("stations[0].normal is along direction"), "{along}");
    let count = format!("count = 5, {plain}");
    assert!(message(&count, "window = {whole = true}").contains("but the object is no feather;"));
    assert!(message(&count, "surface = 'white'").contains("give its dress"));
    assert!(message(&count, "sphere_mm = 2").contains("has 2 shapes"));
    assert!(message(&count, "detail = {view_model = 'both'}").contains("no second row"));
    assert!(message(&count, "zone_map = 'a.png'").contains("there are no zones"));
    let many = format!("instances = [{}]", "{},".repeat(9000));
    let scene = scene(&format!("count = 2000, {plain}"), &format!("{}\n{many}", dress())).unwrap();
    let message = scene.wearing(None).unwrap().objects(1).unwrap_err().to_string();
    assert!(message.contains("18000000 feathers"), "{message}");
}
