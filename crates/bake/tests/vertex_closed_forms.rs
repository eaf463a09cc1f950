//! Values of vertices against what geometry says, over the surface that is drawn between them.

use conray::{AoSettings, Control, Distance, Session};
use conray_bake::{Facing, Slots, VertexSettings, VertexTarget, bake_vertices};
use conray_core::{Affine3A, Estimate, Geometry, SurfacePoint, TriangleMesh, Vec3};
use conray_target::Target;

/// A grid of squares from a corner along two edges.
fn grid(corner: Vec3, along_u: Vec3, along_v: Vec3, squares: u32) -> TriangleMesh {
    let place = |at: u32| {
        let share = |k: u32| k as f32 / squares as f32;
        corner + share(at % (squares + 1)) * along_u + share(at / (squares + 1)) * along_v
    };
    let square = |at: u32| {
        let a = at / squares * (squares + 1) + at % squares;
        [[a, a + 1, a + squares + 2], [a, a + squares + 2, a + squares + 1]]
    };
    let triangles = (0..squares * squares).flat_map(square).collect();
    TriangleMesh::new((0..(squares + 1).pow(2)).map(place).collect(), triangles).unwrap()
}

/// The first of some meshes among all of them.
fn session(meshes: Vec<TriangleMesh>, rays: u32) -> Session {
    let mut geometry = Geometry::default();
    for mesh in meshes {
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    let settings = AoSettings { rays: Some(rays), distance: Distance::Infinite, ..AoSettings::default() };
    Session::build(geometry, &settings).unwrap()
}

fn target(session: &Session) -> VertexTarget {
    let objects: Vec<u32> = (0..session.geometry().instances().len() as u32).collect();
    VertexTarget::new(
        session,
        Slots::of(session, &[0], &objects),
        &VertexSettings::default(),
        &Facing::default(),
    )
    .unwrap()
}

/// Values of the first surface as rays find them at the vertices themselves.
fn sampled(session: &Session, slots: &Slots) -> Vec<f32> {
    let mut points = vec![SurfacePoint::new(Vec3::ZERO, Vec3::Y); slots.count()];
    let surface = &slots.surfaces()[0];
    for triangle in 0..surface.triangles.len() {
        for (slot, place) in surface.corners(triangle).into_iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            points[slot as usize] = session.bvh().front_point(0, triangle as u32, place).with_id(slot);
        }
    }
    session.estimate(&points).unwrap().iter().map(|estimate| estimate.visibility).collect()
}

/// Weights of the second and third corner at the places of a triangle where what is drawn is compared: the middles of 64 parts.
fn places() -> Vec<[f32; 2]> {
    let part = |i: u32, j: u32, third: f32| [i, j].map(|k| (k as f32 + third) / 8.0);
    let upright = (0..8).flat_map(|i| (0..8 - i).map(move |j| part(i, j, 1.0 / 3.0)));
    let turned = (0..7).flat_map(|i| (0..7 - i).map(move |j| part(i, j, 2.0 / 3.0)));
    upright.chain(turned).collect()
}

/// Those of the first surface, triangle by triangle.
fn surface_points(session: &Session) -> Vec<SurfacePoint> {
    let triangles = 0..session.geometry().mesh_of(0).triangles().len() as u32;
    let all = triangles.flat_map(|triangle| places().into_iter().map(move |place| (triangle, place)));
    (0..)
        .zip(all)
        .map(|(id, (triangle, place))| session.bvh().front_point(0, triangle, place).with_id(id))
        .collect()
}

