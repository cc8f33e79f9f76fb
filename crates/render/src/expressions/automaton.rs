// SPDX-License-Identifier: GPL-3.0-or-later
//! All light path expressions of a picture as one deterministic automaton. A path has a state; a table gives the
//! next state for an event, and the layers of a path of that state that ends at a light.
//! Source: [Tho68] (expressions to nondeterministic automata), [RS59] (sets of states). States from which no light
//! can be matched are the state [`DEAD`].
//! Invariant: a word is accepted by layer `k` exactly if expression `k` matches it. Sizes are bounded.
//! Tests: `tests`, against backtracking over the expression.

use std::collections::HashMap;

use super::events::{Alphabet, End, Event, Scatter};
use super::syntax::{CAMERA, EventSet, ExpressionError, LabelPattern, NONE, Node, Pattern, parse};

/// Most states before and after.
const MOST_NODES: usize = 4000;
const MOST_STATES: usize = 4096;

/// No expression matches whatever follows.
pub(crate) const DEAD: u16 = 0;

/// The automaton of some expressions.
#[derive(Debug)]
pub(crate) struct Automaton {
    /// The state behind the camera.
    pub(crate) start: u16,
    /// How many expressions.
    pub(crate) layers: usize,
    scatters: usize,
    ends: usize,
    /// By state, then event.
    next: Vec<u16>,
    /// The layers by state, then light: each a part of `lists`.
    outputs: Vec<[u32; 2]>,
    lists: Vec<u16>,
}

impl Automaton {
    /// The state after a scattering.
    pub(crate) fn after(&self, state: u16, scatter: Scatter) -> u16 {
        self.next[state as usize * self.scatters + scatter.index()]
    }

    /// The layers of a path that ends.
    pub(crate) fn layers_of(&self, state: u16, end: End) -> &[u16] {
        let [begin, end] = self.outputs[state as usize * self.ends + end.index()];
        &self.lists[begin as usize..end as usize]
    }

    /// Makes the automaton of expressions over an alphabet.
    pub(crate) fn new(expressions: &[&str], alphabet: &Alphabet) -> Result<Self, ExpressionError> {
        let mut nodes = Nodes { labels: alphabet.labels(), all: Vec::new() };
        let mut begins = Vec::new();
        for (layer, &text) in expressions.iter().enumerate() {
            let parsed = parse(text)?;
            let accept = nodes.put(State::Accept(layer as u16));
            let begin = nodes.build(&parsed, accept);
            if nodes.all.len() > MOST_NODES {
                return Err(whole(text, format!("more than {MOST_NODES} parts")));
            }
            begins.push(begin);
        }
        let camera = Event { kind: CAMERA, scattering: NONE, labels: 0 };
        for (&begin, &text) in begins.iter().zip(expressions) {
            if nodes.step(&nodes.closure([begin]), camera).is_empty() {
                return Err(whole(text, "matches no path: a path begins with the camera, C".into()));
            }
        }
        let start = nodes.step(&nodes.closure(begins), camera);
        let found = Subsets::of(&nodes, start, alphabet)
            .ok_or_else(|| whole(&expressions.join("', '"), format!("more than {MOST_STATES} states")))?;
        let made = found.pruned(expressions.len(), alphabet);
        for (layer, &text) in expressions.iter().enumerate() {
            if !made.lists.contains(&(layer as u16)) && !mentions_labels(&parse(text)?) {
                return Err(whole(text, "matches no path: a path ends at a light, L, O or B".into()));
            }
        }
        Ok(made)
    }
}

fn whole(text: &str, problem: String) -> ExpressionError {
    ExpressionError { expression: text.into(), position: None, problem }
}

/// The labels that an expression names.
pub(crate) fn labels_in(node: &Node, labels: &mut Vec<String>) {
    match node {
        Node::Event(set) => {
            for pattern in &set.patterns {
                if let LabelPattern::OneOf(list) | LabelPattern::NoneOf(list) = &pattern.labels {
                    labels.extend(list.iter().cloned());
                }
            }
        }
        Node::Sequence(parts) | Node::Choice(parts) => {
            parts.iter().for_each(|part| labels_in(part, labels));
        }
        Node::Repeat(part, ..) => labels_in(part, labels),
    }
}

