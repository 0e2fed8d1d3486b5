//! The simulated room through its public interface: where light falls, how much of it, when, and what is refused.

mod light;
mod line_truth;
mod scene_files;
mod sensor;
mod time;
mod truth;

use std::path::Path;

use image::RgbImage;
use shared::{
    pattern::{Grid, Pattern, Rgb},
    simulation::{Room, Scene},
    stage::Stage,
};

/// A white wall a metre away, seen by an ideal camera and lit by an ideal projector, and room for changes.
fn plain_room(camera: &str, projector: &str, rest: &str) -> Scene {
    let tone = if camera.contains("tone_curve") {
        ""
    } else {
        "tone_curve = \"linear\""
    };
    let text = format!(
        r##"
        title = "test"
        [camera]
        width = 320
        height = 240
        focal_px = [345.0, 345.0]
        centre_px = [161.3, 118.4]
        position_mm = [0.0, 0.0, 0.0]
        looks_at_mm = [0.0, 0.0, 1000.0]
        {tone}
        exposure = 0.8
        {camera}
        [projector]
        width = 512
        height = 384
        focal_px = [640.0, 640.0]
        centre_px = [256.0, 192.0]
        position_mm = [180.0, -140.0, -100.0]
        looks_at_mm = [0.0, 0.0, 1000.0]
        {projector}
        [[solids]]
        name = "wall"
        position_mm = [0.0, 0.0, 1000.0]
        plane = {{ size_mm = [4000.0, 4000.0] }}
        surface = {{ colour = "#ffffff" }}
        {rest}
        "##
    );
    Scene::parse(&text, Path::new(".")).expect("the test room is a scene")
}

const BOX: &str = r##"
    [[solids]]
    name = "box"
    when = "object"
    position_mm = [0.0, 0.0, 900.0]
    box = { size_mm = [200.0, 200.0, 200.0] }
    surface = { colour = "#bcbcbc" }
"##;

fn grid(width_px: u32) -> Grid {
    Grid::coded(15, 15, width_px, width_px, &[Rgb::WHITE]).expect("a grid of 15 lines exists")
}

fn frame(scene: &Scene, stage: Stage, picture: &Pattern) -> RgbImage {
    let light = scene.project(&picture.raster(scene.projector_size()));
    Room::new(scene, stage).render(&light, 0)
}

fn mean(
    picture: &RgbImage,
    channel: usize,
    x: std::ops::Range<u32>,
    y: std::ops::Range<u32>,
) -> f64 {
    let values = y.flat_map(|y| x.clone().map(move |x| (x, y)));
    let values: Vec<f64> = values
        .map(|(x, y)| f64::from(picture.get_pixel(x, y).0[channel]))
        .collect();
    values.iter().sum::<f64>() / values.len() as f64
}
