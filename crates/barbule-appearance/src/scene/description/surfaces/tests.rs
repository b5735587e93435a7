use super::*;

#[test]
fn maps_choose_among_surfaces_that_exist() {
    let message = |surfaces: &str| {
        let table = format!(
            "b = {{type = 'map', file = 'b.png', surfaces = [{surfaces}]}}\nglass = {{type = 'dielectric', index = 1.5}}"
        );
        let table: BTreeMap<String, Value> = toml::from_str(&table).unwrap();
        Surfaces::of_value(&serde_json::to_value(table).unwrap(), "surfaces", &())
    };
    assert!(message("'glass', 'glass'").is_ok());
    assert!(
        message("'glass', 'glas'")
            .unwrap_err()
            .to_string()
            .contains("surfaces.b.surfaces[1] is 'glas', did you mean 'glass'?")
    );
    assert!(message("'b'").unwrap_err().to_string().contains("surfaces.b.surfaces[0] is the map 'b'"));
}

#[test]
fn bad_surfaces_are_refused_by_key() {
    let surface = |text: &str| {
        let table: Value = toml::from_str(text).unwrap();
        NamedSurface::read(&table, "surfaces.table").unwrap_err().to_string()
    };
    assert!(surface("index = 1").contains("surfaces.table.type is missing"));
    assert!(surface("type = 'difuse'").contains("did you mean 'diffuse'"));
    assert!(surface("type = 'dielectric'\nindex = 9").contains("surfaces.table.index is 9"));
    assert!(
        surface("type = 'dielectric'\nindex = 1.5\nroughness = 0")
            .contains("roughness is 0, outside 0.02 to 1")
    );
    assert!(surface("type = 'diffuse'\ncolour = 3").contains("surfaces.table.colour"));
    assert!(
        surface("type = 'keratin'\nroughness = 0.2\nindex = 1.5")
            .contains("surfaces.table.melanin is missing")
    );
    let diffuse = |text: &str| surface(&format!("type = 'diffuse'\n{text}"));
    assert!(diffuse("bump = 'a.png'").contains("surfaces.table.bump_um is missing"));
    assert!(diffuse("bump = 'a.png'\nbump_um = 1e6").contains("bump_um is 1000000, outside"));
    assert!(diffuse("bump_um = 3").contains("there is no picture surfaces.table.bump"));
    assert!(diffuse("bump = 'a.png'\nbump_um = 3\nnormal = 'b.png'").contains("are both given"));
    let map = |text: &str| surface(&format!("type = 'map'\n{text}"));
    assert!(map("surfaces = ['a']").contains("surfaces.table.file is missing"));
    assert!(map("file = 'a.png'").contains("surfaces.table.surfaces is missing"));
    assert!(map("file = 'a.png'\nsurfaces = []").contains("give 1 to 256 of them"));
    assert!(map("file = 'a.png'\nsurfaces = ['a', 3]").contains("surfaces[1] is the number 3"));
    let metal = |text: &str| surface(&format!("type = 'conductor'\n{text}"));
    assert!(surface("type = 'conducter'").contains("did you mean 'conductor'"));
    assert!(metal("metal = 'copper'").contains("surfaces.table.roughness is missing"));
    assert!(metal("roughness = 0.01\nmetal = 'copper'").contains("roughness is 0.01, outside 0.02 to 1"));
    assert!(
        metal("roughness = [0.1, 2]\nmetal = 'copper'")
            .contains("surfaces.table.roughness[1] is 2, outside 0.02 to 1")
    );
    assert!(metal("roughness = [0.1]\nmetal = 'copper'").contains("one number or two"));
    assert!(metal("roughness = 0.1\nmetal = 'coper'").contains("did you mean 'copper'"));
    assert!(metal("roughness = 0.1").contains("surfaces.table has no metal"));
    assert!(metal("roughness = 0.1\nmetal = 'copper'\nindex = 1").contains("has a metal and an index"));
    assert!(metal("roughness = 0.1\nindex = 1").contains("surfaces.table.absorption is missing"));
    assert!(metal("roughness = 0.1\nindex = 0\nabsorption = 1").contains("surfaces.table.index is 0"));
    let film = |text: &str| surface(&format!("type = 'film'\n{text}"));
    assert!(film("roughness = 0.1").contains("surfaces.table.stack is missing"));
    assert!(film("roughness = 0.1\nstack = 'air/keratn:400/air'").contains("did you mean 'keratin'"));
    assert!(film("stack = 'air/keratin:400/air'").contains("surfaces.table.roughness is missing"));
    assert!(
        film("stack = 'air/keratin:400/air'\nroughness = 0.1\ncolour = 3").contains("surfaces.table.colour")
    );
    assert!(metal("roughnes = 0.1").contains("did you mean 'roughness'"));
}
