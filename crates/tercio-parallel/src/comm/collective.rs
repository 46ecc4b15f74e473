//! Collective operations, built on messages between two ranks: every rank of the communicator calls them, in the same
//! order and with the same arguments where these are not a rank's own data.

use bytemuck::{Pod, cast_slice, pod_read_unaligned};

use super::{CommError, Communicator, children, parent};

/// Sends the message of rank 0 to all ranks, along a binomial tree; the messages that other ranks pass are not used.
///
/// # Errors
/// [`CommError`].
pub fn broadcast(comm: &mut impl Communicator, message: Vec<u8>) -> Result<Vec<u8>, CommError> {
    let (rank, size) = (comm.rank(), comm.size());
    let message = if rank == 0 { message } else { comm.receive(parent(rank))? };
    // The child with the largest subtree first.
    let mut below: Vec<usize> = children(rank, size).collect();
    below.reverse();
    below.into_iter().try_for_each(|child| comm.send(child, message.clone()))?;
    Ok(message)
}

/// Combines the numbers of all ranks, element by element, and returns the result on all of them. `combine` has to be
/// associative and commutative, as minimum, maximum and sums of integers are, so that the result does not depend on the
/// number of ranks.
///
/// # Errors
/// [`CommError`], also if ranks have different counts of numbers.
pub fn all_reduce<const N: usize>(
    comm: &mut impl Communicator,
    own: [u64; N],
    combine: impl Fn([u64; N], [u64; N]) -> [u64; N],
) -> Result<[u64; N], CommError> {
    let rank = comm.rank();
    let mut all = own;
    for child in children(rank, comm.size()) {
        let theirs = comm.receive(child)?;
        all = combine(all, numbers(comm.outer_rank(child), &theirs)?);
    }
    let bytes = |numbers: &[u64; N]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    if rank > 0 {
        comm.send(parent(rank), bytes(&all))?;
    }
    let all = broadcast(comm, bytes(&all))?;
    numbers(comm.outer_rank(0), &all)
}

/// The largest of the ranks' numbers, none of which may be NaN; of coordinates, lengths and the like.
///
/// # Errors
/// [`CommError`].
pub fn all_max<const N: usize>(comm: &mut impl Communicator, own: [f64; N]) -> Result<[f64; N], CommError> {
    let combine = |a: [u64; N], b: [u64; N]| {
        std::array::from_fn(|k| f64::from_bits(a[k]).max(f64::from_bits(b[k])).to_bits())
    };
    Ok(all_reduce(comm, own.map(f64::to_bits), combine)?.map(f64::from_bits))
}

/// The sums of the ranks' numbers; they saturate.
///
/// # Errors
/// [`CommError`].
pub fn all_sum<const N: usize>(comm: &mut impl Communicator, own: [u64; N]) -> Result<[u64; N], CommError> {
    all_reduce(comm, own, |a, b| std::array::from_fn(|k| a[k].saturating_add(b[k])))
}

/// Combines the arrays of all ranks, element by element: `own` is the result on all of them then. They have the same length. The
/// messages go up and down a binomial tree, in the byte order of the machine. `combine` has to be associative and commutative.
///
/// # Errors
/// [`CommError`], also if ranks have arrays of different lengths.
pub fn all_reduce_arrays<T: Pod>(
    comm: &mut impl Communicator,
    own: &mut [T],
    combine: impl Fn(T, T) -> T,
) -> Result<(), CommError> {
    let rank = comm.rank();
    let mut below: Vec<usize> = children(rank, comm.size()).collect();
    for &child in &below {
        let theirs = comm.receive(child)?;
        let elements = elements(comm.outer_rank(child), &theirs, own.len())?;
        own.iter_mut().zip(elements).for_each(|(own, theirs)| *own = combine(*own, theirs));
        comm.give_back(child, theirs);
    }
    let message = |comm: &mut _, to: usize, own: &[T]| {
        let mut message = Communicator::buffer(comm, to);
        message.extend_from_slice(cast_slice(own));
        Communicator::send(comm, to, message)
    };
    if rank > 0 {
        let parent = parent(rank);
        message(comm, parent, own)?;
        let all = comm.receive(parent)?;
        let elements = elements(comm.outer_rank(parent), &all, own.len())?;
        own.iter_mut().zip(elements).for_each(|(own, all)| *own = all);
        comm.give_back(parent, all);
    }
    // The child with the largest subtree first.
    below.reverse();
    below.into_iter().try_for_each(|child| message(comm, child, own))
}

/// The elements of a message, of any alignment.
fn elements<T: Pod>(
    from: usize,
    message: &[u8],
    count: usize,
) -> Result<impl Iterator<Item = T> + use<'_, T>, CommError> {
    if message.len() != count * size_of::<T>() {
        let reason = format!("{} bytes, expected {count} elements of {}", message.len(), size_of::<T>());
        return Err(CommError::Transport { rank: from, reason });
    }
    Ok(message.chunks_exact(size_of::<T>()).map(pod_read_unaligned))
}

