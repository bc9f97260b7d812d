//! Files whose names are no UTF-8.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;

use serde_json::Value;

use crate::folder::Folder;

#[test]
fn names_that_are_no_text_are_recorded_as_they_are_shown() {
    let folder = Folder::with_pair(24, 16);
    let [left, map] = [b"left\xff.png".as_slice(), b"d\xff.pfm"].map(OsStr::from_bytes);
    std::fs::rename(folder.path("left.png"), folder.path("").join(left)).unwrap();
    let run = |arguments: &[&OsStr]| {
        let output = folder.command().args(arguments).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        output.stdout
    };
    let json = |bytes: Vec<u8>| serde_json::from_slice::<Value>(&bytes).unwrap();
    run(&["match".as_ref(), left, "right.png".as_ref(), "-o".as_ref(), map]);
    let record = folder.path("").join(OsStr::from_bytes(b"d\xff.pfm.json"));
    let record = json(std::fs::read(record).unwrap());
    assert_eq!(
        (&record["left"]["path"], &record["output"]),
        (&"left\u{fffd}.png".into(), &"d\u{fffd}.pfm".into())
    );
    let found = json(run(&["info".as_ref(), "--json".as_ref(), map]));
    assert_eq!(found[0]["path"], "d\u{fffd}.pfm");
    let report = json(run(&["score".as_ref(), map, map, "--format=json".as_ref()]));
    assert_eq!(report["estimate"]["path"], "d\u{fffd}.pfm");
}
