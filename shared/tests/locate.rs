//! Windows located by all three methods, in one dimension and in two.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up must fail")]

use proptest::prelude::*;
use shared::field::{Element, appendix_a};
use shared::sequence::{
    Alphabet, GridLocator, GridWindowError, LineLocator, Locator, Method, Sequence, Symbol,
    WindowError, WindowOrigin, line_symbols, window_order,
};
use std::num::NonZeroUsize;

const LINES: [usize; 5] = [15, 31, 63, 127, 255];

fn methods() -> Vec<Method> {
    let milestones = [1, 7, 16, 10_000].map(|spacing| Method::Milestones {
        spacing: NonZeroUsize::new(spacing).unwrap(),
    });
    [Method::Serial, Method::Table]
        .into_iter()
        .chain(milestones)
        .collect()
}

fn sequence(order: u32, degree: usize) -> Sequence {
    let field = appendix_a::field(order).unwrap();
    Sequence::new(
        &field,
        &appendix_a::primitive_polynomial(&field, degree).unwrap(),
    )
    .unwrap()
}

#[test]
fn all_methods_find_every_window_of_every_code() {
    let codes = [
        (4, 2),
        (4, 3),
        (4, 4),
        (2, 4),
        (2, 5),
        (2, 6),
        (2, 7),
        (2, 8),
        (3, 3),
    ];
    for (order, degree) in codes {
        let sequence = sequence(order, degree);
        // The circle, written out: an independent source of windows.
        let circle = [sequence.symbols(), sequence.symbols()].concat();
        for method in methods() {
            let locator = Locator::new(&sequence, method);
            for index in 0..sequence.symbols().len() {
                let window = &circle[index..index + degree];
                assert_eq!(
                    locator.locate(window),
                    Ok(index),
                    "{method:?} GF({order}) {degree}"
                );
            }
        }
    }
}

#[test]
fn a_window_outside_the_code_is_rejected_by_all_methods() {
    let sequence = sequence(4, 3);
    let [one, foreign] = [1, 4].map(Element::from_index);
    for method in methods() {
        let locator = Locator::new(&sequence, method);
        assert_eq!(
            locator.locate(&[Element::ZERO; 3]),
            Err(WindowError::AllZero)
        );
        for found in [0, 2, 4] {
            let refused = locator.locate(&vec![one; found]);
            assert_eq!(
                refused,
                Err(WindowError::WrongLength { expected: 3, found })
            );
        }
        let refused = locator.locate(&[one, foreign, one]);
        assert_eq!(
            refused,
            Err(WindowError::UnknownSymbol {
                symbol: 4,
                place: 1
            })
        );
    }
}

#[test]
fn every_window_of_lines_is_found_on_every_grid() {
    for alphabet in [Alphabet::Two, Alphabet::Four] {
        for lines in LINES {
            let symbols = line_symbols(alphabet, lines).unwrap();
            let order = window_order(alphabet, lines).unwrap();
            let locator = LineLocator::new(alphabet, lines, Method::Table).unwrap();
            for (index, window) in symbols.windows(order).enumerate() {
                assert_eq!(locator.locate(window), Ok(index), "{alphabet:?} {lines}");
            }
        }
    }
}

#[test]
fn a_window_beyond_the_last_line_is_rejected() {
    // 31 lines carry the first 31 of 63 symbols: the other windows exist, but not on this grid.
    let symbols = line_symbols(Alphabet::Four, 63).unwrap();
    let grid = GridLocator::new(Alphabet::Four, 31, 63).unwrap();
    for (index, window) in symbols.windows(3).enumerate() {
        let located = grid.locate(window, &symbols[..3]);
        let expected = if index + 3 <= 31 {
            Ok(WindowOrigin {
                row: index,
                column: 0,
            })
        } else {
            Err(GridWindowError::Rows(WindowError::BeyondEnd {
                start: index,
                lines: 31,
            }))
        };
        assert_eq!(located, expected);
    }
}

#[test]
fn a_window_from_the_last_line_round_to_the_first_is_rejected() {
    let symbols = line_symbols(Alphabet::Four, 15).unwrap();
    let locator = LineLocator::new(Alphabet::Four, 15, Method::Serial).unwrap();
    let refused = locator.locate(&[symbols[14], symbols[0]]);
    assert_eq!(
        refused,
        Err(WindowError::BeyondEnd {
            start: 14,
            lines: 15
        })
    );
}

proptest! {
    #[test]
    fn rows_and_columns_are_located_together(
        four in any::<bool>(), rows in prop::sample::select(LINES.to_vec()),
        columns in prop::sample::select(LINES.to_vec()), row in 0_usize..255,
        column in 0_usize..255,
    ) {
        let alphabet = if four { Alphabet::Four } else { Alphabet::Two };
        let window_at = |lines, at: usize| {
            let order = window_order(alphabet, lines).unwrap();
            let start = at % (lines - order + 1);
            (start, line_symbols(alphabet, lines).unwrap()[start..start + order].to_vec())
        };
        let (row, row_window) = window_at(rows, row);
        let (column, column_window) = window_at(columns, column);
        let grid = GridLocator::new(alphabet, rows, columns).unwrap();
        let located = grid.locate(&row_window, &column_window);
        prop_assert_eq!(located, Ok(WindowOrigin { row, column }));
    }

    #[test]
    fn no_window_makes_a_locator_panic(
        window in prop::collection::vec(any::<u8>().prop_map(|s| Symbol(s % 6)), 0..6),
        lines in prop::sample::select(LINES.to_vec()),
    ) {
        let symbols = line_symbols(Alphabet::Four, lines).unwrap();
        let locator = LineLocator::new(Alphabet::Four, lines, Method::Table).unwrap();
        let found = symbols.windows(window_order(Alphabet::Four, lines).unwrap())
            .position(|line_window| line_window == window);
        prop_assert_eq!(locator.locate(&window).ok(), found);
    }
}
