//! Renders a simulated room as a scan folder: both stages under black, white, the colour-coded grid and the unary
//! grid, with the true calibration and the truth of every vertex.
//!
//! Run: `cargo run -p shared --example render_scene -- config/scenes/cube.toml OUT_FOLDER`.

use std::{error::Error, fs, path::Path};

use serde_json::{Value, json};
use shared::{
    pattern::{Grid, GridSettings, Pattern, Rgb},
    simulation::{Room, Scene, write_truth_csv},
    stage::Stage,
};

/// Repeats of each picture, so that its noise can be seen.
const REPEATS: u64 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: render_scene SCENE.toml OUT_FOLDER";
    let (scene, out) = arguments.next().zip(arguments.next()).ok_or(usage)?;
    let (scene, out) = (Scene::load(Path::new(&scene))?, Path::new(&out));
    let colours = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]].map(Rgb);
    let coded = Grid::coded(15, 15, 6, 6, &colours)?;
    let pattern = GridSettings {
        coded,
        unary: colours[0],
    };
    let (mut captures, mut truth) = (Vec::new(), Vec::new());
    for stage in Stage::BOTH {
        fs::create_dir_all(out.join(stage.name()))?;
        let room = Room::new(&scene, stage);
        captures.extend(render(&scene, &room, (stage, &pattern), out)?);
        let vertices = room.truth(&pattern.coded, scene.projector_size());
        let clear = vertices.iter().filter(|vertex| vertex.clear).count() / 4;
        println!(
            "{stage}: {} vertices seen, {clear} crossings clear",
            vertices.len()
        );
        truth.extend(vertices);
    }
    let (width, height) = scene.camera_size();
    let scan = json!({
        "format": 1,
        "pattern": pattern,
        "projector": scene.projector_size(),
        "camera": { "width": width, "height": height },
        "calibration": "calibration.json",
        "captures": captures,
    });
    fs::write(out.join("scan.json"), serde_json::to_string_pretty(&scan)?)?;
    fs::write(out.join("calibration.json"), scene.calibration().to_json()?)?;
    write_truth_csv(&truth, fs::File::create(out.join("truth.csv"))?)?;
    Ok(())
}

/// Renders the pictures of one stage; gives their entries in `scan.json`.
fn render(
    scene: &Scene,
    room: &Room,
    (stage, pattern): (Stage, &GridSettings),
    out: &Path,
) -> Result<Vec<Value>, Box<dyn Error>> {
    let patterns = [
        ("black", Pattern::BLACK),
        ("white", Pattern::WHITE),
        ("prmvs", Pattern::Grid(pattern.coded.clone())),
        ("unary", Pattern::Grid(pattern.unary_grid())),
    ];
    let mut captures = Vec::new();
    let mut frame_number = 0;
    for (shows, pattern) in &patterns {
        let light = scene.project(&pattern.raster(scene.projector_size()));
        for repeat in 0..REPEATS {
            let file = format!("{stage}/{shows}-{repeat:02}.png");
            room.render(&light, frame_number).save(out.join(&file))?;
            frame_number += 1;
            captures.push(json!({ "stage": stage, "shows": shows, "file": file }));
        }
    }
    Ok(captures)
}
