//! Inputs after public reports, and what is right for each.

mod surfaces;
