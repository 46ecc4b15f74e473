//! What an executable needs from the system before its first instruction.

use anyhow::{Context as _, Result, bail};
use object::read::elf::{ElfFile64, FileHeader as _, ProgramHeader as _};
use object::{Endianness, elf};

/// What an executable needs to be started.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// The dynamic linker (PT_INTERP).
    pub interpreter: Option<String>,
    /// Shared libraries (DT_NEEDED).
    pub libraries: Vec<String>,
}

impl Needs {
    /// Reads them from a 64-bit ELF file.
    ///
    /// # Errors
    /// It is not one, or it is damaged.
    pub fn of(executable: &[u8]) -> Result<Self> {
        let file = ElfFile64::<Endianness>::parse(executable).context("not a 64-bit ELF file")?;
        let endian = file.endian();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let mut needs = Self::default();
        let sections = file.elf_header().sections(endian, executable)?;
        for header in file.elf_program_headers() {
            if let Some(interpreter) = header.interpreter(endian, executable)? {
                needs.interpreter = Some(text(interpreter));
            }
        }
        // A static position-independent executable has a dynamic section too, without DT_NEEDED.
        if let Some((entries, strings)) = sections.dynamic(endian, executable)? {
            let strings = sections.strings(endian, executable, strings)?;
            for entry in entries.iter().filter(|entry| entry.d_tag.get(endian) == elf::DT_NEEDED) {
                let offset = u32::try_from(entry.d_val.get(endian)).context("offset of a library's name")?;
                needs.libraries.push(text(strings.get(offset).ok().context("name of a library")?));
            }
        }
        Ok(needs)
    }

    /// Fails unless the executable needs nothing.
    ///
    /// # Errors
    /// Names what it needs.
    pub fn check_static(&self) -> Result<()> {
        if let Some(interpreter) = &self.interpreter {
            bail!("the binary is not static: it needs {interpreter} {}", self.libraries.join(" "));
        }
        if !self.libraries.is_empty() {
            bail!("the binary is not static: it needs {}", self.libraries.join(" "));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test is linked to the C library of the system, if this target links that way.
    #[test]
    #[cfg(all(target_os = "linux", target_env = "gnu", not(target_feature = "crt-static")))]
    fn this_test_itself_is_not_static() {
        let needs = Needs::of(&std::fs::read(std::env::current_exe().unwrap()).unwrap()).unwrap();
        assert!(needs.interpreter.as_ref().is_some_and(|path| path.contains("ld-linux")), "{needs:?}");
        assert!(needs.libraries.iter().any(|library| library.starts_with("libc.so")), "{needs:?}");
        assert!(needs.check_static().is_err());
    }

    #[test]
    fn what_needs_nothing_is_static() {
        Needs::default().check_static().unwrap();
        let library = Needs { libraries: vec!["libGL.so.1".into()], ..Needs::default() };
        assert!(library.check_static().unwrap_err().to_string().contains("libGL.so.1"));
    }

    #[test]
    fn other_files_are_an_error() {
        assert!(Needs::of(b"#!/bin/sh\n").is_err());
        assert!(Needs::of(b"\x7fELF\x02\x01\x01").is_err());
    }
}
