//! The processor's flush-to-zero mode.

/// As long as it lives, this thread's processor reads and writes subnormal numbers as zero, which Embree and others
/// recommend to their users. Elsewhere than on x86-64 it does nothing.
pub struct FlushToZero {
    #[cfg(target_arch = "x86_64")]
    before: u32,
}

impl FlushToZero {
    /// Turns it on.
    #[inline(never)]
    pub fn new() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            /// Flush to zero, and subnormals are zeros.
            const FLUSH: u32 = 1 << 15 | 1 << 6;
            let mut before = 0_u32;
            // SAFETY: stores a register of this thread into a variable of ours.
            unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut before) };
            set(before | FLUSH);
            Self { before }
        }
        #[cfg(not(target_arch = "x86_64"))]
        Self {}
    }
}

impl Drop for FlushToZero {
    #[inline(never)]
    fn drop(&mut self) {
        #[cfg(target_arch = "x86_64")]
        set(self.before);
    }
}

#[cfg(target_arch = "x86_64")]
fn set(register: u32) {
    // SAFETY: only the two bits of `FlushToZero` ever change, so rounding and exceptions stay as Rust expects them. Rust
    // code that runs meanwhile copies numbers, and peers compute with them; none of it relies on subnormal numbers.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn subnormals_are_zero_only_meanwhile() {
        let half = || black_box(f32::MIN_POSITIVE) * black_box(0.5);
        assert!(half() > 0.0);
        let guard = FlushToZero::new();
        let flushed = half();
        drop(guard);
        assert_eq!(flushed, 0.0);
        assert!(half() > 0.0);
    }
}
