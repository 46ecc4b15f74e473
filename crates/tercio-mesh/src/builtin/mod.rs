//! Models made by the program.
