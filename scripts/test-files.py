"""Called by test-files.sh: test-files.py ROOT WORK."""

import csv
import json
import pathlib
import sys
import xml.etree.ElementTree as ET

import healpy
import jsonschema
import nrrd
import numpy as np
import xmlschema
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkMetaImageReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLImageDataReader

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
# The form that WINDOW and Radiance read (no schema of it is published under a free licence), by rule: every
# basis that a block names is defined, its patches number 145, its rings follow each other from 0 to 90 deg, and
# every matrix has a column for each incident and a row for each outgoing patch, none negative.
bases = {}
for b in tree.iter("{http://windows.lbl.gov}AngleBasis"):
    rings = [
        (float(r.find("w:ThetaBounds/w:LowerTheta", ns).text), float(r.find("w:ThetaBounds/w:UpperTheta", ns).text), int(r.find("w:nPhis", ns).text))
        for r in b.findall("w:AngleBasisBlock", ns)
    ]
    bases[b.find("w:AngleBasisName", ns).text] = rings
named = {b.find(f"w:{side}AngleBasis", ns).text for b in tree.iter("{http://windows.lbl.gov}WavelengthDataBlock") for side in ("Column", "Row")}
check("every angle basis that bsdf.xml names is defined", named <= set(bases))
rings = bases["LBNL/Klems Full"]
follow = rings[0][0] == 0 and rings[-1][1] == 90 and all(a[1] == b[0] for a, b in zip(rings, rings[1:]))
check("its rings follow each other and hold 145 patches", follow and sum(n for _, _, n in rings) == 145)
check("its rings are those of the Klems basis", [(a, b, n) for a, b, n in rings] == bands)
check("all matrices are 145 x 145 and not negative", all(m.shape == (145, 145) and m.min() >= 0 for m in map(matrix, blocks)))
# Reciprocity of a Lambertian surface: f(i, o) = f(o, i), within counting noise of all pairs together.
power = reflected * omega[:, None] * omega[None, :]
check("its BRDF is symmetric in the mean", abs(np.triu(power, 1).sum() - np.tril(power, -1).sum()) / power.sum() < 0.03)


def polydata(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    check(f"VTK reads {path.name}", reader.GetErrorCode() == 0 and reader.GetOutput().GetNumberOfPoints() > 0)
    return reader.GetOutput()


mesh = polydata(work / "cell.vtp")
bodies = vtk_to_numpy(mesh.GetCellData().GetArray("body"))
text = (work / "cell.xml").read_text()
fibres, spheres = text.count("<cylinder"), text.count("<sphere")
check(f"it holds all {fibres} fibres and {spheres} spheres", fibres > 10 and len(np.unique(bodies)) == fibres + spheres)
check("and a polygon for every side and cap", mesh.GetNumberOfPolys() == fibres * 34 + spheres * 128)

path = polydata(work / "replay" / next(p.name for p in (work / "replay").glob("*.vtp")))
rows = list(csv.DictReader(open(next((work / "replay").glob("*.csv")))))
flights = [r for r in rows if r["what"] == "flight"]
points = vtk_to_numpy(path.GetPoints().GetData()).reshape(-1, 2, 3)
starts = np.array([[float(r[f"{a}_um"]) for a in "xyz"] for r in flights])
check(f"its {len(flights)} lines start where the flights of the table do", path.GetNumberOfLines() == len(flights) and np.array_equal(points[:, 0], starts))

volume, header = nrrd.read(str(work / "cell-voxels.nrrd"))
check(f"pynrrd reads cell-voxels.nrrd, {volume.shape}", volume.shape == (300, 300, 60) and np.allclose(header["spacings"], 0.5))
reader = vtkMetaImageReader()
reader.SetFileName(str(work / "meta-voxels.mhd"))
reader.Update()
image = reader.GetOutput()
vti = vtkXMLImageDataReader()
vti.SetFileName(str(work / "meta-voxels.vti"))
vti.Update()
cells = vti.GetOutput()
shape = tuple(n - 1 for n in cells.GetDimensions())
labels = vtk_to_numpy(cells.GetCellData().GetArray("label")).reshape(shape, order="F")
check("and those of meta-voxels.vti", np.array_equal(labels, volume) and np.allclose(cells.GetSpacing(), 0.5))
same = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions(), order="F")
check("VTK reads the same labels from meta-voxels.mhd", np.array_equal(same, volume) and np.allclose(image.GetSpacing(), 0.5))
