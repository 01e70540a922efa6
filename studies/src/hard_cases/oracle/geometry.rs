//! Boxes and triangles in exact arithmetic, and what leaves a surface in binary64.

use super::is_rounded;
use crate::exact;
use crate::hard_cases::catalogue::{self, Case, Oracle};
use crate::hard_cases::{meshes, plain_ray};
use glam::{DVec3, Vec3};
use srp_runtime::scene::{Triangle, demo};
use srp_runtime::tni::arithmetic::Ray;

/// Checks that a case states the findings of exact arithmetic.
pub(super) fn check(case: &Case) -> Result<(), String> {
    match case.call.as_str() {
        "box" => of_box(case),
        "ray" => of_ray(case),
        "surface" => of_surface(case),
        _ => of_aimed(case),
    }
}

/// True if a ray hits nothing by the rules of `kernels/scene.h`.
fn is_void(ray: &Ray) -> bool {
    let parts = ray.origin.iter().chain(&ray.direction);
    let still = ray.direction == [0.0; 3];
    let ordered = ray.tmin.partial_cmp(&ray.tmax).is_some_and(|o| o.is_le());
    !parts.clone().all(|x| x.is_finite()) || still || !ordered
}

fn agree(what: &str, stated: bool, found: bool) -> Result<(), String> {
    match stated == found {
        true => Ok(()),
        false => Err(format!("{what}: {found}, not {stated}")),
    }
}

fn of_box(case: &Case) -> Result<(), String> {
    let ray = plain_ray(case);
    let (low, high) = (case.floats("low"), case.floats("high"));
    let met = !is_void(&ray) && exact::meets_box(&ray, low, high);
    agree("a hit", case.gives("hit"), met)
}

fn of_ray(case: &Case) -> Result<(), String> {
    let (ray, triangles) = (plain_ray(case), meshes::of(case, &demo::demo()));
    let found = match is_void(&ray) {
        true => None,
        false => exact::nearest(&ray, &triangles),
    };
    // A distance beyond all numbers is one that no unit can say.
    let found = found.filter(|(t, _)| t.value() <= f64::from(f32::MAX));
    agree("a hit", case.gives("hit"), found.is_some())?;
    let Some((t, nearest)) = found else {
        return Ok(());
    };
    let split = case.gives.iter().position(|w| w == "t");
    let (words, rest) = case.gives.split_at(split.unwrap_or(case.gives.len()));
    let numbers = |words: &[String]| -> Vec<f32> {
        let bits = words.iter().filter_map(|w| catalogue::number(w));
        bits.map(f32::from_bits).collect()
    };
    let allowed: Vec<u32> = numbers(words).iter().map(|&p| p as u32).collect();
    match allowed[..] {
        [] => {}
        [one] => agree("it is the first of the nearest", true, nearest[0] == one)?,
        _ => agree("they are the nearest", true, allowed == nearest)?,
    }
    match numbers(rest).first() {
        Some(&stated) if !is_rounded(stated, t.value()) => {
            Err(format!("t is {stated}, not {}", t.value()))
        }
        _ => Ok(()),
    }
}

/// Inside a closed mesh every ray meets a triangle.
fn of_aimed(case: &Case) -> Result<(), String> {
    if case.argument("scene").is_some() {
        return agree("an oracle of its own", true, case.gives("0"));
    }
    let triangles = meshes::of(case, &demo::demo());
    let [_, _, _, x, y, z] = case.floats("sphere");
    let centre = Vec3::new(x, y, z);
    for triangle in triangles.iter().step_by(triangles.len() / 7 + 1) {
        let [a, b, _] = triangle.positions;
        let direction = a.lerp(b, 0.3) - centre;
        let ray = Ray::new(centre.to_array(), direction.to_array(), 0.0, f32::MAX, 0);
        let met = triangles.iter().any(|t| exact::meets(&ray, t));
        agree("a ray from inside meets the mesh", true, met)?;
        let outwards = exact::leans(direction.to_array(), triangle);
        agree("normals lead outwards", true, outwards.is_gt())?;
    }
    Ok(())
}

/// The nearest of the other triangles that a ray meets, in binary64.
fn nearest(origin: DVec3, direction: DVec3, end: f64, others: &[Triangle]) -> Option<usize> {
    let meet = |triangle: &Triangle| {
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a - origin) / normal.dot(direction);
        let at = origin + direction * t;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(p, q)| (q - p).cross(at - p).dot(normal) >= 0.0);
        (t > 0.0 && t <= end && inside).then_some(t)
    };
    let hits = others.iter().enumerate();
    let hits = hits.filter_map(|(i, t)| meet(t).map(|t| (i, t)));
    hits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i + 1)
}

/// Rays from the point hit itself, on which only the other triangles count.
fn of_surface(case: &Case) -> Result<(), String> {
    let triangles = meshes::of(case, &demo::demo());
    let [a, b, c] = triangles[0].positions.map(|p| p.as_dvec3());
    let [u, v] = case.floats("weights").map(f64::from);
    let point = a * (1.0 - u - v) + b * u + c * v;
    let view = Vec3::from(case.floats("view")).as_dvec3().normalize();
    let plane = (b - a).cross(c - a).normalize();
    let outside = plane.dot(view) <= 0.0;
    let plane = if outside { plane } else { -plane };
    let [n0, n1, n2] = triangles[0].normals.map(|n| n.as_dvec3());
    let between = n0 * (1.0 - u - v) + n1 * u + n2 * v;
    let normal = match between.length() < 1e-5 {
        true => plane,
        false => between.normalize() * between.dot(plane).signum(),
    };
    let others = &triangles[1..];
    let name = |hit: Option<usize>| hit.map_or("miss".to_owned(), |i| i.to_string());

    let light = Vec3::from(case.floats("light")).as_dvec3() - point;
    let lit = plane.dot(light) > 0.0 && normal.dot(light) > 0.0;
    let shadow = match (lit, nearest(point, light, 1.0, others)) {
        (false, _) => "empty",
        (true, None) => "lit",
        (true, Some(_)) => "dark",
    };
    let about = |n: DVec3| view - n * (2.0 * view.dot(n));
    let mirrored = match about(normal).dot(plane) > 0.0 {
        true => about(normal),
        false => about(plane),
    };
    let [index] = case.floats("index").map(f64::from);
    let eta = if outside { 1.0 / index } else { index };
    let cosine = -normal.dot(view);
    let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    let through = match square > 0.0 {
        true => {
            let bent = view * eta + normal * (eta * cosine - square.sqrt());
            let up = bent.dot(plane);
            let bent = if up >= 0.0 {
                bent - plane * (2.0 * up)
            } else {
                bent
            };
            name(nearest(point, bent, f64::INFINITY, others))
        }
        false => "none".to_owned(),
    };
    let found = [
        ("shadow", shadow.to_owned()),
        (
            "mirror",
            name(nearest(point, mirrored, f64::INFINITY, others)),
        ),
        ("through", through),
    ];
    agree(
        "a word and its value",
        true,
        case.gives.len().is_multiple_of(2),
    )?;
    for pair in case.gives.chunks_exact(2) {
        let found = found.iter().find(|(what, _)| *what == pair[0]);
        let found = found.map(|(_, value)| value.as_str());
        if found != Some(pair[1].as_str()) || case.oracle != Oracle::BruteForce {
            return Err(format!("{} is {found:?}, not {}", pair[0], pair[1]));
        }
    }
    Ok(())
}
