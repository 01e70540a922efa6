//! Forms of the kernels: several ways to compute a part of the picture, which differ in rounding and cost
//! and in nothing else.
//!
//! `kernels/forms.h` has a macro for each form, with the values in the order of its table here; the
//! first is the default.

use std::fmt;

/// A choice that the kernels leave open.
#[derive(Debug)]
pub struct Form {
    /// Its name on the command line.
    pub name: &'static str,
    /// The choice, in a few words.
    pub what: &'static str,
    /// The macro that tells the kernels its value.
    pub define: &'static str,
    /// The names of its values and what each means, in the order of their numbers from 0.
    pub values: &'static [(&'static str, &'static str)],
}

/// All of them.
pub const TABLE: &[Form] = &[
    Form {
        name: "power",
        what: "how a cosine is raised to the exponent of a highlight",
        define: "SRP_FORM_power",
        values: &[
            ("exp2-log2", "by the special functions exp2 and log2"),
            (
                "squaring",
                "by repeated squaring, for the nearest whole exponent up to 4095",
            ),
            (
                "table",
                "by tables of exp2 and log2 in the SRAM, 64 straight pieces each",
            ),
        ],
    },
    Form {
        name: "origin",
        what: "where on a surface rays begin",
        define: "SRP_FORM_origin",
        values: &[
            ("weights", "at the weighted sum of the vertices"),
            ("distance", "so far along the ray as the hit is"),
        ],
    },
    Form {
        name: "offset",
        what: "how rays are kept from the surface where they begin",
        define: "SRP_FORM_offset",
        values: &[
            (
                "vertices",
                "off it by a part of the largest coordinate of its vertices",
            ),
            (
                "integer",
                "off it by 256 units of the last place of each coordinate",
            ),
            (
                "fixed",
                "by hits counting from 2^-13 of the scene, or of a shadow ray, on",
            ),
            ("none", "not at all"),
        ],
    },
    Form {
        name: "colour",
        what: "what colours are rounded to that are kept for a pixel, a ray or a surface",
        define: "SRP_FORM_colour",
        values: &[
            ("f32", "binary32"),
            ("f16", "binary16"),
            ("bf16", "bfloat16, the upper half of binary32"),
        ],
    },
    Form {
        name: "level",
        what: "how pictures are filtered between their levels",
        define: "SRP_FORM_level",
        values: &[
            ("nearest", "the nearest level alone"),
            (
                "trilinear",
                "between the two nearest levels, by two samples",
            ),
        ],
    },
];

/// A value for each form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Forms([u8; TABLE.len()]);

/// A mistake in the choice of a form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FormError {
    /// It is not written `NAME=VALUE`.
    NotAChoice(String),
    /// No form has this name.
    UnknownForm(String),
    /// The form has no such value.
    UnknownValue {
        /// The form.
        form: &'static str,
        /// The value that was asked for.
        value: String,
        /// The values that exist.
        values: Vec<&'static str>,
    },
}

impl fmt::Display for FormError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FormError::NotAChoice(text) => {
                write!(f, "`{text}` is not the choice of a form: write NAME=VALUE")
            }
            FormError::UnknownForm(name) => {
                let names: Vec<&str> = TABLE.iter().map(|form| form.name).collect();
                write!(
                    f,
                    "there is no form `{name}`; there are {}",
                    names.join(", ")
                )
            }
            FormError::UnknownValue {
                form,
                value,
                values,
            } => write!(
                f,
                "the form `{form}` has no value `{value}`; it has {}",
                values.join(", ")
            ),
        }
    }
}

impl std::error::Error for FormError {}

impl Forms {
    /// These with the choice that a text `NAME=VALUE` makes.
    pub fn with(self, choice: &str) -> Result<Forms, FormError> {
        let (name, value) = choice
            .split_once('=')
            .ok_or_else(|| FormError::NotAChoice(choice.to_owned()))?;
        let (name, value) = (name.trim(), value.trim());
        let at = TABLE.iter().position(|form| form.name == name);
        let at = at.ok_or_else(|| FormError::UnknownForm(name.to_owned()))?;
        let form = &TABLE[at];
        let number = form.values.iter().position(|(v, _)| *v == value);
        let number = number.ok_or_else(|| FormError::UnknownValue {
            form: form.name,
            value: value.to_owned(),
            values: form.values.iter().map(|(v, _)| *v).collect(),
        })?;
        let mut forms = self;
        forms.0[at] = u8::try_from(number).expect("a form has a handful of values");
        Ok(forms)
    }

    /// The forms with their values, in the order of the table.
    pub fn iter(self) -> impl Iterator<Item = (&'static Form, &'static str)> {
        let values = self.0.into_iter().map(usize::from);
        let both = TABLE.iter().zip(values);
        both.map(|(form, value)| (form, form.values[value].0))
    }

    /// The macros that tell the kernels of it: names and values.
    pub fn defines(self) -> impl Iterator<Item = (String, String)> {
        let both = TABLE.iter().zip(self.0);
        both.map(|(form, value)| (form.define.to_owned(), value.to_string()))
    }
}

impl fmt::Display for Forms {
    /// The choices that are not the usual ones, as on the command line, with commas between them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let usual = Forms::default();
        let chosen = self.iter().zip(usual.iter());
        let chosen = chosen.filter(|((_, value), (_, usual))| value != usual);
        let text: Vec<String> = chosen
            .map(|((form, value), _)| format!("{}={value}", form.name))
            .collect();
        f.write_str(&text.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_can_be_chosen_and_reads_back() {
        for form in TABLE {
            for (number, (value, _)) in form.values.iter().enumerate() {
                let choice = format!("{}={value}", form.name);
                let forms = Forms::default().with(&choice).expect("it is in the table");
                let told = forms.defines().find(|(name, _)| name == form.define);
                assert_eq!(told, Some((form.define.to_owned(), number.to_string())));
                let shown = if number == 0 { String::new() } else { choice };
                assert_eq!(forms.to_string(), shown);
            }
        }
    }

    #[test]
    fn the_header_has_the_values_in_the_order_of_the_table() {
        let header = crate::header("forms.h").expect("it comes along").text;
        for form in TABLE {
            let usual = format!("#define {} 0\n", form.define);
            assert!(header.contains(&usual), "{usual}");
            for (number, (value, _)) in form.values.iter().enumerate() {
                let name = form.define.trim_start_matches("SRP_FORM_");
                let name = format!("{name}_{value}").replace(['-', '+'], "_");
                let line = format!("#define SRP_{} {number} ", name.to_uppercase());
                assert!(header.contains(&line), "{line}");
            }
        }
    }

    #[test]
    fn choices_that_there_are_not() {
        let error = |text: &str| {
            let wrong = Forms::default().with(text).expect_err("it is wrong");
            wrong.to_string()
        };
        assert!(error("power").contains("NAME=VALUE"));
        assert!(error("taste=red").contains("there is no form `taste`"));
        assert!(error("power=cube").contains("exp2-log2, squaring, table"));
    }
}
