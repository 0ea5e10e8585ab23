//! The search on landscapes that need no growing.

use super::*;

/// Two valleys: the search begins in both and ends in the deeper one, though the start in the
/// other is nearer.
struct Valleys {
    config: Config,
    /// In the shallow valley, in the deep one, in neither.
    starts: [[f64; 6]; 3],
}

impl Valleys {
    fn new(starts: usize) -> Self {
        let config = Config { starts, generations: 32, ..Config::default() };
        let starts = [0.3, 0.7, 0.05].map(|t| parameters(&config, &[t; 5], -0.4));
        Self { config, starts }
    }

    fn away(&self, p: &[f64; 6], t: f64) -> f64 {
        let square = |x: f64| (x - t) * (x - t);
        part(&self.config, p).into_iter().map(square).sum::<f64>().sqrt()
    }

    fn value(&self, p: &[f64; 6]) -> f64 {
        (0.15 + self.away(p, 0.32)).min(0.01 + self.away(p, 0.85))
    }

    fn search(&self) -> Search {
        let mut search = Search::new(&self.config, &self.starts, -0.4);
        while search.told.len() <= self.config.generations as usize {
            let points = search.ask(&self.config, 5);
            assert!(points.iter().all(|p| p[5] == -0.4), "{points:?}");
            let values = points.iter().map(|p| self.value(p)).collect();
            search.tell(&self.config, 5, &points, values).unwrap();
        }
        search
    }
}

#[test]
fn the_search_ends_at_the_best_of_its_starts() {
    let two = Valleys::new(2);
    assert!(two.value(&two.starts[0]) < two.value(&two.starts[1]));
    let search = two.search();
    let best = search.best().unwrap();
    let one = Valleys::new(1).search().best().unwrap().distance;
    assert!(best.distance < 0.05 && one > 0.1, "{} {one}", best.distance);
    // All that follows the first half is near the best.
    let late = search.candidates.iter().filter(|c| c.generation > 16);
    assert_eq!(late.clone().count(), 16 * 8);
    assert!(late.clone().all(|c| two.away(&c.parameters, 0.3) > 0.4));
}

/// What lets the ranges be trusted: where only the sum of two parameters tells, each is found to be
/// free, though the starts lie on one side.
#[test]
fn ranges_tell_what_is_not_known() {
    let config = Config { starts: 2, generations: 32, ..Config::default() };
    let starts = [0.6, 0.7, 0.65].map(|t| parameters(&config, &[t; 5], -0.4));
    let mut search = Search::new(&config, &starts, -0.4);
    let away = |point: &[f64]| {
        let others = point[2..].iter().map(|x| (x - 0.6).powi(2)).sum::<f64>();
        0.1 + ((point[0] + point[1] - 1.2).powi(2) + others).sqrt()
    };
    while search.told.len() <= 32 {
        let points = search.ask(&config, 5);
        let values = points.iter().map(|p| away(&part(&config, p))).collect();
        search.tell(&config, 5, &points, values).unwrap();
    }
    let (list, ranges) = (config.ranges.list(), search.ranges(0.2));
    let width = |k: usize| (ranges[k][1] - ranges[k][0]) / (list[k][1] - list[k][0]);
    let widths = [0, 1, 2, 3, 4].map(width);
    // .1 on either side of the best is let pass: one that is known has at most .2.
    assert!(widths[..2].iter().all(|w| *w > 0.3), "{widths:?}");
    assert!(widths[2..].iter().all(|w| *w > 0.1), "{widths:?}");
}

#[test]
fn a_search_is_taken_up_where_it_was() {
    let valleys = Valleys::new(3);
    let search = valleys.search();
    for until in [0, 1, 9, 20, 30] {
        let mut again = Search::new(&valleys.config, &valleys.starts, -0.4);
        for values in &search.told[..until] {
            again.repeat(&valleys.config, 5, values.clone()).unwrap();
        }
        let next = search.candidates.iter().filter(|c| c.generation == until);
        let next: Vec<[f64; 6]> = next.map(|c| c.parameters).collect();
        assert_eq!(again.ask(&valleys.config, 5), next, "{until}");
        assert!(again.repeat(&valleys.config, 5, vec![1.0]).is_err());
    }
}
