use crate::contact::sums::PartialSum;

/// A quantity that is added up for each taxel.
pub(super) trait TaxelQuantity: Send {
    /// Creates a quantity that is zero, for a taxel at a row and a column.
    fn zero(taxel: [usize; 2]) -> Self;

    /// Returns the row and the column of the taxel.
    fn taxel(&self) -> [usize; 2];

    /// Adds a quantity of the same taxel.
    fn add(&mut self, other: &Self);
}

/// Number of sums for which memory is reserved with the first sum.
const CAPACITY: usize = 128;

/// Sums for the taxels of a grid. Only taxels to which something was added have a sum.
#[derive(Debug, Clone)]
pub(super) struct TaxelSums<S> {
    sums: Vec<S>,
    /// Row-major: 1 + the index in `sums`, or 0 for taxels without a sum. Empty if no taxel has a sum.
    entries: Vec<u32>,
    column_count: usize,
}

impl<S: TaxelQuantity> TaxelSums<S> {
    /// Returns the sums, in no particular order.
    pub fn as_slice(&self) -> &[S] {
        &self.sums
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut S> {
        self.sums.iter_mut()
    }

    /// Applies a function to each sum.
    pub fn map<R>(&self, function: impl Fn(&S) -> R) -> TaxelSums<R> {
        TaxelSums {
            sums: self.sums.iter().map(function).collect(),
            entries: self.entries.clone(),
            column_count: self.column_count,
        }
    }

    /// Returns the index in [`Self::as_slice`] of the sum of a taxel of the grid, or `None` if the taxel has no sum.
    pub fn index(&self, [row, column]: [usize; 2]) -> Option<usize> {
        let entry = self.entries.get(row * self.column_count + column)?;
        (*entry as usize).checked_sub(1)
    }

    /// Returns the sum of a taxel of a grid with these numbers of rows and columns. A new sum is zero. All calls must have the same numbers
    /// of rows and columns.
    #[inline(always)]
    pub fn sum_mut(&mut self, taxel: [usize; 2], [row_count, column_count]: [usize; 2]) -> &mut S {
        if self.entries.is_empty() {
            self.entries = vec![0; row_count * column_count];
            self.column_count = column_count;
            self.sums.reserve(CAPACITY);
        }
        self.existing_or_zero(taxel)
    }

    /// Returns the sum of a taxel. A new sum is zero. There must be an entry for the taxel.
    #[inline(always)]
    fn existing_or_zero(&mut self, taxel: [usize; 2]) -> &mut S {
        let [row, column] = taxel;
        let entry = &mut self.entries[row * self.column_count + column];
        if *entry == 0 {
            self.sums.push(S::zero(taxel));
            *entry = u32::try_from(self.sums.len()).unwrap_or_default();
        }
        &mut self.sums[*entry as usize - 1]
    }
}

impl<S: TaxelQuantity> PartialSum for TaxelSums<S> {
    fn empty() -> Self {
        Self {
            sums: Vec::new(),
            entries: Vec::new(),
            column_count: 0,
        }
    }

    fn merge(&mut self, next: Self) {
        if self.sums.is_empty() {
            *self = next;
            return;
        }
        for sum in &next.sums {
            self.existing_or_zero(sum.taxel()).add(sum);
        }
    }
}
