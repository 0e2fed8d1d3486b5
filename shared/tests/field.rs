//! Finite fields against the tables of the thesis, and polynomials against their definitions.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up must fail")]

use proptest::prelude::*;
use shared::field::{Element, Field, FieldError, Polynomial, Representation, appendix_a};

fn extension(p: u32, h: &str) -> Field {
    let base = Field::prime(p).unwrap();
    Field::extension(&base, &base.parse(h).unwrap(), 't').unwrap()
}

/// The lines of a table file that are no comments.
fn rows(table: &'static str) -> impl Iterator<Item = &'static str> {
    table.lines().filter(|line| !line.starts_with('#'))
}

#[test]
fn gf27_has_the_elements_of_table_3_3_in_all_four_representations() {
    let gf27 = extension(3, "x^3 + 2x + 1");
    let zero_then_powers =
        std::iter::once(Element::ZERO).chain((0..26).map(|power| gf27.power(power)));
    let shown: Vec<String> = zero_then_powers
        .map(|element| {
            Representation::ALL
                .map(|way| gf27.show(element, way))
                .join("; ")
        })
        .collect();
    let expected: Vec<&str> = rows(include_str!("tables/table_3_3.txt")).collect();
    assert_eq!(shown, expected);
}

#[test]
fn the_fields_of_appendix_b_have_their_printed_tuples_and_logarithms() {
    let tables = [
        (
            extension(2, "x^2 + x + 1"),
            include_str!("tables/appendix_b_gf4.txt"),
        ),
        (
            extension(2, "x^3 + x + 1"),
            include_str!("tables/appendix_b_gf8.txt"),
        ),
        (
            extension(2, "x^4 + x + 1"),
            include_str!("tables/appendix_b_gf16.txt"),
        ),
        (
            extension(2, "x^5 + x^2 + 1"),
            include_str!("tables/appendix_b_gf32.txt"),
        ),
        (
            extension(2, "x^6 + x + 1"),
            include_str!("tables/appendix_b_gf64.txt"),
        ),
        (
            extension(3, "x + 1"),
            include_str!("tables/appendix_b_gf3.txt"),
        ),
        (
            extension(3, "x^2 + x + 2"),
            include_str!("tables/appendix_b_gf9.txt"),
        ),
    ];
    for (field, table) in tables {
        let mut count = 0;
        for row in rows(table) {
            let (tuple, logarithm) = row.split_once(' ').unwrap();
            let element = match logarithm {
                "-oo" => Element::ZERO,
                _ => field.power(logarithm.parse().unwrap()),
            };
            // Appendix B prints the lowest power first.
            let shown: String = field
                .show(element, Representation::Tuple)
                .chars()
                .rev()
                .collect();
            assert_eq!(shown, tuple, "t^{logarithm} of GF({})", field.order());
            assert_eq!(field.show(element, Representation::Logarithm), logarithm);
            count += 1;
        }
        assert_eq!(count, field.order());
    }
}

#[test]
fn gf5_multiplies_as_table_3_2() {
    let gf5 = Field::prime(5).unwrap();
    for a in 0..5 {
        for b in 0..5 {
            let [x, y] = [a, b].map(|index| gf5.element(index).unwrap());
            assert_eq!(gf5.mul(x, y).index(), a * b % 5);
            assert_eq!(gf5.add(x, y).index(), (a + b) % 5);
        }
    }
}

#[test]
fn the_thesiss_sums_and_products_in_gf27_hold() {
    let gf27 = extension(3, "x^3 + 2x + 1");
    let element = |text| gf27.from_polynomial(&gf27.base().parse(text).unwrap());
    assert_eq!(
        gf27.add(element("x^2 + x + 1"), element("x^2 + 2x")),
        element("2x^2 + 1")
    );
    assert_eq!(
        gf27.add(element("x + 1"), element("2x^2 + 2x + 2")),
        element("2x^2")
    );
    assert_eq!(
        gf27.mul(element("x^2 + 2x"), element("2x^2 + 1")),
        element("x + 2")
    );
}

#[test]
fn all_42_polynomials_of_appendix_a_are_primitive_and_irreducible() {
    let mut count = 0;
    for line in appendix_a::listed() {
        let field = appendix_a::field(line.order).unwrap();
        let h = appendix_a::primitive_polynomial(&field, line.degree).unwrap();
        assert_eq!(h.degree(), Some(line.degree), "{line:?}");
        assert!(
            h.is_monic() && h.is_irreducible(&field).unwrap(),
            "{line:?}"
        );
        let full = u64::from(line.order).pow(line.degree as u32) - 1;
        assert_eq!(h.order_of_x(&field).unwrap(), Some(full), "{line:?}");
        count += 1;
    }
    assert_eq!(count, 42);
}

#[test]
fn irreducible_and_primitive_polynomials_are_as_many_as_theory_counts() {
    // (q, degree, irreducible, primitive) of all monic polynomials: the necklace formula and
    // phi(q^m - 1) / m.
    let counts = [
        (2, 4, 3, 2),
        (2, 6, 9, 6),
        (3, 3, 8, 4),
        (3, 4, 18, 8),
        (4, 3, 20, 12),
    ];
    for (q, degree, irreducible, primitive) in counts {
        let field = appendix_a::field(q).unwrap();
        let mut found = (0, 0);
        for index in 0..(q as usize).pow(degree) {
            let digit = |k| {
                field
                    .element(index / (q as usize).pow(k) % q as usize)
                    .unwrap()
            };
            let coefficients = (0..degree).map(digit).chain([Element::ONE]).collect();
            let h = Polynomial::new(coefficients);
            found.0 += usize::from(h.is_irreducible(&field).unwrap());
            found.1 += usize::from(h.is_primitive(&field).unwrap());
        }
        assert_eq!(
            found,
            (irreducible, primitive),
            "degree {degree} over GF({q})"
        );
    }
}

#[test]
fn a_tower_over_gf4_is_a_field_that_contains_gf4() {
    let gf4 = appendix_a::field(4).unwrap();
    let h = appendix_a::primitive_polynomial(&gf4, 3).unwrap();
    let gf64 = Field::extension(&gf4, &h, 't').unwrap();
    assert_eq!(
        (gf64.order(), gf64.degree(), gf64.characteristic()),
        (64, 3, 2)
    );
    for a in gf4.elements() {
        for b in gf4.elements() {
            assert_eq!(gf64.add(a, b), gf4.add(a, b));
            assert_eq!(gf64.mul(a, b), gf4.mul(a, b));
        }
    }
    assert_eq!(
        gf64.show(gf64.power(3), Representation::Polynomial),
        "x^2 + x + w"
    );
    assert_eq!(gf64.show(gf64.power(3), Representation::Tuple), "1 1 w");
}

#[test]
fn what_generates_no_field_is_refused() {
    assert_eq!(Field::prime(4), Err(FieldError::NotPrime { number: 4 }));
    assert_eq!(Field::prime(0), Err(FieldError::NotPrime { number: 0 }));
    assert!(matches!(
        Field::prime(65537),
        Err(FieldError::TooLarge { .. })
    ));
    let gf2 = Field::prime(2).unwrap();
    let extend = |h, letter| Field::extension(&gf2, &gf2.parse(h).unwrap(), letter);
    // Reducible; irreducible but not primitive; constant; too large; a letter that is taken.
    assert!(matches!(
        extend("x^2 + 1", 't'),
        Err(FieldError::NotPrimitive { .. })
    ));
    assert!(matches!(
        extend("x^4 + x^3 + x^2 + x + 1", 't'),
        Err(FieldError::NotPrimitive { .. })
    ));
    assert!(matches!(
        extend("1", 't'),
        Err(FieldError::NotPrimitive { .. })
    ));
    assert!(matches!(
        extend("x^17 + x^3 + 1", 't'),
        Err(FieldError::TooLarge { .. })
    ));
    assert_eq!(
        extend("x^2 + x + 1", 'x'),
        Err(FieldError::BadLetter { letter: 'x' })
    );
}

#[test]
fn a_wrong_text_is_refused_with_its_place() {
    let gf4 = appendix_a::field(4).unwrap();
    let place = |text: &str| match gf4.parse(text) {
        Err(FieldError::Notation { at, problem, .. }) => (at, problem),
        other => panic!("{text:?} gave {other:?}"),
    };
    assert_eq!(place(""), (0, "expected a number, x, a letter or ("));
    assert_eq!(place("x + "), (4, "expected a number, x, a letter or ("));
    assert_eq!(place("x + y"), (4, "expected a number, x, a letter or ("));
    assert_eq!(place("x ) 1"), (2, "expected + or the end"));
    assert_eq!(place("w(x + 1"), (7, "expected + or )"));
    assert_eq!(
        place("2x"),
        (1, "the number is not below the characteristic")
    );
    assert_eq!(place("x^65"), (4, "the degree is too high"));
    assert_eq!(place("x^"), (2, "expected a number of few digits"));
    assert_eq!(place(&"(".repeat(600)).1, "the text is too long");
}

/// Fields of each kind: prime, extension, tower.
fn any_field() -> impl Strategy<Value = Field> {
    prop::sample::select(vec![
        Field::prime(2).unwrap(),
        Field::prime(7).unwrap(),
        extension(3, "x^3 + 2x + 1"),
        extension(2, "x^6 + x + 1"),
        appendix_a::field(8).unwrap(),
        {
            let gf4 = appendix_a::field(4).unwrap();
            Field::extension(&gf4, &gf4.parse("x^4 + x^2 + wx + w^2").unwrap(), 't').unwrap()
        },
    ])
}

fn field_and_elements() -> impl Strategy<Value = (Field, [Element; 3])> {
    (any_field(), any::<[u16; 3]>()).prop_map(|(field, indices)| {
        let order = field.order() as usize;
        let elements = indices.map(|i| field.element(usize::from(i) % order).unwrap());
        (field, elements)
    })
}

fn field_and_polynomials() -> impl Strategy<Value = (Field, [Polynomial; 2])> {
    let coefficients = || prop::collection::vec(any::<u16>(), 0..12);
    (any_field(), coefficients(), coefficients()).prop_map(|(field, a, b)| {
        let order = field.order() as usize;
        let element = |i: u16| field.element(usize::from(i) % order).unwrap();
        let polynomials =
            [a, b].map(|indices| Polynomial::new(indices.into_iter().map(element).collect()));
        (field, polynomials)
    })
}

proptest! {
    #[test]
    fn the_axioms_of_a_field_hold((f, [a, b, c]) in field_and_elements()) {
        prop_assert_eq!(f.add(a, b), f.add(b, a));
        prop_assert_eq!(f.mul(a, b), f.mul(b, a));
        prop_assert_eq!(f.add(f.add(a, b), c), f.add(a, f.add(b, c)));
        prop_assert_eq!(f.mul(f.mul(a, b), c), f.mul(a, f.mul(b, c)));
        prop_assert_eq!(f.mul(f.add(a, b), c), f.add(f.mul(a, c), f.mul(b, c)));
        prop_assert_eq!(f.add(a, Element::ZERO), a);
        prop_assert_eq!(f.mul(a, Element::ONE), a);
        prop_assert_eq!(f.add(f.sub(a, b), b), a);
        prop_assert_eq!(f.add(a, f.neg(a)), Element::ZERO);
        match f.inverse(a) {
            Some(inverse) => prop_assert_eq!(f.mul(a, inverse), Element::ONE),
            None => prop_assert_eq!(a, Element::ZERO),
        }
    }

    #[test]
    fn a_power_is_a_repeated_product((f, [a, ..]) in field_and_elements(), n in 0_u64..40) {
        let product = (0..n).fold(Element::ONE, |product, _| f.mul(product, a));
        prop_assert_eq!(f.pow(a, n), product);
    }

    #[test]
    fn every_representation_leads_back_to_the_element((f, [a, ..]) in field_and_elements()) {
        prop_assert_eq!(f.from_tuple(&f.to_tuple(a)), Some(a));
        prop_assert_eq!(f.from_polynomial(&f.to_polynomial(a)), a);
        prop_assert_eq!(f.log(a).map_or(Element::ZERO, |log| f.power(u64::from(log))), a);
    }

    #[test]
    fn a_polynomial_is_quotient_times_divisor_plus_remainder(
        (f, [a, b]) in field_and_polynomials(),
    ) {
        match a.div_rem(&b, &f) {
            Some((quotient, remainder)) => {
                prop_assert!(remainder.degree() < b.degree());
                prop_assert_eq!(quotient.mul(&b, &f).add(&remainder, &f), a);
            }
            None => prop_assert_eq!(b, Polynomial::default()),
        }
    }

    #[test]
    fn the_greatest_common_divisor_divides_both((f, [a, b]) in field_and_polynomials()) {
        let gcd = a.gcd(&b, &f);
        prop_assert!(gcd.is_monic() || gcd == Polynomial::default());
        for dividend in [a, b] {
            let remainder = dividend.rem(&gcd, &f);
            prop_assert!(remainder.is_none() || remainder == Some(Polynomial::default()));
        }
    }

    #[test]
    fn a_product_has_the_product_of_the_values(
        (f, [a, b]) in field_and_polynomials(), point in any::<u16>(),
    ) {
        let point = f.element(usize::from(point) % f.order() as usize).unwrap();
        let product = f.mul(a.evaluate(point, &f), b.evaluate(point, &f));
        prop_assert_eq!(a.mul(&b, &f).evaluate(point, &f), product);
    }

    #[test]
    fn a_polynomial_is_read_back_from_its_text((f, [a, _]) in field_and_polynomials()) {
        prop_assert_eq!(f.parse(&a.to_text(&f)), Ok(a));
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[ xw0-9a^+()é]{0,40}|\\PC{0,40}") {
        let read = appendix_a::field(4).unwrap().parse(&text);
        let place = match read {
            Err(FieldError::Notation { at, .. }) => at,
            _ => 0,
        };
        prop_assert!(text.is_char_boundary(place));
    }
}
