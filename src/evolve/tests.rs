//! Tests of the energy and of its gradient: finite differences, areas of polygons, invariances.

mod contours;
mod descent;
mod differences;
mod invariances;
mod scenes;
