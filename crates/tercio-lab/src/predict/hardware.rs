//! Caches and memory of this machine.

use std::fs;
use std::hint::black_box;
use std::time::{Duration, Instant};

use super::measure::processor_time;

/// Bytes of the first processor's cache of one level, where Linux reports them.
pub fn cache_bytes(level: u32) -> Option<u64> {
    let of = |index: u32, what: &str| {
        let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{what}");
        Some(fs::read_to_string(path).ok()?.trim().to_string())
    };
    let is_it = |&index: &u32| {
        of(index, "level").is_some_and(|l| l == level.to_string())
            && of(index, "type").is_some_and(|t| t != "Instruction")
    };
    let index = (0..8).find(is_it)?;
    cache_size(&of(index, "size")?)
}

/// The name of the first processor as Linux reports it, or else its architecture.
pub fn processor_name() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| Some(line.strip_prefix("model name")?.split_once(':')?.1.trim()));
    name.filter(|name| !name.is_empty()).unwrap_or(std::env::consts::ARCH).to_string()
}

/// A size in the format of Linux: 48K, 32768K, 2M.
fn cache_size(text: &str) -> Option<u64> {
    let (number, unit) = match text.strip_suffix('K') {
        Some(number) => (number, 1 << 10),
        None => (text.strip_suffix('M')?, 1 << 20),
    };
    number.parse::<u64>().ok()?.checked_mul(unit)
}

/// The fastest of some runs, in seconds.
fn fastest(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |()| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_secs_f64()
    };
    std::iter::repeat_n((), runs).map(time).fold(f64::INFINITY, f64::min)
}

/// Processor time of a sleep of 50 us and of waking up from it, if the system reports processor time: the least of some runs.
pub fn nap_seconds() -> Option<f64> {
    const NAPS: u32 = 500;
    const SLEEP: Duration = Duration::from_micros(50);
    let mut least: Option<f64> = None;
    for _ in 0..5 {
        let before = processor_time()?;
        (0..NAPS).for_each(|_| std::thread::sleep(SLEEP));
        let seconds = (processor_time()? - before) / f64::from(NAPS);
        least = Some(least.map_or(seconds, |least| least.min(seconds)));
    }
    least
}

/// Bytes a second that all threads together read from memory.
pub fn memory_bandwidth(threads: usize) -> f64 {
    // Larger than caches.
    const WORDS: usize = 1 << 24;
    let data: Vec<u64> = (0..WORDS as u64).collect();
    let share = WORDS.div_ceil(threads);
    let seconds = fastest(5, || {
        std::thread::scope(|scope| {
            for part in data.chunks(share) {
                scope.spawn(move || black_box(part.iter().fold(0u64, |sum, w| sum.wrapping_add(*w))));
            }
        });
    });
    (WORDS * 8) as f64 / seconds
}

/// Seconds of merging one pixel of two pictures by depth.
pub fn composite_seconds() -> f64 {
    const PIXELS: usize = 1 << 20;
    let other: Vec<(f32, u32)> = (0..PIXELS).map(|k| ((k % 7) as f32, k as u32)).collect();
    let mut own: Vec<(f32, u32)> = (0..PIXELS).map(|k| ((k % 5) as f32, k as u32)).collect();
    let seconds = fastest(5, || {
        own.iter_mut().zip(&other).for_each(|(a, b)| {
            if b.0 > a.0 {
                *a = *b;
            }
        });
        black_box(&own);
    });
    seconds / PIXELS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_caches_are_read() {
        assert_eq!(cache_size("32768K"), Some(32 << 20));
        assert_eq!(cache_size("2M"), Some(2 << 20));
        assert_eq!(cache_size("big"), None);
    }
}
