//! Expressions of equations: read from text, written as MathML, and evaluated, so that what is typeset can be held against
//! the formula that computes.

use std::fmt::Write;

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    /// A number, as written.
    Number(String),
    /// A symbol; what follows an underscore is an index.
    Symbol(String),
    /// A square root.
    Root(Box<Expression>),
    /// A cube root.
    CubeRoot(Box<Expression>),
    /// Two expressions with an operator: `+ - * / ^`.
    Pair(Box<Expression>, char, Box<Expression>),
}

impl Expression {
    /// Reads an expression: numbers, symbols, `+ - * / ^`, parentheses, `sqrt(...)`, `cbrt(...)`.
    ///
    /// # Errors
    /// What was expected, and where.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut reader = Reader { rest: text };
        let expression = reader.sum()?;
        reader.skip();
        if reader.rest.is_empty() { Ok(expression) } else { Err(reader.expected("an operator")) }
    }

    /// Its value; nothing for a symbol without one.
    #[cfg(test)]
    pub fn value(&self, of: &impl Fn(&str) -> Option<f64>) -> Option<f64> {
        Some(match self {
            Self::Number(text) => text.parse().ok()?,
            Self::Symbol(name) => of(name)?,
            Self::Root(inner) => inner.value(of)?.sqrt(),
            Self::CubeRoot(inner) => inner.value(of)?.cbrt(),
            Self::Pair(a, operator, b) => {
                let (a, b) = (a.value(of)?, b.value(of)?);
                match operator {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    '/' => a / b,
                    _ => a.powf(b),
                }
            }
        })
    }

    /// As MathML Core, without the element `math`.
    pub fn to_math_ml(&self) -> String {
        match self {
            Self::Number(text) => format!("<mn>{text}</mn>"),
            Self::Symbol(name) => symbol(name),
            Self::Root(inner) => format!("<msqrt>{}</msqrt>", inner.to_math_ml()),
            Self::CubeRoot(inner) => format!("<mroot><mrow>{}</mrow><mn>3</mn></mroot>", inner.to_math_ml()),
            Self::Pair(a, '/', b) => {
                format!("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", a.to_math_ml(), b.to_math_ml())
            }
            Self::Pair(a, '^', b) => {
                format!("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", a.within(3), b.to_math_ml())
            }
            Self::Pair(a, '*', b) => {
                // Numbers side by side need a sign between them.
                let sign = if matches!(**b, Self::Number(_)) { "<mo>×</mo>" } else { "<mo>&#x2062;</mo>" };
                format!("{}{sign}{}", a.within(2), b.within(2))
            }
            Self::Pair(a, '-', b) => format!("{}<mo>−</mo>{}", a.to_math_ml(), b.within(2)),
            Self::Pair(a, _, b) => format!("{}<mo>+</mo>{}", a.to_math_ml(), b.to_math_ml()),
        }
    }

    /// How strongly its parts are bound together.
    fn strength(&self) -> u8 {
        match self {
            Self::Pair(_, '+' | '-', _) => 1,
            Self::Pair(_, '*', _) => 2,
            Self::Pair(_, '^' | '/', _) => 3,
            _ => 4,
        }
    }

    /// As MathML, in parentheses if it is bound less strongly.
    fn within(&self, strength: u8) -> String {
        let is_base = strength == 3 && self.strength() < 4;
        if is_base || self.strength() < strength {
            format!("<mrow><mo>(</mo>{}<mo>)</mo></mrow>", self.to_math_ml())
        } else {
            self.to_math_ml()
        }
    }
}

/// A symbol as MathML: `rho` is a Greek letter, `A_r` and `Gi` have an index.
fn symbol(name: &str) -> String {
    let (name, index) = name.split_once('_').unwrap_or((name, ""));
    let (name, index) = match (name, index) {
        ("Gi" | "Gf", "") => name.split_at(1),
        other => other,
    };
    let letter = match name {
        "rho" => "ρ",
        other => other,
    };
    let mut text = format!("<mi>{letter}</mi>");
    if !index.is_empty() {
        text.clear();
        let _ = write!(text, "<msub><mi>{letter}</mi><mi>{index}</mi></msub>");
    }
    text
}

struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn expected(&self, what: &str) -> String {
        format!("expected {what} before \"{}\"", self.rest)
    }

    /// One of `operators`, if it is next.
    fn operator(&mut self, operators: &[char]) -> Option<char> {
        self.skip();
        let next = self.rest.chars().next().filter(|c| operators.contains(c))?;
        self.rest = &self.rest[next.len_utf8()..];
        Some(next)
    }

    fn sum(&mut self) -> Result<Expression, String> {
        let mut left = self.product()?;
        while let Some(operator) = self.operator(&['+', '-']) {
            left = Expression::Pair(left.into(), operator, self.product()?.into());
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Expression, String> {
        let mut left = self.power()?;
        while let Some(operator) = self.operator(&['*', '/']) {
            left = Expression::Pair(left.into(), operator, self.power()?.into());
        }
        Ok(left)
    }

    fn power(&mut self) -> Result<Expression, String> {
        let base = self.term()?;
        Ok(match self.operator(&['^']) {
            Some(operator) => Expression::Pair(base.into(), operator, self.term()?.into()),
            None => base,
        })
    }

    fn term(&mut self) -> Result<Expression, String> {
        if self.operator(&['(']).is_some() {
            let inner = self.sum()?;
            return self.operator(&[')']).map(|_| inner).ok_or_else(|| self.expected("a parenthesis"));
        }
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        if word.is_empty() {
            return Err(self.expected("a number or a symbol"));
        }
        self.rest = rest;
        Ok(match word {
            "sqrt" => Expression::Root(self.term()?.into()),
            "cbrt" => Expression::CubeRoot(self.term()?.into()),
            _ if word.starts_with(|c: char| c.is_ascii_digit()) => Expression::Number(word.into()),
            _ => Expression::Symbol(word.into()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_have_the_usual_precedence_and_their_parentheses() {
        let value = |text: &str| Expression::read(text).unwrap().value(&|name| (name == "a").then_some(3.0));
        assert_eq!(value("2 + a * 4 - 1"), Some(13.0));
        assert_eq!(value("(2 + a) * a ^ 2 / sqrt(9)"), Some(15.0));
        assert_eq!(
            (value("12 / a / 2"), value("a - (a - 1)"), value("cbrt(8) * b")),
            (Some(2.0), Some(1.0), None)
        );
        let math = |text: &str| Expression::read(text).unwrap().to_math_ml();
        assert_eq!(
            math("a - (b - c)"),
            "<mi>a</mi><mo>−</mo><mrow><mo>(</mo><mi>b</mi><mo>−</mo><mi>c</mi><mo>)</mo></mrow>"
        );
        assert!(math("(a / b) ^ 2").starts_with("<msup><mrow><mrow><mo>(</mo><mfrac>"));
        assert_eq!(math("C_sm"), "<msub><mi>C</mi><mi>sm</mi></msub>");
        assert!(
            Expression::read("a +").is_err()
                && Expression::read("(a").is_err()
                && Expression::read("a b").is_err()
        );
    }
}