fn mentions_labels(node: &Node) -> bool {
    let mut labels = Vec::new();
    labels_in(node, &mut labels);
    !labels.is_empty()
}

/// A pattern over an alphabet: types, scattering, and how its labels are tested.
#[derive(Debug)]
struct Test {
    types: u8,
    scattering: u8,
    /// Bits of labels, and whether one of them is wanted, or none.
    labels: Option<(u64, bool)>,
}

#[derive(Debug)]
enum State {
    /// To two states, without an event.
    Fork(u32, u32),
    /// To the next state by an event.
    Event(Vec<Test>, bool, u32),
    Accept(u16),
}

struct Nodes<'a> {
    labels: &'a [String],
    all: Vec<State>,
}

impl Nodes<'_> {
    fn put(&mut self, state: State) -> u32 {
        self.all.push(state);
        self.all.len() as u32 - 1
    }

    /// The state at which `node` begins, if it goes on at `then`.
    fn build(&mut self, node: &Node, then: u32) -> u32 {
        if self.all.len() > MOST_NODES {
            return then;
        }
        match node {
            Node::Event(set) => {
                let tests = self.tests(set);
                self.put(State::Event(tests, set.negated, then))
            }
            Node::Sequence(parts) => parts.iter().rev().fold(then, |then, part| self.build(part, then)),
            Node::Choice(ways) => {
                let mut first = self.build(&ways[0], then);
                for way in &ways[1..] {
                    let other = self.build(way, then);
                    first = self.put(State::Fork(first, other));
                }
                first
            }
            Node::Repeat(part, least, most) => {
                let mut first = match most {
                    // The end of a loop, from which it begins again.
                    None => {
                        let fork = self.put(State::Fork(then, then));
                        let again = self.build(part, fork);
                        self.all[fork as usize] = State::Fork(again, then);
                        fork
                    }
                    Some(most) => {
                        let mut first = then;
                        for _ in *least..*most {
                            let once = self.build(part, first);
                            first = self.put(State::Fork(once, then));
                        }
                        first
                    }
                };
                for _ in 0..*least {
                    first = self.build(part, first);
                }
                first
            }
        }
    }

    fn tests(&self, set: &EventSet) -> Vec<Test> {
        let bits = |list: &[String]| {
            let bit = |label: &String| self.labels.iter().position(|known| known == label).unwrap_or(63);
            list.iter().fold(0_u64, |bits, label| bits | 1 << bit(label))
        };
        let test = |pattern: &Pattern| {
            let labels = match &pattern.labels {
                LabelPattern::Any => None,
                LabelPattern::OneOf(list) => Some((bits(list), true)),
                LabelPattern::NoneOf(list) => Some((bits(list), false)),
            };
            Test { types: pattern.types, scattering: pattern.scattering, labels }
        };
        set.patterns.iter().map(test).collect()
    }

    /// The states with events, and accepting ones, that are reached without an event; ascending.
    fn closure(&self, from: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut left: Vec<u32> = from.into_iter().collect();
        let mut seen = vec![false; self.all.len()];
        let mut found = Vec::new();
        while let Some(state) = left.pop() {
            if std::mem::replace(&mut seen[state as usize], true) {
                continue;
            }
            match self.all[state as usize] {
                State::Fork(a, b) => left.extend([a, b]),
                _ => found.push(state),
            }
        }
        found.sort_unstable();
        found
    }

    fn step(&self, states: &[u32], event: Event) -> Vec<u32> {
        let goes = |&state: &u32| match &self.all[state as usize] {
            State::Event(tests, negated, then) => {
                let matches = tests.iter().any(|test| test.matches(event));
                (matches != *negated).then_some(*then)
            }
            _ => None,
        };
        let mut next: Vec<u32> = states.iter().filter_map(goes).collect();
        if next.is_empty() {
            return next;
        }
        next.dedup();
        self.closure(next)
    }

    fn accepted(&self, states: &[u32]) -> Vec<u16> {
        let layer = |&state: &u32| match self.all[state as usize] {
            State::Accept(layer) => Some(layer),
            _ => None,
        };
        let mut layers: Vec<u16> = states.iter().filter_map(layer).collect();
        layers.sort_unstable();
        layers
    }
}

