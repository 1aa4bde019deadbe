//! Which instructions the inner loops run on: found when the program runs, not when it is built.
//!
//! Loops are written once, in plain code over fixed lanes; [`Instructions::run`] has them compiled once for each
//! set, and the compiler vectorises them for it. All sets give the same answer up to rounding.

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Instructions {
    /// What every processor of this kind has.
    Portable,
    /// x86-64 with AVX2 and FMA.
    Avx2,
    /// x86-64 with AVX-512 (F, CD, BW, DQ, VL).
    Avx512,
}

/// Loops to be compiled for every set. `run` and all it calls must be `#[inline(always)]`.
pub(crate) trait Loops {
    /// What they give.
    type Output;
    /// Runs them. `FUSED`: a product and a sum are one instruction ([`multiply_add`]); `LANES`: numbers that
    /// one register holds, or two.
    fn run<const FUSED: bool, const LANES: usize>(self) -> Self::Output;
}

/// `a * b + c`, in one rounding where the instructions have it.
#[inline(always)]
pub(crate) fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Widest `LANES` of [`Loops::run`].
pub(crate) const WIDEST: usize = 8;

/// NEON is part of every 64-bit Arm and fuses.
const PORTABLE_FUSES: bool = cfg!(target_arch = "aarch64");

impl Instructions {
    /// All sets, narrowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Whether this processor has them.
    pub fn available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => pulp::x86::V3::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => pulp::x86::V4::is_available(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// The widest that this processor has.
    pub fn best() -> Self {
        let widest = Self::ALL.into_iter().rfind(|set| set.available());
        widest.unwrap_or(Self::Portable)
    }

    /// These, or the portable ones where the processor lacks these.
    pub fn or_portable(self) -> Self {
        if self.available() {
            self
        } else {
            Self::Portable
        }
    }

    /// As reports name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Runs `loops` on these instructions; on the portable ones if the processor lacks them.
    #[inline]
    pub(crate) fn run<L: Loops>(self, loops: L) -> L::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Portable => {}
            Self::Avx2 => {
                if let Some(v3) = pulp::x86::V3::try_new() {
                    return v3.vectorize(Fused::<L, 4>(loops));
                }
            }
            Self::Avx512 => {
                if let Some(v4) = pulp::x86::V4::try_new() {
                    return v4.vectorize(Fused::<L, 8>(loops));
                }
            }
        }
        loops.run::<PORTABLE_FUSES, 4>()
    }
}

/// Loops on their way into a function that may use the wider instructions.
#[cfg(target_arch = "x86_64")]
struct Fused<L, const LANES: usize>(L);

#[cfg(target_arch = "x86_64")]
impl<L: Loops, const LANES: usize> pulp::NullaryFnOnce for Fused<L, LANES> {
    type Output = L::Output;

    #[inline(always)]
    fn call(self) -> L::Output {
        self.0.run::<true, LANES>()
    }
}
