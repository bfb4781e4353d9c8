//! In which order to evaluate a DAG, and in which stack slots, so that few slots are needed.
//!
//! A node's inputs are read before its result is written, so the result may take the slot of an input read for the
//! last time. The least number of slots is NP-hard to find for DAGs (Sethi 1975); for trees the order of Sethi and
//! Ullman (1970) is optimal. Small programs are solved exactly over all sets of evaluated nodes; for the others several
//! depth-first orders are tried and the best one is taken. Nothing here recurses: a chain may be as long as it likes.

/// Programs of at most this many nodes are solved exactly.
const EXACT: usize = 12;

/// A DAG by numbers: `inputs[v]` are the distinct nodes that `v` reads.
#[derive(Clone, Debug)]
pub(crate) struct Dag {
    pub(crate) inputs: Vec<Vec<usize>>,
    /// Nodes whose results are kept to the end. Everything else is read by something.
    pub(crate) roots: Vec<usize>,
    /// How many slots the results of each node take.
    pub(crate) widths: Vec<usize>,
}

/// Order and slots.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    pub(crate) order: Vec<usize>,
    /// Slots of each node's results.
    pub(crate) slots: Vec<Vec<u32>>,
    pub(crate) slots_needed: u32,
}

/// Finds an order with few slots.
pub(crate) fn schedule(dag: &Dag) -> Schedule {
    let order = if dag.inputs.len() <= EXACT {
        exact_order(dag)
    } else {
        best_depth_first_order(dag)
    };
    assign_slots(dag, order)
}

/// Readers of each node that are not evaluated yet; a root has one more that never comes.
fn reader_counts(dag: &Dag) -> Vec<usize> {
    let mut readers = vec![0; dag.inputs.len()];
    for &input in dag.inputs.iter().flatten() {
        readers[input] += 1;
    }
    for &root in &dag.roots {
        readers[root] += 1;
    }
    readers
}

fn assign_slots(dag: &Dag, order: Vec<usize>) -> Schedule {
    let mut readers = reader_counts(dag);
    let mut slots: Vec<Vec<u32>> = vec![Vec::new(); dag.inputs.len()];
    let mut free = std::collections::BinaryHeap::new(); // the lowest slot first: results stay close together
    let mut slots_needed = 0;
    for &node in &order {
        for &input in &dag.inputs[node] {
            readers[input] -= 1;
            if readers[input] == 0 {
                free.extend(slots[input].iter().copied().map(std::cmp::Reverse));
            }
        }
        let next = || match free.pop() {
            Some(std::cmp::Reverse(slot)) => slot,
            None => {
                slots_needed += 1;
                slots_needed - 1
            }
        };
        slots[node] = std::iter::repeat_with(next)
            .take(dag.widths[node])
            .collect();
    }
    Schedule {
        order,
        slots,
        slots_needed,
    }
}

/// Slots that an order needs: the most results alive at once.
fn peak(dag: &Dag, order: &[usize]) -> usize {
    let mut readers = reader_counts(dag);
    let (mut live, mut peak) = (0usize, 0);
    for &node in order {
        for &input in &dag.inputs[node] {
            readers[input] -= 1;
            if readers[input] == 0 {
                live -= dag.widths[input];
            }
        }
        live += dag.widths[node];
        peak = peak.max(live);
    }
    peak
}

/// The best order of all: shortest path over the sets of evaluated nodes, by most results alive.
fn exact_order(dag: &Dag) -> Vec<usize> {
    let count = dag.inputs.len();
    let full = (1usize << count) - 1;
    let inputs: Vec<usize> = dag
        .inputs
        .iter()
        .map(|inputs| inputs.iter().fold(0, |mask, &i| mask | 1 << i))
        .collect();
    let mut readers = vec![0usize; count];
    for (node, list) in dag.inputs.iter().enumerate() {
        for &input in list {
            readers[input] |= 1 << node;
        }
    }
    let roots = dag
        .roots
        .iter()
        .fold(0, |mask, &root| mask | 1usize << root);
    let live = |done: usize| {
        (0..count)
            .filter(|&v| done >> v & 1 == 1 && (roots >> v & 1 == 1 || readers[v] & !done != 0))
            .map(|v| dag.widths[v])
            .sum::<usize>() as u8
    };
    // best[done]: least peak to get there, and the node evaluated last. Sets grow, so numeric order will do.
    let mut best = vec![(u8::MAX, 0u8); full + 1];
    best[0] = (0, 0);
    for done in 0..=full {
        let so_far = best[done].0;
        if so_far == u8::MAX {
            continue;
        }
        for node in (0..count).filter(|&v| done >> v & 1 == 0 && inputs[v] & !done == 0) {
            let next = done | 1 << node;
            let peak = so_far.max(live(next));
            if peak < best[next].0 {
                best[next] = (peak, node as u8);
            }
        }
    }
    let mut order = Vec::with_capacity(count);
    let mut done = full;
    while done != 0 {
        let node = usize::from(best[done].1);
        order.push(node);
        done &= !(1 << node);
    }
    order.reverse();
    order
}

