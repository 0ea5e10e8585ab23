//! Compilation: several formulas to one list of instructions on few registers.

use super::Expression;
use super::graph::{Graph, Id, Node};
use super::op::{Op, whole_exponent};
use crate::{Error, Result};

/// Where an argument comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// The bits of a number.
    Constant(u64),
    Input(usize),
    Register(usize),
}

/// Where a result goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Target {
    Register(usize),
    Output(usize),
}

/// `target = op(arguments)`; no argument is in the target's register.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Instruction {
    pub op: Op,
    pub target: Target,
    pub arguments: [Source; 3],
}

/// Formulas of the same variables, compiled together.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    pub(super) instructions: Vec<Instruction>,
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    pub(super) registers: usize,
}

impl Program {
    /// Compiles `expressions`; output `k` of the program is the value of expression `k`.
    ///
    /// # Errors
    /// If their variables differ.
    pub fn new(expressions: &[Expression]) -> Result<Self> {
        let names = expressions.first().map_or(&[][..], |first| first.names());
        let mut graph = Graph::default();
        let mut roots = Vec::new();
        for expression in expressions {
            if expression.names() != names {
                return Err(Error::Invalid(format!(
                    "formulas of one program need the same variables, found [{}] and [{}]",
                    names.join(", "),
                    expression.names().join(", ")
                )));
            }
            roots.push(graph.import(&expression.graph, expression.root, lower));
        }
        let mut assembly = Assembly::new(&graph, &roots);
        assembly.run(&roots);
        let Assembly { instructions, registers, .. } = assembly;
        Ok(Self { instructions, inputs: names.len(), outputs: roots.len(), registers })
    }

    /// Number of operations per node, copies of inputs and constants to outputs included.
    pub fn operations(&self) -> usize {
        self.instructions.len()
    }
}

/// Operations in terms of cheaper ones, with the same bits for a result.
fn lower(graph: &mut Graph, op: Op, arguments: &[Id]) -> Id {
    match (op, arguments) {
        (Op::Power, &[x, exponent]) => lower_power(graph, x, exponent),
        (Op::Hill, &[x, k, n]) => {
            let (x, k) = (lower_power(graph, x, n), lower_power(graph, k, n));
            let sum = graph.apply(Op::Add, &[k, x]);
            graph.apply(Op::Divide, &[x, sum])
        }
        (Op::Divide, &[x, divisor]) => match graph.number(divisor).and_then(exact_inverse) {
            Some(inverse) => {
                let inverse = graph.constant(inverse);
                graph.apply(Op::Multiply, &[x, inverse])
            }
            None => graph.apply(op, arguments),
        },
        _ => graph.apply(op, arguments),
    }
}

/// The steps of [`super::op::power`] for a known exponent.
fn lower_power(graph: &mut Graph, x: Id, exponent: Id) -> Id {
    let Some(y) = graph.number(exponent) else { return graph.apply(Op::Power, &[x, exponent]) };
    match whole_exponent(y) {
        Some(0) => graph.constant(1.0),
        Some(n) => {
            let digits = n.unsigned_abs();
            let mut result = x;
            for digit in (0..digits.ilog2()).rev() {
                result = graph.apply(Op::Multiply, &[result, result]);
                if digits >> digit & 1 == 1 {
                    result = graph.apply(Op::Multiply, &[result, x]);
                }
            }
            if n > 0 {
                return result;
            }
            let one = graph.constant(1.0);
            graph.apply(Op::Divide, &[one, result])
        }
        None if y == 0.5 => graph.apply(Op::Sqrt, &[x]),
        None => graph.apply(Op::Power, &[x, exponent]),
    }
}

/// `1/divisor` if that is exact, so for powers of 2; then a product has the quotient's bits.
fn exact_inverse(divisor: f64) -> Option<f64> {
    let mantissa = divisor.to_bits() & ((1 << 52) - 1);
    let inverse = 1.0 / divisor;
    (divisor.is_normal() && mantissa == 0 && inverse.is_normal()).then_some(inverse)
}

/// The state of a linear register allocation: nodes in order, a register is free again
/// after the last instruction that reads it.
struct Assembly<'a> {
    graph: &'a Graph,
    /// How often each node is still to be read, by instructions and by outputs.
    reads: Vec<usize>,
    place: Vec<usize>,
    free: Vec<usize>,
    registers: usize,
    instructions: Vec<Instruction>,
}

impl<'a> Assembly<'a> {
    fn new(graph: &'a Graph, roots: &[Id]) -> Self {
        let mut reads = vec![0; graph.len()];
        for &root in roots {
            reads[root] += 1;
        }
        for id in graph.order(roots) {
            if let Node::Apply(op, arguments) = graph.node(id) {
                arguments[..op.arity()].iter().for_each(|&argument| reads[argument] += 1);
            }
        }
        let place = vec![0; graph.len()];
        Self { graph, reads, place, free: Vec::new(), registers: 0, instructions: Vec::new() }
    }

    fn run(&mut self, roots: &[Id]) {
        // Outputs of each node; its instruction writes the only use of it directly.
        let mut outputs: Vec<Vec<usize>> = vec![Vec::new(); self.graph.len()];
        for (output, &root) in roots.iter().enumerate() {
            outputs[root].push(output);
        }
        for id in self.graph.order(roots) {
            let applied = match self.graph.node(id) {
                Node::Apply(op, arguments) => Some((op, arguments)),
                _ => None,
            };
            if let (Some((op, arguments)), [output], 1) =
                (applied, &outputs[id][..], self.reads[id])
            {
                self.push(op, Target::Output(*output), &arguments[..op.arity()]);
                continue;
            }
            if let Some((op, arguments)) = applied {
                let register = self.free.pop().unwrap_or(self.registers);
                self.registers = self.registers.max(register + 1);
                self.push(op, Target::Register(register), &arguments[..op.arity()]);
                self.place[id] = register;
            }
            for &output in &outputs[id] {
                self.push(Op::Copy, Target::Output(output), &[id]);
            }
        }
    }

    /// Appends an instruction, and frees the registers that it is the last to read.
    fn push(&mut self, op: Op, target: Target, arguments: &[Id]) {
        let mut sources = [Source::Constant(0); 3];
        for (source, &id) in sources.iter_mut().zip(arguments) {
            *source = match self.graph.node(id) {
                Node::Constant(bits) => Source::Constant(bits),
                Node::Variable(index) => Source::Input(index),
                Node::Apply(..) => Source::Register(self.place[id]),
            };
        }
        self.instructions.push(Instruction { op, target, arguments: sources });
        for &id in arguments {
            self.reads[id] -= 1;
            if self.reads[id] == 0 && matches!(self.graph.node(id), Node::Apply(..)) {
                self.free.push(self.place[id]);
            }
        }
    }
}
