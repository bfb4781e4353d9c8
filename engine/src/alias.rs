//! Alias tables: one of many by weight, in constant time (Walker 1977; Vose 1991).

/// One cell of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AliasCell {
    /// The cell is kept when a uniform number is below.
    pub threshold: f32,
    /// What is chosen otherwise.
    pub alias: u32,
    /// Probability of this index.
    pub probability: f32,
}

/// Table over `weights`, none of them negative. All weights zero gives a uniform table.
pub fn alias_table(weights: &[f64]) -> Vec<AliasCell> {
    let count = weights.len();
    let total: f64 = weights.iter().sum();
    let probability = |w: f64| {
        if total > 0.0 {
            w / total
        } else {
            1.0 / count as f64
        }
    };
    let mut scaled: Vec<f64> = weights
        .iter()
        .map(|&w| probability(w) * count as f64)
        .collect();
    let mut cells: Vec<AliasCell> = weights
        .iter()
        .enumerate()
        .map(|(i, &w)| AliasCell {
            threshold: 1.0,
            alias: i as u32,
            probability: probability(w) as f32,
        })
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..count).partition(|&i| scaled[i] < 1.0);
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        cells[s].threshold = scaled[s] as f32;
        cells[s].alias = l as u32;
        scaled[l] -= 1.0 - scaled[s];
        if scaled[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // What is left over differs from 1 by rounding only, and keeps its threshold of 1.
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_reproduces_the_weights() {
        let weights = [0.0, 3.0, 1.0, 0.5, 7.5, 1e-6];
        let cells = alias_table(&weights);
        let mut mass = vec![0.0f64; weights.len()];
        for (i, cell) in cells.iter().enumerate() {
            mass[i] += f64::from(cell.threshold);
            mass[cell.alias as usize] += 1.0 - f64::from(cell.threshold);
        }
        let total: f64 = weights.iter().sum();
        for (m, w) in mass.iter().zip(weights) {
            assert!((m / weights.len() as f64 - w / total).abs() < 1e-6);
        }
    }

    #[test]
    fn no_weight_at_all_is_uniform() {
        assert!(
            alias_table(&[0.0; 4])
                .iter()
                .all(|c| (c.probability - 0.25).abs() < 1e-7)
        );
    }
}
