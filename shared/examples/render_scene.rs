//! Renders a simulated room to PNG files: both stages under white, black, the colour-coded grid and the unary grid.
//!
//! Run: `cargo run -p shared --example render_scene -- config/scenes/cube.toml OUT_FOLDER`.

use std::{error::Error, fs, path::Path, time::Instant};

use shared::{
    pattern::{Grid, Pattern, Rgb},
    simulation::{Room, Scene, write_truth_csv},
    stage::Stage,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: render_scene SCENE.toml OUT_FOLDER";
    let (scene, out) = arguments.next().zip(arguments.next()).ok_or(usage)?;
    let scene = Scene::load(Path::new(&scene))?;
    let size = scene.projector_size();
    let colours = ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"].map(str::parse::<Rgb>);
    let grid = Grid::coded(
        15,
        15,
        6,
        6,
        &colours.into_iter().collect::<Result<Vec<_>, _>>()?,
    )?;
    let patterns = [
        ("white", Pattern::WHITE),
        ("black", Pattern::BLACK),
        ("prmvs", Pattern::Grid(grid.clone())),
        ("unary", Pattern::Grid(grid.unary(Rgb([255, 0, 0])))),
    ];
    let mut truth = Vec::new();
    for stage in Stage::BOTH {
        let start = Instant::now();
        let room = Room::new(&scene, stage);
        println!("{stage}: room in {:.0?}", start.elapsed());
        let folder = Path::new(&out).join(stage.name());
        fs::create_dir_all(&folder)?;
        for (frame, (name, pattern)) in (0..).zip(&patterns) {
            let light = scene.project(&pattern.raster(size));
            let start = Instant::now();
            let picture = room.render(&light, frame);
            println!("{stage}: {name} in {:.1?}", start.elapsed());
            picture.save(folder.join(format!("{name}-00.png")))?;
        }
        truth.extend(room.truth(&grid, size));
    }
    for stage in Stage::BOTH {
        let seen = truth.iter().filter(|vertex| vertex.stage == stage);
        let clear = seen.clone().filter(|vertex| vertex.clear).count();
        println!(
            "{stage}: {} vertices seen, {} crossings clear",
            seen.count(),
            clear / 4
        );
    }
    write_truth_csv(&truth, fs::File::create(Path::new(&out).join("truth.csv"))?)?;
    fs::write(
        Path::new(&out).join("calibration.json"),
        scene.calibration().to_json()?,
    )?;
    Ok(())
}
