//! Quality against cost, with the line of what is best.

use maud::{Markup, html};
use srp_studies::accuracy::{Trial, front};

/// Size of the drawing and of its margins.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 44.0;
const BELOW: f64 = 30.0;
const ROUND: f64 = 12.0;

/// Where pictures without a wrong byte are drawn, above all others.
const EXACT: f64 = 8.0;

/// A trial in the plot.
struct Dot {
    x: f64,
    y: f64,
    label: String,
    best: bool,
    /// True when it costs more than the axis shows.
    far: bool,
}

/// A plot.
pub(super) struct Plot {
    dots: Vec<Dot>,
    /// Ends of the axes.
    x: (f64, f64),
    y: (f64, f64),
}

impl Plot {
    /// Of trials, by what they cost.
    pub(super) fn of(
        trials: &[Trial],
        cost: impl Fn(&Trial) -> f64,
        name: impl Fn(&Trial) -> String,
    ) -> Plot {
        let best = front(trials, &cost);
        let finite = || trials.iter().filter_map(|t| t.all.psnr);
        let top = finite().fold(40.0, f64::max) + EXACT;
        let bottom = finite().fold(top, f64::min);
        let costs: Vec<f64> = trials.iter().map(&cost).collect();
        let (least, most) = span(&costs);
        let dot = |(i, t): (usize, &Trial)| Dot {
            x: cost(t).min(most),
            y: t.all.psnr.unwrap_or(top),
            label: match t.all.psnr {
                Some(p) => format!("{}: {p:.2} dB, {:.3}", name(t), cost(t)),
                None => format!("{}: exact, {:.3}", name(t), cost(t)),
            },
            best: best.contains(&i),
            far: cost(t) > most,
        };
        let margin = ((most - least) * 0.05).max(most * 0.002).max(1e-9);
        Plot {
            dots: trials.iter().enumerate().map(dot).collect(),
            x: (least - margin, most + margin),
            y: ((bottom / 10.0).floor() * 10.0, top + 2.0),
        }
    }

    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let across = (x - self.x.0) / (self.x.1 - self.x.0);
        let up = (y - self.y.0) / (self.y.1 - self.y.0);
        (
            LEFT + across * (WIDTH - LEFT - ROUND),
            HEIGHT - BELOW - up * (HEIGHT - BELOW - ROUND),
        )
    }

    /// The line through the best, by cost.
    fn line(&self) -> String {
        let mut best: Vec<(f64, f64)> = (self.dots.iter())
            .filter(|d| d.best)
            .map(|d| self.place(d.x, d.y))
            .collect();
        best.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let steps = best.iter().enumerate().map(|(i, (x, y))| match i {
            0 => format!("M{x:.1} {y:.1}"),
            _ => format!("H{x:.1}V{y:.1}"),
        });
        steps.collect()
    }

    /// The drawing.
    pub(super) fn svg(&self) -> Markup {
        let first = (self.y.0 / 10.0).ceil() as i64 * 10;
        let levels: Vec<i64> = (first..=self.y.1 as i64).step_by(10).collect();
        let (ticks, digits) = ticks(self.x);
        html! {
            svg.plot viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" {
                @for level in levels {
                    @let (x, y) = self.place(self.x.0, level as f64);
                    line.grid x1=(x) y1=(format!("{y:.1}")) x2=(WIDTH - ROUND) y2=(format!("{y:.1}")) {}
                    text x=(x - 6.0) y=(format!("{:.1}", y + 4.0)) text-anchor="end" { (level) }
                }
                @for tick in ticks {
                    @let (x, y) = self.place(tick, self.y.0);
                    text x=(format!("{x:.1}")) y=(y + 18.0) text-anchor="middle" { (format!("{tick:.digits$}")) }
                }
                @let (x, y) = self.place(self.x.0, self.y.0);
                line.axis x1=(x) y1=(y) x2=(WIDTH - ROUND) y2=(y) {}
                line.axis x1=(x) y1=(y) x2=(x) y2=(ROUND) {}
                path d=(self.line()) {}
                @for (i, dot) in self.dots.iter().enumerate() {
                    @let (x, y) = self.place(dot.x, dot.y);
                    circle.best[dot.best].base[i == 0].far[dot.far] cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="4" {
                        title { (dot.label) }
                    }
                }
            }
        }
    }
}

/// The least cost, and the largest that is not far out: that is not three times as far beyond the
/// middle half of all as this half is wide.
fn span(costs: &[f64]) -> (f64, f64) {
    let mut costs = costs.to_vec();
    costs.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (costs.first(), costs.last()) else {
        return (0.0, 0.0);
    };
    let (lower, upper) = (costs[costs.len() / 4], costs[costs.len() * 3 / 4]);
    let fence = upper + 3.0 * (upper - lower);
    let near = costs.iter().rev().find(|&&c| c <= fence);
    (least, near.copied().unwrap_or(most))
}

/// Round numbers on an axis, four to ten of them, and their digits behind the point.
fn ticks((start, end): (f64, f64)) -> (Vec<f64>, usize) {
    let decade = libm::floor(libm::log10((end - start) / 4.0)) as i32;
    let ten = libm::pow(10.0, f64::from(decade));
    let fits = |step: &f64| (end - start) / step >= 4.0;
    let steps = [5.0 * ten, 2.0 * ten, ten];
    let step = steps.into_iter().find(fits).unwrap_or(ten);
    let first = (start / step).ceil() as i64;
    let last = (end / step).floor() as i64;
    let ticks = (first..=last).map(|i| i as f64 * step).collect();
    (ticks, usize::try_from(-decade).unwrap_or(0))
}
