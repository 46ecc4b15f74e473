//! Chapter 5: sort-middle with long strides, and with copies of the database.
//!
//! Assumed throughout: sources and destinations uniform on the ring, one destination a polygon, a full ring. `p`
//! counts all polygons; from equation 5.8 on half of them are visible.

use super::ring::{neighbour_pass, pass};
use super::{DESCRIPTOR, PROCESSORS};
use crate::models;
use crate::models::registry::Model;
use crate::units::{Count, Instructions, Polygons, Processors, Ratio, Words};

/// Instructions to transform and test a polygon (5.4).
const TEST: f64 = 1000.0;
/// Instructions to finish a visible polygon (5.4).
const FINISH: f64 = 5000.0;
/// Visible polygons of the teapot (figure 3-4).
const TEAPOT_VISIBLE: f64 = 6294.0;

/// Equation 5.3: instructions of the first stage, in strides of `d` over the mean distance n/2.
pub fn stride_stage(p: Polygons, n: Processors, d: Processors, a: Words, b: Instructions) -> Instructions {
    pass(a, b, d) * (p.get() / n.get() * (n.get() / 2.0) / d.get())
}

/// Equation 5.4: instructions of the second stage, to the neighbour over the remaining d/2 on the mean.
pub fn alignment_stage(p: Polygons, n: Processors, d: Processors, a: Words, b: Instructions) -> Instructions {
    neighbour_pass(a, b) * (p.get() / n.get() * d.get() / 2.0)
}

/// Equation 5.5: instructions of both stages.
pub fn two_stages(p: Polygons, n: Processors, d: Processors, a: Words, b: Instructions) -> Instructions {
    stride_stage(p, n, d, a, b) + alignment_stage(p, n, d, a, b)
}

/// Equation 5.6: the stride at which [`two_stages`] is least.
pub fn optimal_stride(n: Processors, a: Words, b: Instructions) -> Processors {
    let start = 2.0 * a.get() + b.get();
    Processors::new((start * n.get() / neighbour_pass(a, b).get()).sqrt())
}

/// Equations 5.7 and 6.9: [`two_stages`] at its optimum.
pub fn two_stages_at_optimum(p: Polygons, n: Processors, a: Words, b: Instructions) -> Instructions {
    Instructions::new(p.get() * (pass_root(a, b).get() / n.get().sqrt() + a.get() / 2.0))
}

/// sqrt((3a + b)(2a + b)), the number in equation 6.9 in front of 1/sqrt n.
pub fn pass_root(a: Words, b: Instructions) -> Instructions {
    let start = 2.0 * a.get() + b.get();
    Instructions::new((neighbour_pass(a, b).get() * start).sqrt())
}

/// How many times fewer instructions two stages take than passing to the neighbour over n/2 (5.3).
pub fn distribution_gain(n: Processors, a: Words, b: Instructions) -> Ratio {
    let one = Polygons::new(1.0);
    Ratio::new(neighbour_pass(a, b) * 0.5 / two_stages_at_optimum(one, n, a, b))
}

/// Equation 5.8: instructions of geometry and communication with `m` copies of the database, `p` counting all
/// polygons, half of them visible. The third term is (p/2n)(n/2m)(3a + b); the scan's p/2m in place of p/2n
/// contradicts equations 5.9 and 5.10.
pub fn duplicated(
    p: Polygons,
    m: Ratio,
    n: Processors,
    test: Instructions,
    finish: Instructions,
    a: Words,
    b: Instructions,
) -> Instructions {
    let per_polygon =
        test * (m.get() / n.get()) + finish / (2.0 * n.get()) + neighbour_pass(a, b) / (4.0 * m.get());
    per_polygon * p.get()
}

/// Equation 5.9: the number of copies at which [`duplicated`] is least.
pub fn optimal_copies(n: Processors, test: Instructions, a: Words, b: Instructions) -> Ratio {
    Ratio::new((n.get() * (neighbour_pass(a, b) / (test * 4.0))).sqrt())
}

/// Equation 5.10: [`duplicated`] at its optimum.
pub fn duplicated_at_optimum(
    p: Polygons,
    n: Processors,
    test: Instructions,
    finish: Instructions,
    a: Words,
    b: Instructions,
) -> Instructions {
    let root = Instructions::new((test.get() * neighbour_pass(a, b).get() / n.get()).sqrt());
    (root + finish / (2.0 * n.get())) * p.get()
}

/// Polygons on the fullest processor of the geometry stage, assigned round-robin, with `m` copies (5.5, A.2.1).
pub fn fullest_source(p: Polygons, n: Processors, m: Ratio) -> Count {
    Count::new((p.get() * m.get() / n.get()).ceil())
}

/// Instructions of the geometry stage on the busiest processor: all its polygons are transformed and tested, the
/// visible ones finished (A.2.1).
pub fn geometry_stage(
    p: Polygons,
    n: Processors,
    m: Ratio,
    visible: Polygons,
    test: Instructions,
    finish: Instructions,
) -> Instructions {
    test * fullest_source(p, n, m).get() + finish * visible.get()
}

/// Polygons of the worst processor in excess of its even share, if polygons stay with their screen region (5.5).
pub fn excess(worst: Polygons, p: Polygons, n: Processors) -> Count {
    Count::new(worst.get() - fullest_source(p, n, Ratio::new(1.0)).get())
}

