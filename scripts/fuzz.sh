#!/usr/bin/env bash
# Fuzzes every parser from the shipped files: scripts/fuzz.sh [SECONDS per target, 600] [TARGET …]. Needs a
# nightly compiler and cargo-fuzz (the program needs neither):
#   rustup toolchain install nightly --profile minimal; cargo install cargo-fuzz --locked
# A finding ends the script and is kept below fuzz/artifacts; executions are printed for each target.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-600}
[ $# -gt 0 ] && shift
corpus=${FUZZ_CORPUS:-fuzz/corpus}
all="scene distribution csv yaml checkpoint checkpoint_payload nrrd mhd npy tiff heights"
mkdir -p $(printf "$corpus/%s " $all)
# Files of the formats as first inputs; what a parser does not ship with grows from nothing.
find scenes -name '*.xml' -exec cp {} "$corpus/scene/" \;
find distributions -name '*.xml' -exec cp {} "$corpus/distribution/" \;
find distributions scenes -name '*.csv' -size -64k -exec cp {} "$corpus/csv/" \;
find distributions -name '*.yml' -size -64k -exec cp {} "$corpus/yaml/" \;
find scenes -name '*.nrrd' -size -64k -exec cp {} "$corpus/nrrd/" \;
printf 'NDims = 3\nDimSize = 4 4 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\nElementDataFile = LOCAL\n%032d' 0 > "$corpus/mhd/small.mhd"
printf "\x93NUMPY\x01\x00\x36\x00{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2)}12345678" > "$corpus/npy/small.npy"
printf "\x00\x93NUMPY\x01\x00\x35\x00{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2)}0123456789abcdef" > "$corpus/heights/small.npy"
printf '\x02# um\n0,1,2\n3,4,5e0\n' > "$corpus/heights/small.csv"
printf '\x03Gwyddion Simple Field 1.0\nXRes = 2\nYRes = 1\nXReal = 1e-6\nYReal = 1e-6\n\0\0\0\000012345678' > "$corpus/heights/small.gsf"
for target in ${*:-$all}; do
  log=$(mktemp)
  cargo +nightly fuzz run "$target" "$corpus/$target" -- -max_total_time="$seconds" -timeout=10 -rss_limit_mb=3072 \
    -max_len=65536 -print_final_stats=1 > "$log" 2>&1 || { tail -40 "$log"; echo "$target: a finding"; exit 1; }
  echo "$target: $(sed -n 's/stat::number_of_executed_units: *//p' "$log") executions in $seconds s, no finding"
done
