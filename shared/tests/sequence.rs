//! Sequences against the figures of the thesis, and its properties 1 to 7b over several fields.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up must fail")]

use proptest::prelude::*;
use shared::field::{Element, Field, Polynomial, appendix_a};
use shared::sequence::{FeedbackRegister, ModifiedRegister, Recurrence, Sequence, SequenceError};
use std::collections::HashMap;

fn sequence(order: u32, degree: usize) -> (Field, Polynomial, Sequence) {
    let field = appendix_a::field(order).unwrap();
    let h = appendix_a::primitive_polynomial(&field, degree).unwrap();
    let sequence = Sequence::new(&field, &h).unwrap();
    (field, h, sequence)
}

fn digits(symbols: &[Element]) -> String {
    symbols
        .iter()
        .map(|symbol| symbol.index().to_string())
        .collect()
}

fn shifted(symbols: &[Element], shift: usize) -> Vec<Element> {
    let mut shifted = symbols.to_vec();
    shifted.rotate_left(shift % symbols.len());
    shifted
}

#[test]
fn both_registers_run_through_the_26_steps_of_figure_3_4() {
    let gf3 = Field::prime(3).unwrap();
    let recurrence = Recurrence::new(&gf3, &gf3.parse("x^3 + 2x + 1").unwrap()).unwrap();
    let mut feedback = FeedbackRegister::new(&recurrence);
    let mut modified = ModifiedRegister::new(&recurrence);
    let mut output = String::new();
    let figure = include_str!("tables/figure_3_4.txt");
    let rows: Vec<&str> = figure
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    assert_eq!(rows.len(), 26);
    for (step, row) in rows.into_iter().enumerate() {
        let states = (digits(modified.state()), digits(feedback.state()));
        let symbol = modified.step();
        assert_eq!(feedback.step(), symbol);
        output += &digits(&[symbol]);
        assert_eq!(format!("{step} {output} {} {}", states.0, states.1), row);
    }
}

#[test]
fn the_gf4_example_has_the_symbols_of_the_thesis() {
    let (gf4, _, sequence) = sequence(4, 2);
    let names: Vec<String> = sequence.symbols().iter().map(|&e| gf4.name(e)).collect();
    assert_eq!(names.join(" "), "0 1 1 w^2 1 0 w w 1 w 0 w^2 w^2 w w^2");
}

#[test]
fn the_gf2_sequence_of_fifteen_is_the_printed_one_read_backwards() {
    // Chapter 4 of the thesis prints the same circle of symbols in the other direction.
    let (_, _, sequence) = sequence(2, 4);
    assert_eq!(digits(sequence.symbols()), "000100110101111");
    let printed: String = "000111101011001".chars().rev().collect();
    assert_eq!(digits(&shifted(sequence.symbols(), 3)), printed);
}

#[test]
fn the_modified_register_shows_the_successive_powers_of_x() {
    let (gf4, h, sequence) = sequence(4, 3);
    let gf64 = Field::extension(&gf4, &h, 't').unwrap();
    let mut register = ModifiedRegister::new(sequence.recurrence());
    for log in 0..63 {
        assert_eq!(
            gf64.from_tuple(register.state()).and_then(|e| gf64.log(e)),
            Some(log)
        );
        register.step();
    }
}

#[test]
fn stepping_back_undoes_a_step() {
    let (_, _, sequence) = sequence(8, 2);
    let mut register = FeedbackRegister::new(sequence.recurrence());
    for _ in 0..63 {
        let before = register.state().to_vec();
        register.step();
        let newest = register.state()[1];
        assert_eq!(register.step_back(), newest);
        assert_eq!(register.state(), before);
        register.step();
    }
}

#[test]
fn a_polynomial_without_full_period_is_refused() {
    let gf2 = Field::prime(2).unwrap();
    for h in ["x^4 + x^3 + x^2 + x + 1", "x^4 + x", "x^2 + 1", "1", "0"] {
        let made = Sequence::new(&gf2, &gf2.parse(h).unwrap());
        assert!(
            matches!(made, Err(SequenceError::NotPrimitive { .. })),
            "{h}: {made:?}"
        );
    }
    let long = gf2.parse("x^31 + x^3 + 1").unwrap();
    assert!(matches!(
        Sequence::new(&gf2, &long),
        Err(SequenceError::TooLong { .. })
    ));
    let (_, _, sequence) = sequence(4, 2);
    let state = [Element::ONE];
    let register = FeedbackRegister::at(sequence.recurrence(), &state);
    assert_eq!(register.err(), Some(SequenceError::BadState { cells: 2 }));
}

