//! Which identifiers name types: the one thing in C that a grammar cannot know.
//!
//! A reader of declarations runs over the tokens before the parser does. It follows scopes, finds
//! in each declaration the names declared, and turns every identifier that names a type where it
//! stands into [`Tok::TypeName`]. It also bounds how deep brackets nest.

use crate::message::{IMPLICIT_INT, LIMIT, Messages};
use crate::source::{Name, SourceMap};
use crate::token::{Fixed, Tok, Token};
use std::collections::HashMap;

/// Depth of brackets.
pub(crate) const MAX_BRACKETS: usize = 256;

/// Types that are known without a declaration; `__srp_double` is binary64 even where `double` is
/// `float`.
pub(crate) const BUILT_IN: [&str; 4] = ["float4", "int4", "__srp_double", "__builtin_va_list"];

/// Turns identifiers that name types into [`Tok::TypeName`]. Where brackets nest too deep the
/// tokens end, and a message says so. A function defined without the type of its result gets an
/// `int`.
pub(crate) fn classify(tokens: &mut Vec<Token>, sources: &SourceMap, messages: &mut Messages) {
    let mut reader = Reader {
        scopes: vec![BUILT_IN.iter().map(|&n| (n.into(), true)).collect()],
        frames: vec![Frame::new(Holds::Block)],
    };
    let mut before = None;
    let mut i = 0;
    while i < tokens.len() {
        if reader.at_item() && reader.defines_function(&tokens[i..]) {
            let span = tokens[i].span;
            let text = "the function's result is not declared: `int`";
            messages.push(sources.warning(IMPLICIT_INT, span, text, ""));
            let tok = Tok::Fixed(Fixed::Int);
            tokens.insert(i, Token { tok, span });
        }
        if reader.frames.len() > MAX_BRACKETS {
            let text = format!("brackets nest deeper than {MAX_BRACKETS} levels");
            messages.push(sources.error(LIMIT, tokens[i].span, text, ""));
            tokens.clear();
            return;
        }
        let after = match tokens.get(i + 1).map(|t| &t.tok) {
            Some(Tok::Fixed(fixed)) => Some(*fixed),
            _ => None,
        };
        let tok = &mut tokens[i].tok;
        match tok {
            Tok::Ident(name) => {
                if reader.ident(name, before, after) {
                    *tok = Tok::TypeName(name.clone());
                }
                before = None;
            }
            Tok::Fixed(fixed) => {
                reader.fixed(*fixed, before);
                before = Some(*fixed);
            }
            Tok::Kernel | Tok::Unroll(_) | Tok::Independent(_) | Tok::Ivdep | Tok::Precision(_) => {
                before = None
            }
            _ => {
                reader.expression();
                before = None;
            }
        }
        i += 1;
    }
}

/// True if a type's name may begin with this keyword.
fn names_type(fixed: Fixed) -> bool {
    use Fixed::*;
    matches!(
        fixed,
        Void | Char
            | Short
            | Int
            | Long
            | Signed
            | Unsigned
            | Float
            | Double
            | Bool
            | Struct
            | Union
            | Enum
            | Typeof
    )
}

/// Where in a declaration or statement the reader is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum At {
    /// Where one may start.
    Start,
    /// In specifiers, before or after the one that names the type.
    Specs { named: bool },
    /// In a declarator, before its name.
    Declarator,
    /// In a declarator, after its name.
    Named,
    /// In an expression.
    Expr,
}

/// The contents of a bracket.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Holds {
    /// Statements, or items at file level.
    Block,
    /// Members of a struct or union.
    Members,
    /// Constants of an `enum`.
    Enumerators,
    /// Parameters of a function.
    Params,
    /// The head of a `for`.
    For,
    /// The condition of another statement.
    Condition,
    /// A declarator in parentheses.
    Declarator,
    /// Expressions.
    Expr,
}

/// One open bracket, or the file.
struct Frame {
    holds: Holds,
    at: At,
    /// True if the current item is a declaration. `typedef`: the declaration names types.
    declaration: bool,
    typedef: bool,
    /// The contents of the next braces: set after `struct`, `union`, `enum`.
    tagged: Option<Holds>,
    /// Parameters of the function that the current declarator declares.
    params: Option<Vec<Name>>,
    /// Scopes of `for` statements whose bodies have not ended.
    loops: usize,
    /// A scope ends with this bracket.
    scoped: bool,
    /// It is `({ … })`, after which the expression goes on.
    value: bool,
}

