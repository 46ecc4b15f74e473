//! One instance of an element in ASCII.

use super::header::{Element, Shape};
use super::malformed;
use super::plan::{Plan, Role};
use super::table::Lists;
use crate::error::{Place, ReadError};
use crate::io::text::Cursor;

/// What separates the instances of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spacing {
    /// Any white space separates numbers, as the format is defined.
    Free,
    /// Every instance is exactly one line.
    Strict,
    /// Every instance begins with a line; surplus on the line is ignored, and unneeded lists may be missing at its
    /// end.
    Lenient,
}

/// Why an instance could not be read.
#[derive(Debug)]
pub(super) enum Trouble {
    /// The line ends before the instance does, which is allowed with another [`Spacing`].
    Short(ReadError),
    /// The line holds more than the instance, which is also allowed with another [`Spacing`].
    Surplus(ReadError),
    /// Wrong with any spacing.
    Wrong(ReadError),
}

impl Trouble {
    pub(super) fn into_error(self) -> ReadError {
        match self {
            Self::Short(error) | Self::Surplus(error) | Self::Wrong(error) => error,
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

    /// Number of properties of an instance.
    pub(super) fn width(&self) -> usize {
        self.steps.len()
    }

    /// Parses one instance; its scalars are written to `values`, one per property, its lists are appended to `lists`.
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
        // Every number takes a digit and a separator.
        let left = ahead.rest().len() / 2;
        if length as usize > left {
            let expected = format!("{length} numbers for {}", self.name(row, property));
            let found = format!("{} bytes up to the end of the file", ahead.rest().len());
            return Err(Trouble::Short(malformed(self.file, Place::Line(cursor.line()), expected, found)));
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
            // The usual case, a fast path.
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
            Trouble::Short(error)
        } else {
            Trouble::Wrong(error)
        }
    }

    /// The error that a line holds more than the instance.
    #[cold]
    pub(super) fn surplus(&self, cursor: &Cursor, row: usize) -> Trouble {
        let expected = format!("the end of the line after element {} {row}", self.element.name);
        Trouble::Surplus(cursor.expected(self.file, expected))
    }
}
