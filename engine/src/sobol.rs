//! Direction numbers of the Sobol sequence: the first dimensions of S. Joe and F. Y. Kuo, "Constructing Sobol sequences with
//! better two-dimensional projections", SIAM J. Sci. Comput. 30, 2008 (their list `new-joe-kuo-6`).

/// Dimensions that are well distributed together: three groups of four, see `random.wgsl`.
pub(crate) const DIMENSIONS: usize = 12;
/// Rows of the directions: a row has four dimensions, a group 32 rows.
const DIRECTIONS: usize = 32 * DIMENSIONS / 4;
/// Rows of the table that kernels read: 16 for each four bits of an index.
pub(crate) const ROWS: usize = 4 * DIRECTIONS;

/// Primitive polynomial over GF(2) and first direction numbers of a dimension: degree, inner coefficients as bits, and as
/// many numbers as the degree says. The first dimension, van der Corput's, has none.
type Polynomial = (usize, u32, &'static [u32]);

const POLYNOMIALS: [Polynomial; DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
];

/// For each bit of a sample's index what it adds, modulo 2, to each dimension. The lowest bit of a number stands for 1/2,
/// the next one for 1/4: scrambling works on numbers turned round like this. Dimension `d` for bit `b` is word `d % 4` of
/// row `32 (d / 4) + b`.
fn directions() -> [[u32; 4]; DIRECTIONS] {
    let mut table = [[0; 4]; DIRECTIONS];
    for (bit, row) in table[..32].iter_mut().enumerate() {
        row[0] = 1 << bit;
    }
    for (dimension, (degree, inner, first)) in POLYNOMIALS.into_iter().enumerate() {
        // Bratley and Fox, "Algorithm 659", 1988, with numbers scaled to 32 bits.
        let mut numbers = [0_u32; 32];
        for bit in 0..32 {
            numbers[bit] = match first.get(bit) {
                Some(first) => first << (31 - bit),
                None => {
                    let mut number = numbers[bit - degree] ^ numbers[bit - degree] >> degree;
                    for k in 1..degree {
                        number ^= (inner >> (degree - 1 - k) & 1) * numbers[bit - k];
                    }
                    number
                }
            };
            let dimension = dimension + 1;
            table[32 * (dimension / 4) + bit][dimension % 4] = numbers[bit].reverse_bits();
        }
    }
    table
}

/// The same for four bits at once: what the value `v` of bits `4 n` to `4 n + 3` adds to group `g` is row
/// `128 g + 16 n + v`. A look-up of a table costs a kernel more than the arithmetic around it.
pub(crate) fn nibbles() -> [[u32; 4]; ROWS] {
    let directions = directions();
    std::array::from_fn(|row| {
        let (first, value) = (row / 16 * 4, row % 16);
        let bits = (0..4).filter(|bit| value >> bit & 1 == 1);
        bits.fold([0; 4], |sum, bit| {
            std::array::from_fn(|d| sum[d] ^ directions[first + bit][d])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u32) -> [f64; DIMENSIONS] {
        let table = nibbles();
        std::array::from_fn(|d| {
            let row = |n: usize| 128 * (d / 4) + 16 * n + (index >> (4 * n) & 15) as usize;
            let word = (0..8).fold(0, |word, n| word ^ table[row(n)][d % 4]);
            f64::from(word.reverse_bits()) / 4_294_967_296.0
        })
    }

    #[test]
    fn the_first_points_are_those_of_the_published_sequence() {
        // In the order of Gray codes, as the authors' program prints them.
        let expected = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
            [0.625, 0.125, 0.875, 0.625],
            [0.125, 0.625, 0.375, 0.125],
        ];
        for (i, expected) in (0_u32..).zip(expected) {
            assert_eq!(point(i ^ i >> 1)[..4], expected, "point {i}");
        }
    }

    #[test]
    fn every_dimension_and_the_first_pair_are_stratified() {
        for (bits, dimension) in (1..10_u32).flat_map(|b| (0..DIMENSIONS).map(move |d| (b, d))) {
            let count = 1_u32 << bits;
            let mut seen = vec![false; count as usize];
            for index in 0..count {
                seen[(point(index)[dimension] * f64::from(count)) as usize] = true;
            }
            assert!(
                seen.iter().all(|&seen| seen),
                "{count} points of {dimension}"
            );
        }
        // A (0, m, 2)-net: one point in each box of area 2^-m, whatever its shape.
        for (bits, wide) in (1..9_u32).flat_map(|b| (0..=b).map(move |w| (b, w))) {
            let (columns, rows) = (1_u32 << wide, 1_u32 << (bits - wide));
            let mut seen = vec![false; (columns * rows) as usize];
            for index in 0..columns * rows {
                let [x, y, ..] = point(index);
                let column = (x * f64::from(columns)) as u32;
                seen[(column * rows + (y * f64::from(rows)) as u32) as usize] = true;
            }
            assert!(seen.iter().all(|&seen| seen), "{columns} x {rows}");
        }
    }
}
