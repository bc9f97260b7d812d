"""Messages in and out, kept apart from what a submission prints.

The first two standard streams are moved away and replaced: what is printed goes to standard error,
what is read from the keyboard is at its end. So a submission can print without breaking a message.
"""

import json
import os

# A message has at most 65536 bytes; JSON may write one character as six.
TEXT_LIMIT = 8000


class Channel:
    """The line to hazcam."""

    def __init__(self):
        self._jobs = os.fdopen(os.dup(0), "r", encoding="utf-8")
        # Of a name that is no UTF-8 Python makes a text that is none either, and messages must be.
        self._answers = os.fdopen(os.dup(1), "w", encoding="utf-8", errors="replace")
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)

    def _send(self, message):
        self._answers.write(json.dumps(message, ensure_ascii=False) + "\n")
        self._answers.flush()

    def ready(self, name=None):
        """Says that jobs are welcome."""
        message = {"hazcam": "ready", "protocol": 1}
        if name is not None:
            message["name"] = name
        self._send(message)

    def absent(self, text):
        """Says that this machine lacks something."""
        self._send({"hazcam": "absent", "message": text[:TEXT_LIMIT]})

    def job(self):
        """Waits for a job; None when there will be no more."""
        line = self._jobs.readline()
        return json.loads(line) if line else None

    def done(self, job):
        """Says that the answer is written."""
        self._send({"hazcam": "done", "job": job["job"]})

    def failed(self, job, kind, text):
        """Says why there is no answer. The kind is one of RE, ML and BAD."""
        message = kind + ": " + text[:TEXT_LIMIT]
        self._send({"hazcam": "failed", "job": job["job"], "message": message})
