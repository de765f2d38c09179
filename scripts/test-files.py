"""Called by test-files.sh: test-files.py ROOT WORK."""

import csv
import json
import pathlib
import sys
import xml.etree.ElementTree as ET

import healpy
import jsonschema
import numpy as np
import xmlschema

root, work = map(pathlib.Path, sys.argv[1:3])


def check(what, good):
    print(("ok    " if good else "FAILS ") + what)
    if not good:
        sys.exit(1)


run = work / "goniometer"
for side in ("above", "below"):
    maps = np.atleast_2d(healpy.read_map(run / f"angular_{side}.fits", field=None, dtype=np.float64))
    array = np.load(run / f"angular_{side}.npy")
    nside = healpy.get_nside(maps[0])
    same = array.shape == (3, 2, 768) and np.array_equal(maps.reshape(array.shape), array)
    check(f"healpy reads angular_{side}.fits (nside {nside}), bit for bit as NumPy reads angular_{side}.npy", nside == 8 and same)
rows = [r for r in csv.DictReader(open(run / "brdf.csv")) if r["kind"] == "brdf" and r["wavelength_nm"] == "457.0"]
above = np.load(run / "angular_above.npy")[0, 0]
# Patches above the horizon stand in brdf.csv by their HEALPix number, turned so that light comes from 180 deg.
theta, phi = healpy.pix2ang(8, [int(r["patch"]) for r in rows if float(r["polar_deg"]) < 80])
polar = np.array([float(r["polar_deg"]) for r in rows if float(r["polar_deg"]) < 80])
check("patches of brdf.csv stand where healpy puts them", np.allclose(np.degrees(theta), polar, atol=1e-9))
total = sum(float(r["f_per_sr"]) for r in rows)
check("brdf.csv is not empty and positive", total > 0 and above.sum() > 0)

xsd = xmlschema.XMLSchema(str(root / "schema" / "scene.xsd"))
scenes = sorted(p for p in (root / "scenes").rglob("*.xml") if "<scene " in p.read_text())
for p in scenes:
    xsd.validate(str(p))
for p in (root / "scenes" / "tutorial" / "media.xml", root / "scenes" / "tutorial" / "my-pulp.xml"):
    xsd.validate(str(p))
check(f"{len(scenes)} scenes hold the XSD", len(scenes) > 25)

schema = json.load(open(root / "schema" / "result.schema.json"))
jsonschema.Draft202012Validator.check_schema(schema)
for p in sorted(work.rglob("result.json")):
    jsonschema.validate(json.load(open(p)), schema)
check("result.json holds its schema", True)

ns = {"w": "http://windows.lbl.gov"}
tree = ET.parse(work / "klems" / "bsdf.xml").getroot()
blocks = {b.find("w:WavelengthDataDirection", ns).text: b for b in tree.iter("{http://windows.lbl.gov}WavelengthDataBlock")}
matrix = lambda name: np.array(
    [[float(x) for x in line.split(",")] for line in blocks[name].find("w:ScatteringData", ns).text.strip().splitlines()]
)
reflected, transmitted = matrix("Reflection Front"), matrix("Transmission Front")
check("bsdf.xml holds two 145 x 145 matrices", reflected.shape == transmitted.shape == (145, 145))
# A white Lambertian surface: f = 1/pi, projected solid angles of the basis give back all light.
bands = [(0, 5, 1), (5, 15, 8), (15, 25, 16), (25, 35, 20), (35, 45, 24), (45, 55, 24), (55, 65, 24), (65, 75, 16), (75, 90, 12)]
omega = np.concatenate(
    [np.full(n, np.pi * (np.sin(np.radians(b)) ** 2 - np.sin(np.radians(a)) ** 2) / n) for a, b, n in bands]
)
share = omega / np.pi
check("its mean over the incident light is 1/pi", abs((omega @ reflected) @ share - 1) < 1e-3)
check("nothing is transmitted", np.all(transmitted == 0))
