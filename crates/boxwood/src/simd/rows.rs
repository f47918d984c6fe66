//! Rows of lanes of which one is chosen while running, without asking each time whether it is there.

/// `R` rows of `N` lanes; `R` is even.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Rows<const N: usize, const R: usize>(pub [[f32; N]; R]);

/// One of the rows: how many bytes lie before it, which is what a load wants to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row<const N: usize, const R: usize>(u32);

impl<const N: usize, const R: usize> Row<N, R> {
    /// Row 0.
    pub const FIRST: Self = {
        let () = Self::FITS;
        Self(0)
    };
    const FITS: () = assert!(
        N.is_power_of_two() && R.is_multiple_of(2) && R > 0,
        "pairs of rows, each as long as a power of two"
    );
    const BYTES: u32 = size_of::<[f32; N]>() as u32;

    /// Row `index`.
    ///
    /// # Panics
    /// When there are fewer.
    #[inline(always)]
    pub fn new(index: usize) -> Self {
        let () = Self::FITS;
        assert!(index < R, "a row that is there");
        Self(index as u32 * Self::BYTES)
    }

    /// The other one of rows 0 and 1, 2 and 3, and so on.
    #[inline(always)]
    pub fn neighbour(self) -> Self {
        Self(self.0 ^ Self::BYTES)
    }
}

impl<const N: usize, const R: usize> Rows<N, R> {
    /// A row.
    #[inline(always)]
    pub fn at(&self, row: Row<N, R>) -> &[f32; N] {
        // SAFETY: only `FIRST`, `new` and `neighbour` make a `Row`: the start of one of `R` rows, since the number of rows
        // is even and the size of one a power of two, as the first two have asserted.
        unsafe { &*self.0.as_ptr().byte_add(row.0 as usize) }
    }
}

/// `R` rows of `N` bytes, chosen by a [`Row`] too.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(4))]
pub struct ByteRows<const N: usize, const R: usize>(pub [[u8; N]; R]);

impl<const N: usize, const R: usize> ByteRows<N, R> {
    /// A row.
    #[inline(always)]
    pub fn at(&self, row: Row<N, R>) -> &[u8; N] {
        let before = row.0 as usize / size_of::<f32>();
        // SAFETY: as for `Rows::at`; a row of bytes begins at a quarter of where one of floats does.
        unsafe { &*self.0.as_ptr().byte_add(before) }
    }
}