fn best_depth_first_order(dag: &Dag) -> Vec<usize> {
    let needs = sethi_ullman_numbers(dag);
    let sizes = subtree_sizes(dag);
    let readers = reader_counts(dag);
    let keys: [&dyn Fn(usize, usize) -> i64; 6] = [
        &|_, v| -(needs[v] as i64),
        &|_, v| -((needs[v] as i64) << 24) - sizes[v].min(1 << 20) as i64,
        // Shared inputs late, when they are about to be read; or early, before anything else is held.
        &|_, v| (i64::from(readers[v] > 1) << 32) - needs[v] as i64,
        &|_, v| -(i64::from(readers[v] > 1) << 32) - needs[v] as i64,
        &|place, _| place as i64,
        &|place, _| -(place as i64),
    ];
    let mut best: Option<(usize, Vec<usize>)> = None;
    for key in keys {
        let order = depth_first_order(dag, key);
        let peak = peak(dag, &order);
        if best.as_ref().is_none_or(|(least, _)| peak < *least) {
            best = Some((peak, order));
        }
    }
    best.map(|(_, order)| order).unwrap_or_default()
}

/// Depth-first post-order that visits inputs by ascending `key(place among the inputs, node)`.
fn depth_first_order(dag: &Dag, key: &dyn Fn(usize, usize) -> i64) -> Vec<usize> {
    let sorted = |nodes: &[usize]| {
        let mut places: Vec<usize> = (0..nodes.len()).collect();
        places.sort_by_key(|&place| key(place, nodes[place]));
        places
            .into_iter()
            .map(|place| nodes[place])
            .collect::<Vec<usize>>()
    };
    let mut visited = vec![false; dag.inputs.len()];
    let mut order = Vec::with_capacity(dag.inputs.len());
    let mut stack: Vec<(usize, Vec<usize>, usize)> = Vec::new(); // node, its inputs in order, the next of them
    for root in sorted(&dag.roots) {
        if visited[root] {
            continue;
        }
        visited[root] = true;
        stack.push((root, sorted(&dag.inputs[root]), 0));
        while let Some((node, inputs, next)) = stack.last_mut() {
            match inputs.get(*next).copied() {
                Some(input) => {
                    *next += 1;
                    if !visited[input] {
                        visited[input] = true;
                        stack.push((input, sorted(&dag.inputs[input]), 0));
                    }
                }
                None => {
                    order.push(*node);
                    stack.pop();
                }
            }
        }
    }
    order
}

/// Slots that the subtree below each node needs, were nothing shared.
fn sethi_ullman_numbers(dag: &Dag) -> Vec<usize> {
    let mut needs = vec![0; dag.inputs.len()];
    for node in depth_first_order(dag, &|place, _| place as i64) {
        let mut inputs: Vec<usize> = dag.inputs[node].iter().map(|&input| needs[input]).collect();
        inputs.sort_unstable_by(|a, b| b.cmp(a));
        needs[node] = inputs
            .iter()
            .enumerate()
            .map(|(held, need)| held + need)
            .max()
            .unwrap_or(1)
            .max(1);
    }
    needs
}

