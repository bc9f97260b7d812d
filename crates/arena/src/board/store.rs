//! The board's file.
//!
//! Every change is one transaction of SQLite, with its journal synchronised to the disk before
//! anything is overwritten: a process that is killed at any moment leaves the board as it was
//! before or as it is after, and whoever opens it next needs to do nothing. Writers wait for each
//! other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{
    Connection, ErrorCode, OpenFlags, OptionalExtension, Transaction, TransactionBehavior, params,
};

use super::entry::{Entry, Owner};
use super::error::BoardError;
use super::holdout::Holdout;
use super::picture::{Picture, SceneTruth};
use super::schema::{self, Kind, VERSION};
use crate::submission::{folded, is_secret_id, look_alike};

/// How long a writer waits for others.
const PATIENCE: Duration = Duration::from_secs(60);

/// A leaderboard, open.
#[derive(Debug)]
pub struct Board {
    path: PathBuf,
    connection: Connection,
}

/// What became of an entry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Added {
    /// Its owner had none before.
    New,
    /// It took the place of its owner's entry of this name.
    Replaced(String),
}

impl Board {
    /// Opens the board at `path`.
    pub fn open(path: &Path) -> Result<Self, BoardError> {
        if !path.exists() {
            return Err(BoardError::Missing { path: path.to_owned() });
        }
        let mut board = Self::connect(path)?;
        board.check(None)?;
        Ok(board)
    }

    /// Opens the board at `path`, and begins it with this hold-out if there is none. Of several
    /// that begin a board at once, one does and the others open it.
    pub fn open_or_begin(
        path: &Path,
        holdout: &Holdout,
        fingerprint: &str,
    ) -> Result<Self, BoardError> {
        let text = serde_json::to_string(holdout)
            .map_err(|error| BoardError::Holdout(format!("cannot be kept on a board: {error}")))?;
        create_private(path)
            .map_err(|source| BoardError::Create { path: path.to_owned(), source })?;
        let mut board = Self::connect(path)?;
        board.check(Some((&text, fingerprint)))?;
        Ok(board)
    }

