//! Derivatives, node by node from the variables up.

use super::graph::{Graph, Id, Node};
use super::op::Op;

/// Extends `graph` by the derivative of `root` by variable `variable`.
pub(super) fn derivative(graph: &mut Graph, root: Id, variable: usize) -> Id {
    let order = graph.order(&[root]);
    let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
    let mut by = vec![zero; graph.len()];
    for id in order {
        by[id] = match graph.node(id) {
            Node::Constant(_) => zero,
            Node::Variable(index) => {
                if index == variable {
                    one
                } else {
                    zero
                }
            }
            Node::Apply(op, arguments) => {
                let slopes = arguments.map(|argument| by[argument]);
                let slopes = &slopes[..op.arity()];
                // Also spares the derivatives of what does not depend on the variable.
                if slopes.iter().all(|&slope| slope == zero) {
                    zero
                } else {
                    Rules { graph }.apply(op, id, arguments, slopes)
                }
            }
        };
    }
    by[root]
}

/// Arithmetic that drops 0 and 1, which exact rules of derivatives are full of.
struct Rules<'a> {
    graph: &'a mut Graph,
}

impl Rules<'_> {
    fn number(&mut self, value: f64) -> Id {
        self.graph.constant(value)
    }

    fn is(&self, id: Id, value: f64) -> bool {
        self.graph.number(id) == Some(value)
    }

    fn raw(&mut self, op: Op, arguments: &[Id]) -> Id {
        self.graph.apply(op, arguments)
    }

    fn negate(&mut self, a: Id) -> Id {
        match self.graph.node(a) {
            Node::Apply(Op::Negate, [inner, ..]) => inner,
            _ => self.raw(Op::Negate, &[a]),
        }
    }

    fn add(&mut self, a: Id, b: Id) -> Id {
        match (self.is(a, 0.0), self.is(b, 0.0)) {
            (true, _) => b,
            (_, true) => a,
            _ => self.raw(Op::Add, &[a, b]),
        }
    }

    fn subtract(&mut self, a: Id, b: Id) -> Id {
        match (self.is(a, 0.0), self.is(b, 0.0)) {
            (_, true) => a,
            (true, _) => self.negate(b),
            _ => self.raw(Op::Subtract, &[a, b]),
        }
    }

    fn multiply(&mut self, a: Id, b: Id) -> Id {
        for (factor, other) in [(a, b), (b, a)] {
            if self.is(factor, 0.0) {
                return factor;
            }
            if self.is(factor, 1.0) {
                return other;
            }
            if self.is(factor, -1.0) {
                return self.negate(other);
            }
        }
        self.raw(Op::Multiply, &[a, b])
    }

    fn divide(&mut self, a: Id, b: Id) -> Id {
        if self.is(a, 0.0) || self.is(b, 1.0) {
            return a;
        }
        self.raw(Op::Divide, &[a, b])
    }

    fn power(&mut self, a: Id, b: Id) -> Id {
        if self.is(b, 0.0) {
            return self.number(1.0);
        }
        if self.is(b, 1.0) {
            return a;
        }
        self.raw(Op::Power, &[a, b])
    }

    fn square(&mut self, a: Id) -> Id {
        let two = self.number(2.0);
        self.power(a, two)
    }

    /// The derivative of node `id = op(arguments)`, whose arguments have the derivatives
    /// `slopes`; they are not all 0.
    fn apply(&mut self, op: Op, id: Id, [a, b, c]: [Id; 3], slopes: &[Id]) -> Id {
        match (op, slopes) {
            (Op::Add, &[da, db]) => self.add(da, db),
            (Op::Subtract, &[da, db]) => self.subtract(da, db),
            (Op::Multiply, &[da, db]) => {
                let (left, right) = (self.multiply(da, b), self.multiply(a, db));
                self.add(left, right)
            }
            // a/b: (a' - (a/b) b') / b
            (Op::Divide, &[da, db]) => {
                let right = self.multiply(id, db);
                let top = self.subtract(da, right);
                self.divide(top, b)
            }
            (Op::Power, &[da, db]) => self.power_rule(id, a, b, da, db),
            (Op::Min | Op::Max, &[da, db]) => {
                let less = if op == Op::Min { Op::Less } else { Op::Greater };
                let first = self.raw(less, &[a, b]);
                self.choose(first, da, db)
            }
            // atan2(a, b): (a' b - a b') / (a^2 + b^2)
            (Op::Atan2, &[da, db]) => {
                let (left, right) = (self.multiply(da, b), self.multiply(a, db));
                let top = self.subtract(left, right);
                let (a, b) = (self.square(a), self.square(b));
                let bottom = self.add(a, b);
                self.divide(top, bottom)
            }
            // hypot(a, b): (a a' + b b') / hypot(a, b)
            (Op::Hypot, &[da, db]) => {
                let (left, right) = (self.multiply(a, da), self.multiply(b, db));
                let top = self.add(left, right);
                self.divide(top, id)
            }
            (Op::Where, &[_, db, dc]) => self.choose(a, db, dc),
            (Op::Hill, &[da, db, dc]) => {
                let (x, k) = (self.power(a, c), self.power(b, c));
                let sum = self.add(k, x);
                let (dx, dk) = (self.power_rule(x, a, c, da, dc), self.power_rule(k, b, c, db, dc));
                // x/(k + x): (x' k - x k') / (k + x)^2
                let (left, right) = (self.multiply(dx, k), self.multiply(x, dk));
                let (top, bottom) = (self.subtract(left, right), self.square(sum));
                self.divide(top, bottom)
            }
            (_, &[da]) => match self.unary(op, id, a) {
                Slope::Factor(factor) => self.multiply(factor, da),
                Slope::Divisor(divisor) => self.divide(da, divisor),
            },
            // Steps: comparisons.
            _ => self.number(0.0),
        }
    }

    /// `id = a^b`: `b a^(b-1) a' + a^b log(a) b'`; the second term needs `a > 0`.
    fn power_rule(&mut self, id: Id, a: Id, b: Id, da: Id, db: Id) -> Id {
        let one = self.number(1.0);
        let less = self.subtract(b, one);
        let lower = self.power(a, less);
        let factor = self.multiply(b, lower);
        let first = self.multiply(factor, da);
        if self.is(db, 0.0) {
            return first;
        }
        let log = self.raw(Op::Log, &[a]);
        let factor = self.multiply(id, log);
        let second = self.multiply(factor, db);
        self.add(first, second)
    }

    fn choose(&mut self, condition: Id, b: Id, c: Id) -> Id {
        if b == c { b } else { self.raw(Op::Where, &[condition, b, c]) }
    }

    /// Derivative of the function of one argument `id = op(a)`.
    fn unary(&mut self, op: Op, id: Id, a: Id) -> Slope {
        let one = self.number(1.0);
        match op {
            Op::Negate => Slope::Factor(self.number(-1.0)),
            Op::Abs => Slope::Factor(self.raw(Op::Sign, &[a])),
            Op::Sqrt => {
                let two = self.number(2.0);
                Slope::Divisor(self.multiply(two, id))
            }
            Op::Exp => Slope::Factor(id),
            Op::Log => Slope::Divisor(a),
            Op::Log10 => {
                let ten = self.number(std::f64::consts::LN_10);
                Slope::Divisor(self.multiply(ten, a))
            }
            Op::Sin => Slope::Factor(self.raw(Op::Cos, &[a])),
            Op::Cos => {
                let sine = self.raw(Op::Sin, &[a]);
                Slope::Factor(self.negate(sine))
            }
            Op::Tan => {
                let square = self.square(id);
                Slope::Factor(self.add(one, square))
            }
            Op::Asin | Op::Acos => {
                let square = self.square(a);
                let rest = self.subtract(one, square);
                let root = self.raw(Op::Sqrt, &[rest]);
                Slope::Divisor(if op == Op::Asin { root } else { self.negate(root) })
            }
            Op::Atan => {
                let square = self.square(a);
                Slope::Divisor(self.add(one, square))
            }
            Op::Sinh => Slope::Factor(self.raw(Op::Cosh, &[a])),
            Op::Cosh => Slope::Factor(self.raw(Op::Sinh, &[a])),
            Op::Tanh => {
                let square = self.square(id);
                Slope::Factor(self.subtract(one, square))
            }
            Op::Copy => Slope::Factor(one),
            // Steps: floor, ceil, round, sign.
            _ => Slope::Factor(self.number(0.0)),
        }
    }
}

/// What the derivative of an argument is multiplied with or divided by.
enum Slope {
    Factor(Id),
    Divisor(Id),
}
