//! The trials, each run by all ranks of a job.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tercio_mpi::{MpiComm, Patience, write_error};
use tercio_parallel::ParallelError;
use tercio_parallel::comm::collective::all_sum;
use tercio_parallel::comm::{Awaited, CommError, Communicator, Group, RankNames, Traffic};

type Outcome = Result<(), ParallelError>;

/// Bytes that identify their source.
fn bytes(seed: usize, count: usize) -> Vec<u8> {
    (0..count).map(|k| (seed * 31 + k * 7 + k / 251) as u8).collect()
}

/// Messages of all sizes arrive as they were sent, in order, with signals between them; only messages are counted.
pub fn order(comm: &mut MpiComm) -> Outcome {
    const SIZES: [usize; 8] = [0, 1, 17, 0, 5000, 100_000, 3, 2_000_000];
    let (rank, size) = (comm.rank(), comm.size());
    for to in (0..size).filter(|&to| to != rank) {
        for (number, count) in SIZES.into_iter().enumerate() {
            comm.send(to, bytes(rank + number, count))?;
            comm.signal(to)?;
        }
    }
    for from in (0..size).filter(|&from| from != rank) {
        // Signals first: the messages before them are queued.
        SIZES.iter().try_for_each(|_| comm.await_signal(from))?;
        for (number, count) in SIZES.into_iter().enumerate() {
            assert!(
                comm.receive(from)? == bytes(from + number, count),
                "message {number} of {from} to {rank}"
            );
        }
    }
    let (messages, bytes) = ((size - 1) * SIZES.len(), (size - 1) * SIZES.iter().sum::<usize>());
    let (messages, bytes) = (messages as u64, bytes as u64);
    let expected =
        Traffic { sent_messages: messages, sent_bytes: bytes, taken_messages: messages, taken_bytes: bytes };
    assert_eq!(comm.traffic(), expected);
    for stranger in [rank, size, size + 7] {
        assert_eq!(comm.send(stranger, vec![]), Err(CommError::NoPartner { rank: stranger, size }));
        assert_eq!(comm.receive(stranger), Err(CommError::NoPartner { rank: stranger, size }));
    }
    Ok(())
}

/// Sending does not wait: all ranks send messages that MPI does not buffer before any is received.
pub fn everybody_sends_first(comm: &mut MpiComm) -> Outcome {
    const BYTES: usize = 8 << 20;
    let (rank, size) = (comm.rank(), comm.size());
    for round in 0..3 {
        for to in (1..size).map(|step| (rank + step) % size) {
            comm.send(to, bytes(rank + round, BYTES))?;
        }
    }
    for round in 0..3 {
        for from in (1..size).map(|step| (rank + step) % size) {
            assert!(comm.receive(from)? == bytes(from + round, BYTES), "round {round}, {from} to {rank}");
        }
    }
    Ok(())
}

/// Messages that are sent in parts arrive complete, also those whose last part is full, and empty ones.
pub fn parts(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    // Ranks need not agree.
    comm.set_part_bytes(1000 + rank);
    let count =
        |rank: usize, number: usize| [0, 1, 999, 1000 + rank, 1001 + rank, 3 * (1000 + rank), 50_001][number];
    let (to, from) = ((rank + 1) % size, (rank + size - 1) % size);
    for number in 0..7 {
        comm.send(to, bytes(number, count(rank, number)))?;
        comm.signal(to)?;
    }
    for number in 0..7 {
        comm.await_signal(from)?;
        let message = comm.receive(from)?;
        assert!(
            message == bytes(number, count(from, number)),
            "message {number} of {from}: {}",
            message.len()
        );
    }
    assert_eq!(comm.traffic().taken_messages, 7);
    Ok(())
}

/// No rank leaves a barrier before all have arrived, by the clock that the processes of a machine share.
pub fn barrier(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_nanos()).to_le_bytes();
    for late in 0..size {
        if rank == late {
            std::thread::sleep(Duration::from_millis(20));
        }
        let before = comm.traffic();
        let came = now();
        comm.barrier()?;
        let times = [came, now()];
        assert_eq!(comm.traffic(), before, "a barrier is not counted");
        let mut all = comm.gather(size, times.concat())?;
        if rank == 0 {
            all.push(times.concat());
            let time = |message: &[u8], which: usize| {
                u128::from_le_bytes(message[16 * which..][..16].try_into().expect("16 bytes"))
            };
            let came_last = all.iter().map(|m| time(m, 0)).max();
            let left_first = all.iter().map(|m| time(m, 1)).min();
            assert!(came_last <= left_first, "with rank {late} late: {came_last:?}, {left_first:?}");
        }
    }
    Ok(())
}

