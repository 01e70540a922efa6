//! [`Tok`]: the tokens that the grammar knows, and how preprocessing tokens become them.

use crate::lex::{PpKind, PpToken};
use crate::literal::{self, Literal};
use crate::message::{LEXICAL, LIMIT, Messages, UNSUPPORTED};
use crate::source::{Name, SourceMap};
use srp_archdesc::diagnostic::Span;
use std::rc::Rc;

pub use crate::literal::{FloatConst, IntConst};

macro_rules! fixed {
    ($($name:ident $text:literal $(| $alias:literal)*;)*) => {
        /// Tokens that are always spelled the same: keywords, operators and punctuators.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Fixed { $(#[doc = concat!("`", $text, "`")] $name,)* }

        impl Fixed {
            /// All of them.
            pub(crate) const ALL: &'static [Fixed] = &[$(Fixed::$name,)*];

            /// The spelling.
            pub fn text(self) -> &'static str {
                match self { $(Fixed::$name => $text,)* }
            }

            /// The token of this spelling, or of another that means the same.
            pub fn parse(text: &str) -> Option<Fixed> {
                Some(match text { $($text $(| $alias)* => Fixed::$name,)* _ => return None })
            }
        }
    };
}

fixed! {
    Auto "auto"; Break "break"; Case "case"; Char "char"; Const "const" | "__const" | "__const__";
    Continue "continue"; Default "default"; Do "do"; Double "double"; Else "else"; Enum "enum";
    Extern "extern"; Float "float"; For "for"; Goto "goto"; If "if";
    Inline "inline" | "__inline" | "__inline__"; Int "int"; Long "long"; Register "register";
    Restrict "restrict" | "__restrict" | "__restrict__"; Return "return"; Short "short";
    Signed "signed" | "__signed" | "__signed__"; Sizeof "sizeof"; Static "static";
    Struct "struct"; Switch "switch"; Typedef "typedef"; Union "union"; Unsigned "unsigned";
    Void "void"; Volatile "volatile" | "__volatile" | "__volatile__"; While "while"; Bool "_Bool";
    Alignas "_Alignas"; Alignof "_Alignof" | "__alignof__" | "__alignof"; Noreturn "_Noreturn";
    StaticAssert "_Static_assert"; Attribute "__attribute__" | "__attribute";
    Typeof "typeof" | "__typeof__" | "__typeof"; Asm "asm" | "__asm" | "__asm__";
    Generic "_Generic"; VaArg "__builtin_va_arg"; Offsetof "__builtin_offsetof";
    TypesCompatible "__builtin_types_compatible_p";
    Global "__srp_global";
    LBrace "{"; RBrace "}"; LParen "("; RParen ")"; LBracket "["; RBracket "]"; Dot ".";
    Arrow "->"; Increment "++"; Decrement "--"; Amp "&"; Star "*"; Plus "+"; Minus "-"; Tilde "~";
    Not "!"; Slash "/"; Percent "%"; Shl "<<"; Shr ">>"; Lt "<"; Gt ">"; Le "<="; Ge ">=";
    EqEq "=="; Ne "!="; Caret "^"; Pipe "|"; AndAnd "&&"; OrOr "||"; Question "?"; Colon ":";
    Semicolon ";"; Ellipsis "..."; Assign "="; StarAssign "*="; SlashAssign "/=";
    PercentAssign "%="; PlusAssign "+="; MinusAssign "-="; ShlAssign "<<="; ShrAssign ">>=";
    AmpAssign "&="; CaretAssign "^="; PipeAssign "|="; Comma ",";
}

/// Keywords of C and GNU C that are no part of the language here.
const REFUSED: &[&str] = &[
    "_Complex",
    "_Imaginary",
    "_Atomic",
    "_Thread_local",
    "__int128",
    "_Float16",
    "__complex__",
    "__label__",
    "__thread",
];

/// A token of the grammar.
#[derive(Clone, Debug, PartialEq)]
pub enum Tok {
    /// A keyword, operator or punctuator.
    Fixed(Fixed),
    /// An identifier that names no type where it stands.
    Ident(Name),
    /// An identifier that names a type where it stands.
    TypeName(Name),
    /// An integer constant.
    Int(IntConst),
    /// A floating constant.
    Float(FloatConst),
    /// A character constant: its value as an `int`.
    Char(i32),
    /// A string literal without its terminating zero; neighbours are joined already.
    Str(Rc<[u8]>),
    /// A wide string literal without its terminating zero.
    WideStr(Rc<[u32]>),
    /// `#pragma srp kernel`.
    Kernel,
    /// `#pragma srp unroll N`.
    Unroll(u32),
    /// `#pragma srp independent(NAME, …)`.
    Independent(Rc<[Name]>),
    /// `#pragma ivdep`.
    Ivdep,
    /// `#pragma srp precision(FUNCTION, BITS)`.
    Precision((Name, u32)),
    /// Something that has been complained about.
    Bad,
}

