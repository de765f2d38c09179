#!/usr/bin/env bash
# Opens report.html in a headless Chromium: it renders without a console error, the sliders move the plot,
# nothing lies outside its picture, print and dark mode work. Pictures go to the folder of the second
# argument. Installs Debian's chromium and the npm package playwright-core (which downloads no browser)
# where they are missing.
#   scripts/test-report.sh [REPORT.html] [PICTURES]      without a report it runs two scenes and takes theirs
#   scripts/test-report.sh --present                      exit code 0 if the browser and its driver are there
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
driver=${LIGHTPRO_BROWSER_DRIVER:-${XDG_CACHE_HOME:-$HOME/.cache}/lightpro-browser}
present() { command -v chromium >/dev/null && command -v node >/dev/null && [[ -d $driver/node_modules/playwright-core ]]; }
if [[ ${1:-} == --present ]]; then present; exit; fi
if ! present; then
    if ! command -v chromium >/dev/null || ! command -v npm >/dev/null; then
        apt-get update -qq
        apt-get install -y -qq --no-install-recommends chromium nodejs npm
    fi
    mkdir -p "$driver"
    (cd "$driver" && npm install --silent --no-fund --no-audit --ignore-scripts playwright-core)
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
open_report() { # REPORT PICTURES
    mkdir -p "$2"
    NODE_PATH=$driver/node_modules node "$root/scripts/test-report.js" "$(realpath "$1")" "$(realpath "$2")" "$work/profile-$RANDOM"
}
if [[ -n ${1:-} ]]; then
    open_report "$1" "${2:-$work/pictures}"
    exit
fi
program=${LIGHTPRO:-${CARGO_TARGET_DIR:-$root/target}/release/lightpro}
"$program" run "$root/scenes/tutorial/sheet.xml" -D "source.trap=0 deg" --histories 20000 --quiet -o "$work/sheet"
"$program" run "$root/scenes/tutorial/goniometer.xml" --sweep "source.polar=0:60:30 deg" --histories 10000 --quiet -o "$work/series"
"$program" run "$root/scenes/voxel-sheet.xml" --histories 4000 --quiet -o "$work/voxels"
"$program" realise "$root/scenes/verify/deposited-lossless.xml" -o "$work/bodies" >/dev/null
"$program" run "$work/bodies.xml" --histories 4096 --quiet -o "$work/bodies"
for name in sheet series voxels bodies; do
    echo "$name"
    open_report "$work/$name/report.html" "$work/$name-pictures"
done