/// Rank 0 gathers in the order of the ranks.
pub fn gather(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    for senders in 1..=size {
        let gathered = comm.gather(senders, bytes(rank, 10 * rank))?;
        let expected: Vec<_> = (1..senders).map(|r| bytes(r, 10 * r)).collect();
        assert_eq!(gathered, if rank == 0 { expected } else { Vec::new() });
    }
    Ok(())
}

/// Ranks are divided into groups, whose collectives do not meet each other; all are on one machine.
pub fn groups(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    assert_eq!(Group::of_machine(comm)?.size(), size);
    let mut group = Group::split(comm, rank as u64 % 2, (size - rank) as u64)?;
    let members: Vec<usize> = (0..size).rev().filter(|other| other % 2 == rank % 2).collect();
    assert_eq!(group.members(), members);
    let [sum] = all_sum(&mut group, [rank as u64])?;
    assert_eq!(sum, members.iter().sum::<usize>() as u64);
    group.barrier()?;
    let all = group.all_gather(vec![rank as u8])?.concat();
    assert_eq!(all, members.iter().map(|&member| member as u8).collect::<Vec<_>>());
    Ok(())
}

/// Messages that have not arrived are waited for no longer than that; those that have are received without waiting.
pub fn within(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    let (to, from) = ((rank + 1) % size, (rank + size - 1) % size);
    if size == 1 {
        let none = comm.receive_within(0, Duration::ZERO);
        assert_eq!(none, Err(CommError::NoPartner { rank: 0, size }));
        return Ok(());
    }
    let begin = Instant::now();
    assert_eq!(comm.receive_within(from, Duration::ZERO)?, None);
    assert_eq!(comm.receive_within(from, Duration::from_millis(20))?, None);
    assert!(begin.elapsed() >= Duration::from_millis(20));
    comm.barrier()?;
    comm.send(to, bytes(rank, 3_000_000))?;
    assert!(comm.receive_within(from, Duration::MAX)? == Some(bytes(from, 3_000_000)));
    // A signal follows the second message, which has arrived then.
    comm.send(to, bytes(rank, 10))?;
    comm.signal(to)?;
    comm.await_signal(from)?;
    assert_eq!(comm.receive_within(from, Duration::ZERO)?, Some(bytes(from, 10)));
    assert_eq!(comm.traffic().taken_messages, 2);
    Ok(())
}

/// Rank 0 receives messages of all others in whichever order they arrive, those that were queued before, too; the ones that
/// it does not await stay queued.
pub fn any(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    if rank > 0 {
        // The last rank first.
        if rank + 1 < size {
            comm.await_signal(rank + 1)?;
        }
        comm.send(0, bytes(rank, 100 * rank))?;
        comm.send(0, bytes(rank + 1, 0))?;
        if rank > 1 {
            comm.signal(rank - 1)?;
        }
        comm.signal(0)?;
        return Ok(());
    }
    if size > 1 {
        // So all messages of rank 1 are queued.
        comm.await_signal(1)?;
    }
    for round in 0..2 {
        let mut awaited = Awaited::new((1..size).filter(|&from| round == 0 || from % 2 == 1));
        while !awaited.is_empty() {
            let (from, message) = comm.receive_any(&mut awaited)?;
            assert!(!awaited.contains(from) && (1..size).contains(&from));
            let expected = if round == 0 { bytes(from, 100 * from) } else { Vec::new() };
            assert!(message == expected, "round {round}, rank {from}: {} bytes", message.len());
        }
    }
    for from in (1..size).filter(|from| from % 2 == 0) {
        assert_eq!(comm.receive(from)?, Vec::<u8>::new());
    }
    assert_eq!(comm.traffic().taken_messages as usize, 2 * (size - 1));
    let mut stranger = Awaited::new([size]);
    assert_eq!(comm.receive_any(&mut stranger), Err(CommError::NoPartner { rank: size, size }));
    Ok(())
}

