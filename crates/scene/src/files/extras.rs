//! What of a file is read only where it is wanted.

/// What of a scene file is read beside what occludes; by default nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// Tangents of the vertices of a glTF.
    pub tangents: bool,
    /// Normal maps of materials: `normalTexture` of a glTF, `norm` of an MTL, and its `map_Bump` where the image is no image of heights.
    pub normal_maps: bool,
}
