//! The ways in which endless words can still affect obligations: meet them, or break them.
//!
//! Obligations are clauses. To meet them is to meet one obligation of each clause, a product. To break them is to break
//! all obligations of one clause. So the search guesses a word together with the obligations it will meet (or break): a
//! node is a set of obligations with the remembered messages, an edge is a letter with the set that results from it.
//!
//! An endless path meets its obligations unless it postpones one of them forever. An obligation can be postponed if
//! silence does not meet it: an `until` that continues, a `next` that waits, a window in which no message passes. Each
//! kind must be *served* again and again, or be gone. This is a generalized Büchi condition on the edges (Gastin and
//! Oddoux, CAV 2001): a node can win if a path leads to a strongly connected component whose edges serve everything, or
//! to a node where nothing can be postponed, so that silence is enough.

use std::collections::{HashMap, VecDeque};

use crate::clause::EventId;
use crate::engine::alphabet::{Alphabet, Letter, Symbol};
use crate::engine::limits::Limits;
use crate::engine::obligations::{Clause, Obligation, Obligations};
use crate::engine::operators::Operators;
use crate::engine::past::Memory;

/// There are too many possible continuations to explore them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooManyWays;

/// Obligations that can be postponed forever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Delay {
    /// The operator with this number continues, or waits.
    Operator(u32),
    /// The event does not occur in a window without an end.
    Event(EventId),
    /// Time stands still, and with it a window of the event that has not begun or not ended.
    Time(EventId),
}

/// A set of obligations to be met, or broken; sorted, without redundant ones.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Vertex {
    owed: Clause,
    memory: Memory,
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    symbol: Symbol,
    to: usize,
    /// The delays that continue along this edge: one bit each.
    delays: u128,
}

/// The graph of everything that words can do with obligations.
pub(crate) struct Anticipation<'a> {
    operators: &'a Operators,
    letters: Vec<(Symbol, Letter)>,
    /// Whether obligations are to be met or to be broken.
    meet: bool,
    limits: Limits,
    known: HashMap<Vertex, usize>,
    nodes: Vec<Vertex>,
    edges: Vec<Vec<Edge>>,
    delays: HashMap<Delay, u32>,
}

/// An endless word: symbols, and the cycle that repeats after them; an empty cycle is silence.
pub(crate) type Lasso = (Vec<Symbol>, Vec<Symbol>);

impl<'a> Anticipation<'a> {
    pub(crate) fn new(operators: &'a Operators, alphabet: &Alphabet, meet: bool) -> Self {
        let messages = alphabet.letters().map(|(letter, ..)| (alphabet.symbol(letter), letter));
        let letters = messages.chain([(Symbol::NEXT_TICK, Letter::TICK)]).collect();
        let (known, delays) = (HashMap::new(), HashMap::new());
        Self { operators, letters, meet, limits: alphabet.limits, known, nodes: Vec::new(), edges: Vec::new(), delays }
    }

    /// Whether some endless word meets (or breaks) the obligations, for each of these in turn.
    pub(crate) fn possible(&mut self, owed: &[(&Obligations, &Memory)]) -> Result<Vec<bool>, TooManyWays> {
        let roots = owed.iter().map(|(owed, memory)| self.roots(owed, memory)).collect::<Result<Vec<_>, _>>()?;
        self.explore()?;
        let wins = self.winning();
        Ok(roots.iter().map(|roots| roots.iter().any(|root| wins[*root])).collect())
    }

    /// An endless word that meets (or breaks) the obligations, if there is one.
    pub(crate) fn lasso(&mut self, owed: &Obligations, memory: &Memory) -> Result<Option<Lasso>, TooManyWays> {
        let roots = self.roots(owed, memory)?;
        self.explore()?;
        let (components, is_good) = self.components();
        let stops = |node: usize| self.is_silent(node) || is_good[components[node]];
        let Some((node, stem)) = self.path(&roots, |_| true, stops) else { return Ok(None) };
        if self.is_silent(node) {
            return Ok(Some((stem, Vec::new())));
        }
        let (mut here, mut cycle) = (node, Vec::new());
        let inside = |edge: &Edge| components[edge.to] == components[node];
        for delay in 0..self.delays.len() {
            // The target of an edge on which this delay ends, and that edge.
            let ends = |edge: &&Edge| inside(edge) && edge.delays >> delay & 1 == 0;
            let leaves = |node: usize| self.edges[node].iter().any(|edge| ends(&edge));
            let Some((from, way)) = self.path(&[here], inside, leaves) else { return Ok(None) };
            cycle.extend(way);
            let Some(edge) = self.edges[from].iter().find(ends) else { return Ok(None) };
            cycle.push(edge.symbol);
            here = edge.to;
        }
        let back = self.path(&[here], inside, |there| there == node);
        cycle.extend(back.map(|(_, way)| way).unwrap_or_default());
        Ok(Some((stem, cycle)))
    }

