//! Submissions that attack the grader, the machine or the truth. Each must end in a clear status,
//! harm nothing, and leave part 2, which is honest and comes after it, its points.

use std::fs;

use crate::attacks::{attack, expect_all, is_plain, program};
use crate::classroom::{Classroom, HONEST, Report};

#[test]
fn time_cannot_be_stretched() {
    expect_all(&[
        ("while True: pass", "TO", &["of CPU time", "the limit is 1 s"], &[]),
        (
            "for s in range(1, 65):\n    try: signal.signal(s, signal.SIG_IGN)\n    except (OSError, \
             ValueError): pass\nsignal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))\n\
             while True: pass",
            "TO",
            &["of CPU time"],
            &[],
        ),
        (
            "resource.setrlimit(resource.RLIMIT_CPU, (10**6, 10**6))",
            "RE",
            &[],
            &["setrlimit", "line 6"],
        ),
        // Two threads use twice the time: that of all threads counts.
        (
            "def spin():\n    while True: sum(range(1000))\n\
             for _ in range(4): threading.Thread(target=spin, daemon=True).start()\n\
             while True: np.sort(np.random.rand(10**5))",
            "TO",
            &["of CPU time"],
            &[],
        ),
    ]);
}

#[test]
fn nothing_is_done_before_the_clock_starts() {
    let Some(classroom) = Classroom::with_python() else { return };
    let source = format!(
        "import os\nEARLY = [os.path.join(a, f) for a, _, b in os.walk('..') for f in b]\n{}",
        HONEST.replace(
            "best, Id =",
            "assert not [f for f in EARLY if 'left' in f], EARLY\n    best, Id ="
        )
    );
    classroom.grade_source(&source).expect("OK", &[]);
    // Nor can the images be kept from coming.
    let source = format!("import os\nos.mkdir('../job/left.npy')\n{HONEST}");
    let report = classroom.grade_source(&source);
    report.expect("BAD", &["put something where the images go"]);
    classroom.expect_the_next_to_pass();
}

#[test]
fn importing_has_its_own_limit() {
    let Some(classroom) = Classroom::with_python() else { return };
    let submission =
        classroom.submission("sleepy", &format!("import time\ntime.sleep(1e6)\n{HONEST}"));
    let report = classroom.grade(&submission, &["--start-limit", "2"]);
    report.expect("TO", &["importing it took longer than 2 s"]);
    report.expect_part_2_to_pass();
}

#[test]
fn last_words_excuse_nobody() {
    let Some(classroom) = Classroom::with_python() else { return };
    for words in [
        "sandbox failed: Landlock: not supported",
        "python3 could not be started: no such file",
        "it had used 60.1 s of wall time when it was killed; the limit is 60 s",
    ] {
        for status in [3, 125] {
            let source =
                format!("import os\nos.write(2, b'{words}')\nos._exit({status})\n{HONEST}");
            let report = classroom.grade_source(&source);
            let ended = format!("while it was imported, it exited with status {status}");
            report.expect("RE", &[&ended, words]);
        }
    }
    classroom.expect_the_next_to_pass();
}

#[test]
fn nobody_can_say_that_the_grader_lacks_something() {
    let Some(classroom) = Classroom::with_scipy() else { return };
    let message = r#"{"hazcam":"absent","message":"no numpy"}"#;
    let source = format!(
        "import os\nfor k in range(3, 16):\n    try: os.write(k, b'{message}\\n')\n    except OSError: \
         pass\n{HONEST}"
    );
    let report = classroom.grade_source(&source);
    report.expect("BAD", &["no numpy", "numpy and scipy are installed"]);
    classroom.expect_the_next_to_pass();
}

#[test]
fn no_process_is_started() {
    expect_all(&[
        ("while True: os.fork()", "RE", &["PermissionError"], &["may not start programs"]),
        ("subprocess.run(['/bin/true'])", "RE", &[], &["may not start programs"]),
        ("import multiprocessing\nmultiprocessing.Pool(2)", "RE", &[], &["hint"]),
        ("assert os.system('true') == 0, 'no shell'", "RE", &["no shell"], &[]),
        ("os.posix_spawn('/bin/true', ['true'], {})", "RE", &[], &["may not start programs"]),
        (
            "while True: threading.Thread(target=time.sleep, args=(100,), daemon=True).start()",
            "RE",
            &["thread"],
            &[],
        ),
    ]);
}

