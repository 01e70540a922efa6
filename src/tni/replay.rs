//! One ray, explained: every visit, box, triangle and cycle.

use crate::failure::Failure;
use serde_json::{Value, json};
use srp_archdesc::system::TniSpec;
use srp_runtime::tni::{Event, Logged};
use srp_studies::rays::Ray;
use srp_studies::views::Job;
use std::fmt::Write as _;

/// The first ray of a pixel of the first view, alone in a unit with empty caches: for people, or as JSON.
pub(super) fn explain(job: &Job<'_>, pixel: (u32, u32), json: bool) -> Result<String, Failure> {
    let (ray, events) = job.follow(pixel)?;
    let mut out = String::new();
    match json {
        true => {
            let members = members(pixel, &ray, &events);
            out = serde_json::to_string_pretty(&members).map_err(Failure::message)? + "\n";
        }
        false => {
            tell(&mut out, &ray, &events, &job.spec.tni).expect("writing to a String does not fail")
        }
    }
    Ok(out)
}

/// The same for programs; boxes that are missed are `null`.
fn members((x, y): (u32, u32), ray: &Ray, events: &[Logged]) -> Value {
    let start = events.first().map_or(0, |e| e.cycle);
    let happened = events.iter().map(|Logged { cycle, event, .. }| {
        let mut members = match event {
            Event::Dispatch { trv } => json!({ "what": "dispatch", "trv": trv }),
            Event::Visit { node, enter } => json!({
                "what": "visit", "leaf": node.is_leaf(), "node": node.index,
                "triangles": node.count, "enter": enter,
            }),
            Event::Boxes { children, enter } => {
                let children = children.iter().zip(enter).map(|(child, enter)| {
                    json!({ "leaf": child.is_leaf(), "node": child.index, "enter": enter })
                });
                json!({ "what": "boxes", "children": children.collect::<Vec<_>>() })
            }
            Event::Post { popped, finished } => {
                json!({ "what": "post", "popped": popped, "finished": finished })
            }
            Event::Triangle {
                primitive,
                t,
                taken,
            } => json!({ "what": "triangle", "primitive": primitive, "t": t, "taken": taken }),
            Event::Result { hit } => json!({
                "what": "result", "primitive": hit.map(|(p, _)| p), "t": hit.map(|(_, t)| t),
            }),
        };
        members["cycle"] = (cycle - start).into();
        members
    });
    json!({
        "pixel": [x, y],
        "origin": ray.origin,
        "direction": ray.direction,
        "tmin": ray.tmin,
        "tmax": ray.tmax,
        "any_hit": ray.flags & 1 == 1,
        "events": happened.collect::<Vec<_>>(),
    })
}

fn tell(out: &mut String, ray: &Ray, events: &[Logged], spec: &TniSpec) -> std::fmt::Result {
    let [ox, oy, oz] = ray.origin;
    let [dx, dy, dz] = ray.direction;
    writeln!(
        out,
        "ray from ({ox}, {oy}, {oz}) along ({dx}, {dy}, {dz}), from {} {}{}\n",
        ray.tmin,
        match ray.tmax {
            f32::MAX => "on".to_owned(),
            tmax => format!("to {tmax}"),
        },
        if ray.flags & 1 == 1 { ", any hit" } else { "" }
    )?;
    writeln!(out, "{:>7} {:>6}  what", "cycle", "after")?;
    let (mut before, mut visits, mut tests) = (events.first().map_or(0, |e| e.cycle), 0, 0);
    for Logged { cycle, event, .. } in events {
        write!(out, "{cycle:>7} {:>+6}  ", cycle - before)?;
        before = *cycle;
        match event {
            Event::Dispatch { trv } => writeln!(out, "RD     to TRV {trv}")?,
            Event::Visit { node, enter } if node.is_leaf() => {
                visits += 1;
                writeln!(
                    out,
                    "PRE    visit {visits}: leaf of {} triangle(s) from record {}, entered at {enter}",
                    node.count, node.index
                )?;
            }
            Event::Visit { node, enter } => {
                visits += 1;
                writeln!(
                    out,
                    "PRE    visit {visits}: node pair {}, entered at {enter}",
                    node.index
                )?;
            }
            Event::Boxes { children, enter } => {
                write!(out, "AABB  ")?;
                for (child, enter) in children.iter().zip(enter) {
                    let what = if child.is_leaf() { "leaf" } else { "pair" };
                    match enter {
                        Some(t) => write!(out, " {what} {} at {t};", child.index)?,
                        None => write!(out, " {what} {} missed;", child.index)?,
                    }
                }
                writeln!(out)?;
            }
            Event::Post { finished: true, .. } => writeln!(out, "POST   nothing is left")?,
            Event::Post { popped: 0, .. } => writeln!(out, "POST   goes down")?,
            Event::Post { popped, .. } => writeln!(out, "POST   takes {popped} off the stack")?,
            Event::Triangle {
                primitive,
                t,
                taken,
            } => {
                tests += 1;
                match (t, taken) {
                    (None, _) => writeln!(out, "IST    triangle {primitive}: missed")?,
                    (Some(t), true) => writeln!(out, "IST    triangle {primitive}: hit at {t}")?,
                    (Some(t), false) => {
                        writeln!(
                            out,
                            "IST    triangle {primitive}: hit at {t}, behind another"
                        )?;
                    }
                }
            }
            Event::Result { hit: Some((p, t)) } => {
                writeln!(out, "result triangle {p} at {t}")?;
            }
            Event::Result { hit: None } => writeln!(out, "result nothing is hit")?,
        }
    }
    let first = events.first().map_or(0, |e| e.cycle);
    writeln!(
        out,
        "\n{visits} visits and {tests} triangle tests in {} cycles; a visit that finds its line \
         takes {} and a triangle {}",
        before - first,
        spec.pre_latency + spec.trv_l1.latency + spec.aabb_latency + 1 + spec.post_latency,
        spec.ist_latency + spec.ist_l1.latency
    )
}
