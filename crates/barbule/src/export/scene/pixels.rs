//! Pictures of single-precision numbers.

/// A picture of single-precision numbers (PFM), in colour or grey, whose rows go from the bottom.
pub(super) fn portable_floats<const CHANNELS: usize>(
    [width, height]: [usize; 2],
    texel: impl Fn(usize, usize) -> [f32; CHANNELS],
) -> Vec<u8> {
    let kind = if CHANNELS == 1 { "Pf" } else { "PF" };
    let mut bytes = format!("{kind}\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(4 * CHANNELS * width * height);
    for y in (0..height).rev() {
        for x in 0..width {
            bytes.extend(texel(x, y).into_iter().flat_map(f32::to_le_bytes));
        }
    }
    bytes
}
