//! The nodes of a glTF file: which meshes are where.
//!
//! ```text
//! G = G_parent N                    N = matrix, or T R S of translation, rotation and scale; the identity by default
//! ```
//!
//! Nodes must form trees: a node that is reached twice is refused, since nested repetitions grow exponentially.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.5, "Scenes".

use std::path::Path;

use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};

use super::document::{Document, Node};
use crate::error::{Error, Result};

/// A mesh at a place.
pub struct Instance {
    pub mesh: usize,
    pub transform: Matrix4<f64>,
    pub has_skin: bool,
}

/// The meshes of the scene, in the order of its nodes, each before its children.
pub fn instances(path: &Path, document: &Document) -> Result<Vec<Instance>> {
    let error = |message: String| Error::malformed(path, message);
    if document.nodes.is_empty() {
        let all = 0..document.meshes.len();
        let transform = Matrix4::identity();
        return Ok(all.map(|mesh| Instance { mesh, transform, has_skin: false }).collect());
    }
    let roots = roots(document).map_err(error)?;
    let mut waiting: Vec<_> = roots.iter().rev().map(|&node| (node, Matrix4::identity())).collect();
    let mut reached = vec![false; document.nodes.len()];
    let mut instances = Vec::new();
    while let Some((index, parent)) = waiting.pop() {
        let node = document
            .nodes
            .get(index)
            .ok_or_else(|| error(format!("node {index} does not exist")))?;
        if std::mem::replace(&mut reached[index], true) {
            let message = format!("node {index} occurs twice in the scene; nodes must form trees");
            return Err(error(message));
        }
        let own = transform(node).map_err(|message| error(format!("node {index}: {message}")))?;
        let transform = match own {
            Some(own) => parent * own,
            None => parent,
        };
        if let Some(mesh) = node.mesh {
            instances.push(Instance { mesh, transform, has_skin: node.skin.is_some() });
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    if document.scenes.is_empty()
        && let Some(index) = reached.iter().position(|reached| !reached)
    {
        return Err(error(format!("node {index} is above itself; nodes must form trees")));
    }
    Ok(instances)
}

/// The topmost nodes of the scene, or of all nodes.
fn roots(document: &Document) -> std::result::Result<Vec<usize>, String> {
    if document.scenes.is_empty() {
        let mut is_child = vec![false; document.nodes.len()];
        for &child in document.nodes.iter().flat_map(|node| &node.children) {
            if let Some(is_child) = is_child.get_mut(child) {
                *is_child = true;
            }
        }
        return Ok((0..is_child.len()).filter(|&node| !is_child[node]).collect());
    }
    let scene = document.scene.unwrap_or(0);
    let scene =
        document.scenes.get(scene).ok_or_else(|| format!("scene {scene} does not exist"))?;
    Ok(scene.nodes.clone())
}

/// The transform of a node; none is the identity.
fn transform(node: &Node) -> std::result::Result<Option<Matrix4<f64>>, String> {
    if let Some(matrix) = &node.matrix {
        let matrix = Matrix4::from_column_slice(matrix);
        return match matrix.row(3).transpose() == Vector4::new(0.0, 0.0, 0.0, 1.0) {
            true => Ok(Some(matrix)),
            false => Err("the last row of its matrix is not 0, 0, 0, 1".into()),
        };
    }
    if (node.translation, node.rotation, node.scale) == (None, None, None) {
        return Ok(None);
    }
    let translation = Translation3::from(node.translation.unwrap_or([0.0; 3]));
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    // Rotations are rounded to 32 bits in files.
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE)
        .ok_or("its rotation is 0")?;
    let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]));
    let matrix = translation.to_homogeneous() * rotation.to_homogeneous();
    Ok(Some(matrix * Matrix4::new_nonuniform_scaling(&scale)))
}
