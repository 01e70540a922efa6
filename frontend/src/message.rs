//! [`Messages`]: the messages of one run, and their codes.

use srp_archdesc::diagnostic::{Diagnostic, Severity, render};

/// Errors after which a run says no more.
pub const MAX_ERRORS: usize = 100;

/// The stable code of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Code(pub &'static str);

macro_rules! codes {
    ($($(#[doc = $doc:literal])* $name:ident = $code:literal;)*) => {
        $($(#[doc = $doc])* pub const $name: Code = Code($code);)*

        impl Code {
            /// All codes, each with what it stands for.
            pub const ALL: &'static [(Code, &'static str)] =
                &[$((Code($code), concat!($($doc),*)),)*];
        }
    };
}

codes! {
    /// A character or literal that is no token of C.
    LEXICAL = "C0101";
    /// A malformed preprocessor directive.
    DIRECTIVE = "C0102";
    /// A file to include was not found, or includes too deep.
    INCLUDE = "C0103";
    /// A macro was defined or called wrongly.
    MACRO = "C0104";
    /// `#error`.
    USER_ERROR = "C0105";
    /// A condition of `#if` that has no value.
    CONDITION = "C0106";
    /// A limit on size or depth was passed.
    LIMIT = "C0107";
    /// A constant that does not fit its type.
    CONSTANT_RANGE = "C0108";
    /// The text is not C.
    SYNTAX = "C0201";
    /// C that this compiler does not take.
    UNSUPPORTED = "C0301";
    /// A combination of specifiers that names no type.
    SPECIFIERS = "C0401";
    /// A name that is declared nowhere.
    UNDECLARED = "C0402";
    /// Two declarations of one name that contradict each other.
    REDECLARED = "C0403";
    /// A type whose size is not known where it is needed, or that cannot exist.
    BAD_TYPE = "C0404";
    /// A declaration that cannot stand where it is.
    DECLARATION = "C0405";
    /// A name that is used but defined in no source.
    UNDEFINED = "C0406";
    /// Operands of types that the operator does not take.
    OPERANDS = "C0501";
    /// A value that does not convert to the type wanted.
    CONVERSION = "C0502";
    /// Something assigned to that cannot be.
    NOT_ASSIGNABLE = "C0503";
    /// A call that does not fit the function.
    CALL = "C0504";
    /// A member that the type does not have.
    MEMBER = "C0505";
    /// An expression that must be constant and is not.
    NOT_CONSTANT = "C0506";
    /// An initialiser that does not fit the object.
    INITIALISER = "C0507";
    /// A statement where it has no meaning.
    STATEMENT = "C0601";
    /// A pragma that cannot be followed.
    PRAGMA = "C0602";
    /// A loop under `#pragma srp kernel` that is not on the array; told after it is scheduled.
    KERNEL = "C0604";
    /// `_Static_assert` failed.
    STATIC_ASSERT = "C0603";
    /// A function that returns a value may end without one.
    MISSING_RETURN = "C0901";
    /// A conversion that drops `const` or `volatile`.
    DISCARDED_QUALIFIER = "C0902";
    /// An attribute or pragma that was ignored.
    IGNORED = "C0903";
    /// A constant index outside the array.
    INDEX_RANGE = "C0904";
    /// An integer division by a constant zero.
    DIVISION_BY_ZERO = "C0905";
    /// `#warning`.
    USER_WARNING = "C0906";
    /// A macro defined anew with another meaning.
    MACRO_REDEFINED = "C0907";
    /// A shift by a constant count outside the width.
    SHIFT_RANGE = "C0908";
    /// A pointer to an integer type becomes one to another of the same size.
    POINTER_SIGN = "C0909";
    /// Pointers to different types are compared.
    POINTER_TYPES = "C0910";
    /// A function is called that is not declared.
    IMPLICIT_FUNCTION = "C0911";
    /// A function is defined without the type of its result or of a parameter.
    IMPLICIT_INT = "C0912";
    /// A constant that does not fit the type it is converted to.
    OVERFLOW = "C0913";
    /// A function of the library is declared otherwise than it is.
    LIBRARY_TYPE = "C0916";
    /// A loop that cannot be unrolled.
    UNROLL = "C0914";
    /// A `return` with a value where there is none, or without one where there is.
    RETURN_VALUE = "C0917";
    /// A use of `double` where `float` was asked for.
    DOUBLE_AS_FLOAT = "C0915";
    /// `volatile`, which keeps no access: nothing but the program reads or writes its SRAM while it computes.
    VOLATILE = "C0918";
    /// An operation of a fast unit that the machine does not have: the ordinary unit computes it.
    FAST_UNIT = "C0919";
    /// An included file outside the folders of the sources and those of `-I`.
    OUTSIDE = "C0920";
    /// A format that does not fit the arguments of its call.
    FORMAT = "C0921";
    /// A constant that is a `double` beside a `float`, by which the operation is one of `double`: some hundred operations of
    /// software. The suffix `f` makes the constant a `float`.
    DOUBLE_CONSTANT = "C0922";
    /// An assignment is the condition of an `if` or loop. Parentheses around it say that it is meant.
    ASSIGNED_CONDITION = "C0923";
    /// The body of an `if` is a semicolon.
    EMPTY_BODY = "C0924";
    /// A comparison of an unsigned number with zero that is always true or always false.
    UNSIGNED_RANGE = "C0925";
    /// A statement that computes a value and has no effect.
    NO_EFFECT = "C0926";
    /// A variable is read before it is given a value.
    UNINITIALISED = "C0927";
}

/// The name of a warning on the command line.
const NAMES: &[(Code, &str)] = &[
    (MISSING_RETURN, "return-type"),
    (DISCARDED_QUALIFIER, "discarded-qualifiers"),
    (IGNORED, "attributes"),
    (INDEX_RANGE, "array-bounds"),
    (DIVISION_BY_ZERO, "div-by-zero"),
    (USER_WARNING, "cpp"),
    (MACRO_REDEFINED, "macro-redefined"),
    (SHIFT_RANGE, "shift-count"),
    (POINTER_SIGN, "pointer-sign"),
    (POINTER_TYPES, "compare-pointer-types"),
    (IMPLICIT_FUNCTION, "implicit-function-declaration"),
    (IMPLICIT_INT, "implicit-int"),
    (OVERFLOW, "overflow"),
    (RETURN_VALUE, "return-mismatch"),
    (UNROLL, "unroll"),
    (KERNEL, "kernel"),
    (DOUBLE_AS_FLOAT, "double-as-float"),
    (LIBRARY_TYPE, "builtin-declaration-mismatch"),
    (VOLATILE, "volatile"),
    (FAST_UNIT, "fast-unit"),
    (OUTSIDE, "outside-include"),
    (FORMAT, "format"),
    (DOUBLE_CONSTANT, "double-constant"),
    (ASSIGNED_CONDITION, "parentheses"),
    (EMPTY_BODY, "empty-body"),
    (UNSIGNED_RANGE, "type-limits"),
    (NO_EFFECT, "unused-value"),
    (UNINITIALISED, "uninitialized"),
];

/// The name of the warning with a code, for `-W`.
pub fn warning_name(code: &str) -> Option<&'static str> {
    let found = NAMES.iter().find(|(known, _)| known.0 == code);
    found.map(|(_, name)| *name)
}

/// The names of all warnings, in the order of their codes.
pub fn warning_names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().map(|(_, name)| *name)
}

