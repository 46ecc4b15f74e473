//! Arrays of numbers.

use super::{Parser, STEP};
use crate::ReadError;
use crate::error::{counted, printable};
use crate::io::vtk::numbers::{Numbers, Scalar, Source, Word};

/// Type of an array in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    Numbers(Scalar),
    /// Eight to a byte.
    Bits,
    /// Bytes, which text holds divided by 255.
    Colors,
    Text,
}

impl Type {
    pub fn parse(word: &[u8]) -> Option<Self> {
        let word = word.to_ascii_lowercase();
        Some(Self::Numbers(match std::str::from_utf8(&word).ok()? {
            "bit" => return Some(Self::Bits),
            "string" | "utf8_string" | "unicode_string" => return Some(Self::Text),
            "char" | "signed_char" | "vtktypeint8" => Scalar::I8,
            "unsigned_char" | "vtktypeuint8" => Scalar::U8,
            "short" | "vtktypeint16" => Scalar::I16,
            "unsigned_short" | "vtktypeuint16" => Scalar::U16,
            // VTK writes its own type of numbers in 32 bits.
            "int" | "vtkidtype" | "vtktypeint32" => Scalar::I32,
            "unsigned_int" | "vtktypeuint32" => Scalar::U32,
            "long" | "long_long" | "vtktypeint64" => Scalar::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Scalar::U64,
            "float" | "vtktypefloat32" => Scalar::F32,
            "double" | "vtktypefloat64" => Scalar::F64,
            _ => return None,
        }))
    }
}

impl<'a> Parser<'_, 'a> {
    /// The type of an array, which the line holds next.
    pub fn scalar_type(&mut self) -> Result<Type, ReadError> {
        let before = self.cursor.clone();
        let word = self.word("the type of an array")?;
        Type::parse(word).ok_or_else(|| {
            self.cursor = before;
            self.expected("the type of an array (float, double, int, unsigned_char, …)")
        })
    }

    /// So many numbers of a type of numbers; the cursor is on the line before them.
    pub fn numbers(&mut self, what: &str, count: u64, kind: Type) -> Result<Numbers<'a>, ReadError> {
        match kind {
            Type::Numbers(scalar) if self.binary => {
                self.cursor.skip_line();
                self.binary_numbers(what, count, scalar)
            }
            Type::Numbers(scalar) => self.ascii_numbers(what, count, scalar),
            Type::Bits if !self.binary => self.ascii_numbers(what, count, Scalar::U8),
            Type::Bits => {
                self.cursor.skip_line();
                self.job.reserve(what, count)?;
                let packed = self.binary_numbers(what, count.div_ceil(8), Scalar::U8)?;
                Ok(packed.bits(count as usize))
            }
            Type::Colors if self.binary => self.numbers(what, count, Type::Numbers(Scalar::U8)),
            Type::Colors => self.ascii_colors(what, count),
            Type::Text => Err(self.expected(format!("numbers for {what}, not strings"))),
        }
    }

    fn binary_numbers(&mut self, what: &str, count: u64, scalar: Scalar) -> Result<Numbers<'a>, ReadError> {
        let rest = self.cursor.rest();
        let needed = count.saturating_mul(scalar.bytes() as u64);
        if needed > rest.len() as u64 {
            let expected = format!("{} of {what} in {needed} bytes", counted(count, "number"));
            let found = format!("{} up to the end of the file", counted(rest.len() as u64, "byte"));
            return Err(self.job.malformed(self.place(), expected, found));
        }
        let source = Source::Raw(self.cursor.offset() as u64);
        let bytes = self.cursor.take(needed as usize).into();
        Ok(Numbers { bytes, scalar, big_endian: true, source, input: Some(self.job.input) })
    }

    fn ascii_numbers(&mut self, what: &str, count: u64, scalar: Scalar) -> Result<Numbers<'a>, ReadError> {
        let (text, line) = (self.cursor.rest(), self.cursor.line());
        // Each takes a digit and a blank.
        if count > text.len() as u64 / 2 + 1 {
            let found = format!("{} up to the end of the file", counted(text.len() as u64, "byte"));
            return Err(self.job.malformed(
                self.place(),
                format!("{} of {what}", counted(count, "number")),
                found,
            ));
        }
        self.job.reserve(what, count * scalar.bytes() as u64)?;
        let mut bytes = Vec::with_capacity(count as usize * scalar.bytes());
        for i in 0..count {
            self.cursor.skip_space();
            if self.cursor.offset() - self.reported >= STEP {
                self.report();
            }
            let value = if scalar.is_real() { None } else { self.cursor.integer().map(Word::Whole) };
            let value = value.or_else(|| self.cursor.float().map(Word::Real)).or_else(|| self.not_a_number());
            match value {
                Some(value) => scalar.push(value, &mut bytes),
                None => return Err(self.expected(format!("number {i} of {count} of {what}"))),
            }
        }
        let big_endian = cfg!(target_endian = "big");
        Ok(Numbers { bytes: bytes.into(), scalar, big_endian, source: Source::Text(text, line), input: None })
    }

    /// Colours of text as the bytes that they were before they were divided, rounded as VTK does.
    fn ascii_colors(&mut self, what: &str, count: u64) -> Result<Numbers<'a>, ReadError> {
        let divided = self.ascii_numbers(what, count, Scalar::F32)?;
        self.job.reserve(what, 5 * count)?;
        let mut are_outside = false;
        let byte = |value: f32| {
            let byte = (255.0 * value + 0.5).floor();
            are_outside |= !(0.0..=255.0).contains(&byte);
            byte as u8
        };
        let bytes: Vec<u8> = divided.component(0, 1, None, 0.0).into_iter().map(byte).collect();
        if are_outside {
            // Where VTK begins again at 0.
            self.job.warn(format!("{what} has colours outside 0 to 1, which are taken as 0 or 1"));
        }
        Ok(Numbers { bytes: bytes.into(), scalar: Scalar::U8, ..divided })
    }

    /// NaN as some C libraries print it.
    fn not_a_number(&mut self) -> Option<Word> {
        let word = self.cursor.clone().word().to_ascii_lowercase();
        let is_nan = ["-nan", "nan(", "-nan(", "+nan"].iter().any(|n| word.starts_with(n.as_bytes()));
        is_nan.then(|| {
            self.cursor.word();
            Word::Real(f64::NAN)
        })
    }

    /// Skips strings.
    pub fn skip_strings(&mut self, what: &str, count: u64) -> Result<(), ReadError> {
        self.cursor.skip_line();
        if count > self.cursor.rest().len() as u64 {
            return Err(self.expected(format!("{} of {what}", counted(count, "string"))));
        }
        for _ in 0..count {
            if !self.binary {
                self.cursor.skip_line();
                continue;
            }
            // The two highest bits say in how many bytes the length is.
            let rest = self.cursor.rest();
            let bytes = match rest.first().map(|b| b >> 6) {
                Some(3) => 1,
                Some(2) => 2,
                Some(1) => 4,
                _ => 8,
            };
            let length = rest.get(..bytes).map(|head| {
                let number = head.iter().fold(0u64, |n, &b| n << 8 | u64::from(b));
                number & (u64::MAX >> (64 - 8 * bytes + 2))
            });
            match length.filter(|&n| n <= (rest.len() - bytes) as u64) {
                Some(length) => self.cursor.take(bytes + length as usize),
                None => {
                    let found = printable(rest.get(..8).unwrap_or(rest));
                    return Err(self.job.malformed(self.place(), format!("a string of {what}"), found));
                }
            };
        }
        Ok(())
    }
}
