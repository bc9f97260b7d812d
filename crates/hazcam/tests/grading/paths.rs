//! Paths that are not UTF-8: files may lie there, but neither JSON nor the protocol can say so.
#![cfg(target_os = "linux")]

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::process::Command;

use crate::classroom::Classroom;

fn odd_folder(classroom: &Classroom) -> PathBuf {
    let folder = classroom.path("").join(OsStr::from_bytes(b"odd\xff"));
    fs::create_dir(&folder).unwrap();
    folder
}

#[track_caller]
fn expect_refusal(command: &mut Command, words: &[&str]) {
    let output = command.output().unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stdout}{stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
    for word in words {
        assert!(stdout.contains(word) || stderr.contains(word), "{word}: {stdout}{stderr}");
    }
}

#[test]
fn a_holdout_is_refused_before_the_work() {
    let Some(classroom) = Classroom::without_python() else { return };
    let holdout = odd_folder(&classroom).join("holdout.toml");
    let text = "name = 'h'\n[[test]]\nname = 'h'\npart = 'best'\nscene = 's'\nmax_disparity = 9\n\
                max_e_rms = 1\nmax_p_bad = 0.1\npoints = 0\ncpu_seconds = 9\n\
                [scene.s]\nleft = 'l.png'\nright = 'r.png'\ntruth = 't.pfm'\n";
    fs::write(&holdout, text).unwrap();
    let plane = raster::Plane::from_fn(60, 40, |x, y| ((x * 7919 + y * 104_729) % 251) as u8);
    for name in ["l.png", "r.png"] {
        let image = raster::Image::Grey8(plane.clone());
        formats::write_image(holdout.with_file_name(name), &image).unwrap();
    }
    let truth = raster::Plane::filled(60, 40, 4.0f32);
    formats::write_disparity(holdout.with_file_name("t.pfm"), &truth).unwrap();
    let mut command =
        classroom.command("board", &["add", "--scheme", "small.toml", "--matcher", "fast"]);
    let words = ["odd", "is not UTF-8: rename that folder"];
    expect_refusal(command.arg("--holdout").arg(&holdout), &words);
    assert!(!classroom.path("board.sqlite").exists(), "mistakes begin no board");
}

#[test]
fn a_folder_for_temporary_files_is_refused_before_the_work() {
    let Some(classroom) = Classroom::without_python() else { return };
    let folder = odd_folder(&classroom);
    let mut command = classroom.command("grade", &["--scheme", "small.toml", "--matcher", "fast"]);
    let words = ["odd", "is not UTF-8: let TMPDIR name another"];
    expect_refusal(command.env("TMPDIR", folder), &words);
}

#[test]
fn a_folder_of_engines_is_the_graders_fault() {
    let Some(classroom) = Classroom::without_python() else { return };
    let folder = odd_folder(&classroom);
    for kind in ["protocol", "robust-vision"] {
        let text = format!("name = 'mine'\nkind = '{kind}'\ncommand = ['/bin/true']\n");
        fs::write(folder.join("mine.toml"), text).unwrap();
        let mut command =
            classroom.command("grade", &["--scheme", "small.toml", "--matcher", "mine"]);
        let words = ["XX", "odd", "is not UTF-8: rename it"];
        expect_refusal(command.arg("--engines").arg(&folder), &words);
    }
}
