//! The operations of formulas: names, numbers of arguments, and what they compute.

/// An operation. `Ord` only serves to find equal subexpressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Op {
    /// The argument itself; only in programs.
    Copy,
    Negate,
    Abs,
    Sqrt,
    Exp,
    Log,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Floor,
    Ceil,
    Round,
    Sign,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    Min,
    Max,
    Atan2,
    Hypot,
    Where,
    Hill,
}

/// Functions that are one operation, by name.
pub(super) const FUNCTIONS: [(&str, Op); 25] = [
    ("abs", Op::Abs),
    ("sqrt", Op::Sqrt),
    ("exp", Op::Exp),
    ("log", Op::Log),
    ("log10", Op::Log10),
    ("sin", Op::Sin),
    ("cos", Op::Cos),
    ("tan", Op::Tan),
    ("asin", Op::Asin),
    ("acos", Op::Acos),
    ("atan", Op::Atan),
    ("sinh", Op::Sinh),
    ("cosh", Op::Cosh),
    ("tanh", Op::Tanh),
    ("floor", Op::Floor),
    ("ceil", Op::Ceil),
    ("round", Op::Round),
    ("sign", Op::Sign),
    ("min", Op::Min),
    ("max", Op::Max),
    ("atan2", Op::Atan2),
    ("hypot", Op::Hypot),
    ("where", Op::Where),
    ("hill", Op::Hill),
    ("pow", Op::Power),
];

/// Functions that the parser writes in terms of other operations.
pub(super) const SUGAR: [&str; 2] = ["step", "clamp"];

/// Named numbers.
pub(super) const CONSTANTS: [(&str, f64); 3] =
    [("pi", std::f64::consts::PI), ("e", std::f64::consts::E), ("tau", std::f64::consts::TAU)];

/// Greatest integer exponent that is done by multiplications: at most six of them, each
/// with a relative error of 2^-53, in the place of a call fifty times as long.
const MAX_EXPONENT: f64 = 16.0;

impl Op {
    /// Number of arguments.
    pub(super) fn arity(self) -> usize {
        match self {
            Self::Where | Self::Hill => 3,
            _ if self < Self::Add => 1,
            _ => 2,
        }
    }

    /// Whether the arguments may be swapped without changing a bit.
    pub(super) fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply)
    }

    /// The value at the arguments `a`, of which the first `arity` count.
    ///
    /// Basic arithmetic and `sqrt` are those of IEEE 754; the other functions are
    /// software of the `libm` crate, whose results do not depend on the machine.
    #[inline(always)]
    pub(super) fn apply(self, [a, b, c]: [f64; 3]) -> f64 {
        let truth = |holds: bool| if holds { 1.0 } else { 0.0 };
        match self {
            Self::Copy => a,
            Self::Negate => -a,
            Self::Abs => a.abs(),
            Self::Sqrt => a.sqrt(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Round => round(a),
            Self::Sign => sign(a),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Equal => truth(a == b),
            // A NaN on either side stays visible.
            Self::Min => {
                if (a < b) | a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Self::Max => {
                if (a > b) | a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Self::Where => {
                if a != 0.0 {
                    b
                } else {
                    c
                }
            }
            Self::Exp => libm::exp(a),
            Self::Log => libm::log(a),
            Self::Log10 => libm::log10(a),
            Self::Sin => libm::sin(a),
            Self::Cos => libm::cos(a),
            Self::Tan => libm::tan(a),
            Self::Asin => libm::asin(a),
            Self::Acos => libm::acos(a),
            Self::Atan => libm::atan(a),
            Self::Sinh => libm::sinh(a),
            Self::Cosh => libm::cosh(a),
            Self::Tanh => libm::tanh(a),
            Self::Atan2 => libm::atan2(a, b),
            Self::Hypot => libm::hypot(a, b),
            Self::Power => power(a, b),
            Self::Hill => {
                let x = power(a, c);
                x / (power(b, c) + x)
            }
        }
    }
}

/// 1, 0 or -1; NaN for NaN.
#[inline(always)]
fn sign(a: f64) -> f64 {
    if a > 0.0 {
        1.0
    } else if a < 0.0 {
        -1.0
    } else {
        // 0 of either sign gives 0, NaN gives NaN.
        a + 0.0
    }
}

/// Nearest integer, halves away from zero.
#[inline(always)]
fn round(a: f64) -> f64 {
    let whole = a.abs().floor();
    let up = if a.abs() - whole >= 0.5 { 1.0 } else { 0.0 };
    (whole + up).copysign(a)
}

/// `x^y`. Whole `y` of at most 16 in size are done by multiplications ([`whole_power`]),
/// `y = 1/2` by a square root; whether `y` is written as a number, a parameter or varies
/// in space makes no difference to the result.
pub(super) fn power(x: f64, y: f64) -> f64 {
    match whole_exponent(y) {
        Some(n) => whole_power(n, [x])[0],
        None if y == 0.5 => x.sqrt(),
        None => libm::pow(x, y),
    }
}

/// The exponent, if it is done by multiplications.
pub(super) fn whole_exponent(y: f64) -> Option<i32> {
    (y.abs() <= MAX_EXPONENT && y == y.trunc()).then_some(y as i32)
}

/// `x^n` from the leading binary digit on: square, and multiply by `x` where the digit
/// is 1, so x^2 = x x, x^3 = (x x) x, x^4 = (x x)(x x); the inverse of that for `n < 0`.
#[inline(always)]
pub(super) fn whole_power<const L: usize>(n: i32, x: [f64; L]) -> [f64; L] {
    let digits = n.unsigned_abs();
    if digits == 0 {
        return [1.0; L];
    }
    let mut result = x;
    for digit in (0..digits.ilog2()).rev() {
        for (result, x) in result.iter_mut().zip(x) {
            *result *= *result;
            if digits >> digit & 1 == 1 {
                *result *= x;
            }
        }
    }
    if n < 0 {
        for result in &mut result {
            *result = 1.0 / *result;
        }
    }
    result
}
