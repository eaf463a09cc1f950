//! Scene files as they come: right ones, odd ones, wrong ones.

mod bad_gltf;
mod bad_input;
mod gltf_materials;
mod gltf_meshes;
mod gltf_nodes;
mod hostile;
mod normal_maps;
mod obj;
mod obj_materials;
mod obj_normals;
mod ply;
mod shared_scenes;
mod stl;
mod support;
