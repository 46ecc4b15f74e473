//! Prepared models. A fuzzed build does not compare checksums, so that the code behind them is reached.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::picture::draw_prepared;

fuzz_target!(|bytes: &[u8]| draw_prepared(bytes));
