//! Where to sort, at scale.
