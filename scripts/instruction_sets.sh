#!/usr/bin/env bash
# The same bytes from every instruction set: builds the program for plain x86-64, x86-64-v3 (AVX2, FMA)
# and x86-64-v4 (AVX-512), runs one small scene of each universe with each, and compares result.json;
# the bits of the elementary functions are compared by tests/math_bits.rs in the same builds (with
# --math). A set that this machine lacks is left out, and said so. On another architecture:
#   rustup target add aarch64-unknown-linux-gnu; cargo test --target aarch64-unknown-linux-gnu \
#     --test math_bits --test shipped_scenes      (on such a machine, or with qemu-user as runner)
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}/instruction-sets
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
scenes="verify/slab-p2 verify/hollow-fibres-full verify/scattering-fibres-none verify/alp-3c-full verify/voxel-plate voxel-sheet"
declare -A needs=([x86-64]=sse2 [x86-64-v3]=avx2 [x86-64-v4]=avx512f)
for cpu in x86-64 x86-64-v3 x86-64-v4; do
  if ! grep -qw "${needs[$cpu]}" /proc/cpuinfo; then echo "$cpu: this machine lacks it"; continue; fi
  RUSTFLAGS="-C target-cpu=$cpu" cargo build --quiet --release --bin lightpro --target-dir "$target/$cpu"
  if [ "${1:-}" = --math ]; then
    RUSTFLAGS="-C target-cpu=$cpu" cargo test --quiet --target-dir "$target/$cpu" --test math_bits
  fi
  for scene in $scenes; do
    "$target/$cpu/release/lightpro" run "scenes/$scene.xml" --histories 5000 --quiet --force -o "$work/$cpu" || true
    cp "$work/$cpu/result.json" "$work/$cpu-${scene//\//-}.json"
    cmp "$work/$cpu-${scene//\//-}.json" "$work/x86-64-${scene//\//-}.json"
  done
  echo "$cpu: $(echo $scenes | wc -w) scenes, the same bytes"
done
