//! CPU twin of glsl/maps/bins/mark.comp, scan.comp and compact.comp: the casters that meet some tile, in drawing order.

/// Number of 32-bit words in a block of bits. Twin: BLOCK_WORDS in glsl/maps/bins/marks.glsl.
pub const BLOCK_WORDS: usize = 64;

/// Returns one bit per caster in drawing order, set if it meets some tile, in whole blocks of words; and the number of set bits per block.
pub fn mark(order: &[u32], met: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let word = |casters: &[u32]| casters.iter().rev().fold(0u32, |bits, c| bits << 1 | u32::from(met[*c as usize]));
    let mut words: Vec<u32> = order.chunks(32).map(word).collect();
    words.resize(words.len().next_multiple_of(BLOCK_WORDS), 0);
    let blocks = words.chunks(BLOCK_WORDS).map(|block| block.iter().map(|w| w.count_ones()).sum()).collect();
    (words, blocks)
}

/// Returns the number of set bits before each block, and in total.
pub fn scan(blocks: &[u32]) -> (Vec<u32>, u32) {
    let mut sum = 0;
    let before = blocks
        .iter()
        .map(|block| {
            sum += block;
            sum - block
        })
        .collect();
    (before, sum)
}

/// Returns the casters whose bits are set; each block's casters start at the block's entry in `before`.
pub fn compact(order: &[u32], words: &[u32], before: &[u32], total: u32) -> Vec<u32> {
    let mut drawn = vec![u32::MAX; total as usize];
    for (block, (words, before)) in words.chunks(BLOCK_WORDS).zip(before).enumerate() {
        let set = (0..32 * BLOCK_WORDS).filter(|i| words[i / 32] >> (i % 32) & 1 == 1);
        for (place, i) in (*before as usize..).zip(set) {
            drawn[place] = order[block * 32 * BLOCK_WORDS + i];
        }
    }
    drawn
}
