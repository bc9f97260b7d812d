#!/bin/sh
# Trains the judges of `balanced` and `best` and puts their weights in place. Takes half an hour of two
# processors, and 5 GB below target/lessons, which stay if it fails; the weights are as before then.
#
#     HAZCAM_DATA=~/stereo training/judges.sh [--without NAME..]
#
# from the project's root. What it is given goes on to the program that writes lessons: --without keeps scenes out.
#
# The second judge of `best` learns from what the first one left. On pairs that the first one had among
# its own lessons it leaves less than it will elsewhere, so these lessons come from judges that were
# taught on the other half of the scenes (cross-fitting).
#
# Needs PyTorch and numpy; PYTHON names the interpreter.
set -eu
python=${PYTHON:-python3}
"$python" -c 'import numpy, torch' || { echo "judges.sh: needs PyTorch and numpy" >&2; exit 2; }
lessons=target/lessons
weights=crates/matching/src/refinement/choice
mkdir -p $lessons

before=$(mktemp -d)
cp $weights/*.bin "$before"
finish() {
    [ "$1" = 0 ] || cp "$before"/*.bin $weights
    rm -r "$before"
}
trap 'finish $?' EXIT
trap 'exit 1' HUP INT TERM

# Lessons, after the judges that are in place. They are compiled in.
choices() {
    preset=$1 out=$2
    shift 2
    cargo run --quiet --release -p hazcam-training -- --preset "$preset" --out "$out" "$@"
}

# learn PRESET WEIGHTS LESSONS..: appends a judge.
learn() {
    preset=$1 to=$2
    shift 2
    "$python" training/choice.py "$@" --preset "$preset" --weights "$to"
}

: > $weights/balanced.bin
choices balanced $lessons/all "$@"
learn balanced $weights/balanced.bin $lessons/all
rm $lessons/all

: > $weights/best.bin
for half in 1 2; do
    choices best $lessons/$half --half $half "$@"
    : > $lessons/$half.bin
    learn best $lessons/$half.bin $lessons/$half
done
: > $lessons/first.bin
learn best $lessons/first.bin $lessons/1 $lessons/2

cp $lessons/2.bin $weights/best.bin
choices best $lessons/1 --half 1 "$@"
cp $lessons/1.bin $weights/best.bin
choices best $lessons/2 --half 2 "$@"
cp $lessons/first.bin $weights/best.bin
learn best $weights/best.bin $lessons/1 $lessons/2
rm -r $lessons