    fn connect(path: &Path) -> Result<Self, BoardError> {
        let failed = |source| failure(path, source);
        let connection =
            Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_WRITE).map_err(failed)?;
        connection.busy_timeout(PATIENCE).map_err(failed)?;
        connection.pragma_update(None, "foreign_keys", true).map_err(failed)?;
        connection.pragma_update(None, "synchronous", "FULL").map_err(failed)?;
        Ok(Self { path: path.to_owned(), connection })
    }

    /// Errors unless the file is a board of this version. An empty one is begun with this hold-out
    /// in JSON and its fingerprint, if they are given.
    fn check(&mut self, beginning: Option<(&str, &str)>) -> Result<(), BoardError> {
        let path = self.path.clone();
        let foreign =
            |problem: &str| BoardError::Foreign { path: path.clone(), problem: problem.to_owned() };
        let failed = |source| failure(&path, source);
        let kind = schema::kind(&self.connection).map_err(failed)?;
        if kind == Kind::Empty {
            let transaction = change(&mut self.connection, &path)?;
            // Somebody else may have begun it in the meantime.
            if schema::kind(&transaction).map_err(failed)? == Kind::Empty {
                let (holdout, fingerprint) = beginning.ok_or_else(|| foreign("it is empty"))?;
                begin(&transaction, holdout, fingerprint).map_err(failed)?;
            }
            transaction.commit().map_err(failed)?;
        }
        match schema::kind(&self.connection).map_err(failed)? {
            Kind::Board(VERSION) => Ok(()),
            Kind::Board(version) => Err(foreign(&format!(
                "its format is number {version}, and this hazcam knows number {VERSION}"
            ))),
            Kind::Empty | Kind::Foreign => Err(foreign("it is a database of something else")),
        }
    }

    /// By what it ranks, and the fingerprint of that.
    pub fn holdout(&self) -> Result<(Holdout, String), BoardError> {
        let (text, fingerprint): (String, String) = self
            .connection
            .query_row("SELECT holdout, fingerprint FROM board", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })
            .map_err(|source| self.failed(source))?;
        Ok((self.parse(&text)?, fingerprint))
    }

    /// Puts an entry on the board, in the place of its owner's earlier one if there is one.
    ///
    /// Errors as [`Board::admit`] and [`Board::admit_tests`] do; then nothing is changed.
    pub fn add<'a>(
        &mut self,
        owner: impl Into<Owner<'a>>,
        entry: &Entry,
        pictures: &[Picture],
        truths: &[SceneTruth],
    ) -> Result<Added, BoardError> {
        let owner = owner.into();
        let path = self.path.clone();
        let failed = |source| failure(&path, source);
        let transaction = change(&mut self.connection, &path)?;
        let before = earlier(&transaction, &path, owner, &entry.secret_id)?;
        same_tests(&transaction, &path, owner, (&entry.report.scheme, &entry.tests))?;
        replace(&transaction, owner.name(), entry.clone(), pictures, truths).map_err(failed)?;
        transaction.commit().map_err(failed)?;
        Ok(before.map_or(Added::New, Added::Replaced))
    }

    /// Errors when this owner could not add an entry of this secret ID: it is none, somebody
    /// else's, or the owner was guessed and has an entry of another ID.
    pub fn admit<'a>(
        &self,
        owner: impl Into<Owner<'a>>,
        secret_id: &str,
    ) -> Result<(), BoardError> {
        earlier(&self.connection, &self.path, owner.into(), secret_id).map(drop)
    }

    /// Errors when points by these tests, those of a scheme with a [fingerprint](super::tests_fingerprint), cannot
    /// stand beside those of others on the board.
    pub fn admit_tests<'a>(
        &self,
        owner: impl Into<Owner<'a>>,
        (scheme, tests): (&str, &str),
    ) -> Result<(), BoardError> {
        same_tests(&self.connection, &self.path, owner.into(), (scheme, tests))
    }

    /// What the board has of an owner.
    pub fn entry_of(&self, owner: &str) -> Result<Option<Entry>, BoardError> {
        let kept = earlier_of(&self.connection, owner).map_err(|source| self.failed(source))?;
        let entry =
            kept.map(|(_, secret_id, content)| Ok(Entry { secret_id, ..self.parse(&content)? }));
        entry.transpose()
    }

    /// Everybody, earliest first.
    pub fn entries(&self) -> Result<Vec<Entry>, BoardError> {
        let failed = |source| self.failed(source);
        let mut statement = self
            .connection
            .prepare("SELECT secret_id, content FROM entry ORDER BY added, id")
            .map_err(failed)?;
        let rows = statement
            .query_map([], |row| Ok((row.get(0)?, row.get(1)?)))
            .map_err(failed)?
            .collect::<rusqlite::Result<Vec<(String, String)>>>()
            .map_err(failed)?;
        rows.into_iter()
            .map(|(secret_id, content)| Ok(Entry { secret_id, ..self.parse(&content)? }))
            .collect()
    }

    /// Whose the entries are, by their secret IDs.
    pub fn owners(&self) -> Result<BTreeMap<String, String>, BoardError> {
        let failed = |source| self.failed(source);
        let mut statement =
            self.connection.prepare("SELECT secret_id, owner FROM entry").map_err(failed)?;
        let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).map_err(failed)?;
        rows.collect::<rusqlite::Result<_>>().map_err(failed)
    }

    /// The pictures of somebody's answers.
    pub fn pictures(&self, secret_id: &str) -> Result<Vec<Picture>, BoardError> {
        let failed = |source| self.failed(source);
        let mut statement = self
            .connection
            .prepare(
                "SELECT test, disparity, error FROM picture JOIN entry ON entry.id = picture.entry \
                 WHERE entry.folded = ?",
            )
            .map_err(failed)?;
        let pictures = statement
            .query_map([folded(secret_id)], |row| {
                Ok(Picture { test: row.get(0)?, disparity: row.get(1)?, error: row.get(2)? })
            })
            .map_err(failed)?
            .collect::<rusqlite::Result<_>>();
        pictures.map_err(failed)
    }

    /// The true disparities of the tests' scenes.
    pub fn truths(&self) -> Result<Vec<SceneTruth>, BoardError> {
        let failed = |source| self.failed(source);
        let mut statement =
            self.connection.prepare("SELECT test, truth FROM scene").map_err(failed)?;
        let truths = statement
            .query_map([], |row| Ok(SceneTruth { test: row.get(0)?, truth: row.get(1)? }))
            .map_err(failed)?
            .collect::<rusqlite::Result<_>>();
        truths.map_err(failed)
    }

    /// Gives somebody another name. Of the one before nothing is kept.
    pub fn rename(&mut self, from: &str, to: &str) -> Result<(), BoardError> {
        if !is_secret_id(to) {
            return Err(BoardError::Name(to.to_owned()));
        }
        let path = self.path.clone();
        let failed = |source| failure(&path, source);
        let transaction = change(&mut self.connection, &path)?;
        let others = ("SELECT secret_id FROM entry WHERE folded != ?", &*folded(from));
        nobody_looks_like(&transaction, &path, to, others)?;
        let changed = transaction.execute(
            "UPDATE entry SET secret_id = ?1, folded = ?2, content = \
             json_set(content, '$.secret_id', ?1, '$.report.secret_id', ?1, '$.renamed', json('true')) \
             WHERE folded = ?3",
            params![to, folded(to), folded(from)],
        );
        match changed {
            Ok(0) => drop(transaction),
            Ok(_) => return transaction.commit().map_err(failed),
            Err(error) if error.sqlite_error_code() == Some(ErrorCode::ConstraintViolation) => {
                return Err(BoardError::Taken(to.to_owned()));
            }
            Err(error) => return Err(failed(error)),
        }
        Err(self.unknown(from)?)
    }

    /// Takes somebody off the board.
    pub fn remove(&mut self, secret_id: &str) -> Result<(), BoardError> {
        let removed = self
            .connection
            .execute("DELETE FROM entry WHERE folded = ?", [folded(secret_id)])
            .map_err(|source| self.failed(source))?;
        match removed {
            0 => Err(self.unknown(secret_id)?),
            _ => Ok(()),
        }
    }

    fn unknown(&self, name: &str) -> Result<BoardError, BoardError> {
        let names: Vec<String> = self.entries()?.into_iter().map(|each| each.secret_id).collect();
        let known = if names.is_empty() { "no entries".into() } else { names.join(", ") };
        Ok(BoardError::Unknown { name: name.to_owned(), known })
    }

    fn failed(&self, source: rusqlite::Error) -> BoardError {
        failure(&self.path, source)
    }

    fn parse<T: serde::de::DeserializeOwned>(&self, text: &str) -> Result<T, BoardError> {
        serde_json::from_str(text).map_err(|error| BoardError::Foreign {
            path: self.path.clone(),
            problem: format!("an entry in it cannot be understood ({error})"),
        })
    }
}