/// Instructions per visible polygon that `polygons` on one processor cost in geometry while the others wait (5.5). The
/// document's 167.8 results for 176 polygons; it prints 166 polygons, for which this gives 158.2.
pub fn waiting(
    polygons: Polygons,
    test: Instructions,
    finish: Instructions,
    visible: Polygons,
) -> Instructions {
    (test + finish) * (polygons / visible)
}

/// Visible polygons on the worst processor over the mean (figure 5-9).
pub fn worst_to_mean(worst: Polygons, visible: Polygons, n: Processors) -> Ratio {
    Ratio::new(worst.get() / (visible.get() / n.get()))
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.5.3", "eq 5.3", "instructions of the stage in strides of d":
        stride_stage["p": Polygons = 1.0, "n": Processors = PROCESSORS, "d": Processors, "a": Words = DESCRIPTOR.0,
            "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.5.4", "eq 5.4", "instructions of the stage to the neighbour":
        alignment_stage["p": Polygons = 1.0, "n": Processors = PROCESSORS, "d": Processors, "a": Words = DESCRIPTOR.0,
            "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.5.5", "eq 5.5", "instructions of both stages of the distribution":
        two_stages["p": Polygons = 1.0, "n": Processors = PROCESSORS, "d": Processors, "a": Words = DESCRIPTOR.0,
            "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.5.6", "eq 5.6", "stride that costs least":
        optimal_stride["n": Processors = PROCESSORS, "a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1]
            -> Processors;
    "eldridge.5.7", "eq 5.7, 6.9", "instructions of the distribution at the best stride":
        two_stages_at_optimum["p": Polygons = 1.0, "n": Processors = PROCESSORS, "a": Words = DESCRIPTOR.0,
            "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.6.9-root", "eq 6.9", "sqrt((3a + b)(2a + b))":
        pass_root["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.distribution-gain", "5.3", "passing to the neighbour over two stages at the best stride":
        distribution_gain["n": Processors = PROCESSORS, "a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1]
            -> Ratio;
    "eldridge.5.8", "eq 5.8", "instructions with m copies of the database, half of p visible":
        duplicated["p": Polygons = 1.0, "m": Ratio where 1.0, "n": Processors = PROCESSORS, "Gi": Instructions = TEST,
            "Gf": Instructions = FINISH, "a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.5.9", "eq 5.9", "number of copies that costs least":
        optimal_copies["n": Processors = PROCESSORS, "Gi": Instructions = TEST, "a": Words = DESCRIPTOR.0,
            "b": Instructions = DESCRIPTOR.1] -> Ratio;
    "eldridge.5.10", "eq 5.10", "instructions with the best number of copies":
        duplicated_at_optimum["p": Polygons = 1.0, "n": Processors = PROCESSORS, "Gi": Instructions = TEST,
            "Gf": Instructions = FINISH, "a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.fullest-source", "A.2.1", "polygons on the fullest processor of the geometry stage":
        fullest_source["p": Polygons, "n": Processors = PROCESSORS, "m": Ratio where 1.0 = 1.0] -> Count;
    "eldridge.geometry-stage", "A.2.1", "instructions of the geometry stage on the fullest processor":
        geometry_stage["p": Polygons, "n": Processors = PROCESSORS, "m": Ratio where 1.0 = 1.0, "most_visible": Polygons,
            "Gi": Instructions = TEST, "Gf": Instructions = FINISH] -> Instructions;
    "eldridge.excess", "5.5", "polygons of the worst processor beyond an even share":
        excess["worst": Polygons, "p": Polygons, "n": Processors = PROCESSORS] -> Count;
    "eldridge.waiting", "5.5", "instructions per visible polygon that polygons on one processor cost":
        waiting["polygons": Polygons, "Gi": Instructions = TEST, "Gf": Instructions = FINISH,
            "visible": Polygons = TEAPOT_VISIBLE] -> Instructions;
    "eldridge.worst-to-mean", "fig 5-9", "visible polygons of the worst processor over the mean":
        worst_to_mean["worst": Polygons, "visible": Polygons = TEAPOT_VISIBLE, "n": Processors = PROCESSORS] -> Ratio;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const A: Words = Words::new(42.0);
    const B: Instructions = Instructions::new(30.0);

    proptest! {
        /// No stride is better than the optimum, and the optimum's own formula agrees with the general one.
        #[test]
        fn stride_optimum(n in 2.0f64..1e6, d in 1.0f64..1e4) {
            let (one, n, d) = (Polygons::new(1.0), Processors::new(n), Processors::new(d));
            let best = two_stages_at_optimum(one, n, A, B).get();
            let at = two_stages(one, n, optimal_stride(n, A, B), A, B).get();
            prop_assert!((best / at - 1.0).abs() < 1e-12);
            prop_assert!(two_stages(one, n, d, A, B).get() >= best * (1.0 - 1e-12));
        }

        #[test]
        fn copies_optimum(n in 2.0f64..1e6, m in 1e-3f64..1e4) {
            let (one, n) = (Polygons::new(1.0), Processors::new(n));
            let (test, finish) = (Instructions::new(1000.0), Instructions::new(5000.0));
            let best = duplicated_at_optimum(one, n, test, finish, A, B).get();
            let at = duplicated(one, optimal_copies(n, test, A, B), n, test, finish, A, B).get();
            prop_assert!((best / at - 1.0).abs() < 1e-12);
            prop_assert!(duplicated(one, Ratio::new(m), n, test, finish, A, B).get() >= best * (1.0 - 1e-12));
        }
    }
}
