"""Runs a course submission as an engine: `python start.py inspect|run FOLDER [FUNCTION]`.

Lives beside the package and not in it, so that this folder, and not the working folder, is where
Python looks first: a submission may hold a file called `json.py`.
"""

from hazcam_runner.main import main

main()
