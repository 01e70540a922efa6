//! One ray, explained: every visit, box, triangle and cycle.

use crate::failure::Failure;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::system::TniSpec;
use srp_runtime::tni::{Event, Logged};
use srp_studies::rays::Ray;
use srp_studies::views::Job;
use srp_toolchain::envelope::{About, Contents};
use std::fmt::Write as _;

/// The first ray of a pixel of the first view, alone in a unit with empty caches: for people, or as JSON.
pub(super) fn explain(
    arch: &Arch,
    job: &Job<'_>,
    pixel: (u32, u32),
    json: bool,
) -> Result<String, Failure> {
    let (ray, events) = job.follow(pixel)?;
    let mut out = String::new();
    match json {
        true => {
            let about = About::scene(arch, job.scene);
            out = crate::document::json(about, &document(pixel, &ray, &events))?;
        }
        false => {
            tell(&mut out, &ray, &events, &job.spec.tni).expect("writing to a String does not fail")
        }
    }
    Ok(out)
}

/// A ray through a unit with empty caches.
#[derive(Serialize, JsonSchema)]
pub(crate) struct RayDocument {
    /// Column and row of the pixel.
    pixel: [u32; 2],
    /// Where the ray begins.
    origin: [f32; 3],
    /// Where it goes.
    direction: [f32; 3],
    /// The parameter from which on hits count.
    tmin: f32,
    /// The parameter up to which they do.
    tmax: f32,
    /// True if any hit will do; else the nearest is looked for.
    any_hit: bool,
    /// All that happens to it, in order.
    events: Vec<Happened>,
}

impl Contents for RayDocument {
    const FORMAT: &'static str = "srp-ray";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp tni --ray X,Y --json`";
}

/// An event.
#[derive(Serialize, JsonSchema)]
struct Happened {
    /// The cycle, from 0.
    cycle: u64,
    #[serde(flatten)]
    what: What,
}

/// The kinds of events.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "what", rename_all = "lowercase")]
enum What {
    /// A traversal unit takes the ray.
    Dispatch { trv: u32 },
    /// A node is visited.
    Visit {
        leaf: bool,
        /// Of a leaf, its first record of a triangle; else a pair of nodes.
        node: u32,
        /// Of a leaf.
        triangles: u32,
        /// The parameter at which the ray enters it.
        enter: f32,
    },
    /// The boxes of a pair of nodes are tested.
    Boxes { children: Vec<Child> },
    /// The next node is chosen.
    Post {
        /// Entries that are taken off the stack.
        popped: u32,
        /// True if nothing is left.
        finished: bool,
    },
    /// A triangle is tested.
    Triangle {
        primitive: u32,
        /// The parameter of the hit; null where it is missed.
        t: Option<f32>,
        /// True if it is the nearest up to now.
        taken: bool,
    },
    /// The result: null where nothing is hit.
    Result {
        primitive: Option<u32>,
        t: Option<f32>,
    },
}

/// A node whose box is tested.
#[derive(Serialize, JsonSchema)]
struct Child {
    leaf: bool,
    node: u32,
    /// The parameter at which the ray enters it; null where it is missed.
    enter: Option<f32>,
}

fn document((x, y): (u32, u32), ray: &Ray, events: &[Logged]) -> RayDocument {
    let start = events.first().map_or(0, |e| e.cycle);
    let happened = events.iter().map(|logged| Happened {
        cycle: logged.cycle - start,
        what: what(&logged.event),
    });
    RayDocument {
        pixel: [x, y],
        origin: ray.origin,
        direction: ray.direction,
        tmin: ray.tmin,
        tmax: ray.tmax,
        any_hit: ray.flags & 1 == 1,
        events: happened.collect(),
    }
}

fn what(event: &Event) -> What {
    match event {
        Event::Dispatch { trv } => What::Dispatch { trv: *trv },
        Event::Visit { node, enter } => What::Visit {
            leaf: node.is_leaf(),
            node: node.index,
            triangles: node.count,
            enter: *enter,
        },
        Event::Boxes { children, enter } => {
            let children = children.iter().zip(enter).map(|(child, enter)| Child {
                leaf: child.is_leaf(),
                node: child.index,
                enter: *enter,
            });
            What::Boxes {
                children: children.collect(),
            }
        }
        Event::Post { popped, finished } => What::Post {
            popped: *popped,
            finished: *finished,
        },
        Event::Triangle {
            primitive,
            t,
            taken,
        } => What::Triangle {
            primitive: *primitive,
            t: *t,
            taken: *taken,
        },
        Event::Result { hit } => What::Result {
            primitive: hit.map(|(p, _)| p),
            t: hit.map(|(_, t)| t),
        },
    }
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
