//! Formulas as plain trees, evaluated without the compiler: only the functions of the `libm`
//! crate are shared.

use proptest::prelude::*;

pub(super) const NAMES: [&str; 4] = ["u", "v", "feed", "x_2"];

/// A formula as a plain tree.
#[derive(Clone, Debug)]
pub(super) enum Tree {
    Number(f64),
    Variable(usize),
    Call(&'static str, Vec<Tree>),
    Binary(&'static str, Box<(Tree, Tree)>),
    Minus(Box<Tree>),
}

impl Tree {
    /// With all parentheses, whatever the precedence.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Number(value) if value.is_sign_negative() => format!("({value:?})"),
            Self::Number(value) => format!("{value:?}"),
            Self::Variable(k) => NAMES[*k].into(),
            Self::Call(name, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(Self::text).collect();
                format!("{name}({})", arguments.join(","))
            }
            Self::Binary(op, pair) => format!("({}{op}{})", pair.0.text(), pair.1.text()),
            Self::Minus(inner) => format!("(-{})", inner.text()),
        }
    }

    pub(super) fn value(&self, x: &[f64; 4]) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Variable(k) => x[*k],
            Self::Minus(inner) => -inner.value(x),
            Self::Binary(op, pair) => binary(op, pair.0.value(x), pair.1.value(x)),
            Self::Call(name, arguments) => {
                let a: Vec<f64> = arguments.iter().map(|argument| argument.value(x)).collect();
                call(name, &a)
            }
        }
    }
}

pub(super) fn binary(op: &str, a: f64, b: f64) -> f64 {
    match op {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        "^" => naive_power(a, b),
        "<" => f64::from(a < b),
        "<=" => f64::from(a <= b),
        ">" => f64::from(a > b),
        ">=" => f64::from(a >= b),
        _ => f64::from(a == b),
    }
}

/// The documented products, recursively: x^2k = (x^k)^2, x^(2k+1) = x^2k x.
pub(super) fn naive_power(x: f64, y: f64) -> f64 {
    fn whole(x: f64, n: i32) -> f64 {
        match n {
            0 => 1.0,
            1 => x,
            _ if n % 2 == 1 => whole(x, n - 1) * x,
            _ => whole(x, n / 2) * whole(x, n / 2),
        }
    }
    match y as i32 {
        n if f64::from(n) == y && (0..=16).contains(&n) => whole(x, n),
        n if f64::from(n) == y && (-16..0).contains(&n) => 1.0 / whole(x, -n),
        _ if y == 0.5 => x.sqrt(),
        _ => libm::pow(x, y),
    }
}

pub(super) fn call(name: &str, a: &[f64]) -> f64 {
    let least = |a: f64, b: f64| if a.is_nan() || a < b { a } else { b };
    let greatest = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    match name {
        "abs" => a[0].abs(),
        "sqrt" => a[0].sqrt(),
        "exp" => libm::exp(a[0]),
        "log" => libm::log(a[0]),
        "log10" => libm::log10(a[0]),
        "sin" => libm::sin(a[0]),
        "cos" => libm::cos(a[0]),
        "tan" => libm::tan(a[0]),
        "asin" => libm::asin(a[0]),
        "acos" => libm::acos(a[0]),
        "atan" => libm::atan(a[0]),
        "sinh" => libm::sinh(a[0]),
        "cosh" => libm::cosh(a[0]),
        "tanh" => libm::tanh(a[0]),
        "floor" => a[0].floor(),
        "ceil" => a[0].ceil(),
        "round" => a[0].round(),
        "sign" => {
            if a[0] == 0.0 {
                0.0
            } else {
                a[0].signum()
            }
        }
        "step" => f64::from(a[0] >= 0.0),
        "min" => a[1..].iter().fold(a[0], |all, &next| least(all, next)),
        "max" => a[1..].iter().fold(a[0], |all, &next| greatest(all, next)),
        "clamp" => least(greatest(a[0], a[1]), a[2]),
        "atan2" => libm::atan2(a[0], a[1]),
        "hypot" => libm::hypot(a[0], a[1]),
        "pow" => naive_power(a[0], a[1]),
        "where" => {
            if a[0] == 0.0 {
                a[2]
            } else {
                a[1]
            }
        }
        _ => naive_power(a[0], a[2]) / (naive_power(a[1], a[2]) + naive_power(a[0], a[2])),
    }
}

pub(super) const UNARY: [&str; 19] = [
    "abs", "sqrt", "exp", "log", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sinh",
    "cosh", "tanh", "floor", "ceil", "round", "sign", "step",
];

pub(super) fn tree() -> impl Strategy<Value = Tree> {
    let number = prop_oneof![
        (-20..20_i32).prop_map(f64::from),
        (-9..9_i32).prop_map(|n| 0.5 * f64::from(n)),
        any::<f64>().prop_filter("finite", |v| v.is_finite()),
    ];
    let leaf = prop_oneof![
        number.prop_map(Tree::Number),
        (0..4_usize).prop_map(Tree::Variable),
        (0..4_usize).prop_map(Tree::Variable),
    ];
    leaf.prop_recursive(6, 40, 4, |inner| {
        let operators =
            prop::sample::select(&["+", "-", "*", "/", "^", "<", "<=", ">", ">=", "=="]);
        let two = prop::sample::select(&["atan2", "hypot", "pow", "min", "max"]);
        let three = prop::sample::select(&["where", "clamp", "hill", "min", "max"]);
        let list = |n| prop::collection::vec(inner.clone(), n);
        prop_oneof![
            4 => (operators, inner.clone(), inner.clone())
                .prop_map(|(op, a, b)| Tree::Binary(op, Box::new((a, b)))),
            1 => inner.clone().prop_map(|a| Tree::Minus(Box::new(a))),
            2 => (prop::sample::select(&UNARY), list(1)).prop_map(|(name, a)| Tree::Call(name, a)),
            1 => (two, list(2)).prop_map(|(name, a)| Tree::Call(name, a)),
            1 => (three, list(3)).prop_map(|(name, a)| Tree::Call(name, a)),
        ]
    })
}
