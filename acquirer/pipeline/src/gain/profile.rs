//! The gain along a stripe of the picture: enough to see how wide the lines are, before any gain image is made.

use std::ops::Range;

use pulp::Arch;
use shared::pattern::Axis;

use super::filter::{GainFilter, Inputs, RowFilter};
use crate::line_light::LineLight;

/// A stripe of the picture across lines of one family: picture rows for steep lines, columns for flat ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    /// The lines that cross it.
    pub(crate) family: Axis,
    /// First pixel along those lines.
    pub(crate) at: usize,
    /// Pixels along them that are averaged.
    pub(crate) thick: usize,
}

/// What profiles are made in, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct ProfileBuffers {
    sums: [Vec<f32>; 3],
    blacks: [Vec<f32>; 3],
    whites: [Vec<f32>; 3],
    power: Vec<f32>,
}

/// The gain along a stripe of the picture, one value per camera pixel across the lines.
pub(crate) fn find_profile(
    light: &LineLight<'_>,
    filter: &GainFilter,
    band: Band,
    (buffers, profile): (&mut ProfileBuffers, &mut Vec<f32>),
) {
    let length = match band.family {
        Axis::Column => light.width(),
        Axis::Row => light.height(),
    };
    let ProfileBuffers {
        sums,
        blacks,
        whites,
        power,
    } = buffers;
    for values in [&mut *sums, &mut *blacks, &mut *whites]
        .into_iter()
        .flatten()
        .chain([power, &mut *profile])
    {
        values.clear();
        values.resize(length, 0.0);
    }
    let share = 1.0 / band.thick as f32;
    match band.family {
        Axis::Column => {
            for y in band.at..band.at + band.thick {
                light.response.add_row_of(light.frames, y, sums);
                for c in 0..3 {
                    add(light.black.channels[c].row(y), share, &mut blacks[c]);
                    add(light.white[c].row(y), share, &mut whites[c]);
                }
            }
        }
        Axis::Row => {
            let columns = band.at..band.at + band.thick;
            let first = (0..length).map(|y| y * light.width() + columns.start);
            light.looker().fetch(first);
            for y in 0..length {
                let mut sum = [0.0; 3];
                light
                    .response
                    .add_piece(light.frames, (y, columns.clone()), &mut sum);
                let [black, white] = means(light, (y, columns.clone()));
                for c in 0..3 {
                    sums[c][y] = sum[c];
                    blacks[c][y] = black[c];
                    whites[c][y] = white[c];
                }
            }
        }
    }
    Arch::new().dispatch(RowFilter {
        filter,
        mean: filter.mean_of(light.frames.len(), band.thick),
        inputs: Inputs {
            sums: sums.each_ref().map(|channel| &channel[..]),
            blacks: blacks.each_ref().map(|channel| &channel[..]),
            whites: whites.each_ref().map(|channel| &channel[..]),
        },
        gain: profile,
        power: &mut buffers.power,
    });
}

/// Mean black and white light of some neighbouring pixels of one row.
fn means(light: &LineLight<'_>, (y, columns): (usize, Range<usize>)) -> [[f32; 3]; 2] {
    let share = 1.0 / columns.len() as f32;
    let mut means = [[0.0; 3]; 2];
    for x in columns {
        let at = y * light.width() + x;
        let [black, white] = match light.levels.get(at) {
            Some(level) => [level.black(), level.white()],
            None => {
                let [black, white] = [&light.black.channels, light.white];
                [black, white].map(|channels| channels.at(at))
            }
        };
        for c in 0..3 {
            means[0][c] += share * black[c];
            means[1][c] += share * white[c];
        }
    }
    means
}

/// Adds a share of each value.
fn add(values: &[f32], share: f32, sums: &mut [f32]) {
    let sums = sums.iter_mut().zip(values);
    sums.for_each(|(sum, value)| *sum += share * value);
}
