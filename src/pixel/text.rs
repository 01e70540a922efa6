//! The history of a pixel as text: launches, functions and rays in their order, and in each the values that have a
//! name, samples of textures, and accesses to memory.

use super::History;
use crate::count::count;
use srp_archdesc::isa::{Effect, Kind, Opcode, Ty};
use srp_csimgen::preamble::ops::V4;
use srp_runtime::tni::arithmetic::ANY_HIT;
use srp_traces::history::{Made, MadeWhat, Operation, Place, TracedRay, Want};
use std::collections::BTreeMap;
use std::fmt::Write;

/// What is told together.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Group {
    /// An iteration of a launch.
    Iteration(u32, u64, u64),
    /// The code of a function.
    Function(String),
    /// A ray.
    Ray(u32),
}

impl History {
    /// The variable that gets the result of an operation.
    pub(super) fn variable(&self, operation: &Operation) -> Option<&str> {
        let at = self.trace.spec.position(operation.at)?;
        self.variables.name(at, operation.opcode)
    }

    /// What lies at the address that an operation reads or writes.
    pub(super) fn place(&self, operation: &Operation) -> Option<String> {
        let address = operation.address?;
        Some(self.places.name(operation.opcode.space()?, address))
    }

    pub(super) fn text(&self) -> String {
        let mut text = self.head();
        for (group, made) in self.groups() {
            text.push('\n');
            let cycles = (
                made.iter().map(|made| made.cycle).min().unwrap_or(0),
                made.iter().map(|made| made.cycle).max().unwrap_or(0),
            );
            if let [
                Made {
                    cycle,
                    what: MadeWhat::Ray(ray),
                    ..
                },
            ] = made[..]
            {
                text += &of_ray(*cycle, ray);
                continue;
            }
            let title = match &group {
                Group::Iteration(kernel, launch, iteration) => {
                    let name = &self.trace.spec.kernels[*kernel as usize].name;
                    format!("{name}, launch {launch}, iteration {iteration}")
                }
                Group::Function(name) => format!("{name}, VLIW code"),
                Group::Ray(_) => String::new(),
            };
            let number = count(made.len() as u64, "operation");
            let _ = writeln!(text, "{}..{}  {title}: {number}", cycles.0, cycles.1);
            for made in made {
                // The queue's own work is not what the pixel is of.
                let is_queue = matches!(group, Group::Function(_)) && made.want == Want::Address;
                if is_queue {
                    continue;
                }
                if let MadeWhat::Operation(operation) = &made.what {
                    text += &self.line(made.cycle, operation);
                }
            }
        }
        text
    }

    fn head(&self) -> String {
        let [red, green, blue, _] = self.bytes;
        let (cycles, core) = (&self.stored.cycles, self.stored.core);
        let (x, y, tile) = (self.wanted.x, self.wanted.y, self.wanted.tile);
        let is_ray = |made: &&Made| matches!(made.what, MadeWhat::Ray(_));
        let rays = self.made.iter().filter(is_ray).count();
        let samples = self.made.iter().filter(|made| match &made.what {
            MadeWhat::Operation(operation) => operation.opcode == Opcode::Tex,
            MadeWhat::Ray(_) => false,
        });
        format!(
            "pixel {x},{y} is {red} {green} {blue} (#{red:02x}{green:02x}{blue:02x}): tile {tile}, core {core}, cycles {}..{}\n\
             made of {}, {} and {}\n\
             all of these cycles: --trace {}..{}@{core}\n",
            cycles.start,
            cycles.end,
            count((self.made.len() - rays) as u64, "operation"),
            count(samples.count() as u64, "texture sample"),
            count(rays as u64, "ray"),
            cycles.start,
            cycles.end,
        )
    }

    /// What is told together, in the order in which it begins.
    fn groups(&self) -> Vec<(Group, Vec<&Made>)> {
        let mut groups: BTreeMap<Group, Vec<&Made>> = BTreeMap::new();
        for made in &self.made {
            groups.entry(self.group(made)).or_default().push(made);
        }
        let mut groups: Vec<_> = groups.into_iter().collect();
        groups.sort_by_key(|(_, made)| (made[0].cycle, made[0].id));
        groups
    }

    fn group(&self, made: &Made) -> Group {
        match &made.what {
            MadeWhat::Ray(_) => Group::Ray(made.id),
            MadeWhat::Operation(operation) => match operation.place {
                Place::Array {
                    kernel,
                    launch,
                    iteration,
                } => Group::Iteration(kernel, launch, iteration),
                Place::Bundle(bundle) => {
                    let name = self.trace.spec.function_of(bundle);
                    Group::Function(name.unwrap_or("start").to_owned())
                }
            },
        }
    }

