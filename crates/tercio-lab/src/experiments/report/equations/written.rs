//! The documents' equations as text, corrected where the document or the scan is wrong; forms as printed are beside them.
//!
//! An equation is a line `left = right`, or several, separated by `;`, of which each may use the left sides of those before;
//! the last ones are the outcome. `v0_x` is the x of the parameter `v0`, `M_12` the second number of the first row of `M`.

use crate::experiments::Document;

/// The formula that evaluates an equation, and the equation.
pub(super) type Equation = (&'static str, &'static str);

/// Twice the area, and the slopes of the plane through three points, of document 000.
macro_rules! plane {
    () => {
        "Gamma = (v1_x - v0_x) * (v2_y - v0_y) - (v1_y - v0_y) * (v2_x - v0_x); \
         A = ((v1_z - v0_z) * (v2_y - v0_y) - (v1_y - v0_y) * (v2_z - v0_z)) / Gamma; \
         B = ((v1_x - v0_x) * (v2_z - v0_z) - (v1_z - v0_z) * (v2_x - v0_x)) / Gamma"
    };
}

/// The normal of a parameter's plane, of document 001.
macro_rules! normal {
    () => {
        "N_x = (v1_y - v0_y) * (v2_p - v1_p) - (v1_p - v0_p) * (v2_y - v1_y); \
         N_y = (v1_p - v0_p) * (v2_x - v1_x) - (v1_x - v0_x) * (v2_p - v1_p); \
         N_p = (v1_x - v0_x) * (v2_y - v1_y) - (v1_y - v0_y) * (v2_x - v1_x)"
    };
}

/// Equation 7 of document 003.
macro_rules! rate {
    () => {
        "P = T * (A / (sqrt(N) + A - 1)) ^ 2"
    };
}

/// The slopes of equations 7 and 1 of document 003.
macro_rules! slopes {
    () => {
        "P' = 2 * T * A * (sqrt(N) - 1) / (A + sqrt(N) - 1) ^ 3; R' = 2 * 0.000871 * A + 0.00000074645 * P'"
    };
}

/// Places of a box that meet different numbers of regions, of document 003; equation 4 is its last line.
macro_rules! places {
    ($last:literal) => {
        concat!(
            "i = ceil(w / A); alpha = (i * A - w + 1) ^ 2; beta = A ^ 2 - alpha - (",
            $last,
            ") ^ 2; gamma = (",
            $last,
            ") ^ 2"
        )
    };
}

/// The equations of each document.
pub(super) const EQUATIONS: [(Document, &[Equation]); 5] = [
    (Document::Eldridge, ELDRIDGE),
    (Document::Hybris, HYBRIS),
    (Document::Parks, PARKS),
    (Document::McManus, MCMANUS),
    (Document::Ortega, ORTEGA),
];

/// Numbered equations that are no closed formula, and why.
pub(super) const NOT_TYPESET: [(Document, &str, &str); 5] = [
    (Document::Hybris, "overlap.2.5", "an integral over a table of weights, evaluated cell by cell"),
    (Document::Hybris, "overlap.2.6", "an integral over positions, counted at a grid of them"),
    (Document::McManus, "overlap.pixel-boxes-counted", "counts regions at every place of a box"),
    (Document::McManus, "mcmanus.9", "the rate as a function of area is found by search"),
    (Document::McManus, "mcmanus.13-by-search", "the root of P / R = P' / R', found by search"),
];

