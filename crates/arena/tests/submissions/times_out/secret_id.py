def secret_id():
    """Return the name for the leaderboard."""
    return "almost there"
