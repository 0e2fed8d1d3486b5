//! Pictures that change while the camera looks.

use std::time::Duration;

use super::{mean, plain_room};
use shared::{
    pattern::Pattern,
    simulation::{Room, Timeline},
    stage::Stage,
};

#[test]
fn a_rolling_shutter_shows_both_pictures_in_one_frame() {
    let scene = plain_room("exposure_ms = 10.0\nreadout_ms = 20.0", "", "");
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_millis(100), &Pattern::BLACK.raster(size));
    timeline.show(Duration::from_millis(115), &Pattern::WHITE.raster(size));
    let torn = room.render_at(&timeline, Duration::from_millis(100), 0);
    let white = room.render(&scene.project(&Pattern::WHITE.raster(size)), 0);
    let share = |y: u32| mean(&torn, 0, 150..170, y..y + 1) / mean(&white, 0, 150..170, y..y + 1);
    // row y gathers light from 100 + y / 12 ms on, for 10 ms
    assert!(share(40) < 0.01, "exposed before the change: {}", share(40));
    assert!(
        (share(120) - 0.5).abs() < 0.02,
        "half and half: {}",
        share(120)
    );
    assert!(
        share(200) > 0.99,
        "exposed after the change: {}",
        share(200)
    );
    assert_eq!(
        room.render_at(&timeline, Duration::from_millis(115), 0),
        white
    );
    assert_eq!(
        mean(
            &room.render_at(&timeline, Duration::ZERO, 0),
            0,
            0..320,
            0..240
        ),
        0.0
    );
}

#[test]
fn light_follows_the_command_after_the_latency_and_old_pictures_can_be_forgotten() {
    let scene = plain_room(
        "exposure_ms = 0.1",
        "display_latency_ms = 60.0\ndisplay_jitter_ms = 5.0",
        "",
    );
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_secs(1), &Pattern::WHITE.raster(size));
    timeline.show(Duration::from_secs(2), &Pattern::BLACK.raster(size));
    let level = |timeline: &Timeline, ms: u64| {
        mean(
            &room.render_at(timeline, Duration::from_millis(ms), 0),
            0,
            150..170,
            110..130,
        )
    };
    assert_eq!(level(&timeline, 1059), 0.0);
    assert!(level(&timeline, 1066) > 150.0);
    assert!(level(&timeline, 2059) > 150.0);
    assert_eq!(level(&timeline, 2066), 0.0);
    timeline.forget_before(Duration::from_millis(1500));
    assert!(
        level(&timeline, 2000) > 150.0,
        "what is still shown is kept"
    );
    timeline.forget_before(Duration::from_secs(3));
    assert_eq!(level(&timeline, 3000), 0.0);
}
