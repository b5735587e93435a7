//! Large systems of equations whose far blocks are products of thin matrices: factors without all elements.
//!
//! Unknowns stand at nodes of the plane. Halving the nodes by place gives a tree; the blocks between the two halves of each
//! part are low-rank products UVᵀ (adaptive cross approximation, Bebendorf 2000, made as thin as the tolerance allows), and the
//! inverse follows from the leaves up by Sherman, Morrison and Woodbury's formula (Ambikasaran and Darve 2013). Products are
//! held in single precision, whose roundings are hundreds of times smaller than what they leave out. Memory and time grow with the nodes times the rank and
//! its square, so that long thin bodies, whose rank does not grow with their length, cost little more per node.

mod crosses;

use num_complex::Complex64;
use rayon::prelude::*;

use self::crosses::Crosses;
use super::dense::Dense;
use super::large::LargeFactors;
use super::single::{Single, exact, rounded};
use crate::progress::{Progress, Unobserved};
use crate::{Error, Result};

/// Most nodes of a leaf.
const LEAF_NODES: usize = 160;

/// Columns that one task solves for: fixed, so that results do not depend on the number of threads.
const TASK: usize = 48;

/// Targets next to a cut, and in all, that an approximation is examined at, beside those of groups.
const SAMPLES: usize = 64;

/// Nodes of a half from which on its two products are made one after the other: crosses are in double precision, and more of
/// them than are left in the end.
const LARGE: usize = 16_384;

/// Crosses in a row that must be negligible before an approximation is examined.
const QUIET_CROSSES: usize = 2;

/// The elements of a system: a square block for each pair of nodes.
pub trait Blocks: Sync {
    /// Unknowns of a node.
    fn components(&self) -> usize;
    /// Where each node is.
    fn places(&self) -> Vec<[f64; 2]>;
    /// Nodes of a group see the same others; approximations are examined at some of each.
    fn group(&self, node: usize) -> usize;
    /// Writes the block of a target and a source, row by row; `false` where all of it is zero.
    fn block(&self, target: usize, source: usize, block: &mut [Complex64]) -> bool;
}

/// A system in factors.
pub struct HierarchicalFactors {
    /// The node at each place of the tree's order.
    order: Vec<usize>,
    components: usize,
    root: Part,
    bytes: u64,
    largest_rank: usize,
}

/// A part of the nodes, contiguous in the tree's order.
enum Part {
    Leaf(LargeFactors),
    /// diag(A₁, A₂)(1 + [0, W₁V₁ᵀ; W₂V₂ᵀ, 0]).
    Halves {
        halves: Box<[Part; 2]>,
        first: usize,
        w: [Single; 2],
        v: [Single; 2],
        middle: LargeFactors,
    },
}

/// Which nodes a part has, and its halves.
struct Tree {
    from: usize,
    to: usize,
    halves: Option<Box<[Tree; 2]>>,
    cut: Cut,
}

/// The line between two halves: its axis, 0 for x, and the place on it.
#[derive(Debug, Clone, Copy)]
struct Cut {
    axis: usize,
    at: f64,
}

/// Two thin matrices.
struct Product {
    u: Single,
    v: Single,
}

impl HierarchicalFactors {
    /// Factors of a system whose diagonal is about 1 and whose far blocks may be off by `tolerance` (as norms of crosses).
    /// Below 1e-6 roundings of single precision take over.
    ///
    /// # Errors
    /// The system is singular, the factors would take more than `bytes`, or the user cancelled.
    pub fn new(blocks: &dyn Blocks, tolerance: f64, bytes: u64, progress: &dyn Progress) -> Result<Self> {
        let places = blocks.places();
        let mut order: Vec<usize> = (0..places.len()).collect();
        let tree = split(&mut order, 0, &places);
        let builder = Builder {
            blocks,
            order: &order,
            places: &places,
            components: blocks.components(),
            tolerance,
            progress,
            bytes,
        };
        progress.begin("factoring", builder.order.len() as u64 * u64::from(depth(&tree)));
        let built = builder.part(&tree)?;
        Ok(Self {
            components: builder.components,
            root: built.part,
            bytes: built.bytes,
            largest_rank: built.rank,
            order,
        })
    }

    /// Bytes of the factors.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The largest rank of a block.
    #[must_use]
    pub fn largest_rank(&self) -> usize {
        self.largest_rank
    }