/// The sums of the numbers of the ranks before this one, and of all ranks; they saturate.
///
/// # Errors
/// [`CommError`].
pub fn exclusive_sum<const N: usize>(
    comm: &mut impl Communicator,
    own: [u64; N],
) -> Result<([u64; N], [u64; N]), CommError> {
    let block = own.iter().flat_map(|n| n.to_le_bytes()).collect();
    let (rank, blocks) = (comm.rank(), comm.all_gather(block)?);
    let mut sums = ([0; N], [0; N]);
    for (from, block) in blocks.iter().enumerate() {
        let theirs = numbers::<N>(comm.outer_rank(from), block)?;
        let add = |sum: [u64; N]| std::array::from_fn(|k| theirs[k].saturating_add(sum[k]));
        if from < rank {
            sums.0 = add(sums.0);
        }
        sums.1 = add(sums.1);
    }
    Ok(sums)
}

/// Sends a message to each rank, and returns those of all ranks in their order; the own one is not sent. `messages` has one
/// for each rank.
///
/// # Errors
/// [`CommError`].
///
/// # Panics
/// If there are not as many messages as ranks.
pub fn all_to_all(
    comm: &mut impl Communicator,
    mut messages: Vec<Vec<u8>>,
) -> Result<Vec<Vec<u8>>, CommError> {
    let (rank, size) = (comm.rank(), comm.size());
    assert_eq!(messages.len(), size, "one message for each rank");
    let mut received = vec![Vec::new(); size];
    received[rank] = std::mem::take(&mut messages[rank]);
    // Every rank begins with the next one, so that no rank gets all messages at once.
    for to in (1..size).map(|step| (rank + step) % size) {
        comm.send(to, std::mem::take(&mut messages[to]))?;
    }
    for from in (1..size).map(|step| (rank + size - step) % size) {
        received[from] = comm.receive(from)?;
    }
    Ok(received)
}

/// The numbers of a message.
fn numbers<const N: usize>(from: usize, message: &[u8]) -> Result<[u64; N], CommError> {
    let (numbers, rest) = message.as_chunks::<8>();
    match <[[u8; 8]; N]>::try_from(numbers) {
        Ok(numbers) if rest.is_empty() => Ok(numbers.map(u64::from_le_bytes)),
        _ => {
            let reason = format!("{} bytes, expected {N} numbers of 8", message.len());
            Err(CommError::Transport { rank: from, reason })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::{Group, threads};

    #[test]
    fn all_ranks_get_the_message_of_rank_0() {
        for size in 1..=17 {
            let got = threads::run(size, |comm| Ok(broadcast(comm, vec![comm.rank() as u8; 3])?));
            assert_eq!(got.expect("no errors"), vec![vec![0; 3]; size]);
        }
    }

    #[test]
    fn numbers_of_all_ranks_are_combined() {
        for size in 1..=17u64 {
            let got = threads::run(size as usize, |comm| {
                let rank = comm.rank() as u64;
                let sum = all_sum(comm, [rank, 1])?;
                let max = all_max(comm, [rank as f64, -(rank as f64) - 1.0])?;
                Ok((sum, max, exclusive_sum(comm, [rank])?))
            });
            let all = size * (size - 1) / 2;
            for (rank, (sum, max, scan)) in (0..size).zip(got.expect("no errors")) {
                assert_eq!((sum, max), ([all, size], [size as f64 - 1.0, -1.0]));
                assert_eq!(scan, ([rank * rank.saturating_sub(1) / 2], [all]));
            }
        }
    }

    #[test]
    fn arrays_of_some_ranks_are_combined() {
        for (size, members) in [(1, 0..1), (5, 0..5), (9, 2..9), (9, 3..4), (17, 1..14)] {
            let got = threads::run(size, |comm| {
                let mut own = [comm.rank() as u32, 1, 100 - comm.rank() as u32];
                if members.contains(&comm.rank()) {
                    all_reduce_arrays(&mut Group::new(comm, members.clone()), &mut own, u32::max)?;
                }
                Ok(own)
            });
            for (rank, found) in got.expect("no errors").into_iter().enumerate() {
                let (last, first) =
                    if members.contains(&rank) { (members.end - 1, members.start) } else { (rank, rank) };
                assert_eq!(found, [last as u32, 1, 100 - first as u32], "rank {rank} of {size}, {members:?}");
            }
        }
        let lengths =
            threads::run(2, |comm| Ok(all_reduce_arrays(comm, &mut vec![0u8; comm.rank()], u8::max)?));
        assert!(lengths.expect_err("lengths differ").to_string().contains("expected 0 elements"));
    }

    #[test]
    fn every_rank_gets_the_messages_for_it() {
        for size in 1..=9 {
            let got = threads::run(size, |comm| {
                let rank = comm.rank();
                let messages = (0..comm.size()).map(|to| vec![rank as u8; to]).collect();
                Ok(all_to_all(comm, messages)?)
            });
            for (rank, messages) in got.expect("no errors").into_iter().enumerate() {
                let expected: Vec<Vec<u8>> = (0..size).map(|from| vec![from as u8; rank]).collect();
                assert_eq!(messages, expected);
            }
        }
    }

    #[test]
    fn ranks_that_call_with_other_counts_of_numbers_get_an_error() {
        let got = threads::run(2, |comm| match comm.rank() {
            0 => Ok(all_sum(comm, [1]).map(|_| ())?),
            _ => Ok(all_sum(comm, [1, 2]).map(|_| ())?),
        });
        assert!(got.expect_err("counts differ").to_string().contains("expected 1 numbers of 8"));
    }
}
