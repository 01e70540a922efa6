//! Operators as they are written.

/// Prefix operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its operator, see `text`
pub enum Prefix {
    Increment,
    Decrement,
    AddressOf,
    Deref,
    Plus,
    Minus,
    BitNot,
    Not,
}

/// Infix operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its operator, see `text`
pub enum Infix {
    Mul,
    Div,
    Rem,
    Add,
    Sub,
    Shl,
    Shr,
    Lt,
    Gt,
    Le,
    Ge,
    Eq,
    Ne,
    And,
    Xor,
    Or,
    LogicalAnd,
    LogicalOr,
    Comma,
}

impl Prefix {
    /// How it is written.
    pub fn text(self) -> &'static str {
        match self {
            Prefix::Increment => "++",
            Prefix::Decrement => "--",
            Prefix::AddressOf => "&",
            Prefix::Deref => "*",
            Prefix::Plus => "+",
            Prefix::Minus => "-",
            Prefix::BitNot => "~",
            Prefix::Not => "!",
        }
    }
}

impl Infix {
    /// How it is written.
    pub fn text(self) -> &'static str {
        match self {
            Infix::Mul => "*",
            Infix::Div => "/",
            Infix::Rem => "%",
            Infix::Add => "+",
            Infix::Sub => "-",
            Infix::Shl => "<<",
            Infix::Shr => ">>",
            Infix::Lt => "<",
            Infix::Gt => ">",
            Infix::Le => "<=",
            Infix::Ge => ">=",
            Infix::Eq => "==",
            Infix::Ne => "!=",
            Infix::And => "&",
            Infix::Xor => "^",
            Infix::Or => "|",
            Infix::LogicalAnd => "&&",
            Infix::LogicalOr => "||",
            Infix::Comma => ",",
        }
    }

    /// How tightly it binds; operators of one level group from the left.
    pub fn level(self) -> u32 {
        match self {
            Infix::Comma => 0,
            Infix::LogicalOr => 1,
            Infix::LogicalAnd => 2,
            Infix::Or => 3,
            Infix::Xor => 4,
            Infix::And => 5,
            Infix::Eq | Infix::Ne => 6,
            Infix::Lt | Infix::Gt | Infix::Le | Infix::Ge => 7,
            Infix::Shl | Infix::Shr => 8,
            Infix::Add | Infix::Sub => 9,
            Infix::Mul | Infix::Div | Infix::Rem => 10,
        }
    }
}
