//! Polynomials over a finite field: arithmetic, division with remainder, greatest common divisor.
//!
//! A polynomial holds only its coefficients; each method that calculates takes the field.

use super::{Element, Field};

/// A polynomial in x, with coefficients from a field that the caller knows.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Polynomial {
    /// Lowest power first; the last coefficient is not 0. The polynomial 0 has none.
    coefficients: Vec<Element>,
}

impl Polynomial {
    /// The polynomial c0 + c1 x + c2 x^2 + .. of these coefficients, lowest power first.
    #[must_use]
    pub fn new(mut coefficients: Vec<Element>) -> Self {
        while coefficients.last() == Some(&Element::ZERO) {
            coefficients.pop();
        }
        Self { coefficients }
    }

    /// The polynomial of degree 0 (or the polynomial 0) with this value.
    #[must_use]
    pub fn constant(value: Element) -> Self {
        Self::new(vec![value])
    }

    /// The polynomial x.
    #[must_use]
    pub fn x() -> Self {
        Self::constant(Element::ONE).times_x()
    }

    /// The coefficients, lowest power first, without leading zeros.
    #[must_use]
    pub fn coefficients(&self) -> &[Element] {
        &self.coefficients
    }

    /// The coefficient of x^power; 0 above the degree.
    #[must_use]
    pub fn coefficient(&self, power: usize) -> Element {
        self.coefficients.get(power).copied().unwrap_or_default()
    }

    /// The greatest power with a coefficient; none for the polynomial 0.
    #[must_use]
    pub fn degree(&self) -> Option<usize> {
        self.coefficients.len().checked_sub(1)
    }

    /// Whether the coefficient of the greatest power is 1.
    #[must_use]
    pub fn is_monic(&self) -> bool {
        self.coefficients.last() == Some(&Element::ONE)
    }

    /// The sum of two polynomials.
    #[must_use]
    pub fn add(&self, other: &Self, field: &Field) -> Self {
        self.power_by_power(other, |a, b| field.add(a, b))
    }

    /// The difference of two polynomials.
    #[must_use]
    pub fn sub(&self, other: &Self, field: &Field) -> Self {
        self.power_by_power(other, |a, b| field.sub(a, b))
    }

    /// The polynomial with every coefficient multiplied by `factor`.
    #[must_use]
    pub fn scale(&self, factor: Element, field: &Field) -> Self {
        Self::new(
            self.coefficients
                .iter()
                .map(|&c| field.mul(c, factor))
                .collect(),
        )
    }

    /// The product with x: every coefficient moves one power up.
    #[must_use]
    pub fn times_x(&self) -> Self {
        Self::new(
            std::iter::once(Element::ZERO)
                .chain(self.coefficients.iter().copied())
                .collect(),
        )
    }

    /// The product of two polynomials.
    #[must_use]
    pub fn mul(&self, other: &Self, field: &Field) -> Self {
        let mut product = vec![Element::ZERO; self.coefficients.len() + other.coefficients.len()];
        for (i, &a) in self.coefficients.iter().enumerate() {
            for (j, &b) in other.coefficients.iter().enumerate() {
                product[i + j] = field.add(product[i + j], field.mul(a, b));
            }
        }
        Self::new(product)
    }

    /// The quotient and the remainder of a division; none if the divisor is 0.
    ///
    /// ```
    /// use shared::field::{Field, FieldError};
    ///
    /// // The thesis's example over GF(3): x^4 = (x^3 + 2x + 1) x + (x^2 + 2x).
    /// let gf3 = Field::prime(3)?;
    /// let (h, x4) = (gf3.parse("x^3 + 2x + 1")?, gf3.parse("x^4")?);
    /// let (quotient, remainder) = x4.div_rem(&h, &gf3).unwrap();
    /// assert_eq!((quotient.to_text(&gf3).as_str(), remainder.to_text(&gf3).as_str()), ("x", "x^2 + 2x"));
    /// # Ok::<(), FieldError>(())
    /// ```
    #[must_use]
    pub fn div_rem(&self, divisor: &Self, field: &Field) -> Option<(Self, Self)> {
        let inverse = field.inverse(*divisor.coefficients.last()?)?;
        let mut remainder = self.coefficients.clone();
        let mut quotient = Vec::new();
        while remainder.len() >= divisor.coefficients.len() {
            let factor = field.mul(remainder.pop()?, inverse);
            let start = remainder.len() + 1 - divisor.coefficients.len();
            for (r, &d) in remainder[start..].iter_mut().zip(&divisor.coefficients) {
                *r = field.sub(*r, field.mul(factor, d));
            }
            quotient.push(factor);
        }
        quotient.reverse();
        Some((Self::new(quotient), Self::new(remainder)))
    }

    /// The remainder of a division; none if the divisor is 0.
    #[must_use]
    pub fn rem(&self, divisor: &Self, field: &Field) -> Option<Self> {
        self.div_rem(divisor, field).map(|(_, remainder)| remainder)
    }

    /// The monic greatest common divisor, by Euclid's algorithm; 0 only if both are 0.
    #[must_use]
    pub fn gcd(&self, other: &Self, field: &Field) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        while let Some(remainder) = a.rem(&b, field) {
            (a, b) = (b, remainder);
        }
        let inverse = a.coefficients.last().and_then(|&c| field.inverse(c));
        inverse.map_or(a.clone(), |inverse| a.scale(inverse, field))
    }

    /// The power self^n modulo another polynomial, by repeated squaring; none if that is 0.
    #[must_use]
    pub fn pow_mod(&self, mut n: u64, modulus: &Self, field: &Field) -> Option<Self> {
        let mut square = self.rem(modulus, field)?;
        let mut result = Self::constant(Element::ONE).rem(modulus, field)?;
        while n > 0 {
            if n % 2 == 1 {
                result = result.mul(&square, field).rem(modulus, field)?;
            }
            square = square.mul(&square, field).rem(modulus, field)?;
            n /= 2;
        }
        Some(result)
    }

    /// The value at a point, by Horner's rule.
    #[must_use]
    pub fn evaluate(&self, point: Element, field: &Field) -> Element {
        let highest_first = self.coefficients.iter().rev();
        highest_first.fold(Element::ZERO, |value, &c| {
            field.add(field.mul(value, point), c)
        })
    }

    fn power_by_power(&self, other: &Self, op: impl Fn(Element, Element) -> Element) -> Self {
        let powers = 0..self.coefficients.len().max(other.coefficients.len());
        Self::new(
            powers
                .map(|k| op(self.coefficient(k), other.coefficient(k)))
                .collect(),
        )
    }
}
