//! What the items of a loop are collected in.

use super::divide::{Target, divide, gather};
use super::{IntoParallelIterator, Loop};

/// Collections of items of this type.
pub trait Collected<T> {
    /// All items of a loop, in order.
    fn of<L: Loop<Item = T>>(items: L) -> Self;
}

impl<T: Send> Collected<T> for Vec<T> {
    fn of<L: Loop<Item = T>>(items: L) -> Self {
        let mut list = Self::new();
        list.par_extend(items);
        list
    }
}

impl<T: Send> Collected<Option<T>> for Option<Vec<T>> {
    fn of<L: Loop<Item = Option<T>>>(items: L) -> Self {
        // SAFETY: each number is in one piece.
        let of_piece = |_, range| unsafe { items.piece(range) }.collect::<Option<Vec<T>>>();
        gather(items.len(), items.lengths(), of_piece).into_iter().collect::<Option<Vec<_>>>().map(concat)
    }
}

impl<T: Send, E: Send> Collected<Result<T, E>> for Result<Vec<T>, E> {
    fn of<L: Loop<Item = Result<T, E>>>(items: L) -> Self {
        // SAFETY: each number is in one piece.
        let of_piece = |_, range| unsafe { items.piece(range) }.collect::<Result<Vec<T>, E>>();
        gather(items.len(), items.lengths(), of_piece).into_iter().collect::<Result<Vec<_>, E>>().map(concat)
    }
}

/// The elements of all pieces.
fn concat<T>(mut pieces: Vec<Vec<T>>) -> Vec<T> {
    if pieces.len() == 1 {
        return pieces.swap_remove(0);
    }
    let mut all = Vec::with_capacity(pieces.iter().map(Vec::len).sum());
    pieces.into_iter().for_each(|piece| all.extend(piece));
    all
}

/// Collections that get the items of a loop in addition.
pub trait ParallelExtend<T> {
    /// Appends all items, in order.
    fn par_extend<I: IntoParallelIterator>(&mut self, items: I)
    where
        I::Loop: Loop<Item = T>;
}

impl<T: Send> ParallelExtend<T> for Vec<T> {
    fn par_extend<I: IntoParallelIterator>(&mut self, items: I)
    where
        I::Loop: Loop<Item = T>,
    {
        let items = items.into_par_iter();
        let (len, lengths) = (items.len(), items.lengths());
        if !I::Loop::EXACT {
            // SAFETY: each number is in one piece.
            let of_piece = |_, range| unsafe { items.piece(range) }.collect::<Self>();
            let mut pieces = gather(len, lengths, of_piece);
            if self.is_empty() && pieces.len() == 1 {
                *self = pieces.swap_remove(0);
                return;
            }
            self.reserve(pieces.iter().map(Self::len).sum());
            pieces.into_iter().for_each(|piece| self.extend(piece));
            return;
        }
        self.reserve(len);
        let target = Target::new(self);
        divide(len, lengths, &|_, range| {
            // SAFETY: less than what was reserved, and each number is in one piece.
            unsafe { target.write(range.clone(), items.piece(range)) };
        });
        // SAFETY: each piece of an exact loop has written all of its items.
        unsafe { self.set_len(self.len() + len) };
    }
}