    /// A line for an operation that makes a variable, samples a texture, or reads or writes memory.
    fn line(&self, cycle: u64, operation: &Operation) -> String {
        let info = operation.opcode.info();
        let name = self.variable(operation);
        let place = self.place(operation);
        let value = |(value, ty): (V4, Ty), kind| shown(value, ty, kind);
        let what = match (info.effect, place, name) {
            (Effect::Store, Some(place), _) => {
                let stored = operation.operands.get(2).copied();
                let stored = stored.map(|of| value(of, info.operands.get(2).copied()));
                format!("{place} = {}", stored.unwrap_or_default())
            }
            (_, place, name) => {
                let Some(result) = operation.result else {
                    return String::new();
                };
                let result = value(result, info.result);
                match (operation.opcode, place, name) {
                    (Opcode::Tex, Some(place), _) => {
                        let at = operation.operands.get(2).map(|of| of.0.0);
                        let [s, t, level, _] = at.unwrap_or_default().map(f32::from_bits);
                        let name = name.map_or(String::new(), |name| format!("{name} = "));
                        format!("{name}{place} at ({s}, {t}), level {level} = {result}")
                    }
                    (_, Some(place), Some(name)) => format!("{name} = {place} = {result}"),
                    (_, Some(place), None) => format!("{place} = {result}"),
                    (_, None, Some(name)) => format!("{name} = {result}"),
                    (_, None, None) => return String::new(),
                }
            }
        };
        let at = self.trace.spec.position(operation.at).unwrap_or_default();
        let at = at.rsplit_once(':').map_or(at, |(line, _)| line);
        let at = at.rsplit_once('/').map_or(at, |(_, file)| file);
        format!("  {cycle:>9}  {at:<16}  {what}\n")
    }
}

fn of_ray(cycle: u64, of: &TracedRay) -> String {
    let (ray, hit) = (&of.ray, of.hit.hit);
    let kind = match ray.flags & ANY_HIT {
        0 => "ray",
        _ => "shadow ray",
    };
    let [ox, oy, oz] = ray.origin;
    let [dx, dy, dz] = ray.direction;
    let mut text = format!(
        "{cycle}..{}  {kind} {} of packet {}\n",
        of.returned, of.index, of.packet
    );
    let _ = writeln!(
        text,
        "  from ({ox}, {oy}, {oz}) towards ({dx}, {dy}, {dz}), t from {:e} to {:e}",
        ray.tmin, ray.tmax
    );
    if let Some((done, cost)) = of.cost {
        let _ = writeln!(
            text,
            "  {done:>9}  {} and {} later",
            count(u64::from(cost.visits), "node"),
            count(u64::from(cost.tests), "triangle test")
        );
    }
    let _ = match hit.is_hit() {
        true => writeln!(
            text,
            "  {:>9}  hits triangle {} at t = {}, u = {}, v = {}",
            of.returned, hit.primitive, hit.t, hit.u, hit.v
        ),
        false => writeln!(text, "  {:>9}  hits nothing", of.returned),
    };
    text
}

/// A value: of numbers with a point their shortest digits; what may be either is shown as what it looks like.
fn shown(V4(lanes): V4, ty: Ty, kind: Option<Kind>) -> String {
    let lane = |bits: u32| match kind {
        Some(Kind::F | Kind::F4) => f32::from_bits(bits).to_string(),
        Some(Kind::I | Kind::I4) if (bits as i32).unsigned_abs() < 1 << 24 => {
            (bits as i32).to_string()
        }
        Some(Kind::I | Kind::I4) => format!("{bits:#x}"),
        _ => {
            let number = f32::from_bits(bits);
            match (1e-20..1e20).contains(&number.abs()) || bits == 0 {
                true => number.to_string(),
                false if (bits as i32).unsigned_abs() < 1 << 23 => (bits as i32).to_string(),
                false => format!("{bits:#010x}"),
            }
        }
    };
    match ty {
        Ty::Pred => (if lanes[0] & 1 == 1 { "true" } else { "false" }).to_owned(),
        Ty::Word => lane(lanes[0]),
        Ty::Vec => {
            let [x, y, z, w] = lanes.map(lane);
            format!("({x}, {y}, {z}, {w})")
        }
    }
}
