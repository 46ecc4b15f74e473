//! Where a model is in the world.

use clap::Args;
use serde_json::{Value, json};
use tercio::glam::{DAffine3, DMat3, DVec3};
use tercio::mesh::trig::sin_cos_degrees;

use super::values;

/// Factors and sums of a transform, so that squares of coordinates do not overflow.
const LARGEST: f64 = 1e100;

/// Scales, turns and moves a model, in this order.
#[derive(Clone, Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Several models")]
pub struct PlaceArgs {
    /// Moves the model by X,Y,Z, in units of its coordinates, after --scale and --rotate.
    #[arg(long, value_name = "X,Y,Z", allow_negative_numbers = true, value_parser = values::vector)]
    #[arg(allow_hyphen_values = true)]
    translate: Option<DVec3>,
    /// Turns the model round the origin by degrees about the axes x, then y, then z of the world, counter-clockwise seen from the
    /// end of the axis.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    rotate: Option<DVec3>,
    /// Makes the model larger by a factor, or by one along each axis; negative ones mirror it.
    #[arg(long, value_name = "FACTOR|X,Y,Z", allow_hyphen_values = true, value_parser = scale)]
    scale: Option<DVec3>,
    /// Transforms the model by a matrix, row by row: 12 numbers, or 16 with a last row 0,0,0,1; columns are multiplied from the right.
    #[arg(long, value_name = "NUMBERS", allow_hyphen_values = true, value_parser = matrix)]
    #[arg(conflicts_with_all = ["translate", "rotate", "scale"])]
    matrix: Option<DAffine3>,
}

/// One factor, or one for each axis.
pub fn scale(text: &str) -> Result<DVec3, String> {
    let factors = match values::number(text.trim()) {
        Ok(factor) => DVec3::splat(factor),
        Err(_) => values::vector(text).map_err(|_| "expected a factor, or three: x,y,z".to_owned())?,
    };
    checked(DAffine3::from_scale(factors)).map(|_| factors)
}

