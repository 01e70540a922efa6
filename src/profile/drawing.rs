//! Drawings of a profile: what each core does in the course of time, and lines of the source as areas.

use super::{anchor, class_of};
use maud::{Markup, PreEscaped, html};
use srp_runtime::digits::thousands;
use srp_studies::profile::{CoreTimeline, LineProfile, Profile, Timeline};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Height of a core's row, and of that of its T&I unit.
const CORE: f64 = 44.0;
const UNIT: f64 = 18.0;

/// Width of a drawing.
const WIDTH: f64 = 1000.0;

/// Height of the areas.
const HEIGHT: f64 = 360.0;

/// Colours of loops.
const LOOPS: usize = 8;

/// The class of what a core does.
fn class(doing: &str, loops: &[&str]) -> String {
    match doing {
        "VLIW" => "p-vliw".to_owned(),
        "switch" => "p-switch".to_owned(),
        "memory" => "p-memory".to_owned(),
        "texture" => "p-texture".to_owned(),
        "instructions" | "contexts" => "p-code".to_owned(),
        "banks" => "p-banks".to_owned(),
        "wait" => "p-wait".to_owned(),
        name => {
            let number = loops.iter().position(|of| *of == name).unwrap_or(LOOPS);
            format!("l-{}", number.min(LOOPS))
        }
    }
}

/// The course of time, a row for each core and below it its T&I unit.
pub(super) fn timeline(profile: &Profile, timeline: &Timeline) -> Markup {
    let loops: Vec<&str> = profile.loops.iter().map(|l| l.kernel.as_str()).collect();
    let steps = timeline.cores.iter().flat_map(|core| &core.doings);
    let steps = steps.map(|d| d.cycles.len()).max().unwrap_or(1);
    let cores = timeline.cores.iter().flat_map(|core| &core.rays);
    let most = cores.copied().max().unwrap_or(0);
    let doings = timeline.cores.iter().flat_map(|core| &core.doings);
    let mut known: Vec<&str> = loops.clone();
    for doing in doings {
        if !known.contains(&doing.doing.as_str()) {
            known.push(&doing.doing);
        }
    }
    html! {
        section {
            h3 { "In the course of time" }
            p.soft { "From left to right " (thousands(timeline.step * steps as u64)) " cycles in steps of "
                (thousands(timeline.step)) ". Below each core the rays that its T&I unit gives back, up to "
                (thousands(most)) " in a step." }
            @for (number, core) in timeline.cores.iter().enumerate() {
                div.row {
                    span.name { "core " (number) }
                    (row(core, timeline.step, steps, most, &loops))
                }
            }
            p.keys { @for name in &known {
                span { span class={ "key " (class(name, &loops)) } {} " " (name) }
            } }
        }
    }
}

/// A core's row: for each thing that it does one path of bars, and the rays below.
fn row(core: &CoreTimeline, step: u64, steps: usize, most: u64, loops: &[&str]) -> Markup {
    let width = WIDTH / steps as f64;
    let mut below = vec![CORE; steps];
    let mut drawn = String::new();
    for doing in &core.doings {
        let mut path = String::new();
        for (i, &cycles) in doing.cycles.iter().enumerate().filter(|(_, c)| **c > 0) {
            let height = CORE * cycles as f64 / step as f64;
            below[i] -= height;
            bar(&mut path, i as f64 * width, below[i], width, height);
        }
        let class = class(&doing.doing, loops);
        let _ = write!(
            drawn,
            "<path class=\"{class}\" d=\"{path}\"><title>{}</title></path>",
            doing.doing
        );
    }
    let mut path = String::new();
    for (i, &rays) in core.rays.iter().enumerate().filter(|(_, r)| **r > 0) {
        let height = UNIT * rays as f64 / most.max(1) as f64;
        let top = CORE + 2.0 + UNIT - height;
        bar(&mut path, i as f64 * width, top, width, height);
    }
    let _ = write!(
        drawn,
        "<path class=\"unit\" d=\"{path}\"><title>rays of the T&amp;I unit</title></path>"
    );
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {}", CORE + 2.0 + UNIT)) preserveAspectRatio="none" role="img" {
            (PreEscaped(drawn))
        }
    }
}

fn bar(path: &mut String, x: f64, y: f64, width: f64, height: f64) {
    let _ = write!(path, "M{x:.1} {y:.1}h{width:.1}v{height:.1}h-{width:.1}z");
}

