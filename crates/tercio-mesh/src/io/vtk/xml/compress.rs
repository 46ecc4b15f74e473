//! Compressors of VTK.

use std::io::Read;

use flate2::{Decompress, FlushDecompress, Status};

/// Memory for the dictionary of LZMA, in KiB: more than its largest preset needs.
const LZMA_MEMORY: u32 = 80 << 10;

/// How blocks are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compressor {
    Zlib,
    Lz4,
    Lzma,
}

impl Compressor {
    /// By the name of VTK's class.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "vtkZLibDataCompressor" => Some(Self::Zlib),
            "vtkLZ4DataCompressor" => Some(Self::Lz4),
            "vtkLZMADataCompressor" => Some(Self::Lzma),
            _ => None,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Zlib => "zlib",
            Self::Lz4 => "LZ4",
            Self::Lzma => "LZMA",
        }
    }

    /// No data become smaller by more than this factor.
    pub fn most_ratio(self) -> u64 {
        match self {
            Self::Zlib => 1 << 11,
            Self::Lz4 => 1 << 8,
            Self::Lzma => 1 << 14,
        }
    }
}

/// Fills `to` exactly, or says what is wrong.
pub fn decompress(compressor: Compressor, from: &[u8], to: &mut [u8]) -> Result<(), String> {
    let wanted = to.len();
    let short = |got: u64| format!("{got} bytes instead of {wanted}");
    match compressor {
        Compressor::Zlib => {
            let mut zlib = Decompress::new(true);
            match zlib.decompress(from, to, FlushDecompress::Finish) {
                Ok(Status::StreamEnd) if zlib.total_out() == wanted as u64 => Ok(()),
                Ok(_) => Err(short(zlib.total_out())),
                Err(error) => Err(error.to_string()),
            }
        }
        Compressor::Lz4 => match lz4_flex::block::decompress_into(from, to) {
            Ok(got) if got == wanted => Ok(()),
            Ok(got) => Err(short(got as u64)),
            Err(error) => Err(error.to_string()),
        },
        Compressor::Lzma => {
            let mut xz = lzma_rust2::XzReader::new_mem_limit(from, false, LZMA_MEMORY);
            xz.read_exact(to).map_err(|error| error.to_string())
        }
    }
}
