/// Numbers between 1/2 and 1 in no order, the same each time: a direction that no derivative is likely to be normal to but one
/// that is zero. None is a simple sum of others, as those of an arithmetic progression modulo 1 would be: the second difference
/// of an outcome in time would be normal to these.
///
/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014, figure 14.
#[derive(Default)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    pub fn next(&mut self) -> f64 {
        /// 2⁶⁴ over the golden ratio.
        const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
        const FACTORS: [u64; 2] = [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
        self.0 = self.0.wrapping_add(STEP);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(FACTORS[0]);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(FACTORS[1]);
        let bits = (mixed ^ mixed >> 31) >> 12;
        // The fraction of a number from 1 to 2.
        f64::from_bits(1.0_f64.to_bits() | bits) * 0.5
    }
}