/// Sequences over each field of Appendix A, of at most about a thousand symbols.
fn any_code() -> impl Strategy<Value = (u32, usize)> {
    prop::sample::select(vec![
        (2, 2),
        (2, 4),
        (2, 5),
        (2, 8),
        (3, 2),
        (3, 3),
        (3, 5),
        (4, 2),
        (4, 3),
        (4, 4),
        (8, 2),
        (8, 3),
    ])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Properties 1 and 3: a cyclic shift is what the register gives from another state, and every
    /// window but zeros is seen exactly once.
    #[test]
    fn every_shift_is_a_sequence_and_every_window_occurs_once(
        (q, m) in any_code(), shift in 0_usize..5000,
    ) {
        let (_, _, sequence) = sequence(q, m);
        let state = sequence.window(shift);
        let mut register = FeedbackRegister::at(sequence.recurrence(), &state).unwrap();
        let period = sequence.symbols().len();
        let windows: std::collections::HashSet<_> =
            (0..period).map(|index| sequence.window(index)).collect();
        let output: Vec<Element> = (0..period).map(|_| register.step()).collect();
        prop_assert_eq!(output, shifted(sequence.symbols(), shift));
        prop_assert_eq!(windows.len(), period);
        prop_assert_eq!(period, (q as usize).pow(m as u32) - 1);
        prop_assert!(!windows.contains(&vec![Element::ZERO; m]));
    }

    /// Property 2: h(x) is 0 where x means "one symbol later".
    #[test]
    fn the_recurrence_holds_around_the_circle((q, m) in any_code(), start in 0_usize..5000) {
        let (field, h, sequence) = sequence(q, m);
        let circle = sequence.symbols().iter().cycle().skip(start % sequence.symbols().len());
        let sum = h.coefficients().iter().zip(circle).fold(Element::ZERO, |sum, (&c, &b)| {
            field.add(sum, field.mul(c, b))
        });
        prop_assert_eq!(sum, Element::ZERO);
    }

    /// Property 4: 0 occurs q^(m-1) - 1 times, every other element q^(m-1) times.
    #[test]
    fn all_symbols_but_zero_are_equally_frequent((q, m) in any_code()) {
        let (field, _, sequence) = sequence(q, m);
        let often = (q as usize).pow(m as u32 - 1);
        for element in field.elements() {
            let count = sequence.symbols().iter().filter(|&&symbol| symbol == element).count();
            prop_assert_eq!(count, often - usize::from(element == Element::ZERO));
        }
    }

    /// Properties 5 and 6: the sum of two shifts is a third, or zeros.
    #[test]
    fn the_sum_of_two_shifts_is_a_shift(
        (q, m) in any_code(), one in 0_usize..5000, other in 0_usize..5000,
    ) {
        let (field, _, sequence) = sequence(q, m);
        let [a, b] = [one, other].map(|shift| shifted(sequence.symbols(), shift));
        let sum: Vec<Element> = a.iter().zip(&b).map(|(&a, &b)| field.add(a, b)).collect();
        let start = (0..sum.len()).find(|&index| sequence.window(index) == sum[..m]);
        match start {
            Some(shift) => prop_assert_eq!(sum, shifted(sequence.symbols(), shift)),
            None => prop_assert!(sum.iter().all(|&symbol| symbol == Element::ZERO)),
        }
    }

    /// Property 7a: the sequence is b, g b, g^2 b, .. with b of length (q^m - 1) / (q - 1) and g a
    /// primitive element of GF(q), here (-1)^m h(0).
    #[test]
    fn the_sequence_is_made_of_multiples_of_its_first_block((q, m) in any_code()) {
        let (field, h, sequence) = sequence(q, m);
        let length = sequence.symbols().len() / (q as usize - 1);
        let sign = field.pow(field.neg(Element::ONE), m as u64);
        let factor = field.mul(sign, h.coefficient(0));
        let powers: std::collections::HashSet<_> =
            (0..u64::from(q) - 1).map(|n| field.pow(factor, n)).collect();
        prop_assert_eq!(powers.len(), q as usize - 1);
        let blocks: Vec<&[Element]> = sequence.symbols().chunks(length).collect();
        for pair in blocks.windows(2) {
            let multiple: Vec<Element> = pair[0].iter().map(|&b| field.mul(b, factor)).collect();
            prop_assert_eq!(&multiple, pair[1]);
        }
    }

    /// Property 7b: how often each pair of a symbol and the one `shift` later occurs.
    #[test]
    fn pairs_at_a_distance_are_equally_frequent((q, m) in any_code(), shift in 0_usize..5000) {
        let (field, h, sequence) = sequence(q, m);
        let later = shifted(sequence.symbols(), shift);
        let mut counts: HashMap<(Element, Element), usize> = HashMap::new();
        for (&a, &b) in sequence.symbols().iter().zip(&later) {
            *counts.entry((a, b)).or_default() += 1;
        }
        let q_to = |n: usize| (q as usize).pow(n as u32);
        let block = sequence.symbols().len() / (q as usize - 1);
        let multiple = shift.is_multiple_of(block).then(|| {
            let sign = field.pow(field.neg(Element::ONE), m as u64);
            field.pow(field.mul(sign, h.coefficient(0)), (shift / block) as u64)
        });
        for a in field.elements() {
            for b in field.elements() {
                let often = match multiple {
                    Some(factor) if b == field.mul(a, factor) => q_to(m - 1),
                    Some(_) => 0,
                    None => q_to(m - 2),
                };
                let zeros = usize::from((a, b) == (Element::ZERO, Element::ZERO));
                prop_assert_eq!(counts.get(&(a, b)).copied().unwrap_or(0), often - zeros);
            }
        }
    }
}
