//! Speed-up with a part that stays serial: equations 4.2 to 4.7 of document 001, and consequences.

use crate::models;
use crate::models::registry::{Glossary, Model};
use crate::units::{FrameRate, PolygonRate, Ratio, Seconds};

/// Equation 4.2: time if the part `parallel` becomes `speed_up` times as fast and `serial` stays.
pub fn time(parallel: Seconds, speed_up: Ratio, serial: Seconds) -> Seconds {
    parallel / speed_up.get() + serial
}

/// Equation 4.3: time on one processor.
pub fn single(parallel: Seconds, serial: Seconds) -> Seconds {
    time(parallel, Ratio::new(1.0), serial)
}

/// Equation 4.5: the observed speed-up. The document prints the fraction upside down.
pub fn observed(single: FrameRate, dual: FrameRate) -> Ratio {
    Ratio::new(dual / single)
}

/// Equation 4.5 as it is printed, upside down: the time on two processors over the time on one.
pub fn observed_as_printed(single: FrameRate, dual: FrameRate) -> Ratio {
    observed(dual, single)
}

/// Equation 4.6: the speed-up of the parallel part from its own time on one processor.
///
/// # Errors
/// A time on two processors that is not longer than the serial part.
pub fn parallel_part(parallel: Seconds, dual: Seconds, serial: Seconds) -> Result<Ratio, String> {
    if dual.get() <= serial.get() {
        return Err(format!("expected more than the serial time {serial} on two processors, found {dual}"));
    }
    Ok(Ratio::new(parallel / (dual - serial)))
}

/// Equation 4.7: the speed-up of the parallel part from frame rates; `idle` is the rate with only the serial part.
///
/// # Errors
/// As [`parallel_part`].
pub fn parallel_speed_up(single: FrameRate, dual: FrameRate, idle: FrameRate) -> Result<Ratio, String> {
    let [single, dual, serial] = [single, dual, idle].map(Seconds::from);
    parallel_part(single - serial, dual, serial)
}

/// Amdahl's law: speed-up of the whole if the share `share` becomes `speed_up` times as fast.
///
/// # Errors
/// A share above 1, a speed-up of zero.
pub fn whole(share: Ratio, speed_up: Ratio) -> Result<Ratio, String> {
    if share.get() > 1.0 {
        return Err(format!("share: expected at most 1, found {share}"));
    }
    if speed_up.get() <= 0.0 {
        return Err("speed_up: expected a number above zero, found 0".into());
    }
    Ok(Ratio::new(1.0 / (1.0 - share.get() + share.get() / speed_up.get())))
}

/// The polygon rate after a stage that takes the share `share` of the time becomes `speed_up` times as fast (document
/// 000, 9.1).
///
/// # Errors
/// As [`whole`].
pub fn rate_after(rate: PolygonRate, share: Ratio, speed_up: Ratio) -> Result<PolygonRate, String> {
    Ok(rate * whole(share, speed_up)?.get())
}

pub(crate) const MODELS: &[Model] = models! {
    "amdahl.4.2", "001 eq 4.2, 4.4", "time where all but a serial part is faster":
        time["parallel": Seconds, "speed_up": Ratio, "serial": Seconds] -> Seconds;
    "amdahl.4.3", "001 eq 4.3", "time on one processor":
        single["parallel": Seconds, "serial": Seconds] -> Seconds;
    "amdahl.4.5", "001 eq 4.5", "observed speed-up, from frame rates; printed upside down":
        observed["single": FrameRate, "dual": FrameRate] -> Ratio;
    "amdahl.4.5-as-printed", "001 eq 4.5", "the same as printed, upside down":
        observed_as_printed["single": FrameRate, "dual": FrameRate] -> Ratio;
    "amdahl.4.6", "001 eq 4.6", "speed-up of the parallel part, from times":
        parallel_part["parallel": Seconds, "dual": Seconds, "serial": Seconds] -> Result<Ratio, String>;
    "amdahl.4.7", "001 eq 4.7", "speed-up of the parallel part, from frame rates":
        parallel_speed_up["single": FrameRate, "dual": FrameRate, "idle": FrameRate = 120.0] -> Result<Ratio, String>;
    "amdahl.whole", "Amdahl 1967", "speed-up of the whole where a share of it becomes faster":
        whole["share": Ratio, "speed_up": Ratio] -> Result<Ratio, String>;
    "amdahl.rate-after", "000 9.1", "polygon rate after a share of the time has become faster":
        rate_after["rate": PolygonRate, "share": Ratio, "speed_up": Ratio] -> Result<PolygonRate, String>;
};

pub(crate) const GLOSSARY: Glossary = Glossary {
    group: "amdahl",
    document: None,
    symbols: &[
        ("dual", "pictures a second on two processors"),
        ("amdahl.4.6/dual", "time on two processors"),
        ("idle", "pictures a second if only the serial part runs"),
        ("parallel", "time of the part that is divided, on one processor"),
        ("rate", "polygons a second before"),
        ("serial", "time of the part that is not divided"),
        ("share", "share of the time that becomes faster"),
        ("single", "pictures a second on one processor"),
        ("speed_up", "how many times as fast that part becomes"),
    ],
    assumptions: &[(
        &["amdahl.*"],
        "the serial part takes the same time on any number of processors, and nothing overlaps it",
    )],
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Equation 4.7 recovers the speed-up that 4.2 was given.
        #[test]
        fn there_and_back(parallel in 1e-3f64..10.0, serial in 1e-4f64..1.0, speed_up in 1.0f64..100.0) {
            let at = |s: f64| time(Seconds::new(parallel), Ratio::new(s), Seconds::new(serial));
            let rate = |t: Seconds| FrameRate::new(1.0 / t.get());
            let idle = rate(Seconds::new(serial));
            let found = parallel_speed_up(rate(at(1.0)), rate(at(speed_up)), idle).unwrap().get();
            prop_assert!((found / speed_up - 1.0).abs() < 1e-6);
            let (one, two) = (rate(at(1.0)), rate(at(speed_up)));
            prop_assert!((single(Seconds::new(parallel), Seconds::new(serial)).get() * one.get() - 1.0).abs() < 1e-12);
            prop_assert!((observed(one, two).get() * observed_as_printed(one, two).get() - 1.0).abs() < 1e-12);
        }
    }
}