#[test]
fn no_other_program_takes_the_place_of_a_submission() {
    // It would have the same rights, and the line to the grader: a matcher that is installed would answer.
    let thread = "caught = []\ndef run():\n    try: os.execv('/bin/true', ['true'])\n    except OSError as e: \
                  caught.append(e)\nthread = threading.Thread(target=run)\nthread.start()\nthread.join()\nraise caught[0]";
    // The loader would start what may only be read.
    let loader = "for each in ['/lib64/ld-linux-x86-64.so.2', '/lib/ld-linux-aarch64.so.1']:\n    if \
                  os.path.exists(each): os.execv(each, [each, '/bin/true'])\nraise PermissionError(13, 'no loader')";
    let raw = "libc = ctypes.CDLL(None, use_errno=True)\nargv = (ctypes.c_char_p * 2)(b'true', None)\n\
               libc.execve(b'/bin/true', argv, None)\nraise OSError(ctypes.get_errno(), 'execve')";
    if let Some(classroom) = Classroom::with_python() {
        let unnamed = "libc = ctypes.CDLL(None, use_errno=True)\nfile = os.open('/bin/true', os.O_RDONLY)\n\
                       libc.execveat(file, b'', None, None, 0x1000)\nif ctypes.get_errno() == 38: raise \
                       PermissionError(13, 'no such call')\nraise OSError(ctypes.get_errno(), 'execveat')";
        for body in ["os.execv('/bin/true', ['true'])", thread, loader, raw, unnamed] {
            let report = classroom.grade_source(&attack(body));
            report.expect("RE", &["PermissionError", "may not start programs"]);
        }
        let early = "import os\nos.execv('/bin/true', ['true'])\n";
        let report = classroom.grade_source(&format!("{early}{HONEST}"));
        report.expect("RE", &["PermissionError", "may not start programs"]);
        classroom.expect_the_next_to_pass();
    }
    // Engines are what the grader chose: scripts among them begin programs.
    if let Some(classroom) = Classroom::with_plain_python() {
        let run = |body| classroom.grade_program(&program(body));
        let report = run("os.execv('/bin/true', ['true'])");
        report.expect("RE", &["exited with status 0 without an answer"]);
        let report = run("os.execv('/bin/cat', ['cat', '/etc/passwd'])");
        report.expect("RE", &["exited with status 1", "Permission denied"]);
    }
}

#[test]
fn nobody_else_is_signalled_or_inspected() {
    expect_all(&[
        ("os.kill(os.getppid(), 9)", "RE", &["PermissionError"], &[]),
        ("os.kill(-1, 9)", "RE", &["PermissionError"], &[]),
        ("os.kill(0, 9)", "RE", &["PermissionError"], &[]),
        ("os.killpg(os.getpgid(os.getppid()), 9)", "RE", &["PermissionError"], &[]),
        ("os.setsid()", "RE", &["PermissionError"], &[]),
        ("open('/proc/%d/environ' % os.getppid())", "RE", &["PermissionError"], &[]),
        ("open('/proc/%d/mem' % os.getppid(), 'rb')", "RE", &["PermissionError"], &[]),
        ("open('/proc/self/environ')", "RE", &["PermissionError"], &[]),
        (
            "libc = ctypes.CDLL(None, use_errno=True)\n\
             if libc.ptrace(16, os.getppid(), 0, 0): raise OSError(ctypes.get_errno(), 'ptrace')",
            "RE",
            &["PermissionError"],
            &[],
        ),
        // Signals that the kernel sends when something happens to an open file.
        (
            "end, _ = os.pipe()\nfcntl.fcntl(end, fcntl.F_SETOWN, os.getppid())",
            "RE",
            &["PermissionError"],
            &[],
        ),
        (
            // F_SETOWN_EX, of a process.
            "end, _ = os.pipe()\nfcntl.fcntl(end, 15, struct.pack('ii', 1, os.getppid()))",
            "RE",
            &["PermissionError"],
            &[],
        ),
        (
            // F_SETSIG.
            "end, _ = os.pipe()\nfcntl.fcntl(end, 10, signal.SIGKILL)",
            "RE",
            &["PermissionError"],
            &[],
        ),
        (
            "fcntl.fcntl(os.open('.', os.O_RDONLY), fcntl.F_NOTIFY, fcntl.DN_CREATE)",
            "RE",
            &["PermissionError"],
            &[],
        ),
        (
            "open('mine', 'w').close()\n\
             fcntl.fcntl(os.open('mine', os.O_RDONLY), fcntl.F_SETLEASE, fcntl.F_RDLCK)",
            "RE",
            &["PermissionError"],
            &[],
        ),
        // What programs do with their own files goes on.
        (
            "file = open('mine', 'w')\nfcntl.lockf(file, fcntl.LOCK_EX)\n\
             os.set_inheritable(file.fileno(), True)\nos.set_blocking(file.fileno(), False)\n\
             os.close(fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, 0))",
            "OK",
            &[],
            &[],
        ),
        // No file is left open that is not its own: beyond the three streams, the two pipes to the
        // grader that they were copied to.
        (
            "def is_open(k):\n    try: return bool(os.fstat(k))\n    except OSError: return False\n\
             extra = [k for k in range(3, 64) if is_open(k)]\nassert not extra[2:], extra",
            "OK",
            &[],
            &[],
        ),
    ]);
}

