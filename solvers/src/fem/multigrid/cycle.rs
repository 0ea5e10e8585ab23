//! The hierarchy of levels and its V-cycle.

use super::Options;
use super::coarsest::Coarsest;
use super::constraints::Constraints;
use super::fine::Fine;
use super::first::First;
use super::galerkin::Elements;
use super::lattice::{Lattice, Layout};
use super::level::{Level, Operator};
use super::stencil::Stencil;
use super::transfer::Transfer;
use crate::Result;
use std::sync::Arc;

/// Smallest stiffness in the preconditioner, relative to the largest: less could leave the
/// range of 4-byte numbers.
const SMALLEST: f64 = 1e-30;

/// All levels, the finest first.
pub(super) struct Hierarchy {
    pub levels: Vec<Level>,
    coarsest: Coarsest,
    /// From each of `levels` to the next or the coarsest.
    pub transfers: Vec<Transfer>,
    /// Of all levels but the finest.
    pub elements: Vec<Elements>,
    pub constraints: Arc<Constraints>,
    ke: Vec<f64>,
    fixed: Vec<bool>,
    springs: Vec<f64>,
}

/// Lattices of all levels.
pub(super) fn lattices(lattice: Lattice, components: usize, options: &Options) -> Vec<Lattice> {
    let limit = options.coarsest(&lattice, components);
    let mut all = vec![lattice, lattice.coarser()];
    loop {
        let last = all[all.len() - 1];
        let unknowns = last.node_count() * components;
        if unknowns <= limit || last.coarser() == last {
            return all;
        }
        all.push(last.coarser());
    }
}

impl Hierarchy {
    /// `ke` and `springs` are scaled so that the largest entry of `ke` is 1.
    pub(super) fn new(
        lattice: Lattice,
        components: usize,
        ke: &[f64],
        fixed: &[bool],
        springs: &[f64],
        options: Options,
    ) -> Result<Self> {
        let lattices = lattices(lattice, components, &options);
        let layouts: Vec<_> = lattices.iter().map(|&l| Layout::new(l, components)).collect();
        let constraints = Arc::new(Constraints::new(&layouts[0], fixed, &[]));
        let mut elements =
            vec![Elements::First(Box::new(First::new(lattice, components, ke, fixed, springs)))];
        while elements.len() + 1 < lattices.len() {
            elements.push(elements[elements.len() - 1].coarser(components));
        }
        let coarsest = Coarsest::new(layouts[layouts.len() - 1], &elements[elements.len() - 1])?;
        let operator = |(index, &layout): (usize, &Layout)| match index {
            0 => Operator::Fine(Fine::new(layout, ke, constraints.clone())),
            _ => Operator::Stencil(Stencil::new(layout)),
        };
        let above = layouts[..layouts.len() - 1].iter().enumerate();
        Ok(Self {
            levels: above.map(|l| Level::new(operator(l), options.degree)).collect(),
            coarsest,
            transfers: layouts.windows(2).map(|pair| Transfer::new(pair[0], pair[1])).collect(),
            elements,
            constraints,
            ke: ke.to_vec(),
            fixed: fixed.to_vec(),
            springs: springs.to_vec(),
        })
    }

    /// Rebuilds all levels for new stiffness of the elements, all above 0.
    pub(super) fn update(&mut self, stiffness: &[f64]) -> Result<()> {
        let scale = 1.0 / stiffness.iter().copied().fold(0.0, f64::max);
        let springs: Vec<f64> = self.springs.iter().map(|s| s * scale).collect();
        let layout = self.levels[0].layout;
        self.constraints = Arc::new(Constraints::new(&layout, &self.fixed, &springs));
        let finest = &mut self.levels[0];
        if let Operator::Fine(fine) = &mut finest.operator {
            fine.set_constraints(self.constraints.clone());
            fine.set_stiffness(stiffness, scale, SMALLEST);
            fine.inverse_diagonal(&self.ke, &mut finest.inverse_diagonal);
        }
        if let Elements::First(first) = &mut self.elements[0] {
            first.update(stiffness, scale, &self.fixed, &springs);
        }
        for index in 1..self.elements.len() {
            let (finer, coarser) = self.elements.split_at_mut(index);
            coarser[0].gather(&finer[index - 1], layout.components);
        }
        for (level, elements) in self.levels[1..].iter_mut().zip(&self.elements) {
            if let Operator::Stencil(stencil) = &mut level.operator {
                elements.assemble(stencil, &mut level.inverse_diagonal);
            }
        }
        for level in &mut self.levels {
            level.estimate_radius();
        }
        self.coarsest.update(&self.elements[self.elements.len() - 1])
    }

    /// The solution's approximation `x` for the finest level's `b`.
    pub(super) fn precondition(&mut self) {
        self.cycle(0);
    }

    fn cycle(&mut self, index: usize) {
        self.levels[index].relax(true);
        self.levels[index].residual();
        let (finer, coarser) = self.levels.split_at_mut(index + 1);
        let level = &mut finer[index];
        let transfer = &mut self.transfers[index];
        if let Some(next) = coarser.first_mut() {
            transfer.restrict(&level.r, &mut next.b);
            self.cycle(index + 1);
        } else {
            transfer.restrict(&level.r, &mut self.coarsest.b);
            self.coarsest.solve();
        }
        let (finer, coarser) = self.levels.split_at_mut(index + 1);
        let level = &mut finer[index];
        let correction = coarser.first().map_or(&self.coarsest.x, |next| &next.x);
        let fixed = (index == 0).then_some(&self.constraints.fixed);
        self.transfers[index].prolong(correction, &mut level.x, |row, x| {
            for &place in fixed.map_or(&[][..], |fixed| fixed.row(row)) {
                x[place as usize] = 0.0;
            }
        });
        level.relax(false);
    }

    /// Stored entries of the coarsest level's factor.
    pub(super) fn factor_entries(&self) -> usize {
        self.coarsest.entries()
    }
}
