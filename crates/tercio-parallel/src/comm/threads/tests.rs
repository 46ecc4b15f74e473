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
