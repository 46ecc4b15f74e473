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
    fn other_processes_are_alone() {
        assert_eq!(of(&[]), None);
        // A Slurm step that does not use MPI.
        assert_eq!(of(&[("SLURM_STEP_NUM_TASKS", "8")]), None);
        for nonsense in ["", "0", "-1", "many"] {
            assert_eq!(of(&[("PMI_SIZE", nonsense)]), None, "{nonsense}");
        }
    }
}
