//! Dense lines from tracks made by hand.

use super::*;
use crate::grid::DecodedCrossing;
use shared::pattern::GridIndex;

/// A flat line at y = 100.5 over some pixels of x, moved down from `step_at` on.
fn track(line: Option<u16>, x: impl Iterator<Item = u32>, step_at: u32, step_px: f64) -> LineTrack {
    let point = |x: u32| LinePoint {
        position: CameraPixel::new(
            f64::from(x) + 0.5,
            100.3 + if x >= step_at { step_px } else { 0.0 },
        ),
        half_width_px: 2.0,
        confidence: 0.9,
    };
    LineTrack {
        axis: Axis::Row,
        line,
        points: x.map(point).collect(),
    }
}

fn crossing(row: u16, column: u16, x: f64) -> DecodedCrossing {
    let corner = |dx, dy| CameraPixel::new(x + dx, 100.3 + dy);
    DecodedCrossing {
        index: GridIndex { row, column },
        centre: corner(0.0, 0.0),
        vertices: [
            corner(-2.0, -2.0),
            corner(2.0, -2.0),
            corner(2.0, 2.0),
            corner(-2.0, 2.0),
        ],
        confidence: 1.0,
    }
}

fn grid(tracks: Vec<LineTrack>, crossings: Vec<DecodedCrossing>) -> DecodedGrid {
    DecodedGrid {
        crossings,
        tracks,
        ..DecodedGrid::default()
    }
}

#[test]
fn a_crossing_zone_is_filled_and_a_gap_beside_it_is_not() {
    let gap_at = |from: u32, to: u32| {
        let x = (10..90).filter(move |x| !(from..to).contains(x));
        let tracks = vec![track(Some(3), x, 1000, 0.0)];
        find_dense_lines(&grid(tracks, vec![crossing(3, 1, 40.0)]))
    };
    let filled = gap_at(36, 44);
    assert_eq!(filled.len(), 1);
    assert_eq!(filled[0].points.len(), 76, "two are taken off each end");
    let cut = gap_at(60, 70);
    assert_eq!(cut.len(), 2);
}

#[test]
fn a_step_cuts_the_line_even_inside_a_crossing() {
    let whole = vec![track(Some(3), 10..90, 50, 4.0)];
    assert_eq!(find_dense_lines(&grid(whole, Vec::new())).len(), 2);
    let x = (10..90).filter(|x| !(36..44).contains(x));
    let gap = vec![track(Some(3), x, 40, 4.0)];
    let lines = find_dense_lines(&grid(gap, vec![crossing(3, 1, 40.0)]));
    assert_eq!(lines.len(), 2, "arms that miss each other are not joined");
}

#[test]
fn an_end_goes_on_to_the_next_step_and_not_where_numbers_meet() {
    let tracks = |step_at| {
        vec![
            track(Some(3), 10..40, 1000, 0.0),
            track(None, 40..90, step_at, 4.0),
        ]
    };
    let known = vec![crossing(3, 0, 10.0), crossing(3, 1, 40.0)];
    let last_x = |lines: &[DenseLine]| lines[0].points.last().unwrap().position.x;
    let lines = find_dense_lines(&grid(tracks(1000), known.clone()));
    assert_eq!(lines.len(), 1);
    assert!(last_x(&lines) > 85.0, "{}", last_x(&lines));
    assert!(lines[0].points.last().unwrap().confidence < 1.0);
    let stepping = find_dense_lines(&grid(tracks(70), known.clone()));
    assert!(last_x(&stepping) < 70.0, "{}", last_x(&stepping));
    let another = crossing(4, 2, 85.0);
    let contested = [known.clone(), vec![another.clone()]].concat();
    let lines = find_dense_lines(&grid(tracks(1000), contested));
    assert!(lines.iter().all(|line| line.line == 3));
    assert!(last_x(&lines) < 40.0, "{}", last_x(&lines));
    let stepping = vec![
        track(Some(3), 10..40, 1000, 0.0),
        track(None, (40..60).chain(70..90), 1000, 0.0),
    ];
    let lines = find_dense_lines(&grid(stepping, [known, vec![another]].concat()));
    let numbers: Vec<u16> = lines.iter().map(|line| line.line).collect();
    assert_eq!(numbers, [3, 4], "a gap parts the two numbers");
}

#[test]
fn a_crossing_without_an_arm_numbers_its_line() {
    let mut alone = grid(vec![track(None, 10..90, 1000, 0.0)], Vec::new());
    assert!(find_dense_lines(&alone).is_empty());
    alone.partial = vec![crossing(3, 1, 12.0)];
    let lines = find_dense_lines(&alone);
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0].line, 3);
}

#[test]
fn crumbs_of_a_line_within_a_crossing_do_not_part_it() {
    let x = (10..90).filter(|x| !(35..39).contains(x) && !(41..45).contains(x));
    let tracks = vec![track(Some(3), x, 1000, 0.0)];
    let lines = find_dense_lines(&grid(tracks, vec![crossing(3, 1, 40.0)]));
    assert_eq!(lines.len(), 1);
}
