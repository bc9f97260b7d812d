//! The tables of a board, and how a file is told to be one.

use rusqlite::Connection;

/// Marks the file as a board of hazcam: "hazb".
pub(super) const APPLICATION: i32 = 0x6861_7a62;

/// The version of the tables below.
pub(super) const VERSION: i32 = 1;

/// `folded` is what secret IDs that look alike share: they are one name.
const TABLES: &str = "
CREATE TABLE board (
    one INTEGER PRIMARY KEY CHECK (one = 1),
    holdout TEXT NOT NULL,
    fingerprint TEXT NOT NULL
) STRICT;
CREATE TABLE scene (
    test TEXT PRIMARY KEY,
    truth BLOB NOT NULL
) STRICT;
CREATE TABLE entry (
    id INTEGER PRIMARY KEY,
    owner TEXT NOT NULL UNIQUE,
    secret_id TEXT NOT NULL,
    folded TEXT NOT NULL UNIQUE,
    added TEXT NOT NULL,
    content TEXT NOT NULL
) STRICT;
CREATE TABLE picture (
    entry INTEGER NOT NULL REFERENCES entry (id) ON DELETE CASCADE,
    test TEXT NOT NULL,
    disparity BLOB NOT NULL,
    error BLOB NOT NULL,
    PRIMARY KEY (entry, test)
) STRICT;
";

/// Makes the tables in an empty database.
pub(super) fn create(connection: &Connection) -> rusqlite::Result<()> {
    connection.execute_batch(TABLES)?;
    connection.pragma_update(None, "application_id", APPLICATION)?;
    connection.pragma_update(None, "user_version", VERSION)
}

/// What a file is, as its header tells.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A database without any table.
    Empty,
    /// A board of this version of its tables.
    Board(i32),
    /// Another program's database.
    Foreign,
}

pub(super) fn kind(connection: &Connection) -> rusqlite::Result<Kind> {
    let application: i32 = connection.pragma_query_value(None, "application_id", |r| r.get(0))?;
    if application == APPLICATION {
        let version = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
        return Ok(Kind::Board(version));
    }
    let tables: i64 =
        connection.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))?;
    Ok(if tables == 0 && application == 0 { Kind::Empty } else { Kind::Foreign })
}