impl Frame {
    fn new(holds: Holds) -> Frame {
        Frame {
            holds,
            at: match holds {
                Holds::Expr | Holds::Condition => At::Expr,
                Holds::Declarator => At::Declarator,
                _ => At::Start,
            },
            declaration: false,
            typedef: false,
            tagged: None,
            params: None,
            loops: 0,
            scoped: false,
            value: false,
        }
    }

    /// A new item may start.
    fn restart(&mut self, at: At) {
        self.at = at;
        self.declaration = false;
        self.typedef = false;
        self.tagged = None;
        self.params = None;
    }
}

struct Reader {
    /// Scopes, innermost last: each says of its names whether they are types.
    scopes: Vec<HashMap<Name, bool>>,
    /// The file, then each open bracket.
    frames: Vec<Frame>,
}

impl Reader {
    fn frame(&mut self) -> &mut Frame {
        self.frames.last_mut().expect("the file's frame stays")
    }

    /// True if a declaration at file level may start here.
    fn at_item(&self) -> bool {
        self.frames.len() == 1 && self.frames[0].at == At::Start
    }

    /// True if the tokens begin with a name and parameters, followed by the body of a function or
    /// declarations of its parameters.
    fn defines_function(&self, tokens: &[Token]) -> bool {
        let fixed = |i: usize| match tokens.get(i).map(|token| &token.tok) {
            Some(Tok::Fixed(fixed)) => Some(*fixed),
            _ => None,
        };
        match &tokens[0].tok {
            Tok::Ident(name) if fixed(1) == Some(Fixed::LParen) && !self.is_type(name) => {}
            _ => return false,
        }
        let mut depth = 0usize;
        for i in 1..tokens.len() {
            match fixed(i) {
                Some(Fixed::LParen) => depth += 1,
                Some(Fixed::RParen) => depth -= 1,
                Some(Fixed::Semicolon | Fixed::LBrace) => return false,
                _ => {}
            }
            if depth == 0 {
                let after = fixed(i + 1);
                let named = tokens.get(i + 1).is_some_and(|token| match &token.tok {
                    Tok::Ident(name) => self.is_type(name),
                    _ => false,
                });
                return named
                    || after.is_some_and(|f| f == Fixed::LBrace || names_type(f))
                    || matches!(
                        after,
                        Some(Fixed::Register | Fixed::Const | Fixed::Volatile)
                    );
            }
        }
        false
    }

    fn is_type(&self, name: &Name) -> bool {
        let found = self.scopes.iter().rev().find_map(|scope| scope.get(name));
        found.copied().unwrap_or(false)
    }

    /// Takes an identifier; whether it names a type here.
    fn ident(&mut self, name: &Name, before: Option<Fixed>, after: Option<Fixed>) -> bool {
        use Fixed::*;
        if let Some(Struct | Union | Enum | Dot | Arrow | Goto) = before {
            return false;
        }
        let is_type = self.is_type(name);
        let in_params = self.in_params();
        let frame = self.frame();
        frame.tagged = None;
        match frame.at {
            At::Start if frame.holds == Holds::Enumerators => {
                frame.at = At::Expr;
                self.declare(name, false);
                false
            }
            At::Start => {
                let label = frame.holds == Holds::Block && after == Some(Colon);
                let starts = is_type && !label;
                frame.at = if starts {
                    At::Specs { named: true }
                } else {
                    At::Expr
                };
                frame.declaration = starts;
                starts
            }
            At::Specs { named: false } if is_type => {
                frame.at = At::Specs { named: true };
                true
            }
            At::Declarator if is_type && before == Some(LParen) && in_params => {
                self.declarator_is_params(true);
                true
            }
            At::Specs { .. } | At::Declarator => {
                frame.at = At::Named;
                self.declared(name);
                false
            }
            At::Named | At::Expr => is_type,
        }
    }

    /// True if the innermost brackets belong to the declarator of a parameter.
    fn in_params(&self) -> bool {
        let mut outer = self.frames.iter().rev();
        self.frames
            .last()
            .is_some_and(|f| f.holds == Holds::Declarator)
            && outer
                .find(|f| f.holds != Holds::Declarator)
                .is_some_and(|f| f.holds == Holds::Params)
    }