/// Begins a change of the board, for which it waits until nobody else changes it.
fn change<'a>(connection: &'a mut Connection, path: &Path) -> Result<Transaction<'a>, BoardError> {
    let begun = connection.transaction_with_behavior(TransactionBehavior::Immediate);
    begun.map_err(|source| failure(path, source))
}

/// Errors when somebody else on the board got points by other tests.
fn same_tests(
    connection: &Connection,
    path: &Path,
    owner: Owner<'_>,
    (scheme, tests): (&str, &str),
) -> Result<(), BoardError> {
    let failed = |source| failure(path, source);
    let differs = connection
        .query_row(
            "SELECT secret_id FROM entry WHERE owner <> ?1 AND \
             coalesce(json_extract(content, '$.tests'), '') NOT IN ('', ?2) ORDER BY id LIMIT 1",
            [owner.name(), tests],
            |row| row.get(0),
        )
        .optional();
    match differs.map_err(failed)? {
        Some(id) => Err(BoardError::OtherTests { scheme: scheme.to_owned(), id }),
        None => Ok(()),
    }
}

/// Makes an empty database a board that ranks on this hold-out, which is text in JSON.
fn begin(transaction: &Transaction<'_>, holdout: &str, fingerprint: &str) -> rusqlite::Result<()> {
    schema::create(transaction)?;
    transaction.execute(
        "INSERT INTO board (one, holdout, fingerprint) VALUES (1, ?, ?)",
        params![holdout, fingerprint],
    )?;
    Ok(())
}

