//! The network simplex on a complete bipartite graph (Dantzig 1951; Cunningham 1976).
//!
//! The basis is a tree over rows and columns, rooted at the last node of the start. It stays
//! *strongly feasible*: an edge that carries nothing points towards the root (its row is the child).
//! With the rule for the leaving edge below this rules out cycling, however degenerate the masses.

use super::constants::PRICE_SLACK;

/// Marks the root's parent and the end of a list of children.
const NONE: usize = usize::MAX;

/// Nodes `0..m` are rows, `m..m + n` columns. Masses are all positive.
pub(super) struct Simplex<'a> {
    m: usize,
    n: usize,
    costs: &'a [f64],
    parent: Vec<usize>,
    /// Flow on the edge to the parent.
    flow: Vec<f64>,
    depth: Vec<usize>,
    /// Duals: rows u, columns v; on the tree u + v = cost.
    potential: Vec<f64>,
    first_child: Vec<usize>,
    next: Vec<usize>,
    previous: Vec<usize>,
    stack: Vec<usize>,
    slack: f64,
}

impl<'a> Simplex<'a> {
    /// Greedy start: each row in turn takes its cheapest open column. Exactly one line closes per
    /// step, a column on ties, which makes the tree strongly feasible.
    pub(super) fn new(rows: &[f64], columns: &[f64], costs: &'a [f64]) -> Self {
        let (m, n) = (rows.len(), columns.len());
        let mut simplex = Self {
            m,
            n,
            costs,
            parent: vec![NONE; m + n],
            flow: vec![0.0; m + n],
            depth: vec![0; m + n],
            potential: vec![0.0; m + n],
            first_child: vec![NONE; m + n],
            next: vec![NONE; m + n],
            previous: vec![NONE; m + n],
            stack: Vec::with_capacity(m + n),
            slack: PRICE_SLACK * costs.iter().fold(0.0, |a: f64, c| a.max(c.abs())),
        };
        let mut open: Vec<usize> = (0..n).collect();
        let mut left = columns.to_vec();
        let mut root = m;
        for (row, &mass) in rows.iter().enumerate() {
            let mut rest = mass;
            loop {
                let cost = |c: usize| costs[row * n + c];
                let cheapest =
                    (0..open.len()).min_by(|&a, &b| cost(open[a]).total_cmp(&cost(open[b])));
                let Some(at) = cheapest else { break };
                let column = open[at];
                root = m + column;
                let last_row = row + 1 == m;
                let close_row = if open.len() == 1 && last_row {
                    true
                } else {
                    !last_row && (open.len() == 1 || rest < left[column])
                };
                if close_row {
                    simplex.attach(row, m + column, rest);
                    left[column] = (left[column] - rest).max(0.0);
                    break;
                }
                simplex.attach(m + column, row, left[column]);
                rest = (rest - left[column]).max(0.0);
                open.swap_remove(at);
            }
        }
        simplex.refresh(root);
        simplex
    }

    fn attach(&mut self, child: usize, parent: usize, flow: f64) {
        self.parent[child] = parent;
        self.flow[child] = flow;
        let head = self.first_child[parent];
        self.next[child] = head;
        self.previous[child] = NONE;
        if head != NONE {
            self.previous[head] = child;
        }
        self.first_child[parent] = child;
    }

    fn detach(&mut self, child: usize) {
        let (before, after) = (self.previous[child], self.next[child]);
        match before {
            NONE => self.first_child[self.parent[child]] = after,
            _ => self.next[before] = after,
        }
        if after != NONE {
            self.previous[after] = before;
        }
    }

    fn cost(&self, a: usize, b: usize) -> f64 {
        let (row, column) = if a < b { (a, b) } else { (b, a) };
        self.costs[row * self.n + column - self.m]
    }

    /// Depths and potentials of everything below `top`, from its own.
    fn refresh(&mut self, top: usize) {
        self.stack.push(top);
        while let Some(node) = self.stack.pop() {
            let mut child = self.first_child[node];
            while child != NONE {
                self.depth[child] = self.depth[node] + 1;
                self.potential[child] = self.cost(child, node) - self.potential[node];
                self.stack.push(child);
                child = self.next[child];
            }
        }
    }

    /// Pivots until no edge is worth entering; gives the number of pivots, or that of the cap.
    pub(super) fn solve(&mut self, cap: usize) -> Result<usize, usize> {
        let mut row = 0;
        let mut pivots = 0;
        let block = ((self.m * self.n) as f64).sqrt() as usize / self.n + 1;
        while let Some((r, c)) = self.entering(&mut row, block) {
            if pivots == cap {
                return Err(pivots);
            }
            self.pivot(r, self.m + c);
            pivots += 1;
        }
        Ok(pivots)
    }

