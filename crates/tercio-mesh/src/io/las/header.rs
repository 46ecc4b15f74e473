//! The header.

use super::extra::Extra;
use crate::ReadError;
use crate::error::Place;
use crate::io::input::Input;

/// Bytes of the shortest header.
const SHORTEST: usize = 227;
/// Bytes of the header of version 1.4, which says where the extended records are.
const WITH_EXTENDED: usize = 375;
/// Bytes of the head of a record of variable length, and of an extended one, whose length has 64 bits.
const RECORD_HEAD: usize = 54;
const EXTENDED_HEAD: usize = 60;
/// User and number of the record that describes extra bytes.
const EXTRA_BYTES: (&str, u16) = ("LASF_Spec", 4);

/// Where a point has what.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Of the formats from 6 on.
    pub is_new: bool,
    pub gps: Option<usize>,
    pub rgb: Option<usize>,
    pub nir: Option<usize>,
    /// Bytes of a point without extra ones.
    pub bytes: usize,
}

impl Layout {
    /// That of a format.
    fn of(format: u8) -> Option<Self> {
        let old = Self { is_new: false, gps: None, rgb: None, nir: None, bytes: 20 };
        let new = Self { is_new: true, gps: Some(22), rgb: None, nir: None, bytes: 30 };
        Some(match format {
            0 => old,
            1 => Self { gps: Some(20), bytes: 28, ..old },
            2 => Self { rgb: Some(20), bytes: 26, ..old },
            3 => Self { gps: Some(20), rgb: Some(28), bytes: 34, ..old },
            4 => Self { gps: Some(20), bytes: 57, ..old },
            5 => Self { gps: Some(20), rgb: Some(28), bytes: 63, ..old },
            6 => new,
            7 => Self { rgb: Some(30), bytes: 36, ..new },
            8 => Self { rgb: Some(30), nir: Some(36), bytes: 38, ..new },
            9 => Self { bytes: 59, ..new },
            10 => Self { rgb: Some(30), nir: Some(36), bytes: 67, ..new },
            _ => return None,
        })
    }

    /// Extra bytes of a point in so many bytes.
    pub fn extra(&self, record: usize) -> Option<usize> {
        record.checked_sub(self.bytes)
    }
}

pub struct Header {
    minor: u8,
    format: u8,
    pub is_packed: bool,
    pub layout: Layout,
    /// Bytes of a point.
    pub record: usize,
    pub points: u64,
    pub scale: [f64; 3],
    pub offset: [f64; 3],
    /// Where the points begin.
    pub begin: usize,
    /// How points are compressed: a record of LASzip.
    pub laszip: Option<(usize, usize)>,
    /// What is known of the extra bytes of a point.
    pub extra: Extra,
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..)?.first_chunk().copied()
}

pub fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    number(bytes, at).map(u16::from_le_bytes)
}

pub fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    number(bytes, at).map(u32::from_le_bytes)
}

pub fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    number(bytes, at).map(u64::from_le_bytes)
}

pub fn f64_at(bytes: &[u8], at: usize) -> Option<f64> {
    number(bytes, at).map(f64::from_le_bytes)
}

impl Header {
    /// Is there one at the front?
    pub fn is_at(bytes: &[u8]) -> bool {
        bytes.starts_with(b"LASF")
            && bytes.len() >= SHORTEST
            && bytes.get(24) == Some(&1)
            && bytes.get(25).is_some_and(|&minor| minor <= 9)
            && u16_at(bytes, 94).is_some_and(|size| usize::from(size) >= SHORTEST)
    }

    /// For messages and reports.
    pub fn name(&self) -> String {
        let kind = if self.is_packed { "LAZ" } else { "LAS" };
        format!("{kind} 1.{}, point format {}", self.minor, self.format)
    }