/// Nodes below each node, shared ones counted once per path; saturating.
fn subtree_sizes(dag: &Dag) -> Vec<usize> {
    let mut sizes = vec![0usize; dag.inputs.len()];
    for node in depth_first_order(dag, &|place, _| place as i64) {
        sizes[node] = dag.inputs[node]
            .iter()
            .fold(1, |sum, &input| sum.saturating_add(sizes[input]));
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(inputs: &[&[usize]], roots: &[usize]) -> u32 {
        let dag = Dag {
            inputs: inputs.iter().map(|list| list.to_vec()).collect(),
            roots: roots.to_vec(),
            widths: vec![1; inputs.len()],
        };
        let schedule = schedule(&dag);
        check(&dag, &schedule);
        schedule.slots_needed
    }

    /// Executes a schedule symbolically: every input must still be in its slot when it is read.
    fn check(dag: &Dag, schedule: &Schedule) {
        let mut stack = vec![usize::MAX; schedule.slots_needed as usize];
        for &node in &schedule.order {
            for &input in &dag.inputs[node] {
                for &slot in &schedule.slots[input] {
                    assert_eq!(stack[slot as usize], input, "{dag:?} {schedule:?}");
                }
            }
            assert_eq!(schedule.slots[node].len(), dag.widths[node]);
            for &slot in &schedule.slots[node] {
                stack[slot as usize] = node;
            }
        }
        for &root in &dag.roots {
            for &slot in &schedule.slots[root] {
                assert_eq!(stack[slot as usize], root, "{dag:?} {schedule:?}");
            }
        }
        let mut sorted = schedule.order.clone();
        sorted.sort_unstable();
        assert_eq!(
            sorted,
            (0..dag.inputs.len()).collect::<Vec<_>>(),
            "each node once"
        );
    }

    /// Small numbers without a pattern.
    fn random(seed: &mut u64) -> usize {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 33) as usize
    }

    /// A random DAG in which every node but the last ones is read by something.
    fn random_dag(count: usize, seed: &mut u64) -> Dag {
        let mut inputs: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (node, list) in inputs.iter_mut().enumerate().skip(1) {
            for _ in 0..random(seed) % 4 {
                list.push(random(seed) % node);
            }
            list.sort_unstable();
            list.dedup();
        }
        let read: Vec<bool> = (0..count)
            .map(|v| inputs.iter().any(|list| list.contains(&v)))
            .collect();
        let roots = (0..count).filter(|&v| !read[v]).collect();
        // Some keep several results.
        let widths = (0..count).map(|_| 1 + random(seed) % 5 / 3).collect();
        Dag {
            inputs,
            roots,
            widths,
        }
    }

    /// The least peak over all topological orders, by trying them all.
    fn brute_force(dag: &Dag) -> usize {
        fn go(dag: &Dag, order: &mut Vec<usize>, best: &mut usize) {
            if order.len() == dag.inputs.len() {
                *best = (*best).min(peak(dag, order));
                return;
            }
            for node in 0..dag.inputs.len() {
                if !order.contains(&node)
                    && dag.inputs[node].iter().all(|input| order.contains(input))
                {
                    order.push(node);
                    go(dag, order, best);
                    order.pop();
                }
            }
        }
        let mut best = usize::MAX;
        go(dag, &mut Vec::new(), &mut best);
        best
    }

    #[test]
    fn nothing_needs_nothing() {
        assert_eq!(slots(&[], &[]), 0);
        assert_eq!(slots(&[&[]], &[0]), 1);
    }

    #[test]
    fn a_chain_needs_at_most_two_slots() {
        for length in [2, 10, 50_000] {
            let inputs = (0..length)
                .map(|v| if v == 0 { vec![] } else { vec![v - 1] })
                .collect();
            let dag = Dag {
                inputs,
                roots: vec![length - 1],
                widths: vec![1; length],
            };
            let schedule = schedule(&dag);
            check(&dag, &schedule);
            assert!(schedule.slots_needed <= 2);
        }
    }

    #[test]
    fn a_balanced_binary_tree_needs_its_depth_plus_one() {
        for depth in 1..10u32 {
            let count = (1usize << (depth + 1)) - 1; // heap order, backwards: inputs come first
            let inputs = (0..count)
                .map(|v| {
                    let heap = count - 1 - v;
                    let children = [2 * heap + 1, 2 * heap + 2];
                    if children[1] < count {
                        children.iter().map(|c| count - 1 - c).collect()
                    } else {
                        vec![]
                    }
                })
                .collect();
            let dag = Dag {
                inputs,
                roots: vec![count - 1],
                widths: vec![1; count],
            };
            let schedule = schedule(&dag);
            check(&dag, &schedule);
            assert_eq!(schedule.slots_needed, depth + 1, "depth {depth}");
        }
    }

    #[test]
    fn small_dags_are_solved_exactly() {
        let mut seed = 1;
        for round in 0..300 {
            let dag = random_dag(1 + round % 8, &mut seed);
            let schedule = schedule(&dag);
            check(&dag, &schedule);
            assert_eq!(schedule.slots_needed as usize, brute_force(&dag), "{dag:?}");
        }
    }

    #[test]
    fn depth_first_orders_are_close_to_the_least() {
        let mut seed = 7;
        let (mut found, mut least) = (0, 0);
        for _ in 0..200 {
            let dag = random_dag(12, &mut seed);
            found += peak(&dag, &best_depth_first_order(&dag));
            least += peak(&dag, &exact_order(&dag));
        }
        assert!(
            found * 100 <= least * 112,
            "{found} slots where {least} suffice"
        );
    }

    #[test]
    fn large_dags_are_scheduled_correctly() {
        let mut seed = 3;
        for count in [13, 100, 1000, 3000] {
            let dag = random_dag(count, &mut seed);
            check(&dag, &schedule(&dag));
        }
    }
}
