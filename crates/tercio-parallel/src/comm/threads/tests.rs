use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;

#[test]
fn messages_arrive_in_order_and_are_counted() {
    let traffic = run(3, |comm| {
        if comm.rank() == 0 {
            for n in 0..10u8 {
                comm.send(2, vec![n; usize::from(n)])?;
            }
        }
        if comm.rank() == 2 {
            for n in 0..10u8 {
                assert_eq!(comm.receive(0)?, vec![n; usize::from(n)]);
            }
        }
        comm.barrier()?;
        Ok(comm.traffic())
    });
    let traffic = traffic.unwrap();
    assert_eq!(traffic[0], Traffic { sent_messages: 10, sent_bytes: 45, ..Traffic::default() });
    assert_eq!(traffic[1], Traffic::default());
    assert_eq!(traffic[2], Traffic { taken_messages: 10, taken_bytes: 45, ..Traffic::default() });
}

#[test]
fn a_barrier_waits_for_all() {
    for ranks in [1, 2, 3, 5, 8, 9] {
        let arrived = AtomicUsize::new(0);
        run(ranks, |comm| {
            for round in 1..5 {
                arrived.fetch_add(1, Ordering::SeqCst);
                comm.barrier()?;
                let seen = arrived.load(Ordering::SeqCst);
                assert!(seen >= round * ranks, "{seen} of {ranks} in round {round}");
                comm.barrier()?;
            }
            Ok(())
        })
        .unwrap();
    }
}

#[test]
fn rank_0_gathers_in_order() {
    for senders in 1..=4 {
        let gathered = run(4, |comm| Ok(comm.gather(senders, vec![comm.rank() as u8])?)).unwrap();
        assert_eq!(gathered[0], (1..senders as u8).map(|r| vec![r]).collect::<Vec<_>>());
        assert!(gathered[1..].iter().all(Vec::is_empty));
    }
}

#[test]
fn every_rank_gets_the_blocks_of_all() {
    for ranks in 1..=17 {
        let gathered = run(ranks, |comm| {
            let block = vec![comm.rank() as u8, 7];
            let all = comm.all_gather(block)?;
            Ok((all, comm.traffic()))
        });
        let expected: Vec<Vec<u8>> = (0..ranks as u8).map(|rank| vec![rank, 7]).collect();
        for (all, traffic) in gathered.unwrap() {
            assert_eq!(all, expected);
            let messages = u64::from(ranks.next_power_of_two().trailing_zeros());
            assert_eq!((traffic.sent_messages, traffic.sent_bytes), (messages, 2 * (ranks as u64 - 1)));
        }
    }
    let error = run(2, |comm| Ok(comm.all_gather(vec![0; comm.rank()])?)).unwrap_err().to_string();
    assert!(error.contains("blocks of"), "{error}");
}

#[test]
fn a_thousand_ranks() {
    let sums = run(1024, |comm| {
        let all = comm.all_gather((comm.rank() as u64).to_ne_bytes().to_vec())?;
        comm.barrier()?;
        Ok(all.iter().map(|block| u64::from_ne_bytes(block[..].try_into().expect("8 bytes"))).sum::<u64>())
    });
    assert!(sums.unwrap().iter().all(|&sum| sum == 1023 * 1024 / 2));
}

#[test]
fn a_panic_blocks_no_rank_and_is_reported() {
    let error = run(5, |comm| {
        assert!(comm.rank() != 3, "no paper");
        let from = (comm.rank() + 1) % 5;
        comm.receive(from)?;
        Ok(())
    });
    let ParallelError::Panicked { rank: 3, message } = error.unwrap_err() else { panic!("rank 3 panicked") };
    assert_eq!(message, "no paper");
}

#[test]
fn a_rank_that_ends_early_is_gone() {
    let error = run(2, |comm| if comm.rank() == 0 { Ok(vec![]) } else { Ok(comm.receive(0)?) });
    assert!(matches!(error, Err(ParallelError::Comm(CommError::Gone { rank: 0 }))), "{error:?}");
}

#[test]
fn invalid_peers_are_errors() {
    let mut comms = ThreadComm::for_ranks(2);
    let comm = &mut comms[0];
    for rank in [0, 2] {
        assert_eq!(comm.send(rank, vec![]), Err(CommError::NoPartner { rank, size: 2 }));
        assert_eq!(comm.receive(rank), Err(CommError::NoPartner { rank, size: 2 }));
    }
    assert_eq!(comm.traffic(), Traffic::default());
}