    /// b ← A⁻¹ b, rows node by node.
    pub fn solve(&self, b: &mut Dense) {
        let m = self.components;
        let mut sorted = Dense::zeros(b.rows(), b.columns());
        for k in 0..b.columns() {
            let (from, to) = (b.column(k), sorted.column_mut(k));
            for (place, &node) in self.order.iter().enumerate() {
                to[place * m..][..m].copy_from_slice(&from[node * m..][..m]);
            }
        }
        self.root.solve(&mut sorted);
        for k in 0..b.columns() {
            let (from, to) = (sorted.column(k), b.column_mut(k));
            for (place, &node) in self.order.iter().enumerate() {
                to[node * m..][..m].copy_from_slice(&from[place * m..][..m]);
            }
        }
    }
}

impl Part {
    /// b ← A⁻¹ b in the tree's order, columns in parallel.
    fn solve(&self, b: &mut Dense) {
        let rows = b.rows();
        if b.columns() <= TASK {
            self.solve_few(b);
            return;
        }
        b.elements_mut().par_chunks_mut(TASK * rows).for_each(|columns| {
            let mut few = Dense::from_columns(rows, columns.to_vec());
            self.solve_few(&mut few);
            columns.copy_from_slice(few.elements());
        });
    }

    /// w ← A⁻¹ w, some columns of it at a time in double precision.
    fn solve_single(&self, w: &mut Single) {
        let rows = w.rows();
        w.elements_mut().par_chunks_mut(TASK * rows).for_each(|columns| {
            let mut few = Dense::from_columns(rows, columns.iter().map(|&value| exact(value)).collect());
            self.solve_few(&mut few);
            columns.iter_mut().zip(few.elements()).for_each(|(value, &solved)| *value = rounded(solved));
        });
    }

    fn solve_few(&self, b: &mut Dense) {
        match self {
            Self::Leaf(factors) => factors.solve(b),
            Self::Halves { halves, first, w, v, middle } => {
                let rest = b.rows() - first;
                let mut parts = [b.block(0, 0, *first, b.columns()), b.block(*first, 0, rest, b.columns())];
                for (half, part) in halves.iter().zip(&mut parts) {
                    half.solve_few(part);
                }
                // (1 + ṼᵀW̃) z = Ṽᵀy, x = y − W̃z; V₁ belongs to the second half's unknowns.
                let mut z = v[0].transposed_times(&parts[1]).above(&v[1].transposed_times(&parts[0]));
                middle.solve(&mut z);
                let ranks = [w[0].columns(), w[1].columns()];
                let lower = z.block(ranks[0], 0, ranks[1], z.columns());
                let upper = z.block(0, 0, ranks[0], z.columns());
                w[0].take_product_from(&upper, &mut parts[0]);
                w[1].take_product_from(&lower, &mut parts[1]);
                b.set_block(0, &parts[0]);
                b.set_block(*first, &parts[1]);
            }
        }
    }
}

/// A part with its size.
struct Built {
    part: Part,
    bytes: u64,
    rank: usize,
}

struct Builder<'a> {
    blocks: &'a dyn Blocks,
    order: &'a [usize],
    places: &'a [[f64; 2]],
    components: usize,
    tolerance: f64,
    progress: &'a dyn Progress,
    /// How many bytes there may be in all.
    bytes: u64,
}