    /// A shortest path from one of the nodes to a goal, along allowed edges.
    fn path(
        &self,
        from: &[usize],
        may: impl Fn(&Edge) -> bool,
        found: impl Fn(usize) -> bool,
    ) -> Option<(usize, Vec<Symbol>)> {
        let mut came: HashMap<usize, Option<(usize, Symbol)>> = from.iter().map(|node| (*node, None)).collect();
        let mut queue: VecDeque<usize> = from.iter().copied().collect();
        while let Some(node) = queue.pop_front() {
            if found(node) {
                let step = |node: usize| came.get(&node).copied().flatten();
                let mut path: Vec<Symbol> =
                    std::iter::successors(step(node), |(from, _)| step(*from)).map(|(_, symbol)| symbol).collect();
                path.reverse();
                return Some((node, path));
            }
            for edge in self.edges[node].iter().filter(|edge| may(edge)) {
                came.entry(edge.to).or_insert_with(|| {
                    queue.push_back(edge.to);
                    Some((node, edge.symbol))
                });
            }
        }
        None
    }

    fn roots(&mut self, owed: &Obligations, memory: &Memory) -> Result<Vec<usize>, TooManyWays> {
        let ways = self.ways(owed)?;
        ways.into_iter().map(|owed| self.number(Vertex { owed, memory: memory.clone() })).collect()
    }

    /// The alternatives: products, one of which must be met, or clauses, one of which must be broken.
    fn ways(&self, owed: &Obligations) -> Result<Vec<Clause>, TooManyWays> {
        if self.meet { products(owed, self.limits.ways) } else { Ok(owed.clauses().to_vec()) }
    }

    fn number(&mut self, node: Vertex) -> Result<usize, TooManyWays> {
        if let Some(known) = self.known.get(&node) {
            return Ok(*known);
        }
        if self.nodes.len() >= self.limits.nodes {
            return Err(TooManyWays);
        }
        self.known.insert(node.clone(), self.nodes.len());
        self.nodes.push(node);
        Ok(self.nodes.len() - 1)
    }

    fn explore(&mut self) -> Result<(), TooManyWays> {
        let mut count = 0;
        while self.edges.len() < self.nodes.len() {
            let node = self.nodes[self.edges.len()].clone();
            let mut edges = Vec::new();
            // If silence is enough, other continuations need not be known.
            let letters = if self.can_delay(&node.owed) { self.letters.clone() } else { Vec::new() };
            for (symbol, letter) in letters {
                let mut memory = node.memory.clone();
                if letter.is_tick() {
                    self.operators.age(&mut memory, 1);
                }
                let state = self.operators.read(&mut memory, letter, None, 0);
                let owed =
                    if self.meet { Obligations::all(node.owed.clone()) } else { Obligations::any(node.owed.clone()) };
                let owed = self.operators.step(self.passed(owed, letter), state);
                self.operators.forget(&mut memory);
                for way in self.ways(&owed)? {
                    let delays = self.put_off(&way, letter)?;
                    let to = self.number(Vertex { owed: way, memory: memory.clone() })?;
                    edges.push(Edge { symbol, to, delays });
                }
            }
            count += edges.len();
            if count > self.limits.edges {
                return Err(TooManyWays);
            }
            self.edges.push(edges);
        }
        Ok(())
    }

    /// The obligations after time has passed, if the letter is a tick.
    fn passed(&self, owed: Obligations, letter: Letter) -> Obligations {
        if letter.is_tick() { self.operators.advance(owed, 1).shifted(1) } else { owed }
    }

    /// Whether a set has an obligation that can be postponed.
    fn can_delay(&self, owed: &Clause) -> bool {
        owed.iter().any(|obligation| self.operators.met_by_silence(obligation) != self.meet)
    }

    fn is_silent(&self, node: usize) -> bool {
        !self.can_delay(&self.nodes[node].owed)
    }

    /// The delays that a letter leaves unserved, restricted to possible ones.
    ///
    /// An operator that continues is served when it is gone. It can always go when it is met: an operator that is
    /// started again in this state demands the same.
    fn put_off(&mut self, owed: &Clause, letter: Letter) -> Result<u128, TooManyWays> {
        let mut bits = 0;
        for obligation in owed.iter().filter(|obligation| self.operators.met_by_silence(obligation) != self.meet) {
            for delay in delays_of(obligation) {
                let served = match delay {
                    Delay::Operator(operator) => self.operators.is_asked(operator, letter),
                    Delay::Event(event) => letter.satisfied & (1 << event.0) != 0,
                    Delay::Time(_) => letter.is_tick(),
                };
                let next = self.delays.len() as u32;
                let number = *self.delays.entry(delay).or_insert(next);
                if number as usize >= self.limits.delays.min(u128::BITS as usize) {
                    return Err(TooManyWays);
                }
                bits |= u128::from(!served) << number;
            }
        }
        Ok(bits)
    }

