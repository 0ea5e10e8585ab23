//! The oracle is a tree evaluator that shares nothing with the compiler but the functions
//! of the `libm` crate.

mod oracle;

use super::*;
use crate::diffusion::{Reaction, explicit::Parameter};
use crate::{Field, Grid};
use oracle::{NAMES, tree};
use proptest::prelude::*;
/// Bits, but all NaNs alike.
fn bits(value: f64) -> u64 {
    if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() }
}

fn parse(text: &str) -> Expression {
    Expression::parse(text, &NAMES).unwrap_or_else(|error| panic!("{error}"))
}

/// The value of a formula at one node.
fn value(expression: &Expression, x: [f64; 4]) -> f64 {
    let mut out = [0.0];
    let program = Program::new(std::slice::from_ref(expression)).unwrap();
    program.evaluate(&x.map(Input::Uniform), &mut [&mut out], &mut Scratch::default());
    out[0]
}

/// Deterministic values with zeros of both signs, repeated values, infinities and NaN.
fn column(k: usize, i: usize) -> f64 {
    const SPECIAL: [f64; 8] =
        [0.0, -0.0, 1.0, -1.0, 2.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    let hash = (i * 4 + k).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
    if hash.is_multiple_of(7) { SPECIAL[hash / 7 % 8] } else { hash as f64 / 2e6 - 3.0 }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn programs_agree_with_a_tree_to_the_bit(
        trees in prop::collection::vec(tree(), 1..4),
        uniform in prop::array::uniform4(any::<bool>()),
        n in prop_oneof![0..20_usize, 250..270_usize, 500..600_usize],
    ) {
        let formulas: Vec<Expression> = trees.iter().map(|tree| parse(&tree.text())).collect();
        let program = Program::new(&formulas).unwrap();
        let columns: Vec<Vec<f64>> = (0..4)
            .map(|k| (0..n).map(|i| column(k, if uniform[k] { k } else { i })).collect())
            .collect();
        let inputs: Vec<Input<'_>> = (0..4)
            .map(|k| if uniform[k] { Input::Uniform(column(k, k)) } else { Input::Slice(&columns[k]) })
            .collect();
        let mut values = vec![vec![1234.5; n]; trees.len()];
        let mut outputs: Vec<&mut [f64]> = values.iter_mut().map(Vec::as_mut_slice).collect();
        // A work space that another program has used.
        let mut scratch = Scratch::default();
        Program::new(&[parse("sin(u)*v + u/v - feed")]).unwrap().evaluate(
            &[Input::Slice(&[1.0; 3]), Input::Slice(&[2.0; 3]), Input::Uniform(5.0), Input::Uniform(0.0)],
            &mut [&mut [0.0; 3]],
            &mut scratch,
        );
        program.evaluate(&inputs, &mut outputs, &mut scratch);
        for (tree, values) in trees.iter().zip(&values) {
            for i in 0..n {
                let x = std::array::from_fn(|k| columns[k][i]);
                prop_assert_eq!(bits(values[i]), bits(tree.value(&x)), "{} at {:?}", tree.text(), x);
            }
        }
    }

    #[test]
    fn text_reads_back_as_the_same_program(tree in tree()) {
        let first = parse(&tree.text());
        for formula in [first.derivative(0), first] {
            let text = formula.to_string();
            if text.len() <= 10_000 {
                let again = parse(&text);
                prop_assert_eq!(&again.to_string(), &text);
                let programs = [&again, &formula].map(|f| Program::new(std::slice::from_ref(f)).unwrap());
                prop_assert_eq!(&programs[0], &programs[1], "{}", text);
            }
        }
    }

    #[test]
    fn garbage_is_refused_without_panic(text in ".{0,60}") {
        if let Err(error) = Expression::parse(&text, &NAMES) {
            prop_assert!(error.to_string().ends_with('^'));
        }
    }

    #[test]
    fn almost_formulas_do_not_panic(
        words in prop::collection::vec(prop::sample::select(&[
            "u", "v", "(", ")", ",", "+", "-", "*", "/", "^", "<", "==", "min", "where", "2", ".5",
            "1e", "sin", " ", "w", "\n", "\u{e9}", "hill(", "1e-3", ".",
        ]), 0..30)
    ) {
        if let Ok(formula) = Expression::parse(&words.concat(), &NAMES) {
            let _ = value(&formula.derivative(0), [0.5; 4]);
        }
    }
}

#[test]
fn precedence_is_that_of_mathematics() {
    let x = [3.0, 5.0, 7.0, 11.0];
    for (text, expected) in [
        ("-u^2", -9.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("-u*-v", 15.0),
        ("u - v - feed", -9.0),
        ("feed/v/2", 0.7),
        ("1 + u*v^2", 76.0),
        ("u + 1 < v", 1.0),
        ("(u < v) + (v <= 5) + (v > 5) + (u >= 4) + (x_2 == 11)", 3.0),
        (".5e1 + 1.E-1*10 + +1", 7.0),
        ("2*e - 2*2.718281828459045 + tau - 2*pi", 0.0),
        ("min(u, v, feed) + max(u, v, feed)", 10.0),
        ("clamp(x_2, 0, 4) + step(0) + step(-1) + sign(-0.5)", 4.0),
        ("hill(u, 3, 4)", 0.5),
        ("where(u > v, 1, 2) + hypot(3, 4) + round(-2.5)", 4.0),
    ] {
        assert_eq!(value(&parse(text), x), expected, "{text}");
    }
    // A variable hides a constant.
    let hidden = Expression::parse("e", &["e"]).unwrap();
    assert_eq!(hidden.to_string(), "e");
}

#[test]
fn messages_name_place_reason_and_remedy() {
    for (text, message) in [
        (
            "u + fed",
            "unknown name `fed` at column 5, did you mean `feed`? known names: u, v, feed, x_2, e, pi, tau\n  u + fed\n      ^",
        ),
        (
            "zebra*u",
            "unknown name `zebra` at column 1; known names: u, v, feed, x_2, e, pi, tau\n  zebra*u\n  ^",
        ),
        (
            "u*v^",
            "expected a number, a name, `(` or `-` at column 5, found the end\n  u*v^\n      ^",
        ),
        ("", "expected a number, a name, `(` or `-` at column 1, found the end\n  \n  ^"),
        ("(u + v", "expected `)` or an operator at column 7, found the end\n  (u + v\n        ^"),
        (
            "2u",
            "expected an operator or the end at column 2, found `u`, products are written with `*`\n  2u\n   ^",
        ),
        (
            "u**2",
            "expected a number, a name, `(` or `-` at column 3, found `*`, powers are written `^`\n  u**2\n    ^",
        ),
        ("atan2(u)", "`atan2` at column 1 takes 2 arguments, found 1\n  atan2(u)\n  ^"),
        ("min(u)", "`min` at column 1 takes 2 or more arguments, found 1\n  min(u)\n  ^"),
        ("sin()", "`sin` at column 1 takes 1 argument, found 0\n  sin()\n  ^"),
        (
            "u(1 - v)",
            "`u` at column 1 is no function, products are written with `*`\n  u(1 - v)\n  ^",
        ),
        (
            "1 + sin",
            "the function `sin` at column 5 needs arguments: `sin(...)`\n  1 + sin\n      ^",
        ),
        (
            "u < v < 1",
            "comparisons do not chain: use parentheses, found another at column 7\n  u < v < 1\n        ^",
        ),
        ("u = v", "unexpected character `=` at column 3, equality is `==`\n  u = v\n    ^"),
        ("1e999", "a number greater than 1.797e308 at column 1\n  1e999\n  ^"),
        (
            "u +\n v +\n * v",
            "expected a number, a name, `(` or `-` at column 2 of line 3, found `*`\n   * v\n   ^",
        ),
    ] {
        assert_eq!(Expression::parse(text, &NAMES).unwrap_err().to_string(), message);
    }
    let error = Expression::parse("tahn(u)", &NAMES).unwrap_err();
    assert!(
        error.message().starts_with("unknown function `tahn`, did you mean `tanh`?"),
        "{error}"
    );
    assert_eq!((error.line(), error.column()), (1, 1));
}

#[test]
fn depth_and_length_are_limited() {
    for open in ["(", "-", "sin(", "2^"] {
        let error = Expression::parse(&open.repeat(2000), &NAMES).unwrap_err();
        assert!(
            error.to_string().starts_with("nesting deeper than 200 levels at column"),
            "{error}"
        );
    }
    let deep = format!("{}u{}", "(".repeat(199), ")".repeat(199));
    assert!(Expression::parse(&deep, &NAMES).is_ok());
    let long = Expression::parse(&"u+".repeat(5001), &NAMES).unwrap_err();
    assert!(long.to_string().starts_with("a formula of 10002 bytes at column 1, at most 10000"));
    // A chain of 5000 terms is one level deep to the parser but 5000 to the tree.
    let chain = parse(&("u+".repeat(4999) + "u"));
    assert_eq!(value(&chain, [1.0; 4]), 5000.0);
    assert_eq!(value(&chain.derivative(0), [1.0; 4]), 5000.0);
    assert_eq!(chain.to_string().len(), 5000 + 3 * 4999);
}

/// Each function against central differences. The formulas and their third derivatives are
/// of order 1 to 100 at these points, so with steps of 1e-5 truncation is below 1e-8 and
/// rounding about 1e-11/1e-5 x 1e-5.
#[test]
fn derivatives_agree_with_finite_differences() {
    let x = [0.37, 0.61, 1.3, 2.2];
    for text in [
        "abs(u - v)",
        "abs(u)",
        "sqrt(u)",
        "exp(-u*v)",
        "log(u + v)",
        "log10(u)",
        "sin(3*u)",
        "cos(u)/v",
        "tan(u)",
        "asin(u)",
        "acos(u*v)",
        "atan(u/v)",
        "sinh(u)",
        "cosh(u)",
        "tanh(u - v)",
        "floor(9*u)",
        "ceil(u)",
        "round(u)",
        "sign(u)",
        "atan2(u, v)",
        "atan2(v, u)",
        "hypot(u, 2*v)",
        "min(u, v)",
        "max(u, v, u*v)",
        "clamp(u, 0.1, 0.9)",
        "where(u < v, u^2, u^3)",
        "u^3",
        "u^-2",
        "u^0.5",
        "u^2.7",
        "2^u",
        "u^u",
        "u^v",
        "v^u",
        "hill(u, v, 2)",
        "hill(v, u, 3)",
        "hill(u, v, feed)",
        "hill(v, 0.4, u)",
        "feed*(1 - u) - u*v^2",
        "1/(1 + u)^2",
        "step(u)",
        "u/feed - v/u",
        "-u^2",
        "pow(u, 3)",
        "u < v",
        "where(u > 0, exp(-1/u), 0)",
    ] {
        let formula = parse(text);
        for k in 0..2 {
            let h = 1e-5;
            let at = |shift: f64| {
                let mut x = x;
                x[k] += shift;
                value(&formula, x)
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            let exact = value(&formula.derivative(k), x);
            assert!(
                (exact - difference).abs() < 1e-7,
                "d/d{} {text}: {exact} {difference}",
                NAMES[k]
            );
        }
        // Exactly 0 by a variable that does not occur, and written so.
        assert_eq!(formula.derivative(3).to_string(), "0", "{text}");
    }
}

#[test]
fn derivatives_drop_zeros_and_ones() {
    for (text, expected) in [
        ("feed*(1 - u) - u*v^2", "-feed - v^2"),
        ("u + v", "1"),
        ("3*u", "3"),
        ("u^2", "2*u"),
        ("u*v", "v"),
        ("sin(u)", "cos(u)"),
        ("exp(2*u)", "exp(2*u)*2"),
        ("where(v > 0, u, u + 1)", "1"),
    ] {
        assert_eq!(parse(text).derivative(0).to_string(), expected);
    }
}

#[test]
fn shared_subexpressions_are_computed_once() {
    let rates = [parse("feed*(1 - u) - u*v^2"), parse("v*v*u - (feed + x_2)*v")];
    // v v, u (v v), 1 - u, feed (1 - u), the difference; feed + x_2, times v, the difference.
    // The first v^2 and the second v*v are the same node, and so are their products with u.
    let program = Program::new(&rates).unwrap();
    assert_eq!(program.operations(), 8);
    assert_eq!(Program::new(&rates[..1]).unwrap().operations(), 5);
    let other = Expression::parse("u", &["u"]).unwrap();
    let error = Program::new(&[rates[0].clone(), other]).unwrap_err();
    assert!(error.to_string().contains("found [u, v, feed, x_2] and [u]"), "{error}");
}

#[test]
fn registers_are_used_again() {
    let chain = (0..40).fold("u".to_string(), |text, k| format!("sin({text})*{k}.5"));
    let program = Program::new(&[parse(&chain)]).unwrap();
    assert_eq!(program.operations(), 80);
    // One for the value, one for the next; the last result goes to the output.
    assert_eq!(program.registers, 2);
}

fn gray_scott(feed: Parameter) -> FormulaReaction {
    let species = [("u", "feed*(1 - u) - u*v^2"), ("v", "u*v^2 - (feed + kill)*v")];
    FormulaReaction::new(&species, &[("feed", feed), ("kill", Parameter::Uniform(0.06))]).unwrap()
}

/// Rates of a piece `first..first + n` of fixed concentrations.
fn piece(reaction: &FormulaReaction, first: usize, n: usize) -> [Vec<f64>; 2] {
    let u: Vec<f64> = (first..first + n).map(|i| (0.1 * i as f64).sin()).collect();
    let v: Vec<f64> = (first..first + n).map(|i| (0.3 * i as f64).cos()).collect();
    let (mut du, mut dv) = (vec![0.0; n], vec![0.0; n]);
    reaction.rates(first, &[&u, &v], &mut [&mut du, &mut dv]);
    [du, dv]
}

#[test]
fn reaction_takes_maps_and_any_piece() {
    let grid = Grid::new(&[30, 41], 1.0).unwrap();
    let map = Field::from_fn(grid, |[x, y, _]| 0.01 * x + 0.02 * y);
    let reaction = gray_scott(Parameter::Map(map.clone()));
    let [du, dv] = piece(&reaction, 0, grid.len());
    for i in 0..grid.len() {
        let (u, v) = ((0.1 * i as f64).sin(), (0.3 * i as f64).cos());
        let feed = map.as_slice()[i];
        assert_eq!(du[i], feed * (1.0 - u) - u * (v * v));
        assert_eq!(dv[i], u * (v * v) - (feed + 0.06) * v);
    }
    // From many threads at once, the same bytes.
    use rayon::prelude::*;
    (0..200_usize).into_par_iter().for_each(|k| {
        let (first, n) = (5 * k, 1 + k);
        let [a, b] = piece(&reaction, first, n);
        assert_eq!((&a[..], &b[..]), (&du[first..first + n], &dv[first..first + n]));
    });
}

#[test]
fn reaction_has_the_exact_jacobian() {
    let mut reaction = gray_scott(Parameter::Uniform(0.5));
    reaction.set_parameter("feed", Parameter::Uniform(0.04)).unwrap();
    let jacobian = reaction.jacobian(0, &[0.5, 0.25]).unwrap();
    let expected = [-0.04 - 0.0625, -(0.5 * 0.5), 0.0625, 0.5 * 0.5 - (0.04 + 0.06)];
    assert_eq!(jacobian.transpose().as_slice(), expected);
    let error = reaction.jacobian(0, &[0.5]).unwrap_err();
    assert_eq!(error.to_string(), "concentrations has shape [1], expected [2]");
    let error = reaction.set_parameter("fed", Parameter::Uniform(1.0)).unwrap_err();
    assert_eq!(error.to_string(), "unknown parameter `fed`; known: feed, kill");
}

#[test]
fn reaction_refuses_bad_names() {
    let refusal =
        |species: &[(&str, &str)]| FormulaReaction::new(species, &[]).unwrap_err().to_string();
    assert!(refusal(&[("u", "1"), ("u", "2")]).contains("the name `u` is given twice"));
    assert!(refusal(&[("2u", "1")]).contains("the name `2u` is not made of letters"));
    assert!(refusal(&[]).contains("found 0 species of 0 names"));
    let message = refusal(&[("u", "1 +")]);
    assert!(message.starts_with("in the formula of species `u`: expected a number"), "{message}");
}
