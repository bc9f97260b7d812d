"""The two things that the runner is asked to do.

inspect FOLDER        looks at the files and asks for the secret ID. The ID is the name in `ready`;
                      the one job after it is answered with the list of findings, as JSON.
run FOLDER FUNCTION   imports the module with the function's name, and calls it for every job.
"""

import json
import os
import sys

from hazcam_runner.channel import TEXT_LIMIT, Channel

# Characters of one finding.
FINDING_LIMIT = 1000


def main():
    """Does what the command line says."""
    channel = Channel()
    if "HAZCAM_SANDBOX" in os.environ:
        try:
            from hazcam_runner import programs

            programs.forbid()
        except (ImportError, OSError) as error:
            channel.absent(
                "{} cannot be kept from starting other programs ({}: {}): use another Python, with "
                "--python".format(sys.executable, type(error).__name__, error)
            )
            return
    try:
        # Before the submission's own folder is looked into: a file of its own called numpy.py
        # would be taken for it.
        import numpy  # noqa: F401
    except ImportError as error:
        channel.absent(
            "{} has no numpy ({}): install it with `{} -m pip install numpy scipy`".format(
                sys.executable, error, sys.executable
            )
        )
        return
    mode, folder = sys.argv[1:3]
    if mode == "inspect":
        _inspect(channel, folder)
    else:
        _run(channel, folder, sys.argv[3])


def _inspect(channel, folder):
    from hazcam_runner import inspecting

    identifier, findings = inspecting.inspect(folder)
    channel.ready(identifier)
    job = channel.job()
    if job is not None:
        channel.failed(job, "FINDINGS", _fitting(findings))


def _fitting(findings):
    """The findings as JSON that the channel does not cut: long ones shortened, and of too many the last left out, those
    last without which nothing can be graded."""
    findings = [dict(each, text=each["text"][:FINDING_LIMIT]) for each in findings]
    while len(text := json.dumps(findings, ensure_ascii=False)) > TEXT_LIMIT:
        spare = [i for i, each in enumerate(findings) if not each["fatal"]]
        del findings[spare[-1] if spare else -1]
    return text


def _run(channel, folder, name):
    from hazcam_runner import explaining, loading, older

    older.restore()
    try:
        function = loading.function(folder, name)
    except older.Missing as error:
        channel.absent(str(error))
        return
    except BaseException as error:
        # Said as the answer to the first job, because only an answer can say much.
        failure = explaining.explain(error, folder)
        channel.ready()
        job = channel.job()
        if job is not None:
            channel.failed(job, *failure)
        return
    channel.ready()
    while True:
        job = channel.job()
        if job is None:
            return
        try:
            _answer(job, function)
        except BaseException as error:
            channel.failed(job, *explaining.explain(error, folder))
        else:
            channel.done(job)


def _answer(job, function):
    import numpy as np

    from hazcam_runner import arrays

    if job["min_disparity"] != 0:
        raise arrays.BadAnswer(
            "a course function searches disparities from 0 on, but the range begins at {}".format(
                job["min_disparity"]
            )
        )
    left, right, box, largest = arrays.arguments(job)
    shape = left.shape
    answer = arrays.disparity(function(left, right, box, largest), shape)
    np.save(job["disparity"], answer, allow_pickle=False)