/// 12 or 16 numbers, row by row.
pub fn matrix(text: &str) -> Result<DAffine3, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|word| values::number(word.trim()).ok()).collect();
    let count = text.split(',').count();
    if numbers.len() != count || !matches!(count, 12 | 16) {
        return Err("expected 12 or 16 numbers, row by row".into());
    }
    if count == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err("expected 0,0,0,1 as the last row: lines stay parallel".into());
    }
    let column = |k: usize| DVec3::new(numbers[k], numbers[4 + k], numbers[8 + k]);
    checked(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

/// A transform that leaves a model its three dimensions.
fn checked(transform: DAffine3) -> Result<DAffine3, String> {
    let largest = transform.to_cols_array().into_iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if largest > LARGEST {
        return Err(format!("expected numbers of at most {LARGEST:e}"));
    }
    let inverse = transform.matrix3.inverse();
    if transform.matrix3.determinant() == 0.0 || !inverse.is_finite() {
        return Err("expected a transform that can be undone: this one makes the model flat".into());
    }
    Ok(transform)
}

/// The turn about x, then y, then z.
fn turn(degrees: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(sin_cos_degrees);
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let about_y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
    let about_z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

impl PlaceArgs {
    /// Sets one of the options by its name, for tables of instances; `None` if there is no such option.
    pub fn set(&mut self, name: &str, text: &str) -> Option<Result<(), String>> {
        let set = |place: &mut Option<DVec3>, value: Result<DVec3, String>| value.map(|v| *place = Some(v));
        Some(match name {
            "translate" => set(&mut self.translate, values::vector(text)),
            "rotate" => set(&mut self.rotate, values::vector(text)),
            "scale" => set(&mut self.scale, scale(text)),
            "matrix" => matrix(text).map(|m| self.matrix = Some(m)),
            _ => return None,
        })
    }

    /// The options that are given, with texts that [`PlaceArgs::set`] understands.
    pub fn texts(&self) -> Vec<(&'static str, String)> {
        let join = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let vectors = [("translate", self.translate), ("rotate", self.rotate), ("scale", self.scale)];
        let vectors = vectors.into_iter().filter_map(|(name, v)| Some((name, join(&v?.to_array()))));
        let rows = |m: DAffine3| -> Vec<f64> {
            (0..3).flat_map(|k| m.matrix3.row(k).to_array().into_iter().chain([m.translation[k]])).collect()
        };
        let matrix = self.matrix.map(|matrix| ("matrix", join(&rows(matrix))));
        vectors.chain(matrix).collect()
    }

    /// Whether both a matrix and other transforms are given.
    pub fn is_twice(&self) -> bool {
        self.matrix.is_some() && (self.translate.is_some() || self.rotate.is_some() || self.scale.is_some())
    }

    /// From the coordinates of the model's file to the world.
    pub fn transform(&self) -> DAffine3 {
        if let Some(matrix) = self.matrix {
            return matrix;
        }
        let mut matrix3 = self.rotate.map_or(DMat3::IDENTITY, turn);
        if let Some(scale) = self.scale {
            matrix3 *= DMat3::from_diagonal(scale);
        }
        DAffine3 { matrix3, translation: self.translate.unwrap_or(DVec3::ZERO) }
    }
}

/// The rows of a transform, for reports.
pub fn json(transform: &DAffine3) -> Value {
    let row = |k: usize| {
        let [x, y, z] = transform.matrix3.row(k).to_array();
        [x, y, z, transform.translation[k]]
    };
    json!([row(0), row(1), row(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(options: &[(&str, &str)]) -> PlaceArgs {
        let mut place = PlaceArgs::default();
        for (name, text) in options {
            place.set(name, text).expect("an option").expect("a value");
        }
        place
    }

    #[test]
    fn models_are_scaled_then_turned_then_moved() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        let at = |options: &[(&str, &str)]| place(options).transform().transform_point3(p);
        assert_eq!(place(&[]).transform(), DAffine3::IDENTITY);
        assert_eq!(at(&[("translate", "10,0,-1")]), DVec3::new(11.0, 2.0, 2.0));
        assert_eq!(at(&[("scale", "2")]), p * 2.0);
        assert_eq!(at(&[("scale", "1,-1,4")]), DVec3::new(1.0, -2.0, 12.0));
        // Quarter turns are exact, and counter-clockwise.
        assert_eq!(at(&[("rotate", "90,0,0")]), DVec3::new(1.0, -3.0, 2.0));
        assert_eq!(at(&[("rotate", "0,90,0")]), DVec3::new(3.0, 2.0, -1.0));
        assert_eq!(at(&[("rotate", "0,0,90")]), DVec3::new(-2.0, 1.0, 3.0));
        // x first: (1, 2, 3) -> (1, -3, 2) -> (3, 1, 2).
        assert_eq!(at(&[("rotate", "90,0,90")]), DVec3::new(3.0, 1.0, 2.0));
        let all = [("scale", "2"), ("rotate", "0,0,90"), ("translate", "1,0,0")];
        assert_eq!(at(&all), DVec3::new(-3.0, 2.0, 6.0));
        assert_eq!(at(&[("matrix", "0,-1,0,5, 1,0,0,6, 0,0,2,7")]), DVec3::new(3.0, 7.0, 13.0));
        assert_eq!(at(&[("matrix", "0,-1,0,5,1,0,0,6,0,0,2,7,0,0,0,1")]), DVec3::new(3.0, 7.0, 13.0));
        let turned = turn(DVec3::new(30.0, -70.0, 200.0));
        assert!((turned.determinant() - 1.0).abs() < 1e-12);
        assert!((turned * turned.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    }

    #[test]
    fn transforms_that_lose_a_dimension_are_refused() {
        for bad in ["0", "1,0,1", "x", "1,2", "inf", "1e200", ""] {
            assert!(scale(bad).is_err(), "{bad}");
        }
        for bad in
            ["1,0,0", "1,0,0,0,0,1,0,0,1,1,0,0", "1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1", "1,0,0,0,0,1,0,0,0,0,1,x"]
        {
            assert!(matrix(bad).is_err(), "{bad}");
        }
    }
}
