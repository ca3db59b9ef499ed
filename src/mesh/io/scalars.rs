//! Numbers of vertices or faces that the mesh itself does not keep, such as class probabilities: properties of PLY,
//! arrays of VTK.

use std::collections::BTreeSet;
use std::ops::Range;

use ndarray::Array2;

use super::scalar::Scalar;

/// The numbers of one element whose names match, in the order of the file.
pub struct Scalars {
    /// Whether they are those of faces.
    pub of_faces: bool,
    /// Their names. The components of an array of VTK are called `name[0]`, `name[1]`, ...
    pub names: Vec<String>,
    /// The type of each in the file, or one that holds all of its numbers.
    pub types: Vec<Scalar>,
    /// One row per vertex or face of the file, one column per name.
    pub numbers: Array2<f64>,
}

/// What a file has at its vertices and at its faces besides the mesh.
#[derive(Default)]
pub struct Properties {
    /// One row per vertex of the mesh.
    pub of_vertices: Option<Scalars>,
    /// One row per face of the mesh.
    pub of_faces: Option<Scalars>,
}

impl Scalars {
    /// Their names beside others that are taken: those of both begin with `input_`.
    pub fn free_names(&self, taken: &[&str]) -> Vec<String> {
        free_names(self.names.iter().map(String::as_str), taken)
    }

    /// The arrays that the columns are components of, with names beside others that are taken.
    pub fn arrays(&self, taken: &[&str]) -> Vec<(String, Range<usize>)> {
        let mut arrays: Vec<(&str, Range<usize>)> = Vec::new();
        for (c, name) in self.names.iter().enumerate() {
            match (component(name), arrays.last_mut()) {
                (Some((whole, i)), Some((last, columns)))
                    if *last == whole && i > 0 && columns.len() == i =>
                {
                    columns.end += 1;
                }
                (Some((whole, 0)), _) => arrays.push((whole, c..c + 1)),
                _ => arrays.push((name, c..c + 1)),
            }
        }
        let names = free_names(arrays.iter().map(|(name, _)| *name), taken);
        names.into_iter().zip(arrays).map(|(name, (_, columns))| (name, columns)).collect()
    }
}

/// The name of an array, and which component of it a name is.
fn component(name: &str) -> Option<(&str, usize)> {
    let (whole, rest) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((whole, rest.parse().ok()?))
}

fn free_names<'a>(names: impl Iterator<Item = &'a str> + Clone, taken: &[&str]) -> Vec<String> {
    let mut used: BTreeSet<String> = taken.iter().map(|&name| name.to_owned()).collect();
    used.extend(names.clone().map(str::to_owned));
    let free = |name: &str| {
        let mut free = name.to_owned();
        if taken.contains(&name) {
            while used.contains(&free) {
                free.insert_str(0, "input_");
            }
            used.insert(free.clone());
        }
        free
    };
    names.map(free).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalars(names: &[&str]) -> Scalars {
        Scalars {
            of_faces: false,
            names: names.iter().map(|&name| name.to_owned()).collect(),
            types: vec![Scalar::F64; names.len()],
            numbers: Array2::zeros((1, names.len())),
        }
    }

    #[test]
    fn names_that_are_taken_change() {
        let found =
            scalars(&["label", "a", "input_label", "red"]).free_names(&["label", "red", "x"]);
        assert_eq!(found, ["input_input_label", "a", "input_label", "input_red"]);
    }

    #[test]
    fn components_become_arrays_again() {
        let names = ["a", "u[0]", "u[1]", "u[2]", "v[0]", "w[1]", "n[0]", "n[1]", "[x]"];
        let found = scalars(&names).arrays(&["u"]);
        let expected = [
            ("a", 0..1),
            ("input_u", 1..4),
            ("v", 4..5),
            ("w[1]", 5..6),
            ("n", 6..8),
            ("[x]", 8..9),
        ];
        assert_eq!(found, expected.map(|(name, columns)| (name.to_owned(), columns)));
    }
}
