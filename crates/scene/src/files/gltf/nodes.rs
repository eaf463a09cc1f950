//! The node tree of a glTF: where meshes and cameras stand.

use super::accessor::Accessor;
use super::data::{Data, get};
use super::schema::{Instancing, Node, Root};
use crate::files::error::Fault;
use crate::files::limits::Limits;
use conray_core::{Affine3A, Mat4, Quat, Vec3};

/// A node that counts, in the order of a walk through the tree.
pub(super) struct Placed {
    /// Its index in the document.
    pub node: usize,
    /// Its placement.
    pub world_from_node: Affine3A,
}

/// Walks the tree of the scene: the one that the document names, else its first, else all nodes without a parent.
///
/// A node that is met twice, because it has two parents or is its own ancestor, is refused.
pub(super) fn walk(root: &Root, limits: &Limits) -> Result<Vec<Placed>, Fault> {
    let roots = match root.scene {
        Some(scene) => get(&root.scenes, scene, "scene", "the document")?.nodes.clone(),
        None => root.scenes.first().map_or_else(|| parentless(root), |scene| scene.nodes.clone()),
    };
    Limits::check("nodes", root.nodes.len() as u64, limits.max_nodes)?;
    let mut seen = vec![false; root.nodes.len()];
    let mut out = Vec::new();
    let mut stack: Vec<(usize, Affine3A, u64)> =
        roots.iter().rev().map(|&node| (node, Affine3A::IDENTITY, 1)).collect();
    while let Some((index, world_from_parent, depth)) = stack.pop() {
        let name = format!("node {index}");
        let node = get(&root.nodes, index, "node", "the node tree")?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(Fault::element(name, "it has several parents or is its own ancestor"));
        }
        Limits::check("levels of nodes", depth, limits.max_node_depth)?;
        if node.extensions.visibility.as_ref().is_some_and(|v| !v.visible) {
            continue;
        }
        let world_from_node = world_from_parent * local(node, &name)?;
        if !world_from_node.is_finite() {
            return Err(Fault::element(name, "its transform is not finite"));
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, world_from_node, depth + 1)));
        out.push(Placed { node: index, world_from_node });
    }
    Ok(out)
}

fn parentless(root: &Root) -> Vec<usize> {
    let mut has_parent = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(slot) = has_parent.get_mut(child) {
            *slot = true;
        }
    }
    (0..root.nodes.len()).filter(|&n| !has_parent[n]).collect()
}

fn local(node: &Node, name: &str) -> Result<Affine3A, Fault> {
    if let Some(matrix) = &node.matrix {
        let matrix = Mat4::from_cols_array(matrix);
        if matrix.row(3).abs_diff_eq(conray_core::Vec3::ZERO.extend(1.0), 1e-5) {
            return Ok(Affine3A::from_mat4(matrix));
        }
        return Err(Fault::element(name, "its matrix does not end in the row 0 0 0 1"));
    }
    Ok(trs(node.translation, node.rotation, node.scale))
}

/// Translation, rotation and scale; a quaternion need not be of unit length.
fn trs(translation: Option<[f32; 3]>, rotation: Option<[f32; 4]>, scale: Option<[f32; 3]>) -> Affine3A {
    let rotation = Quat::from_array(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { Quat::IDENTITY };
    Affine3A::from_scale_rotation_translation(
        scale.map_or(Vec3::ONE, Vec3::from_array),
        rotation,
        translation.map_or(Vec3::ZERO, Vec3::from_array),
    )
}

/// The placements that `EXT_mesh_gpu_instancing` gives a node's mesh, relative to the node.
pub(super) fn instances(
    data: &Data,
    instancing: &Instancing,
    name: &str,
    limits: &Limits,
) -> Result<Vec<Affine3A>, Fault> {
    let attribute = |key: &str, width| match instancing.attributes.get(key) {
        Some(&index) => Accessor::new(data, index, name)?.with_width(width, index, key).map(Some),
        None => Ok(None),
    };
    let (translation, rotation, scale) =
        (attribute("TRANSLATION", 3)?, attribute("ROTATION", 4)?, attribute("SCALE", 3)?);
    let counts = [&translation, &rotation, &scale].map(|a| a.as_ref().map(|a| a.count));
    let count = counts.into_iter().flatten().next().unwrap_or(0);
    if counts.into_iter().flatten().any(|c| c != count) {
        return Err(Fault::element(name, "its instancing attributes differ in their count"));
    }
    Limits::check("instances", count as u64, limits.max_instances)?;
    data.spend((count as u64).saturating_mul(size_of::<Affine3A>() as u64))?;
    Ok((0..count)
        .map(|i| {
            let floats3 = |a: &Option<Accessor>| a.as_ref().map(|a| a.floats(i));
            trs(floats3(&translation), rotation.as_ref().map(|a| a.floats(i)), floats3(&scale))
        })
        .collect())
}