impl Builder<'_> {
    fn part(&self, tree: &Tree) -> Result<Built> {
        if self.progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let nodes = tree.to - tree.from;
        let Some(halves) = &tree.halves else {
            let matrix = self.dense(tree);
            self.progress.advance(nodes as u64);
            if !matrix.is_finite() {
                return Err(Error::not_settled("the elements of a system of equations are not finite"));
            }
            let bytes = 16 * (matrix.rows() * matrix.columns()) as u64;
            return Ok(Built { part: Part::Leaf(LargeFactors::new(matrix, &Unobserved)?), bytes, rank: 0 });
        };
        let (first, second) = rayon::join(|| self.part(&halves[0]), || self.part(&halves[1]));
        let (first, second) = (first?, second?);
        let upper = || self.product(&halves[0], &halves[1], tree.cut);
        let lower = || self.product(&halves[1], &halves[0], tree.cut);
        let (upper, lower) = if nodes > 2 * LARGE { (upper(), lower()) } else { rayon::join(upper, lower) };
        let (upper, lower) = (upper?, lower?);
        let size = |product: &Product| product.u.bytes() + product.v.bytes();
        let between = 16 * (upper.u.columns() + lower.u.columns()).pow(2) as u64;
        let bytes = first.bytes + second.bytes + size(&upper) + size(&lower) + between;
        if bytes > self.bytes {
            return Err(Error::machine(
                "the factors of a system of equations do not fit into the memory allowed",
            ));
        }
        let rank = upper.u.columns().max(lower.u.columns()).max(first.rank).max(second.rank);
        let mut w = [upper.u, lower.u];
        for (part, w) in [&first.part, &second.part].into_iter().zip(&mut w) {
            part.solve_single(w);
        }
        let v = [upper.v, lower.v];
        let ranks = [w[0].columns(), w[1].columns()];
        let mut middle = Dense::identity(ranks[0] + ranks[1]);
        let (left, right) = middle.elements_mut().split_at_mut((ranks[0] + ranks[1]) * ranks[0]);
        rayon::join(|| fill(left, &v[1], &w[0], ranks[0]), || fill(right, &v[0], &w[1], 0));
        self.progress.advance(nodes as u64);
        let rows = w[0].rows();
        let halves = Box::new([first.part, second.part]);
        let part =
            Part::Halves { halves, first: rows, w, v, middle: LargeFactors::new(middle, &Unobserved)? };
        Ok(Built { part, bytes, rank })
    }

    fn dense(&self, tree: &Tree) -> Dense {
        let (m, nodes) = (self.components, tree.to - tree.from);
        let mut matrix = Dense::zeros(nodes * m, nodes * m);
        let mut block = vec![Complex64::ZERO; m * m];
        for source in 0..nodes {
            for target in 0..nodes {
                if !self.blocks.block(
                    self.order[tree.from + target],
                    self.order[tree.from + source],
                    &mut block,
                ) {
                    continue;
                }
                for (row, values) in block.chunks_exact(m).enumerate() {
                    for (column, value) in values.iter().enumerate() {
                        matrix[(target * m + row, source * m + column)] = *value;
                    }
                }
            }
        }
        matrix
    }

    /// The block of two parts as a product, by crosses of a target's rows and a source's columns.
    fn product(&self, targets: &Tree, sources: &Tree, cut: Cut) -> Result<Product> {
        let mut crosses = Crosses::new(self, targets, sources);
        let mut unexamined = self.samples(targets, cut);
        let mut quiet = 0;
        let mut next = unexamined.pop();
        while let Some(target) = next {
            if self.progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let (is_quiet, best) = crosses.add(target);
            quiet = if is_quiet { quiet + 1 } else { 0 };
            next = match best {
                Some(best) if quiet < QUIET_CROSSES => Some(best),
                _ => {
                    // Groups that no cross has seen yet may hide more.
                    let found = loop {
                        match unexamined.pop() {
                            Some(target) if crosses.is_approximated(target) => {}
                            found => break found,
                        }
                    };
                    quiet = 0;
                    found
                }
            };
        }
        Ok(crosses.finish())
    }

    /// Targets at which an approximation is examined: those next to the cut between the parts, where elements are largest
    /// and most local; of each group three from near to far; and some of all.
    fn samples(&self, targets: &Tree, cut: Cut) -> Vec<usize> {
        let mut near: Vec<(f64, usize)> = (targets.from..targets.to)
            .map(|place| ((self.places[self.order[place]][cut.axis] - cut.at).abs(), place))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut groups: std::collections::BTreeMap<usize, Vec<usize>> = std::collections::BTreeMap::new();
        for &(_, place) in &near {
            groups.entry(self.blocks.group(self.order[place])).or_default().push(place);
        }
        let step = (near.len() / SAMPLES).max(1);
        let mut samples: Vec<usize> = near.iter().step_by(step).map(|&(_, place)| place).collect();
        for group in groups.values() {
            samples.extend([group[group.len() / 2], group[group.len() / 8], group[0]]);
        }
        samples.extend(near.iter().take(SAMPLES).map(|&(_, place)| place));
        let mut seen = std::collections::BTreeSet::new();
        // The last is examined first.
        samples.reverse();
        samples.retain(|place| seen.insert(*place));
        samples.reverse();
        samples
    }
}

