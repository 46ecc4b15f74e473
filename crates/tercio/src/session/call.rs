//! The functions that all ranks of a session call, as messages.

use std::fmt;

/// A call of a collective function, as ranks compare them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    pub(super) function: Function,
    /// Of functions of a part: its number, and does the rank have it?
    pub(super) part: Option<(u32, bool)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Add,
    Update,
    Show,
    Camera,
    ShadowMaps,
    Render,
}

impl Function {
    /// In the order of their numbers in messages, from 1 on.
    const ALL: [(Self, &str); 6] = [
        (Self::Add, "add"),
        (Self::Update, "update"),
        (Self::Show, "show"),
        (Self::Camera, "camera"),
        (Self::ShadowMaps, "shadow_maps"),
        (Self::Render, "render"),
    ];
}

impl Call {
    /// As bytes of a message.
    pub(super) fn bytes(self) -> Vec<u8> {
        let [part, state] = self.part.map_or([0, 0], |(part, is_there)| [part, 1 + u32::from(is_there)]);
        [self.function as u32 + 1, part, state].iter().flat_map(|n| n.to_le_bytes()).collect()
    }

    pub(super) fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let numbers: Vec<u32> = bytes.as_chunks().0.iter().map(|&n| u32::from_le_bytes(n)).collect();
        let &[function, part, state] = &numbers[..] else { return None };
        let (function, _) = Function::ALL.get((function as usize).checked_sub(1)?)?;
        let part = (state > 0).then_some((part, state > 1));
        Some(Self { function: *function, part })
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Function::ALL[self.function as usize].1;
        match self.part {
            None => f.write_str(name),
            Some((part, true)) => write!(f, "{name} of part {part}"),
            Some((part, false)) => write!(f, "{name} of part {part}, which it does not have"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_are_what_their_bytes_say() {
        for (function, name) in Function::ALL {
            for part in [None, Some((7, true)), Some((u32::MAX, false))] {
                let call = Call { function, part };
                assert_eq!(Call::of_bytes(&call.bytes()), Some(call));
                assert!(call.to_string().starts_with(name), "{call}");
            }
        }
        assert_eq!(Call::of_bytes(&[0; 12]), None);
        assert_eq!(Call::of_bytes(&[1; 11]), None);
    }
}
