//! Deflate (RFC 1951) for filtered rows of pictures: bytes, and runs of zeros, where nothing changes from row to row.
//!
//! Nothing else is searched for: that would take longer than drawing the picture. The code is made for each block, of some of its
//! rows.

use simd_adler32::Adler32;

use super::huffman::{SYMBOLS, lengths, words};

/// The longest code word. Four of them and the bits of a byte that is not complete fit into 64 bits.
const LONGEST: u8 = 14;
const END: usize = 256;
/// Lengths of repetitions: the first length of each symbol from 257 on; the bits that say which of its lengths follow the symbol.
const RUNS: [(u16, u8); 29] = {
    let mut runs = [(0, 0); 29];
    let (mut first, mut symbol) = (3, 0);
    while symbol < 28 {
        let extra = if symbol < 8 { 0 } else { (symbol / 4 - 1) as u8 };
        runs[symbol] = (first, extra);
        first += 1 << extra;
        symbol += 1;
    }
    runs[28] = (LONGEST_RUN as u16, 0);
    runs
};
const LONGEST_RUN: usize = 258;

/// Takes the content of a block.
pub trait Content {
    /// Bytes.
    fn bytes(&mut self, bytes: &[u8]);
    /// A run of zeros.
    fn zeros(&mut self, count: usize);
}

/// How a run of zeros is written: a zero, repetitions of the byte before them, and again zeros, if too few are left for a repetition.
struct Run {
    longest: usize,
    /// Between 3 and 257.
    last: Option<usize>,
    zeros: usize,
}

impl Run {
    fn new(count: usize) -> Self {
        let repeated = count.saturating_sub(1);
        let (longest, rest) = (repeated / LONGEST_RUN, repeated % LONGEST_RUN);
        let first = usize::from(count > 0);
        if rest < 3 {
            Self { longest, last: None, zeros: first + rest }
        } else {
            Self { longest, last: Some(rest), zeros: first }
        }
    }
}

/// Which of [`RUNS`] has this length.
fn run_symbol(length: usize) -> usize {
    RUNS.partition_point(|&(first, _)| usize::from(first) <= length).saturating_sub(1)
}

/// How often each symbol is in a part of a block.
pub struct Counts([u32; SYMBOLS]);

impl Default for Counts {
    fn default() -> Self {
        Self([0; SYMBOLS])
    }
}

impl Content for Counts {
    fn bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.0[usize::from(byte)] += 1);
    }

    fn zeros(&mut self, count: usize) {
        let run = Run::new(count);
        self.0[0] += run.zeros as u32;
        self.0[END + 29] += run.longest as u32;
        if let Some(length) = run.last {
            self.0[END + 1 + run_symbol(length)] += 1;
        }
    }
}

/// Bits, the first of each byte lowest.
struct Bits {
    /// Bytes, and room behind them.
    out: Vec<u8>,
    last: Word,
}

/// The end of some bits.
#[derive(Clone, Copy, Default)]
struct Word {
    /// The number of whole bytes.
    end: usize,
    /// The bits after those, and how many: fewer than 8 when they are written.
    bits: u64,
    count: u32,
}

impl Word {
    /// Appends the bits of symbols.
    #[inline(always)]
    fn add(&mut self, code: Code) {
        self.bits |= u64::from(code.word) << self.count;
        self.count += code.length;
    }

    /// Moves whole bytes, at most 7, to where there is room for 8.
    #[inline(always)]
    fn write(&mut self, out: &mut [u8]) {
        if let Some(to) = out.get_mut(self.end..self.end + 8) {
            to.copy_from_slice(&self.bits.to_le_bytes());
        }
        self.end += self.count as usize / 8;
        self.bits >>= self.count & !7;
        self.count &= 7;
    }
}

impl Bits {
    /// Makes room for so many bytes, and for one more word: bits are written in words.
    fn make_room(&mut self, bytes: usize) {
        let needed = self.last.end + bytes + 8;
        if self.out.len() < needed {
            self.out.resize(needed.max(self.out.len() * 2), 0);
        }
    }

    /// Appends at most 56 bits.
    fn put(&mut self, bits: u64, count: u32) {
        self.make_room(8);
        self.last.bits |= bits << self.last.count;
        self.last.count += count;
        self.last.write(&mut self.out);
    }
}

/// The word of a symbol, or of several symbols after each other.
#[derive(Clone, Copy)]
struct Code {
    word: u32,
    length: u32,
}

impl Code {
    /// The words of two symbols, together at most 32 bits.
    #[inline(always)]
    fn then(self, next: Self) -> Self {
        Self { word: self.word | next.word << self.length, length: self.length + next.length }
    }
}

/// A part of a stream that is being written: one block.
pub struct Block {
    bits: Bits,
    codes: [Code; SYMBOLS],
    checksum: Adler32,
    length: usize,
}

/// A block as bytes.
pub struct Written {
    pub bytes: Vec<u8>,
    /// Adler-32 of its content.
    checksum: u32,
    length: usize,
}

