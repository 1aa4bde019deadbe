//! The number types of binary clouds.

/// A scalar type of PLY or PCD.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Byte order of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

impl Scalar {
    /// Size of a number, bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at `offset`, or `None` if `bytes` end before it does. 64-bit integers are rounded to `f64`.
    pub(super) fn read(self, bytes: &[u8], offset: usize, endian: Endian) -> Option<f64> {
        fn array<const N: usize>(bytes: &[u8], offset: usize, endian: Endian) -> Option<[u8; N]> {
            let mut out: [u8; N] = *bytes.get(offset..)?.first_chunk()?;
            if endian == Endian::Big {
                out.reverse();
            }
            Some(out)
        }
        Some(match self {
            Self::I8 => f64::from(i8::from_le_bytes(array(bytes, offset, endian)?)),
            Self::U8 => f64::from(u8::from_le_bytes(array(bytes, offset, endian)?)),
            Self::I16 => f64::from(i16::from_le_bytes(array(bytes, offset, endian)?)),
            Self::U16 => f64::from(u16::from_le_bytes(array(bytes, offset, endian)?)),
            Self::I32 => f64::from(i32::from_le_bytes(array(bytes, offset, endian)?)),
            Self::U32 => f64::from(u32::from_le_bytes(array(bytes, offset, endian)?)),
            Self::I64 => i64::from_le_bytes(array(bytes, offset, endian)?) as f64,
            Self::U64 => u64::from_le_bytes(array(bytes, offset, endian)?) as f64,
            Self::F32 => f64::from(f32::from_le_bytes(array(bytes, offset, endian)?)),
            Self::F64 => f64::from_le_bytes(array(bytes, offset, endian)?),
        })
    }
}
