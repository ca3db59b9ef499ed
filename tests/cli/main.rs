//! The program from outside: command lines, files, exit codes.

mod albedo;
mod cases;
mod classes;
mod compare;
mod contours;
mod evaluate;
mod experiment;
mod inputs;
mod labeling;
mod mesh;
mod mixture;
mod operators;
mod paper;
mod photographs;
mod readme;
mod reconstruct;
mod reference;
mod refusals;
mod render;
mod seeds;
mod segment;
mod signals;
mod solve;
mod support;
mod texts;
mod views;
