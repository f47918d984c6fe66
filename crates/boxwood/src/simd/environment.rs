//! The mode in which a thread's processor computes with floats.
//!
//! *How it works.* Answers are the same bits everywhere because every operation rounds to nearest and subnormal numbers are
//! numbers. Games and audio programs set their threads to another mode (FTZ and DAZ of x86-64, FZ of ARM: subnormal numbers
//! count as zero), and Embree asks for it. So the register that says it is read at the door; only where it says something
//! unusual is it changed, and set back afterwards, whatever happens in between.
//!
//! *Cost.* To read and compare it takes a few cycles; to change it twice, some tens.
//!
//! *Rule.* The compiler does not know that floats depend on the register and may move operations across its change. Hence
//! all work is behind a call that is never inlined, and which touches memory, as the change may too: so it stays in its place.
//!
//! *Where.* x86-64 and 64-bit ARM; WebAssembly has one mode only. Elsewhere the caller's mode is taken for the usual one.

use register::Register;

/// Runs `work` in the mode that exact answers need: rounding to nearest, subnormal numbers kept, no traps. Where the
/// calling thread is in another mode (flush-to-zero, say), the mode is changed for so long.
///
/// Builders and [`Intersect`](crate::Intersect) do so by themselves. It is for those who call
/// [`Traverse`](crate::Traverse) themselves, or who ask many rays one by one and want to change the mode only once:
///
/// ```
/// use boxwood::{BruteForce, Intersect, Ray, TriangleMesh};
/// let judge = BruteForce::new(TriangleMesh::new([[0.0; 3]; 0], [[0_u32; 3]; 0])?);
/// let rays = vec![Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 100];
/// let hits = boxwood::exactly(|| rays.iter().filter(|ray| judge.occluded(ray)).count());
/// assert_eq!(hits, 0);
/// # Ok::<(), boxwood::MeshError>(())
/// ```
#[inline(always)]
pub fn exactly<R>(work: impl FnOnce() -> R) -> R {
    let before = register::read();
    let _restored = if register::is_usual(before) {
        None
    } else {
        Some(Restored::after_change(before, register::usual(before)))
    };
    apart(work)
}

/// Not inlined: see the rule above.
#[inline(never)]
fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// Sets the register back when it goes, on unwinding too.
struct Restored(Register);

impl Restored {
    #[cold]
    fn after_change(before: Register, now: Register) -> Self {
        register::write(now);
        Self(before)
    }
}

impl Drop for Restored {
    #[cold]
    fn drop(&mut self) {
        register::write(self.0);
    }
}

/// Runs `work` in the mode of a careless caller (subnormal numbers count as zero, and rounding is upwards), for tests: no
/// code of Rust's is meant to run so. Returns whether there is such a mode and `work` left it as it was.
///
/// # Safety
/// What the compiler makes of floats is for the usual mode. `work` may compute with them only behind [`exactly`], or must be
/// content with any number.
#[doc(hidden)]
pub unsafe fn carelessly(work: impl FnOnce()) -> bool {
    let before = register::read();
    let careless = register::careless(before);
    let _restored = Restored::after_change(before, careless);
    apart(work);
    careless != before && register::control(register::read()) == register::control(careless)
}

/// MXCSR.
#[cfg(all(target_arch = "x86_64", target_feature = "sse", not(miri)))]
mod register {
    use core::arch::asm;

    pub type Register = u32;

    /// Subnormal numbers read as zero, six masks, two bits of rounding, subnormal results become zero. The others say what
    /// has happened.
    const CONTROL: u32 = 0xffc0;
    /// Only the masks: nothing traps.
    const USUAL: u32 = 0x1f80;

    #[inline(always)]
    pub fn read() -> u32 {
        let mut register = 0_u32;
        // SAFETY: stores a register of this thread into a variable of ours. The intrinsic for it is deprecated.
        unsafe {
            asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags));
        }
        register
    }
    #[inline(always)]
    pub fn control(register: u32) -> u32 {
        register & CONTROL
    }
    #[inline(always)]
    pub fn is_usual(register: u32) -> bool {
        control(register) == USUAL
    }
    pub fn usual(_: u32) -> u32 {
        USUAL
    }
    pub fn careless(register: u32) -> u32 {
        const FLUSH: u32 = 1 << 15 | 1 << 6;
        const UPWARDS: u32 = 2 << 13;
        register & !(3 << 13) | FLUSH | UPWARDS
    }
    pub fn write(register: u32) {
        // SAFETY: what is written was read before, or differs from it in bits that every such processor has. Work in
        // between is behind a call, so that no operation of ours is in another mode than it was written for.
        unsafe {
            asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack));
        }
    }
}

