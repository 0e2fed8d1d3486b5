//! Pixel loops compiled for the processor's widest registers.
//!
//! Each sum has its own order of additions and none is fused with a multiplication, so the width of the registers
//! does not change a bit.

use pulp::{Arch, NullaryFnOnce};

/// Runs work compiled for the widest registers that the processor has (AVX2 on PCs of the last decade). The
/// work's `call` and all that it calls must be `#[inline(always)]`.
pub(super) fn wide<W: NullaryFnOnce>(work: W) -> W::Output {
    Arch::new().dispatch(work)
}
