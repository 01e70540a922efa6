//! The table that `srp tni --hits` writes: every ray, its hit and its cost, for comparison with other tracers.

use srp_runtime::tni::arithmetic::ANY_HIT;
use srp_studies::tni::{Outcome, TracedRay};
use std::fmt::Write;

/// Names of the columns. Numbers are the shortest that read back as the same float.
const COLUMNS: &str =
    "view,pixel,ox,oy,oz,dx,dy,dz,tmin,tmax,any,t,u,v,primitive,visits,tests,cycles";

/// A line for each ray, view by view in the order of the rays. A ray that hits nothing has no `t`, `u`, `v` and
/// `primitive`; triangles are numbered from 0 in the order of the scene, cycles are those of the unit's clock.
pub(super) fn table(views: &[Outcome]) -> String {
    let mut out = format!("{COLUMNS}\n");
    for (view, outcome) in views.iter().enumerate() {
        for ray in &outcome.rays {
            // Writing to a string does not fail.
            let _ = line(&mut out, view, ray);
        }
    }
    out
}

fn line(out: &mut String, view: usize, traced: &TracedRay) -> std::fmt::Result {
    let TracedRay { ray, hit, .. } = traced;
    let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
    write!(
        out,
        "{view},{},{ox:?},{oy:?},{oz:?},{dx:?},{dy:?},{dz:?},{:?},{:?},{},",
        ray.payload,
        ray.tmin,
        ray.tmax,
        ray.flags & ANY_HIT
    )?;
    match hit.is_hit() {
        true => write!(out, "{:?},{:?},{:?},{}", hit.t, hit.u, hit.v, hit.primitive)?,
        false => out.push_str(",,,"),
    }
    writeln!(out, ",{},{},{}", traced.visits, traced.tests, traced.cycles)
}
