//! Tokens to a graph, by operator precedence (Pratt 1973).
//!
//! From the loosest: comparisons (which do not chain), `+ -`, `* /`, unary `-` and `+`,
//! `^` (right to left). So `-x^2 = -(x^2)` and `2^-x` is allowed.

use super::error::{ParseError, nearest};
use super::graph::{Graph, Id};
use super::lexer::{Token, tokens};
use super::op::{CONSTANTS, FUNCTIONS, Op, SUGAR};

/// Longest text (bytes): hundreds of terms, and far from what could exhaust memory.
pub(super) const MAX_LENGTH: usize = 10_000;

/// Deepest nesting of parentheses, calls, signs and powers: some 100 kB of stack.
pub(super) const MAX_DEPTH: usize = 200;

pub(super) const COMPARISON: u8 = 1;
pub(super) const SUM: u8 = 2;
pub(super) const PRODUCT: u8 = 3;
pub(super) const SIGN: u8 = 4;
pub(super) const POWER: u8 = 5;

/// Operators between two operands: symbol, operation, precedence.
pub(super) const OPERATORS: [(&str, Op, u8); 10] = [
    ("<", Op::Less, COMPARISON),
    ("<=", Op::LessEqual, COMPARISON),
    (">", Op::Greater, COMPARISON),
    (">=", Op::GreaterEqual, COMPARISON),
    ("==", Op::Equal, COMPARISON),
    ("+", Op::Add, SUM),
    ("-", Op::Subtract, SUM),
    ("*", Op::Multiply, PRODUCT),
    ("/", Op::Divide, PRODUCT),
    ("^", Op::Power, POWER),
];

struct Parser<'a> {
    text: &'a str,
    names: &'a [&'a str],
    tokens: Vec<(Token<'a>, usize)>,
    next: usize,
    depth: usize,
    graph: Graph,
}

type Parsed = Result<Id, ParseError>;

