//! From columns to colours and attributes.

use super::front::{Column, Front};
use crate::doubles::{Doubles, all_stored};
use crate::strokes::Colors;
use crate::{Attribute, AttributeDomain};

/// The colours and the attributes of a table's columns.
pub fn meaning(
    front: &Front,
    columns: Vec<Vec<f64>>,
    warnings: &mut Vec<String>,
) -> (Option<Colors>, Vec<Attribute>) {
    let kinds = front.columns.iter().filter(|c| matches!(c, Column::Color(_) | Column::Value(_)));
    let mut colors: [Option<Vec<f32>>; 4] = Default::default();
    let mut rest = Vec::new();
    let mut all = Vec::new();
    for (kind, values) in kinds.zip(columns) {
        let single = |offset: f64| all_stored(&values, offset);
        match kind {
            Column::Color(k) => colors[*k] = Some(single(0.0)),
            Column::Value(name) => {
                let doubles = Doubles::of(&values);
                all.push(doubles);
                rest.push((name.clone(), single(doubles.offset())));
            }
            Column::Axis(_) | Column::LeftOut(_) => {}
        }
    }
    let is_unnamed = rest.iter().all(|(name, _)| name.is_empty());
    if is_unnamed && !rest.is_empty() {
        let count = rest.len() + 3;
        let first = match count {
            6 | 9 | 10 => Some(0),
            7 => Some(1),
            _ => None,
        };
        // Of the numbers as they are in the file, not less an offset.
        let are = |from: usize, is: fn(&f32) -> bool, rest: &[(String, Vec<f32>)], all: &[Doubles]| {
            let column = |((_, values), doubles): (&(String, Vec<f32>), &Doubles)| {
                values.iter().all(|&v| is(&((doubles.offset() + f64::from(v)) as f32)))
            };
            rest.get(from..from + 3).is_some_and(|three| three.iter().zip(&all[from..]).all(column))
        };
        let is_byte: fn(&f32) -> bool = |v| (0.0..=255.0).contains(v) && v.fract() == 0.0;
        // Bytes of colours are not all 0 or 1; normals along the axes are.
        let is_small: fn(&f32) -> bool = |v| *v <= 1.0;
        let are_colors =
            |first: usize| are(first, is_byte, &rest, &all) && !are(first, is_small, &rest, &all);
        if let Some(first) = first.filter(|&first| are_colors(first)) {
            all.drain(first..first + 3);
            for (k, (_, values)) in rest.drain(first..first + 3).enumerate() {
                colors[k] = Some(values);
            }
        }
        let is_short: fn(&f32) -> bool = |v| v.abs() <= 1.001;
        let has_normals = match (count, rest.len()) {
            (6, 3) => are(0, is_short, &rest, &all),
            (9 | 10, 3 | 4) => are(rest.len() - 3, is_short, &rest, &all),
            _ => false,
        };
        let plain = if has_normals { rest.len() - 3 } else { rest.len() };
        for (k, (name, _)) in rest.iter_mut().enumerate() {
            *name = match k.checked_sub(plain) {
                Some(axis) => Attribute::component_name("normal", axis, 3),
                None => Attribute::component_name("value", k, plain),
            };
        }
    }
    let domain = AttributeDomain::Vertex;
    warnings.extend(rest.iter().zip(&all).filter_map(|((name, _), doubles)| doubles.warning(name, false)));
    let attribute = |((name, values), doubles): (_, Doubles)| Attribute {
        name,
        domain,
        values,
        offset: doubles.offset(),
        component: None,
    };
    (bytes(colors), rest.into_iter().zip(all).map(attribute).collect())
}

/// Colours of components from 0 to 255; or to 1, if none is greater and some are not whole; or of 16 bits, if some are greater.
fn bytes([r, g, b, a]: [Option<Vec<f32>>; 4]) -> Option<Colors> {
    let all = [r?, g?, b?];
    let most = all.iter().flatten().copied().filter(|v| v.is_finite()).fold(0.0f32, f32::max);
    let is_fraction = most <= 1.0 && all.iter().flatten().any(|v| v.fract() != 0.0);
    let scale: f32 = if is_fraction {
        255.0
    } else if most > 255.0 {
        255.0 / 65535.0
    } else {
        1.0
    };
    let byte = |v: f32, scale: f32| (v * scale).round() as u8;
    let alphas = a.unwrap_or_default();
    let alpha_scale = if alphas.iter().all(|&v| v <= 1.0) { 255.0 } else { scale.min(1.0) };
    let color = |i: usize| {
        let of = |k: usize| byte(all[k].get(i).copied().unwrap_or(0.0), scale);
        Some([of(0), of(1), of(2), alphas.get(i).map_or(255, |&a| byte(a, alpha_scale))])
    };
    Some((0..all[0].len()).map(color).collect())
}
