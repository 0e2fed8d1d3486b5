//! Scene files: the shipped ones are of use, broken ones are refused.

use std::path::Path;

use proptest::prelude::*;
use shared::{
    pattern::{Grid, Pattern, Rgb},
    simulation::{Room, Scene, Space},
    stage::Stage,
};

#[test]
fn nonsense_is_refused_with_the_line_and_what_to_do() {
    let cube = std::fs::read_to_string(scenes().join("cube.toml")).unwrap();
    let refused = |text: &str| Scene::parse(text, &scenes()).unwrap_err().to_string();
    let with = |from: &str, to: &str| {
        assert!(cube.contains(from), "{from}");
        refused(&cube.replacen(from, to, 1))
    };
    let line_of = |key: &str| {
        let line = cube.lines().position(|line| line.starts_with(key)).unwrap() + 1;
        format!("line {line}")
    };
    let unknown = with("\nexposure =", "\nexposrue =");
    assert!(
        unknown.contains(&line_of("exposure =")) && unknown.contains("exposrue"),
        "{unknown}"
    );
    let negative = with("jpeg_quality = 90", "jpeg_quality = 101");
    assert!(
        negative.contains(&line_of("jpeg_quality")) && negative.contains("0 to 100"),
        "{negative}"
    );
    let steep = with("tone_curve = \"srgb\"", "tone_curve = { power = 9.0 }");
    assert!(
        steep.contains(&line_of("tone_curve")) && steep.contains("0.2 to 5"),
        "{steep}"
    );
    let endless = with("frame_rate_hz = 30.0", "frame_rate_hz = nan");
    assert!(endless.contains(&line_of("frame_rate_hz")), "{endless}");
    let colour = with("colour = \"#fff1dc\"", "colour = \"warm\"");
    assert!(
        colour.contains("warm") && colour.contains("#rrggbb"),
        "{colour}"
    );
    let two = with("\nbox = {", "\nsphere = { radius_mm = 3.0 }\nbox = {");
    assert!(two.contains("exactly one shape"), "{two}");
    let blind = with(
        "looks_at_mm = [0.0, 0.0, 1000.0]",
        "looks_at_mm = [0.0, 0.0, 0.0]",
    );
    assert!(
        blind.contains(&line_of("[camera]")) && blind.contains("looks_at_mm"),
        "{blind}"
    );
    let same = with(
        "position_mm = [180.0, -140.0, -100.0]",
        "position_mm = [0.0, 0.0, 0.0]",
    );
    assert!(same.contains("baseline"), "{same}");
    let solids = cube.find("[[solids]]\nname").unwrap();
    assert!(refused(&cube[..solids]).contains("the room is empty"));
    let missing = with(
        "box = { size_mm = [240.0, 240.0, 150.0] }",
        "mesh = { file = \"no.obj\" }",
    );
    assert!(missing.contains("no.obj"), "{missing}");
    let corner = "mesh = { vertices_mm = [[0, 0, 0]], faces = [[0, 1, 2]] }";
    let broken = with("box = { size_mm = [240.0, 240.0, 150.0] }", corner);
    assert!(broken.contains("none of the 1 vertices"), "{broken}");
    assert!(
        Scene::load(Path::new("no/such/scene.toml"))
            .unwrap_err()
            .to_string()
            .contains("no/such")
    );
}

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes")
}

#[test]
fn every_shipped_scene_shows_grid_and_object() {
    let mut count = 0;
    for entry in std::fs::read_dir(scenes()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let grid = Grid::coded(15, 15, 6, 6, &[Rgb::WHITE]).unwrap();
        let clear = Stage::BOTH.map(|stage| {
            let truth = Space::new(&scene, stage).truth(&grid, scene.projector_size());
            truth.iter().filter(|v| v.clear).count() / 4
        });
        assert!(
            clear[0] >= 150,
            "{}: {} crossings clear before",
            path.display(),
            clear[0]
        );
        assert!(
            clear[1] >= 100,
            "{}: {} crossings clear after",
            path.display(),
            clear[1]
        );
        assert_ne!(
            clear[0],
            clear[1],
            "{}: the object changes nothing",
            path.display()
        );
        count += 1;
    }
    assert_eq!(count, 7, "scenes");
}

/// Numbers at the borders of what scene files may say.
fn extreme() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![1e-6, 1e-3, 0.5, 1.0, 10.0, 1e3, 1e6])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_damaged_scene_file_never_panics(at in 0_usize..9000, to in 0_u8..128, cut in 0_usize..20) {
        let cube = std::fs::read_to_string(scenes().join("cube.toml")).unwrap();
        let mut bytes = cube.into_bytes();
        let at = at % bytes.len();
        bytes[at] = to;
        let until = (at + 1 + cut).min(bytes.len());
        bytes.drain(at + 1..until);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        drop(Scene::parse(&text, &scenes()));
    }

    #[test]
    fn a_room_of_extreme_numbers_never_panics(v in prop::collection::vec(extreme(), 12), blur in 0.0..10.0, bayer: bool) {
        let text = format!(
            "title = \"extreme\"\n[camera]\nwidth = 17\nheight = 8\nfocal_px = [{}, {}]\n\
             centre_px = [{}, -3.0]\ndistortion = [{}, -{}, 0.0, 0.1, 0.0]\nposition_mm = [0, 0, 0]\n\
             looks_at_mm = [0, {}, 1000]\nexposure = {}\nfull_well_electrons = {}\nblur_px = {blur}\n\
             bayer = {bayer}\njpeg_quality = 1\n[projector]\nwidth = 9\nheight = 8\nfocal_px = [{}, {}]\n\
             centre_px = [0, 0]\nposition_mm = [{}, 0, 0]\nlooks_at_mm = [0, 0, 500]\ngamma = {}\nblur_px = {blur}\n\
             [[solids]]\nname = \"ball\"\nposition_mm = [0, 0, 500]\nsphere = {{ radius_mm = {} }}\n\
             surface = {{ noise = {{ colour = \"#ff0000\", size_mm = {} }}, gloss = 0.5, gloss_exponent = {} }}\n",
            v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9], v[10], v[11], v[0], v[1], v[2],
        );
        let scene = Scene::parse(&text, Path::new(".")).unwrap();
        let light = scene.project(&Pattern::WHITE.raster(scene.projector_size()));
        let room = Room::new(&scene, Stage::Object);
        prop_assert_eq!(room.render(&light, 3).dimensions(), (17, 8));
        let grid = Grid::coded(15, 15, 1, 1, &[Rgb::WHITE]).unwrap();
        for vertex in room.truth(&grid, scene.projector_size()) {
            prop_assert!(vertex.camera.x.is_finite() && vertex.point_mm.z.is_finite());
        }
    }
}
