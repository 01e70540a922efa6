//! Which level of a picture a frame samples, by the kernels that come along: against the width of a pixel's
//! cone computed by hand on a floor, seen at an angle and in a mirror.

use glam::{DVec3, Vec2, Vec3};
use srp_archdesc::Unwatched;
use srp_archdesc::ops::V4;
use srp_archdesc::ops::semantics::texture::at_level;
use srp_kernels::form::Forms;
use srp_runtime::effect::{Effect, Effects, Guard, find};
use srp_runtime::memory::SystemMemory;
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Camera, Map, Material, Options, Scene, Texture, Triangle};
use srp_runtime::scene_image::SceneImage;
use srp_studies::functional;
use srp_tests::studio::Studio;
use srp_tests::{c_files, compiled_for};

const SIZE: (u32, u32) = (96, 64);

/// Texels of a side, and smaller levels.
const SIDE: u32 = 64;
const SMALLER: u32 = 6;

/// How often the picture repeats in a unit of length.
const REPEATS: f32 = 0.5;

/// The height of the camera above the floor, and how far the mirror is.
const HEIGHT: f64 = 1.5;
const AWAY: f64 = 6.0;

/// The most by which straight lines between powers of two, and 2^-8, are off log2 of a quotient.
const STRAIGHT: f64 = 0.0861 + 0.004;

fn quad(scene: &mut Scene, corners: [Vec3; 4], uvs: [Vec2; 4], material: u32) {
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        let mut triangle = Triangle {
            positions: [a, b, c].map(|i| corners[i]),
            normals: [Vec3::ZERO; 3],
            uvs: [a, b, c].map(|i| uvs[i]),
            material,
        };
        triangle.normals = [triangle.geometric_normal(); 3];
        scene.triangles.push(triangle);
    }
}

/// A floor without end, in even light, and perhaps a wall that mirrors.
fn floor(texel: impl Fn(u32, u32) -> u32, levels: bool, wall: bool) -> Scene {
    let texels = (0..SIDE * SIDE).map(|i| texel(i % SIDE, i / SIDE));
    let map = Map {
        texture: 0,
        clamp: false,
    };
    let mirror = Material {
        illumination: 3,
        specular: [1.0; 3],
        ..Material::diffuse("mirror", [0.0; 3])
    };
    let mut scene = Scene {
        name: "floor".to_owned(),
        triangles: Vec::new(),
        materials: vec![
            Material {
                diffuse_map: Some(map),
                ..Material::diffuse("floor", [1.0; 3])
            },
            mirror,
        ],
        textures: vec![Texture {
            name: "picture".to_owned(),
            width: SIDE,
            height: SIDE,
            texels: texels.collect(),
            levels,
        }],
        lights: Vec::new(),
        ambient: [1.0; 3],
        background: [0.0; 3],
        camera: Camera {
            position: Vec3::new(0.0, HEIGHT as f32, 0.0),
            forward: Vec3::new(0.0, -0.3, -1.0),
            up: Vec3::Y,
            fov: 40.0,
        },
        options: Options::default(),
    };
    let far = 400.0f32;
    let corners = [(-far, far), (far, far), (far, -far), (-far, -far)];
    quad(
        &mut scene,
        corners.map(|(x, z)| Vec3::new(x, 0.0, z)),
        corners.map(|(x, z)| REPEATS * Vec2::new(x, z)),
        0,
    );
    if wall {
        let z = -AWAY as f32;
        let corners = [(-far, 0.0), (far, 0.0), (far, far), (-far, far)];
        let corners = corners.map(|(x, y)| Vec3::new(x, y, z));
        quad(&mut scene, corners, [Vec2::ZERO; 4], 1);
    }
    scene
}

/// The level of detail of a pixel by hand: the width of its cone over the cosine, in texels. `None` where it
/// does not see the floor; true if it sees it in the mirror.
fn detail(camera: &Camera, (x, y): (u32, u32), wall: bool) -> Option<(f64, bool)> {
    let forward = camera.forward.as_dvec3().normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let down = forward.cross(right);
    let pixel = 2.0 * (f64::from(camera.fov) / 2.0).to_radians().tan() / f64::from(SIZE.1);
    let from_middle = |i: u32, n: u32| (f64::from(i) + 0.5 - f64::from(n) / 2.0) * pixel;
    let ray = forward + right * from_middle(x, SIZE.0) + down * from_middle(y, SIZE.1);
    let (to_floor, to_wall) = (HEIGHT / -ray.y, AWAY / -ray.z);
    let in_mirror = wall && to_wall < to_floor;
    if ray.y >= -1e-3 || !wall && to_floor * ray.length() > 350.0 {
        return None;
    }
    // A pixel is so wide at distance 1 along the axis, from which the distance of a primary ray is counted.
    let distance = match in_mirror {
        true => to_wall + (to_floor - to_wall) * ray.length(),
        false => to_floor,
    };
    let texels = f64::from(SIDE) * f64::from(REPEATS);
    let width = pixel * distance / (-ray.y / ray.length());
    Some(((texels * width).log2(), in_mirror))
}

fn linear(byte: f64) -> f64 {
    match byte / 255.0 {
        c @ ..=0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    }
}

/// The light that a byte of a picture shows.
fn light(byte: u8) -> f64 {
    2.0 * (1.0 - (1.0 - linear(f64::from(byte))).sqrt())
}

/// The light of a level whose number is its colour; between levels, of both.
fn of_level(detail: f64) -> f64 {
    let detail = detail.clamp(0.0, f64::from(SMALLER));
    let whole = detail.floor();
    let light = |level: f64| linear(40.0 + 25.0 * level);
    light(whole) + (light(whole + 1.0) - light(whole)) * (detail - whole)
}