const ELDRIDGE: &[Equation] = &[
    (
        "eldridge.3.1",
        "x' = M_11 * v_x + M_12 * v_y + M_13 * v_z + M_14; y' = M_21 * v_x + M_22 * v_y + M_23 * v_z + M_24; \
         z' = M_31 * v_x + M_32 * v_y + M_33 * v_z + M_34",
    ),
    ("eldridge.3.2", "X = d * v_x / v_z; Y = d * v_y / v_z"),
    (
        "eldridge.3.4",
        "Delta = M_11 * (M_22 * M_33 - M_23 * M_32) + M_12 * (M_23 * M_31 - M_21 * M_33) + M_13 * (M_21 * M_32 - M_22 * M_31); \
         n'_x = ((M_22 * M_33 - M_23 * M_32) * normal_x + (M_23 * M_31 - M_21 * M_33) * normal_y \
         + (M_21 * M_32 - M_22 * M_31) * normal_z) / Delta; \
         n'_y = ((M_32 * M_13 - M_33 * M_12) * normal_x + (M_33 * M_11 - M_31 * M_13) * normal_y \
         + (M_31 * M_12 - M_32 * M_11) * normal_z) / Delta; \
         n'_z = ((M_12 * M_23 - M_13 * M_22) * normal_x + (M_13 * M_21 - M_11 * M_23) * normal_y \
         + (M_11 * M_22 - M_12 * M_21) * normal_z) / Delta",
    ),
    ("eldridge.3.5", "E = (v0_y - v1_y) * at_x + (v1_x - v0_x) * at_y + v0_x * v1_y - v0_y * v1_x"),
    ("eldridge.3.6", "A = v0_y - v1_y; B = v1_x - v0_x; C = v0_x * v1_y - v0_y * v1_x"),
    ("eldridge.3.11", "Gamma = (v1_x - v0_x) * (v2_y - v0_y) - (v1_y - v0_y) * (v2_x - v0_x)"),
    ("eldridge.3.10", concat!(plane!(), "; C = v0_z - A * v0_x - B * v0_y")),
    ("eldridge.3.14", concat!(plane!(), "; C = v0_z - A * v0_x - B * v0_y")),
    ("eldridge.3.14-as-printed", concat!(plane!(), "; C = v0_z + A * v0_x + B * v0_y")),
    ("eldridge.4.1", "t = p / n * (G + A * R)"),
    ("eldridge.4.2", "t = f * p / n * (o * G + A * R)"),
    ("eldridge.4.2-as-printed", "t = f * p / n * (o * G + A / o * R)"),
    ("eldridge.4.3", "t = p / n * (G + n * C + f * A * R)"),
    ("eldridge.4.3-as-printed", "t = p / n * (G + n * C + f * A / o * R)"),
    ("eldridge.4.4", "t = p / n * (G + A * R) + Q * C"),
    ("eldridge.4.5", "t = p / n * (G + A * R) + p * A * C"),
    ("eldridge.4.6", "C = 3 * a + b"),
    ("eldridge.4.7", "t_middle / t_first = (G + n * C + f * A * R) / (f * (o * G + A * R))"),
    (
        "eldridge.4.8-as-printed",
        "t_middle / t_first = (G + n * C + f * A / o * R) / (f * (o * G + A / o * R))",
    ),
    ("eldridge.4.9", "t_middle / t_first = (G + n * C) / (f * o * G)"),
    ("eldridge.4.10", "f * o = 1 + n * C / G"),
    ("eldridge.4.11", "p = C_dense * Q / (C_sparse * A)"),
    ("eldridge.4.12", "p = C_dense * Q / (C_sm + (f - 1) * A * R / n)"),
    ("eldridge.4.12-as-printed", "p = C_dense * Q / (C_sm + (f / o - 1) * A * R / n)"),
    ("eldridge.5.1", "c = n * C / (n * C + G + f * A * R)"),
    ("eldridge.5.1-as-printed", "c = n * C / (n * C + G + f * A / o * R)"),
    ("eldridge.5.2", "s = (3 * a + b) / a"),
    ("eldridge.5.2-as-printed", "s = a / (3 * a + b)"),
    ("eldridge.5.3", "t = p / n * (n / (2 * d)) * ((2 + d) * a + b)"),
    ("eldridge.5.4", "t = p / n * (d / 2) * (3 * a + b)"),
    ("eldridge.5.5", "t = p / n * (n / (2 * d) * ((2 + d) * a + b) + d / 2 * (3 * a + b))"),
    ("eldridge.5.6", "d = sqrt((2 * a + b) * n / (3 * a + b))"),
    ("eldridge.5.7", "t = p * (sqrt((3 * a + b) * (2 * a + b) / n) + a / 2)"),
    ("eldridge.5.8", "t = p * (m * Gi / n + Gf / (2 * n) + (3 * a + b) / (4 * m))"),
    ("eldridge.5.9", "m = sqrt(n * (3 * a + b) / (4 * Gi))"),
    ("eldridge.5.10", "t = p * (sqrt(Gi * (3 * a + b) / n) + Gf / (2 * n))"),
    ("eldridge.6.1", "t = p / n * (G + g * C + f * A * R)"),
    ("eldridge.6.1-as-printed", "t = p / n * (G + g * C + f * A / o * R)"),
    ("eldridge.6.2", "s = P * (1 / g - 1 / n)"),
    ("eldridge.6.3", "t = P * (1 / g - 1 / n) * ((2 + g) * a + b)"),
    ("eldridge.6.4", "t = a + (2 * a + b) / g"),
    ("eldridge.6.5-factor", "K = ((2 + d) * a + b) / 2"),
    ("eldridge.6.5", "t = K * p * g / n"),
    ("eldridge.6.6", "t = P * (a + (2 * a + b) / g)"),
    ("eldridge.6.7", "g = sqrt((2 * a + b) * P * n / (K * p))"),
    ("eldridge.6.8-squared", "q ^ 2 = 4 * K * (2 * a + b)"),
    ("eldridge.6.8", "t = P * a + growth * sqrt(P * p / n)"),
    ("eldridge.6.9-root", "r = sqrt((3 * a + b) * (2 * a + b))"),
    ("eldridge.7.1", "u = coefficients_A * at_x + coefficients_B * at_y + coefficients_C"),
    ("eldridge.7.3", "u = z * (coefficients_A * at_x + coefficients_B * at_y + coefficients_C)"),
    ("eldridge.7.5", "u = u_over_z / inverse_z"),
    ("eldridge.8.1", "r = n / lines_per_polygon * lines"),
    ("eldridge.8.3", "r = n * passes * lines"),
    ("eldridge.8.4", "r = n * passes * lines / distance"),
    ("eldridge.8.5", "r = columns * pixels * lines"),
    ("eldridge.8.7", "r = n * clock / R"),
    ("eldridge.8.9", "r = columns * pixels * lines * efficiency / A"),
    ("eldridge.8.11", "G = budget * lines_per_polygon"),
    ("eldridge.8.12", "r = polygons * per_polygon * fps"),
    ("eldridge.8.13", "C = budget / passes * n"),
    ("eldridge.8.14", "C = budget / passes * n * passes_per_polygon"),
    ("eldridge.8.16", "R = budget * (fetch + height / pixels)"),
    ("eldridge.8.17", "r = slices * per_slice * n * fps"),
];