#[test]
fn no_connection_is_opened() {
    expect_all(&[
        ("socket.socket()", "RE", &["PermissionError"], &["open connections"]),
        ("socket.socket(socket.AF_UNIX)", "RE", &["PermissionError"], &[]),
        ("socket.socketpair()", "RE", &["PermissionError"], &[]),
        ("socket.create_connection(('127.0.0.1', 22))", "RE", &[], &["hint"]),
    ]);
}

#[test]
fn files_elsewhere_are_out_of_reach() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("truth.npy"), "the truth").unwrap();
    let outside = folder.path().display();
    let bodies = [
        "open('/etc/passwd')".to_owned(),
        "open('/etc/shadow')".to_owned(),
        "os.listdir('/')".to_owned(),
        "os.listdir('/proc')".to_owned(),
        "os.listdir('../..')".to_owned(),
        "os.listdir('/root')".to_owned(),
        format!("np.load('{outside}/truth.npy')"),
        format!("open('{outside}/truth.npy', 'a')"),
        format!("open('{outside}/new', 'w')"),
        format!("os.truncate('{outside}/truth.npy', 0)"),
        format!("os.remove('{outside}/truth.npy')"),
        format!("os.rename('{outside}/truth.npy', 'mine')"),
        format!("os.link('{outside}/truth.npy', 'mine')"),
        format!("os.symlink('{outside}/truth.npy', 'mine')"),
        format!("os.chmod('{outside}/truth.npy', 0o777)"),
        format!("os.utime('{outside}/truth.npy')"),
        format!("os.mkdir('{outside}/new')"),
        format!("os.rmdir('{outside}')"),
        "open('/dev/shm/hazcam-test', 'w')".to_owned(),
        "open('/tmp/hazcam-test', 'w')".to_owned(),
        "open('../pid', 'w')".to_owned(),
        "open('../hidden/left.npy', 'w')".to_owned(),
        "open(sys.prefix + '/hazcam-test', 'w')".to_owned(),
        "os.mkfifo('pipe')".to_owned(),
        "os.mkdir('hiding', 0o300)".to_owned(),
        "os.chroot('.')".to_owned(),
        "os.setuid(1)".to_owned(),
        "os.memfd_create('x')".to_owned(),
    ];
    let check = |body: &str, report: Report| {
        let message = report.message(0);
        assert_eq!(report.outcome(0), "RE", "{body}\n{message}");
        let refused = ["[Errno 13]", "[Errno 1]", "[Errno 38]"];
        assert!(refused.iter().any(|error| message.contains(error)), "{body}\n{message}");
    };
    if let Some(classroom) = Classroom::with_plain_python() {
        for body in bodies.iter().filter(|body| is_plain(body)) {
            check(body, classroom.grade_program(&program(body)));
        }
    }
    if let Some(classroom) = Classroom::with_python() {
        for body in &bodies {
            check(body, classroom.grade_source(&attack(body)));
        }
        classroom.expect_the_next_to_pass();
    }
    let names: Vec<_> = fs::read_dir(&folder).unwrap().flatten().collect();
    assert_eq!(names.len(), 1);
    assert_eq!(fs::read_to_string(names[0].path()).unwrap(), "the truth");
}