/// Paints each level in memory in a colour of its own.
fn number_levels(image: &mut SceneImage) {
    let mut bytes = image.memory.bytes().to_vec();
    let at = |address: u32| (address - srp_runtime::memory::BASE) as usize;
    let map = at(image.shading.maps);
    let word = |i: usize| u32::from_le_bytes(bytes[map + i..map + i + 4].try_into().expect("4"));
    let descriptor = V4([0, 4, 8, 12].map(word));
    for level in 0..=SMALLER {
        let V4([texels, width, height, _]) = at_level(descriptor, level);
        let byte = (40 + 25 * level) as u8;
        let tiles = 64 * (width.div_ceil(4) * height.div_ceil(4)) as usize;
        bytes[at(texels)..at(texels) + tiles].fill(byte);
    }
    image.memory = SystemMemory::new(bytes).writable_from(image.frame.address);
}

fn render(scene: Scene, form: &str, numbered: bool) -> (Scene, Picture) {
    let studio = Studio::of(scene, SIZE);
    let found: Effects = find(&studio.scene).into_iter().collect();
    let levels = studio.scene.textures[0].levels;
    assert_eq!(found.contains(Effect::Levels), levels, "{found}");
    let forms = Forms::default().with(form).expect("it is a form");
    let defines = found.defines().chain(forms.defines()).collect();
    let program = compiled_for(&c_files("kernels"), &studio.arch, defines);
    let program = program.unwrap_or_else(|e| panic!("{e}"));
    let mut image = studio.image();
    if numbered {
        number_levels(&mut image);
    }
    let options = functional::Options {
        guard: &Guard::default(),
        threads: 2,
        tiles: None,
        steps: functional::MAX_STEPS,
        watch: &Unwatched,
    };
    let frame = functional::render(&image, &program, &studio.arch, options);
    let picture = frame.unwrap_or_else(|e| panic!("{e}")).picture;
    (studio.scene, picture)
}

/// The red of each pixel, with its place.
fn reds(picture: &Picture) -> impl Iterator<Item = ((u32, u32), u8)> {
    let pixels = (0..).zip(picture.rgba.chunks_exact(4));
    pixels.map(|(i, pixel)| ((i % SIZE.0, i / SIZE.0), pixel[0]))
}

#[test]
fn levels_are_those_of_cones_computed_by_hand() {
    for form in ["level=nearest", "level=trilinear"] {
        let (scene, picture) = render(floor(|_, _| 0, true, true), form, true);
        let (mut seen, mut pixels) = ([[false; SMALLER as usize + 1]; 2], [0; 2]);
        for (place, red) in reds(&picture) {
            let Some((detail, in_mirror)) = detail(&scene.camera, place, true) else {
                continue;
            };
            let light = light(red);
            let rounded = |d: f64| {
                if form.ends_with("nearest") {
                    d.round()
                } else {
                    d
                }
            };
            let [least, most] = [-STRAIGHT, STRAIGHT].map(|off| of_level(rounded(detail + off)));
            // Half a byte of the picture, and 8 bits of the unit's weights.
            let slack = 0.006 * (1.0 + light);
            assert!(
                (least - slack..most + slack).contains(&light),
                "{form}: {place:?} in mirror {in_mirror}: {light} at a level of detail of {detail}"
            );
            let level = detail.round().clamp(0.0, f64::from(SMALLER));
            seen[usize::from(in_mirror)][level as usize] = true;
            pixels[usize::from(in_mirror)] += 1;
        }
        let levels = seen.map(|seen| seen.into_iter().filter(|&s| s).count());
        println!("{form}: {pixels:?} pixels, {levels:?} levels on the floor and in the mirror");
        assert!(pixels.iter().all(|&n| n > 500) && levels[0] >= 3 && levels[1] >= 3);
    }
}

/// A chequered floor: far away, where a pixel is wider than two squares, it is grey, and noise without levels.
#[test]
fn a_chequered_floor_is_grey_from_afar() {
    let square = |x: u32, y: u32| match (x / 8 + y / 8) % 2 {
        0 => u32::MAX,
        _ => 0xff00_0000,
    };
    let spread = |levels: bool| {
        let (scene, picture) = render(floor(square, levels, false), "level=nearest", false);
        let mut bands = vec![Vec::new(); 10];
        for (place, red) in reds(&picture) {
            if let Some((detail, _)) = detail(&scene.camera, place, false) {
                bands[detail.clamp(0.0, 9.0) as usize].push(f64::from(red));
            }
        }
        let deviation = |band: &Vec<f64>| {
            let n = band.len() as f64;
            let mean = band.iter().sum::<f64>() / n;
            let square = band.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
            (band.len(), mean, square.sqrt())
        };
        bands.iter().map(deviation).collect::<Vec<_>>()
    };
    let (with, without) = (spread(true), spread(false));
    println!("with levels {with:.1?}\nwithout {without:.1?}");
    let grey = 255.0 * {
        let light = linear(188.0);
        1.055 * (light * (1.0 - light / 4.0)).powf(1.0 / 2.4) - 0.055
    };
    for band in 5..8 {
        let (pixels, mean, deviation) = with[band];
        assert!(pixels > 90, "{with:?}");
        assert!(
            (mean - grey).abs() < 1.0 && deviation < 1.0,
            "{with:?}, not {grey}"
        );
        assert!(without[band].2 > 60.0, "{without:?}");
    }
    // It falls from where squares are larger than pixels.
    assert!(with[1].2 > 80.0 && with[3].2 < with[1].2 && with[4].2 < with[3].2);
}
