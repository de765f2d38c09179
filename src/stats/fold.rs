//! Ordered pairwise sums over batches: the same bits for any division of the work.

/// What can be added up batch by batch.
pub trait Merge {
    /// Adds what later batches found.
    fn merge(&mut self, later: Self);
}

impl Merge for f64 {
    fn merge(&mut self, later: Self) {
        *self += later;
    }
}

impl<T: Merge> Merge for Vec<T> {
    fn merge(&mut self, later: Self) {
        assert_eq!(self.len(), later.len(), "lists of unequal length cannot be merged");
        for (a, b) in self.iter_mut().zip(later) {
            a.merge(b);
        }
    }
}

/// A complete subtree: the merged batches `first` … `first` + 2^`level` − 1, where `first` is a
/// multiple of 2^`level`.
#[derive(Clone, Debug, PartialEq)]
pub struct Node<T> {
    /// Index of its first batch.
    pub first: u64,
    /// Its height in the tree.
    pub level: u32,
    /// The merged batches.
    pub value: T,
}

/// Pairwise fold of batches in order by a fixed binary tree over the batch index.
///
/// The stack of complete subtrees is a binary counter: two neighbours of equal height under one
/// parent merge at once. Floating-point sums depend on nothing but the batches themselves (not on
/// threads, shards or resumption), and their rounding error grows as log₂ of their number.
#[derive(Clone, Debug, PartialEq)]
pub struct Fold<T> {
    nodes: Vec<Node<T>>,
    next: u64,
}

impl<T> Default for Fold<T> {
    fn default() -> Self {
        Fold { nodes: Vec::new(), next: 0 }
    }
}

impl<T: Merge> Fold<T> {
    /// An empty fold whose first batch has this index: one shard of a run.
    pub fn starting_at(first: u64) -> Self {
        Fold { nodes: Vec::new(), next: first }
    }

    /// Adds the next batch.
    pub fn push(&mut self, value: T) {
        self.insert(Node { first: self.next, level: 0, value });
    }

    /// Adds a subtree (of another shard or a checkpoint); gives it back as an error when it does not
    /// start at the next batch or is not aligned to its own size.
    pub fn push_node(&mut self, node: Node<T>) -> Result<(), Node<T>> {
        let aligned = node.level < 64 && node.first.trailing_zeros() >= node.level;
        if node.first != self.next || !aligned {
            return Err(node);
        }
        self.insert(node);
        Ok(())
    }

    fn insert(&mut self, mut node: Node<T>) {
        self.next += 1 << node.level;
        while let Some(left) = self.nodes.pop_if(|l| l.level == node.level && l.first >> l.level & 1 == 0) {
            let (first, level) = (left.first, left.level + 1);
            let mut value = left.value;
            value.merge(node.value);
            node = Node { first, level, value };
        }
        self.nodes.push(node);
    }

    /// Index of the next batch: the number of batches so far when the fold started at 0.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// The complete subtrees so far, in order.
    pub fn nodes(&self) -> &[Node<T>] {
        &self.nodes
    }

    /// The merge of all batches; `None` without any. Incomplete subtrees merge from the right.
    pub fn finish(self) -> Option<T> {
        self.nodes.into_iter().map(|n| n.value).rev().reduce(|right, mut left| {
            left.merge(right);
            left
        })
    }

    /// The merge of all batches so far, as [`Fold::finish`] would give it now.
    pub fn peek(&self) -> Option<T>
    where
        T: Clone,
    {
        self.clone().finish()
    }
}
