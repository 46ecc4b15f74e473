//! Extra bytes of points in layers that nothing describes, so that nothing shows them: they are passed over. Their decompressor has
//! tables of a megabyte for every hundred bytes of a point and looks at each byte of each point, and a layer without bytes stands for
//! any number of them.

use std::io::{Read, Result, Seek, SeekFrom};

use laz::DecompressionSelection;
use laz::record::LayeredFieldDecompressor;

/// So many bytes of each point, with a layer each.
pub struct Skipped {
    bytes: usize,
    /// Bytes of all layers.
    layers: u64,
}

impl Skipped {
    pub fn new(bytes: usize) -> Self {
        Self { bytes, layers: 0 }
    }
}

impl<R: Read + Seek> LayeredFieldDecompressor<R> for Skipped {
    fn size_of_field(&self) -> usize {
        self.bytes
    }

    fn set_selection(&mut self, _: DecompressionSelection) {}

    fn init_first_point(&mut self, source: &mut R, first_point: &mut [u8], _: &mut usize) -> Result<()> {
        source.read_exact(first_point)
    }

    fn decompress_field_with(&mut self, _: &mut [u8], _: &mut usize) -> Result<()> {
        Ok(())
    }

    fn read_layers_sizes(&mut self, source: &mut R) -> Result<()> {
        self.layers = 0;
        for _ in 0..self.bytes {
            let mut size = [0; 4];
            source.read_exact(&mut size)?;
            self.layers += u64::from(u32::from_le_bytes(size));
        }
        Ok(())
    }

    fn read_layers(&mut self, source: &mut R) -> Result<()> {
        source.seek(SeekFrom::Current(self.layers as i64)).map(|_| ())
    }
}
