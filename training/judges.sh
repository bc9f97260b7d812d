#!/bin/sh
# Trains the judges of `balanced` and `best` and puts their weights in place. Takes 40 minutes of two
# processors, some 12 GB of memory, and 19 GB in target/lessons.*, which stay if it fails; the weights are as
# before then.
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
weights=crates/matching/src/refinement/choice
mkdir -p target
# Of its own, since another run may not have ended.
lessons=$(mktemp -d target/lessons.XXXXXX)

before=$(mktemp -d)
cp $weights/*.bin "$before"
running=
finish() {
    [ -z "$running" ] || kill $running 2>/dev/null || true
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

# start PRESET WEIGHTS [--seed N] [--context N] LESSONS..: begins to learn a judge, which is appended. Steps are small:
# more threads would not be faster, and what is learned would depend on their number.
start() {
    preset=$1 to=$2
    shift 2
    OMP_NUM_THREADS=1 "$python" training/choice.py "$@" --preset "$preset" --weights "$to" &
    started=$!
    running="$running $started"
}

for file in $weights/balanced.bin $weights/best.bin $lessons/balanced.bin $lessons/1.bin $lessons/2.bin $lessons/first.bin
do
    : > $file
done
choices balanced $lessons/all "$@"
start balanced $lessons/balanced.bin --seed 23 $lessons/all
balanced=$started
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
    start balanced $lessons/later$1.bin --seed "$1" $lessons/left
}
for seed in 1 3
do
    later $seed
    one=$started
    later $((seed + 1))
    wait $one
    wait $started
done
cat $lessons/later?.bin >> $lessons/balanced.bin
rm $lessons/left

start best $lessons/1.bin --context 32 $lessons/1
one=$started
start best $lessons/2.bin --context 32 $lessons/2
wait $one
wait $started
start best $lessons/first.bin --context 32 $lessons/1 $lessons/2
first=$started
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
    start best $lessons/another$1.bin --seed "$1" --context $(($1 % 2 ? 0 : 32)) $lessons/left1 $lessons/left2
}
for seed in 1 3
do
    another $seed
    one=$started
    another $((seed + 1))
    wait $one
    wait $started
done
another 5
wait $started
cat $lessons/first.bin $lessons/another?.bin > $weights/best.bin
rm -r $lessons
