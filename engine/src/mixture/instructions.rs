//! Vector instruction sets, chosen when the program runs.
//!
//! Inner loops are written once, as plain code over fixed lanes. [`InstructionSet::run`] compiles them once per set, and the
//! compiler vectorises them for it. All sets give the same result up to rounding.

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// The baseline of the target.
    Portable,
    /// x86-64 with AVX2 and FMA.
    Avx2,
    /// x86-64 with AVX-512 (F, CD, BW, DQ, VL).
    Avx512,
}

/// A loop that is compiled for every set. `run` and all it calls must be `#[inline(always)]`.
pub(crate) trait SimdKernel {
    type Output;
    /// `FUSED`: a product and a sum are one instruction ([`multiply_add`]). `LANES`: numbers in one register, or two.
    fn run<const FUSED: bool, const LANES: usize>(self) -> Self::Output;
}

/// `a * b + c`, rounded once where the instruction set can.
#[inline(always)]
pub(crate) fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Largest `LANES` of [`SimdKernel::run`].
pub(crate) const MAX_LANES: usize = 8;

/// NEON is part of every 64-bit Arm and has fused multiply-add.
const PORTABLE_IS_FUSED: bool = cfg!(target_arch = "aarch64");

impl InstructionSet {
    /// All sets, narrowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Whether this processor has it.
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

    /// The widest set of this processor.
    pub fn best() -> Self {
        let widest = Self::ALL.into_iter().rfind(|set| set.available());
        widest.unwrap_or(Self::Portable)
    }

    /// This set, or the portable one where the processor lacks it.
    pub fn or_portable(self) -> Self {
        if self.available() {
            self
        } else {
            Self::Portable
        }
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Runs `kernel` with this set, or with the portable one where the processor lacks it.
    #[inline]
    pub(crate) fn run<K: SimdKernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Portable => {}
            Self::Avx2 => {
                if let Some(v3) = pulp::x86::V3::try_new() {
                    return v3.vectorize(FusedKernel::<K, 4>(kernel));
                }
            }
            Self::Avx512 => {
                if let Some(v4) = pulp::x86::V4::try_new() {
                    return v4.vectorize(FusedKernel::<K, 8>(kernel));
                }
            }
        }
        kernel.run::<PORTABLE_IS_FUSED, 4>()
    }
}

/// Carries a kernel into a function compiled for wider instructions.
#[cfg(target_arch = "x86_64")]
struct FusedKernel<K, const LANES: usize>(K);

#[cfg(target_arch = "x86_64")]
impl<K: SimdKernel, const LANES: usize> pulp::NullaryFnOnce for FusedKernel<K, LANES> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run::<true, LANES>()
    }
}
