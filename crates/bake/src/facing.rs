//! Which way the points of surfaces look.

use crate::NormalMaps;
use conray::Session;
use conray_core::SurfacePoint;
use std::sync::Arc;

/// About which normals hemispheres are taken.
#[derive(Clone, Debug, Default)]
pub enum Normals {
    /// Those of the vertices.
    #[default]
    Shading,
    /// Those of the triangles.
    Geometric,
    /// Those of normal maps, where there are some.
    Mapped(Arc<NormalMaps>),
}

/// Which way points look.
#[derive(Clone, Debug, Default)]
pub struct Facing {
    /// About which normals.
    pub normals: Normals,
    /// Into the surface: what is found is how thick the body is there, by the AO distance.
    pub inside: bool,
}

impl Facing {
    /// Bytes that it takes.
    pub fn memory_bytes(&self) -> u64 {
        match &self.normals {
            Normals::Mapped(maps) => maps.memory_bytes(),
            Normals::Shading | Normals::Geometric => 0,
        }
    }

    /// The point of a triangle of an instance, at weights of its second and third corner, as it is to look, for a square with sides of `footprint` in world units of which
    /// it tells a part with sides of `spread`.
    pub fn point(
        &self,
        session: &Session,
        [instance, triangle]: [u32; 2],
        place: [f32; 2],
        footprint: f32,
        spread: f32,
    ) -> SurfacePoint {
        let point = session.bvh().front_point(instance, triangle, place);
        let normal = match &self.normals {
            Normals::Shading => point.shading_normal,
            Normals::Geometric => point.geometric_normal,
            Normals::Mapped(maps) => {
                maps.normal(session.geometry(), [instance, triangle], place, &point, spread)
            }
        };
        let side = if self.inside { -1.0 } else { 1.0 };
        SurfacePoint {
            geometric_normal: side * point.geometric_normal,
            shading_normal: side * normal,
            footprint,
            ..point
        }
    }
}
