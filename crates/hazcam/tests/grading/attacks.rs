//! How attacks are made: from a few lines of Python to a submission or a program, and its end.

use crate::classroom::Classroom;

/// Part 1 whose function runs `body`; `out` has what it returns.
pub fn attack(body: &str) -> String {
    format!(
        "{IMPORTS}import numpy as np\n\n\
         def NAME(Il, Ir, bbox, maxd):\n    out = np.zeros(Il.shape)\n{}    return out\n",
        indented(body)
    )
}

/// The same as a program in plain Python, for what needs no numpy. It answers zeros.
pub fn program(body: &str) -> String {
    format!(
        "{IMPORTS}import json\n\n\
         def attack():\n{}\n\
         def say(**message):\n    print(json.dumps(message), flush=True)\n\n\
         say(hazcam='ready', protocol=1)\n\
         job = json.loads(sys.stdin.readline())\n\
         try:\n    attack()\nexcept BaseException as error:\n    \
         code = 'ML' if isinstance(error, MemoryError) else 'RE'\n    \
         text = '%s: %s: %s' % (code, type(error).__name__, error)\n    \
         say(hazcam='failed', job=job['job'], message=text)\n    sys.exit()\n\
         shape = (job['rows'], job['columns'])\n\
         text = repr(dict(descr='<f4', fortran_order=False, shape=shape)).encode() + b'\\n'\n\
         with open(job['disparity'], 'wb') as file:\n    \
         file.write(b'\\x93NUMPY\\1\\0' + len(text).to_bytes(2, 'little') + text)\n    \
         file.write(bytes(4 * shape[0] * shape[1]))\n\
         say(hazcam='done', job=job['job'])\n",
        indented(body)
    )
}

const IMPORTS: &str = "\
import ctypes, fcntl, os, resource, signal, socket, struct, subprocess, sys, threading, time\n";

fn indented(body: &str) -> String {
    body.lines().map(|line| format!("    {line}\n")).collect()
}

/// Whether an attack can be made in plain Python: not by way of arrays, nor by what is returned.
pub fn is_plain(body: &str) -> bool {
    !body.contains("np.") && !body.starts_with("out = ")
}

/// Body of part 1, how it ends, words of the message, and words that the runner of submissions adds.
pub type Attack<'a> = (&'a str, &'a str, &'a [&'a str], &'a [&'a str]);

/// Makes attacks as submissions where there is numpy, and those that can do without as programs
/// wherever there is a Python.
#[track_caller]
pub fn expect_all(attacks: &[Attack<'_>]) {
    if let Some(classroom) = Classroom::with_plain_python() {
        for (body, outcome, words, _) in attacks.iter().filter(|attack| is_plain(attack.0)) {
            let report = classroom.grade_program(&program(body));
            assert!(outcome.contains(report.outcome(0)), "{body}\n{}", report.message(0));
            report.expect(report.outcome(0), words);
        }
    }
    let Some(classroom) = Classroom::with_python() else { return };
    for (body, outcome, words, runners) in attacks {
        let report = classroom.grade_source(&attack(body));
        assert!(outcome.contains(report.outcome(0)), "{body}\n{}", report.message(0));
        report.expect(report.outcome(0), &[*words, *runners].concat());
    }
    classroom.expect_the_next_to_pass();
}
