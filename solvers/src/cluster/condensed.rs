//! The hierarchy of clusters without those that are too small, and the best of them.

use super::Clusters;
use super::spanning_tree::Edge;

/// A cluster of the hierarchy; `lambda` is a density, the inverse of a distance.
#[derive(Clone, Debug)]
struct Cluster {
    parent: Option<usize>,
    /// Density at which it splits off.
    birth: f64,
    /// Sum over its points of how far in density they stay with it.
    stability: f64,
    /// Greatest density at which points leave it, also for two clusters within it.
    death: f64,
}

/// The clusters of at least some size, and where each point leaves them.
pub(super) struct CondensedTree {
    /// Parents come before their children; the first is the root.
    clusters: Vec<Cluster>,
    /// For each point the last cluster that it is in, and the density at which it leaves that.
    leaves: Vec<(usize, f64)>,
}

/// Two nodes of the single-linkage tree that merge; nodes below `n` are points.
struct Merge {
    parts: [usize; 2],
    distance: f64,
    size: usize,
}

/// The single-linkage tree of edges sorted by length; merge k makes node n + k.
fn single_linkage(n: usize, edges: &[Edge]) -> Vec<Merge> {
    let mut parent: Vec<usize> = (0..2 * n).collect();
    let mut merges: Vec<Merge> = Vec::with_capacity(edges.len());
    let mut find = |mut i: usize, new: usize| {
        while parent[i] != i {
            let next = parent[i];
            parent[i] = new;
            i = next;
        }
        parent[i] = new;
        i
    };
    for (k, &(a, b, distance)) in edges.iter().enumerate() {
        let parts = [a, b].map(|i| find(i, n + k));
        let size = |i: usize| if i < n { 1 } else { merges[i - n].size };
        let size = size(parts[0]) + size(parts[1]);
        merges.push(Merge { parts, distance, size });
    }
    merges
}

impl CondensedTree {
    pub(super) fn new(n: usize, edges: &[Edge], min_size: usize) -> Self {
        let merges = single_linkage(n, edges);
        let root = Cluster { parent: None, birth: 0.0, stability: 0.0, death: 0.0 };
        let mut tree = Self { clusters: vec![root], leaves: vec![(0, f64::INFINITY); n] };
        let size = |node: usize| if node < n { 1 } else { merges[node - n].size };
        let mut open = vec![((n + merges.len()).saturating_sub(1), 0)];
        while let Some((node, cluster)) = open.pop() {
            if node < n {
                continue;
            }
            let Merge { parts, distance, .. } = merges[node - n];
            let lambda = 1.0 / distance;
            let split = parts.iter().all(|&part| size(part) >= min_size);
            for part in parts {
                if split {
                    tree.leave(cluster, lambda, size(part));
                    let parent = Some(cluster);
                    let (birth, death) = (lambda, lambda);
                    tree.clusters.push(Cluster { parent, birth, stability: 0.0, death });
                    open.push((part, tree.clusters.len() - 1));
                } else if size(part) >= min_size {
                    open.push((part, cluster));
                } else {
                    tree.leave(cluster, lambda, size(part));
                    tree.drop_points(part, cluster, lambda, &merges);
                }
            }
        }
        tree
    }

    /// `count` points leave `cluster` at density `lambda`.
    fn leave(&mut self, cluster: usize, lambda: f64, count: usize) {
        let cluster = &mut self.clusters[cluster];
        // Points at one place have an infinite density: they never leave, not even from birth.
        if lambda > cluster.birth {
            cluster.stability += (lambda - cluster.birth) * count as f64;
        }
        cluster.death = cluster.death.max(lambda);
    }

    fn drop_points(&mut self, node: usize, cluster: usize, lambda: f64, merges: &[Merge]) {
        let n = self.leaves.len();
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            match node.checked_sub(n) {
                None => self.leaves[node] = (cluster, lambda),
                Some(merge) => open.extend(merges[merge].parts),
            }
        }
    }

    /// The clusters, none inside another, whose stabilities have the greatest sum.
    fn select(&self) -> Vec<bool> {
        let mut within = vec![0.0; self.clusters.len()];
        let mut chosen = vec![false; self.clusters.len()];
        for (c, cluster) in self.clusters.iter().enumerate().skip(1).rev() {
            chosen[c] = cluster.stability >= within[c];
            let best = cluster.stability.max(within[c]);
            within[cluster.parent.unwrap_or(0)] += best;
        }
        // Inside a chosen cluster nothing else is.
        let mut covered = vec![false; self.clusters.len()];
        for (c, cluster) in self.clusters.iter().enumerate().skip(1) {
            let parent = cluster.parent.unwrap_or(0);
            covered[c] = covered[parent] || chosen[parent];
            chosen[c] &= !covered[c];
        }
        chosen
    }

    pub(super) fn clusters(&self) -> Clusters {
        let chosen = self.select();
        let mut numbers = vec![None; self.clusters.len()];
        let mut count = 0;
        let (labels, strengths) = self
            .leaves
            .iter()
            .map(|&(last, lambda)| {
                let mut cluster = Some(last);
                while let Some(c) = cluster.filter(|&c| !chosen[c]) {
                    cluster = self.clusters[c].parent;
                }
                let Some(c) = cluster else { return (None, 0.0) };
                let label = *numbers[c].get_or_insert_with(|| {
                    count += 1;
                    count - 1
                });
                let death = self.clusters[c].death;
                let strength = if lambda < death { lambda / death } else { 1.0 };
                (Some(label), strength)
            })
            .unzip();
        Clusters { labels, strengths, count }
    }
}
