//! Which polynomials are irreducible, and which are primitive.
//!
//! h(x) of degree m over GF(q) is irreducible if it is no product of polynomials of lower degree:
//! then the remainders modulo h form the field GF(q^m). It is primitive if moreover the powers of x
//! run through all q^m - 1 remainders other than 0: then a shift register made from h gives a
//! sequence of that full period. Both tests need only powers of x modulo h, found by repeated
//! squaring, and the prime factors of m and of q^m - 1.
//!
//! Source: M. O. Rabin, "Probabilistic algorithms in finite fields" (1980), for irreducibility; the
//! order of x after section 3.1.1.1 of the thesis.

use super::{Element, Field, FieldError, Polynomial};

/// The greatest q^m for which the tests work: its factors are found by trial division.
pub const MAX_RESIDUES: u64 = 1 << 32;

impl Polynomial {
    /// The number q^m of remainders modulo this polynomial; 1 for constants.
    ///
    /// # Errors
    /// [`FieldError::TooLarge`] above [`MAX_RESIDUES`].
    pub fn residues(&self, field: &Field) -> Result<u64, FieldError> {
        let degree = self.degree().unwrap_or(0);
        let too_large = FieldError::TooLarge {
            base: field.order(),
            degree,
            limit: MAX_RESIDUES,
        };
        let residues = u32::try_from(degree)
            .ok()
            .and_then(|m| u64::from(field.order()).checked_pow(m))
            .filter(|&residues| residues <= MAX_RESIDUES);
        residues.ok_or(too_large)
    }

    /// Whether this polynomial is no product of two polynomials of lower degree.
    ///
    /// # Errors
    /// [`FieldError::TooLarge`] if there are more than [`MAX_RESIDUES`] remainders.
    pub fn is_irreducible(&self, field: &Field) -> Result<bool, FieldError> {
        self.residues(field)?;
        Ok(self.rabin_test(field).unwrap_or(false))
    }

    /// The smallest n > 0 with x^n = 1 modulo this polynomial, looked for among the divisors of
    /// q^m - 1. None if there is none, as for every polynomial without a constant term; an
    /// irreducible polynomial other than x always has one.
    ///
    /// ```
    /// use shared::field::{Field, FieldError};
    ///
    /// let gf2 = Field::prime(2)?;
    /// // Of two irreducible polynomials of degree 4, only one is primitive: its order is 2^4 - 1.
    /// assert_eq!(gf2.parse("x^4 + x + 1")?.order_of_x(&gf2)?, Some(15));
    /// assert_eq!(gf2.parse("x^4 + x^3 + x^2 + x + 1")?.order_of_x(&gf2)?, Some(5));
    /// # Ok::<(), FieldError>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::TooLarge`] if there are more than [`MAX_RESIDUES`] remainders.
    pub fn order_of_x(&self, field: &Field) -> Result<Option<u64>, FieldError> {
        let mut order = self.residues(field)? - 1;
        let one = Self::constant(Element::ONE);
        let is_one = |n| {
            Self::x()
                .pow_mod(n, self, field)
                .is_some_and(|power| power == one)
        };
        if order == 0 || !is_one(order) {
            return Ok(None);
        }
        for prime in prime_factors(order) {
            while order.is_multiple_of(prime) && is_one(order / prime) {
                order /= prime;
            }
        }
        Ok(Some(order))
    }

    /// Whether the powers of x modulo this polynomial are all remainders other than 0.
    ///
    /// Such a polynomial is irreducible too: every remainder but 0 is a power of x, and so has an
    /// inverse.
    ///
    /// # Errors
    /// [`FieldError::TooLarge`] if there are more than [`MAX_RESIDUES`] remainders.
    pub fn is_primitive(&self, field: &Field) -> Result<bool, FieldError> {
        let full = self.residues(field)? - 1;
        Ok(self.order_of_x(field)? == Some(full))
    }

    /// Rabin's test; none for the polynomial 0.
    ///
    /// x^(q^k) - x is the product of all monic irreducible polynomials whose degree divides k. So h
    /// is irreducible if it divides that for k = m and shares no factor with it for k = m / prime.
    fn rabin_test(&self, field: &Field) -> Option<bool> {
        let degree = self.degree().filter(|&degree| degree > 0)?;
        let mut differences = Vec::new();
        let mut power = Self::x().rem(self, field)?;
        for _ in 1..=degree {
            power = power.pow_mod(u64::from(field.order()), self, field)?;
            differences.push(power.sub(&Self::x(), field).rem(self, field)?);
        }
        let divides = differences.pop() == Some(Self::default());
        let shares_none = prime_factors(degree as u64).into_iter().all(|prime| {
            let k = degree / prime as usize;
            self.gcd(&differences[k - 1], field).degree() == Some(0)
        });
        Some(divides && shares_none)
    }
}

/// The distinct prime factors of a number up to [`MAX_RESIDUES`], in rising order, by trial
/// division; none for 0 and 1.
pub(super) fn prime_factors(mut number: u64) -> Vec<u64> {
    let mut factors = Vec::new();
    let mut candidate = 2;
    while candidate * candidate <= number {
        if number.is_multiple_of(candidate) {
            factors.push(candidate);
            while number.is_multiple_of(candidate) {
                number /= candidate;
            }
        }
        candidate += 1;
    }
    if number > 1 {
        factors.push(number);
    }
    factors
}
