//! Loads of a loop on register files and links, one by one.

use crate::count::count;
use maud::{Markup, html};
use srp_studies::loops::{FileLoad, LinkLoad, LoopReport, PortLoad, WireLoad, part, percent};

/// Height of the bars of a file's cycles.
const TALL: f64 = 26.0;
/// Widest a cycle's bar, and all of them.
const BAR: (f64, f64) = (12.0, 120.0);

/// Register pressure: of every file in use, the live registers in each cycle against its capacity.
pub(super) fn files(l: &LoopReport) -> Markup {
    let mut used: Vec<&FileLoad> = l.files.iter().filter(|f| f.live > 0).collect();
    used.sort_by(|a, b| {
        let full = |f: &FileLoad| part(f.live, f.capacity);
        a.kind.cmp(&b.kind).then(full(b).total_cmp(&full(a)))
    });
    let idle = l.files.len() - used.len();
    html! {
        @if !l.files.is_empty() {
            h3 { "Registers that hold something still needed, cycle by cycle" }
            div.takes { @for f in used { (file(f)) } }
            @if idle > 0 { p.soft { "Nothing is in the other " (count(idle as u32, "file")) "." } }
        }
    }
}

fn file(f: &FileLoad) -> Markup {
    let width = BAR.0.min(BAR.1 / f.live_by_slot.len() as f64);
    let all = width * f.live_by_slot.len() as f64;
    let full = f.live >= f.capacity;
    let what = format!(
        "{}: {} {}-bit registers, {}; at most {} live, in cycle {} of the II; {} all the time; {}; {}",
        f.file,
        f.capacity,
        f.width,
        f.kind.name(),
        f.live,
        f.live_slot,
        f.kept,
        ports("read", &f.read),
        ports("write", &f.write)
    );
    html! {
        div.take.full[full] title=(what) {
            svg width=(all) height=(TALL) viewBox=(format!("0 0 {all} {TALL}")) role="img" aria-label=(f.file) {
                rect.empty width=(all) height=(TALL) {}
                @for (slot, &live) in f.live_by_slot.iter().enumerate() {
                    @let tall = TALL * part(live, f.capacity);
                    rect.live x=(format!("{:.1}", slot as f64 * width)) y=(format!("{:.1}", TALL - tall))
                        width=(format!("{:.1}", (width - 1.0).max(0.5))) height=(format!("{tall:.1}")) {}
                }
            }
            div {
                code { (f.file) } " " b { (f.live) } " of " (f.capacity)
                small { (f.kind.name()) ", fullest in cycle " (f.live_slot)
                    @for (way, p) in [("read", &f.read), ("write", &f.write)] {
                        @if p.most >= p.ports && p.most > 0 {
                            span { ", all " (count(p.ports, &format!("{way} port"))) " taken" }
                        }
                    }
                }
            }
        }
    }
}

fn ports(way: &str, p: &PortLoad) -> String {
    format!(
        "{way} ports: at most {} of {} in cycle {}",
        p.most, p.ports, p.most_slot
    )
}

/// Utilisation of every link, wire and shared resource.
pub(super) fn links(l: &LoopReport) -> Markup {
    let mut links: Vec<&LinkLoad> = l.links.iter().collect();
    links.sort_by_key(|link| std::cmp::Reverse(link.slots));
    let used = links.iter().filter(|link| link.slots > 0).count();
    let mut wires: Vec<&WireLoad> = l.wires.iter().collect();
    wires.sort_by_key(|wire| std::cmp::Reverse(wire.slots));
    let taking = wires.iter().filter(|wire| wire.slots > 0).count();
    html! {
        @if !links.is_empty() {
            details.links {
                summary { (used) " of " (count(links.len() as u32, "link")) " in use, "
                    (percent(l.links_busy())) " of their cycles" }
                div.takes { @for link in links { (one(&link.name(), link.slots, l.ii)) } }
            }
        }
        @if !wires.is_empty() {
            details.links {
                summary { (taking) " of " (count(wires.len() as u32, "wire")) " in use, "
                    (percent(l.wires_busy())) " of their cycles" }
                div.takes { @for wire in wires { (one(&wire.wire, wire.slots, l.ii)) } }
            }
        }
        @let shared: Vec<_> = l.shared.iter().filter(|s| s.uses.iter().any(|&n| n > 0)).collect();
        @if !shared.is_empty() {
            h3 { "Shared resources" }
            div.takes { @for s in shared { (one(&s.resource, s.uses.iter().sum(), s.offered * l.ii)) } }
        }
    }
}

fn one(name: &str, taken: u32, of: u32) -> Markup {
    html! {
        div.take title=(format!("{name}: {taken} of {of}")) {
            div.bar { i style=(format!("width:{:.0}%", 100.0 * part(taken, of))) {} }
            div { code { (name) } " " b { (percent(part(taken, of))) } }
        }
    }
}