impl Test {
    fn matches(&self, event: Event) -> bool {
        let fits = self.types & event.kind != 0 && self.scattering & event.scattering != 0;
        fits && self.labels.is_none_or(|(labels, has_one)| (labels & event.labels != 0) == has_one)
    }
}

/// Sets of states that are reached, with their ways.
struct Subsets {
    next: Vec<Vec<u32>>,
    accepted: Vec<Vec<Vec<u16>>>,
}

impl Subsets {
    /// `None` if there are too many.
    fn of(nodes: &Nodes, start: Vec<u32>, alphabet: &Alphabet) -> Option<Self> {
        let mut numbers: HashMap<Vec<u32>, u32> = HashMap::from([(Vec::new(), 0)]);
        let mut sets = vec![Vec::new(), start.clone()];
        numbers.entry(start).or_insert(1);
        let (mut next, mut accepted) = (Vec::new(), Vec::new());
        while let Some(set) = sets.get(next.len()).cloned() {
            let after = alphabet.scatters().map(|event| {
                let reached = nodes.step(&set, event);
                if let Some(&number) = numbers.get(&reached) {
                    return number;
                }
                let number = sets.len() as u32;
                sets.push(reached.clone());
                numbers.insert(reached, number);
                number
            });
            next.push(after.collect());
            accepted.push(alphabet.ends().map(|event| nodes.accepted(&nodes.step(&set, event))).collect());
            if sets.len() > MOST_STATES {
                return None;
            }
        }
        Some(Self { next, accepted })
    }

