//! How fields are made: the integers modulo a prime, and the remainders modulo a polynomial.

use super::finite::{Extends, MAX_ORDER};
use super::primitive::prime_factors;
use super::{Element, Field, FieldError, Polynomial};

impl Field {
    /// The prime field GF(p): the integers from 0 to p - 1, modulo p.
    ///
    /// Its generator is the smallest one: 2 for GF(5), where 2, 4, 3, 1 are the powers of 2.
    ///
    /// ```
    /// use shared::field::{Field, FieldError};
    ///
    /// let gf5 = Field::prime(5)?;
    /// let powers = [1, 2, 3, 4].map(|n| gf5.power(n).index());
    /// assert_eq!(powers, [2, 4, 3, 1]);
    /// # Ok::<(), FieldError>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::NotPrime`], or [`FieldError::TooLarge`] above [`MAX_ORDER`].
    pub fn prime(p: u32) -> Result<Self, FieldError> {
        let characteristic = u16::try_from(p).map_err(|_| too_large(p, 1))?;
        if prime_factors(u64::from(p)) != [u64::from(p)] {
            return Err(FieldError::NotPrime { number: p });
        }
        // A number generates the group if its powers first come back to 1 after p - 1 steps.
        let powers = (1..p)
            .map(|g| powers_of(Element(1), |e| times(e, g, p)))
            .find(|powers| powers.len() as u64 == u64::from(p) - 1)
            .ok_or(FieldError::NotPrime { number: p })?;
        Ok(Self::with_powers(characteristic, powers, 'g', None))
    }

    /// The extension of `base` by a primitive polynomial h(x) of degree m: the polynomials of
    /// degree below m, modulo h(x).
    ///
    /// The generator is x, which is a zero of h; `letter` names it in texts (w in GF(4), t in the
    /// thesis's GF(27)).
    ///
    /// # Errors
    /// [`FieldError::NotPrimitive`] if h is not monic and primitive; [`FieldError::TooLarge`]
    /// above [`MAX_ORDER`]; [`FieldError::BadLetter`].
    pub fn extension(base: &Self, h: &Polynomial, letter: char) -> Result<Self, FieldError> {
        if !letter.is_alphabetic() || letter == 'x' {
            return Err(FieldError::BadLetter { letter });
        }
        let degree = h.degree().unwrap_or(0);
        let residues = h.residues(base)?;
        if residues > u64::from(MAX_ORDER) {
            return Err(too_large(base.order(), degree));
        }
        if !h.is_monic() || !h.is_primitive(base)? {
            let polynomial = h.to_text(base);
            return Err(FieldError::NotPrimitive {
                polynomial,
                order: base.order(),
            });
        }
        let order = base.order();
        let mut powers = Vec::new();
        let mut power = Polynomial::constant(Element::ONE);
        for _ in 1..residues {
            powers.push(index_of(&power, order));
            power = power.times_x();
            power = power.rem(h, base).unwrap_or(power);
        }
        let extends = Extends {
            base: Box::new(base.clone()),
            modulus: h.clone(),
        };
        Ok(Self::with_powers(
            base.characteristic,
            powers,
            letter,
            Some(extends),
        ))
    }

    fn with_powers(
        characteristic: u16,
        powers: Vec<Element>,
        letter: char,
        extends: Option<Extends>,
    ) -> Self {
        let mut logs = vec![0; powers.len() + 1];
        for (log, power) in (0..).zip(&powers) {
            logs[power.index()] = log;
        }
        Self {
            characteristic,
            powers,
            logs,
            letter,
            extends,
        }
    }
}

/// The element of the extension that a polynomial of degree below m stands for.
pub(super) fn index_of(polynomial: &Polynomial, base_order: u32) -> Element {
    let digits = polynomial
        .coefficients()
        .iter()
        .rev()
        .map(|digit| u32::from(digit.0));
    let index = digits.fold(0, |index, digit| index * base_order + digit % base_order);
    // Below base_order^m, which is at most MAX_ORDER.
    Element(index as u16)
}

/// The successive elements from `start` on, up to the last one before `start` returns.
fn powers_of(start: Element, next: impl Fn(Element) -> Element) -> Vec<Element> {
    let further = std::iter::successors(Some(next(start)), |&e| Some(next(e)));
    std::iter::once(start)
        .chain(further.take_while(|&e| e != start))
        .collect()
}

/// The product of two integers modulo p.
fn times(element: Element, factor: u32, p: u32) -> Element {
    // Below p, which fits in 16 bits.
    Element((u64::from(element.0) * u64::from(factor) % u64::from(p)) as u16)
}

fn too_large(base: u32, degree: usize) -> FieldError {
    FieldError::TooLarge {
        base,
        degree,
        limit: u64::from(MAX_ORDER),
    }
}
