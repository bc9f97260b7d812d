//! Who is compared with whom.

/// One of hazcam's matchers, and an engine of the same kind: the same window, or as many paths or
/// fewer, or the same purpose.
pub const PEERS: [(&str, &str); 5] = [
    ("fast", "opencv-bm-9x9"),
    ("balanced", "opencv-hh"),
    ("balanced", "opencv-sgbm"),
    ("balanced", "opencv-3way"),
    ("best", "opencv-wls"),
];
