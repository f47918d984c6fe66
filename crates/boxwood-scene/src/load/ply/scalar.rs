//! The eight types of number that a PLY file may hold.

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// `char` or `int8`.
    I8,
    /// `uchar` or `uint8`.
    U8,
    /// `short` or `int16`.
    I16,
    /// `ushort` or `uint16`.
    U16,
    /// `int` or `int32`.
    I32,
    /// `uint` or `uint32`.
    U32,
    /// `float` or `float32`.
    F32,
    /// `double` or `float64`.
    F64,
}

impl Scalar {
    /// For messages.
    pub const NAMES: &'static str = "char, uchar, short, ushort, int, uint, float, double, or int8, uint8, int16, \
                                     uint16, int32, uint32, float32, float64";

    /// The type that a header calls by this name.
    pub fn of_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether it holds whole numbers only.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The number at the start of `bytes`, rounded once; `None` where they end too early.
    #[inline]
    pub fn float<const BIG: bool>(self, bytes: &[u8]) -> Option<f32> {
        Some(match self {
            Self::F32 => f32::from_bits(u32::from_le_bytes(take::<4, BIG>(bytes)?)),
            Self::F64 => f64::from_bits(u64::from_le_bytes(take::<8, BIG>(bytes)?)) as f32,
            _ => self.integer::<BIG>(bytes)? as f32,
        })
    }

    /// The whole number at the start of `bytes` (of a float, what is before its point); `None` where they end too
    /// early.
    #[inline]
    pub fn integer<const BIG: bool>(self, bytes: &[u8]) -> Option<i64> {
        Some(match self {
            Self::I8 => i8::from_le_bytes(take::<1, BIG>(bytes)?).into(),
            Self::U8 => u8::from_le_bytes(take::<1, BIG>(bytes)?).into(),
            Self::I16 => i16::from_le_bytes(take::<2, BIG>(bytes)?).into(),
            Self::U16 => u16::from_le_bytes(take::<2, BIG>(bytes)?).into(),
            Self::I32 => i32::from_le_bytes(take::<4, BIG>(bytes)?).into(),
            Self::U32 => u32::from_le_bytes(take::<4, BIG>(bytes)?).into(),
            Self::F32 => f32::from_le_bytes(take::<4, BIG>(bytes)?) as i64,
            Self::F64 => f64::from_le_bytes(take::<8, BIG>(bytes)?) as i64,
        })
    }
}

/// The first `N` bytes, least significant first.
#[inline]
fn take<const N: usize, const BIG: bool>(bytes: &[u8]) -> Option<[u8; N]> {
    let mut bytes = *bytes.first_chunk()?;
    if BIG {
        bytes.reverse();
    }
    Some(bytes)
}
