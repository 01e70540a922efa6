//! Random programs as trees that can be made smaller: statements with statements in them, and
//! expressions whose parts can be replaced by constants.

/// A piece of an expression's or statement's text.
#[derive(Clone, Debug)]
pub(crate) enum Piece {
    Text(String),
    Expr(Expr),
}

/// An expression.
#[derive(Clone, Debug)]
pub(crate) struct Expr {
    pub(crate) pieces: Vec<Piece>,
    /// The simplest text that can replace the node.
    pub(crate) simplest: &'static str,
}

/// A statement.
#[derive(Clone, Debug)]
pub(crate) enum Stmt {
    /// Text with expressions in it.
    Plain(Vec<Piece>),
    /// Statements between an opening and a closing text.
    Block {
        open: Vec<Piece>,
        body: Vec<Stmt>,
        close: String,
    },
}

/// A function: its head and the text before and after its statements.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub(crate) head: String,
    pub(crate) first: String,
    pub(crate) body: Vec<Stmt>,
    pub(crate) last: String,
}

/// A program.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) globals: String,
    pub(crate) functions: Vec<Function>,
    pub(crate) last: String,
}

fn write_pieces(pieces: &[Piece], out: &mut String) {
    for piece in pieces {
        match piece {
            Piece::Text(text) => out.push_str(text),
            Piece::Expr(expr) => write_pieces(&expr.pieces, out),
        }
    }
}

fn write_stmts(stmts: &[Stmt], indent: usize, out: &mut String) {
    for stmt in stmts {
        out.push_str(&"    ".repeat(indent));
        match stmt {
            Stmt::Plain(pieces) => write_pieces(pieces, out),
            Stmt::Block { open, body, close } => {
                write_pieces(open, out);
                out.push('\n');
                write_stmts(body, indent + 1, out);
                out.push_str(&"    ".repeat(indent));
                out.push_str(close);
            }
        }
        out.push('\n');
    }
}

impl Tree {
    /// The program as C.
    pub(crate) fn text(&self) -> String {
        let mut out = self.globals.clone();
        for function in &self.functions {
            out.push_str(&function.head);
            out.push_str("\n{\n");
            out.push_str(&function.first);
            write_stmts(&function.body, 1, &mut out);
            out.push_str(&function.last);
            out.push_str("}\n");
        }
        out.push_str(&self.last);
        out
    }

    /// The smallest program found that still fails: statements are left out, taken out of what
    /// is around them, and expressions replaced, as long as `fails` says so.
    pub(crate) fn shrunk(mut self, fails: &mut dyn FnMut(&Tree) -> bool) -> Tree {
        loop {
            let before = self.text().len();
            let mut at = 0;
            while let Some(smaller) = self.changed(at) {
                if smaller.text().len() < self.text().len() && fails(&smaller) {
                    self = smaller;
                } else {
                    at += 1;
                }
            }
            if self.text().len() == before {
                return self;
            }
        }
    }

    /// The program with its change number `at` made; `None` where there are not so many.
    fn changed(&self, at: usize) -> Option<Tree> {
        let mut tree = self.clone();
        let mut left = at;
        for function in &mut tree.functions {
            if change_stmts(&mut function.body, &mut left) {
                return Some(tree);
            }
        }
        None
    }
}

/// Makes change number `left` in a list of statements, or takes those it has off.
fn change_stmts(stmts: &mut Vec<Stmt>, left: &mut usize) -> bool {
    let mut i = 0;
    while i < stmts.len() {
        if *left == 0 {
            stmts.remove(i);
            return true;
        }
        *left -= 1;
        match &mut stmts[i] {
            Stmt::Plain(pieces) => {
                if change_pieces(pieces, left) {
                    return true;
                }
            }
            Stmt::Block { open, body, .. } => {
                if *left == 0 {
                    let inner = std::mem::take(body);
                    stmts.splice(i..=i, inner);
                    return true;
                }
                *left -= 1;
                if change_pieces(open, left) || change_stmts(body, left) {
                    return true;
                }
            }
        }
        i += 1;
    }
    false
}

fn change_pieces(pieces: &mut [Piece], left: &mut usize) -> bool {
    for piece in pieces {
        let Piece::Expr(expr) = piece else {
            continue;
        };
        if *left == 0 {
            expr.pieces = vec![Piece::Text(expr.simplest.to_owned())];
            return true;
        }
        *left -= 1;
        if change_pieces(&mut expr.pieces, left) {
            return true;
        }
    }
    false
}
