#!/bin/sh
# Trains the judges of `balanced` and `best` and puts their weights in place. Takes 40 minutes of two
# processors, and 19 GB below target/lessons, which stay if it fails; the weights are as before then.
#
#     HAZCAM_DATA=~/stereo training/judges.sh [--without NAME..]
#
# from the project's root. What it is given goes on to the program that writes lessons: --without keeps scenes out.
#
# The other judges learn from what the first one left, and differ by chance alone. On pairs that the first one
# had among its own lessons it leaves less than it will elsewhere, so in `best` these lessons come from judges
# that were taught on the other half of the scenes (cross-fitting).
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
    kill $(jobs -p) 2>/dev/null || true
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

# learn PRESET WEIGHTS [--seed N] [--context N] LESSONS..: appends a judge. Steps are small: more threads would not be
# faster, and what is learned would depend on their number.
learn() {
    preset=$1 to=$2
    shift 2
    OMP_NUM_THREADS=1 "$python" training/choice.py "$@" --preset "$preset" --weights "$to"
}

for file in $weights/balanced.bin $weights/best.bin $lessons/balanced.bin $lessons/1.bin $lessons/2.bin $lessons/first.bin
do
    : > $file
done
choices balanced $lessons/all "$@"
learn balanced $lessons/balanced.bin --seed 23 $lessons/all &
balanced=$!
for half in 1 2; do
    choices best $lessons/$half --half $half "$@"
done
wait $balanced
rm $lessons/all
cp $lessons/balanced.bin $weights/balanced.bin
choices balanced $lessons/left "$@"
# Two at a time; each begins anew.
later() {
    : > $lessons/later$1.bin
    learn balanced $lessons/later$1.bin --seed "$1" $lessons/left
}
for seed in 1 3
do
    later $seed &
    one=$!
    later $((seed + 1))
    wait $one
done
cat $lessons/later?.bin >> $lessons/balanced.bin
rm $lessons/left

learn best $lessons/1.bin --context 32 $lessons/1 &
one=$!
learn best $lessons/2.bin --context 32 $lessons/2
wait $one
learn best $lessons/first.bin --context 32 $lessons/1 $lessons/2 &
first=$!
for half in 1 2; do
    cp $lessons/$((3 - half)).bin $weights/best.bin
    choices best $lessons/left$half --half $half "$@"
done
wait $first
cp $lessons/first.bin $weights/best.bin
cp $lessons/balanced.bin $weights/balanced.bin
# Those with a context, as the first, and those without take turns.
another() {
    : > $lessons/another$1.bin
    learn best $lessons/another$1.bin --seed "$1" --context $(($1 % 2 ? 0 : 32)) $lessons/left1 $lessons/left2
}
for seed in 1 3
do
    another $seed &
    one=$!
    another $((seed + 1))
    wait $one
done
another 5
cat $lessons/first.bin $lessons/another?.bin > $weights/best.bin
rm -r $lessons