    pub fn parse(input: &Input) -> Result<Self, ReadError> {
        let bytes = input.bytes();
        let malformed = |at: usize, expected: &str, found: String| {
            let place = Place::Byte(at as u64);
            ReadError::Malformed { file: input.name.clone(), place, expected: expected.into(), found }
        };
        let short = || malformed(bytes.len(), "a header of LAS", "the end of the file".into());
        if !Self::is_at(bytes) {
            let found = crate::error::printable(bytes.get(..8).unwrap_or(bytes));
            return Err(malformed(0, "a header of LAS", found));
        }
        let (minor, packed_format) = (bytes[25], bytes[104]);
        let format = packed_format & 0x3f;
        let unknown = || malformed(104, "a point format of 0 to 10", format.to_string());
        let layout = Layout::of(format).ok_or_else(unknown)?;
        let record = usize::from(u16_at(bytes, 105).ok_or_else(short)?);
        if layout.extra(record).is_none() {
            let expected = format!("at least {} bytes for points of format {format}", layout.bytes);
            return Err(malformed(105, &expected, record.to_string()));
        }
        let mut points = u64::from(u32_at(bytes, 107).ok_or_else(short)?);
        let size = usize::from(u16_at(bytes, 94).ok_or_else(short)?);
        if minor >= 4 && size >= 255 {
            let all = u64_at(bytes, 247).ok_or_else(short)?;
            points = if all == 0 { points } else { all };
        }
        let three = |at: usize| -> Option<[f64; 3]> {
            Some([f64_at(bytes, at)?, f64_at(bytes, at + 8)?, f64_at(bytes, at + 16)?])
        };
        let scale = three(131).ok_or_else(short)?;
        let offset = three(155).ok_or_else(short)?;
        for (k, value) in scale.iter().chain(&offset).enumerate() {
            let is_scale = k < 3;
            if !value.is_finite() || is_scale && *value == 0.0 {
                let expected = if is_scale { "a scale other than 0" } else { "a finite offset" };
                return Err(malformed(131 + 8 * k, expected, value.to_string()));
            }
        }
        for (k, (offset, scale)) in offset.iter().zip(&scale).enumerate() {
            // All points would be one, and may be too far away to be shown.
            let largest = scale * f64::from(i32::MAX);
            if !largest.is_finite() {
                let expected = format!("a scale of {} with which coordinates are finite", ["x", "y", "z"][k]);
                return Err(malformed(131 + 8 * k, &expected, format!("{scale:e}")));
            }
            let farthest = offset + largest;
            if farthest == *offset || !farthest.is_finite() || !(offset - largest).is_finite() {
                let axis = ["x", "y", "z"][k];
                let expected =
                    format!("an offset of {axis} beside which coordinates with a scale of {scale} differ");
                return Err(malformed(155 + 8 * k, &expected, format!("{offset:e}")));
            }
        }
        let begin = u32_at(bytes, 96).ok_or_else(short)? as usize;
        if begin < size || begin > bytes.len() {
            let expected = format!("points that begin at byte {size} to {}", bytes.len());
            return Err(malformed(96, &expected, begin.to_string()));
        }
        let is_packed = packed_format & 0xc0 != 0;
        let records = Records {
            bytes: bytes.get(..begin).unwrap_or_default(),
            at: size,
            count: u32_at(bytes, 100).ok_or_else(short)?,
            head: RECORD_HEAD,
        };
        let laszip = if is_packed {
            let found = records.find(laz::LazVlr::USER_ID, laz::LazVlr::RECORD_ID);
            Some(found.ok_or_else(|| {
                malformed(size, "a record \"laszip encoded\" before the points", "none".into())
            })?)
        } else {
            None
        };
        // Behind the points are records that were added later, or are too long for others.
        let extended = || {
            let has_them = minor >= 4 && size >= WITH_EXTENDED;
            let at = usize::try_from(u64_at(bytes, 235).filter(|_| has_them)?).ok()?;
            Some(Records { bytes, at, count: u32_at(bytes, 243)?, head: EXTENDED_HEAD })
        };
        let (user, number) = EXTRA_BYTES;
        let described = records.find(user, number).or_else(|| extended()?.find(user, number));
        let extra = match described {
            Some((from, to)) => {
                let mut extra = Extra::parse(bytes.get(from..to).unwrap_or_default(), layout.bytes, record);
                extra.mistake = extra.mistake.map(|(at, expected, found)| (from + at, expected, found));
                extra
            }
            None => Extra::default(),
        };
        Ok(Self { minor, format, is_packed, layout, record, points, scale, offset, begin, laszip, extra })
    }
}

/// Records of variable length, one behind the other.
struct Records<'a> {
    /// The file, up to where they end at the latest.
    bytes: &'a [u8],
    /// Where the first one is.
    at: usize,
    count: u32,
    /// Bytes of the head of each.
    head: usize,
}

impl Records<'_> {
    /// Where the content of the first one of a user with a number is.
    fn find(&self, user: &str, number: u16) -> Option<(usize, usize)> {
        let mut at = self.at;
        for _ in 0..self.count {
            let head = self.bytes.get(at..)?.get(..self.head)?;
            let length = match self.head {
                RECORD_HEAD => u64::from(u16_at(head, 20)?),
                _ => u64_at(head, 20)?,
            };
            let from = at + self.head;
            let to = from.checked_add(usize::try_from(length).ok()?)?;
            if head.get(2..).is_some_and(|id| id.starts_with(user.as_bytes()))
                && u16_at(head, 18) == Some(number)
            {
                return (to <= self.bytes.len()).then_some((from, to));
            }
            at = to;
        }
        None
    }
}
