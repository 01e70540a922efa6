//! FLIP: how different two pictures look to somebody who flips between them (Andersson et al., *FLIP: A
//! Difference Evaluator for Alternating Images*, HPG 2020), for pictures of 8 bits a channel, seen
//! as the article proposes: a monitor 0.7 m wide of 3840 pixels, 0.7 m away.
//!
//! All its filters are sums of products of one-dimensional ones, and are applied as such.

use std::f64::consts::PI;

/// Pixels in a degree of the field of view.
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// Exponents of the difference of colours and of features (section 4.3 of the article).
const COLOUR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;

/// Where the map of colour differences has its knee: below, it is steep.
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;

/// Width of a feature, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// The reference white, D65.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

/// sRGB's linear rgb to XYZ.
const TO_XYZ: [[f64; 3]; 3] = [
    [0.412_386_563_253, 0.357_591_490_921, 0.180_450_491_204],
    [0.212_636_821_677, 0.715_182_981_841, 0.072_180_196_481],
    [0.019_330_620_152, 0.119_197_163_640, 0.950_372_587_005],
];

/// And back.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_232_976, -1.537_398_969_489, -0.498_615_881_996],
    [-0.969_224_252_203, 1.875_929_983_695, 0.041_554_226_340],
    [0.055_639_419_852, -0.204_011_206_124, 1.057_148_977_188],
];

/// The sensitivity to contrast of a channel: a sum of Gaussians `a √(π/b) exp(−π² x² / b)` with x in
/// degrees.
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// The widest of them, by which all filters are cut off.
const WIDEST: f64 = 0.04;

type Colour = [f64; 3];

/// A channel of a picture.
#[derive(Clone)]
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Filtered along rows, then along columns; beyond its edges a picture goes on as it ends.
    fn filtered(&self, across: &[f64], down: &[f64]) -> Plane {
        let (width, height) = (self.width, self.height());
        let convolved =
            |from: &[f64], kernel: &[f64], length: usize, stride: usize, start: usize| {
                let radius = kernel.len() as isize / 2;
                let last = length as isize - 1;
                let value = move |at: isize| {
                    let taps = (-radius..=radius).zip(kernel);
                    taps.map(|(k, w)| w * from[start + (at + k).clamp(0, last) as usize * stride])
                        .sum::<f64>()
                };
                (0..length as isize).map(value).collect::<Vec<f64>>()
            };
        let rows = (0..height).flat_map(|y| convolved(&self.values, across, width, 1, y * width));
        let rows: Vec<f64> = rows.collect();
        let mut values = vec![0.0; rows.len()];
        for x in 0..width {
            let column = convolved(&rows, down, height, width, x);
            for (y, value) in column.into_iter().enumerate() {
                values[y * width + x] = value;
            }
        }
        Plane { width, values }
    }
}

/// The difference at each pixel, from 0 to 1. Pictures are sRGB from 0 to 1, rows of `width`.
pub(super) fn flip(reference: &[Colour], test: &[Colour], width: usize) -> Vec<f64> {
    let [a, b] = [reference, test].map(|p| opponent(p, width));
    let (seen_a, seen_b) = (perceived(&a), perceived(&b));
    let (edges_a, points_a) = features(&a[0]);
    let (edges_b, points_b) = features(&b[0]);
    let hue = |rgb: Colour| hunt(lab(rgb));
    let most = libm::pow(
        apart(hue([0.0, 1.0, 0.0]), hue([0.0, 0.0, 1.0])),
        COLOUR_EXPONENT,
    );
    let pixel = |i: usize| {
        let colour = libm::pow(apart(seen_a[i], seen_b[i]), COLOUR_EXPONENT);
        let knee = KNEE * most;
        let colour = if colour < knee {
            KNEE_VALUE / knee * colour
        } else {
            KNEE_VALUE + (colour - knee) / (most - knee) * (1.0 - KNEE_VALUE)
        };
        let feature = (edges_a[i] - edges_b[i])
            .abs()
            .max((points_a[i] - points_b[i]).abs());
        let feature = libm::pow((feature / 2f64.sqrt()).min(1.0), FEATURE_EXPONENT);
        libm::pow(colour.min(1.0), 1.0 - feature)
    };
    (0..reference.len()).map(pixel).collect()
}