const HYBRIS: &[Equation] = &[
    ("overlap.2.1", "O = (1 + w / W) * (1 + h / H)"),
    ("overlap.2.2", "O = (1 + s / sqrt(R * A_r)) * (1 + s / sqrt(A_r / R))"),
    ("overlap.2.2-as-printed", "O = (1 + s / (R * sqrt(A_r))) * (1 + R * s / sqrt(A_r))"),
    ("overlap.tile-sides", "W = sqrt(R * A_r); H = sqrt(A_r / R)"),
    ("overlap.tile-sides-as-printed", "W = R * sqrt(A_r); H = sqrt(A_r) / R"),
    ("overlap.tile-aspect", "W = sqrt(R * A_r); H = sqrt(A_r / R); r = W / H"),
    ("overlap.2.3", "O = (1 + w / S) * (1 + h / S)"),
    ("overlap.2.4", "O = (1 + sqrt(rho * a) / S) ^ 2"),
    ("overlap.2.7", "O = 3 + 1 / rho"),
    ("overlap.2.7-excess", "O - 3 = 1 / rho"),
    ("overlap.2.8", "O = 1 + 2 * s / S + s ^ 2 / (rho * S ^ 2)"),
    ("overlap.2.9", "O = 1 + 2 * sqrt(rho * a) / S + a / S ^ 2"),
    ("overlap.2.10", "O = 1 + (w + h) / S + a / S ^ 2"),
    ("overlap.2.11", "O = (rho - 1) * a / S ^ 2"),
    ("hybris.3.1", "p = left + (1 - (x_left - rx_left)) * dpdx"),
    ("hybris.3.2", "k = 1 - (x_left - rx_left)"),
    ("hybris.3.3", "F = coefficients_A * at_x + coefficients_B * at_y + coefficients_C"),
    ("hybris.3.4", "E = (at_x - v0_x) * (v1_y - v0_y) - (at_y - v0_y) * (v1_x - v0_x)"),
    ("hybris.3.5", "E' = value + steps_x * (v1_y - v0_y) - steps_y * (v1_x - v0_x)"),
    (
        "hybris.3.7",
        "D = v1_x * v2_y - v1_y * v2_x + v2_x * v0_y - v2_y * v0_x + v0_x * v1_y - v0_y * v1_x; \
         A = (v0_p * (v1_y - v2_y) + v1_p * (v2_y - v0_y) + v2_p * (v0_y - v1_y)) / D; \
         B = (v0_p * (v2_x - v1_x) + v1_p * (v0_x - v2_x) + v2_p * (v1_x - v0_x)) / D; \
         C = (v0_p * (v1_x * v2_y - v1_y * v2_x) + v1_p * (v2_x * v0_y - v2_y * v0_x) \
         + v2_p * (v0_x * v1_y - v0_y * v1_x)) / D",
    ),
    ("hybris.3.8", normal!()),
    (
        "hybris.3.9",
        concat!(normal!(), "; F = N_x * (at_x - v0_x) + N_y * (at_y - v0_y) + N_p * (at_p - v0_p)"),
    ),
    ("hybris.3.10", concat!(normal!(), "; p = v0_p - N_x / N_p * (at_x - v0_x) - N_y / N_p * (at_y - v0_y)")),
    ("hybris.3.11", concat!(normal!(), "; dpdx = -N_x / N_p; dpdy = -N_y / N_p")),
    ("hybris.3.13", "r = (n + 2) / n"),
    ("hybris.4.1", "B = w * h * d * f"),
    ("amdahl.4.2", "t = parallel / speed_up + serial"),
    ("amdahl.4.3", "t = parallel + serial"),
    ("amdahl.4.5", "S = dual / single"),
    ("amdahl.4.5-as-printed", "S = single / dual"),
    ("amdahl.4.6", "S = parallel / (dual - serial)"),
    ("amdahl.4.7", "S = (1 / single - 1 / idle) / (1 / dual - 1 / idle)"),
];

