//! The network simplex on a complete bipartite graph (Dantzig 1951; Cunningham 1976).
//!
//! The basis is a tree over rows and columns, rooted at the last node of the start. It stays
//! *strongly feasible*: an edge that carries nothing points towards the root (its row is the child).
//! With the rule for the leaving edge below this rules out cycling, however degenerate the masses.

use super::constants::{PRICED_EDGES, REDUCED_COST_TOLERANCE};
use super::pricing::{max_abs, min_reduced_cost};
use crate::mixture::instructions::{InstructionSet, SimdKernel};

/// No node: the root's parent, or the end of a list of children.
const NONE: u32 = u32::MAX;

/// Nodes `0..m` are rows, `m..m + n` columns. Masses are all positive.
pub(super) struct Simplex<'a> {
    m: usize,
    n: usize,
    costs: &'a [f64],
    root: usize,
    links: Vec<TreeLinks>,
    /// Flow on the edge to the parent.
    flow: Vec<f64>,
    /// Duals: rows u, columns v; on the tree u + v = cost.
    potential: Vec<f64>,
    /// Buffer of walks over the tree.
    walk: Vec<u32>,
    tolerance: f64,
}

/// Links of a node in the tree.
#[derive(Clone, Copy)]
struct TreeLinks {
    parent: u32,
    first_child: u32,
    /// Siblings.
    next: u32,
    previous: u32,
    /// Nodes of the subtree, itself included.
    size: u32,
}