/// A rectangle.
#[derive(Clone, Copy)]
struct Area {
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// Files and their lines as areas as large as their cycles, in the colour of what most of them are.
pub(super) fn areas(profile: &Profile) -> Markup {
    let mut files: BTreeMap<&str, Vec<&LineProfile>> = BTreeMap::new();
    for line in profile.lines.iter().filter(|line| line.line > 0) {
        files.entry(&line.file).or_default().push(line);
    }
    let cycles = |lines: &[&LineProfile]| lines.iter().map(|l| l.parts.total()).sum::<u64>();
    let mut files: Vec<(&str, Vec<&LineProfile>)> = files.into_iter().collect();
    files.sort_by_key(|(name, lines)| (std::cmp::Reverse(cycles(lines)), *name));
    let sizes: Vec<u64> = files.iter().map(|(_, lines)| cycles(lines)).collect();
    let whole = Area {
        x: 0.0,
        y: 0.0,
        width: WIDTH,
        height: HEIGHT,
    };
    let mut drawn = String::new();
    for ((_, lines), area) in files.iter_mut().zip(squarified(&sizes, whole)) {
        lines.sort_by_key(|line| (std::cmp::Reverse(line.parts.total()), line.line));
        let sizes: Vec<u64> = lines.iter().map(|line| line.parts.total()).collect();
        for (line, area) in lines.iter().zip(squarified(&sizes, area)) {
            draw(&mut drawn, line, area);
        }
        let Area {
            x,
            y,
            width,
            height,
        } = area;
        let _ = write!(
            drawn,
            "<rect class=\"file\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }
    html! {
        section {
            h3 { "Lines by their cycles" }
            svg.areas viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" { (PreEscaped(drawn)) }
        }
    }
}

fn draw(drawn: &mut String, line: &LineProfile, area: Area) {
    let class = class_of(&line.parts);
    let name = format!("{}:{}", line.file, line.line);
    let short = name.rsplit('/').next().unwrap_or(&name);
    let Area {
        x,
        y,
        width,
        height,
    } = area;
    let title = html! { (name) ": " (thousands(line.parts.total())) " cycles" }.into_string();
    let _ = write!(
        drawn,
        "<a href=\"#{}\"><rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" \
         height=\"{height:.1}\"><title>{title}</title></rect>",
        anchor(&name)
    );
    if width > 6.5 * short.len() as f64 && height > 14.0 {
        let label = html! { (short) }.into_string();
        let (x, y) = (x + 4.0, y + 12.0);
        let _ = write!(drawn, "<text x=\"{x:.1}\" y=\"{y:.1}\">{label}</text>");
    }
    drawn.push_str("</a>");
}

/// Parts of an area, as large as these sizes, which do not ascend, and as square as rows of them can be (Bruls,
/// Huizing and van Wijk 2000).
fn squarified(sizes: &[u64], mut area: Area) -> Vec<Area> {
    let mut found = Vec::new();
    let mut left = sizes;
    while !left.is_empty() {
        let all: f64 = left.iter().map(|&size| size as f64).sum::<f64>().max(1.0);
        let scale = area.width * area.height / all;
        let side = area.width.min(area.height).max(1e-6);
        // The worst ratio of sides in a row of the first `n`.
        let worst = |n: usize| {
            let sum = left[..n]
                .iter()
                .map(|&s| s as f64 * scale)
                .sum::<f64>()
                .max(1e-9);
            let ratio = |&size: &u64| {
                let along = (size as f64 * scale / sum * side).max(1e-9);
                let across = sum / side;
                (along / across).max(across / along)
            };
            left[..n].iter().map(ratio).fold(0.0, f64::max)
        };
        let mut n = 1;
        while n < left.len() && worst(n + 1) <= worst(n) {
            n += 1;
        }
        let sum = left[..n].iter().map(|&s| s as f64 * scale).sum::<f64>();
        let across = sum / side;
        let mut along = 0.0;
        for &size in &left[..n] {
            let length = size as f64 * scale / sum.max(1e-9) * side;
            found.push(match area.width >= area.height {
                true => Area {
                    x: area.x,
                    y: area.y + along,
                    width: across,
                    height: length,
                },
                false => Area {
                    x: area.x + along,
                    y: area.y,
                    width: length,
                    height: across,
                },
            });
            along += length;
        }
        match area.width >= area.height {
            true => (area.x, area.width) = (area.x + across, (area.width - across).max(0.0)),
            false => (area.y, area.height) = (area.y + across, (area.height - across).max(0.0)),
        }
        left = &left[n..];
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_as_large_as_their_sizes_and_inside() {
        let sizes = [60, 30, 30, 20, 10, 5, 5, 1, 1];
        let whole = Area {
            x: 5.0,
            y: 7.0,
            width: 90.0,
            height: 40.0,
        };
        let areas = squarified(&sizes, whole);
        assert_eq!(areas.len(), sizes.len());
        let all: u64 = sizes.iter().sum();
        for (area, &size) in areas.iter().zip(&sizes) {
            let expected = 3600.0 * size as f64 / all as f64;
            assert!((area.width * area.height - expected).abs() < 1e-6);
            assert!(area.x >= 5.0 && area.x + area.width <= 95.0 + 1e-9);
            assert!(area.y >= 7.0 && area.y + area.height <= 47.0 + 1e-9);
        }
        for (i, a) in areas.iter().enumerate() {
            for b in &areas[..i] {
                let overlap = |a: f64, an: f64, b: f64, bn: f64| (a + an).min(b + bn) - a.max(b);
                let both =
                    overlap(a.x, a.width, b.x, b.width).min(overlap(a.y, a.height, b.y, b.height));
                assert!(both < 1e-6);
            }
        }
    }
}
