//! What can go wrong in a room on purpose.

use std::time::Duration;

use super::{mean, plain_room};
use image::RgbImage;
use shared::{
    pattern::{Axis, Grid, Pattern, Raster, Rgb},
    sequence::Symbol,
    simulation::{Room, Scene, Timeline},
    stage::Stage,
};

/// The frame of an exposure that begins after so many milliseconds, under a picture that has been up for long.
fn frame(scene: &Scene, picture: &Raster, start_ms: f64) -> RgbImage {
    let mut timeline = Timeline::new(scene);
    timeline.show(Duration::ZERO, picture);
    let start = Duration::from_secs_f64(1.0 + start_ms / 1000.0);
    Room::new(scene, Stage::Background).render_at(&timeline, start, 0)
}

fn middle(picture: &RgbImage) -> [f64; 3] {
    [0, 1, 2].map(|channel| mean(picture, channel, 140..180, 100..140))
}

#[test]
fn a_lamp_flickers_unless_the_exposure_holds_whole_swings() {
    let room = |exposure_ms: &str| {
        let camera = format!("exposure_ms = {exposure_ms}");
        let rest = "[ambient]\nlevel = 0.4\n[faults]\nlamp_flicker = 0.5\nlamp_flicker_hz = 100.0";
        plain_room(&camera, "", rest)
    };
    let swing = |scene: &Scene| {
        let black = Pattern::BLACK.raster(scene.projector_size());
        let at = |ms| middle(&frame(scene, &black, ms))[1];
        at(0.0) / at(5.0)
    };
    let short = swing(&room("0.1"));
    assert!((short - 3.0).abs() < 0.1, "1.5 against 0.5: {short}");
    let whole = swing(&room("20.0"));
    assert!((whole - 1.0).abs() < 0.01, "{whole}");
}

#[test]
fn a_colour_wheel_shows_one_colour_after_the_other_and_all_in_a_whole_turn() {
    let room = |exposure_ms: &str| {
        // a third of the turn is three times as bright
        let camera = format!("exposure_ms = {exposure_ms}\nwhite_balance = [0.3, 0.3, 0.3]");
        plain_room(&camera, "", "[faults]\ncolour_wheel_hz = 50.0")
    };
    let white = |scene: &Scene, ms| {
        let picture = Pattern::WHITE.raster(scene.projector_size());
        middle(&frame(scene, &picture, ms))
    };
    let scene = room("2.0");
    let lit = |ms| white(&scene, ms).map(|level| level > 1.0);
    assert_eq!(lit(1.0), [true, false, false]);
    assert_eq!(lit(8.0), [false, true, false]);
    assert_eq!(lit(15.0), [false, false, true]);
    let whole = room("20.0");
    let steady = plain_room(
        "exposure_ms = 20.0\nwhite_balance = [0.3, 0.3, 0.3]",
        "",
        "",
    );
    let pairs = white(&whole, 3.0).into_iter().zip(white(&steady, 3.0));
    for (wheel, steady) in pairs {
        assert!((wheel - steady).abs() <= 1.0, "{wheel} {steady}");
    }
}

#[test]
fn a_scaler_takes_light_from_lines_of_one_pixel() {
    let scene = |faults: &str| plain_room("", "gamma = 2.2", faults);
    let lines = |scene: &Scene| {
        let size = scene.projector_size();
        let count = size.along(Axis::Column) as usize / 2;
        let columns = vec![Symbol(0); count];
        let colours = [Rgb::WHITE, Rgb::BLACK];
        let grid = Grid::explicit(vec![Symbol(1)], columns, (1, 1), &colours).unwrap();
        let picture = Pattern::Grid(grid).raster(size);
        middle(&frame(scene, &picture, 0.0))[1]
    };
    let exact = lines(&scene(""));
    for faults in ["picture_scale = [0.9, 0.9]", "keystone = 0.1"] {
        let scaled = lines(&scene(&format!("[faults]\n{faults}")));
        let share = scaled / exact;
        assert!((0.55..0.75).contains(&share), "{faults}: {share}");
    }
}

#[test]
fn another_output_shows_its_own_colour_whatever_is_sent() {
    let scene = plain_room("", "", "[faults]\nother_output = \"#808080\"");
    let size = scene.projector_size();
    let [black, white] = [Pattern::BLACK, Pattern::WHITE]
        .map(|picture| middle(&frame(&scene, &picture.raster(size), 0.0)));
    assert_eq!(black, white);
    assert!(black[0] > 50.0);
}

#[test]
fn frames_are_lost_by_their_share_and_the_rate_is_what_comes() {
    let scene = plain_room(
        "frame_rate_hz = 30.0",
        "",
        "[faults]\nlost_share = 0.2\ndelivered_rate_hz = 10.0",
    );
    let lost = (0..10_000).filter(|number| scene.loses(*number)).count();
    assert!((1800..2200).contains(&lost), "{lost}");
    assert_eq!(scene.delivered_period(), Duration::from_millis(100));
    assert!(scene.frame_period() < Duration::from_millis(34));
    let whole = plain_room("", "", "");
    assert!((0..1000).all(|number| !whole.loses(number)));
    assert_eq!(whole.delivered_period(), whole.frame_period());
}