/// FPCR.
#[cfg(all(target_arch = "aarch64", target_feature = "neon", not(miri)))]
mod register {
    use core::arch::asm;

    pub type Register = u64;

    const FLUSH: u64 = 1 << 24;
    const ROUNDING: u64 = 3 << 22;
    /// Traps; and three bits of newer processors: inputs flushed to zero, other rules of rounding, upper lanes kept.
    const OTHERS: u64 = 0b1001_1111 << 8 | 0b111;
    const CONTROL: u64 = FLUSH | ROUNDING | OTHERS;

    #[inline(always)]
    pub fn read() -> u64 {
        let register;
        // SAFETY: copies a register of this thread.
        unsafe {
            asm!("mrs {}, fpcr", out(reg) register, options(nomem, nostack, preserves_flags))
        };
        register
    }
    #[inline(always)]
    pub fn control(register: u64) -> u64 {
        register & CONTROL
    }
    #[inline(always)]
    pub fn is_usual(register: u64) -> bool {
        control(register) == 0
    }
    pub fn usual(register: u64) -> u64 {
        register & !CONTROL
    }
    pub fn careless(register: u64) -> u64 {
        const UPWARDS: u64 = 1 << 22;
        register & !ROUNDING | FLUSH | UPWARDS
    }
    pub fn write(register: u64) {
        // SAFETY: what is written was read before, or differs from it in bits that every such processor has or ignores.
        // Work in between is behind a call, so that no operation of ours is in another mode than it was written for.
        unsafe { asm!("msr fpcr, {}", in(reg) register, options(nostack, preserves_flags)) };
    }
}

/// No register: WebAssembly has one mode, and other machines' are not known here.
#[cfg(not(all(
    any(
        all(target_arch = "x86_64", target_feature = "sse"),
        all(target_arch = "aarch64", target_feature = "neon")
    ),
    not(miri)
)))]
mod register {
    pub type Register = ();

    pub fn read() {}
    pub fn control((): ()) {}
    pub fn is_usual((): ()) -> bool {
        true
    }
    pub fn usual((): ()) {}
    pub fn careless((): ()) {}
    pub fn write((): ()) {}
}

#[cfg(all(test, not(miri), any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::exactly;
    use core::hint::black_box;

    fn carelessly(work: impl FnOnce()) -> bool {
        // SAFETY: the numbers are made of what the compiler does not know, and looked at.
        unsafe { super::carelessly(work) }
    }

    fn apart<R>(work: impl FnOnce() -> R) -> R {
        super::apart(work)
    }

    /// What becomes of a subnormal result, a subnormal operand, and a quotient that is usually rounded down.
    fn signs_of_a_mode() -> [f32; 3] {
        apart(|| {
            let [least, half, three] = black_box([f32::MIN_POSITIVE, 0.5, 3.0]);
            let subnormal = black_box(f32::from_bits(1));
            [least * half, subnormal * 1.0e30, 5.0 / three]
        })
    }

    #[test]
    fn a_careless_mode_is_met_and_comes_back() {
        let usual = signs_of_a_mode();
        assert!(usual[0] > 0.0 && usual[1] > 0.0);
        let left_alone = carelessly(|| {
            let careless = signs_of_a_mode();
            assert_eq!(careless[..2], [0.0, 0.0]);
            assert!(careless[2] > usual[2]);
            assert_eq!(exactly(signs_of_a_mode), usual);
            assert_eq!(exactly(|| exactly(signs_of_a_mode)), usual);
            assert_eq!(signs_of_a_mode(), careless);
        });
        assert!(left_alone);
        assert_eq!(signs_of_a_mode(), usual);
        assert_eq!(exactly(signs_of_a_mode), usual);
    }

    #[cfg(feature = "std")]
    #[test]
    fn unwinding_brings_it_back() {
        let left_alone = carelessly(|| {
            let unwound = std::panic::catch_unwind(|| exactly(|| panic!("on purpose")));
            assert!(unwound.is_err());
            assert_eq!(signs_of_a_mode()[0], 0.0);
        });
        assert!(left_alone && signs_of_a_mode()[0] > 0.0);
    }
}