    /// The nodes from which a winning word continues.
    fn winning(&self) -> Vec<bool> {
        let (components, is_good) = self.components();
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        for (from, edges) in self.edges.iter().enumerate() {
            edges.iter().for_each(|edge| before[edge.to].push(from));
        }
        let mut wins: Vec<bool> =
            (0..self.nodes.len()).map(|node| self.is_silent(node) || is_good[components[node]]).collect();
        let mut open: Vec<usize> = (0..wins.len()).filter(|node| wins[*node]).collect();
        while let Some(node) = open.pop() {
            for from in &before[node] {
                if !std::mem::replace(&mut wins[*from], true) {
                    open.push(*from);
                }
            }
        }
        wins
    }

    /// The strongly connected component of each node, and the components whose edges serve everything.
    fn components(&self) -> (Vec<usize>, Vec<bool>) {
        let components = strongly_connected(&self.edges);
        let count = components.iter().max().map_or(0, |last| last + 1);
        // The delays common to all inner edges; without an edge, all of them.
        let mut delays = vec![u128::MAX; count];
        for (from, edges) in self.edges.iter().enumerate() {
            for edge in edges.iter().filter(|edge| components[edge.to] == components[from]) {
                delays[components[from]] &= edge.delays;
            }
        }
        (components, delays.into_iter().map(|delays| delays == 0).collect())
    }
}

/// The ways to postpone an obligation that silence does not settle.
fn delays_of(obligation: &Obligation) -> impl Iterator<Item = Delay> {
    let delays = match *obligation {
        Obligation::Goes(operator, _) | Obligation::Waits(operator, _) => [Some(Delay::Operator(operator)), None],
        Obligation::Passes { event, first, last, .. } => {
            let endless = last == u64::MAX;
            [endless.then_some(Delay::Event(event)), (first > 0 || !endless).then_some(Delay::Time(event))]
        }
    };
    delays.into_iter().flatten()
}

/// The products of clauses: all minimal ways to meet one obligation of each.
fn products(owed: &Obligations, most: usize) -> Result<Vec<Clause>, TooManyWays> {
    let mut products: Vec<Clause> = vec![Clause::new()];
    for clause in owed.clauses() {
        let mut longer: Vec<Clause> = Vec::new();
        for product in &products {
            for obligation in clause {
                let product = with(product, obligation.clone());
                let implies = |a: &Clause, b: &Clause| b.iter().all(|y| a.iter().any(|x| x.implies(y)));
                if !longer.iter().any(|known| implies(&product, known)) {
                    longer.retain(|known| !implies(known, &product));
                    longer.push(product);
                }
            }
        }
        if longer.len() > most {
            return Err(TooManyWays);
        }
        products = longer;
    }
    Ok(products)
}

/// A product with one more obligation, without the ones that it makes redundant.
fn with(product: &Clause, obligation: Obligation) -> Clause {
    if product.iter().any(|known| known.implies(&obligation)) {
        return product.clone();
    }
    let mut longer: Clause = product.iter().filter(|known| !obligation.implies(known)).cloned().collect();
    let place = longer.binary_search(&obligation).unwrap_or_else(|place| place);
    longer.insert(place, obligation);
    longer
}

/// The number of each node's strongly connected component (Tarjan's algorithm with an explicit stack).
fn strongly_connected(edges: &[Vec<Edge>]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let (mut order, mut low) = (vec![NONE; edges.len()], vec![NONE; edges.len()]);
    let mut components = vec![NONE; edges.len()];
    let (mut found, mut count, mut visited) = (Vec::new(), 0, 0);
    for root in 0..edges.len() {
        // A node and which of its edges is next.
        let mut path: Vec<(usize, usize)> = (order[root] == NONE).then_some((root, 0)).into_iter().collect();
        while let Some((node, next)) = path.pop() {
            if next == 0 {
                (order[node], low[node]) = (visited, visited);
                visited += 1;
                found.push(node);
            }
            if let Some(edge) = edges[node].get(next) {
                // The node returns once its neighbor is done, and then passes on how far back that leads.
                path.push((node, next + 1));
                if order[edge.to] == NONE {
                    path.push((edge.to, 0));
                } else if components[edge.to] == NONE {
                    low[node] = low[node].min(order[edge.to]);
                }
                continue;
            }
            if let Some((parent, _)) = path.last() {
                low[*parent] = low[*parent].min(low[node]);
            }
            if low[node] == order[node] {
                while let Some(member) = found.pop() {
                    components[member] = count;
                    if member == node {
                        break;
                    }
                }
                count += 1;
            }
        }
    }
    components
}