/// VᵀW into columns from a row on; W's first column is theirs.
fn fill(columns: &mut [Complex64], v: &Single, w: &Single, row: usize) {
    if w.columns() == 0 {
        return;
    }
    let size = columns.len() / w.columns();
    let product = v.transposed_times_single(w);
    for (k, column) in columns.chunks_exact_mut(size).enumerate() {
        column[row..row + v.columns()].copy_from_slice(product.column(k));
    }
}

/// Halves nodes along the longer side of their box, in place.
fn split(order: &mut [usize], from: usize, places: &[[f64; 2]]) -> Tree {
    let to = from + order.len();
    if order.len() <= LEAF_NODES {
        return Tree { from, to, halves: None, cut: Cut { axis: 0, at: 0.0 } };
    }
    let extent = |axis: usize| {
        let values = order.iter().map(|&node| places[node][axis]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let axis = usize::from(extent(1)[1] - extent(1)[0] > extent(0)[1] - extent(0)[0]);
    order.sort_by(|&a, &b| places[a][axis].total_cmp(&places[b][axis]).then(a.cmp(&b)));
    let middle = order.len() / 2;
    let cut = Cut { axis, at: places[order[middle]][axis] };
    let (left, right) = order.split_at_mut(middle);
    let halves = [split(left, from, places), split(right, from + middle, places)];
    Tree { from, to, halves: Some(Box::new(halves)), cut }
}

fn depth(tree: &Tree) -> u32 {
    tree.halves.as_ref().map_or(1, |halves| 1 + depth(&halves[0]).max(depth(&halves[1])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Unobserved;

    /// Nodes on two lines that see each other, and on a third that only sees itself.
    struct Lines;

    impl Lines {
        fn at(node: usize) -> [f64; 2] {
            [(node / 3) as f64 * 0.01, (node % 3) as f64]
        }
    }

    impl Blocks for Lines {
        fn components(&self) -> usize {
            2
        }

        fn places(&self) -> Vec<[f64; 2]> {
            (0..900).map(Self::at).collect()
        }

        fn group(&self, node: usize) -> usize {
            node % 3
        }

        fn block(&self, target: usize, source: usize, block: &mut [Complex64]) -> bool {
            if (target % 3 == 2) != (source % 3 == 2) {
                return false;
            }
            let (a, b) = (Self::at(target), Self::at(source));
            let r = libm::hypot(a[0] - b[0], a[1] - b[1]) + 0.02;
            let wave = Complex64::from_polar(0.01 / r.sqrt(), 9.0 * r);
            block.copy_from_slice(&[wave, 0.3 * wave * (a[0] - b[0]), wave * wave, 0.5 * wave]);
            if target == source {
                block[0] += 1.0;
                block[3] += 1.0;
            }
            true
        }
    }

    #[test]
    fn factors_solve_what_all_elements_say() {
        let full = |row: usize, column: usize| {
            let mut block = [Complex64::ZERO; 4];
            Lines.block(row / 2, column / 2, &mut block);
            block[(row % 2) * 2 + column % 2]
        };
        let matrix = Dense::from_fn(1800, 1800, |i, k| {
            let coupled = (i / 2 % 3 == 2) == (k / 2 % 3 == 2);
            if coupled { full(i, k) } else { Complex64::ZERO }
        });
        let x = Dense::from_fn(1800, 3, |i, k| Complex64::new((i as f64).sin(), k as f64));
        let right = matrix.times(&x);
        let mut before = f64::INFINITY;
        for tolerance in [1e-3, 1e-5, 1e-6] {
            let factors = HierarchicalFactors::new(&Lines, tolerance, u64::MAX, &Unobserved).unwrap();
            let mut b = right.clone();
            factors.solve(&mut b);
            let error = b
                .elements()
                .iter()
                .zip(x.elements())
                .map(|(got, expected)| (got - expected).norm())
                .fold(0.0, f64::max);
            println!("{tolerance}: {error:e}, rank {}, {} bytes", factors.largest_rank(), factors.bytes());
            // About thrice the tolerance is reached; below 1e-6 roundings of single precision end it.
            assert!(error < 5.0 * tolerance && error < before, "{tolerance}: {error:e}");
            assert!(factors.bytes() < 16 * 1800 * 1800 / 2);
            before = error;
        }
        assert!(HierarchicalFactors::new(&Lines, 1e-6, 1 << 20, &Unobserved).is_err());
    }
}