/// What the owner's entry is called in whose place one of this secret ID may come. Errors when it
/// may not.
fn earlier(
    connection: &Connection,
    path: &Path,
    owner: Owner<'_>,
    id: &str,
) -> Result<Option<String>, BoardError> {
    if !is_secret_id(id) {
        return Err(BoardError::Name(id.to_owned()));
    }
    let key = folded(id);
    let ask = |query: &str, key: &str| -> Result<Option<String>, BoardError> {
        let answer = connection.query_row(query, [key], |row| row.get(0));
        answer.optional().map_err(|source| failure(path, source))
    };
    let holder = ask("SELECT owner FROM entry WHERE folded = ?", &key)?;
    if holder.is_some_and(|holder| holder != owner.name()) {
        return Err(BoardError::Taken(id.to_owned()));
    }
    let others = ("SELECT secret_id FROM entry WHERE owner != ?", owner.name());
    nobody_looks_like(connection, path, id, others)?;
    let before = ask("SELECT secret_id FROM entry WHERE owner = ?", owner.name())?;
    match (owner, before) {
        (Owner::Guessed(owner), Some(before)) if folded(&before) != key => {
            Err(BoardError::Guessed { owner: owner.to_owned(), before, id: id.to_owned() })
        }
        (_, before) => Ok(before),
    }
}

/// Errors when the secret ID of one of the others, whom a query with a parameter finds, could be taken for this one.
fn nobody_looks_like(
    connection: &Connection,
    path: &Path,
    id: &str,
    (query, parameter): (&str, &str),
) -> Result<(), BoardError> {
    let failed = |source| failure(path, source);
    let mut others = connection.prepare(query).map_err(failed)?;
    let others = others.query_map([parameter], |row| row.get::<_, String>(0)).map_err(failed)?;
    for other in others {
        let other = other.map_err(failed)?;
        // The same one is somebody's, which is told otherwise.
        if folded(&other) != folded(id) && look_alike(&other, id) {
            return Err(BoardError::Alike { id: id.to_owned(), other });
        }
    }
    Ok(())
}

/// The number, the name and the content of an owner's entry.
fn earlier_of(
    connection: &Connection,
    owner: &str,
) -> rusqlite::Result<Option<(i64, String, String)>> {
    let query = "SELECT id, secret_id, content FROM entry WHERE owner = ?";
    let row = |row: &rusqlite::Row<'_>| Ok((row.get(0)?, row.get(1)?, row.get(2)?));
    connection.query_row(query, [owner], row).optional()
}

/// Writes an entry with all that belongs to it, in the place of its owner's earlier one. The same hand-in keeps its
/// place among others that do as well.
fn replace(
    transaction: &Transaction<'_>,
    owner: &str,
    mut entry: Entry,
    pictures: &[Picture],
    truths: &[SceneTruth],
) -> rusqlite::Result<()> {
    let earlier = earlier_of(transaction, owner)?;
    let same = earlier.and_then(|(id, _, content)| {
        let earlier: Entry = serde_json::from_str(&content).ok()?;
        earlier.is_of(entry.handin.as_deref(), &entry.tests).then_some((id, earlier.added))
    });
    let now = || {
        let query = "SELECT strftime('%Y-%m-%dT%H:%M:%SZ', 'now')";
        transaction.query_row(query, [], |row| row.get(0))
    };
    let (id, added) = match same {
        Some((id, added)) => (Some(id), added),
        None => (None, now()?),
    };
    entry.added = added;
    let content = serde_json::to_string(&entry).expect("an entry is plain data");
    let key = folded(&entry.secret_id);
    transaction.execute("DELETE FROM entry WHERE owner = ?", [owner])?;
    transaction.execute(
        "INSERT INTO entry (id, owner, secret_id, folded, added, content) VALUES (?, ?, ?, ?, ?, ?)",
        params![id, owner, entry.secret_id, key, entry.added, content],
    )?;
    let number = transaction.last_insert_rowid();
    for Picture { test, disparity, error } in pictures {
        transaction.execute(
            "INSERT INTO picture (entry, test, disparity, error) VALUES (?, ?, ?, ?)",
            params![number, test, disparity, error],
        )?;
    }
    for SceneTruth { test, truth } in truths {
        transaction.execute(
            "INSERT INTO scene (test, truth) VALUES (?, ?) \
             ON CONFLICT (test) DO UPDATE SET truth = excluded.truth",
            params![test, truth],
        )?;
    }
    Ok(())
}

/// What SQLite says, in the board's words where it has some.
fn failure(path: &Path, source: rusqlite::Error) -> BoardError {
    let path = path.to_owned();
    match source.sqlite_error_code() {
        Some(ErrorCode::NotADatabase) => {
            BoardError::Foreign { path, problem: "it is no SQLite database".into() }
        }
        _ => BoardError::Database { path, source },
    }
}

/// Makes an empty file that nobody else can read, unless there is one: the hold-out is in it.
fn create_private(path: &Path) -> std::io::Result<()> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create(true).truncate(false);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path).map(drop)
}