const PARKS: &[Equation] = &[
    ("parks.scene", "t = 139 * N + 319.3 * V + 158 * S + 21 * P"),
    ("parks.polygon", "t = 139 + 319.3 * V + 158 * height + 21 * area"),
    ("parks.interlace", "t = 139 * N + 319.3 * V + 158 * S / k + 21 * P / k ^ 2"),
];

const MCMANUS: &[Equation] = &[
    ("mcmanus.1", "R = 0.000871 * A ^ 2 + 0.00000074645 * P + 1.3673"),
    ("mcmanus.geometry-area", "R = 0.00000074645 * P + 1.3673"),
    ("mcmanus.array-area", "R = 0.000871 * A ^ 2"),
    ("mcmanus.places", places!("w - (i - 1) * A - 1")),
    ("mcmanus.4-as-printed", places!("w - (i - 1) * A + 1")),
    (
        "mcmanus.6-of-places",
        concat!(
            places!("w - (i - 1) * A - 1"),
            "; C = (i ^ 2 * alpha + (i ^ 2 + i) * beta + (i + 1) ^ 2 * gamma) / A ^ 2"
        ),
    ),
    ("mcmanus.6", "C = ((sqrt(N) + A - 1) / A) ^ 2"),
    ("overlap.pixel-boxes", "C = ((w + A - 1) / A) ^ 2"),
    ("mcmanus.7", rate!()),
    ("mcmanus.8", concat!(rate!(), "; R = 0.000871 * A ^ 2 + 0.00000074645 * P + 1.3673; L = P / R")),
    ("mcmanus.10", concat!(slopes!(), "; L' = P' / R'")),
    ("mcmanus.rate-slope", "P' = 2 * T * A * (sqrt(N) - 1) / (A + sqrt(N) - 1) ^ 3"),
    (
        "mcmanus.11",
        "s = sqrt(N); a = 1.5625; b = 3.75 * s - 5; c = 4.75 * N - 11 * s + 4; d = 3 * N * s - 10 * N + 13 * s; \
         e = N ^ 2 - 4 * N * s - 8 * s + 10 * N; f = 4 * N * s - 8 * N; g = 4 * N; h = 1.5 * s - 2; j = 2 * N - 4 * s; \
         k = 6 * s; P' = T * A ^ 2 * (h * A ^ 2 + j * A + k) \
         / (a * A ^ 6 + b * A ^ 5 + c * A ^ 4 + d * A ^ 3 + e * A ^ 2 + f * A + g)",
    ),
    (
        "mcmanus.11-as-printed",
        "s = sqrt(N); a = 1.5575; b = 3.75 * s; c = 4.75 * N - 11 * s + 4; d = 3 * N * s - 10 * N + 13 * s; \
         e = N ^ 2 - 4 * N * s - 8 * s + 10 * N; f = 4 * N * s - 8 * s + 10 * N; g = 4 * N; h = 1.5 * s - 2; \
         j = 2 * N - 4 * s; k = 2 * s; P' = T * A ^ 2 * (h * A ^ 2 + j * A + k) \
         / (a * A ^ 6 + b * A ^ 5 + c * A ^ 4 + d * A ^ 3 + e * A ^ 2 + f * A + g)",
    ),
    (
        "mcmanus.11-overlap",
        "C = (1.25 * A ^ 3 + (1.5 * sqrt(N) - 2) * A ^ 2 + (N - 2 * sqrt(N)) * A + 2 * sqrt(N)) / A ^ 3",
    ),
    ("mcmanus.12", slopes!()),
    ("mcmanus.13", "A = cbrt((sqrt(N) - 1) * 1.3673 / 0.000871)"),
    ("mcmanus.14", concat!(rate!(), "; P_X = X / A ^ 2 * P")),
    ("mcmanus.14-as-printed", concat!(rate!(), "; P_X = P / (X / A)")),
];

const ORTEGA: &[Equation] = &[
    ("ortega.rate", "r = floor(N / t)"),
    ("ortega.speed-up", "s = t0 / t"),
    ("ortega.step-bytes", "B = polygons * vertices * vertex"),
    ("ortega.volume-bytes", "B = side ^ 3 * cell"),
    ("ortega.memory-per-processor", "m = memory / processors"),
    ("ortega.spare-colors", "s = last - first + 1 - side ^ 2"),
    ("ortega.loop-steps", "s = tallest * ceil(N / processors) + sum(longest) * ceil(buffer / processors)"),
];
