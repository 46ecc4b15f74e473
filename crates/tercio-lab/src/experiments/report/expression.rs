//! Expressions of equations: read from text, written as MathML, and evaluated, so that what is typeset can be held against
//! the formula that computes.

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    /// A number, as written.
    Number(String),
    /// A symbol; what follows an underscore is an index.
    Symbol(String),
    /// A function of one number.
    Of(Function, Box<Expression>),
    /// The sum of the numbers of a list.
    Sum(String),
    /// The negative of an expression.
    Negative(Box<Expression>),
    /// Two expressions with an operator: `+ - * / ^`.
    Pair(Box<Expression>, char, Box<Expression>),
}

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Root,
    CubeRoot,
    Ceiling,
    Floor,
}

impl Expression {
    /// Reads an expression: numbers, symbols, `+ - * / ^`, parentheses, `sqrt(...)`, `cbrt(...)`, `ceil(...)`, `floor(...)`,
    /// and `sum(...)` of a symbol that is a list.
    ///
    /// # Errors
    /// What was expected, and where.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut reader = Reader { rest: text };
        let expression = reader.sum()?;
        reader.skip();
        if reader.rest.is_empty() { Ok(expression) } else { Err(reader.expected("an operator")) }
    }

    /// Its value, where `of` gives the numbers of a symbol; nothing for a symbol without one.
    #[cfg(test)]
    pub fn value(&self, of: &impl Fn(&str) -> Option<Vec<f64>>) -> Option<f64> {
        Some(match self {
            Self::Number(text) => text.parse().ok()?,
            Self::Symbol(name) => match of(name)?[..] {
                [number] => number,
                _ => return None,
            },
            Self::Sum(name) => of(name)?.into_iter().sum(),
            Self::Negative(inner) => -inner.value(of)?,
            Self::Of(function, inner) => {
                let value = inner.value(of)?;
                match function {
                    Function::Root => value.sqrt(),
                    Function::CubeRoot => value.cbrt(),
                    Function::Ceiling => value.ceil(),
                    Function::Floor => value.floor(),
                }
            }
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
            Self::Sum(name) => format!("<mrow><mo>∑</mo>{}</mrow>", symbol(name)),
            Self::Negative(inner) => format!("<mrow><mo>−</mo>{}</mrow>", inner.within(2)),
            Self::Of(function, inner) => {
                let inner = inner.to_math_ml();
                match function {
                    Function::Root => format!("<msqrt>{inner}</msqrt>"),
                    Function::CubeRoot => format!("<mroot><mrow>{inner}</mrow><mn>3</mn></mroot>"),
                    Function::Ceiling => format!("<mrow><mo>⌈</mo>{inner}<mo>⌉</mo></mrow>"),
                    Function::Floor => format!("<mrow><mo>⌊</mo>{inner}<mo>⌋</mo></mrow>"),
                }
            }
            Self::Pair(a, '/', b) => {
                format!("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", a.to_math_ml(), b.to_math_ml())
            }
            Self::Pair(a, '^', b) => {
                format!("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", a.within(3), b.to_math_ml())
            }
            Self::Pair(a, '*', b) => {
                // Numbers and words side by side need a sign between them.
                let is_apart = matches!(**b, Self::Number(_)) || a.has_words() || b.has_words();
                let sign = if is_apart { "<mo>×</mo>" } else { "<mo>&#x2062;</mo>" };
                format!("{}{sign}{}", a.within(2), b.within(2))
            }
            Self::Pair(a, '-', b) => format!("{}<mo>−</mo>{}", a.to_math_ml(), b.within(2)),
            Self::Pair(a, _, b) => format!("{}<mo>+</mo>{}", a.to_math_ml(), b.to_math_ml()),
        }
    }

    /// Is one of its factors a word instead of a letter?
    fn has_words(&self) -> bool {
        match self {
            Self::Symbol(name) => word(name).is_some(),
            Self::Pair(a, '*', b) => a.has_words() || b.has_words(),
            Self::Pair(a, '^', _) => a.has_words(),
            _ => false,
        }
    }

    /// How strongly its parts are bound together.
    fn strength(&self) -> u8 {
        match self {
            Self::Pair(_, '+' | '-', _) | Self::Negative(_) => 1,
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

/// Symbols that are quotients.
const QUOTIENTS: [(&str, &str, &str); 4] =
    [("dpdx", "dp", "dx"), ("dpdy", "dp", "dy"), ("u_over_z", "u", "z"), ("inverse_z", "1", "z")];

/// A symbol as MathML: `rho` is a Greek letter, `A_r`, `Gi` and `t0` have an index, `v0_x` is the x of vertex 0.
fn symbol(name: &str) -> String {
    if let Some((_, above, below)) = QUOTIENTS.iter().find(|q| q.0 == name) {
        return format!("<mfrac><mi>{above}</mi><mi>{below}</mi></mfrac>");
    }
    if let Some(word) = word(name) {
        return format!("<mtext>{word}</mtext>");
    }
    let (base, index) = match name.split_once('_') {
        // Of a point, the letter of its coordinate is the symbol, and of the coefficients theirs.
        Some(("at" | "v" | "coefficients", part)) => (part, ""),
        Some(("v0", part)) => (part, "0"),
        Some(("v1", part)) => (part, "1"),
        Some(("v2", part)) => (part, "2"),
        // Not Δx and Δy, which are the differences of the corners in equation 3.4.
        Some(("steps", part)) => ("s", part),
        Some(("normal", part)) => ("n", part),
        Some((base, index)) => (base, index),
        None => match name.strip_prefix(['G', 't']) {
            Some(index @ ("i" | "f" | "0")) => (&name[..1], index),
            _ => (name, ""),
        },
    };
    let letter = letter(base).replace('\'', "′");
    if index.is_empty() {
        format!("<mi>{letter}</mi>")
    } else {
        format!("<msub><mi>{letter}</mi><mi>{index}</mi></msub>")
    }
}

/// A Greek letter by its name.
fn letter(name: &str) -> &str {
    match name {
        "rho" => "ρ",
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "Gamma" => "Γ",
        "Delta" => "Δ",
        other => other,
    }
}

/// The words of a symbol that is called by words: `lines per polygon`. Letters, with and without index, are none.
fn word(name: &str) -> Option<String> {
    let (base, index) = name.split_once('_').unwrap_or((name, ""));
    let is_letter = letter(base).chars().count() <= 2;
    let is_part = matches!(base, "coefficients" | "steps" | "normal") && !index.is_empty();
    let is_quotient = QUOTIENTS.iter().any(|q| q.0 == name);
    (!is_letter && !is_part && !is_quotient).then(|| name.replace('_', " "))
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
        if self.operator(&['-']).is_some() {
            return Ok(Expression::Negative(self.power()?.into()));
        }
        let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '\'');
        let end = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        if word.is_empty() {
            return Err(self.expected("a number or a symbol"));
        }
        self.rest = rest;
        Ok(match word {
            "sqrt" => Expression::Of(Function::Root, self.term()?.into()),
            "cbrt" => Expression::Of(Function::CubeRoot, self.term()?.into()),
            "ceil" => Expression::Of(Function::Ceiling, self.term()?.into()),
            "floor" => Expression::Of(Function::Floor, self.term()?.into()),
            "sum" => match self.term()? {
                Expression::Symbol(name) => Expression::Sum(name),
                _ => return Err(self.expected("a list in \"sum\"")),
            },
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
        let value = |text: &str| {
            Expression::read(text).unwrap().value(&|name| match name {
                "a" => Some(vec![3.0]),
                "list" => Some(vec![1.0, 2.0, 4.5]),
                _ => None,
            })
        };
        assert_eq!(value("2 + a * 4 - 1"), Some(13.0));
        assert_eq!(value("(2 + a) * a ^ 2 / sqrt(9)"), Some(15.0));
        assert_eq!(
            (value("12 / a / 2"), value("a - (a - 1)"), value("cbrt(8) * b")),
            (Some(2.0), Some(1.0), None)
        );
        assert_eq!((value("-a ^ 2 * 2"), value("ceil(a / 2) - floor(a / 2)")), (Some(-18.0), Some(1.0)));
        assert_eq!((value("2 * sum(list)"), value("list")), (Some(15.0), None));
        let math = |text: &str| Expression::read(text).unwrap().to_math_ml();
        assert_eq!(
            math("a - (b - c)"),
            "<mi>a</mi><mo>−</mo><mrow><mo>(</mo><mi>b</mi><mo>−</mo><mi>c</mi><mo>)</mo></mrow>"
        );
        assert!(math("(a / b) ^ 2").starts_with("<msup><mrow><mrow><mo>(</mo><mfrac>"));
        assert_eq!(math("v1_x"), "<msub><mi>x</mi><mi>1</mi></msub>");
        assert_eq!(math("n * per_slice"), "<mi>n</mi><mo>×</mo><mtext>per slice</mtext>");
        assert_eq!(math("C_sm"), "<msub><mi>C</mi><mi>sm</mi></msub>");
        assert!(
            Expression::read("a +").is_err()
                && Expression::read("(a").is_err()
                && Expression::read("a b").is_err()
                && Expression::read("sum(a + 1)").is_err()
        );
    }
}
