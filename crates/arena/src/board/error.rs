//! Why a board cannot be read or changed.

use std::io;
use std::path::PathBuf;

/// Why a board cannot be read or changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BoardError {
    /// There is no such file.
    #[error("there is no board {}: `hazcam board add` begins one, --board names another", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The file is something else.
    #[error("{} is no leaderboard: {problem}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        problem: String,
    },
    /// The database fails.
    #[error("the board {} cannot be used: {source}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// The file cannot be created.
    #[error("cannot create the board {}: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Somebody else has this name.
    #[error("the secret ID `{0}` is taken: choose another, or rename or remove that entry")]
    Taken(String),
    /// Somebody else has a name that looks the same.
    #[error("the secret ID `{id}` looks like `{other}`, which somebody else has: choose another")]
    Alike {
        /// The name.
        id: String,
        /// That of the other entry.
        other: String,
    },
    /// An owner that nobody gave has an entry of another name.
    #[error(
        "no --owner was given, and `{owner}`, taken from the entrant's name, has an entry already, \
         `{before}` and not `{id}`: give --owner '{owner}' to put this one in its place (with \
         --secret-id '{before}' under that name), or another --owner NAME for somebody else"
    )]
    Guessed {
        /// The owner's name.
        owner: String,
        /// The name of the entry on the board.
        before: String,
        /// The name of the entry that was to be added.
        id: String,
    },
    /// Nobody has this name.
    #[error("nobody on the board is called `{name}`; there are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
    /// A name that cannot be one.
    #[error(
        "`{0}` cannot be a secret ID: it must have 4 to 32 printable characters, none of them blank but \
         plain spaces between words, at most two accents on a letter, and none of = + - @ at the beginning"
    )]
    Name(String),
    /// The board ranks on another pair.
    #[error("{0}")]
    OtherHoldout(String),
    /// Other tests gave the points of those who are on the board.
    #[error(
        "the tests of the scheme `{scheme}`, or their scenes, are not those by which `{id}` on this \
         board got its points: give the --scheme and the data of before, or begin another board \
         with --board; `hazcam board remove` takes off whom that concerns"
    )]
    OtherTests {
        /// The scheme's name.
        scheme: String,
        /// Somebody on the board.
        id: String,
    },
    /// The hold-out cannot be used.
    #[error("the hold-out {0}")]
    Holdout(String),
}
