//! The reader of colour maps.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio::scene::ColorMap;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = ColorMap::parse("map", bytes) {
        for position in [f64::NAN, -1.0, 0.0, 0.3, 1.0, 2.0] {
            assert!(map.at(position).iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }
});
