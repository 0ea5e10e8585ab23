//! Gradients of the densities against differences.

use super::*;

/// Gradients by the design variables against central differences.
#[test]
fn gradients_agree_with_differences() {
    let project = "projection = { beta = 4.0, beta_max = 4.0, delta = 0.2 }";
    let mma = "optimizer = 'mma'";
    let cases = [
        ("mbb", "filter = 'density'".to_owned()),
        ("mbb", format!("filter = 'helmholtz'\n{mma}\n{project}")),
        ("mbb", "filter = 'none'\ninterpolation = 'ramp'".to_owned()),
        ("mbb", "problem.body_force = [0.01, 0.02]\nfilter = 'density'".to_owned()),
        (
            "cantilever",
            "problem.support = [{ edge = 'left' }, { node = [33, 1], fix = 'y', value = [0.0, 0.5] }]\n\
             filter = 'density'"
                .to_owned(),
        ),
        ("row-h", format!("filter = 'density'\ncases = 'worst'\n{mma}")),
        ("force-inverter", "filter = 'density'".to_owned()),
        ("heat-sink", "filter = 'density'".to_owned()),
        ("l-bracket", format!("objective = 'stress'\n{mma}")),
        ("cantilever", "filter = 'density'\nproblem.symmetry = ['y']".to_owned()),
        ("row-h", "filter = 'helmholtz'\nproblem.symmetry = ['x', 'y']".to_owned()),
        (
            "mbb",
            format!(
                "filter = 'density'\nproblem.symmetry = ['x']\n{mma}\n\
                 projection = {{ beta = 2.0 }}\n\
                 problem.passive = [{{ box = [[5.0, 5.0], [9.0, 9.0]], material = 'solid' }}]"
            ),
        ),
        (
            "cantilever-3d",
            "filter = 'density'\nproblem.elements = [6, 4, 3]\n\
            problem.load = [{ nodes = [[7, 5, 1], [7, 5, 4]], force = [0.0, 1.0, 0.5] }]"
                .to_owned(),
        ),
    ];
    for (name, settings) in &cases {
        let config: Config = crate::from_table(&table(name, settings)).unwrap();
        let problem = Problem::new(&config, &context()).unwrap();
        let solver = LinearSolver::new(&problem.system, Choice::Direct, 1 << 33).unwrap();
        let mut analysis = Analysis::new(&problem, solver);
        let mut design = Design::new(&config, &problem).unwrap();
        let n = problem.grid.len();
        let mut rho = vec![0.0; n];
        let beta = config.projection.map_or(0.0, |projection| projection.beta);
        let count = simp::groups(&config, &problem);
        let law = Law::new(&config, config.penalization);
        let mut at = |x: &[f64]| {
            let (analysis, design, rho) = (&mut analysis, &mut design, &mut rho[..]);
            let (config, problem, tolerance) = (&config, &problem, 1e-10);
            let mut functions = Functions::new(count, n);
            Evaluator { config, problem, analysis, design, law, beta, tolerance, rho }
                .evaluate(x, &mut functions)
                .unwrap();
            functions
        };
        let mut x: Vec<f64> =
            (0..n).map(|e| 0.3 + 0.4 * ((e * 7919 % 101) as f64 / 101.0)).collect();
        for (e, x) in x.iter_mut().enumerate().filter(|(e, _)| problem.passive[*e].is_some()) {
            *x = f64::from(u8::from(problem.passive[e] == Some(Material::Solid)));
        }
        problem.symmetrize(&mut x);
        let functions = at(&x);
        let free: Vec<usize> = (0..n).filter(|&e| problem.passive[e].is_none()).collect();
        for &e in &[free[0], free[free.len() / 2], free[free.len() / 3]] {
            // Fourth order: at the second either round-off or the next term is too large.
            const STEP: f64 = 1e-4;
            // Along a direction as symmetric as the designs: shares that add up to 1.
            let mut along = vec![0.0; n];
            along[e] = 1.0;
            problem.symmetrize(&mut along);
            let mut moved = |step: f64| {
                let x: Vec<f64> = x.iter().zip(&along).map(|(x, d)| x + step * d).collect();
                at(&x)
            };
            let points = [-2.0, -1.0, 1.0, 2.0].map(|n| moved(n * STEP));
            for (k, (value, gradient)) in functions.objectives.iter().enumerate() {
                let [a, b, c, d] = points.each_ref().map(|point| point.objectives[k].0);
                let difference = (8.0 * (c - b) - (d - a)) / (12.0 * STEP);
                let scale = gradient.iter().fold(value.abs() * 1e-6, |a, g| a.max(g.abs()));
                let error = (difference - gradient[e]).abs() / scale;
                assert!(error < 2e-6, "{name} {settings}: {difference} {}", gradient[e]);
            }
        }
    }
}
