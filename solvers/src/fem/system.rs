//! What is solved: mesh, element, supports and springs.

use super::{Element, Lattice};
use crate::{Error, Result};
use rayon::prelude::*;

/// Elements whose energies one task computes: large enough to hide its cost.
const CHUNK: usize = 1024;

/// A structure whose element stiffnesses are still open.
#[derive(Clone, Debug)]
pub struct System {
    lattice: Lattice,
    /// [`Lattice::offsets`]: asked for at every element.
    offsets: [usize; 8],
    element: Element,
    fixed: Vec<bool>,
    springs: Vec<f64>,
}

impl System {
    /// A structure with `fixed` unknowns and a spring to the ground at each unknown
    /// (`springs`, force/length, at least 0; empty for none).
    ///
    /// # Errors
    /// If a length is not that of the unknowns, or a spring is negative or not finite.
    pub fn new(
        lattice: Lattice,
        element: Element,
        fixed: Vec<bool>,
        springs: Vec<f64>,
    ) -> Result<Self> {
        let unknowns = lattice.node_count() * element.components();
        for (name, length) in [("fixed", fixed.len()), ("springs", springs.len())] {
            if length != unknowns && !(name == "springs" && length == 0) {
                return Err(Error::Shape {
                    name: name.into(),
                    actual: vec![length],
                    expected: vec![unknowns],
                });
            }
        }
        if let Some(&bad) = springs.iter().find(|&&k| !(k >= 0.0 && k.is_finite())) {
            return Err(Error::out_of_range("spring", bad, "[0, inf)"));
        }
        Ok(Self { lattice, offsets: lattice.offsets(), element, fixed, springs })
    }

    /// The mesh.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The element.
    pub fn element(&self) -> &Element {
        &self.element
    }

    /// Whether each unknown is prescribed.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Springs to the ground, one per unknown, or none at all.
    pub fn springs(&self) -> &[f64] {
        &self.springs
    }

    /// The same structure with one more unknown fixed.
    pub fn with_fixed(mut self, unknown: usize) -> Self {
        self.fixed[unknown] = true;
        self
    }

    /// Number of unknowns, fixed ones included.
    pub fn unknowns(&self) -> usize {
        self.fixed.len()
    }

    /// Copies the values at an element's nodes into `local`.
    #[inline]
    pub fn gather(&self, element: usize, values: &[f64], local: &mut [f64]) {
        let components = self.element.components();
        let first = self.lattice.first_node(element);
        for (node, chunk) in self.offsets.iter().zip(local.chunks_exact_mut(components)) {
            let at = (first + node) * components;
            chunk.copy_from_slice(&values[at..at + components]);
        }
    }

    /// `u_e^T K_e v_e` of every element (energy at stiffness 1), elements in parallel.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn energies(&self, u: &[f64], v: &[f64], energies: &mut [f64]) {
        assert_eq!(energies.len(), self.lattice.element_count(), "one energy per element");
        let n = self.element.unknowns();
        energies.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, energies)| {
            let (mut local_u, mut local_v) = ([0.0; 24], [0.0; 24]);
            for (m, energy) in energies.iter_mut().enumerate() {
                let element = chunk * CHUNK + m;
                self.gather(element, u, &mut local_u[..n]);
                self.gather(element, v, &mut local_v[..n]);
                *energy = self.element.energy(&local_u[..n], &local_v[..n]);
            }
        });
    }

    /// `product = K(stiffness) u`, springs included, of all unknowns, fixed ones too.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn multiply(&self, stiffness: &[f64], u: &[f64], product: &mut [f64]) {
        let (n, components) = (self.element.unknowns(), self.element.components());
        product.fill(0.0);
        product.iter_mut().zip(&self.springs).zip(u).for_each(|((p, k), u)| *p = k * u);
        let mut local = [0.0; 24];
        for (element, &scale) in stiffness.iter().enumerate() {
            self.gather(element, u, &mut local[..n]);
            let first = self.lattice.first_node(element);
            for (r, row) in self.element.stiffness().chunks_exact(n).enumerate() {
                let node = first + self.offsets[r / components];
                let force: f64 = row.iter().zip(&local).map(|(k, u)| k * u).sum();
                product[node * components + r % components] += scale * force;
            }
        }
    }
}