/// A token and where it stands.
#[derive(Clone, Debug)]
pub struct Token {
    /// Its kind and value.
    pub tok: Tok,
    /// Where it is.
    pub span: Span,
}

/// Most bytes of all string literals of a source: macros can make much of a few.
const MAX_STRINGS: usize = 64 << 20;

/// The tokens of the grammar that these preprocessing tokens are.
pub(crate) fn tokens(
    input: Vec<PpToken>,
    sources: &SourceMap,
    messages: &mut Messages,
) -> Vec<Token> {
    let mut out: Vec<Token> = Vec::with_capacity(input.len());
    let mut strings: Option<Strings> = None;
    let mut room = MAX_STRINGS;
    for pp in input {
        if &*pp.text == "__extension__" {
            continue;
        }
        if pp.kind == PpKind::Str {
            if pp.text.len() > room {
                let text = format!(
                    "string literals come to more than {} MiB",
                    MAX_STRINGS >> 20
                );
                messages.push(sources.error(LIMIT, pp.span, text, ""));
                return Vec::new();
            }
            room -= pp.text.len();
        }
        let tok = token(&pp, sources, messages);
        if let Tok::Str(_) | Tok::WideStr(_) = tok {
            let strings = strings.get_or_insert_with(|| Strings::at(pp.span));
            strings.add(&tok, pp.span);
            continue;
        }
        out.extend(strings.take().map(Strings::token));
        out.push(Token { tok, span: pp.span });
    }
    out.extend(strings.map(Strings::token));
    out
}

/// Neighbouring strings, which are one.
struct Strings {
    characters: Vec<u32>,
    is_wide: bool,
    span: Span,
}

impl Strings {
    fn at(span: Span) -> Strings {
        Strings {
            characters: Vec::new(),
            is_wide: false,
            span,
        }
    }

    fn add(&mut self, tok: &Tok, span: Span) {
        match tok {
            Tok::Str(bytes) => self.characters.extend(bytes.iter().map(|&b| u32::from(b))),
            Tok::WideStr(characters) => {
                self.characters.extend(characters.iter());
                self.is_wide = true;
            }
            _ => {}
        }
        if span.end >= self.span.start {
            self.span = self.span.to(span);
        }
    }

    fn token(self) -> Token {
        let tok = match self.is_wide {
            true => Tok::WideStr(self.characters.into()),
            false => Tok::Str(self.characters.iter().map(|&c| c as u8).collect()),
        };
        Token {
            tok,
            span: self.span,
        }
    }
}

fn token(pp: &PpToken, sources: &SourceMap, messages: &mut Messages) -> Tok {
    let mut error = |code, text: String| {
        messages.push(sources.error(code, pp.span, text, ""));
        Tok::Bad
    };
    match pp.kind {
        PpKind::Ident if REFUSED.contains(&&*pp.text) => {
            error(UNSUPPORTED, format!("`{}` is not supported", pp.text))
        }
        PpKind::Ident | PpKind::Punct => match Fixed::parse(&pp.text) {
            Some(fixed) => Tok::Fixed(fixed),
            None if pp.kind == PpKind::Ident => Tok::Ident(pp.text.clone()),
            None => error(
                LEXICAL,
                format!("`{}` has a meaning only in directives", pp.text),
            ),
        },
        PpKind::Number => {
            literal::number(&pp.text).map_or_else(|why| error(why.code, why.text), Tok::from)
        }
        PpKind::Char => match literal::character(&pp.text) {
            Ok(value) => Tok::Char(value),
            Err(why) => error(why.code, why.text),
        },
        PpKind::Str => {
            literal::string(&pp.text).map_or_else(|why| error(why.code, why.text), Tok::from)
        }
        PpKind::Unterminated => error(LEXICAL, "quote without its partner on this line".into()),
        PpKind::Stray => {
            let c = pp.text.chars().next().unwrap_or(' ');
            error(LEXICAL, format!("`{}` is no part of C", c.escape_debug()))
        }
        PpKind::Pragma => pragma(&pp.text),
    }
}

/// A pragma for the compiler, as the preprocessor spells it.
fn pragma(text: &str) -> Tok {
    let words: Vec<&str> = text.split(' ').collect();
    let number = |word: &str| word.parse().unwrap_or(1);
    match words.as_slice() {
        ["unroll", count] => Tok::Unroll(number(count)),
        ["independent", names @ ..] => {
            Tok::Independent(names.iter().map(|&name| Name::from(name)).collect())
        }
        ["ivdep"] => Tok::Ivdep,
        ["precision", function, bits] => Tok::Precision((Name::from(*function), number(bits))),
        _ => Tok::Kernel,
    }
}

impl From<Literal> for Tok {
    fn from(literal: Literal) -> Tok {
        match literal {
            Literal::Int(int) => Tok::Int(int),
            Literal::Float(float) => Tok::Float(float),
            Literal::Str(bytes) => Tok::Str(bytes),
            Literal::WideStr(chars) => Tok::WideStr(chars),
        }
    }
}