#[test]
fn memory_and_disk_end_somewhere() {
    expect_all(&[
        ("out = np.ones(10**11)", "ML", &["MemoryError"], &["larger than the limit of memory"]),
        ("keep = []\nwhile True: keep.append(bytes(10**8))", "ML", &["MemoryError"], &[]),
        ("keep = []\nwhile True: keep.append(np.zeros(10**7))", "ML", &["MemoryError"], &[]),
        (
            "with open('big', 'wb') as file:\n    file.truncate(10**11)",
            "RE",
            &[],
            &["larger than a submission may write"],
        ),
        (
            "with open('big', 'wb') as file:\n    while True: file.write(bytes(10**7))",
            "RE",
            &[],
            &[],
        ),
        (
            "for k in range(100):\n    open('big%d' % k, 'wb').write(bytes(10**7))\n\
             time.sleep(1)",
            "RE",
            &["it had written", "32 MiB are allowed"],
            &[],
        ),
        (
            // Without a name, and still there.
            "keep = []\nfor k in range(10):\n    keep.append(open('big', 'wb', buffering=0))\n    \
             os.remove('big')\n    keep[-1].write(bytes(10**7))\ntime.sleep(1)",
            "RE",
            &["it had written", "32 MiB are allowed"],
            &[],
        ),
        (
            // As quick as the watch, so that the CPU time may end first.
            "for k in range(10**6): open('small%d' % k, 'w').close()",
            "RE or TO",
            &[],
            &[],
        ),
        ("os.umask(0o777)", "RE", &["OSError"], &[]),
        (
            "keep = [open('f%d' % k, 'w') for k in range(100)]",
            "RE",
            &[],
            &["too many files are open"],
        ),
    ]);
}

#[test]
fn folders_cannot_be_nested_out_of_sight() {
    let nested = "for _ in range(1500):\n    os.mkdir('d')\n    os.chdir('d')\n";
    let long = "for _ in range(40):\n    os.mkdir('d' * 250)\n    os.chdir('d' * 250)\n";
    let long = format!("{long}time.sleep(1)");
    expect_all(&[
        // So deep that a process runs out of descriptors on the way: it is removed nevertheless.
        (nested, "OK", &[], &[]),
        (&long, "RE", &["folders that cannot be read"], &[]),
    ]);
}

#[test]
fn ends_without_an_answer_are_told_apart() {
    expect_all(&[
        ("ctypes.string_at(0)", "SG", &["memory that is not its own", "SIGSEGV"], &[]),
        ("os.abort()", "SG", &["SIGABRT"], &[]),
        ("os.kill(os.getpid(), 9)", "SG", &["SIGKILL"], &[]),
        ("os._exit(0)", "RE", &["status 0 without an answer"], &[]),
        ("os._exit(7)", "RE", &["status 7"], &[]),
        (
            "os.closerange(0, 256)\ntime.sleep(100)",
            "RE",
            &["closed its standard input or output"],
            &[],
        ),
        ("raise KeyboardInterrupt", "RE", &["KeyboardInterrupt"], &[]),
    ]);
}

#[test]
fn a_flood_of_output_is_cut() {
    let Some(classroom) = Classroom::with_python() else { return };
    let report = classroom.grade_source(&attack("while True: print('spam' * 10**5)"));
    report.expect("TO", &["CPU time"]);
    assert!(report.0["tests"][0]["output"].as_str().unwrap().len() <= 16 << 10);
    // The same on the grader's own line, whose number can be found out.
    for line in ["{\\\"hazcam\\\":\\\"ready\\\",\\\"protocol\\\":1}", "{\\\"hazcam\\\":3}", "spam"]
    {
        let report = classroom.grade_source(&attack(&format!(
            "while True:\n    for k in range(3, 16):\n        try: os.write(k, b\"{line}\\n\" * \
             1000)\n        except OSError: pass"
        )));
        assert!(["BAD", "TO"].contains(&report.outcome(0)), "{}", report.message(0));
    }
    classroom.expect_the_next_to_pass();
}

