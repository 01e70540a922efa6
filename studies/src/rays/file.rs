//! Rays as text: a line each, `ox oy oz dx dy dz [tmin tmax [any]]`. Empty lines and what follows
//! a `#` do not count.

use srp_archdesc::diagnostic::{Diagnostic, Span};
use srp_runtime::tni::arithmetic::{ANY_HIT, Ray};

/// Most rays of a file.
pub const MAX_RAYS: usize = 1 << 26;

/// Reads rays; `file` is the name of the text for messages. The payload of each ray is its number, from 0.
///
/// # Errors
///
/// The first mistake, with its place.
pub fn read(file: &str, text: &str) -> Result<Vec<Ray>, Box<Diagnostic>> {
    let mut rays = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let numbered = ray(line, rays.len()).map_err(|mistake| {
            let at = |offset: usize| (start + offset) as u32;
            let span = Span::new(at(mistake.at.0), at(mistake.at.1));
            let form =
                "a line is `ox oy oz dx dy dz`, then `tmin tmax`, then `any` where any hit will do";
            let message = Diagnostic::error("R0601", file, mistake.message);
            Box::new(message.at(span, "").help(form))
        })?;
        rays.extend(numbered);
        start += line.len();
    }
    Ok(rays)
}

/// A mistake in a line, at these bytes of it.
struct Mistake {
    message: String,
    at: (usize, usize),
}

/// The ray on a line, if there is one.
fn ray(line: &str, number: usize) -> Result<Option<Ray>, Mistake> {
    let text = line.split('#').next().unwrap_or_default();
    let place = |word: &str| {
        let from = word.as_ptr() as usize - line.as_ptr() as usize;
        (from, from + word.len())
    };
    let mut words: Vec<&str> = text.split_ascii_whitespace().take(10).collect();
    let (Some(first), Some(last)) = (words.first(), words.last().copied()) else {
        return Ok(None);
    };
    let whole = (place(first).0, place(last).1);
    let wrong = |message: String, at| Err(Mistake { message, at });
    if number == MAX_RAYS {
        return wrong(format!("more than {MAX_RAYS} rays"), whole);
    }
    let any = words.len() == 9 && last == "any";
    if any {
        words.pop();
    } else if words.len() == 9 {
        let what = "the word for rays that end with any hit is `any`";
        return wrong(what.to_owned(), place(last));
    }
    if !matches!(words.len(), 6 | 8) {
        let count = match words.len() {
            1 => "1 word".to_owned(),
            10.. => "more than 9 words".to_owned(),
            n => format!("{n} words"),
        };
        return wrong(format!("a ray has 6, 8 or 9 words, not {count}"), whole);
    }
    let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::MAX];
    for (value, word) in numbers.iter_mut().zip(&words) {
        match word.parse() {
            Ok(number) => *value = number,
            Err(_) => return wrong("this is not a number".to_owned(), place(word)),
        }
    }
    let [ox, oy, oz, dx, dy, dz, tmin, tmax] = numbers;
    let flags = if any { ANY_HIT } else { 0 };
    let mut ray = Ray::new([ox, oy, oz], [dx, dy, dz], tmin, tmax, flags);
    ray.payload = number as u32;
    Ok(Some(ray))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_rays_and_says_what_is_wrong() {
        let rays = read(
            "r",
            "# a comment\n0 1 2 0 0 -1\n\n1e3 0 0 1 0 0 0.5 9 any # shadow\n",
        );
        let rays = rays.expect("two rays");
        assert_eq!(rays[0].origin, [0.0, 1.0, 2.0]);
        assert_eq!((rays[0].tmax, rays[0].flags), (f32::MAX, 0));
        assert_eq!((rays[1].tmin, rays[1].tmax), (0.5, 9.0));
        assert_eq!((rays[1].flags, rays[1].payload), (ANY_HIT, 1));
        let wrong = |text: &str| {
            let message = read("r", text).expect_err(text);
            let span = message.primary.as_ref().expect("a place").span;
            let at = &text[span.start as usize..span.end as usize];
            (message.message.clone(), at.to_owned())
        };
        let (what, at) = wrong("0 0 0 1 0 0\n0 0 x 1 0 0");
        assert_eq!((what.as_str(), at.as_str()), ("this is not a number", "x"));
        assert_eq!(wrong("#\n 0 0 0 1 0 # ray\n").1, "0 0 0 1 0");
        assert_eq!(wrong("0 0 0 1 0 0 0 1 all").1, "all");
    }
}
