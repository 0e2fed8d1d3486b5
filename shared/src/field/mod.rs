//! Finite (Galois) fields: the arithmetic behind the colour code.
//!
//! A field is a set of numbers that can be added, subtracted, multiplied and divided. The grid has
//! four colours, so its code needs a field of four elements, GF(4). This module makes the prime
//! fields GF(p) ([`Field::prime`]), every extension GF(q^m) of a field GF(q) it has already made
//! ([`Field::extension`]), and the [`Polynomial`]s over them.
//!
//! Source: section 3.1.1 and Appendices A and B of the thesis; R. Lidl and H. Niederreiter,
//! "Introduction to Finite Fields and their Applications" (1994).
//!
//! # GF(4) by hand
//! The integers modulo 4 are no field: 2 x 2 = 0, so 2 has no inverse. Take instead the polynomials
//! of degree 0 and 1 over GF(2): `0`, `1`, `x` and `x + 1`. Add them modulo 2, and multiply them
//! modulo h(x) = x^2 + x + 1. There `x^2` is `x + 1`, since x^2 = h(x) + (x + 1).
//!
//! ```
//! use shared::field::{Field, FieldError};
//!
//! let gf2 = Field::prime(2)?;
//! let h = gf2.parse("x^2 + x + 1")?;
//! let gf4 = Field::extension(&gf2, &h, 'w')?;
//! let [zero, one, w, w2] = [0, 1, 2, 3].map(|index| gf4.element(index).unwrap());
//!
//! // The letter w names the element x. Its powers run through all elements but 0:
//! assert_eq!(gf4.mul(w, w), w2); //                  x times x is x + 1
//! assert_eq!(gf4.mul(w, w2), one); //                x times (x + 1) is x^2 + x, which is 1
//! assert_eq!(gf4.name(w2), "w^2");
//!
//! // Addition is that of the polynomials, modulo 2:
//! assert_eq!(gf4.add(one, w), w2); //                1 + x is x + 1
//! assert_eq!(gf4.add(w, w), zero); //                every element is its own negative
//!
//! // Division multiplies by the inverse, which only 0 lacks:
//! assert_eq!(gf4.inverse(w), Some(w2));
//! assert_eq!(gf4.inverse(zero), None);
//! # Ok::<(), FieldError>(())
//! ```
//!
//! # GF(27) in four ways
//! Every element can be written as a tuple, a polynomial, a power of t and a logarithm. This is the
//! row of t^4 in Table 3.3:
//!
//! ```
//! use shared::field::{Field, FieldError, Representation};
//!
//! let gf3 = Field::prime(3)?;
//! let gf27 = Field::extension(&gf3, &gf3.parse("x^3 + 2x + 1")?, 't')?;
//! let element = gf27.power(4);
//! let row = Representation::ALL.map(|way| gf27.show(element, way));
//! assert_eq!(row, ["120", "x^2 + 2x", "t^4", "4"]);
//! # Ok::<(), FieldError>(())
//! ```

mod finite;

mod construction;

mod representation;

mod polynomial;

mod notation;

mod primitive;

pub mod appendix_a;

pub use finite::{Element, Field, MAX_ORDER};
pub use notation::MAX_DEGREE;
pub use polynomial::Polynomial;
pub use primitive::MAX_RESIDUES;
pub use representation::Representation;

/// Why a field or a polynomial cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// Only a prime number of integers form a field.
    #[error("the integers modulo {number} are no field: {number} is not prime")]
    NotPrime {
        /// The number of elements that was asked for.
        number: u32,
    },
    /// The field, or the remainders modulo a polynomial, are more than the tables can hold.
    #[error("{base}^{degree} elements are too many; at most {limit} are supported")]
    TooLarge {
        /// Order of the field that the coefficients come from.
        base: u32,
        /// Degree of the polynomial.
        degree: usize,
        /// The greatest number of elements.
        limit: u64,
    },
    /// The polynomial cannot generate an extension whose elements are the powers of x.
    #[error("{polynomial} is not a monic primitive polynomial over GF({order})")]
    NotPrimitive {
        /// The polynomial, as text.
        polynomial: String,
        /// Order of the field of its coefficients.
        order: u32,
    },
    /// The letter would be mistaken for something else in a polynomial.
    #[error("{letter:?} cannot name an element; choose a letter other than x")]
    BadLetter {
        /// The letter that was asked for.
        letter: char,
    },
    /// The text is not a polynomial over this field.
    #[error("cannot read {text:?} as a polynomial over GF({order}): at byte {at}, {problem}")]
    Notation {
        /// The whole text.
        text: String,
        /// Order of the field of the coefficients.
        order: u32,
        /// Where the problem was found, in bytes from the start.
        at: usize,
        /// What was found or expected there.
        problem: &'static str,
    },
    /// Appendix A does not list this field or degree.
    #[error("Appendix A has no polynomial of degree {degree} over GF({order})")]
    NotListed {
        /// Order of the field of the coefficients.
        order: u32,
        /// Degree of the polynomial.
        degree: usize,
    },
}
