//! Cosine and sine that are the same on every host: a camera or a scene made with the host's
//! library could differ in the last bit, and with it every cycle count.

/// Cosine and sine of `part` full turns, within 2^-50. The part is reduced exactly to at most an
/// eighth of a turn, where the Taylor series converges quickly.
pub fn turn(part: f64) -> (f64, f64) {
    let part = part - part.floor();
    let quadrant = (((part * 8.0).floor() + 1.0) / 2.0).floor();
    let x = (part - quadrant / 4.0) * std::f64::consts::TAU;
    let (mut cos, mut sin, mut term) = (0.0, 0.0, 1.0);
    for k in 0..10 {
        cos += term;
        term *= x / f64::from(2 * k + 1);
        sin += term;
        term *= -x / f64::from(2 * k + 2);
    }
    match quadrant as u32 % 4 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_cosine_and_sine() {
        for i in -500..1000 {
            let part = f64::from(i) / 371.0;
            let (cos, sin) = turn(part);
            let angle = part * std::f64::consts::TAU;
            assert!((cos - angle.cos()).abs() < 1e-14, "{part}");
            assert!((sin - angle.sin()).abs() < 1e-14, "{part}");
        }
        assert_eq!(turn(0.25), (0.0, 1.0));
        assert_eq!(turn(0.5), (-1.0, 0.0));
        assert_eq!(turn(1.0), (1.0, 0.0));
    }
}
