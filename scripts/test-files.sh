#!/usr/bin/env bash
# Opens what a run writes in the tools that it is for: healpy, NumPy, xmlschema, jsonschema, VTK, pynrrd. Makes a Python
# environment of its own with them where it is missing.
#   scripts/test-files.sh             runs two small scenes and opens their files
#   scripts/test-files.sh --present   exit code 0 if the environment is there
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
venv=${LIGHTPRO_PYTHON:-${XDG_CACHE_HOME:-$HOME/.cache}/lightpro-python}
if [[ ${1:-} == --present ]]; then "$venv/bin/python" -c 'import healpy, numpy, xmlschema, jsonschema, vtkmodules, nrrd' 2>/dev/null; exit; fi
if ! "$venv/bin/python" -c 'import healpy, numpy, xmlschema, jsonschema, vtkmodules, nrrd' 2>/dev/null; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet healpy numpy xmlschema jsonschema vtk pynrrd
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
program=${LIGHTPRO:-${CARGO_TARGET_DIR:-$root/target}/release/lightpro}
"$program" run "$root/scenes/tutorial/goniometer.xml" --histories 5000 --quiet -o "$work/goniometer"
"$program" run "$root/scenes/verify/klems-diffuser.xml" --histories 20000 --quiet -o "$work/klems"
cat >"$work/tubes.xml" <<'SCENE'
<?xml version="1.0"?>
<scene name="tubes" version="1">
  <materials><material id="air" index="1"/><material id="lumen" index="1"/><material id="wall" index="1.55"/></materials>
  <universe kind="statistical" memory="full" outside="air" edges="contained">
    <sheet thickness="30 um" pore="air"><layer>
      <fibres name="pulp" material="wall" lumen="lumen" width="10 um" flatness=".5" wall="1.5 um" length="100 um" ends="flat" grammage="8 g/m2"/>
      <particles shape="sphere" material="wall" diameter="5 um" volume-fraction="1 %"/>
    </layer></sheet>
  </universe>
  <source kind="diffuse"/>
  <run histories="4096"/>
</scene>
SCENE
"$program" realise "$work/tubes.xml" --cell 0.15mm --voxel 0.5um -o "$work/cell" >/dev/null
"$program" realise "$work/tubes.xml" --cell 0.15mm --voxel 0.5um --mhd --vti -o "$work/meta" >/dev/null
mkdir "$work/replay"
"$program" replay "$work/tubes.xml" --history 8 -o "$work/replay" >/dev/null
"$venv/bin/python" "$root/scripts/test-files.py" "$root" "$work"