    /// As tables; states that lead nowhere are [`DEAD`].
    fn pruned(&self, layers: usize, alphabet: &Alphabet) -> Automaton {
        let count = self.next.len();
        let mut lives: Vec<bool> =
            self.accepted.iter().map(|ends| ends.iter().any(|list| !list.is_empty())).collect();
        loop {
            let more: Vec<usize> = (0..count)
                .filter(|&state| !lives[state] && self.next[state].iter().any(|&next| lives[next as usize]))
                .collect();
            if more.is_empty() {
                break;
            }
            more.into_iter().for_each(|state| lives[state] = true);
        }
        let mut numbers = vec![DEAD; count];
        let mut used: u16 = 0;
        for state in (0..count).filter(|&state| lives[state]) {
            used += 1;
            numbers[state] = used;
        }
        let (scatters, ends) = (alphabet.scatters().count(), alphabet.ends().count());
        let mut made = Automaton {
            start: numbers[1],
            layers,
            scatters,
            ends,
            next: vec![DEAD; scatters],
            outputs: vec![[0; 2]; ends],
            lists: Vec::new(),
        };
        for state in (0..count).filter(|&state| lives[state]) {
            made.next.extend(self.next[state].iter().map(|&next| numbers[next as usize]));
            for list in &self.accepted[state] {
                let begin = made.lists.len() as u32;
                made.lists.extend(list);
                made.outputs.push([begin, made.lists.len() as u32]);
            }
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expressions::syntax::{BACKGROUND, LIGHT};

    /// Whether `node` matches a beginning of `word`, and `then` the rest.
    fn matches(node: &Node, word: &[Event], labels: &[String], then: &dyn Fn(&[Event]) -> bool) -> bool {
        match node {
            Node::Event(set) => {
                let nodes = Nodes { labels, all: Vec::new() };
                let is_it = |event| nodes.tests(set).iter().any(|test| test.matches(event)) != set.negated;
                word.split_first().is_some_and(|(&first, rest)| is_it(first) && then(rest))
            }
            Node::Sequence(parts) => match parts.split_first() {
                None => then(word),
                Some((first, rest)) => {
                    let rest = Node::Sequence(rest.to_vec());
                    matches(first, word, labels, &|word| matches(&rest, word, labels, then))
                }
            },
            Node::Choice(ways) => ways.iter().any(|way| matches(way, word, labels, then)),
            Node::Repeat(part, least, most) => {
                if *least == 0 && then(word) {
                    return true;
                }
                let rest = Node::Repeat(part.clone(), least.saturating_sub(1), most.map(|m| m.max(1) - 1));
                let is_shorter = |left: &[Event]| left.len() < word.len() || *least > 0;
                *most != Some(0)
                    && matches(part, word, labels, &|left| {
                        is_shorter(left) && matches(&rest, left, labels, then)
                    })
            }
        }
    }

    #[test]
    fn it_accepts_what_its_expressions_match() {
        let labels = vec!["a".to_owned(), "b".into()];
        let alphabet = Alphabet::new(labels.clone(), vec![0, 1, 2], vec![0, 1, 3]);
        let texts = [
            "C.*",
            "C<RD>L",
            "C<R[GS]>[^V]*[LB]",
            "C(<RS>|<TS>)+<.D'a'>L?<L.'b'>",
            "C[DG]{1,2}.*<L[^'a']>",
            "C(R|T*)*<B.>",
            "C[^<RD'a'>V]*O",
            "CV+L|C<T.>?B",
        ];
        let made = Automaton::new(&texts, &alphabet).expect("sound");
        let nodes: Vec<Node> = texts.iter().map(|text| parse(text).expect("sound")).collect();
        let scatters: Vec<Event> = alphabet.scatters().collect();
        let ends: Vec<Event> = alphabet.ends().collect();
        let camera = Event { kind: CAMERA, scattering: NONE, labels: 0 };
        let mut seed = 1_u32;
        let mut draw = |n: usize| {
            seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (seed >> 8) as usize % n
        };
        let mut hits = vec![0; texts.len()];
        for _ in 0..3000 {
            let (length, last) = (draw(5), draw(ends.len()));
            let (mut word, mut state) = (vec![camera], made.start);
            for _ in 0..length {
                let event = draw(scatters.len());
                word.push(scatters[event]);
                state = made.after(state, Scatter::of_index(event));
            }
            word.push(ends[last]);
            let found = made.layers_of(state, End::of_index(last));
            for (layer, node) in nodes.iter().enumerate() {
                let expected = matches(node, &word, &labels, &<[Event]>::is_empty);
                assert_eq!(found.contains(&(layer as u16)), expected, "{}: {word:?}", texts[layer]);
                hits[layer] += u32::from(expected);
            }
        }
        assert!(hits.iter().all(|&hits| hits > 0), "each matched something: {hits:?}");
    }

    #[test]
    fn useless_and_huge_expressions_are_refused() {
        let alphabet = Alphabet::new(Vec::new(), vec![0], vec![0]);
        for (text, problem) in [
            ("RL", "begins with the camera"),
            ("CR", "ends at a light"),
            ("C.{64}{64}{64}L", "parts"),
            ("C.*<RD>.{14}L", "states"),
        ] {
            let error = Automaton::new(&[text], &alphabet).expect_err(text);
            assert!(error.problem.contains(problem), "{text}: {error}");
        }
        let made = Automaton::new(&["CB"], &alphabet).expect("sound");
        let diffuse = Scatter::of_index(0);
        assert_eq!(made.after(made.start, diffuse), DEAD, "nothing can follow");
        assert!(ends_at(&made, LIGHT).is_empty() && ends_at(&made, BACKGROUND) == [0], "its light");
    }

    fn ends_at(made: &Automaton, kind: u8) -> &[u16] {
        let position = super::super::events::ENDS.iter().position(|&known| known == kind).expect("a light");
        made.layers_of(made.start, End::of_index(position))
    }
}
