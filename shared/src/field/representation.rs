//! The four ways to write an element of an extension field GF(q^m): a tuple of m elements of GF(q),
//! a polynomial in x of degree below m, a power of the generator, and a logarithm.
//!
//! The first two say what the element is, the last two where it stands among the powers of x. To
//! go from one pair to the other is the whole of locating a window in a sequence.
//!
//! Source: section 3.1.1.1 of the thesis (Table 3.3) and its Appendix B.

use super::construction::index_of;
use super::notation::power_text;
use super::{Element, Field, Polynomial};

/// One of the four ways to write an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Representation {
    /// The m coefficients, highest power first, as in Table 3.3. (Appendix B has the lowest first.)
    Tuple,
    /// A polynomial in x of degree below m.
    Polynomial,
    /// A power of the field's letter, or 0.
    Power,
    /// The exponent of that power; `-oo` for 0.
    Logarithm,
}

impl Representation {
    /// All four, in the order of Table 3.3's columns.
    pub const ALL: [Self; 4] = [Self::Tuple, Self::Polynomial, Self::Power, Self::Logarithm];
}

impl Field {
    /// The element as text, in one of the four ways.
    #[must_use]
    pub fn show(&self, element: Element, representation: Representation) -> String {
        match representation {
            Representation::Tuple => self.tuple_text(element),
            Representation::Polynomial => self.to_polynomial(element).to_text(self.base()),
            Representation::Power => match self.log(element) {
                Some(log) => power_text(self.letter, log as usize),
                None => "0".to_owned(),
            },
            Representation::Logarithm => self
                .log(element)
                .map_or("-oo".to_owned(), |log| log.to_string()),
        }
    }

    /// The element as m elements of the base field, highest power first.
    #[must_use]
    pub fn to_tuple(&self, element: Element) -> Vec<Element> {
        let order = self.base().order();
        let mut rest = u32::from(element.0);
        let mut tuple = vec![Element::ZERO; self.degree()];
        for digit in tuple.iter_mut().rev() {
            // Below the base field's order, which is at most that of this field.
            *digit = Element((rest % order) as u16);
            rest /= order;
        }
        tuple
    }

    /// The element that m elements of the base field, highest power first, stand for. None if they
    /// are not m, or one is not in the base field.
    ///
    /// With [`Field::log`] this is the table that turns a tuple into its logarithm.
    #[must_use]
    pub fn from_tuple(&self, tuple: &[Element]) -> Option<Element> {
        let fits = tuple.len() == self.degree() && tuple.iter().all(|&e| self.base().contains(e));
        let polynomial = Polynomial::new(tuple.iter().rev().copied().collect());
        fits.then(|| index_of(&polynomial, self.base().order()))
    }

    /// The element as a polynomial over the base field, of degree below m.
    #[must_use]
    pub fn to_polynomial(&self, element: Element) -> Polynomial {
        Polynomial::new(self.to_tuple(element).into_iter().rev().collect())
    }

    /// The element that a polynomial over the base field stands for: its remainder modulo h(x), or
    /// its constant term in a prime field.
    #[must_use]
    pub fn from_polynomial(&self, polynomial: &Polynomial) -> Element {
        let remainder = self
            .extends
            .as_ref()
            .and_then(|e| polynomial.rem(&e.modulus, &e.base));
        remainder.map_or(polynomial.coefficient(0), |r| {
            index_of(&r, self.base().order())
        })
    }

    /// The tuple as text: digits side by side; names with spaces between them over GF(4) and GF(8).
    fn tuple_text(&self, element: Element) -> String {
        let names: Vec<String> = self
            .to_tuple(element)
            .into_iter()
            .map(|digit| self.base().name(digit))
            .collect();
        let short = self.base().extends.is_none() && self.base().order() <= 10;
        names.join(if short { "" } else { " " })
    }
}