impl Block {
    /// Begins a block, the last one of its stream or not, whose symbols have about these counts.
    pub fn new(counts: &Counts, is_last: bool) -> Self {
        // Krichevsky and Trofimov: what was not counted may be there half a time.
        let lengths = lengths(counts.0.map(|count| 2 * count + 1), LONGEST);
        let words = words(&lengths);
        let code = |symbol: usize| Code { word: words[symbol].into(), length: lengths[symbol].into() };
        let mut block = Self {
            bits: Bits { out: Vec::new(), last: Word::default() },
            codes: std::array::from_fn(code),
            checksum: Adler32::new(),
            length: 0,
        };
        block.bits.put(u64::from(is_last) | 2 << 1, 3);
        block.put_code(&lengths);
        block
    }

    /// The lengths of the code's words, themselves compressed.
    fn put_code(&mut self, of_symbols: &[u8; SYMBOLS]) {
        const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
        const REPEAT: usize = 16;
        let mut all = of_symbols.to_vec();
        // The only distance of repetitions, 1.
        all.push(1);
        // Each length with how often it is repeated: not at all or 3 to 6 times.
        let mut items: Vec<(usize, u64)> = Vec::new();
        for same in all.chunk_by(|a, b| a == b) {
            let length = usize::from(same[0]);
            items.push((length, 0));
            let mut rest = same.len() - 1;
            while rest >= 3 {
                let repeated = rest.min(6);
                items.push((REPEAT, repeated as u64));
                rest -= repeated;
            }
            items.extend(std::iter::repeat_n((length, 0), rest));
        }
        let mut counts = [0; 19];
        items.iter().for_each(|&(symbol, _)| counts[symbol] += 1);
        let lengths = lengths(counts, 7);
        let words = words(&lengths);
        self.bits.put(SYMBOLS as u64 - 257, 5);
        self.bits.put(0, 5);
        self.bits.put(19 - 4, 4);
        ORDER.iter().for_each(|&symbol| self.bits.put(lengths[symbol].into(), 3));
        for (symbol, repeated) in items {
            self.bits.put(words[symbol].into(), lengths[symbol].into());
            if symbol == REPEAT {
                self.bits.put(repeated - 3, 2);
            }
        }
    }

    fn put_symbol(&mut self, symbol: usize) {
        let Code { word, length } = self.codes[symbol];
        self.bits.put(word.into(), length);
    }

    /// Ends the block. What follows, if it is not the last one, begins with a whole byte.
    pub fn finish(mut self, is_last: bool) -> Written {
        self.put_symbol(END);
        if !is_last {
            // An empty block that is not compressed, whose lengths begin with a whole byte.
            self.bits.put(0, 3);
        }
        self.bits.put(0, (8 - self.bits.last.count) % 8);
        if !is_last {
            self.bits.put(0xffff_0000, 32);
        }
        let mut bytes = self.bits.out;
        bytes.truncate(self.bits.last.end);
        Written { bytes, checksum: self.checksum.finish(), length: self.length }
    }
}

impl Content for Block {
    fn bytes(&mut self, bytes: &[u8]) {
        self.checksum.write(bytes);
        self.length += bytes.len();
        self.bits.make_room(bytes.len() * usize::from(LONGEST) / 8 + 8);
        let (fours, rest) = bytes.as_chunks::<4>();
        let (codes, bits) = (&self.codes, &mut self.bits);
        let code = |byte: u8| codes[usize::from(byte)];
        // Its own copy stays in registers: otherwise every store could change it.
        let Bits { out, last } = bits;
        let (out, mut own) = (&mut out[..], *last);
        for &[a, b, c, d] in fours {
            // At most 7 bits and 4 times 14.
            own.add(code(a).then(code(b)));
            own.add(code(c).then(code(d)));
            own.write(out);
        }
        for &byte in rest {
            own.add(code(byte));
        }
        own.write(out);
        *last = own;
    }

    fn zeros(&mut self, count: usize) {
        self.checksum = Adler32::from_checksum(after_zeros(self.checksum.finish(), count));
        self.length += count;
        let run = Run::new(count);
        (0..run.zeros).for_each(|_| self.put_symbol(0));
        let symbol = END + 29;
        // With the distance, a 0, each.
        let Code { word, length } = self.codes[symbol];
        (0..run.longest).for_each(|_| self.bits.put(word.into(), length + 1));
        if let Some(last) = run.last {
            let symbol = run_symbol(last);
            let (first, extra) = RUNS[symbol];
            self.put_symbol(END + 1 + symbol);
            self.bits.put(last as u64 - u64::from(first), u32::from(extra) + 1);
        }
    }
}

const MODULUS: u64 = 65521;

/// Adler-32 of something with this checksum and so many zeros.
fn after_zeros(checksum: u32, zeros: usize) -> u32 {
    let [a, b] = [checksum & 0xffff, checksum >> 16].map(u64::from);
    let b = (b + a * (zeros as u64 % MODULUS)) % MODULUS;
    (b << 16 | a) as u32
}

/// Adler-32 of the content of blocks after each other.
pub fn checksum(blocks: &[Written]) -> u32 {
    blocks.iter().fold(1, |all, block| {
        let [a, b] = [block.checksum & 0xffff, block.checksum >> 16].map(u64::from);
        let before = after_zeros(all, block.length);
        let [a0, b0] = [before & 0xffff, before >> 16].map(u64::from);
        // The checksum of nothing is 1, which both contain.
        let (a, b) =
            ((a0 + a + MODULUS - 1) % MODULUS, (b0 + b + MODULUS - block.length as u64 % MODULUS) % MODULUS);
        (b << 16 | a) as u32
    })
}
