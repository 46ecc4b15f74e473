//! What a material library states that is not applied.

use crate::error::printable;

/// As many names are shown; a hostile file could have any number.
const SHOWN: usize = 8;

/// Statements and options that are understood but not applied, and those that are not known, each once.
#[derive(Default)]
pub struct Ignored {
    names: Vec<Vec<u8>>,
    has_more: bool,
}

impl Ignored {
    /// Adds one by its name in lower case.
    pub fn add(&mut self, name: &[u8]) {
        if self.names.iter().any(|known| known == name) {
            return;
        }
        if self.names.len() < SHOWN {
            self.names.push(name.into());
        } else {
            self.has_more = true;
        }
    }

    /// The warning that names them, if there are any.
    pub fn warning(&self, library: &str) -> Option<String> {
        let names: Vec<String> = self.names.iter().map(|name| printable(name)).collect();
        let dots = if self.has_more { ", …" } else { "" };
        (!names.is_empty()).then(|| {
            format!("did not apply of the material library \"{library}\": {}{dots}", names.join(", "))
        })
    }
}
