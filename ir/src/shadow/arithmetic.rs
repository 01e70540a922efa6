//! Results of float operations in binary64, and their partial derivatives.

use super::{Decision, Flip, Mark, NonFinite, Shadows};

/// A float operation, of one lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Add,
    Sub,
    Mul,
    Fma,
    Div,
    Rcp,
    Rsqrt,
    Sqrt,
    Exp2,
    Log2,
    Sin,
    Cos,
    Neg,
    Abs,
    Min,
    Max,
}

impl Function {
    fn operands(self) -> usize {
        use Function::*;
        match self {
            Fma => 3,
            Add | Sub | Mul | Div | Min | Max => 2,
            Rcp | Rsqrt | Sqrt | Exp2 | Log2 | Sin | Cos | Neg | Abs => 1,
        }
    }

    fn exact(self, [a, b, c]: [f64; 3]) -> f64 {
        match self {
            Function::Add => a + b,
            Function::Sub => a - b,
            Function::Mul => a * b,
            Function::Fma => libm::fma(a, b, c),
            Function::Div => a / b,
            Function::Rcp => 1.0 / a,
            Function::Rsqrt => 1.0 / a.sqrt(),
            Function::Sqrt => a.sqrt(),
            Function::Exp2 => libm::exp2(a),
            Function::Log2 => libm::log2(a),
            Function::Sin => libm::sin(a),
            Function::Cos => libm::cos(a),
            Function::Neg => -a,
            Function::Abs => a.abs(),
            Function::Min if b < a || a.is_nan() => b,
            Function::Max if b > a || a.is_nan() => b,
            Function::Min | Function::Max => a,
        }
    }

    /// The partial derivatives where the operands are these.
    fn slopes(self, [a, b, _]: [f64; 3]) -> [f64; 3] {
        use std::f64::consts::LN_2;
        match self {
            Function::Add => [1.0, 1.0, 0.0],
            Function::Sub => [1.0, -1.0, 0.0],
            Function::Mul => [b, a, 0.0],
            Function::Fma => [b, a, 1.0],
            Function::Div => [1.0 / b, -a / (b * b), 0.0],
            Function::Rcp => [-1.0 / (a * a), 0.0, 0.0],
            Function::Rsqrt => [-0.5 / (a * a.sqrt()), 0.0, 0.0],
            Function::Sqrt => [0.5 / a.sqrt(), 0.0, 0.0],
            Function::Exp2 => [libm::exp2(a) * LN_2, 0.0, 0.0],
            Function::Log2 => [1.0 / (a * LN_2), 0.0, 0.0],
            Function::Sin => [libm::cos(a), 0.0, 0.0],
            Function::Cos => [-libm::sin(a), 0.0, 0.0],
            Function::Neg => [-1.0, 0.0, 0.0],
            Function::Abs => [if a < 0.0 { -1.0 } else { 1.0 }, 0.0, 0.0],
            Function::Min if b < a || a.is_nan() => [0.0, 1.0, 0.0],
            Function::Max if b > a || a.is_nan() => [0.0, 1.0, 0.0],
            Function::Min | Function::Max => [1.0, 0.0, 0.0],
        }
    }
}

/// A float with its mark.
pub(super) type Marked = (f32, Mark);

impl Shadows<'_> {
    /// Returns a float's value in binary64.
    #[inline]
    pub(super) fn shadow(&self, (value, mark): Marked) -> f64 {
        self.tape.shadow(mark.node_of(), value)
    }

    /// The mark of one lane of a result.
    #[inline]
    pub(super) fn lane(
        &mut self,
        function: Function,
        source: u32,
        args: [Marked; 3],
        result: f32,
    ) -> Mark {
        let used = &args[..function.operands()];
        if !result.is_finite() {
            if used.iter().all(|(value, _)| value.is_finite()) {
                self.non_finite(source, used, result);
            }
            return Mark::PLAIN;
        }
        let values = args.map(|(value, _)| f64::from(value));
        if used.iter().all(|(_, mark)| mark.node_of() == 0) {
            let exact = function.exact(values);
            let error = f64::from(result) - exact;
            return match error == 0.0 || !exact.is_finite() {
                true => Mark::PLAIN,
                false => Mark::node(self.tape.push(result, exact, source, [(0, 0.0); 3])),
            };
        }
        let exact = function.exact(args.map(|arg| self.shadow(arg)));
        if !exact.is_finite() {
            let nodes = [args[0].1.node_of(), args[1].1.node_of()];
            self.flips.push(Flip {
                decision: Decision::Number,
                source,
                tag: self.tape.tag(nodes),
                values: [args[0].0, args[1].0],
                shadows: [self.shadow(args[0]), self.shadow(args[1])],
                nodes,
            });
            return Mark::PLAIN;
        }
        let slopes = function.slopes(values);
        let parents = std::array::from_fn(|i| match i < used.len() {
            true => (args[i].1.node_of(), slopes[i]),
            false => (0, 0.0),
        });
        Mark::node(self.tape.push(result, exact, source, parents))
    }

    fn non_finite(&mut self, source: u32, args: &[Marked], value: f32) {
        let tag = self.tape.tag(args.iter().map(|(_, mark)| mark.node_of()));
        self.non_finite.push(NonFinite { source, tag, value });
    }

    /// The mark of a dot product of `n` lanes, each step rounded.
    pub(super) fn dot(
        &mut self,
        source: u32,
        n: usize,
        a: [Marked; 4],
        b: [Marked; 4],
        result: f32,
    ) -> Mark {
        const NONE: Marked = (0.0, Mark::PLAIN);
        let mut sum = NONE;
        for i in 0..n {
            let product = a[i].0 * b[i].0;
            let mark = self.lane(Function::Mul, source, [a[i], b[i], NONE], product);
            let product = (product, mark);
            if i == 0 {
                sum = product;
                continue;
            }
            let value = if i + 1 == n {
                result
            } else {
                sum.0 + product.0
            };
            let mark = self.lane(Function::Add, source, [sum, product, NONE], value);
            sum = (value, mark);
        }
        sum.1
    }
}
