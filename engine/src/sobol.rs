//! Direction numbers of the Sobol sequence: the first dimensions of S. Joe and F. Y. Kuo, "Constructing Sobol sequences with
//! better two-dimensional projections", SIAM J. Sci. Comput. 30, 2008 (their list `new-joe-kuo-6`).

/// Dimensions that are well distributed together: three groups of four, see `random.wgsl`.
pub(crate) const DIMENSIONS: usize = 12;
/// Rows of the table: a row has four dimensions, a group 32 rows.
pub(crate) const ROWS: usize = 32 * DIMENSIONS / 4;

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
pub(crate) fn directions() -> [[u32; 4]; ROWS] {
    let mut table = [[0; 4]; ROWS];
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

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u32) -> [f64; DIMENSIONS] {
        let table = directions();
        std::array::from_fn(|d| {
            let bits = (0..32).filter(|bit| index >> bit & 1 == 1);
            let word = bits.fold(0, |word, bit| word ^ table[32 * (d / 4) + bit][d % 4]);
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
