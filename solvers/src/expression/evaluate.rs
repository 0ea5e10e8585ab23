//! Running a program: chunks of nodes, an operation at a time.

use super::op::{Op, whole_exponent, whole_power};
use super::program::{Program, Source, Target};

/// Nodes per chunk: ten registers of 2 kB stay in the first-level cache, and 64 vectors
/// per operation hide the choice of its code.
const LANES: usize = 256;

/// Values of a variable.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// The same at every node.
    Uniform(f64),
    /// One value per node.
    Slice(&'a [f64]),
}

/// Work space of [`Program::evaluate`]; it grows in the first call and can serve any program.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    registers: Vec<Vec<f64>>,
    /// Values of registers that are the same at every node.
    uniform: Vec<Option<f64>>,
    steps: Vec<Step>,
}

/// Where the argument of a step is.
#[derive(Clone, Copy, Debug)]
enum Argument {
    Uniform(f64),
    Input(usize),
    Register(usize),
}

/// An instruction that remains when everything uniform has been computed.
#[derive(Clone, Copy, Debug)]
struct Step {
    code: Code,
    target: Target,
    arguments: [Argument; 3],
}

#[derive(Clone, Copy, Debug)]
enum Code {
    Op(Op),
    WholePower(i32),
}

/// The argument of a step on one chunk.
#[derive(Clone, Copy)]
enum Lanes<'a> {
    Uniform(f64),
    Slice(&'a [f64]),
}

impl Lanes<'_> {
    fn at(self, i: usize) -> f64 {
        match self {
            Self::Uniform(value) => value,
            Self::Slice(values) => values[i],
        }
    }
}

impl Program {
    /// Writes the values of expression `k` to `outputs[k]`.
    ///
    /// `inputs` are the variables in order; their slices and the outputs have one length.
    /// What depends on uniform inputs alone is computed once per call. Allocates nothing
    /// when `scratch` has served this program before. Cost: [`Program::operations`] passes
    /// over vectors in the first-level cache per 256 nodes.
    ///
    /// # Panics
    /// If the number of inputs or outputs is not the program's, or their lengths differ.
    pub fn evaluate(
        &self,
        inputs: &[Input<'_>],
        outputs: &mut [&mut [f64]],
        scratch: &mut Scratch,
    ) {
        assert_eq!(inputs.len(), self.inputs, "inputs of the program");
        assert_eq!(outputs.len(), self.outputs, "outputs of the program");
        let Some(n) = outputs.first().map(|output| output.len()) else { return };
        assert!(outputs.iter().all(|output| output.len() == n), "outputs differ in length");
        let fits = |input: &Input<'_>| matches!(input, Input::Slice(s) if s.len() != n);
        assert!(!inputs.iter().any(fits), "inputs differ in length from the outputs");
        self.resolve(inputs, scratch);
        let Scratch { registers, steps, .. } = scratch;
        if registers.len() < self.registers {
            registers.resize_with(self.registers, || vec![0.0; LANES]);
        }
        pulp::Arch::new().dispatch(Chunks { steps, inputs, outputs, registers, n });
    }

    /// Computes what is uniform and lists the steps that remain.
    fn resolve(&self, inputs: &[Input<'_>], scratch: &mut Scratch) {
        let Scratch { uniform, steps, .. } = scratch;
        uniform.clear();
        uniform.resize(self.registers, None);
        steps.clear();
        for instruction in &self.instructions {
            let arguments = instruction.arguments.map(|source| match source {
                Source::Constant(bits) => Argument::Uniform(f64::from_bits(bits)),
                Source::Input(k) => match inputs[k] {
                    Input::Uniform(value) => Argument::Uniform(value),
                    Input::Slice(_) => Argument::Input(k),
                },
                Source::Register(k) => uniform[k].map_or(Argument::Register(k), Argument::Uniform),
            });
            let mut step =
                Step { code: Code::Op(instruction.op), target: instruction.target, arguments };
            let value = known(instruction.op, arguments);
            match (instruction.target, value) {
                (Target::Register(k), _) => uniform[k] = value,
                (Target::Output(_), Some(value)) => {
                    step.code = Code::Op(Op::Copy);
                    step.arguments[0] = Argument::Uniform(value);
                }
                _ => {}
            }
            if let (Op::Power, Argument::Uniform(y)) = (instruction.op, arguments[1])
                && let Some(n) = whole_exponent(y)
                && value.is_none()
            {
                step.code = Code::WholePower(n);
            }
            if value.is_none() || matches!(instruction.target, Target::Output(_)) {
                steps.push(step);
            }
        }
    }
}

/// The value of an operation all of whose arguments are uniform.
fn known(op: Op, arguments: [Argument; 3]) -> Option<f64> {
    let mut values = [0.0; 3];
    for (value, argument) in values.iter_mut().zip(&arguments[..op.arity()]) {
        let Argument::Uniform(number) = argument else { return None };
        *value = *number;
    }
    Some(op.apply(values))
}

/// The loop over chunks, compiled for each vector unit.
struct Chunks<'a, 'i, 'o> {
    steps: &'a [Step],
    inputs: &'a [Input<'i>],
    outputs: &'a mut [&'o mut [f64]],
    registers: &'a mut [Vec<f64>],
    n: usize,
}

impl pulp::NullaryFnOnce for Chunks<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { steps, inputs, outputs, registers, n } = self;
        for start in (0..n).step_by(LANES) {
            let lanes = LANES.min(n - start);
            for step in steps {
                match step.target {
                    Target::Register(k) => {
                        // No step reads its own target, so it may be gone meanwhile.
                        let mut target = std::mem::take(&mut registers[k]);
                        run(step, inputs, registers, start, &mut target[..lanes]);
                        registers[k] = target;
                    }
                    Target::Output(k) => {
                        run(step, inputs, registers, start, &mut outputs[k][start..start + lanes]);
                    }
                }
            }
        }
    }
}