#[test]
fn memory_of_messages_returns_to_the_sender() {
    let mut comms = ThreadComm::for_ranks(3);
    let mut message = comms[0].buffer(2);
    assert_eq!(message.capacity(), 0, "nothing was sent yet");
    message.extend([7; 1000]);
    let memory = message.as_ptr();
    comms[0].send(2, message).unwrap();
    let message = comms[2].receive(0).unwrap();
    assert_eq!(comms[0].buffer(2).capacity(), 0, "nothing was read yet");
    comms[2].give_back(0, message);
    assert_eq!(comms[0].buffer(1).capacity(), 0, "the next message to rank 1 may be of another size");
    let again = comms[0].buffer(2);
    assert_eq!((again.as_ptr(), again.len()), (memory, 0));
    assert!(again.capacity() >= 1000);
    assert_eq!(comms[0].buffer(2).capacity(), 0, "only once");
    assert_eq!(comms[0].traffic(), Traffic { sent_messages: 1, sent_bytes: 1000, ..Traffic::default() });
}

#[test]
fn messages_of_any_rank_are_received_in_the_order_of_arrival() {
    const RANKS: usize = 9;
    let order = [3, 8, 1, 7, 2];
    let received = run(RANKS, |comm| {
        let rank = comm.rank();
        if let Some(at) = order.iter().position(|&sender| sender == rank) {
            // One after another.
            if at > 0 {
                comm.await_signal(order[at - 1])?;
            }
            comm.send(0, vec![rank as u8])?;
            comm.send(0, vec![100 + rank as u8])?;
            match order.get(at + 1) {
                Some(&next) => comm.signal(next)?,
                None => comm.signal(0)?,
            }
        }
        if rank == 4 {
            comm.send(0, vec![4])?;
        }
        if rank > 0 {
            comm.barrier()?;
            return Ok(Vec::new());
        }
        // The last signal follows all messages, but those of rank 2, which are before it in the same queue.
        let mut all = Vec::new();
        for _ in 0..2 {
            let mut awaited = Awaited::new(order);
            while !awaited.is_empty() {
                let (from, message) = comm.receive_any(&mut awaited)?;
                assert!(!awaited.contains(from));
                all.push((from, message[0]));
            }
        }
        comm.await_signal(2)?;
        assert_eq!(comm.receive(4)?, [4]);
        comm.barrier()?;
        assert_eq!((comm.traffic().taken_messages, comm.traffic().taken_bytes), (11, 11));
        Ok(all)
    });
    let received = received.unwrap().remove(0);
    let first: Vec<(usize, u8)> = order.map(|rank| (rank, rank as u8)).to_vec();
    assert_eq!(received[..5], first);
    let mut second = received[5..].to_vec();
    second.sort_unstable();
    assert_eq!(second, [1, 2, 3, 7, 8].map(|rank| (rank, 100 + rank as u8)));
}

#[test]
fn an_awaited_rank_that_is_gone_is_an_error_after_the_messages_that_came() {
    run(4, |comm| {
        match comm.rank() {
            1 => comm.send(0, vec![1])?,
            // Waits until rank 0 is done.
            3 => assert!(comm.receive(0).is_err()),
            // Is gone after rank 1, whose message has arrived then.
            2 => assert!(comm.receive(1).is_err()),
            0 => {
                assert_eq!(comm.receive(2), Err(CommError::Gone { rank: 2 }));
                let mut awaited = Awaited::new([1, 2, 3]);
                assert_eq!(comm.receive_any(&mut awaited), Ok((1, vec![1])));
                assert_eq!(comm.receive_any(&mut awaited), Err(CommError::Gone { rank: 2 }));
                let mut stranger = Awaited::new([3, 4]);
                assert_eq!(comm.receive_any(&mut stranger), Err(CommError::NoPartner { rank: 4, size: 4 }));
                let mut own = Awaited::new([0, 3]);
                assert_eq!(comm.receive_any(&mut own), Err(CommError::NoPartner { rank: 0, size: 4 }));
            }
            _ => {}
        }
        Ok(())
    })
    .unwrap();
}