    /// Takes an apparent declarator in parentheses as a list of parameters: `int (int)`.
    fn declarator_is_params(&mut self, named: bool) {
        self.scopes.push(HashMap::new());
        let frame = self.frame();
        frame.holds = Holds::Params;
        frame.at = At::Specs { named };
        frame.declaration = true;
        frame.scoped = true;
    }

    /// A declarator's name.
    fn declared(&mut self, name: &Name) {
        let mut owners = self.frames.iter().rev();
        let owner = owners.find(|f| f.holds != Holds::Declarator);
        if let Some(Frame {
            holds: Holds::Block | Holds::Params | Holds::For,
            typedef,
            ..
        }) = owner
        {
            self.declare(name, *typedef);
        }
    }

    fn declare(&mut self, name: &Name, is_type: bool) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.clone(), is_type);
        }
    }

    /// Something that only an expression has.
    fn expression(&mut self) {
        let frame = self.frame();
        if frame.at == At::Start {
            frame.at = At::Expr;
        }
    }

    fn fixed(&mut self, fixed: Fixed, before: Option<Fixed>) {
        use Fixed::*;
        let frame = self.frame();
        match fixed {
            LParen => self.open_paren(before),
            LBracket => {
                self.expression();
                self.frames.push(Frame::new(Holds::Expr));
            }
            LBrace => self.open_brace(before),
            RParen | RBracket | RBrace => self.close(),
            Semicolon => {
                let at = if frame.holds == Holds::For {
                    At::Expr
                } else {
                    At::Start
                };
                frame.restart(at);
                self.end_loops();
            }
            Comma => match frame.holds {
                Holds::Params | Holds::Enumerators => frame.restart(At::Start),
                _ if frame.declaration => {
                    frame.at = At::Declarator;
                    frame.params = None;
                }
                _ => {}
            },
            Colon => match (frame.holds, frame.at) {
                (Holds::Members, _) => frame.at = At::Expr,
                // After a label; what follows the `:` of `? :` starts no declaration either way.
                (Holds::Block, At::Expr) if !frame.declaration => frame.at = At::Start,
                _ => {}
            },
            Assign => frame.at = At::Expr,
            Star => match frame.at {
                At::Specs { .. } => frame.at = At::Declarator,
                _ => self.expression(),
            },
            _ => self.keyword(fixed, before),
        }
    }

    fn keyword(&mut self, fixed: Fixed, before: Option<Fixed>) {
        use Fixed::*;
        let names_type = match fixed {
            _ if names_type(fixed) => true,
            Typedef | Extern | Static | Auto | Register | Inline | Noreturn | Const | Volatile
            | Restrict | Global | Attribute | Alignas => false,
            Else | Do => return,
            _ => return self.expression(),
        };
        if before == Some(LParen) && names_type && self.in_params() {
            self.declarator_is_params(true);
        }
        let frame = self.frame();
        match &mut frame.at {
            at @ At::Start => {
                *at = At::Specs { named: names_type };
                frame.declaration = true;
            }
            At::Specs { named } => *named |= names_type,
            At::Declarator | At::Named | At::Expr => {}
        }
        frame.typedef |= fixed == Typedef;
        match fixed {
            Struct | Union => frame.tagged = Some(Holds::Members),
            Enum => frame.tagged = Some(Holds::Enumerators),
            _ => {}
        }
    }

    fn open_paren(&mut self, before: Option<Fixed>) {
        use Fixed::*;
        let holds = match before {
            Some(Attribute | Alignas | Typeof | Asm) => Holds::Expr,
            Some(For) => Holds::For,
            Some(If | While | Switch) => Holds::Condition,
            _ => match self.frame().at {
                At::Specs { .. } => {
                    self.frame().at = At::Declarator;
                    Holds::Declarator
                }
                At::Declarator => Holds::Declarator,
                At::Named => Holds::Params,
                At::Start | At::Expr => {
                    self.expression();
                    Holds::Expr
                }
            },
        };
        let mut frame = Frame::new(holds);
        if let Holds::Params | Holds::For = holds {
            self.scopes.push(HashMap::new());
            frame.scoped = true;
        }
        self.frames.push(frame);
    }

    fn open_brace(&mut self, before: Option<Fixed>) {
        let frame = self.frame();
        let holds = match (frame.tagged.take(), frame.at) {
            (Some(holds), _) => holds,
            // Statements in an expression: `({ … })`.
            (None, At::Start | At::Expr)
                if before == Some(Fixed::LParen) && frame.holds == Holds::Expr =>
            {
                Holds::Block
            }
            (None, At::Expr | At::Specs { .. } | At::Declarator) => Holds::Expr,
            (None, At::Start | At::Named) => Holds::Block,
        };
        let names = frame.params.take();
        let mut inner = Frame::new(holds);
        if holds == Holds::Block {
            let names = names.into_iter().flatten();
            self.scopes.push(names.map(|name| (name, false)).collect());
            inner.scoped = true;
        }
        inner.value = before == Some(Fixed::LParen);
        self.frames.push(inner);
    }

    fn close(&mut self) {
        self.end_loops();
        if self.frames.len() == 1 {
            // A bracket too many: the parser will say so.
            return;
        }
        let Some(closed) = self.frames.pop() else {
            return;
        };
        let outer = self.frames.last_mut().expect("the file's frame stays");
        match closed.holds {
            Holds::Block => {
                if closed.value {
                    outer.at = At::Expr;
                } else {
                    outer.restart(At::Start);
                }
                self.scopes.pop();
                self.end_loops();
            }
            Holds::Params => {
                let scope = if closed.scoped {
                    self.scopes.pop()
                } else {
                    None
                };
                let mut names: Vec<Name> = scope.into_iter().flat_map(|s| s.into_keys()).collect();
                names.sort();
                outer.params.get_or_insert(names);
                outer.at = At::Named;
            }
            Holds::For => {
                outer.at = At::Start;
                outer.loops += 1;
            }
            Holds::Condition => outer.at = At::Start,
            Holds::Declarator => {
                outer.at = At::Named;
                if outer.params.is_none() {
                    outer.params = closed.params;
                }
            }
            Holds::Members | Holds::Enumerators | Holds::Expr => {}
        }
    }

    /// A statement has ended, and with it the scopes of the `for` statements that it ends.
    fn end_loops(&mut self) {
        let frame = self.frames.last_mut().expect("the file's frame stays");
        for _ in 0..std::mem::take(&mut frame.loops) {
            self.scopes.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::parse::tests::classified;

    /// Types are marked with `'`.
    #[test]
    fn types_are_found_where_they_are_in_scope() {
        let cases = [
            ("typedef int T; T x;", "typedef int T ; T' x ;"),
            ("typedef int T, *P; P p;", "typedef int T , * P ; P' p ;"),
            (
                "typedef int (*F)(int); F f; int g(F);",
                "typedef int ( * F ) ( int ) ; F' f ; int g ( F' ) ;",
            ),
            (
                "typedef int T; void f(int T) { T * 2; } T y;",
                "typedef int T ; void f ( int T ) { T * 2 ; } T' y ;",
            ),
            (
                "typedef int T; void f(void) { T T = 1; T * T; } T y;",
                "typedef int T ; void f ( void ) { T' T = 1 ; T * T ; } T' y ;",
            ),
            (
                "typedef int T; struct T { T T; } s; int u = sizeof(T) + s.T;",
                "typedef int T ; struct T { T' T ; } s ; int u = sizeof ( T' ) + s . T ;",
            ),
            (
                "typedef int T; void f(void) { for (int T = 0; T < 3;) T++; T z; T: z; }",
                "typedef int T ; void f ( void ) { for ( int T = 0 ; T < 3 ; ) T ++ ; T' z ; T : z ; }",
            ),
            (
                "typedef int T; enum { A = sizeof(T), T2 }; T f(T (*g)(T), T);",
                "typedef int T ; enum { A = sizeof ( T' ) , T2 } ; T' f ( T' ( * g ) ( T' ) , T' ) ;",
            ),
            (
                "typedef int T; void f(void) { if (1) { T a; } else { T b; } (T)1; }",
                "typedef int T ; void f ( void ) { if ( 1 ) { T' a ; } else { T' b ; } ( T' ) 1 ; }",
            ),
            (
                "typedef struct { int x; } S; S v = (S){ .x = 1 }, w; unsigned S;",
                "typedef struct { int x ; } S ; S' v = ( S' ) { . x = 1 } , w ; unsigned S ;",
            ),
            ("float4 f(int4 v);", "float4' f ( int4' v ) ;"),
        ];
        for (text, expected) in cases {
            assert_eq!(classified(text), expected);
        }
    }
}