/// Root mean square difference of what is drawn between values of the first surface, whose triangles are of one size, to the truth where it is known.
fn rmse(slots: &Slots, values: &[f32], truth: &[Option<f32>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    let all = (0..slots.surfaces()[0].triangles.len())
        .flat_map(|t| places().into_iter().map(move |place| (t, place)));
    for ((triangle, [u, v]), truth) in all.zip(truth).filter_map(|(at, truth)| Some((at, (*truth)?))) {
        let [a, b, c] = slots.surfaces()[0].corners(triangle).map(|slot| values[slot as usize]);
        sum += f64::from(a * (1.0 - u - v) + b * u + c * v - truth).powi(2);
        count += 1;
    }
    (sum / f64::from(count)).sqrt()
}

/// Visibility of a floor at a distance from the foot of an endless wall of that height.
fn by_the_wall(away: f32, height: f32) -> f32 {
    0.5 + 0.5 * away / (away * away + height * height).sqrt()
}

#[test]
fn a_floor_beside_a_wall_is_drawn_as_well_as_its_triangles_let_it_be() {
    // The wall is low: the shade at its foot is as wide as a square.
    let height = 0.25;
    let floor = grid(Vec3::new(0.0, 0.0, -0.5), Vec3::Z, Vec3::X, 4);
    let wall = grid(Vec3::new(0.0, 0.0, -500.0), 1000.0 * Vec3::Z, height * Vec3::Y, 1);
    let session = session(vec![floor, wall], 256);
    let target = target(&session);
    let off = |values: &[f32], height| {
        let truth = surface_points(&session)
            .iter()
            .map(|p| Some(by_the_wall(p.position.x, height)))
            .collect::<Vec<_>>();
        rmse(target.slots(), values, &truth)
    };
    let outcome = session.run_target(&target, Control::none()).unwrap();
    let values = target.resolve(&outcome.estimates).unwrap();
    // The same from estimates that are exact: what is left is the triangles'.
    let exact = |point: &SurfacePoint| Estimate {
        visibility: by_the_wall(point.position.x, height),
        error: 0.0,
        ..Estimate::PENDING
    };
    let best = target.resolve(&target.points().iter().map(exact).collect::<Vec<_>>()).unwrap();
    let (found, best) = (off(&values.visibility, height), off(&best.visibility, height));
    // At the vertices not even rays err.
    let floor = session.geometry().mesh_of(0).positions();
    let mut at_vertices = vec![0.0; target.slots().count()];
    for (place, &slot) in floor.iter().zip(&target.slots().surfaces()[0].slots) {
        at_vertices[slot as usize] = by_the_wall(place.x, height);
    }
    let at_vertices = off(&at_vertices, height);
    // 0.0099 of 0.0091, and 0.0177 at vertices.
    assert!(found < 1.15 * best, "{found} of {best}");
    assert!(found < 0.6 * at_vertices, "{found} fitted, {at_vertices} at vertices");
    assert!(off(&values.visibility, 1.5 * height) > 2.5 * found, "the comparison can fail");
}

#[test]
fn vertices_inside_a_box_darken_no_floor_about_it() {
    // A box of 1.3 x 0.5 x 1.3 stands on a floor of 4 x 4 in squares of a half: it hides nine vertices, and cuts the triangles about them.
    let (half, height) = (0.65, 0.5);
    let corner = |k: u32| {
        let side = |axis: u32| if k >> axis & 1 == 1 { half } else { -half };
        Vec3::new(side(0), if k >> 1 & 1 == 1 { height } else { 0.0 }, side(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let solid = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    let floor = grid(Vec3::new(-2.0, 0.0, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X, 8);
    let session = session(vec![floor, solid], 256);
    let target = target(&session);
    let estimates = session.run_target(&target, Control::none()).unwrap().estimates;
    let with_the_inside = target.resolve(&estimates).unwrap();
    let (facing, budget) = (Facing::default(), session.plan().budget);
    let baked = bake_vertices(&session, &[], &target, &facing, budget, Control::none(), None).unwrap();
    assert!(baked.buried > 50);
    let values = baked.values;
    // The truth by rays, where the floor is seen.
    let points = surface_points(&session);
    let is_seen = |point: &SurfacePoint| point.position.x.abs().max(point.position.z.abs()) > half;
    let truth: Vec<Option<f32>> = points
        .iter()
        .zip(session.estimate(&points).unwrap())
        .map(|(point, estimate)| is_seen(point).then_some(estimate.visibility))
        .collect();
    let off = |values: &[f32]| rmse(target.slots(), values, &truth);
    let found = off(&values.visibility);
    let (inside, at_vertices) = (off(&with_the_inside.visibility), off(&sampled(&session, target.slots())));
    // 0.0156; 0.0461 where the inside counts; 0.0642 at vertices.
    assert!(found < 0.3 * at_vertices && found < 0.4 * inside, "{found} {inside} {at_vertices}");
    assert_eq!(values.filled, 1, "the vertex in the middle");
}