impl<'a> Simplex<'a> {
    /// Greedy start: each row in turn takes its cheapest open column, by costs less `prices`, one per column: with the duals
    /// of a similar problem as prices, few pivots are left. Exactly one line closes per step, a column on ties, which makes
    /// the tree strongly feasible.
    pub(super) fn new(
        rows: &[f64],
        columns: &[f64],
        costs: &'a [f64],
        prices: Option<&[f64]>,
    ) -> Self {
        let (m, n) = (rows.len(), columns.len());
        let alone = TreeLinks {
            parent: NONE,
            first_child: NONE,
            next: NONE,
            previous: NONE,
            size: 1,
        };
        let mut simplex = Self {
            m,
            n,
            costs,
            root: m,
            links: vec![alone; m + n],
            flow: vec![0.0; m + n],
            potential: vec![0.0; m + n],
            walk: Vec::with_capacity(m + n),
            tolerance: REDUCED_COST_TOLERANCE * max_abs(costs),
        };
        let mut open: Vec<usize> = (0..n).collect();
        let mut left = columns.to_vec();
        for (row, &mass) in rows.iter().enumerate() {
            let mut rest = mass;
            loop {
                let price = |c: usize| prices.map_or(0.0, |prices| prices[c]);
                let cost = |c: usize| costs[row * n + c] - price(c);
                let cheapest =
                    (0..open.len()).min_by(|&a, &b| cost(open[a]).total_cmp(&cost(open[b])));
                let Some(at) = cheapest else { break };
                let column = open[at];
                simplex.root = m + column;
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
        simplex.recompute_potentials();
        for at in (1..simplex.walk.len()).rev() {
            let node = simplex.links[simplex.walk[at] as usize];
            simplex.links[node.parent as usize].size += node.size;
        }
        simplex
    }

    #[inline(always)]
    fn attach(&mut self, child: usize, parent: usize, flow: f64) {
        self.flow[child] = flow;
        let head = self.links[parent].first_child;
        let links = &mut self.links[child];
        (links.parent, links.next, links.previous) = (parent as u32, head, NONE);
        if head != NONE {
            self.links[head as usize].previous = child as u32;
        }
        self.links[parent].first_child = child as u32;
    }

    #[inline(always)]
    fn detach(&mut self, child: usize) {
        let TreeLinks {
            parent,
            next,
            previous,
            ..
        } = self.links[child];
        match previous {
            NONE => self.links[parent as usize].first_child = next,
            _ => self.links[previous as usize].next = next,
        }
        if next != NONE {
            self.links[next as usize].previous = previous;
        }
    }

    #[inline(always)]
    fn cost(&self, a: usize, b: usize) -> f64 {
        let (row, column) = if a < b { (a, b) } else { (b, a) };
        self.costs[row * self.n + column - self.m]
    }

    /// Potentials of the whole tree from its costs; pivots only shift them, which accumulates rounding.
    /// Leaves all nodes in `walk`, parents before children.
    #[inline(always)]
    fn recompute_potentials(&mut self) {
        self.walk.clear();
        self.walk.push(self.root as u32);
        let mut at = 0;
        while let Some(&node) = self.walk.get(at) {
            let node = node as usize;
            let mut child = self.links[node].first_child;
            while child != NONE {
                self.potential[child as usize] =
                    self.cost(child as usize, node) - self.potential[node];
                self.walk.push(child);
                child = self.links[child as usize].next;
            }
            at += 1;
        }
    }

    /// Pivots until no edge has a negative reduced cost; the number of pivots, as an error if it reaches `max_pivots`.
    pub(super) fn solve(&mut self, max_pivots: usize) -> Result<usize, usize> {
        InstructionSet::best().run(PivotLoop {
            simplex: self,
            max_pivots,
        })
    }

    /// Block search: the best edge of the next block of rows that has any worth entering, with its reduced cost.
    #[inline(always)]
    fn entering<const LANES: usize>(
        &self,
        row: &mut usize,
        block: usize,
    ) -> Option<(usize, usize, f64)> {
        let columns = &self.potential[self.m..];
        let mut best = None;
        let mut least = -self.tolerance;
        let mut in_block = 0;
        for _ in 0..self.m {
            let u = self.potential[*row];
            let costs = &self.costs[*row * self.n..(*row + 1) * self.n];
            let price = min_reduced_cost::<LANES>(costs, columns) - u;
            if price < least {
                (best, least) = (Some(*row), price);
            }
            *row = if *row + 1 == self.m { 0 } else { *row + 1 };
            in_block += 1;
            if in_block == block {
                if best.is_some() {
                    break;
                }
                in_block = 0;
            }
        }
        let row = best?;
        let u = self.potential[row];
        let costs = &self.costs[row * self.n..(row + 1) * self.n];
        let at = costs
            .iter()
            .zip(columns)
            .position(|(c, v)| (c - v) - u <= least)?;
        Some((row, at, least))
    }

    /// Brings edge (row, column) into the tree; `price` is its reduced cost.
    #[inline(always)]
    fn pivot(&mut self, row: usize, column: usize, price: f64) {
        // Along the cycle flow goes from the apex down to the row, over the new edge, and up from
        // the column. Edges run row -> column, so it is against the edge, and takes flow off it,
        // above a row on the row's side and above a column on the column's side. The last edge that
        // would run dry, counted from the apex, leaves.
        let (mut a, mut b) = (row, column);
        let (mut row_side, mut column_side) = ((f64::INFINITY, 0), (f64::INFINITY, 0));
        while a != b {
            // The smaller tree cannot hold the other node.
            if self.links[a].size < self.links[b].size {
                // Last on the way down is the deepest, met first here: strictly less.
                if a < self.m && self.flow[a] < row_side.0 {
                    row_side = (self.flow[a], a);
                }
                a = self.links[a].parent as usize;
            } else {
                // Last on the way up is the highest: less or equal.
                if b >= self.m && self.flow[b] <= column_side.0 {
                    column_side = (self.flow[b], b);
                }
                b = self.links[b].parent as usize;
            }
        }
        let apex = a;
        // The column's side comes after the row's.
        let (theta, leaving, row_falls) = if row_side.0 < column_side.0 {
            (row_side.0, row_side.1, true)
        } else {
            (column_side.0, column_side.1, false)
        };
        let moved = self.links[leaving].size;
        for (start, loses_if_row) in [(row, true), (column, false)] {
            let falls = loses_if_row == row_falls;
            let (mut node, mut below) = (start, falls);
            while node != apex {
                if (node < self.m) == loses_if_row {
                    self.flow[node] -= theta;
                } else {
                    self.flow[node] += theta;
                }
                // What falls leaves all above it on this side and comes to all on the other.
                if !falls {
                    self.links[node].size += moved;
                } else if !below {
                    self.links[node].size -= moved;
                }
                below &= node != leaving;
                node = self.links[node].parent as usize;
            }
        }
        // The part below the leaving edge hangs from the new edge's end that lies in it.
        let (inside, outside) = if row_falls {
            (row, column)
        } else {
            (column, row)
        };
        let (mut node, mut parent, mut flow, mut below) = (inside, outside, theta, 0);
        loop {
            let (old_parent, old_flow) = (self.links[node].parent as usize, self.flow[node]);
            let old_size = self.links[node].size;
            self.detach(node);
            self.attach(node, parent, flow);
            self.links[node].size = moved - below;
            if node == leaving {
                break;
            }
            (parent, node, flow, below) = (node, old_parent, old_flow, old_size);
        }
        // Shifting the potentials on either side of the new edge makes its reduced cost zero: the smaller side is shifted.
        let all = self.links.len() as u32;
        let to_rows = if row_falls { price } else { -price };
        if 2 * moved <= all {
            self.shift(inside, NONE, to_rows);
        } else {
            self.shift(self.root, inside as u32, -to_rows);
        }
    }

    /// Adds `to_rows` to the potentials of rows below `top` and subtracts it from those of columns, except below `except`.
    #[inline(always)]
    fn shift(&mut self, top: usize, except: u32, to_rows: f64) {
        self.walk.clear();
        self.walk.push(top as u32);
        while let Some(node) = self.walk.pop() {
            let sign = if (node as usize) < self.m {
                to_rows
            } else {
                -to_rows
            };
            self.potential[node as usize] += sign;
            let mut child = self.links[node as usize].first_child;
            while child != NONE {
                if child != except {
                    self.walk.push(child);
                }
                child = self.links[child as usize].next;
            }
        }
    }

    /// Edges with positive flow: (row, column, flow).
    pub(super) fn flows(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.m + self.n).filter_map(|node| {
            let (parent, flow) = (self.links[node].parent, self.flow[node]);
            let (row, column) = if node < self.m {
                (node, parent as usize)
            } else {
                (parent as usize, node)
            };
            (parent != NONE && flow > 0.0).then(|| (row, column - self.m, flow))
        })
    }

    /// Duals of the columns; the dual of a row is the least of its costs less these.
    pub(super) fn column_duals(&self) -> &[f64] {
        &self.potential[self.m..]
    }
}

/// The loop of [`Simplex::solve`].
struct PivotLoop<'s, 'a> {
    simplex: &'s mut Simplex<'a>,
    max_pivots: usize,
}

impl SimdKernel for PivotLoop<'_, '_> {
    type Output = Result<usize, usize>;

    #[inline(always)]
    fn run<const FUSED: bool, const LANES: usize>(self) -> Result<usize, usize> {
        let Self {
            simplex,
            max_pivots,
        } = self;
        let nodes = simplex.m + simplex.n;
        let block = (PRICED_EDGES / simplex.n).clamp(1, simplex.m.div_ceil(2));
        let (mut row, mut pivots, mut shifts) = (0, 0, 0);
        loop {
            let Some((r, c, price)) = simplex.entering::<LANES>(&mut row, block) else {
                if shifts == 0 {
                    return Ok(pivots);
                }
                simplex.recompute_potentials();
                shifts = 0;
                continue;
            };
            if pivots == max_pivots {
                return Err(pivots);
            }
            simplex.pivot(r, simplex.m + c, price);
            pivots += 1;
            shifts += 1;
            if shifts == nodes {
                simplex.recompute_potentials();
                shifts = 0;
            }
        }
    }
}
