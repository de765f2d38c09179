#!/bin/sh
# Instructions per event of the minimal loop: a count, not a time, the same on every run.
#   benches/count.sh            prints it
#   benches/count.sh check      fails if it is more than 2 % above the pinned number of this file
# Counted: the history loop of benches/slab_p1.rs (20,000 histories of P1, stream, source and tally included).
PINNED=34684613
cd "$(dirname "$0")/.." || exit 1
cargo build --release --bench slab_p1 >/dev/null 2>&1 || exit 1
bin=$(cargo build --release --bench slab_p1 --message-format=json 2>/dev/null |
  sed -n 's/.*"executable":"\([^"]*slab_p1-[^"]*\)".*/\1/p' | head -1)
got=$(valgrind --tool=callgrind --toggle-collect='*Case*run*' --callgrind-out-file=/dev/null "$bin" --test 2>&1 |
  sed -n 's/.*Collected : //p')
echo "$got instructions, $((got / 20000)) per history, $((got / 53200)) per scattering event; pinned $PINNED"
[ "$1" != check ] || [ "$got" -le $((PINNED + PINNED / 50)) ]
