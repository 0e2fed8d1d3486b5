//! One finite field: its elements and their arithmetic.
//!
//! An element is a small index. For GF(p) it is the integer itself; for an extension of GF(q), the
//! polynomial c0 + c1 x + c2 x^2 + .. has the index c0 + c1 q + c2 q^2 + .., so the elements of
//! GF(q) keep their indices inside its extensions. Written in base p, an index is a list of
//! digits, and addition adds them digit by digit modulo p. Multiplication adds logarithms: the
//! field holds the table of all powers of one generator, and its inverse.
//!
//! An index of the wrong field gives a wrong sum without notice; see [`Field`].

use super::Polynomial;

/// The greatest number of elements of one [`Field`].
pub const MAX_ORDER: u32 = 1 << 16;

/// An element of a [`Field`], as an index from 0 to the field's order - 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Element(pub(super) u16);

impl Element {
    /// The neutral element of addition, in every field.
    pub const ZERO: Self = Self(0);
    /// The neutral element of multiplication, in every field.
    pub const ONE: Self = Self(1);

    /// The element with this index, in any field that is large enough; see [`Field::element`].
    #[must_use]
    pub const fn from_index(index: u16) -> Self {
        Self(index)
    }

    /// The index of this element, from 0 to the field's order - 1.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// A finite field of at most [`MAX_ORDER`] elements.
///
/// The methods take elements of this same field. An element of a larger field, which
/// [`Field::contains`] denies, has no logarithm here and counts as 0 in products.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    pub(super) characteristic: u16,
    /// The powers of the generator, from 0 to the order - 2.
    pub(super) powers: Vec<Element>,
    /// The inverse of `powers`; the entry of 0 has no meaning.
    pub(super) logs: Vec<u16>,
    /// What names the generator in texts.
    pub(super) letter: char,
    /// What this field extends; none for a prime field.
    pub(super) extends: Option<Extends>,
}

/// The smaller field under an extension, and the polynomial that generates the extension.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Extends {
    pub(super) base: Box<Field>,
    pub(super) modulus: Polynomial,
}

impl Field {
    /// The number of elements.
    #[must_use]
    pub fn order(&self) -> u32 {
        self.group_order() + 1
    }

    /// The prime p for which adding any element p times gives 0.
    #[must_use]
    pub fn characteristic(&self) -> u32 {
        u32::from(self.characteristic)
    }

    /// The field whose elements are the coefficients here; a prime field is its own base.
    #[must_use]
    pub fn base(&self) -> &Self {
        self.extends.as_ref().map_or(self, |extends| &extends.base)
    }

    /// The number m for which the order is that of the base field to the m-th power.
    #[must_use]
    pub fn degree(&self) -> usize {
        let degree = self
            .extends
            .as_ref()
            .and_then(|extends| extends.modulus.degree());
        degree.unwrap_or(1)
    }

    /// The element whose powers are all elements but 0. In an extension it is x, a zero of h(x).
    #[must_use]
    pub fn generator(&self) -> Element {
        self.power(1)
    }

    /// The element with this index, or none if the index reaches the order.
    #[must_use]
    pub fn element(&self, index: usize) -> Option<Element> {
        let element = Element(u16::try_from(index).ok()?);
        self.contains(element).then_some(element)
    }

    /// All elements, by index.
    pub fn elements(&self) -> impl Iterator<Item = Element> + use<> {
        (0..=u16::MAX).take(self.logs.len()).map(Element)
    }

    /// Whether this element's index is below the order.
    #[must_use]
    pub fn contains(&self, element: Element) -> bool {
        element.index() < self.logs.len()
    }

    /// The sum a + b.
    #[must_use]
    pub fn add(&self, a: Element, b: Element) -> Element {
        if self.characteristic == 2 {
            return Element(a.0 ^ b.0);
        }
        self.digit_by_digit(a, b, |p, a, b| (a + b) % p)
    }

    /// The difference a - b.
    #[must_use]
    pub fn sub(&self, a: Element, b: Element) -> Element {
        if self.characteristic == 2 {
            return Element(a.0 ^ b.0);
        }
        self.digit_by_digit(a, b, |p, a, b| (a + p - b) % p)
    }

    /// The negative -a.
    #[must_use]
    pub fn neg(&self, a: Element) -> Element {
        self.sub(Element::ZERO, a)
    }

    /// The product a b.
    #[must_use]
    pub fn mul(&self, a: Element, b: Element) -> Element {
        match (self.log(a), self.log(b)) {
            (Some(a), Some(b)) => self.power(u64::from(a) + u64::from(b)),
            _ => Element::ZERO,
        }
    }

    /// The inverse 1 / a, or none for 0.
    #[must_use]
    pub fn inverse(&self, a: Element) -> Option<Element> {
        let log = self.log(a)?;
        Some(self.power(u64::from(self.group_order() - log)))
    }

    /// The power a^n; 0^0 is 1.
    #[must_use]
    pub fn pow(&self, a: Element, n: u64) -> Element {
        match self.log(a) {
            _ if n == 0 => Element::ONE,
            Some(log) => self.power(u64::from(log) * (n % u64::from(self.group_order()))),
            None => Element::ZERO,
        }
    }

    /// The n-th power of the generator.
    #[must_use]
    pub fn power(&self, n: u64) -> Element {
        let n = n % u64::from(self.group_order());
        // Below the group's order, which fits in 16 bits.
        self.powers[n as usize]
    }

    /// The logarithm of a: which power of the generator it is, from 0 to the order - 2. None for 0.
    #[must_use]
    pub fn log(&self, a: Element) -> Option<u32> {
        self.logs
            .get(a.index())
            .filter(|_| a != Element::ZERO)
            .map(|&log| u32::from(log))
    }

    /// The number of elements other than 0.
    fn group_order(&self) -> u32 {
        // At most MAX_ORDER - 1 by construction.
        self.powers.len() as u32
    }

    /// Applies an operation on integers modulo p to each base-p digit of two indices.
    fn digit_by_digit(&self, a: Element, b: Element, op: fn(u32, u32, u32) -> u32) -> Element {
        let p = self.characteristic();
        let (mut a, mut b) = (u32::from(a.0), u32::from(b.0));
        let (mut result, mut place) = (0, 1);
        while a > 0 || b > 0 {
            result += place * op(p, a % p, b % p);
            (a, b, place) = (a / p, b / p, place * p);
        }
        // As many digits as the greater operand, so below the order.
        Element(result as u16)
    }
}
