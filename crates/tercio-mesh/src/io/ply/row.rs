//! One instance of an element in ASCII.

use super::header::{Element, Shape};
use super::malformed;
use super::plan::{Plan, Role};
use super::table::Lists;
use crate::error::{Place, ReadError};
use crate::io::text::Cursor;

/// What parts the instances of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spacing {
    /// Any white space parts numbers, as the format is defined.
    Free,
    /// Every instance begins and ends with a line, exactly.
    Strict,
    /// Every instance begins with a line; more on the line is left out, and lists that nobody needs may
    /// be missing at its end.
    Lenient,
}

/// Why an instance could not be read.
#[derive(Debug)]
pub(super) enum Trouble {
    /// The instance is longer or shorter than its line, which is allowed under another [`Spacing`].
    Layout(ReadError),
    /// Wrong under any spacing.
    Wrong(ReadError),
}

impl Trouble {
    pub(super) fn into_error(self) -> ReadError {
        match self {
            Self::Layout(error) | Self::Wrong(error) => error,
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Value,
    Corners { float: bool },
    Wedges,
    SkippedList,
}

/// Parses the instances of one element.
#[derive(Debug)]
pub(super) struct Row<'a> {
    file: &'a str,
    element: &'a Element,
    plan: &'a Plan,
    spacing: Spacing,
    steps: Vec<Step>,
}

impl<'a> Row<'a> {
    pub(super) fn new(file: &'a str, element: &'a Element, plan: &'a Plan, spacing: Spacing) -> Self {
        let step = |(i, shape)| match shape {
            Shape::One(_) => Step::Value,
            Shape::List { item, .. } if plan.corners == Some(i) => Step::Corners { float: item.is_float() },
            Shape::List { .. } if plan.wedges == Some(i) => Step::Wedges,
            Shape::List { .. } => Step::SkippedList,
        };
        let steps = element.properties.iter().map(|p| p.shape).enumerate().map(step).collect();
        Self { file, element, plan, spacing, steps }
    }

    /// Properties of an instance.
    pub(super) fn width(&self) -> usize {
        self.steps.len()
    }

    /// Parses one instance; its scalars go to `values`, one a property, its lists behind `lists`.
    #[inline]
    pub(super) fn parse(
        &self,
        cursor: &mut Cursor,
        row: usize,
        values: &mut [f64],
        lists: &mut Lists,
    ) -> Result<(), Trouble> {
        for (i, (step, value)) in self.steps.iter().zip(values).enumerate() {
            match *step {
                Step::Value => *value = self.float(cursor, row, i)?,
                Step::Corners { float } => {
                    let length = self.length(cursor, row, i)?;
                    lists.counts.push(length);
                    for _ in 0..length {
                        lists.corners.push(self.corner(cursor, row, i, float)?);
                    }
                }
                Step::Wedges => {
                    let length = self.length(cursor, row, i)?;
                    lists.wedge_counts.push(length);
                    for _ in 0..length {
                        lists.wedges.push(self.float(cursor, row, i)? as f32);
                    }
                }
                Step::SkippedList => {
                    if self.spacing == Spacing::Lenient && cursor.line_is_over() {
                        continue;
                    }
                    for _ in 0..self.length(cursor, row, i)? {
                        self.float(cursor, row, i)?;
                    }
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn float(&self, cursor: &mut Cursor, row: usize, property: usize) -> Result<f64, Trouble> {
        if self.spacing == Spacing::Free {
            cursor.skip_space();
        }
        cursor.float().ok_or_else(|| self.trouble(cursor, "a number", row, property))
    }

    #[inline]
    fn length(&self, cursor: &mut Cursor, row: usize, property: usize) -> Result<u32, Trouble> {
        if self.spacing == Spacing::Free {
            cursor.skip_space();
        }
        let mut ahead = cursor.clone();
        let length = ahead.integer().and_then(|n| u32::try_from(n).ok());
        let length = length.ok_or_else(|| self.trouble(cursor, "a list length", row, property))?;
        // Every number takes a digit and something that parts it from the one before.
        let left = ahead.rest().len() / 2;
        if length as usize > left {
            let expected = format!("{length} numbers for {}", self.name(row, property));
            let found = format!("{} bytes", ahead.rest().len());
            return Err(Trouble::Layout(malformed(self.file, Place::Line(cursor.line()), expected, found)));
        }
        *cursor = ahead;
        Ok(length)
    }

    #[inline]
    fn corner(&self, cursor: &mut Cursor, row: usize, property: usize, float: bool) -> Result<u32, Trouble> {
        if self.spacing == Spacing::Free {
            cursor.skip_space();
        }
        let before = cursor.clone();
        if !float && self.plan.role == Role::Faces {
            // The usual case, kept short.
            if let Some(number) = cursor.integer().and_then(|n| u32::try_from(n).ok())
                && number < self.plan.vertices
            {
                return Ok(number);
            }
        }
        *cursor = before.clone();
        let value = if float { cursor.float() } else { cursor.integer().map(|n| n as f64) };
        match value.and_then(|value| self.plan.vertex(value)) {
            Some(number) => Ok(number),
            None => {
                *cursor = before;
                Err(self.trouble(cursor, &self.plan.expected_vertex(), row, property))
            }
        }
    }

    fn name(&self, row: usize, property: usize) -> String {
        let name = self.element.properties.get(property).map_or("", |p| p.name.as_str());
        format!("{name} of element {} {row}", self.element.name)
    }

    #[cold]
    fn trouble(&self, cursor: &mut Cursor, expected: &str, row: usize, property: usize) -> Trouble {
        let error = cursor.expected(self.file, format!("{expected} for {}", self.name(row, property)));
        if self.spacing != Spacing::Free && cursor.line_is_over() {
            Trouble::Layout(error)
        } else {
            Trouble::Wrong(error)
        }
    }

    /// The error for more on the line than the instance takes.
    #[cold]
    pub(super) fn surplus(&self, cursor: &Cursor, row: usize) -> Trouble {
        let expected = format!("the end of the line behind element {} {row}", self.element.name);
        Trouble::Layout(cursor.expected(self.file, expected))
    }
}
