"""What stands between hazcam and a course submission in Python (3.8 or newer, with numpy).

main        the two things it is asked to do
channel     messages in and out (see PROTOCOL.md), kept apart from what a submission prints
arrays      what the course's functions are given, and what they must return
loading     importing the submission's modules
explaining  errors in words that their author can act on, with the line they come from
hints       what usually lies behind an error
inspecting  what can be seen without running anything
programs    no other program is started from here
older       names that older versions of numpy, scipy and Python had, and libraries for drawing
"""
