//! Rays as text: a line each, `ox oy oz dx dy dz [tmin tmax [any]]`. Empty lines and what follows
//! a `#` do not count.

use srp_runtime::tni::arithmetic::{ANY_HIT, Ray};

/// Most rays of a file.
pub const MAX_RAYS: usize = 1 << 26;

/// Reads rays. The payload of each is its number, from 0. An error says the line, from 1, and what
/// is wrong with it.
pub fn read(text: &str) -> Result<Vec<Ray>, (usize, String)> {
    let mut rays = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default();
        let mut words: Vec<&str> = line.split_ascii_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        if rays.len() == MAX_RAYS {
            return Err((number, format!("more than {MAX_RAYS} rays")));
        }
        let any = words.len() == 9 && words[8] == "any";
        if any {
            words.pop();
        } else if words.len() == 9 {
            let why = format!(
                "`{}` is not `any`, the word for rays that end with any hit",
                words[8]
            );
            return Err((number, why));
        }
        if !matches!(words.len(), 6 | 8) {
            return Err((
                number,
                format!(
                    "{} words; a ray is `ox oy oz dx dy dz`, then `tmin tmax`, then `any` where \
                     any hit will do",
                    words.len()
                ),
            ));
        }
        let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::MAX];
        for (value, word) in numbers.iter_mut().zip(&words) {
            *value = word
                .parse()
                .map_err(|_| (number, format!("`{word}` is not a number")))?;
        }
        let [ox, oy, oz, dx, dy, dz, tmin, tmax] = numbers;
        let flags = if any { ANY_HIT } else { 0 };
        let mut ray = Ray::new([ox, oy, oz], [dx, dy, dz], tmin, tmax, flags);
        ray.payload = rays.len() as u32;
        rays.push(ray);
    }
    Ok(rays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_rays_and_says_what_is_wrong() {
        let rays = read("# a comment\n0 1 2 0 0 -1\n\n1e3 0 0 1 0 0 0.5 9 any # shadow\n");
        let rays = rays.expect("two rays");
        assert_eq!(rays[0].origin, [0.0, 1.0, 2.0]);
        assert_eq!((rays[0].tmax, rays[0].flags), (f32::MAX, 0));
        assert_eq!((rays[1].tmin, rays[1].tmax), (0.5, 9.0));
        assert_eq!((rays[1].flags, rays[1].payload), (ANY_HIT, 1));
        let wrong = |text| read(text).expect_err(text);
        assert_eq!(
            wrong("0 0 0 1 0 0\n0 0 x 1 0 0"),
            (2, "`x` is not a number".to_owned())
        );
        assert_eq!(wrong("0 0 0 1 0").0, 1);
        assert!(
            wrong("0 0 0 1 0 0 0 1 all")
                .1
                .contains("`all` is not `any`")
        );
    }
}
