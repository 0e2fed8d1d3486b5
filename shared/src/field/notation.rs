//! Polynomials as text, in the notation of Appendix A.
//!
//! Takes and gives texts such as `x^4 + x^2 + wx + w^2`, `x^3 + 2x + 1` and
//! `x^10 + x^3 + w(x^2 + x + 1)`. A text is a sum of terms; a term is a product of factors written
//! side by side; a factor is a number, x, the letter of the field's generator (both may have an
//! exponent), or a text in parentheses.

use super::{Element, Field, FieldError, Polynomial};

/// The greatest degree of a polynomial that can be read.
pub const MAX_DEGREE: usize = 64;

/// The longest text that is read, in bytes. It bounds the depth of nested parentheses.
const MAX_TEXT: usize = 512;

impl Field {
    /// Reads a polynomial over this field.
    ///
    /// ```
    /// use shared::field::{FieldError, appendix_a};
    ///
    /// let gf4 = appendix_a::field(4)?;
    /// let h = gf4.parse("x^10 + x^3 + w(x^2 + x + 1)")?;
    /// assert_eq!(h.to_text(&gf4), "x^10 + x^3 + wx^2 + wx + w");
    /// # Ok::<(), FieldError>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::Notation`] with the place, also for degrees above [`MAX_DEGREE`].
    pub fn parse(&self, text: &str) -> Result<Polynomial, FieldError> {
        let mut reader = Reader {
            field: self,
            text,
            at: 0,
        };
        let read = match text.len() {
            0..=MAX_TEXT => reader.sum().and_then(|sum| reader.end().map(|()| sum)),
            _ => Err("the text is too long"),
        };
        read.map_err(|problem| FieldError::Notation {
            text: text.chars().take(80).collect(),
            order: self.order(),
            at: reader.at,
            problem,
        })
    }

    /// The text of an element as a coefficient: a number in a prime field, else 0, 1 or a power of
    /// the field's letter.
    #[must_use]
    pub fn name(&self, element: Element) -> String {
        match self.log(element) {
            Some(log) if self.extends.is_some() => power_text(self.letter, log as usize),
            _ => element.index().to_string(),
        }
    }
}

impl Polynomial {
    /// The polynomial as text, highest power first.
    #[must_use]
    pub fn to_text(&self, field: &Field) -> String {
        let highest_first = (0..self.coefficients().len()).rev();
        let terms: Vec<String> = highest_first
            .map(|power| (self.coefficient(power), power))
            .filter(|&(coefficient, _)| coefficient != Element::ZERO)
            .map(|(coefficient, power)| match power {
                0 => field.name(coefficient),
                _ if coefficient == Element::ONE => power_text('x', power),
                _ => field.name(coefficient) + &power_text('x', power),
            })
            .collect();
        if terms.is_empty() {
            "0".to_owned()
        } else {
            terms.join(" + ")
        }
    }
}

/// The text of a power of a letter: 1, t, t^2, t^3 ..
pub(super) fn power_text(letter: char, exponent: usize) -> String {
    match exponent {
        0 => "1".to_owned(),
        1 => letter.to_string(),
        _ => format!("{letter}^{exponent}"),
    }
}

/// What is wrong with a text; its place is where the reader stands.
type Problem = &'static str;

struct Reader<'a> {
    field: &'a Field,
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    fn sum(&mut self) -> Result<Polynomial, Problem> {
        let mut sum = self.product()?;
        while self.accept('+') {
            sum = sum.add(&self.product()?, self.field);
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<Polynomial, Problem> {
        let mut product = self
            .factor()?
            .ok_or("expected a number, x, a letter or (")?;
        while let Some(factor) = self.factor()? {
            product = product.mul(&factor, self.field);
            if product.degree() > Some(MAX_DEGREE) {
                return Err("the degree is too high");
            }
        }
        Ok(product)
    }

    fn factor(&mut self) -> Result<Option<Polynomial>, Problem> {
        let letter = self.field.letter;
        let Some(next) = self.peek() else {
            return Ok(None);
        };
        match next {
            '(' => {
                self.accept('(');
                let sum = self.sum()?;
                if self.accept(')') {
                    Ok(Some(sum))
                } else {
                    Err("expected + or )")
                }
            }
            'x' => {
                self.accept('x');
                let exponent = self.exponent()?;
                if exponent > MAX_DEGREE {
                    return Err("the degree is too high");
                }
                let one = Polynomial::constant(Element::ONE);
                Ok(Some((0..exponent).fold(one, |power, _| power.times_x())))
            }
            '0'..='9' => {
                let number = self.number()?;
                let number = Some(number).filter(|&n| n < self.field.characteristic() as usize);
                let element = number.and_then(|n| self.field.element(n));
                let element = element.ok_or("the number is not below the characteristic")?;
                Ok(Some(Polynomial::constant(element)))
            }
            _ if next == letter && self.field.extends.is_some() => {
                self.accept(letter);
                let exponent = self.exponent()?;
                Ok(Some(Polynomial::constant(
                    self.field.power(exponent as u64),
                )))
            }
            _ => Ok(None),
        }
    }

    fn exponent(&mut self) -> Result<usize, Problem> {
        if self.accept('^') {
            self.number()
        } else {
            Ok(1)
        }
    }

    fn number(&mut self) -> Result<usize, Problem> {
        self.peek();
        let rest = &self.text[self.at..];
        let length = rest
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(rest.len());
        let number = rest[..length]
            .parse()
            .map_err(|_| "expected a number of few digits")?;
        self.at += length;
        Ok(number)
    }

    fn end(&mut self) -> Result<(), Problem> {
        self.peek().map_or(Ok(()), |_| Err("expected + or the end"))
    }

    fn accept(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    /// The next character that is no space; the reader then stands at it.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }
}
