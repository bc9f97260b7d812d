//! Mistakes that students make, and what they are told: the words must say what to mend.

use std::fs;

use crate::classroom::{Classroom, HONEST};

/// Part 1's source, how it ends, and words of the message.
const MISTAKES: &[(&str, &str, &[&str])] = &[
    (
        "def NAME(Il, Ir, bbox, maxd):\n    Id = Il\n\tId = Ir\n    return Id\n",
        "RE",
        &[
            "stereo_disparity_fast.py, line 3: TabError",
            "<tab>Id = Ir",
            "tabs and spaces are mixed",
        ],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    print 'hello'\n",
        "RE",
        &["line 2: SyntaxError", "this is Python 2: write print(...)"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    for d in xrange(maxd):\n        pass\n",
        "RE",
        &["line 2, in stereo_disparity_fast", "NameError", "write range"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    return Il[:Il.shape[0] / 2]\n",
        "RE",
        &["TypeError: slice indices", "write `//`"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    Id = Il * 0\n",
        "BAD",
        &["returned nothing (None)", "`return Id`"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    return Il[10:50, 10:70]\n",
        "BAD",
        &["shape (40, 60)", "(120, 160) (rows, columns), whatever the box"],
    ),
    ("def NAME(Il, Ir, bbox, maxd):\n    return [1, 2]\n", "BAD", &["returned a list"]),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    return Il * float('nan')\n",
        "BAD",
        &[
            "19200 pixels of the box that are scored, as their truth is known, are no finite numbers",
            "column 0, row 0",
            "from 0 to 12",
        ],
    ),
    (
        "def NAME(Il, Ir, bbox):\n    return Il\n",
        "RE",
        &["line 1", "takes 3 arguments, but it is called with four: Il, Ir, bbox, maxd"],
    ),
    (
        "def stereo_disparity(Il, Ir, bbox, maxd):\n    return Il\n",
        "RE",
        &["there is no function stereo_disparity_fast(Il, Ir, bbox, maxd)", "defines stereo_disp"],
    ),
    (
        "import stereo_tools\ndef NAME(Il, Ir, bbox, maxd):\n    return Il\n",
        "RE",
        &["line 1", "No module named 'stereo_tools'", "hand the file in, or remove the import"],
    ),
    (
        "from numpy.surely_gone import inner1d\ndef NAME(Il, Ir, bbox, maxd):\n    return Il\n",
        "RE",
        &["line 1", "No module named 'numpy.surely_gone'", "this machine's numpy has no such"],
    ),
    (
        "raise ModuleNotFoundError('gone', name='numpy')\ndef NAME(Il, Ir, bbox, maxd): pass\n",
        "RE",
        &["line 1", "ModuleNotFoundError: gone"],
    ),
    (
        "from secret_id import missing\ndef NAME(Il, Ir, bbox, maxd):\n    return Il\n",
        "RE",
        &["line 1", "cannot import name 'missing' from 'secret_id' (secret_id.py)"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    exit(0)\n",
        "RE",
        &["SystemExit", "must return and not end the program"],
    ),
    ("def NAME(Il, Ir, bbox, maxd):\n    input()\n", "RE", &["EOFError", "remove input()"]),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    return NAME(Il, Ir, bbox, maxd)\n",
        "RE",
        &["RecursionError", "write it as a loop"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    open('no' + chr(0xdcff))\n",
        "RE",
        &["line 2", "FileNotFoundError", "hand in what is needed there"],
    ),
    (
        "def NAME(Il, Ir, bbox, maxd):\n    raise ValueError(chr(0xd800) + 9000 * chr(0x1f600))\n",
        "RE",
        &["line 2", "ValueError: ?\u{1f600}"],
    ),
    ("", "RE", &["there is no function"]),
    ("\0", "RE", &["null bytes"]),
];

#[test]
fn every_mistake_is_told_where_it_is_and_what_to_do() {
    let Some(classroom) = Classroom::with_python() else { return };
    for (source, outcome, words) in MISTAKES {
        let report = classroom.grade_source(source);
        report.expect(outcome, words);
        assert!(!report.message(0).contains("hazcam_runner"), "{}", report.message(0));
        assert!(!report.message(0).contains("importlib"), "{}", report.message(0));
    }
    classroom.expect_the_next_to_pass();
}

#[test]
fn mistakes_in_python_3_are_not_taken_for_python_2() {
    let Some(classroom) = Classroom::with_python() else { return };
    for body in [
        "    try:\n        Id = Il\n    return Id\n",
        "    try:\n        return Il\n    except (OSError, ValueError) as error\n        return Ir\n",
        "    print('hello'\n    return Il\n",
    ] {
        let report = classroom.grade_source(&format!("def NAME(Il, Ir, bbox, maxd):\n{body}"));
        report.expect("RE", &["SyntaxError"]);
        assert!(!report.message(0).contains("Python 2"), "{}", report.message(0));
    }
}

#[test]
fn files_beside_the_modules_are_looked_at_too() {
    let Some(classroom) = Classroom::with_python() else { return };
    let source = format!("import tools\n{HONEST}");
    let graded = |tools: &[u8]| {
        let submission = classroom.submission("helped", &source);
        fs::write(submission.join("tools.py"), tools).unwrap();
        classroom.grade(&submission, &[])
    };
    let report = graded(b"import cv2\n");
    let told = report.findings();
    assert!(told.contains("\"tools.py\" 1: \"cv2 brings matchers (StereoBM"), "{told}");
    let own = classroom.submission("helped", &source).join("cv2.py");
    fs::write(&own, "").unwrap();
    assert!(!graded(b"import cv2\n").findings().contains("brings matchers"));
    fs::remove_file(own).unwrap();
    let report = graded(b"import numpy as np\nZERO = np.asscalar(np.zeros(1))\nx = np.float(1)\n");
    report.expect("OK", &[]);
    assert!(report.findings().contains("\"tools.py\" 2: \"np.asscalar is gone"));
    let report = graded(b"x = (\n");
    report.expect("RE", &["tools.py, line 1: SyntaxError"]);
    assert!(report.findings().contains("\"tools.py\" 1: \"SyntaxError"), "{}", report.findings());
    // As some editors save on Windows.
    let utf16: Vec<u8> = "\u{feff}x = 1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let report = graded(&utf16);
    assert_eq!(report.outcome(0), "RE");
    assert!(!report.message(0).contains('?'), "{}", report.message(0));
    assert!(report.findings().contains("\"tools.py\" "), "{}", report.findings());
}

#[test]
fn names_that_are_imported_from_modules_are_told_too() {
    let Some(classroom) = Classroom::with_scipy() else { return };
    let imports = "from collections import Iterable\nfrom scipy.signal import gaussian\nimport scipy.signal\n\
                   assert scipy.signal.hann(3)[1] == 1 and isinstance([], Iterable) and gaussian(3, 1)[1] == 1\n";
    let submission = classroom.submission("older", &format!("{imports}{HONEST}"));
    fs::write(submission.join("PIL.py"), "").unwrap();
    let report = classroom.grade(&submission, &[]);
    report.expect("OK", &[]);
    let told = report.findings();
    assert!(told.contains("\"PIL.py\" null: \"it hides the library of that name"), "{told}");
    assert!(told.contains("collections.Iterable is gone"), "{told}");
    // As far as this scipy has dropped them.
    if told.contains("scipy.signal.gaussian is gone") {
        assert!(told.contains("scipy.signal.hann is gone"), "{told}");
    }
}

#[test]
fn a_backend_with_windows_is_not_asked_for() {
    let Some(classroom) = Classroom::with_python() else { return };
    let draws = "import matplotlib\nmatplotlib.use('TkAgg')\nimport matplotlib.pyplot as plt\n";
    let body = HONEST
        .replace("    return Id", "    plt.switch_backend('Qt5Agg'); plt.close()\n    return Id");
    classroom.grade_source(&format!("{draws}{body}")).expect("OK", &[]);
}

#[test]
fn a_source_that_is_too_deep_for_python_does_not_hide_the_secret_id() {
    let Some(classroom) = Classroom::with_python() else { return };
    let report = classroom.grade_source(&format!("depth = {}1\n{HONEST}", "-".repeat(20_000)));
    report.expect("RE", &["stereo_disparity_fast.py: MemoryError", "nested too deeply"]);
    assert_eq!(report.0["secret_id"], "Secret submission");
}

#[test]
fn drawing_libraries_may_be_imported_and_not_used() {
    let Some(classroom) = Classroom::with_python() else { return };
    // A name that is surely not installed, of a library that has a stand-in where it is missing.
    let report = classroom.grade_source(&format!("import mat4py\n{HONEST}"));
    report.expect("OK", &[]);
    let report = classroom
        .grade_source("import mat4py\ndef NAME(Il, Ir, bbox, maxd):\n    mat4py.loadmat('a')\n");
    report.expect("RE", &["line 3", "mat4py", "remove the call"]);
}

#[test]
fn values_outside_of_the_range_or_the_box_are_forgiven() {
    let Some(classroom) = Classroom::with_python() else { return };
    let edges = "    Id[0, :4] = -5, 99, 12.5, 1e300\n    return Id\n";
    let report = classroom.grade_source(&HONEST.replace("    return Id\n", edges));
    report.expect("OK", &[]);
    assert_eq!(report.0["tests"][0]["scores"]["clipped"], 4);
    let remark = report.0["tests"][0]["remarks"][0].as_str().unwrap();
    assert!(
        remark.starts_with("4 of the 19200 pixels in the box were outside 0 to 12"),
        "{remark}"
    );
}

#[test]
fn a_missing_or_useless_secret_id_costs_no_points() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("nameless", HONEST);
    for (content, words) in [
        (None, "the file is missing; it defines secret_id()"),
        (Some("def secret_id():\n    return 'ab'\n"), "'ab' (2 characters), but 4 to 32"),
        (
            Some("def secret_id():\n    return ' abcd'\n"),
            "' abcd', which begins or ends with a space",
        ),
        (Some("def secret_id():\n    return 'abcd '\n"), "with no space at an end"),
        (
            Some("def secret_id():\n    return 'rover\\u200dfan'\n"),
            "characters are needed; character 6, U+200D, is not printable",
        ),
        (Some("def secret_id():\n    return '=A1+A2'\n"), "= + - @ cannot come first"),
        (Some("def secret_id():\n    return '\\u3164' * 5\n"), "which would not look on the board"),
        (Some("def secret_id():\n    return 'abc' + '\\u0301' * 3\n"), "at most two accents"),
        (Some("def secret_id():\n    return 7\n"), "returned an int, but a string (str) is needed"),
        (Some("secret_id = 'abcdef'\n"), "is a str and no function: write `def secret_id"),
        (Some("def secret_id():\n    return 1 / 0\n"), "ZeroDivisionError"),
        (Some("def secret_id()\n    return 'abcdef'\n"), "SyntaxError"),
    ] {
        let file = folder.join("secret_id.py");
        match content {
            Some(text) => fs::write(file, text).unwrap(),
            None => fs::remove_file(file).unwrap(),
        }
        let report = classroom.grade(&folder, &[]);
        assert_eq!((&report.0["secret_id"], report.0["points"].as_f64()), (&().into(), Some(5.0)));
        assert!(report.findings().contains(words), "{}", report.findings());
    }
}

#[test]
fn a_result_kept_in_a_small_type_is_no_mistake() {
    let Some(classroom) = Classroom::with_python() else { return };
    let source = HONEST.replace("return Id", "return Id.astype(np.uint8)");
    let report = classroom.grade_source(&source);
    report.expect("OK", &[]);
    let findings = report.findings();
    for words in
        ["if sums or differences are taken in uint8", "up to 255 that are only kept may be"]
    {
        assert!(findings.contains(words), "`{words}` is not in: {findings}");
    }
}

#[test]
fn what_is_called_may_be_more_than_what_is_written() {
    let Some(classroom) = Classroom::with_python() else { return };
    let fifth = HONEST.replace("(Il, Ir, bbox, maxd)", "(Il, Ir, bbox, maxd, window)");
    let decorated = format!(
        "def supplied(f):\n    return lambda *given: f(*given, 5)\n\n{}",
        fifth.replace("def NAME", "@supplied\ndef NAME")
    );
    let rebound = format!("{fifth}\nimport functools\nNAME = functools.partial(NAME, window=5)\n");
    let hidden =
        format!("{}\nglobals()['NAME'] = other\n", HONEST.replace("def NAME", "def other"));
    for source in [decorated, rebound, hidden] {
        let report = classroom.grade_source(&source);
        report.expect("OK", &[]);
    }
}

#[test]
fn what_numpy_dropped_is_put_back() {
    let Some(classroom) = Classroom::with_python() else { return };
    let source = HONEST.replace(
        "return Id",
        "assert np.NAN != np.NAN and np.NINF < 0 and np.asfarray([1]).dtype == float\n    \
         assert np.msort([2, 1])[0] == 1 and np.bool8(1) and np.mat([[1]]).shape == (1, 1)\n    return Id",
    );
    let report = classroom.grade_source(&source);
    report.expect("OK", &[]);
}

#[test]
fn files_of_the_wrong_name_are_found() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("renamed", HONEST);
    fs::rename(
        folder.join("stereo_disparity_fast.py"),
        folder.join("Stereo_disparity_fast (1).py"),
    )
    .unwrap();
    let report = classroom.grade(&folder, &[]);
    report.expect("RE", &["the file is missing; there is `Stereo_disparity_fast (1).py`: rename"]);
    report.expect_part_2_to_pass();
}

#[test]
fn folders_and_compiled_files_are_no_sources() {
    let Some(classroom) = Classroom::with_python() else { return };
    let name = "stereo_disparity_fast.py";
    let folder = classroom.submission("folder", HONEST);
    fs::remove_file(folder.join(name)).unwrap();
    fs::create_dir(folder.join(name)).unwrap();
    fs::write(folder.join(name).join("code.py"), "").unwrap();
    let report = classroom.grade(&folder, &[]);
    report.expect("RE", &["the file is missing; `stereo_disparity_fast.py` is a folder: hand in"]);
    report.expect_part_2_to_pass();
    fs::remove_dir_all(folder.join(name)).unwrap();
    fs::write(folder.join("stereo_disparity_fast.cpython-311.pyc"), "").unwrap();
    let report = classroom.grade(&folder, &[]);
    report.expect("RE", &["which is compiled: hand in the source, stereo_disparity_fast.py"]);
}

#[test]
fn files_in_another_folder_are_found() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("scattered", HONEST);
    let below = folder.join("part1/code");
    fs::create_dir_all(&below).unwrap();
    let name = "stereo_disparity_fast.py";
    fs::rename(folder.join(name), below.join(name)).unwrap();
    let report = classroom.grade(&folder, &[]);
    report.expect("RE", &["the file is missing; there is one in `part1/code`: put all files"]);
    report.expect_part_2_to_pass();
}

#[test]
fn truth_values_are_no_disparities() {
    let Some(classroom) = Classroom::with_python() else { return };
    let report = classroom.grade_source(&HONEST.replace("return Id", "return Id > 3"));
    report.expect("BAD", &["an array of bool, but an array of real numbers is needed"]);
}
