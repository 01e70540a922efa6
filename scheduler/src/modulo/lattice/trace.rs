//! From a map of deliveries back to the way that it promises, and from ways to routes.

use super::delivery::Map;
use super::state::{Point, State, Way};
use crate::modulo::problem::Tag;
use crate::modulo::route::Route;
use crate::modulo::table::{Item, Via};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_archdesc::resource::Place;

impl State<'_, '_> {
    /// The cheapest way of a net in a map of its value. A stay in a file that is longer than it has registers for takes
    /// the same register twice, and so is a conflict like others.
    pub(super) fn trace(&self, net: usize, map: &Map) -> Way {
        let net = &self.nets[net];
        let (_, read) = self.ends(net);
        let (unit, _) = self.place(net.to);
        let root = self.root(net.from);
        let mut way = Vec::new();
        let mut point = self.read_from(map, read, unit);
        loop {
            way.push(point);
            point = match self.cost(map, point) {
                0 => break,
                _ if point.in_file => self.kept_from(map, point),
                _ => self.read_from(map, point.time - 1, point.lane),
            };
        }
        let join = *way.last().expect("a way has points");
        if join != root {
            // The rest is that of another way of the value.
            let ways = self.nets_of[net.from].iter();
            let ways = ways.filter(|&&other| self.nets[other].from == net.from);
            let mut ways = ways.filter_map(|&other| self.ways[other].as_ref());
            let rest = ways.find_map(|way| {
                let at = way.iter().position(|&p| p == join)?;
                Some(&way[at + 1..])
            });
            way.extend(rest.expect("what costs nothing is on a way of the value"));
        }
        way
    }

    fn cost(&self, map: &Map, point: Point) -> i16 {
        match point.in_file {
            true => map.file(point.time, point.lane),
            false => map.out(point.time, point.lane),
        }
    }

    /// Where a unit reads the value most cheaply.
    fn read_from(&self, map: &Map, time: i32, unit: u16) -> Point {
        let cost = map.read(time, unit);
        let at = |lane: u16, in_file: bool| Point {
            time,
            lane,
            in_file,
        };
        if map.file(time, unit) == cost {
            return at(unit, true);
        }
        if map.out(time, unit) == cost {
            return at(unit, false);
        }
        let links = self.array.links.iter();
        let mut links = links.filter(|links| links.mask[usize::from(unit)] == 0);
        let from = links.find_map(|links| {
            let lane = usize::from(unit).checked_add_signed(links.shift)? as u16;
            (map.out(time, lane) == cost).then_some(lane)
        });
        at(from.expect("a cost comes from somewhere"), false)
    }

    /// How the value came to stand in a file: from the output, or it stood there before.
    fn kept_from(&self, map: &Map, point: Point) -> Point {
        let before =
            map.file(point.time, point.lane) - self.prices.register(point.time, point.lane);
        match map.out(point.time, point.lane) == before {
            true => Point {
                in_file: false,
                ..point
            },
            false => Point {
                time: point.time - 1,
                ..point
            },
        }
    }

    /// The route of each edge of the problem, once every net has a way.
    pub(super) fn routes(&self) -> Vec<Route> {
        let mut routes = vec![None; self.problem.edges.len()];
        for (net, way) in self.nets.iter().zip(&self.ways) {
            let way = way.as_ref().expect("no net is open");
            let (_, read) = self.ends(net);
            let (unit, _) = self.place(net.to);
            let mut items = self.items(way);
            let last = way[0];
            if last.in_file {
                let file = self.file(last.lane);
                items.push(Item::Read(file, read, Tag::Plain, Fu::new(unit.into())));
            }
            let route = Route::new(items, self.read_path(last, unit), Tag::Plain);
            (net.edges.iter()).for_each(|&e| routes[e] = Some(route.clone()));
        }
        let routes = routes.into_iter();
        routes
            .map(|route| route.expect("every edge is of a net"))
            .collect()
    }

    fn file(&self, lane: u16) -> Place {
        let file = self.array.files[usize::from(lane)];
        file.expect("values stand in files that there are").0
    }

    fn out(&self, lane: u16) -> Place {
        self.problem.graph.out[Fu::new(lane.into())]
    }

    /// The path by which a unit reads a value where it stands.
    fn read_path(&self, from: Point, unit: u16) -> u32 {
        let place = match from.in_file {
            true => self.file(from.lane),
            false => self.out(from.lane),
        };
        let reads = &self.problem.graph.reads[Fu::new(unit.into())];
        let bits = self.array.ty.bits();
        let path = reads
            .iter()
            .position(|read| read.from == place && read.width >= bits && read.delay == 0);
        path.expect("units read over the ways of the array") as u32
    }

    /// The items that a way takes, from the producer on.
    fn items(&self, way: &Way) -> Vec<Item> {
        let mut items = Vec::new();
        let mut points = way.iter().rev().copied().peekable();
        let root = points.next().expect("a way begins at its producer");
        items.push(Item::Out(self.out(root.lane), root.time));
        let mut before = root;
        while let Some(point) = points.next() {
            let unit = Fu::new(point.lane.into());
            if point.in_file {
                let file = self.file(point.lane);
                if !before.in_file {
                    let via = Via::Result(unit);
                    items.push(Item::Written(file, point.time, Tag::Plain, via));
                }
                items.push(Item::Held(file, point.time, Tag::Plain));
            } else {
                // An output that is only kept needs no move, unless the value goes from there into the file.
                let written = points.peek().is_some_and(|next| next.in_file);
                let kept = !before.in_file && before.lane == point.lane && !written;
                if !kept {
                    if before.in_file {
                        let file = self.file(before.lane);
                        items.push(Item::Read(file, before.time, Tag::Plain, unit));
                    }
                    let path = self.read_path(before, point.lane);
                    items.push(Item::Move(unit, point.time - 1, path, Tag::Plain));
                }
                items.push(Item::Out(self.out(point.lane), point.time));
            }
            before = point;
        }
        items
    }
}
