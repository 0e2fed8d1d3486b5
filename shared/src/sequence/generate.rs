//! Pseudo-random sequences and the two shift registers that generate them.
//!
//! The feedback register (Figures 3.1 and 3.2, "Fibonacci" type) holds a window of the sequence: it
//! gives out its oldest symbol and takes in the next one. The modified register (Figure 3.3,
//! "Galois" type) holds an element of GF(q^m) as a tuple: each step multiplies it by x, modulo h(x),
//! and gives out the coefficient of x^(m-1). From the state 0..0 1 both give the same sequence, but
//! only the modified register's states are the successive powers of x.
//!
//! ```
//! use shared::field::{Element, Field, FieldError};
//! use shared::sequence::{FeedbackRegister, ModifiedRegister, Recurrence, SequenceError};
//!
//! // Step 3 of Figure 3.4: x^3 = x + 2 modulo h(x) = x^3 + 2x + 1.
//! let gf3 = Field::prime(3)?;
//! let recurrence = Recurrence::new(&gf3, &gf3.parse("x^3 + 2x + 1")?)?;
//! let mut feedback = FeedbackRegister::new(&recurrence);
//! let mut modified = ModifiedRegister::new(&recurrence);
//! for _ in 0..3 {
//!     assert_eq!(feedback.step(), modified.step());
//! }
//! let digits = |state: &[Element]| state.iter().map(|e| e.index()).collect::<Vec<_>>();
//! assert_eq!(digits(modified.state()), [0, 1, 2]);
//! assert_eq!(digits(feedback.state()), [0, 1, 2]);
//! # Ok::<(), SequenceError>(())
//! ```

use super::{Recurrence, SequenceError};
use crate::field::{Element, Field, Polynomial};

/// The longest sequence that is held in memory: all of Appendix A fits.
pub const MAX_PERIOD: u64 = 1 << 21;

/// The shift register whose state is a window of the sequence.
#[derive(Debug, Clone)]
pub struct FeedbackRegister<'r> {
    recurrence: &'r Recurrence,
    state: Vec<Element>,
}

impl<'r> FeedbackRegister<'r> {
    /// The register in the state 0..0 1.
    #[must_use]
    pub fn new(recurrence: &'r Recurrence) -> Self {
        Self {
            recurrence,
            state: recurrence.first_window(),
        }
    }

    /// The register in the given state, oldest symbol first.
    ///
    /// # Errors
    /// [`SequenceError::BadState`].
    pub fn at(recurrence: &'r Recurrence, state: &[Element]) -> Result<Self, SequenceError> {
        if !recurrence.accepts(state) {
            return Err(SequenceError::BadState {
                cells: recurrence.order(),
            });
        }
        Ok(Self {
            recurrence,
            state: state.to_vec(),
        })
    }

    /// The symbols in the cells, oldest first: the window that will be given out next.
    #[must_use]
    pub fn state(&self) -> &[Element] {
        &self.state
    }

    /// Shifts by one and gives out the oldest symbol.
    pub fn step(&mut self) -> Element {
        let next = self.recurrence.next(&self.state);
        self.state.rotate_left(1);
        self.state
            .last_mut()
            .map_or(Element::ZERO, |cell| std::mem::replace(cell, next))
    }

    /// Takes one step back and gives the symbol that it drops, the newest.
    pub fn step_back(&mut self) -> Element {
        let previous = self.recurrence.previous(&self.state);
        self.state.rotate_right(1);
        self.state
            .first_mut()
            .map_or(Element::ZERO, |cell| std::mem::replace(cell, previous))
    }
}

/// The shift register whose state is a power of x, as a tuple.
#[derive(Debug, Clone)]
pub struct ModifiedRegister<'r> {
    recurrence: &'r Recurrence,
    state: Vec<Element>,
}

impl<'r> ModifiedRegister<'r> {
    /// The register in the state 0..0 1, which is x^0.
    #[must_use]
    pub fn new(recurrence: &'r Recurrence) -> Self {
        Self {
            recurrence,
            state: recurrence.first_window(),
        }
    }

    /// The coefficients in the cells, highest power first: after k steps, those of x^k.
    #[must_use]
    pub fn state(&self) -> &[Element] {
        &self.state
    }

    /// Multiplies by x modulo h(x), and gives out the coefficient of x^(m-1) before that.
    pub fn step(&mut self) -> Element {
        let field = self.recurrence.field();
        self.state.rotate_left(1);
        // The highest coefficient comes round to the place of x^0. It stood for x^m by now, which
        // is -(h[m-1] x^(m-1) + .. + h[0]) modulo h(x).
        let highest = self.state.last_mut().map_or(Element::ZERO, std::mem::take);
        for (cell, &tap) in self.state.iter_mut().rev().zip(self.recurrence.taps()) {
            *cell = field.add(*cell, field.mul(highest, tap));
        }
        highest
    }
}

/// One period of a pseudo-random sequence, from the state 0..0 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sequence {
    recurrence: Recurrence,
    symbols: Vec<Element>,
}

impl Sequence {
    /// The sequence of a primitive polynomial over `field`.
    ///
    /// # Errors
    /// [`SequenceError::NotPrimitive`]; [`SequenceError::TooLong`] above [`MAX_PERIOD`].
    pub fn new(field: &Field, h: &Polynomial) -> Result<Self, SequenceError> {
        let recurrence = Recurrence::new(field, h)?;
        let period = recurrence.period();
        if period > MAX_PERIOD {
            return Err(SequenceError::TooLong {
                period,
                limit: MAX_PERIOD,
            });
        }
        let mut register = FeedbackRegister::new(&recurrence);
        let symbols = (0..period).map(|_| register.step()).collect();
        Ok(Self {
            recurrence,
            symbols,
        })
    }

    /// The recurrence that the symbols obey.
    #[must_use]
    pub fn recurrence(&self) -> &Recurrence {
        &self.recurrence
    }

    /// The q^m - 1 symbols of one period.
    #[must_use]
    pub fn symbols(&self) -> &[Element] {
        &self.symbols
    }

    /// The m symbols from this index on, in a circle: after the last symbol comes the first.
    #[must_use]
    pub fn window(&self, index: usize) -> Vec<Element> {
        let period = self.symbols.len();
        let circle = (index % period..).map(|k| self.symbols[k % period]);
        circle.take(self.recurrence.order()).collect()
    }
}
