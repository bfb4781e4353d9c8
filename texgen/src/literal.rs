//! Values as people write them in `@param` defaults: numbers, `true`, colours like `#c46a2a`, and lists in round
//! or square brackets.

use crate::value::color_from_hex;

/// A written value, not yet of any type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Literal {
    Number(f64),
    Bool(bool),
    /// Linear RGBA.
    Color([f32; 4]),
    List(Vec<Literal>),
}

impl Literal {
    /// As a finite f32.
    pub(crate) fn number(&self) -> Option<f32> {
        match self {
            Literal::Number(number) => Some(*number as f32).filter(|number| number.is_finite()),
            _ => None,
        }
    }

    /// As a whole number.
    pub(crate) fn integer(&self) -> Option<i64> {
        match self {
            Literal::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                Some(*number as i64)
            }
            _ => None,
        }
    }

    /// As N components: a list of N numbers, one number for all, or a colour. Three components make an opaque
    /// colour of four.
    pub(crate) fn vector<const N: usize>(&self) -> Option<[f32; N]> {
        let components: Vec<f32> = match self {
            Literal::Number(_) => vec![self.number()?; N],
            Literal::Color(color) if N >= 3 => color[..N].to_vec(),
            Literal::List(items) => {
                let mut components = items
                    .iter()
                    .map(Literal::number)
                    .collect::<Option<Vec<f32>>>()?;
                if N == 4 && components.len() == 3 {
                    components.push(1.0);
                }
                components
            }
            _ => return None,
        };
        components.try_into().ok()
    }

    /// As N columns of N numbers.
    pub(crate) fn columns<const N: usize>(&self) -> Option<[[f32; N]; N]> {
        let Literal::List(items) = self else {
            return None;
        };
        let columns = items
            .iter()
            .map(|item| {
                matches!(item, Literal::List(_))
                    .then(|| item.vector())
                    .flatten()
            })
            .collect::<Option<Vec<[f32; N]>>>()?;
        columns.try_into().ok()
    }
}

/// Parses one literal that is the whole text.
///
/// # Errors
/// The end of a sentence that begins with "the default of `x`".
pub(crate) fn parse(text: &str) -> Result<Literal, String> {
    let mut rest = text.trim();
    let literal = parse_one(&mut rest, 0)?;
    if rest.trim().is_empty() {
        Ok(literal)
    } else {
        Err(format!("is followed by `{}`", rest.trim()))
    }
}

fn parse_one(rest: &mut &str, depth: usize) -> Result<Literal, String> {
    *rest = rest.trim_start();
    let close = match rest.chars().next() {
        None => return Err("is missing".into()),
        Some('(') => ')',
        Some('[') => ']',
        Some(_) => return parse_word(rest),
    };
    if depth > 4 {
        return Err("is nested too deeply".into());
    }
    *rest = &rest[1..];
    let mut items = Vec::new();
    loop {
        *rest = rest.trim_start();
        if let Some(behind) = rest.strip_prefix(close) {
            *rest = behind;
            return Ok(Literal::List(items));
        }
        if rest.is_empty() {
            return Err(format!("lacks a closing `{close}`"));
        }
        items.push(parse_one(rest, depth + 1)?);
        *rest = rest.trim_start();
        match rest.strip_prefix(',') {
            Some(behind) => *rest = behind,
            None if rest.starts_with(close) => {}
            None if rest.is_empty() => {}
            None => return Err(format!("lacks a comma before `{rest}`")),
        }
    }
}

fn parse_word(rest: &mut &str) -> Result<Literal, String> {
    let end = rest
        .find(|c: char| c.is_whitespace() || matches!(c, ',' | '(' | ')' | '[' | ']'))
        .unwrap_or(rest.len());
    let word = &rest[..end];
    *rest = &rest[end..];
    let word = word.trim_matches('"'); // colours may be quoted as in a look file
    match word {
        "true" => return Ok(Literal::Bool(true)),
        "false" => return Ok(Literal::Bool(false)),
        _ => {}
    }
    if word.starts_with('#') {
        return color_from_hex(word)
            .map(Literal::Color)
            .ok_or_else(|| format!("holds `{word}`, which is not a colour like `#c46a2a`"));
    }
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(Literal::Number(number)),
        _ => Err(format!("holds `{word}`, which is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lists_and_colours() {
        assert_eq!(parse(" 2.5 "), Ok(Literal::Number(2.5)));
        assert_eq!(
            parse("(1, 0, 0)").map(|l| l.vector::<3>()),
            Ok(Some([1.0, 0.0, 0.0]))
        );
        assert_eq!(
            parse("[1,0.5,0,]").map(|l| l.vector::<4>()),
            Ok(Some([1.0, 0.5, 0.0, 1.0]))
        );
        assert_eq!(
            parse("#ffffff").map(|l| l.vector::<3>()),
            Ok(Some([1.0; 3]))
        );
        assert_eq!(
            parse("((1,0),(0,1))").map(|l| l.columns::<2>()),
            Ok(Some([[1.0, 0.0], [0.0, 1.0]]))
        );
        assert_eq!(parse("3").map(|l| l.integer()), Ok(Some(3)));
        assert_eq!(parse("2").map(|l| l.vector::<2>()), Ok(Some([2.0, 2.0])));
    }

    #[test]
    fn problems_are_sentences() {
        for (text, problem) in [
            ("", "is missing"),
            ("(1, 2", "lacks a closing `)`"),
            ("1 2", "is followed by `2`"),
            ("(1 2)", "lacks a comma before `2)`"),
            ("nan", "holds `nan`, which is not a number"),
            ("#12", "holds `#12`, which is not a colour like `#c46a2a`"),
            ("((((((((1))))))))", "is nested too deeply"),
        ] {
            assert_eq!(parse(text), Err(problem.to_owned()), "{text}");
        }
    }
}
