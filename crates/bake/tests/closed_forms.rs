//! Baked texels against what geometry says, texel by texel.

use conray::{AoSettings, Control, Distance, Session, Work};
use conray_bake::{
    BentSpace, Facing, MapExtent, MapOptions, NormalMaps, Normals, PORTION, Places, Sheets, Unwrap, bake_maps,
};
use conray_core::{
    Affine2, Affine3A, Geometry, Material, NormalMap, NormalTexture, TriangleMesh, Vec2, Vec3, Wrap,
};
use conray_target::{AtlasMap, MapSize};
use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

/// Texels on each side, and the share of the map that the surface leaves free on each side.
const SIDE: u32 = 48;
const MARGIN: f32 = 0.1;

/// A quad from a corner along two edges, its UVs over the map but for the margin.
fn quad(corner: Vec3, along_u: Vec3, along_v: Vec3) -> TriangleMesh {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = corners.map(|(u, v)| corner + u * along_u + v * along_v).to_vec();
    let uvs = corners.map(|(u, v)| Vec2::new(u, v) * (1.0 - 2.0 * MARGIN) + MARGIN).to_vec();
    TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap().with_uv_set(uvs).unwrap()
}

/// Bakes the first of some quads among all of them, in portions of so many places.
fn baked(quads: Vec<TriangleMesh>, settings: &AoSettings, supersample: u32, portion: u64) -> (AtlasMap, f64) {
    let options = MapOptions { portion, ..MapOptions::default() };
    baked_with(scene(quads), settings, supersample, &options, |_| Facing::default())
}

