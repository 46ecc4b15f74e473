//! Is the mesh closed, is it consistently wound?
