//! `tercio lab validate` with ranks: counters, messages and times, predicted against measured.

use std::collections::BTreeSet;
use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};
use tercio::parallel::Communicator as _;
use tercio_lab::machines::Machine;
use tercio_lab::predict::quoted::{self, RanksRow};
use tercio_lab::predict::ranks::calibrate;
use tercio_lab::predict::ranks::exchange::ExchangeCosts;
use tercio_lab::predict::ranks::measure::MeasuredRanks;
use tercio_lab::predict::validate_ranks::{Row, Table, compare};

use super::measured::Measured;
use crate::progress::Display;
use crate::{mpi, threads};

/// Who draws the frames that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Who {
    /// Threads of this process.
    Threads,
    /// Ranks of this process, in the requested numbers.
    Ranks,
    /// This many processes that mpirun started.
    Processes(usize),
}

impl Who {
    /// The choice of the options, in a job of `processes` if it is an MPI job.
    ///
    /// # Errors
    /// Which options contradict each other.
    pub fn of(ranks: &[usize], has_organisation: bool, processes: Option<usize>) -> Result<Self, String> {
        match processes {
            Some(count) if count > 1 && !(ranks.is_empty() || ranks == [count]) => {
                let requested: Vec<String> = ranks.iter().map(ToString::to_string).collect();
                let requested = requested.join(",");
                Err(format!("--ranks {requested}: mpirun started {count} processes, which are the ranks"))
            }
            Some(count) if count > 1 || ranks == [1] => Ok(Self::Processes(count)),
            _ if !ranks.is_empty() => Ok(Self::Ranks),
            _ if has_organisation => {
                Err("--organisation says how ranks share a frame: it needs --ranks N,..., or mpirun -n N"
                    .into())
            }
            _ => Ok(Self::Threads),
        }
    }
}

/// Number of processors that the processes of a job share, where each may use `own`: no more than their machines have,
/// unless mpirun bound each process to processors of its own.
///
/// # Errors
/// A rank has ended.
pub fn processors(comm: &mut mpi::Comm, own: usize) -> Result<usize> {
    let name = comm.machine().into_bytes();
    let others = comm.gather(comm.size(), name.clone())?;
    let machines = others.into_iter().chain([name]).collect::<BTreeSet<_>>().len();
    let all = comm.size() * own;
    Ok(threads::of_machine().map_or(all, |most| all.min(most * machines)))
}

/// Compares ranks of this process.
///
/// # Errors
/// What went wrong.
pub fn of_this_process(machine: &Machine, table: Table, display: &Display) -> Result<Vec<Row>> {
    let machine = &with_costs(machine, table, display)?;
    let costs = ExchangeCosts::of(machine)?;
    Ok(compare(machine, &costs, table, MeasuredRanks::draw, begin(table, display))?)
}

/// Compares the processes of a job; the other ranks draw what rank 0 requests.
///
/// # Errors
/// What went wrong.
pub fn of_processes(
    machine: &Machine,
    table: Table,
    comm: &mut mpi::Comm,
    display: &Display,
) -> Result<Vec<Row>> {
    let machine = &with_costs(machine, table, display)?;
    let costs = ExchangeCosts::of(machine)?;
    let draw = |scene: &_, camera: &_, sharing: &_, frames| {
        MeasuredRanks::draw_between(comm, scene, camera, sharing, frames)
    };
    Ok(compare(machine, &costs, table, draw, begin(table, display))?)
}

/// A description with costs of ranks, which are measured if it lacks them.
fn with_costs(machine: &Machine, table: Table, display: &Display) -> Result<Machine> {
    let mut machine = machine.clone();
    if !ExchangeCosts::are_known(&machine) {
        display.stage("measuring this machine");
        let measured = calibrate::measure(table.options.frames, table.options.rounds, &machine)?;
        calibrate::describe(&measured, "measured by tercio lab validate", &mut machine);
    }
    Ok(machine)
}

fn begin(table: Table, display: &Display) -> impl FnMut() {
    let rows = table.models.len() * table.sizes.len() * table.how.len();
    display.progress.begin("pictures", rows as u64 * u64::from(table.options.rounds));
    || display.progress.advance(1)
}

/// Prints the rows; returns whether all hold.
///
/// # Errors
/// What cannot be written.
pub fn write(rows: &[Row], as_json: bool, output: &Measured) -> Result<bool> {
    let quoted: Vec<RanksRow> = rows.iter().map(RanksRow::from).collect();
    output.write(as_json, || rows.iter().map(json).collect(), || text(rows, &quoted), &quoted)?;
    Ok(rows.iter().all(Row::holds))
}

/// With stable keys.
fn json(row: &Row) -> Value {
    json!({ "row": row, "error": row.error(), "tolerance": row.tolerance(), "holds": row.holds() })
}

/// A table in Markdown, and the counters that differ.
fn text(rows: &[Row], quoted: &[RanksRow]) -> String {
    let mut text = quoted::markdown(quoted);
    text.push_str(
        "\nTimes: predicted / measured; a stage's is that of its busiest rank, waiting that of rank 0. Page faults and \
         context switches: of the median frame, all ranks. Differences: predicted less measured.\n",
    );
    for row in rows {
        for (rank, name, ours, theirs) in &row.differing {
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "\n{} {:?}, {} ranks, rank {rank}: {name} predicted {ours}, counted {theirs}",
                row.model, row.size, row.ranks
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::Who;

    #[test]
    fn processes_of_mpirun_are_the_ranks() {
        use Who::{Processes, Ranks, Threads};
        for (ranks, processes, who) in [
            (&[][..], None, Threads),
            (&[], Some(1), Threads),
            (&[1, 2], None, Ranks),
            (&[1, 2], Some(1), Ranks),
            (&[1], None, Ranks),
            (&[1], Some(1), Processes(1)),
            (&[], Some(4), Processes(4)),
            (&[4], Some(4), Processes(4)),
        ] {
            assert_eq!(Who::of(ranks, false, processes), Ok(who));
        }
        assert_eq!(Who::of(&[], true, Some(2)), Ok(Processes(2)));
        assert!(Who::of(&[], true, None).unwrap_err().contains("--ranks"));
        for ranks in [&[2][..], &[4, 2]] {
            assert!(Who::of(ranks, false, Some(4)).unwrap_err().contains("mpirun started 4"));
        }
    }
}