fn scene(quads: Vec<TriangleMesh>) -> Geometry {
    let mut geometry = Geometry::default();
    for quad in quads {
        let mesh = geometry.add_mesh(quad).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    geometry
}

/// Bakes the first surface of a scene, looking as is said of it.
fn baked_with(
    geometry: Geometry,
    settings: &AoSettings,
    supersample: u32,
    options: &MapOptions,
    facing: impl Fn(&Geometry) -> Facing,
) -> (AtlasMap, f64) {
    let session = Session::build(geometry, settings).unwrap();
    let sheets = Sheets::of(
        session.geometry(),
        &[0],
        MapExtent::Size(MapSize { width: SIDE, height: SIDE }),
        Unwrap::No,
    );
    let facing = facing(session.geometry());
    let places = Places::of(session.geometry(), &sheets, false, supersample, facing);
    let mut baked =
        bake_maps(&session, &[], &places, session.plan().budget, options, Control::none(), &mut |_| {})
            .unwrap();
    let work = Work::of_parts(&baked.parts).unwrap();
    assert_eq!(baked.portions, baked.parts.len());
    (baked.maps.remove(0), work.expected_rmse)
}

/// Root mean square difference of the texels that are read to a function of the place on the quad, from 0 to 1 in both directions.
fn rmse(map: &AtlasMap, truth: impl Fn(f32, f32) -> f32) -> f32 {
    rmse_where(map, |u, v| Some(truth(u, v))).0
}

/// The same where there is a truth, and the share of the texels of which there is.
fn rmse_where(map: &AtlasMap, truth: impl Fn(f32, f32) -> Option<f32>) -> (f32, f32) {
    let share = |texel: u32| {
        let uv = (texel as f32 + 0.5) / SIDE as f32;
        ((uv - MARGIN) / (1.0 - 2.0 * MARGIN)).clamp(0.0, 1.0)
    };
    let (mut sum, mut count, mut all) = (0.0, 0, 0);
    for at in (0..SIDE * SIDE).filter(|&at| map.is_read[at as usize]) {
        all += 1;
        let Some(truth) = truth(share(at % SIDE), share(at / SIDE)) else { continue };
        sum += (map.visibility[at as usize] - truth).powi(2);
        count += 1;
    }
    assert_eq!(map.missing(), 0);
    ((sum / count as f32).sqrt(), count as f32 / all as f32)
}

/// A floor of length 1 beside a wall of height 1 that is very long. Its front is up: u runs along z, v along x. The wall shows the floor its back, which
/// buries nothing: half of what the floor's rim sees is open.
fn corner() -> Vec<TriangleMesh> {
    let floor = quad(Vec3::new(0.0, 0.0, -0.5), Vec3::Z, Vec3::X);
    let wall = quad(Vec3::new(0.0, 0.0, -500.0), 1000.0 * Vec3::Z, Vec3::Y);
    vec![floor, wall]
}

fn by_the_wall(height: f32) -> impl Fn(f32, f32) -> f32 {
    move |_, away| 0.5 + 0.5 * away / (away * away + height * height).sqrt()
}

fn settings(rays: u32) -> AoSettings {
    AoSettings { rays: Some(rays), distance: Distance::Infinite, ..AoSettings::default() }
}

#[test]
fn a_floor_beside_a_wall() {
    let (map, expected) = baked(corner(), &settings(256), 1, PORTION);
    let found = rmse(&map, by_the_wall(1.0));
    assert!(found < 0.006, "{found}");
    assert!((f64::from(found) / expected).abs() < 1.6, "{found}, {expected} expected");
    // The same against another wall: the comparison can fail.
    assert!(rmse(&map, by_the_wall(1.2)) > 0.02);
}

#[test]
fn in_portions_it_is_as_right() {
    let (map, expected) = baked(corner(), &settings(256), 1, 500);
    let found = rmse(&map, by_the_wall(1.0));
    assert!(found < 0.006 && (f64::from(found) / expected).abs() < 1.6, "{found}, {expected} expected");
}

#[test]
fn divided_texels_are_as_right() {
    let (map, _) = baked(corner(), &settings(64), 2, PORTION);
    let found = rmse(&map, by_the_wall(1.0));
    assert!(found < 0.008, "{found}");
}

#[test]
fn a_floor_under_a_ceiling_that_reaches_nowhere_else() {
    // A large ceiling at height 1 over the middle of the floor: by its form factor (Howell, "A Catalog of Radiation Heat Transfer
    // Configuration Factors", B-3: a rectangle parallel to an element under its corner), four times a quarter of it.
    let floor = quad(Vec3::new(-0.01, 0.0, -0.01), 0.02 * Vec3::Z, 0.02 * Vec3::X);
    let ceiling = quad(Vec3::new(-2.0, 1.0, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X);
    let (map, _) = baked(vec![floor, ceiling], &settings(1024), 1, PORTION);
    let (a, b) = (2.0f32, 2.0f32);
    let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    let quarter = (a / p * (b / p).atan() + b / q * (a / q).atan()) / std::f32::consts::TAU;
    let found = rmse(&map, |_, _| 1.0 - 4.0 * quarter);
    assert!(found < 0.003, "{found} about {}", 1.0 - 4.0 * quarter);
    assert!(rmse(&map, |_, _| 1.0 - 4.1 * quarter) > 0.01);
}

/// A sphere about a centre, of rings and sectors so fine that it is a thousandth smaller than a true one.
fn sphere(centre: Vec3, radius: f32) -> TriangleMesh {
    let (rings, sectors) = (64u32, 128u32);
    let place = |k: u32| {
        let (polar, around) =
            ((k / sectors) as f32 / rings as f32 * PI, (k % sectors) as f32 / sectors as f32 * TAU);
        let (ring, height) = polar.sin_cos();
        centre + radius * Vec3::new(ring * around.cos(), height, ring * around.sin())
    };
    let quad = |k: u32| {
        let (a, b) = (k, k / sectors * sectors + (k + 1) % sectors);
        [[a, b, a + sectors], [b, b + sectors, a + sectors]]
    };
    let triangles = (0..rings * sectors).flat_map(quad).collect();
    TriangleMesh::new((0..(rings + 1) * sectors).map(place).collect(), triangles).unwrap()
}

#[test]
fn a_floor_under_a_sphere() {
    // A sphere wholly over the horizon takes (R / D)^2 cos from what an element at distance D sees (Howell, "A Catalog of Radiation Heat Transfer Configuration
    // Factors", B-43).
    let (height, radius) = (0.7, 0.5);
    let floor = quad(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X);
    let solid = sphere(Vec3::new(0.0, height, 0.0), radius);
    let (map, expected) = baked(vec![floor, solid], &settings(256), 1, PORTION);
    let truth = |radius: f32| {
        move |u: f32, v: f32| {
            let squared = (2.0 * u - 1.0).powi(2) + (2.0 * v - 1.0).powi(2) + height * height;
            1.0 - radius * radius * height / squared.powf(1.5)
        }
    };
    let found = rmse(&map, truth(radius));
    assert!(found < 0.006, "{found}, {expected} expected");
    assert!(rmse(&map, truth(1.1 * radius)) > 0.03, "the comparison can fail");
}

#[test]
fn a_sphere_in_a_box() {
    // A room from -4 to 4 and 5 high, in it a sphere over the middle of the floor; rays reach 2. About the middle the floor sees the whole sphere and no wall, by the
    // walls no sphere: of the unit disc, on which equal areas count alike, a wall at distance a takes the segment beyond a / 2.
    let (half, high, centre, radius, reach) = (4.0f32, 5.0f32, 1.2f32, 1.0f32, 2.0f32);
    let (side, up) = (2.0 * half, high * Vec3::Y);
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    let room = vec![
        quad(corner(-1.0, -1.0), side * Vec3::Z, side * Vec3::X),
        quad(corner(-1.0, -1.0) + up, side * Vec3::X, side * Vec3::Z),
        quad(corner(-1.0, -1.0), side * Vec3::X, up),
        quad(corner(1.0, 1.0), -side * Vec3::X, up),
        quad(corner(-1.0, 1.0), -side * Vec3::Z, up),
        quad(corner(1.0, -1.0), side * Vec3::Z, up),
        sphere(Vec3::new(0.0, centre, 0.0), radius),
    ];
    let settings = AoSettings { distance: Distance::World(reach), ..settings(256) };
    let (map, expected) = baked(room, &settings, 1, PORTION);
    let truth = |radius: f32, reach: f32| {
        move |u: f32, v: f32| {
            let [x, z] = [v, u].map(|share| (2.0 * share - 1.0) * half);
            let squared = x * x + z * z + centre * centre;
            let from_wall = [x, z].map(|place| ((half - place.abs()) / reach).min(1.0));
            let both = from_wall[0].powi(2) + from_wall[1].powi(2) < 1.0;
            let by_wall: f32 = from_wall.iter().map(|c| (c.acos() - c * (1.0 - c * c).sqrt()) / PI).sum();
            let (is_whole, is_none) =
                (squared - radius * radius <= reach * reach, squared.sqrt() >= radius + reach);
            let by_sphere = if is_none { 0.0 } else { radius * radius * centre / squared.powf(1.5) };
            ((is_whole || is_none) && !both).then_some(1.0 - by_wall - by_sphere)
        }
    };
    let (found, share) = rmse_where(&map, truth(radius, reach));
    assert!(share > 0.6, "{share}");
    assert!(found < 0.006, "{found}, {expected} expected");
    assert!(rmse_where(&map, truth(radius, 1.1 * reach)).0 > 0.012, "the comparison can fail");
    assert!(rmse_where(&map, truth(1.2 * radius, reach)).0 > 0.02);
}

/// A normal map of one colour, read by the first UV set.
fn with_normal_map(mut geometry: Geometry, texel: [u8; 3]) -> Geometry {
    let texture = Arc::new(NormalTexture::new(1, 1, vec![texel]).unwrap());
    let (texture_from_uv, wrap) = (Affine2::IDENTITY, [Wrap::Repeat; 2]);
    let map = NormalMap { texture, uv_set: 0, texture_from_uv, wrap, scale: 1.0 };
    geometry.add_material(Material { normal_map: Some(map), ..Material::default() });
    geometry
}

fn mapped(geometry: &Geometry) -> Facing {
    let maps = Arc::new(NormalMaps::of(geometry, &[0]));
    Facing { normals: Normals::Mapped(maps), ..Facing::default() }
}

#[test]
fn an_open_floor_whose_normals_lean() {
    // Of the hemisphere about a normal that leans by an angle, cos^2 of half of it lies over the floor, weighed by the cosine.
    let floor = || scene(vec![quad(Vec3::ZERO, Vec3::Z, Vec3::X)]);
    for texel in [[218, 128, 218], [128, 48, 226], [245, 128, 176]] {
        let normal = Vec3::from(texel.map(|c| f32::from(c) * 2.0 / 255.0 - 1.0)).normalize();
        let options = MapOptions::default();
        let bake = |facing: fn(&Geometry) -> Facing| {
            baked_with(with_normal_map(floor(), texel), &settings(256), 1, &options, facing).0
        };
        let map = bake(mapped);
        let found = rmse(&map, |_, _| 0.5 + 0.5 * normal.z);
        let mean = map.visibility.iter().sum::<f32>() / map.visibility.len() as f32;
        assert!(found < 0.006, "{texel:?} {found}");
        assert!((mean - 0.5 - 0.5 * normal.z).abs() < 0.001, "{texel:?} {mean}");
        assert!(rmse(&bake(|_| Facing::default()), |_, _| 0.5 + 0.5 * normal.z) > 0.02);
    }
}

#[test]
fn normals_lean_towards_the_side_that_the_map_says() {
    // A floor by a wall without end sees a wedge of sky of a right angle, which is the same along the wall: of it a normal in the plane across sees half of the difference of
    // the sines of the angles from it (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-1). v, which points down in
    // pictures, runs away from the wall, so green leans towards it.
    let by_wall = || {
        let wall = quad(Vec3::new(0.0, 0.0, -5000.0), 10000.0 * Vec3::Z, 10000.0 * Vec3::Y);
        scene(vec![quad(Vec3::new(0.0, 0.0, -0.5), Vec3::Z, Vec3::X), wall])
    };
    let truth = |away: f32, up: f32| 0.5 * if away > 0.0 { away + up } else { 1.0 + away };
    for green in [218u8, 38] {
        let texel = [128, green, 218];
        let normal = Vec3::from(texel.map(|c| f32::from(c) * 2.0 / 255.0 - 1.0)).normalize();
        let (map, _) =
            baked_with(with_normal_map(by_wall(), texel), &settings(256), 1, &MapOptions::default(), mapped);
        let found = rmse(&map, |_, _| truth(-normal.y, normal.z));
        assert!(found < 0.006, "{green}: {found}");
        assert!(rmse(&map, |_, _| truth(normal.y, normal.z)) > 0.2);
    }
}

#[test]
fn bent_directions_in_tangent_space_are_told_by_the_axes_of_the_map() {
    // v, which points down in pictures, runs away from the wall: open directions lean down in the picture.
    for turn in [Affine3A::IDENTITY, Affine3A::from_rotation_z(2.0) * Affine3A::from_rotation_y(1.0)] {
        let mut geometry = Geometry::default();
        for quad in corner() {
            let mesh = geometry.add_mesh(quad).unwrap();
            geometry.add_instance(mesh, turn).unwrap();
        }
        let [world, tangent] = [BentSpace::World, BentSpace::Tangent].map(|bent| {
            let options = MapOptions { bent, ..MapOptions::default() };
            baked_with(geometry.clone(), &settings(64), 1, &options, |_| Facing::default()).0
        });
        let axes = [Vec3::Z, Vec3::NEG_X, Vec3::Y].map(|axis| turn.transform_vector3(axis));
        for at in (0..tangent.bent.len()).filter(|&at| tangent.is_read[at]) {
            let expected = Vec3::from(axes.map(|axis| axis.dot(world.bent[at])));
            assert!((tangent.bent[at] - expected).length() < 1e-4, "{} {expected}", tangent.bent[at]);
        }
        let middle = tangent.bent[(SIDE / 2 * SIDE + SIDE / 2) as usize];
        assert!(middle.y < -0.1 && middle.x.abs() < 0.05 && middle.z > 0.3, "{middle}");
    }
}

#[test]
fn a_plane_beside_a_box_that_stands_on_it() {
    // The floor from 0.02 to 1.02 before a face of the box that is 3 wide and 0.8 high: of the box only the face is seen from there.
    let (wide, high, near) = (3.0f32, 0.8, 0.02);
    let floor = quad(Vec3::new(near, 0.0, -0.5), Vec3::Z, Vec3::X);
    let corner = |k: u32| {
        Vec3::new(
            -f32::from(u8::from(k & 1 == 1)),
            if k >> 1 & 1 == 1 { high } else { 0.0 },
            (f32::from(u8::from(k >> 2 & 1 == 1)) - 0.5) * wide,
        )
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let solid = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    let (map, expected) = baked(vec![floor, solid], &settings(256), 1, PORTION);
    // An element and a rectangle in a plane at a right angle, one corner nearest to it (Howell, B-4).
    let quarter = |away: f32, width: f32, height: f32| {
        let (x, y) = (height / width, away / width);
        let both = (x * x + y * y).sqrt();
        ((1.0 / y).atan() - y / both * (1.0 / both).atan()) / TAU
    };
    let truth = |height: f32| {
        move |u: f32, v: f32| {
            let (away, along) = (near + v, u - 0.5);
            1.0 - quarter(away, 0.5 * wide - along, height) - quarter(away, 0.5 * wide + along, height)
        }
    };
    let found = rmse(&map, truth(high));
    assert!(found < 0.006, "{found}, {expected} expected");
    assert!(rmse(&map, truth(1.2 * high)) > 0.02, "the comparison can fail");
}