    /// Block search: the best edge of the next rows that have any worth entering.
    fn entering(&self, row: &mut usize, block: usize) -> Option<(usize, usize)> {
        let columns = &self.potential[self.m..];
        let mut best = (-self.slack, None);
        for scanned in 1..=self.m {
            let u = self.potential[*row];
            let costs = &self.costs[*row * self.n..(*row + 1) * self.n];
            let (price, column) = cheapest(costs, columns);
            if price - u < best.0 {
                best = (price - u, Some((*row, column)));
            }
            *row = if *row + 1 == self.m { 0 } else { *row + 1 };
            if scanned % block == 0 && best.1.is_some() {
                break;
            }
        }
        best.1
    }

    /// Brings edge (row, column) into the tree.
    fn pivot(&mut self, row: usize, column: usize) {
        // Along the cycle flow goes from the apex down to the row, over the new edge, and up from
        // the column. Edges run row -> column, so it is against the edge, and takes flow off it,
        // above a row on the row's side and above a column on the column's side. The last edge that
        // would run dry, counted from the apex, leaves.
        let (mut a, mut b) = (row, column);
        let (mut row_side, mut column_side) = ((f64::INFINITY, NONE), (f64::INFINITY, NONE));
        while a != b {
            if self.depth[a] >= self.depth[b] {
                // Last on the way down is the deepest, met first here: strictly less.
                if a < self.m && self.flow[a] < row_side.0 {
                    row_side = (self.flow[a], a);
                }
                a = self.parent[a];
            } else {
                // Last on the way up is the highest: less or equal.
                if b >= self.m && self.flow[b] <= column_side.0 {
                    column_side = (self.flow[b], b);
                }
                b = self.parent[b];
            }
        }
        let apex = a;
        // The column's side comes after the row's.
        let (theta, leaving, row_falls) = if row_side.0 < column_side.0 {
            (row_side.0, row_side.1, true)
        } else {
            (column_side.0, column_side.1, false)
        };
        for (start, loses_if_row) in [(row, true), (column, false)] {
            let mut node = start;
            while node != apex {
                if (node < self.m) == loses_if_row {
                    self.flow[node] -= theta;
                } else {
                    self.flow[node] += theta;
                }
                node = self.parent[node];
            }
        }
        // The part below the leaving edge hangs from the new edge's end that lies in it.
        let (inside, outside) = if row_falls {
            (row, column)
        } else {
            (column, row)
        };
        let (mut node, mut parent, mut flow) = (inside, outside, theta);
        loop {
            let (old_parent, old_flow) = (self.parent[node], self.flow[node]);
            self.detach(node);
            self.attach(node, parent, flow);
            if node == leaving {
                break;
            }
            (parent, node, flow) = (node, old_parent, old_flow);
        }
        self.depth[inside] = self.depth[outside] + 1;
        self.potential[inside] = self.cost(row, column) - self.potential[outside];
        self.refresh(inside);
    }

    /// Edges that carry something: (row, column, flow).
    pub(super) fn flows(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.m + self.n).filter_map(|node| {
            let (parent, flow) = (self.parent[node], self.flow[node]);
            let (row, column) = if node < self.m {
                (node, parent)
            } else {
                (parent, node)
            };
            (parent != NONE && flow > 0.0).then(|| (row, column - self.m, flow))
        })
    }

    /// Row and column duals.
    pub(super) fn duals(&self) -> (&[f64], &[f64]) {
        self.potential.split_at(self.m)
    }
}

/// Smallest `costs - columns` and where; lanes side by side first, the place only afterwards.
fn cheapest(costs: &[f64], columns: &[f64]) -> (f64, usize) {
    const LANES: usize = 8;
    let mut low = [f64::INFINITY; LANES];
    let (c, v) = (costs.chunks_exact(LANES), columns.chunks_exact(LANES));
    let tail = c.remainder().iter().zip(v.remainder());
    let mut best = tail.fold(f64::INFINITY, |a, (c, v)| a.min(c - v));
    for (c, v) in c.zip(v) {
        for lane in 0..LANES {
            let price = c[lane] - v[lane];
            low[lane] = if price < low[lane] { price } else { low[lane] };
        }
    }
    best = low.into_iter().fold(best, f64::min);
    let at = costs.iter().zip(columns).position(|(c, v)| c - v <= best);
    (best, at.unwrap_or(0))
}
