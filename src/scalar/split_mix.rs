/// A deterministic pseudo-random sequence in [1/2, 1), used as the components of a direction.
///
/// Such a direction is unlikely to be orthogonal to any nonzero derivative. No number of the
/// sequence is a simple sum of other numbers. An arithmetic progression modulo 1 has such sums, so
/// the second difference of an outcome in time would be orthogonal to it.
///
/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014, figure 14.
#[derive(Default)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    pub fn next(&mut self) -> f64 {
        /// 2⁶⁴ divided by the golden ratio.
        const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
        const FACTORS: [u64; 2] = [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
        self.0 = self.0.wrapping_add(STEP);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(FACTORS[0]);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(FACTORS[1]);
        let bits = (mixed ^ mixed >> 31) >> 12;
        // A number in [1, 2) with these bits as its fraction, halved.
        f64::from_bits(1.0_f64.to_bits() | bits) * 0.5
    }
}
