//! Arrays of numbers as a file holds them: bytes of one type, in place or decoded, converted where they are used.

use std::borrow::Cow;

use crate::loops::prelude::*;

use crate::doubles::{Doubles, stored};
use crate::error::Place;
use crate::io::input::Input;
use crate::io::text::Cursor;

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
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

/// Numbers that a task converts at a time.
const CHUNK: usize = 1 << 15;

/// A type of numbers.
trait Number: Copy + Sized {
    fn read(bytes: &[u8], big_endian: bool) -> Self;
    fn single(self) -> f32;
    fn double(self) -> f64;
    /// As a number of an element; `None` if it is negative or not whole.
    fn index(self) -> Option<u64>;
}

macro_rules! whole {
    ($($t:ty),*) => { $(impl Number for $t {
        #[inline]
        fn read(bytes: &[u8], big_endian: bool) -> Self {
            let bytes = bytes.first_chunk().copied().unwrap_or_default();
            if big_endian { Self::from_be_bytes(bytes) } else { Self::from_le_bytes(bytes) }
        }
        #[inline]
        fn single(self) -> f32 { self as f32 }
        #[inline]
        fn double(self) -> f64 { self as f64 }
        #[inline]
        fn index(self) -> Option<u64> { u64::try_from(self).ok() }
    })* };
}

macro_rules! real {
    ($($t:ty),*) => { $(impl Number for $t {
        #[inline]
        fn read(bytes: &[u8], big_endian: bool) -> Self {
            let bytes = bytes.first_chunk().copied().unwrap_or_default();
            if big_endian { Self::from_be_bytes(bytes) } else { Self::from_le_bytes(bytes) }
        }
        #[inline]
        fn single(self) -> f32 { self as f32 }
        #[inline]
        fn double(self) -> f64 { self as f64 }
        #[inline]
        fn index(self) -> Option<u64> {
            let value = self as f64;
            (value >= 0.0 && value.fract() == 0.0 && value < u64::MAX as f64).then_some(value as u64)
        }
    })* };
}

whole!(i8, u8, i16, u16, i32, u32, i64, u64);
real!(f32, f64);

/// Runs an expression with the type of a [`Scalar`].
macro_rules! typed {
    ($scalar:expr, $t:ident => $body:expr) => {
        typed!(@each $scalar, $t => $body;
            I8 i8, U8 u8, I16 i16, U16 u16, I32 i32, U32 u32, I64 i64, U64 u64, F32 f32, F64 f64)
    };
    (@each $scalar:expr, $t:ident => $body:expr; $($name:ident $own:ty),*) => {
        match $scalar {
            $(Scalar::$name => {
                type $t = $own;
                $body
            })*
        }
    };
}

impl Scalar {
    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub fn is_real(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Appends a number that is read from text, in the byte order of this machine, as far as the type holds it.
    pub fn push(self, value: Word, to: &mut Vec<u8>) {
        typed!(self, T => to.extend_from_slice(&match value {
            Word::Whole(n) => n as T,
            Word::Real(x) => x as T,
        }.to_ne_bytes()));
    }
}

/// A number of a text.
#[derive(Clone, Copy, Debug)]
pub enum Word {
    Whole(i64),
    Real(f64),
}

/// Where numbers come from, for messages.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// The bytes are those of the file from here on.
    Raw(u64),
    /// They were read from this text, which begins at a line.
    Text(&'a [u8], u64),
    /// They were encoded, and began here.
    Encoded(Place),
}

/// Numbers of one type.
#[derive(Clone, Debug)]
pub struct Numbers<'a> {
    pub bytes: Cow<'a, [u8]>,
    pub scalar: Scalar,
    pub big_endian: bool,
    pub source: Source<'a>,
    /// The file whose bytes these are; `None` if they are decoded.
    pub input: Option<&'a Input>,
}

