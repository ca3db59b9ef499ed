//! Coincident vertices: merges them on request, and warns about those that are not merged.

use ndarray::Array2;

use crate::counted::counted;
use crate::mesh::Mesh;
use crate::mesh::weld::{
    Weld, coincident, free_cuts, is_shattered, mending_tolerance, nearly_coincident,
};
use crate::{Error, Result};

/// The command that welds a mesh for verbs that take it as it is.
pub const CONVERT_COMMAND: &str = "`meshseg mesh convert --weld`";

/// Merges vertices within a tolerance, if there are any.
///
/// # Errors
/// The tolerance is not a length, or leaves no face.
pub fn weld(mesh: &Mesh, tolerance: f64) -> Result<Option<Weld>> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        let message = format!("--weld {tolerance:?}: must be a finite number, 0 or more");
        return Err(Error::unsuitable(message));
    }
    let weld = Weld::within(mesh, tolerance);
    let collapsed = |weld: &Weld| {
        let faces = 0..mesh.faces.len();
        faces.clone().all(|j| weld.mesh.is_degenerate(j))
            && !faces.clone().all(|j| mesh.is_degenerate(j))
    };
    if tolerance > 0.0 && weld.as_ref().is_some_and(collapsed) {
        return Err(Error::unsuitable(format!(
            "--weld {tolerance:?}: leaves no face with an area; it is a length in the units of the file"
        )));
    }
    Ok(weld)
}

/// Means at the welded vertices of rows at the vertices of the file. With the weights of a quadrature, integrals are
/// preserved: the integrated costs of lumped masses are added.
pub fn means(weld: &Weld, rows: &Array2<f64>, weights: &[f64]) -> Array2<f64> {
    let rows = rows.as_standard_layout();
    let d = rows.ncols();
    let means = weld.means_by(rows.as_slice().expect("in standard layout"), d, weights);
    Array2::from_shape_vec((means.len() / d, d), means).expect("rows of d numbers")
}

/// Means of costs, see [`means`].
///
/// # Errors
/// Vertices that are merged together forbid every label.
pub fn costs(weld: &Weld, costs: &Array2<f64>, weights: &[f64]) -> Result<Array2<f64>> {
    let means = means(weld, costs, weights);
    let is_forbidden = |k: &u32| means.row(*k as usize).iter().all(|&s| s == f64::INFINITY);
    match weld.of.iter().position(is_forbidden) {
        None => Ok(means),
        Some(v) => Err(Error::unsuitable(format!(
            "row {v} of the costs and those of the vertices at its position together forbid every label; leave out \
             --weld, or forbid fewer labels"
        ))),
    }
}

/// A sentence that says what was merged.
pub fn note(weld: Option<&Weld>, tolerance: f64) -> String {
    match (weld, tolerance) {
        (Some(Weld { merged, onto, .. }), 0.0) => {
            format!(
                "welded {} onto {} at the same positions",
                counted(*merged, "vertex", "vertices"),
                counted(*onto, "other", "others")
            )
        }
        (Some(Weld { merged, onto, .. }), _) => {
            format!(
                "welded {} onto {} within a distance of {tolerance:?}",
                counted(*merged, "vertex", "vertices"),
                counted(*onto, "other", "others")
            )
        }
        (None, 0.0) => {
            "welded 0 vertices: no two vertices of faces lie at the same position".to_owned()
        }
        (None, _) => format!(
            "welded 0 vertices: no two vertices of faces lie within {tolerance:?} of each other"
        ),
    }
}

/// Warnings after a requested weld: sheets that now touch, or seams that its tolerance is too small for.
pub fn aftermath(mesh: &Mesh, weld: Option<&Weld>) -> Vec<String> {
    let welded = weld.map_or(mesh, |weld| &weld.mesh);
    let touching =
        weld.and_then(|weld| side_effect(weld, "leave out --weld to keep them separate"));
    touching.into_iter().chain(unmended(welded)).collect()
}

/// A warning about seams that remain after welding.
pub fn unmended(welded: &Mesh) -> Option<String> {
    shattered(welded, "--weld").or_else(|| {
        let (near, tolerance) = nearly_coincident(welded);
        (near > 0).then(|| {
            format!(
                "{} others, but not within the tolerance of --weld, so cuts along such seams are free; weld them with \
                 --weld {tolerance:.1e}",
                counted(near, "vertex lies near", "vertices lie near")
            )
        })
    })
}

/// A warning about non-manifold edges that the weld created.
pub fn side_effect(weld: &Weld, remedy: &str) -> Option<String> {
    let edges = weld.new_non_manifold_edges;
    (edges > 0).then(|| {
        format!(
            "welding created {} with more than two faces, where sheets overlap or touch; {remedy}",
            counted(edges, "edge", "edges")
        )
    })
}

/// Warnings about seams in a surface that is taken as it is; `remedy` merges coincident vertices.
pub fn seams(mesh: &Mesh, remedy: &str) -> Vec<String> {
    let coincident = coincident(mesh);
    let seams =
        (coincident > 0).then(|| format!("{}; weld them with {remedy}", free_cuts(coincident)));
    let shattered = shattered(mesh, remedy).filter(|_| {
        // Otherwise the first warning suffices.
        coincident == 0 || Weld::exact(mesh).is_some_and(|weld| is_shattered(&weld.mesh))
    });
    seams.into_iter().chain(shattered).collect()
}

/// A warning if nearly every face is a separate component, with the tolerance that joins them.
pub fn shattered(mesh: &Mesh, remedy: &str) -> Option<String> {
    if !is_shattered(mesh) {
        return None;
    }
    let advice = match mending_tolerance(mesh) {
        Some(0.0) => format!("weld them with {remedy}"),
        Some(tolerance) => format!("weld nearly equal vertices with {remedy} {tolerance:.1e}"),
        None => "no small tolerance would join them".to_owned(),
    };
    let faces = mesh.faces.len();
    Some(format!(
        "hardly any of the {faces} faces share a vertex, so cuts between them are free; {advice}"
    ))
}
