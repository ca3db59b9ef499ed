//! Inputs as people have them, from public reports, and what is right for each: `tests/cases/` has the files.

mod readers;
