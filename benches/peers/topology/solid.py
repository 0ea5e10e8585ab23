"""Three iterations of the 96 x 48 x 48 cantilever of `patterns bench topopt --large` by pyMOTO's multigrid-CG.

    python benches/peers/topology/solid.py     # in an environment with pymoto 2.0.1

Prints CPU seconds of each iteration on one thread; the first one sets up the restrictions.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
os.environ["MPLBACKEND"] = "agg"

import time
import warnings

import numpy as np
import pymoto as pym

SIZE = (96, 48, 48)
VOLFRAC, RMIN, PENAL, EMIN, NU, MOVE = 0.3, 1.5, 3.0, 1e-9, 0.3, 0.2
TOLERANCE = 1e-5
ITERATIONS = 4


def multigrid(domain, levels):
    """V-cycles down to a grid that is factorized."""
    if levels == 0:
        return None
    inner = multigrid(
        pym.VoxelDomain(domain.nelx // 2, domain.nely // 2, domain.nelz // 2, 2 * domain.unitx, 2 * domain.unity, 2 * domain.unitz),
        levels - 1,
    )
    return pym.solvers.GeometricMultigrid(domain, inner_level=inner)


def main():
    warnings.simplefilter("ignore")
    domain = pym.VoxelDomain(*SIZE)
    wall = domain.nodes[0, :, :].ravel()
    supports = np.concatenate([3 * wall, 3 * wall + 1, 3 * wall + 2])
    load = np.zeros(3 * domain.nnodes)
    edge = domain.nodes[SIZE[0], SIZE[1], :].ravel()
    load[3 * edge + 1] = 1.0 / edge.size
    x = pym.Signal("x", state=np.full(domain.nel, VOLFRAC))
    solver = pym.solvers.CG(preconditioner=multigrid(domain, 4), tol=TOLERANCE)
    with pym.Network() as network:
        filtered = pym.DensityFilter(domain, radius=RMIN)(x)
        moduli = pym.MathExpression(f"{EMIN} + {1.0 - EMIN}*inp0^{PENAL:.0f}")(filtered)
        stiffness = pym.AssembleStiffness(domain, bc=supports, e_modulus=1.0, poisson_ratio=NU)(moduli)
        u = pym.LinSolve(symmetric=True, positive_definite=True, solver=solver)(stiffness, load)
        compliance = pym.EinSum("i,i->")(u, load)
    optimizer = pym.OC(x, compliance, network, move=MOVE, xmin=0.0, xmax=1.0, verbosity=0)
    values = x.state
    for iteration in range(ITERATIONS):
        start = time.process_time()
        values, response, _ = optimizer.step(values)
        seconds = time.process_time() - start
        print(f"iteration {iteration + 1}: compliance {float(np.ravel(response)[0]):.4f}, {seconds:.1f} CPU s", flush=True)


main()
