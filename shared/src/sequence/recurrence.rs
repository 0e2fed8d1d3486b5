//! The rule by which each symbol of a sequence follows from the m symbols before it.
//!
//! For `h(x) = x^m + h[m-1] x^(m-1) + .. + h[1] x + h[0]` the rule is
//! `b[i+m] = -(h[m-1] b[i+m-1] + .. + h[1] b[i+1] + h[0] b[i])`, so that h(x) is 0 where x stands
//! for "one symbol later". Since `h[0]` is not 0, the rule can be solved for `b[i]` and run
//! backwards.
//!
//! Source: section 3.1.2 of the thesis (property 2).

use super::SequenceError;
use crate::field::{Element, Field, Polynomial};

/// A linear recurrence of full period over a finite field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recurrence {
    field: Field,
    /// `-h[0], -h[1], .. -h[m-1]`: what the symbols of a window, oldest first, are multiplied by.
    taps: Vec<Element>,
    period: u64,
}

impl Recurrence {
    /// The recurrence of a primitive polynomial over `field`.
    ///
    /// # Errors
    /// [`SequenceError::NotPrimitive`], or [`SequenceError::Field`] if the polynomial has too high
    /// a degree to tell.
    pub fn new(field: &Field, h: &Polynomial) -> Result<Self, SequenceError> {
        if !h.is_monic() || !h.is_primitive(field)? {
            return Err(SequenceError::NotPrimitive {
                polynomial: h.to_text(field),
            });
        }
        let m = h.degree().unwrap_or(0);
        let taps = h.coefficients()[..m]
            .iter()
            .map(|&c| field.neg(c))
            .collect();
        let period = h.residues(field)? - 1;
        Ok(Self {
            field: field.clone(),
            taps,
            period,
        })
    }

    /// The field of the symbols.
    #[must_use]
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// The number m of symbols that determine the next one: the length of a window.
    #[must_use]
    pub fn order(&self) -> usize {
        self.taps.len()
    }

    /// The number q^m - 1 of symbols after which the sequence repeats.
    #[must_use]
    pub fn period(&self) -> u64 {
        self.period
    }

    /// The state 0..0 1, in which all our sequences begin.
    #[must_use]
    pub fn first_window(&self) -> Vec<Element> {
        let mut window = vec![Element::ZERO; self.order()];
        if let Some(newest) = window.last_mut() {
            *newest = Element::ONE;
        }
        window
    }

    /// `-h[0], -h[1], .. -h[m-1]`.
    pub(super) fn taps(&self) -> &[Element] {
        &self.taps
    }

    /// Whether this is one element of the field for each cell.
    pub(super) fn accepts(&self, window: &[Element]) -> bool {
        window.len() == self.order() && window.iter().all(|&e| self.field.contains(e))
    }

    /// The symbol that follows this window, oldest symbol first.
    pub(super) fn next(&self, window: &[Element]) -> Element {
        self.weighted_sum(&self.taps, window)
    }

    /// The symbol before this window, oldest symbol first.
    ///
    /// The recurrence, shifted by one, gives the newest symbol from the one wanted and all others.
    pub(super) fn previous(&self, window: &[Element]) -> Element {
        let (Some((newest, others)), Some((first, taps))) =
            (window.split_last(), self.taps.split_first())
        else {
            return Element::ZERO;
        };
        let rest = self.field.sub(*newest, self.weighted_sum(taps, others));
        let inverse = self.field.inverse(*first).unwrap_or_default();
        self.field.mul(rest, inverse)
    }

    fn weighted_sum(&self, weights: &[Element], symbols: &[Element]) -> Element {
        let products = weights
            .iter()
            .zip(symbols)
            .map(|(&w, &s)| self.field.mul(w, s));
        products.fold(Element::ZERO, |sum, product| self.field.add(sum, product))
    }
}