impl Numbers<'_> {
    pub fn len(&self) -> usize {
        self.bytes.len() / self.scalar.bytes()
    }

    /// Where in the file a number is.
    pub fn place(&self, index: usize) -> Place {
        match self.source {
            Source::Raw(at) => Place::Byte(at + (index * self.scalar.bytes()) as u64),
            Source::Encoded(place) => place,
            Source::Text(text, line) => {
                let mut cursor = Cursor::new(text, line);
                for _ in 0..index {
                    cursor.skip_space();
                    cursor.word();
                }
                cursor.skip_space();
                Place::Line(cursor.line())
            }
        }
    }

    /// A number.
    pub fn double(&self, index: usize) -> f64 {
        let size = self.scalar.bytes();
        let bytes = self.bytes.get(index * size..).unwrap_or_default();
        typed!(self.scalar, T => T::read(bytes, self.big_endian).double())
    }

    /// A number as that of an element; `None` if it is none.
    pub fn index(&self, index: usize) -> Option<u64> {
        let size = self.scalar.bytes();
        let bytes = self.bytes.get(index * size..).unwrap_or_default();
        typed!(self.scalar, T => T::read(bytes, self.big_endian).index())
    }

    /// So many single bits of packed bytes, the highest of each byte first, as numbers 0 and 1; missing ones are 0.
    pub fn bits(self, count: usize) -> Self {
        let bit = |i: usize| self.bytes.get(i / 8).map_or(0, |byte| byte >> (7 - i % 8) & 1);
        let bytes = (0..count).map(bit).collect::<Vec<u8>>().into();
        Self { bytes, scalar: Scalar::U8, input: None, ..self }
    }

    /// Reports that so many of its bytes were read.
    pub fn consumed(&self, bytes: usize) {
        if let Some(input) = self.input {
            input.consumed(bytes);
        }
    }

    /// All numbers as those of elements below `limit`, or the position of the first that is none.
    pub fn indices(&self, limit: u64) -> Result<Vec<u32>, usize> {
        fn convert<T: Number>(numbers: &Numbers, limit: u64) -> Result<Vec<u32>, usize> {
            let size = numbers.scalar.bytes();
            let limit = limit.min(1 << 32);
            let mut values = vec![0u32; numbers.len()];
            let wrong = values
                .par_chunks_mut(CHUNK)
                .zip(numbers.bytes.par_chunks(CHUNK * size))
                .enumerate()
                .map(|(chunk, (values, bytes))| {
                    numbers.consumed(bytes.len());
                    let mut good = true;
                    for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(size)) {
                        let index = T::read(bytes, numbers.big_endian).index().unwrap_or(u64::MAX);
                        good &= index < limit;
                        *value = index as u32;
                    }
                    if good {
                        return usize::MAX;
                    }
                    let is_wrong =
                        |b: &[u8]| T::read(b, numbers.big_endian).index().is_none_or(|index| index >= limit);
                    CHUNK * chunk + bytes.chunks_exact(size).position(is_wrong).unwrap_or_default()
                });
            match wrong.reduce(|| usize::MAX, usize::min) {
                usize::MAX => Ok(values),
                wrong => Err(wrong),
            }
        }
        typed!(self.scalar, T => convert::<T>(self, limit))
    }

    /// One component of tuples of `of`, as `f32` and less an offset: of all tuples, or of those with these numbers.
    pub fn component(&self, component: usize, of: usize, tuples: Option<&[u32]>, offset: f64) -> Vec<f32> {
        fn convert<T: Number>(
            numbers: &Numbers,
            component: usize,
            of: usize,
            tuples: Option<&[u32]>,
            offset: f64,
        ) -> Vec<f32> {
            let size = numbers.scalar.bytes();
            let (stride, first) = (of * size, component * size);
            let count = numbers.len() / of.max(1);
            let mut values = vec![0f32; tuples.map_or(count, <[u32]>::len)];
            let read = |bytes: Option<&[u8]>| {
                let number = T::read(bytes.unwrap_or_default(), numbers.big_endian);
                if offset == 0.0 { number.single() } else { stored(number.double(), offset) }
            };
            match tuples {
                None => values.par_chunks_mut(CHUNK).zip(numbers.bytes.par_chunks(CHUNK * stride)).for_each(
                    |(values, bytes)| {
                        numbers.consumed(bytes.len());
                        for (value, tuple) in values.iter_mut().zip(bytes.chunks_exact(stride)) {
                            *value = read(tuple.get(first..));
                        }
                    },
                ),
                Some(tuples) => {
                    values.par_chunks_mut(CHUNK).zip(tuples.par_chunks(CHUNK)).for_each(
                        |(values, tuples)| {
                            numbers.consumed(tuples.len() * stride);
                            for (value, &tuple) in values.iter_mut().zip(tuples) {
                                *value = read(numbers.bytes.get(tuple as usize * stride + first..));
                            }
                        },
                    );
                }
            }
            values
        }
        typed!(self.scalar, T => convert::<T>(self, component, of, tuples, offset))
    }

    /// Tuples of `of` numbers, of which `N` are taken and missing ones are 0: all, or those with these numbers.
    pub fn tuples<const N: usize, V: Send + Sync + Default + Clone>(
        &self,
        of: usize,
        tuples: Option<&[u32]>,
        value: impl Fn([f64; N]) -> V + Sync,
    ) -> Vec<V> {
        fn convert<T: Number, const N: usize, V: Send + Sync + Default + Clone>(
            numbers: &Numbers,
            of: usize,
            tuples: Option<&[u32]>,
            value: impl Fn([f64; N]) -> V + Sync,
        ) -> Vec<V> {
            let count = tuples.map_or(numbers.len() / of.max(1), <[u32]>::len);
            let size = numbers.scalar.bytes();
            let stride = of * size;
            let mut values = vec![V::default(); count];
            values.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, values)| {
                numbers.consumed(values.len() * stride);
                for (i, slot) in values.iter_mut().enumerate() {
                    let i = chunk * CHUNK + i;
                    let tuple = tuples.map_or(i, |t| t.get(i).map_or(0, |&t| t as usize));
                    let bytes = numbers.bytes.get(tuple * stride..).unwrap_or_default();
                    let mut tuple = [0.0; N];
                    for (k, number) in tuple.iter_mut().enumerate().take(of) {
                        let bytes = bytes.get(k * size..).unwrap_or_default();
                        *number = T::read(bytes, numbers.big_endian).double();
                    }
                    *slot = value(tuple);
                }
            });
            values
        }
        typed!(self.scalar, T => convert::<T, N, V>(self, of, tuples, value))
    }

    /// Points of three numbers each as `f32`.
    pub fn points32(&self) -> Vec<[f32; 3]> {
        fn convert<T: Number>(numbers: &Numbers) -> Vec<[f32; 3]> {
            let size = numbers.scalar.bytes();
            let mut points = vec![[0f32; 3]; numbers.len() / 3];
            points.par_chunks_mut(CHUNK).zip(numbers.bytes.par_chunks(3 * CHUNK * size)).for_each(
                |(points, bytes)| {
                    numbers.consumed(bytes.len());
                    let values = points.as_flattened_mut().iter_mut().zip(bytes.chunks_exact(size));
                    values.for_each(|(value, bytes)| *value = T::read(bytes, numbers.big_endian).single());
                },
            );
            points
        }
        typed!(self.scalar, T => convert::<T>(self))
    }

    /// What decides about the offset of one component of tuples of `of`; nothing of types all of whose numbers `f32` holds.
    pub fn doubles(&self, component: usize, of: usize) -> Doubles {
        fn fold<T: Number>(numbers: &Numbers, component: usize, of: usize) -> Doubles {
            let size = numbers.scalar.bytes();
            let chunk = |bytes: &[u8]| {
                let tuples = bytes.chunks_exact(of * size).filter_map(|tuple| tuple.get(component * size..));
                let number = |bytes: &[u8]| T::read(bytes, numbers.big_endian).double();
                tuples.fold(Doubles::default(), |all, tuple| all.with(number(tuple)))
            };
            let chunks = numbers.bytes.par_chunks(CHUNK * of * size);
            chunks.map(chunk).reduce(Doubles::default, Doubles::and)
        }
        if matches!(self.scalar, Scalar::F32) || self.scalar.bytes() < 4 || of == 0 {
            return Doubles::default();
        }
        typed!(self.scalar, T => fold::<T>(self, component, of))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(scalar: Scalar, values: &[f64], big_endian: bool) -> Numbers<'static> {
        let mut bytes = Vec::new();
        values.iter().for_each(|&v| scalar.push(Word::Real(v), &mut bytes));
        if big_endian != cfg!(target_endian = "big") {
            bytes.chunks_exact_mut(scalar.bytes()).for_each(<[u8]>::reverse);
        }
        Numbers { bytes: bytes.into(), scalar, big_endian, source: Source::Raw(100), input: None }
    }

    #[test]
    fn bits_are_unpacked_from_the_highest_one() {
        let bits = of(Scalar::U8, &[0b1010_0001.into(), 0b0100_0000.into()], false).bits(10);
        assert_eq!(bits.bytes[..], [1, 0, 1, 0, 0, 0, 0, 1, 0, 1]);
    }

    #[test]
    fn every_type_and_byte_order_holds_its_numbers() {
        use Scalar::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        for scalar in [I8, U8, I16, U16, I32, U32, I64, U64, F32, F64] {
            for big_endian in [false, true] {
                let values: Vec<f64> = (0..12).map(|i| f64::from(i * 9 % 100)).collect();
                let numbers = of(scalar, &values, big_endian);
                assert_eq!(numbers.len(), 12);
                assert_eq!((0..12).map(|i| numbers.double(i)).collect::<Vec<_>>(), values);
                let indices = numbers.indices(100).expect("all are below");
                assert_eq!(indices, values.iter().map(|&v| v as u32).collect::<Vec<_>>());
                assert_eq!(numbers.indices(90), Err(10));
                assert_eq!(numbers.place(10), Place::Byte(100 + 10 * scalar.bytes() as u64));
                assert_eq!(numbers.component(1, 3, None, 0.0), [9.0, 36.0, 63.0, 90.0]);
                assert_eq!(numbers.component(2, 4, Some(&[2, 0]), 10.0), [80.0, 8.0]);
                assert_eq!(numbers.points32()[1], [27.0, 36.0, 45.0]);
                let pairs = numbers.tuples(4, Some(&[1]), |[a, b]: [f64; 2]| [a, b]);
                assert_eq!(pairs, [[36.0, 45.0]]);
                assert_eq!(numbers.doubles(0, 1).offset(), 0.0);
            }
        }
        assert!(of(I64, &[3e9 + 1.0, 1.0], false).doubles(0, 1).warning("id", true).is_some());
        assert_eq!(of(I64, &[1.0, 3e9 + 1.0, 2.0, 3e9 + 2.0], true).doubles(1, 2).offset(), 3e9 + 1.0);
        assert_eq!(of(I64, &[3e9, -1.0], false).indices(u64::MAX), Err(1));
        assert_eq!(of(F64, &[1.5], false).indices(9), Err(0));
    }
}
