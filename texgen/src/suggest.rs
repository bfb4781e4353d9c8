//! "Did you mean ...?": the known name most like a mistyped one.

/// The candidate nearest to `name`, if it is near enough to be worth suggesting. Letter case counts little.
pub fn did_you_mean<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    // A name of one letter is like any other one: only its case may be wrong.
    let limit = match name.chars().count().min(30) {
        0..=1 => 1,
        length => 2 * (1 + length / 4),
    };
    candidates
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Edit distance with adjacent transpositions (optimal string alignment), in half edits: a change of letter
/// case costs one, everything else two.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).map(|j| 2 * j).collect();
    for i in 1..=a.len() {
        let mut row = vec![2 * i];
        for j in 1..=b.len() {
            let (x, y) = (a[i - 1], b[j - 1]);
            let change = if x == y {
                0
            } else if x.eq_ignore_ascii_case(&y) {
                1
            } else {
                2
            };
            let mut best = (last[j - 1] + change).min(last[j] + 2).min(row[j - 1] + 2);
            if i > 1 && j > 1 && x == b[j - 2] && a[i - 2] == y {
                best = best.min(before[j - 2] + 2);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::did_you_mean;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let names = ["TexCoord0", "WorldPos", "Normal"];
        assert_eq!(did_you_mean("texcoord0", names), Some("TexCoord0"));
        assert_eq!(did_you_mean("WorldPso", names), Some("WorldPos"));
        assert_eq!(did_you_mean("Normals", names), Some("Normal"));
        assert_eq!(did_you_mean("banana_split", names), None);
        assert_eq!(did_you_mean("s", ["t", "S"]), Some("S"));
        assert_eq!(did_you_mean("", ["a"]), None);
        assert_eq!(did_you_mean("x", []), None);
    }
}