/// One step on one chunk.
#[inline(always)]
fn run(step: &Step, inputs: &[Input<'_>], registers: &[Vec<f64>], start: usize, out: &mut [f64]) {
    let n = out.len();
    let lanes = |argument: Argument| match argument {
        Argument::Uniform(value) => Lanes::Uniform(value),
        Argument::Register(k) => Lanes::Slice(&registers[k][..n]),
        Argument::Input(k) => match inputs[k] {
            Input::Uniform(value) => Lanes::Uniform(value),
            Input::Slice(values) => Lanes::Slice(&values[start..start + n]),
        },
    };
    let [a, b, c] = step.arguments;
    // Each arm is its own loop with the operation in line.
    macro_rules! arms {
        ($($arity:ident: $($op:ident)*;)*) => {
            match step.code {
                $($(Code::Op(Op::$op) => arms!(@$arity Op::$op),)*)*
                Code::Op(Op::Where) => choose(lanes(a), lanes(b), lanes(c), out),
                Code::Op(op) => call(op, [a, b, c].map(lanes), out),
                Code::WholePower(exponent) => raise(exponent, lanes(a), out),
            }
        };
        (@one $op:expr) => { one(lanes(a), out, #[inline(always)] |a| $op.apply([a, 0.0, 0.0])) };
        (@two $op:expr) => {
            two(lanes(a), lanes(b), out, #[inline(always)] |a, b| $op.apply([a, b, 0.0]))
        };
    }
    arms! {
        one: Copy Negate Abs Sqrt Floor Ceil Round Sign;
        two: Add Subtract Multiply Divide Min Max Less LessEqual Greater GreaterEqual Equal;
    }
}

#[inline(always)]
fn one(a: Lanes<'_>, out: &mut [f64], f: impl Fn(f64) -> f64) {
    match a {
        Lanes::Uniform(a) => out.fill(f(a)),
        Lanes::Slice(a) => {
            for (out, &a) in out.iter_mut().zip(a) {
                *out = f(a);
            }
        }
    }
}

#[inline(always)]
fn two(a: Lanes<'_>, b: Lanes<'_>, out: &mut [f64], f: impl Fn(f64, f64) -> f64) {
    match (a, b) {
        (Lanes::Uniform(a), b) => one(
            b,
            out,
            #[inline(always)]
            |b| f(a, b),
        ),
        (a, Lanes::Uniform(b)) => one(
            a,
            out,
            #[inline(always)]
            |a| f(a, b),
        ),
        (Lanes::Slice(a), Lanes::Slice(b)) => {
            for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
                *out = f(a, b);
            }
        }
    }
}

/// `where(c, a, b)`.
#[inline(always)]
fn choose(c: Lanes<'_>, a: Lanes<'_>, b: Lanes<'_>, out: &mut [f64]) {
    #[inline(always)]
    fn pick(c: f64, a: f64, b: f64) -> f64 {
        Op::Where.apply([c, a, b])
    }
    match (c, a, b) {
        (Lanes::Uniform(c), a, b) => two(
            a,
            b,
            out,
            #[inline(always)]
            |a, b| pick(c, a, b),
        ),
        (c, Lanes::Uniform(a), b) => two(
            c,
            b,
            out,
            #[inline(always)]
            |c, b| pick(c, a, b),
        ),
        (c, a, Lanes::Uniform(b)) => two(
            c,
            a,
            out,
            #[inline(always)]
            |c, a| pick(c, a, b),
        ),
        (Lanes::Slice(c), Lanes::Slice(a), Lanes::Slice(b)) => {
            for (((out, &c), &a), &b) in out.iter_mut().zip(c).zip(a).zip(b) {
                *out = pick(c, a, b);
            }
        }
    }
}

/// Operations that are calls of functions for single numbers; outside of the code for
/// vector units, from which such calls are slow.
#[inline(never)]
fn call(op: Op, [a, b, c]: [Lanes<'_>; 3], out: &mut [f64]) {
    macro_rules! arms {
        ($($arity:ident: $($op:ident)*;)*) => {
            match op {
                $($(Op::$op => arms!(@$arity Op::$op),)*)*
                _ => {
                    for (i, out) in out.iter_mut().enumerate() {
                        *out = op.apply([a.at(i), b.at(i), c.at(i)]);
                    }
                }
            }
        };
        (@one $op:expr) => { one(a, out, |a| $op.apply([a, 0.0, 0.0])) };
        (@two $op:expr) => { two(a, b, out, |a, b| $op.apply([a, b, 0.0])) };
    }
    arms! {
        one: Exp Log Log10 Sin Cos Tan Asin Acos Atan Sinh Cosh Tanh;
        two: Power Atan2 Hypot;
    }
}

/// Powers by multiplications, eight lanes side by side.
#[inline(always)]
fn raise(exponent: i32, x: Lanes<'_>, out: &mut [f64]) {
    let Lanes::Slice(x) = x else { return };
    let (groups, rest) = out.as_chunks_mut::<8>();
    let (x, last) = x.as_chunks::<8>();
    for (out, x) in groups.iter_mut().zip(x) {
        *out = whole_power(exponent, *x);
    }
    for (out, &x) in rest.iter_mut().zip(last) {
        *out = whole_power(exponent, [x])[0];
    }
}