/// Messages that are not received block no rank at the end.
pub fn not_taken(comm: &mut MpiComm) -> Outcome {
    let (rank, size) = (comm.rank(), comm.size());
    for to in (1..size).map(|step| (rank + step) % size) {
        comm.send(to, bytes(rank, 4 << 20))?;
        comm.signal(to)?;
    }
    Ok(())
}

/// The last rank fails while the others wait for it.
pub fn error(comm: &mut MpiComm) -> Outcome {
    let last = comm.size() - 1;
    if comm.rank() == last {
        return Ok(comm.send(last, Vec::new())?);
    }
    comm.receive(last).map(drop)?;
    unreachable!("the last rank sends nothing")
}

/// The last rank panics while the others wait for it.
pub fn panic(comm: &mut MpiComm) -> Outcome {
    let last = comm.size() - 1;
    assert!(comm.rank() != last, "no paper");
    comm.receive(last).map(drop)?;
    unreachable!("the last rank sends nothing")
}

/// Rank 0 ends without an error and without sending what the others wait for.
pub fn early_end(comm: &mut MpiComm) -> Outcome {
    if comm.rank() == 0 {
        return Ok(());
    }
    let error = comm.receive(0).map(drop);
    assert_eq!(error, Err(CommError::Gone { rank: 0 }));
    assert_eq!(comm.send(0, vec![1]), Err(CommError::Gone { rank: 0 }));
    Ok(error?)
}

/// Ends waiting after more than a second.
fn impatient(comm: &mut MpiComm) {
    let timeout = Some(Duration::from_millis(1200));
    comm.set_patience(Patience { timeout, ..Patience::default() });
}

/// Rank 0 is silent until the others have noticed it, twice: each of them once for each wait, and waits on.
pub fn notice(comm: &mut MpiComm) -> Outcome {
    const WAITS: usize = 2;
    let (rank, size) = (comm.rank(), comm.size());
    // All processes have mpirun as their parent.
    let job = std::os::unix::process::parent_id();
    let file = move |rank: usize, notices: usize| {
        std::env::temp_dir().join(format!("tercio-notice-{job}-{rank}-{notices}"))
    };
    if rank == 0 {
        for wait in 1..=WAITS {
            let begin = Instant::now();
            while !(1..size).all(|rank| file(rank, wait).exists()) {
                assert!(begin.elapsed() < Duration::from_secs(120), "no notice");
                std::thread::sleep(Duration::from_millis(5));
            }
            (1..size).for_each(|rank| std::fs::remove_file(file(rank, wait)).expect("the file"));
            (1..size).try_for_each(|to| comm.send(to, vec![7]))?;
        }
        return Ok(());
    }
    let noticed = Rc::new(RefCell::new(Vec::new()));
    let by_notice = noticed.clone();
    let notice = Box::new(move |names: &RankNames| {
        by_notice.borrow_mut().push(names.to_string());
        std::fs::write(file(rank, by_notice.borrow().len()), "").expect("a file");
    });
    comm.set_patience(Patience { silence: Duration::from_millis(50), notice, timeout: None });
    for wait in 1..=WAITS {
        assert_eq!(comm.receive(0)?, [7]);
        assert_eq!(*noticed.borrow(), vec!["rank 0"; wait]);
    }
    // At the end of the job there may be another one.
    comm.set_patience(Patience::default());
    Ok(())
}

/// All ranks write many lines at once, some of which have several parts.
pub fn lines(comm: &mut MpiComm) -> Outcome {
    for line in 0..LINES {
        comm.barrier()?;
        write_error(comm.rank(), format_args!("line {line} of {} is whole", comm.rank()));
    }
    Ok(())
}

/// So many that all lines of a rank fit into a pipe's 4,096 bytes.
pub const LINES: usize = 60;

/// The last rank neither sends anything nor ends.
pub fn silent_end(comm: &mut MpiComm) -> Outcome {
    impatient(comm);
    if comm.rank() + 1 == comm.size() {
        std::thread::sleep(Duration::from_secs(300));
    }
    Ok(())
}

/// Rank 0 has work of its own when all others have ended, for longer than they would wait for a message.
pub fn long_end(comm: &mut MpiComm) -> Outcome {
    impatient(comm);
    if comm.rank() == 0 {
        std::thread::sleep(Duration::from_secs(3));
    }
    Ok(())
}
