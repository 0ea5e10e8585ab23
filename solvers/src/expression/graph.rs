//! Formulas as graphs in which equal subexpressions are one node.

use super::op::Op;
use std::collections::BTreeMap;

/// Index of a node.
pub(super) type Id = usize;

/// A node; arguments stand before it in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Node {
    /// The bits of a number.
    Constant(u64),
    /// A variable, by its place in the list of names.
    Variable(usize),
    /// An operation; arguments that it does not take are 0.
    Apply(Op, [Id; 3]),
}

/// Nodes, each of them once.
#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    known: BTreeMap<Node, Id>,
}

impl Graph {
    pub(super) fn node(&self, id: Id) -> Node {
        self.nodes[id]
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The number that a node stands for, if it is one.
    pub(super) fn number(&self, id: Id) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(super) fn constant(&mut self, value: f64) -> Id {
        // There is one NaN, whatever made it.
        let value = if value.is_nan() { f64::NAN } else { value };
        let node = Node::Constant(value.to_bits());
        self.insert(node, node)
    }

    pub(super) fn variable(&mut self, index: usize) -> Id {
        let node = Node::Variable(index);
        self.insert(node, node)
    }

    /// An operation on nodes. Numbers are folded, by the code that would run on them
    /// later; nothing else is rewritten, so no bit of a result changes.
    pub(super) fn apply(&mut self, op: Op, arguments: &[Id]) -> Id {
        let mut ids = [0; 3];
        ids[..arguments.len()].copy_from_slice(arguments);
        let mut values = [0.0; 3];
        let numbers = arguments.iter().zip(&mut values);
        if numbers.fold(true, |all, (&id, value)| match self.number(id) {
            Some(number) => {
                *value = number;
                all
            }
            None => false,
        }) {
            return self.constant(op.apply(values));
        }
        let mut key = ids;
        if op.commutes() {
            key[..2].sort_unstable();
        }
        self.insert(Node::Apply(op, key), Node::Apply(op, ids))
    }

    fn insert(&mut self, key: Node, node: Node) -> Id {
        let next = self.nodes.len();
        let id = *self.known.entry(key).or_insert(next);
        if id == next {
            self.nodes.push(node);
        }
        id
    }

    /// Every node that the roots need, arguments first, in the order in which the text
    /// names them; so it depends on the formulas alone and not on how the graph grew.
    pub(super) fn order(&self, roots: &[Id]) -> Vec<Id> {
        let mut order = Vec::new();
        let mut done = vec![false; self.nodes.len()];
        let mut open: Vec<(Id, bool)> = roots.iter().rev().map(|&id| (id, false)).collect();
        while let Some((id, arguments_done)) = open.pop() {
            if done[id] {
                continue;
            }
            match self.nodes[id] {
                Node::Apply(op, arguments) if !arguments_done => {
                    open.push((id, true));
                    open.extend(arguments[..op.arity()].iter().rev().map(|&id| (id, false)));
                }
                _ => {
                    done[id] = true;
                    order.push(id);
                }
            }
        }
        order
    }

    /// Takes over what the roots of `other` need, node by node through `rewrite`, and
    /// returns their new places.
    pub(super) fn import(
        &mut self,
        other: &Graph,
        root: Id,
        mut rewrite: impl FnMut(&mut Self, Op, &[Id]) -> Id,
    ) -> Id {
        let mut place = vec![0; other.len()];
        for id in other.order(&[root]) {
            place[id] = match other.node(id) {
                Node::Constant(bits) => self.constant(f64::from_bits(bits)),
                Node::Variable(index) => self.variable(index),
                Node::Apply(op, arguments) => {
                    let arguments = arguments.map(|id| place[id]);
                    rewrite(self, op, &arguments[..op.arity()])
                }
            };
        }
        place[root]
    }
}
