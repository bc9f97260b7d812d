//! Help as a person reads it.

use crate::classroom::Classroom;

#[test]
fn help_is_what_it_was() {
    let Some(classroom) = Classroom::without_python() else { return };
    for (name, command, arguments) in [
        ("grade", "grade", &["--help"][..]),
        ("board", "board", &["--help"]),
        ("board_add", "board", &["add", "--help"]),
        ("board_show", "board", &["show", "--help"]),
        ("board_export", "board", &["export", "--help"]),
        ("board_rename", "board", &["rename", "--help"]),
    ] {
        let output = classroom.command(command, arguments).output().unwrap();
        insta::assert_snapshot!(name, String::from_utf8(output.stdout).unwrap());
    }
}
