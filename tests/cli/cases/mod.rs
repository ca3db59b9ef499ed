//! Inputs as people bring them, after public reports: what is right for each, and for others of its kind. Files are in
//! `tests/cases`.

mod claims;
mod experiments;
mod images;
mod readers;
mod seams;
mod surfaces;
