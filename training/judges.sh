#!/bin/sh
# Trains the judges of `balanced` and `best` and puts their weights in place. Takes half an hour of two
# processors, and 8 GB below target/lessons. If it fails the weights are as before.
#
#     HAZCAM_DATA=~/stereo training/judges.sh
#
# The second judge of `best` learns from what the first one left. On pairs that the first one had among
# its own lessons it leaves less than it will elsewhere, so these lessons come from judges that were
# taught on the other half of the scenes (cross-fitting).
#
# Needs PyTorch and numpy; PYTHON names the interpreter.
set -eu
cd "$(dirname "$0")/.."
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
trap 'exit 1' INT TERM

# Lessons, after the judges that are in place. They are compiled in.
choices() {
    cargo run --quiet --release -p hazcam-training -- "$@"
}

# learn PRESET LESSONS WEIGHTS: appends a judge.
learn() {
    "${PYTHON:-python3}" training/choice.py $lessons/"$2" --preset "$1" --weights "$3"
}

: > $weights/balanced.bin
choices --preset balanced --out $lessons/all
learn balanced all $weights/balanced.bin

: > $weights/best.bin
for half in 1 2; do
    choices --preset best --half $half --out $lessons/$half
    : > $lessons/$half.bin
    learn best $half $lessons/$half.bin
done
cat $lessons/1 $lessons/2 > $lessons/all
: > $lessons/first.bin
learn best all $lessons/first.bin

cp $lessons/2.bin $weights/best.bin
choices --preset best --half 1 --out $lessons/1
cp $lessons/1.bin $weights/best.bin
choices --preset best --half 2 --out $lessons/2
cat $lessons/1 $lessons/2 > $lessons/all
cp $lessons/first.bin $weights/best.bin
learn best all $weights/best.bin
rm -r $lessons
