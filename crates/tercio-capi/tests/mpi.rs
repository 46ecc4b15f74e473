//! C programs over MPI.
