//! The values that a parameter takes.

/// Most values of one parameter.
const MOST: usize = 100_000;

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// These, in this order.
    These(Vec<String>),
    /// Numbers between two, both included; whole ones where both are.
    Between {
        /// The least.
        from: f64,
        /// The largest.
        to: f64,
        /// True when only whole numbers are meant.
        whole: bool,
    },
}

impl Values {
    /// Reads `4,5,6`, the steps `0:300:100` or the range `1..64`, which only random samples can draw from.
    ///
    /// # Errors
    ///
    /// A sentence about what is wrong.
    pub fn parse(text: &str) -> Result<Values, String> {
        if let Some((from, to)) = text.split_once("..") {
            let numbers = (from.trim().parse(), to.trim().parse());
            return match numbers {
                (Ok(from), Ok(to)) if from < to && f64::is_finite(to - from) => {
                    Ok(Values::Between {
                        from,
                        to,
                        whole: !text.replace("..", "").contains(['.', 'e', 'E']),
                    })
                }
                _ => Err(format!(
                    "`{text}` is no range: write FROM..TO, the smaller number first"
                )),
            };
        }
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        if let [from, to, step] = parts[..]
            && let (Ok(from), Ok(to), Ok(step)) = (from.parse(), to.parse(), step.parse())
        {
            return steps(from, to, step).ok_or_else(|| {
                format!("`{text}` has no values, or more than {MOST}: write FROM:TO:STEP")
            });
        }
        let values: Vec<String> = text.split(',').map(|v| v.trim().to_owned()).collect();
        match values.iter().any(String::is_empty) {
            true => Err(format!(
                "`{text}` has an empty value: write 4,5,6 or 0:300:100"
            )),
            false => Ok(Values::These(values)),
        }
    }

    /// How many there are; `None` of a range.
    pub fn count(&self) -> Option<usize> {
        match self {
            Values::These(values) => Some(values.len()),
            Values::Between { .. } => None,
        }
    }

    /// The value at a part of the way, from 0 to below 1.
    pub fn at(&self, part: f64) -> String {
        match *self {
            Values::These(ref values) => {
                let i = (part * values.len() as f64) as usize;
                values[i.min(values.len() - 1)].clone()
            }
            Values::Between { from, to, whole } if whole => {
                ((from + part * (to - from + 1.0)).floor().min(to)).to_string()
            }
            // Six digits are enough for any attribute, and keep tables readable.
            Values::Between { from, to, .. } => rounded(from + part * (to - from)),
        }
    }
}

/// A number with at most six digits behind the point.
pub(super) fn rounded(number: f64) -> String {
    let text = format!("{number:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}

fn steps(from: f64, to: f64, step: f64) -> Option<Values> {
    let count = ((to - from) / step + 1e-9).floor();
    if !(0.0..MOST as f64).contains(&count) {
        return None;
    }
    let value = |i: usize| rounded(from + i as f64 * step);
    Some(Values::These((0..=count as usize).map(value).collect()))
}

/// Orders values: numbers with their sizes, others by their letters.
pub fn order(a: &str, b: &str) -> std::cmp::Ordering {
    match (number(a), number(b)) {
        (Some(x), Some(y)) => x.total_cmp(&y),
        _ => a.cmp(b),
    }
}

/// The number that a value is, sizes as `16K` too.
pub fn number(text: &str) -> Option<f64> {
    let (digits, unit) = match text.strip_suffix(['K', 'M']) {
        Some(digits) if text.ends_with('K') => (digits, 1024.0),
        Some(digits) => (digits, 1024.0 * 1024.0),
        None => (text, 1.0),
    };
    digits.parse().ok().map(|number: f64| number * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_steps_and_ranges_are_read() {
        let these = |text: &str| match Values::parse(text) {
            Ok(Values::These(values)) => values.join(" "),
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(these("4,5, 6"), "4 5 6");
        assert_eq!(these("0:300:100"), "0 100 200 300");
        assert_eq!(these("0.1:0.3:0.1"), "0.1 0.2 0.3");
        assert_eq!(these("16K,32K"), "16K 32K");
        let range = Values::parse("1..64").expect("a range");
        assert_eq!(
            (range.at(0.0), range.at(0.9999)),
            ("1".to_owned(), "64".to_owned())
        );
        let range = Values::parse("0.5..1").expect("a range");
        assert_eq!(range.at(0.5), "0.75");
        for wrong in ["1..", "5..2", "", "4,,5", "0:10:0", "0:10:-1", "0:1e9:1"] {
            assert!(Values::parse(wrong).is_err(), "{wrong}");
        }
    }
}
