//! Whether this process belongs to an MPI job: read from the environment, without initializing MPI.

use std::env;

/// Where launchers store the number of processes that they started: Open MPI; MPICH, Intel MPI and others of its
/// family; MVAPICH2.
pub const VARIABLES: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE"];

/// Number of processes in the job, including this one; `None` if no MPI launcher started this process.
///
/// Launchers that set none of [`VARIABLES`] (`srun --mpi=pmix`) are recognised by PMIx's rank; the number of
/// processes is then the number of tasks of the Slurm step.
pub fn processes() -> Option<usize> {
    processes_by(|name| env::var(name).ok())
}

/// Where launchers store the number of a process.
const RANK_VARIABLES: [&str; 4] = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "PMIX_RANK"];

/// Is this the first process of its job, or in none? True if that is not known.
pub fn is_first() -> bool {
    is_first_by(|name| env::var(name).ok())
}

fn is_first_by(value: impl Fn(&str) -> Option<String>) -> bool {
    RANK_VARIABLES.into_iter().find_map(value).is_none_or(|rank| rank.trim() == "0")
}

/// Where Open MPI stores the number of processes of each part of a command with several (`mpirun -n 1 a : -n 2 b`).
const PARTS_VARIABLE: &str = "OMPI_APP_CTX_NUM_PROCS";

/// Is this the first of the processes that were started with the same arguments, which tells what is wrong with them? Launchers
/// other than Open MPI do not say which processes that are: then all are, so that nothing wrong is ever silent. True without a job.
pub fn is_first_alike() -> bool {
    is_first_alike_by(|name| env::var(name).ok())
}

fn is_first_alike_by(value: impl Fn(&str) -> Option<String>) -> bool {
    let rank = RANK_VARIABLES.into_iter().find_map(&value).and_then(|rank| rank.trim().parse::<usize>().ok());
    let (Some(rank), Some(parts)) = (rank, value(PARTS_VARIABLE)) else { return true };
    let mut first = 0;
    rank == 0
        || parts.split_whitespace().map_while(|count| count.parse::<usize>().ok()).any(|count| {
            first += count;
            first == rank
        })
}

/// Where launchers store the number of processes that they started on this machine: Open MPI; MPICH, Intel MPI and others of
/// its family; MVAPICH2.
const LOCAL_VARIABLES: [&str; 3] =
    ["OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "MV2_COMM_WORLD_LOCAL_SIZE"];

/// Number of processes of the job on this machine, including this one; 1 if it is not known. A Slurm step says it only if
/// all machines have the same number.
pub fn local_processes() -> usize {
    local_processes_by(|name| env::var(name).ok())
}

fn local_processes_by(value: impl Fn(&str) -> Option<String>) -> usize {
    let Some(all) = processes_by(&value) else { return 1 };
    let number = |text: &str| text.trim().parse().ok().filter(|&n: &usize| n > 0);
    let by_launcher = LOCAL_VARIABLES.into_iter().find_map(|name| number(&value(name)?));
    // "4" or "4(x2)": four on each of two machines.
    let by_slurm = || number(value("SLURM_STEP_TASKS_PER_NODE")?.split('(').next()?);
    by_launcher.or_else(by_slurm).unwrap_or(1).min(all)
}

fn processes_by(value: impl Fn(&str) -> Option<String>) -> Option<usize> {
    let number = |name: &str| value(name)?.trim().parse().ok().filter(|&n: &usize| n > 0);
    let by_pmix = || value("PMIX_RANK").and_then(|_| number("SLURM_STEP_NUM_TASKS"));
    VARIABLES.into_iter().find_map(number).or_else(by_pmix)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Option<usize> {
        processes_by(|name| variables.iter().find(|v| v.0 == name).map(|v| v.1.to_string()))
    }

    #[test]
    fn launchers_are_recognised_by_their_variables() {
        assert_eq!(of(&[("OMPI_COMM_WORLD_SIZE", "4"), ("OMPI_COMM_WORLD_RANK", "0")]), Some(4));
        assert_eq!(of(&[("PMI_SIZE", "64"), ("PMI_RANK", "3")]), Some(64));
        assert_eq!(of(&[("MV2_COMM_WORLD_SIZE", "1")]), Some(1));
        assert_eq!(of(&[("PMIX_RANK", "1"), ("SLURM_STEP_NUM_TASKS", "8")]), Some(8));
    }

    #[test]
    fn the_first_process_is_known() {
        let is_first = |rank: Option<(&str, &str)>| {
            is_first_by(|name| rank.filter(|r| r.0 == name).map(|r| r.1.to_string()))
        };
        assert!(is_first(None) && is_first(Some(("OMPI_COMM_WORLD_RANK", "0"))));
        assert!(!is_first(Some(("PMI_RANK", "3"))) && !is_first(Some(("PMIX_RANK", "10"))));
    }

    #[test]
    fn the_first_process_with_the_same_arguments_is_known() {
        let first = |parts: Option<&str>| -> Vec<bool> {
            let of_rank = |rank: usize| {
                is_first_alike_by(|name| match name {
                    "OMPI_COMM_WORLD_RANK" => Some(rank.to_string()),
                    PARTS_VARIABLE => parts.map(str::to_owned),
                    _ => None,
                })
            };
            (0..4).map(of_rank).collect()
        };
        assert_eq!(first(None), [true; 4]);
        assert_eq!(first(Some("4")), [true, false, false, false]);
        assert_eq!(first(Some("1 3")), [true, true, false, false]);
        assert_eq!(first(Some("2 1 1 ")), [true, false, true, true]);
        assert_eq!(first(Some("nonsense")), [true, false, false, false]);
        assert!(is_first_alike_by(|_| None));
        assert!(is_first_alike_by(|name| (name == "PMI_RANK").then(|| "2".into())));
    }

    #[test]
    fn processes_of_this_machine_are_counted() {
        let local = |variables: &[(&str, &str)]| {
            local_processes_by(|name| variables.iter().find(|v| v.0 == name).map(|v| v.1.to_string()))
        };
        assert_eq!(local(&[]), 1);
        assert_eq!(local(&[("OMPI_COMM_WORLD_SIZE", "8"), ("OMPI_COMM_WORLD_LOCAL_SIZE", "4")]), 4);
        assert_eq!(local(&[("PMI_SIZE", "8"), ("MPI_LOCALNRANKS", "2")]), 2);
        let step =
            |tasks| [("PMIX_RANK", "1"), ("SLURM_STEP_NUM_TASKS", "8"), ("SLURM_STEP_TASKS_PER_NODE", tasks)];
        assert_eq!(["4(x2)", "8", "", "x"].map(|tasks| local(&step(tasks))), [4, 8, 1, 1]);
        // Without a job, of a launcher that says nothing, or more than all.
        assert_eq!(local(&[("OMPI_COMM_WORLD_LOCAL_SIZE", "4")]), 1);
        assert_eq!(local(&[("PMI_SIZE", "8")]), 1);
        assert_eq!(local(&[("PMI_SIZE", "2"), ("MPI_LOCALNRANKS", "64")]), 2);
    }

    #[test]
    fn other_processes_are_alone() {
        assert_eq!(of(&[]), None);
        // A Slurm step that does not use MPI.
        assert_eq!(of(&[("SLURM_STEP_NUM_TASKS", "8")]), None);
        for nonsense in ["", "0", "-1", "many"] {
            assert_eq!(of(&[("PMI_SIZE", nonsense)]), None, "{nonsense}");
        }
    }
}
