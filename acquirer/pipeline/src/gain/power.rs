//! How far each gain can be trusted, in one byte: limits ask for it at scattered pixels, and what is small stays in the
//! cache.

use pulp::NullaryFnOnce;

/// Bits of an `f32` that are left out: three of the mantissa stay, eight steps per doubling.
const LEFT_OUT: u32 = 20;
/// Code 0: 2^-6 or less counts as nothing. The largest code is 2^26.
const FIRST: u32 = (127 - 6) << (23 - LEFT_OUT);

/// Squared signal to noise of a full line at each pixel, in steps of 6 to 12 %.
#[derive(Debug, Clone, Default)]
pub struct PowerPlane {
    width: usize,
    codes: Vec<u8>,
}

impl PowerPlane {
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        self.width = width;
        self.codes.resize(width * height, 0);
    }

    /// One row's codes, see [`power_of`].
    #[inline(always)]
    pub(crate) fn row(&self, y: usize) -> &[u8] {
        &self.codes[y * self.width..(y + 1) * self.width]
    }

    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }

    pub(super) fn codes_mut(&mut self) -> &mut [u8] {
        &mut self.codes
    }
}

/// The power that a code stands for: the middle of its step.
#[inline(always)]
pub(crate) fn power_of(code: u8) -> f32 {
    let step = u32::from(code) + FIRST;
    let middle = f32::from_bits(step << LEFT_OUT | 1 << (LEFT_OUT - 1));
    if code == 0 { 0.0 } else { middle }
}

/// The code of a power.
#[inline(always)]
pub(super) fn code_of(power: f32) -> u8 {
    let step = power.max(0.0).to_bits() >> LEFT_OUT;
    step.clamp(FIRST, FIRST + 255).wrapping_sub(FIRST) as u8
}

/// Codes of a row of powers.
pub(super) struct RowCodes<'a> {
    pub(super) powers: &'a [f32],
    pub(super) codes: &'a mut [u8],
}

impl NullaryFnOnce for RowCodes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let pairs = self.codes.iter_mut().zip(self.powers);
        pairs.for_each(|(code, &power)| *code = code_of(power));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_within_a_sixteenth_of_its_power_and_never_out_of_order() {
        let mut last = 0;
        for k in 0..3400 {
            let power = 0.02 * 1.007_f32.powi(k);
            let code = code_of(power);
            assert!(code >= last);
            last = code;
            if code < 255 {
                let error = (power_of(code) / power - 1.0).abs();
                assert!(error < 1.0 / 15.0, "{power} became {}", power_of(code));
            }
        }
        assert_eq!(last, 255);
    }

    #[test]
    fn nothing_stays_nothing_and_too_much_is_the_most() {
        for nothing in [0.0, -1.0, 0.01, f32::NAN] {
            assert_eq!(power_of(code_of(nothing)), 0.0);
        }
        assert_eq!(code_of(f32::MAX), 255);
        assert_eq!(code_of(f32::INFINITY), 255);
    }
}
