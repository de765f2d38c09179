#!/usr/bin/env bash
# The same bytes from every instruction set: builds the program for plain x86-64, x86-64-v3 (AVX2, FMA),
# x86-64-v4 (AVX-512) and aarch64, runs one small scene of each universe with each, and compares result.json
# with that of the first. There is no dispatch at run time: what the compiler was told is what runs.
#   scripts/instruction_sets.sh          the scenes
#   scripts/instruction_sets.sh --math   the bits of the elementary functions, too (tests/math_bits.rs)
# A set that this machine lacks is left out, and said so. aarch64 on another machine is emulated; it needs
#   rustup target add aarch64-unknown-linux-gnu
#   apt-get install qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}/instruction-sets
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
scenes="verify/slab-p2 verify/hollow-fibres-full verify/scattering-fibres-none verify/alp-3c-full verify/voxel-plate voxel-sheet"
arm=aarch64-unknown-linux-gnu
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"

# Whether the machine can run the set $1.
runs() {
  local flag
  case $1 in
    aarch64) command -v qemu-aarch64 aarch64-linux-gnu-gcc >/dev/null && rustc --target $arm --print target-libdir | xargs test -d; return ;;
    x86-64) flag=sse2 ;;
    x86-64-v3) flag=avx2 ;;
    x86-64-v4) flag=avx512f ;;
  esac
  grep -qw "$flag" /proc/cpuinfo
}

first=
for set in x86-64 x86-64-v3 x86-64-v4 aarch64; do
  if ! runs $set; then echo "$set: this machine lacks it"; continue; fi
  if [ $set = aarch64 ]; then
    options=(--target $arm) program="$CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER $target/$set/$arm/release/lightpro"
    unset RUSTFLAGS
  else
    options=() program=$target/$set/release/lightpro
    export RUSTFLAGS="-C target-cpu=$set"
  fi
  cargo build --quiet --release --bin lightpro --target-dir "$target/$set" "${options[@]}"
  if [ "${1:-}" = --math ]; then
    cargo test --quiet --target-dir "$target/$set" "${options[@]}" --test math_bits
  fi
  first=${first:-$set}
  for scene in $scenes; do
    $program run "scenes/$scene.xml" --histories 5000 --quiet --force -o "$work/$set" || true
    cp "$work/$set/result.json" "$work/$set-${scene//\//-}.json"
    cmp "$work/$set-${scene//\//-}.json" "$work/$first-${scene//\//-}.json"
  done
  echo "$set: $(echo $scenes | wc -w) scenes, the same bytes"
done
