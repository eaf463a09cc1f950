//! Scenes made by code: no files, no state, the same arrays at every call.

mod assembly;
mod atrium;
mod cornell;
mod faces;
mod grove;
mod masks;
mod part;
mod random;
mod shapes;

#[cfg(test)]
mod checks;
#[cfg(test)]
mod tests;

use crate::Scene;

/// Names that [`builtin`] knows.
pub const BUILTIN_NAMES: [&str; 4] = ["cornell", "cornell-blocks", "atrium", "grove"];

/// Makes a built-in scene; `None` for an unknown name.
///
/// | name | what | triangles | unit |
/// | --- | --- | ---: | --- |
/// | `cornell` | the measured Cornell box with its tall block and a ball on the floor | 20,500 | m (0.55 wide) |
/// | `cornell-blocks` | the same with both measured blocks | 30 | m |
/// | `atrium` | a court between two storeys of columns, with cloth, vases and ivy | about 330,000 | m (38 wide) |
/// | `grove` | instanced trees, bushes and grass on rolling ground | over 20 million, flattened | m (140 wide) |
///
/// All are right-handed with Y up, and each has named views: the first is the usual one. The Cornell boxes are meant
/// for square pictures, the others for 16:9. Calls take between microseconds and about a second, and two calls give
/// identical arrays.
pub fn builtin(name: &str) -> Option<Scene> {
    match name {
        "cornell" => Some(cornell::with_ball()),
        "cornell-blocks" => Some(cornell::with_blocks()),
        "atrium" => Some(atrium::atrium()),
        "grove" => Some(grove::grove()),
        _ => None,
    }
}