/// Returns the explanation of a code; `None` if the code is unknown.
pub fn explain(code: &str) -> Option<String> {
    let (code, text) = Code::ALL.iter().find(|(known, _)| known.0 == code)?;
    let name = warning_name(code.0).map(|name| {
        format!("\n\nThe warning `{name}`: `-W no-{name}` turns it off, `-W error={name}` makes it an error.")
    });
    Some(format!("{}:{text}{}", code.0, name.unwrap_or_default()))
}

/// Messages as a terminal shows them, an empty line after each. `text` gives the text of a file by
/// the name that messages know it by; where it has none, the message comes without the lines.
pub fn render_all(
    messages: &[Diagnostic],
    text: &dyn Fn(&str) -> Option<String>,
    colour: bool,
) -> String {
    let mut out = String::new();
    for message in messages {
        let source = text(&message.file).unwrap_or_default();
        out.push_str(&render(message, &source, colour));
        out.push_str("\n\n");
    }
    out
}

/// The messages of a run, in the order of their discovery.
#[derive(Debug, Default)]
pub struct Messages {
    list: Vec<Diagnostic>,
    errors: usize,
}

impl Messages {
    /// No messages yet.
    pub fn new() -> Messages {
        Messages::default()
    }

    /// Adds a message, unless [`MAX_ERRORS`] errors have been added already or the same was said
    /// of the same place.
    pub fn push(&mut self, message: Diagnostic) {
        if self.errors >= MAX_ERRORS {
            return;
        }
        let recent = self.list.iter().rev().take(64);
        if recent.into_iter().any(|m| *m == message) {
            return;
        }
        if message.severity == Severity::Error {
            self.errors += 1;
        }
        self.list.push(message);
    }

    /// Adds an error in place of the warnings of a code about the same place.
    pub(crate) fn replace(&mut self, code: Code, error: Diagnostic) {
        self.list.retain(|m| {
            m.code != code.0
                || m.severity == Severity::Error
                || m.file != error.file
                || m.primary != error.primary
        });
        self.push(error);
    }

    /// How many errors there are.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// All messages.
    pub fn into_list(self) -> Vec<Diagnostic> {
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_have_names() {
        for (code, _) in Code::ALL.iter().filter(|(code, _)| code.0 >= "C09") {
            assert!(warning_name(code.0).is_some(), "{code:?}");
            assert!(explain(code.0).is_some_and(|text| text.contains("-W")));
        }
    }

    #[test]
    fn codes_are_unique() {
        let mut codes: Vec<_> = Code::ALL.iter().map(|(code, _)| code).collect();
        codes.sort();
        codes.dedup();
        assert_eq!(codes.len(), Code::ALL.len());
    }
}
