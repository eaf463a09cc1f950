//! Which format a file is in.

use std::path::Path;

/// A scene file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ, with MTL beside it.
    Obj,
    /// glTF 2.0, as JSON or as binary GLB.
    Gltf,
    /// Stanford PLY, text or binary of either byte order.
    Ply,
    /// Stereolithography, text or binary.
    Stl,
}

impl Format {
    /// By the name's ending, else by the first bytes; `None` where neither tells.
    pub fn detect(name: &Path, bytes: &[u8]) -> Option<Self> {
        let extension = name.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("obj") => Some(Self::Obj),
            Some("gltf" | "glb") => Some(Self::Gltf),
            Some("ply") => Some(Self::Ply),
            Some("stl") => Some(Self::Stl),
            _ => Self::of_bytes(bytes),
        }
    }

    fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if bytes.starts_with(b"glTF")
            || (text.starts_with(b"{") && text.windows(7).take(4096).any(|w| w == b"\"asset\""))
        {
            Some(Self::Gltf)
        } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            Some(Self::Ply)
        } else if text.starts_with(b"solid") {
            Some(Self::Stl)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_decides_and_else_the_content() {
        let of = |name: &str, bytes: &[u8]| Format::detect(Path::new(name), bytes);
        assert_eq!(of("a.OBJ", b""), Some(Format::Obj));
        assert_eq!(of("a.glb", b"solid"), Some(Format::Gltf));
        assert_eq!(of("upload", b"ply\r\nformat"), Some(Format::Ply));
        assert_eq!(of("upload", b"solid cube"), Some(Format::Stl));
        assert_eq!(of("upload", b" {\n \"asset\": {}}"), Some(Format::Gltf));
        assert_eq!(of("a.fbx", b"Kaydara FBX"), None);
    }
}