#[test]
fn wrong_answers_are_refused() {
    expect_all(&[
        ("out = out[:-1]", "BAD", &["shape (119, 160)"], &[]),
        ("out = np.zeros((120, 160, 3))", "BAD", &["shape (120, 160, 3)"], &[]),
        ("out = np.zeros((10**4, 10**4), dtype=np.float32)", "BAD", &["shape (10000, 10000)"], &[]),
        ("out = out * np.nan", "BAD", &["no finite numbers"], &[]),
        ("out = out + np.inf", "BAD", &["no finite numbers"], &[]),
        ("out = 'disparity'", "BAD", &["returned a str"], &[]),
        ("out = np.array([['a'] * 160] * 120)", "BAD", &["real numbers"], &[]),
        ("out = out.astype(complex)", "BAD", &["real numbers"], &[]),
        ("out = out.astype(object)", "BAD", &["real numbers"], &[]),
        ("out = np.ma.zeros(Il.shape)", "OK", &[], &[]),
        ("out = np.ma.masked_less(np.zeros(Il.shape), 1)", "BAD", &["NaN"], &[]),
        ("class Mine(np.ndarray): pass\nout = out.view(Mine)", "OK", &[], &[]),
    ]);
}

/// Writes the answer past the runner and says that it is there.
fn forged(write: &str) -> String {
    attack(&format!(
        "{write}\nfor k in range(3, 16):\n    try: os.write(k, b'{{\"hazcam\":\"done\",\"job\":1}}\\n')\
         \n    except OSError: pass\ntime.sleep(100)"
    ))
}

#[test]
fn forged_answers_are_read_strictly() {
    let Some(classroom) = Classroom::with_python() else { return };
    let answer = "../job/disparity.npy";
    for (write, words) in [
        ("", "wrote no disparity file"),
        ("np.save('@', np.array([{}], dtype=object), allow_pickle=True)", "disparity.npy"),
        ("np.save('@', np.zeros((10**3, 10**3), np.float32))", "has 4000128 bytes"),
        ("np.save('@', np.zeros((160, 120), np.float32))", "has the shape (160, 120)"),
        ("np.save('@', np.zeros((120, 160)))", "has 153728 bytes"),
        ("open('@', 'wb').write(b'\\x93NUMPY\\x01\\x00\\xff\\xff{')", "disparity.npy"),
        ("open('@', 'w').close()", "disparity.npy"),
        ("os.mkdir('@')", "no regular file"),
    ] {
        let report = classroom.grade_source(&forged(&write.replace('@', answer)));
        report.expect("BAD", &[words]);
    }
    classroom.expect_the_next_to_pass();
}

#[test]
fn a_copy_of_the_truth_is_noticed() {
    let Some(classroom) = Classroom::with_python() else { return };
    // The wall stands at 5.5 pixels everywhere: its truth is easily handed in.
    let report = classroom.grade_source(&attack("out = out + 5.5"));
    report.expect("OK", &[]);
    let remark = report.0["tests"][0]["remarks"][0].as_str().unwrap();
    assert!(remark.contains("suspicious: 100 % of the scored pixels equal the truth"), "{remark}");
}

#[test]
fn modules_cannot_be_put_in_the_runners_way() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("shadows", HONEST);
    for name in ["json", "ast", "traceback", "hazcam_runner", "numpy", "site", "sitecustomize"] {
        fs::write(folder.join(format!("{name}.py")), "raise SystemExit('shadowed')\n").unwrap();
    }
    let report = classroom.grade(&folder, &[]);
    assert_eq!(report.0["points"], 5.0, "{}", report.message(0));
}

#[test]
fn a_random_answer_shows_when_run_twice() {
    let Some(classroom) = Classroom::with_python() else { return };
    let source = attack("out = np.random.rand(*Il.shape)");
    let report = classroom.grade(&classroom.submission("dice", &source), &["--twice"]);
    let remark = report.0["tests"][0]["remarks"][0].as_str().unwrap();
    assert!(remark.starts_with("a second run gave other values in"), "{remark}");
    assert_eq!(report.0["tests"][1]["remarks"], serde_json::json!([]));
}
