#!/usr/bin/env bash
# Opens what a run writes in the tools that it is for: healpy, NumPy, xmlschema, jsonschema. Makes a Python
# environment of its own with them where it is missing.
#   scripts/test-files.sh             runs two small scenes and opens their files
#   scripts/test-files.sh --present   exit code 0 if the environment is there
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
venv=${LIGHTPRO_PYTHON:-${XDG_CACHE_HOME:-$HOME/.cache}/lightpro-python}
if [[ ${1:-} == --present ]]; then "$venv/bin/python" -c 'import healpy, numpy, xmlschema, jsonschema' 2>/dev/null; exit; fi
if ! "$venv/bin/python" -c 'import healpy, numpy, xmlschema, jsonschema' 2>/dev/null; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet healpy numpy xmlschema jsonschema
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
program=${LIGHTPRO:-${CARGO_TARGET_DIR:-$root/target}/release/lightpro}
"$program" run "$root/scenes/tutorial/goniometer.xml" --histories 5000 --quiet -o "$work/goniometer"
"$program" run "$root/scenes/verify/klems-diffuser.xml" --histories 20000 --quiet -o "$work/klems"
"$venv/bin/python" "$root/scripts/test-files.py" "$root" "$work"