/// The graph of a text and the node that is its value.
pub(super) fn parse(text: &str, names: &[&str]) -> Result<(Graph, Id), ParseError> {
    if text.len() > MAX_LENGTH {
        let message =
            format!("a formula of {} bytes{{}}, at most {MAX_LENGTH} are read", text.len());
        return Err(ParseError::new(text, 0, message));
    }
    let tokens = tokens(text)?;
    let mut parser = Parser { text, names, tokens, next: 0, depth: 0, graph: Graph::default() };
    let root = parser.expression(COMPARISON)?;
    match parser.peek() {
        Token::End => Ok((parser.graph, root)),
        found => Err(parser.unexpected("an operator or the end", found)),
    }
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Token<'a> {
        self.tokens[self.next].0
    }

    /// Takes the next token; the last one stays.
    fn take(&mut self) -> Token<'a> {
        let token = self.peek();
        self.next = (self.next + 1).min(self.tokens.len() - 1);
        token
    }

    fn fail(&self, at: usize, message: impl Into<String>) -> ParseError {
        ParseError::new(self.text, at, message)
    }

    /// An error at the next token.
    fn unexpected(&self, wanted: &str, found: Token<'_>) -> ParseError {
        let hint = match (found, self.next.checked_sub(1).map(|last| self.tokens[last].0)) {
            (Token::Symbol("*"), Some(Token::Symbol("*"))) => ", powers are written `^`",
            (
                Token::Name(_) | Token::Number(_) | Token::Symbol("("),
                Some(Token::Name(_) | Token::Number(_) | Token::Symbol(")")),
            ) => ", products are written with `*`",
            _ => "",
        };
        let message = format!("expected {wanted}{{}}, found {}{hint}", found.describe());
        self.fail(self.tokens[self.next].1, message)
    }

    /// Everything that binds at least as strongly as `least`.
    fn expression(&mut self, least: u8) -> Parsed {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let at = self.tokens[self.next].1;
            return Err(self.fail(at, format!("nesting deeper than {MAX_DEPTH} levels")));
        }
        let mut left = self.operand()?;
        while let Some((op, binding)) = self.operator(least) {
            self.next += 1;
            // `^` groups to the right, and its exponent may carry a sign.
            let right = self.expression(if binding == POWER { SIGN } else { binding + 1 })?;
            left = self.graph.apply(op, &[left, right]);
            if binding == COMPARISON && self.operator(COMPARISON).is_some_and(|(_, b)| b == binding)
            {
                let at = self.tokens[self.next].1;
                return Err(
                    self.fail(at, "comparisons do not chain: use parentheses, found another")
                );
            }
        }
        self.depth -= 1;
        Ok(left)
    }

    /// The operator that comes next, if it binds at least as strongly as `least`.
    fn operator(&self, least: u8) -> Option<(Op, u8)> {
        let Token::Symbol(symbol) = self.peek() else { return None };
        let known = OPERATORS.iter().find(|(known, _, _)| *known == symbol);
        known.map(|&(_, op, binding)| (op, binding)).filter(|&(_, binding)| binding >= least)
    }

    fn operand(&mut self) -> Parsed {
        let at = self.tokens[self.next].1;
        match self.peek() {
            Token::Number(value) => {
                self.take();
                Ok(self.graph.constant(value))
            }
            Token::Name(name) => {
                self.take();
                if self.peek() == Token::Symbol("(") {
                    self.call(name, at)
                } else {
                    self.name(name, at)
                }
            }
            Token::Symbol("-") => {
                self.take();
                let operand = self.expression(SIGN)?;
                Ok(self.graph.apply(Op::Negate, &[operand]))
            }
            Token::Symbol("+") => {
                self.take();
                self.expression(SIGN)
            }
            Token::Symbol("(") => {
                self.take();
                let inner = self.expression(COMPARISON)?;
                self.close("`)` or an operator")?;
                Ok(inner)
            }
            found => Err(self.unexpected("a number, a name, `(` or `-`", found)),
        }
    }

    fn close(&mut self, wanted: &str) -> Result<(), ParseError> {
        match self.peek() {
            Token::Symbol(")") => {
                self.take();
                Ok(())
            }
            found => Err(self.unexpected(wanted, found)),
        }
    }

    /// A variable or, if none has this name, a named number.
    fn name(&mut self, name: &str, at: usize) -> Parsed {
        if let Some(index) = self.names.iter().position(|&known| known == name) {
            return Ok(self.graph.variable(index));
        }
        if let Some(&(_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            return Ok(self.graph.constant(value));
        }
        if functions().contains(&name) {
            return Err(
                self.fail(at, format!("the function `{name}`{{}} needs arguments: `{name}(...)`"))
            );
        }
        let mut known = self.names.to_vec();
        known.extend(["e", "pi", "tau"]);
        Err(self.unknown("name", name, at, &known))
    }

    fn unknown(&self, kind: &str, name: &str, at: usize, known: &[&str]) -> ParseError {
        let near = nearest(name, known).map_or(String::new(), |n| format!(", did you mean `{n}`?"));
        let separator = if near.is_empty() { ";" } else { "" };
        let known = known.join(", ");
        let message =
            format!("unknown {kind} `{name}`{{}}{near}{separator} known {kind}s: {known}");
        self.fail(at, message)
    }

    /// A function's arguments, from its parenthesis on.
    fn call(&mut self, name: &str, at: usize) -> Parsed {
        let functions = functions();
        if !functions.contains(&name) {
            if self.names.contains(&name) || CONSTANTS.iter().any(|(known, _)| *known == name) {
                let message = format!("`{name}`{{}} is no function, products are written with `*`");
                return Err(self.fail(at, message));
            }
            return Err(self.unknown("function", name, at, &functions));
        }
        self.take();
        let mut arguments = Vec::new();
        while self.peek() != Token::Symbol(")") || !arguments.is_empty() {
            arguments.push(self.expression(COMPARISON)?);
            if self.peek() != Token::Symbol(",") {
                break;
            }
            self.take();
        }
        self.close("`,`, `)` or an operator")?;
        self.function(name, at, &arguments)
    }

    fn function(&mut self, name: &str, at: usize, arguments: &[Id]) -> Parsed {
        let op = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|&(_, op)| op);
        let several = matches!(op, Some(Op::Min | Op::Max));
        let wanted = op.map_or(if name == "clamp" { 3 } else { 1 }, Op::arity);
        let found = arguments.len();
        if found != wanted && !(several && found > wanted) {
            let more = if several { " or more" } else { "" };
            let plural = if wanted == 1 { "" } else { "s" };
            let message =
                format!("`{name}`{{}} takes {wanted}{more} argument{plural}, found {found}");
            return Err(self.fail(at, message));
        }
        let graph = &mut self.graph;
        Ok(match (op, arguments) {
            (Some(op), [first, rest @ ..]) if several => {
                rest.iter().fold(*first, |all, &next| graph.apply(op, &[all, next]))
            }
            (Some(op), _) => graph.apply(op, arguments),
            (None, &[x, least, greatest]) => {
                let raised = graph.apply(Op::Max, &[x, least]);
                graph.apply(Op::Min, &[raised, greatest])
            }
            (None, _) => {
                let zero = graph.constant(0.0);
                graph.apply(Op::GreaterEqual, &[arguments[0], zero])
            }
        })
    }
}

/// Names of all functions.
fn functions() -> Vec<&'static str> {
    FUNCTIONS.iter().map(|&(name, _)| name).chain(SUGAR).collect()
}