/// Luminance and two opponent colours, linear in the light.
fn opponent(picture: &[Colour], width: usize) -> [Plane; 3] {
    let pixels: Vec<Colour> = (picture.iter())
        .map(|&srgb| {
            let [x, y, z] = times(&TO_XYZ, srgb.map(linear));
            let (x, y, z) = (x / WHITE[0], y / WHITE[1], z / WHITE[2]);
            [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
        })
        .collect();
    [0, 1, 2].map(|c| Plane {
        width,
        values: pixels.iter().map(|p| p[c]).collect(),
    })
}

/// A picture as it is seen: blurred as eyes blur it, in a space in which distances are differences.
fn perceived(planes: &[Plane; 3]) -> Vec<Colour> {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as isize;
    let blurred: Vec<Plane> = (planes.iter().zip(SENSITIVITY))
        .map(|(plane, gaussians)| {
            let mut sum = vec![0.0; plane.values.len()];
            let mut whole = 0.0;
            for &(a, b) in gaussians {
                let at = |k: isize| {
                    let x = k as f64 / PIXELS_PER_DEGREE;
                    libm::exp(-PI * PI * x * x / b)
                };
                let kernel: Vec<f64> = (-radius..=radius).map(at).collect();
                let weight = a * (PI / b).sqrt();
                whole += weight * kernel.iter().sum::<f64>() * kernel.iter().sum::<f64>();
                let part = plane.filtered(&kernel, &kernel);
                let parts = sum.iter_mut().zip(&part.values);
                parts.for_each(|(sum, part)| *sum += weight * part);
            }
            sum.iter_mut().for_each(|s| *s /= whole);
            Plane {
                width: plane.width,
                values: sum,
            }
        })
        .collect();
    let pixel = |i: usize| {
        let y = (blurred[0].values[i] + 16.0) / 116.0;
        let x = blurred[1].values[i] / 500.0 + y;
        let z = y - blurred[2].values[i] / 200.0;
        let rgb = times(&FROM_XYZ, [x * WHITE[0], y * WHITE[1], z * WHITE[2]]);
        hunt(lab(rgb.map(|c| c.clamp(0.0, 1.0))))
    };
    (0..planes[0].values.len()).map(pixel).collect()
}

/// How much each pixel is on an edge, and how much it is a point.
fn features(luminance: &Plane) -> (Vec<f64>, Vec<f64>) {
    let grey = Plane {
        width: luminance.width,
        values: luminance
            .values
            .iter()
            .map(|y| (y + 16.0) / 116.0)
            .collect(),
    };
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as isize;
    let gauss = |k: isize| libm::exp(-((k * k) as f64) / (2.0 * deviation * deviation));
    let kernel = |f: &dyn Fn(f64) -> f64| {
        let kernel: Vec<f64> = (-radius..=radius).map(|k| f(k as f64) * gauss(k)).collect();
        let up: f64 = kernel.iter().filter(|&&w| w > 0.0).sum();
        let down: f64 = -kernel.iter().filter(|&&w| w < 0.0).sum::<f64>();
        let scaled = kernel.iter().map(|&w| {
            if w > 0.0 {
                w / up
            } else {
                w / down.max(f64::MIN_POSITIVE)
            }
        });
        scaled.collect::<Vec<f64>>()
    };
    let smooth = kernel(&|_| 1.0);
    let strength = |along: &[f64]| {
        let (x, y) = (grey.filtered(along, &smooth), grey.filtered(&smooth, along));
        let both = x.values.iter().zip(&y.values);
        both.map(|(x, y)| (x * x + y * y).sqrt()).collect()
    };
    let edges = strength(&kernel(&|x| -x));
    let points = strength(&kernel(&|x| x * x / (deviation * deviation) - 1.0));
    (edges, points)
}

fn times(matrix: &[[f64; 3]; 3], v: Colour) -> Colour {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn linear(s: f64) -> f64 {
    if s <= 0.04045 {
        s / 12.92
    } else {
        libm::pow((s + 0.055) / 1.055, 2.4)
    }
}

/// CIE L*a*b* of linear rgb.
fn lab(rgb: Colour) -> Colour {
    const DELTA: f64 = 6.0 / 29.0;
    let xyz = times(&TO_XYZ, rgb);
    let f = |i: usize| {
        let t = xyz[i] / WHITE[i];
        if t > DELTA * DELTA * DELTA {
            libm::cbrt(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let (x, y, z) = (f(0), f(1), f(2));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Colours count less in the dark.
fn hunt([l, a, b]: Colour) -> Colour {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The distance HyAB.
fn apart(a: Colour, b: Colour) -> f64 {
    let (da, db) = (a[1] - b[1], a[2] - b[2]);
    (a[0] - b[0]).abs() + (da * da + db * db).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (48, 40);

    fn picture(of: impl Fn(usize, usize) -> [usize; 3]) -> Vec<Colour> {
        let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)));
        pixels
            .map(|(x, y)| of(x, y).map(|c| c as f64 / 255.0))
            .collect()
    }

    fn pattern(x: usize, y: usize) -> [usize; 3] {
        [x * 5 % 256, y * 6 % 256, x * y % 256]
    }

    /// Values of the authors' program, version 1.7, for the same pictures.
    #[test]
    fn agrees_with_the_authors() {
        let reference = picture(pattern);
        let test = picture(|x, y| {
            let [r, g, b] = pattern(x, y);
            let inverted = (10..20).contains(&y) && (12..30).contains(&x);
            let g = if inverted { 255 - g } else { g };
            [(r + (x + y) % 7 * 4).min(255), g, b]
        });
        let map = flip(&reference, &test, SIZE.0);
        let mean = map.iter().sum::<f64>() / map.len() as f64;
        assert!((mean - 0.231_621).abs() < 2e-5, "{mean}");
        for (x, y, expected) in [
            (0, 0, 0.023_656),
            (20, 15, 0.906_066),
            (47, 39, 0.149_474),
            (12, 10, 0.902_911),
            (30, 25, 0.187_860),
        ] {
            let found: f64 = map[y * SIZE.0 + x];
            assert!(
                (found - expected).abs() < 1e-4,
                "{x} {y}: {found}, not {expected}"
            );
        }
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let reference = picture(pattern);
        assert!(
            flip(&reference, &reference, SIZE.0)
                .iter()
                .all(|&d| d == 0.0)
        );
    }
}
