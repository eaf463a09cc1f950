//! A court between two storeys of columns and arches: the stand-in for Crytek Sponza where no file is at hand.
//!
//! Everything repeats along the four sides of the court, so most parts are made once in the coordinates of a side (see
//! [`plan::Side`]) and placed four times or once per bay. Solids are closed; where they meet they run into each other by
//! some centimetres rather than touch, so that no two faces lie in one plane. Cloth and leaves are single sheets.

mod arcades;
mod balustrade;
mod cloth;
mod columns;
mod floors;
mod greenery;
mod mouldings;
mod plan;
mod relief;
mod roof;
mod vaults;
mod walls;

use super::assembly::Assembly;
use crate::Scene;

/// Scene `atrium`.
pub(crate) fn atrium() -> Scene {
    let mut assembly = Assembly::new("atrium");
    let stone = assembly.opaque("stone");
    columns::add(&mut assembly, stone);
    arcades::add(&mut assembly, stone);
    vaults::add(&mut assembly, stone);
    balustrade::add(&mut assembly, stone);
    mouldings::add(&mut assembly, stone);
    relief::add(&mut assembly, stone);
    let paving = assembly.opaque("paving");
    floors::add(&mut assembly, paving);
    let masonry = assembly.opaque("masonry");
    walls::add(&mut assembly, masonry);
    let roof = assembly.opaque("roof");
    roof::add(&mut assembly, roof);
    let fabric = assembly.opaque("fabric");
    cloth::add(&mut assembly, fabric);
    greenery::add(&mut assembly);

    assembly.view("court", [10.4, 1.9, 0.8], [-12.8, 5.3, -0.3], 62.0);
    assembly.view("gallery", [-5.9, 7.9, -7.9], [2.2, 8.0, -4.0], 62.0);
    assembly.view("plants", [-1.9, 1.3, 0.3], [-4.75, 1.5, -4.6], 46.0);
    assembly.view("arcade", [11.5, 1.7, -7.9], [-4.0, 2.75, -6.2], 62.0);
    assembly.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_atrium_is_a_building_of_its_size_and_detail() {
        let scene = atrium();
        let (bounds, triangles) = (scene.geometry.bounds(), scene.geometry.triangle_count());
        assert!((200_000..350_000).contains(&triangles), "{triangles} triangles");
        let size = bounds.size();
        for (axis, expected) in [(0, 38.0), (1, 16.0), (2, 23.0)] {
            assert!((size[axis] - expected).abs() < 0.5, "size is {size}");
        }
        let names: Vec<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
        assert_eq!(names, ["court", "gallery", "plants", "arcade"]);
    }
}
