//! Graphs back to text, with the fewest parentheses.

use super::graph::{Graph, Id, Node};
use super::op::{FUNCTIONS, Op};
use super::parser::{COMPARISON, OPERATORS, POWER, PRODUCT, SIGN};
use std::fmt;

/// What remains to be written; a stack of it stands for recursion, which a derivative of
/// a derivative of ... could drive too deep.
enum Piece {
    Text(&'static str),
    /// A node, in parentheses if it binds less strongly than the number says.
    Node(Id, u8),
}

/// Binds more strongly than any operator.
const ATOM: u8 = POWER + 1;

pub(super) fn write(
    graph: &Graph,
    root: Id,
    names: &[String],
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    let mut stack = vec![Piece::Node(root, COMPARISON)];
    while let Some(piece) = stack.pop() {
        let (id, least) = match piece {
            Piece::Text(text) => {
                f.write_str(text)?;
                continue;
            }
            Piece::Node(id, least) => (id, least),
        };
        if binding(graph, id) < least {
            f.write_str("(")?;
            stack.push(Piece::Text(")"));
        }
        match graph.node(id) {
            Node::Constant(bits) => f.write_str(&number(f64::from_bits(bits)))?,
            Node::Variable(index) => f.write_str(&names[index])?,
            Node::Apply(op, arguments) => {
                let from = stack.len();
                pieces(graph, op, &arguments[..op.arity()], &mut stack);
                stack[from..].reverse();
            }
        }
    }
    Ok(())
}

/// The text of an operation, in the order of writing.
fn pieces(graph: &Graph, op: Op, arguments: &[Id], out: &mut Vec<Piece>) {
    if op == Op::Negate {
        out.extend([Piece::Text("-"), Piece::Node(arguments[0], SIGN)]);
    } else if let Some(&(symbol, _, own)) = OPERATORS.iter().find(|(_, known, _)| *known == op) {
        // What stands on the side to which an operator does not group is put in
        // parentheses if it binds equally; so are the operands of comparisons.
        let (left, right) = match own {
            POWER => (ATOM, SIGN),
            COMPARISON => (own + 1, own + 1),
            _ => (own, own + 1),
        };
        let (before, after) = if own >= PRODUCT { ("", "") } else { (" ", " ") };
        out.extend([Piece::Node(arguments[0], left), Piece::Text(before), Piece::Text(symbol)]);
        out.extend([Piece::Text(after), Piece::Node(arguments[1], right)]);
    } else if let Some(&(name, _)) = FUNCTIONS.iter().find(|(_, known)| *known == op) {
        out.extend([Piece::Text(name), Piece::Text("(")]);
        for (k, argument) in chain(graph, op, arguments).into_iter().enumerate() {
            out.push(Piece::Text(if k > 0 { ", " } else { "" }));
            out.push(Piece::Node(argument, COMPARISON));
        }
        out.push(Piece::Text(")"));
    }
}

/// The arguments of a function; `min(min(a, b), c)` is `min(a, b, c)`, and `max` likewise.
fn chain(graph: &Graph, op: Op, arguments: &[Id]) -> Vec<Id> {
    let mut all: Vec<Id> = arguments.iter().rev().copied().collect();
    while let (true, Some(&first)) = (matches!(op, Op::Min | Op::Max), all.last()) {
        match graph.node(first) {
            Node::Apply(inner, [a, b, _]) if inner == op => {
                all.pop();
                all.extend([b, a]);
            }
            _ => break,
        }
    }
    all.reverse();
    all
}

/// How strongly the text of a node binds.
fn binding(graph: &Graph, id: Id) -> u8 {
    match graph.node(id) {
        Node::Constant(bits) => match f64::from_bits(bits) {
            value if !value.is_finite() => PRODUCT,
            value if value.is_sign_negative() => SIGN,
            _ => ATOM,
        },
        Node::Variable(_) => ATOM,
        Node::Apply(Op::Negate, _) => SIGN,
        Node::Apply(op, _) => {
            OPERATORS.iter().find(|(_, known, _)| *known == op).map_or(ATOM, |&(_, _, own)| own)
        }
    }
}

/// The shortest digits that read back as `value`; what is not finite as the quotient that
/// makes it.
fn number(value: f64) -> String {
    if value.is_nan() {
        return "0/0".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "1/0" } else { "-1/0" }.into();
    }
    let text = format!("{value:?}");
    text.strip_suffix(".0").unwrap_or(&text).into()
}
