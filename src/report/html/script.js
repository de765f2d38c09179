"use strict";
// Polar cut and hemisphere maps of the directions in which light leaves; the sliders choose run and wavelength.
(function () {
  const box = document.getElementById("directions");
  if (!box) return;
  const D = JSON.parse(document.getElementById("data").textContent);
  const NS = "http://www.w3.org/2000/svg";
  const el = (id) => document.getElementById(id);
  const rad = Math.PI / 180;
  const RAMP = [[68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128],
    [94, 201, 98], [173, 220, 48], [253, 231, 37]];
  function colour(t) {
    const x = Math.min(Math.max(t, 0), 1) * 8, i = Math.min(Math.floor(x), 7), f = x - i;
    return "rgb(" + [0, 1, 2].map((k) => Math.round(RAMP[i][k] + f * (RAMP[i + 1][k] - RAMP[i][k]))) + ")";
  }
  function add(parent, tag, attributes, text) {
    const node = document.createElementNS(NS, tag);
    for (const k in attributes) node.setAttribute(k, attributes[k]);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  }
  // A patch is [polar, azimuth, solid angle, projected solid angle, outline …].
  const patches = D.patches;
  const scale = (i, factor) => factor ? Math.PI / patches[i][3] : 1 / patches[i][2];
  const below = patches.some((p, i) => p[0] > 90 && D.runs.some((r) => r.powers.some((w) => w[i] > 0)));

  function niceStep(top) {
    const raw = top / 4, decade = Math.pow(10, Math.floor(Math.log10(raw)));
    return [1, 2, 5, 10].map((m) => m * decade).find((s) => s >= 0.999 * raw);
  }
  const tidy = (v) => String(Number(v.toPrecision(6)));

  // Angle from the upward normal, positive towards the mirror direction; equal angles averaged.
  function cut(run, w, factor) {
    const near = D.cut.map((i, k) => {
      const p = patches[i], side = Math.cos(p[1] * rad) >= 0 ? 1 : -1;
      return [side * p[0], run.powers[w][i] * scale(i, factor), run.errors[w][k] * scale(i, factor)];
    }).sort((a, b) => a[0] - b[0]);
    const out = [];
    for (const p of near) {
      const last = out[out.length - 1];
      if (last && Math.abs(last[0] - p[0]) < 1e-3) { last[1] += p[1]; last[2] += p[2] * p[2]; last[3] += 1; }
      else out.push([p[0], p[1], p[2] * p[2], 1]);
    }
    return out.map((p) => [p[0], p[1] / p[3], Math.sqrt(p[2]) / p[3]]);
  }
  // One scale for all wavelengths and runs, so that the sliders show change.
  function largest(factor) {
    let top = 0;
    for (const run of D.runs) for (let w = 0; w < D.wavelengths.length; w++)
      for (const p of cut(run, w, factor)) top = Math.max(top, p[1] + p[2]);
    return top > 0 ? top : 1;
  }
  const tops = [largest(false), largest(true)];

  function polar(run, w, factor) {
    const svg = el("polar");
    svg.replaceChildren();
    const R = 168, cx = 260, cy = 212, step = niceStep(tops[+factor]);
    const top = Math.ceil(tops[+factor] / step - 1e-9) * step;
    svg.setAttribute("viewBox", below ? "0 0 520 444" : "0 0 520 262");
    const at = (angle, value) => {
      const r = R * Math.max(value, 0) / top;
      return [cx + r * Math.sin(angle * rad), cy - r * Math.cos(angle * rad)];
    };
    const end = below ? 180 : 90;
    for (let v = step; v < top * 1.001; v += step) {
      const pts = [];
      for (let a = -end; a <= end; a += 3) pts.push(at(a, v).join());
      add(svg, "polyline", { points: pts.join(" "), class: "grid-line" });
    }
    for (let a = -end + (below ? 30 : 0); a <= end; a += 30) {
      const [x, y] = at(a, top), [tx, ty] = at(a, top * 1.08);
      add(svg, "line", { x1: cx, y1: cy, x2: x, y2: y, class: "grid-line" });
      const anchor = Math.abs(Math.sin(a * rad)) < 0.1 ? "middle" : a > 0 ? "start" : "end";
      add(svg, "text", { x: tx, y: ty + 4, "text-anchor": anchor }, Math.abs(a) + "°");
    }
    for (let v = step; v < top * 1.001; v += step) {
      const [x, y] = at(15, v);
      add(svg, "text", { x: x + 2, y: y + 4 }, tidy(v));
    }
    add(svg, "line", { x1: cx - R, y1: cy, x2: cx + R, y2: cy, class: "axis" });
    if (run.incidence !== null && run.incidence < 90) {
      const [x1, y1] = at(-run.incidence, top * 0.98), [x2, y2] = at(-run.incidence, top * 0.62);
      add(svg, "line", { x1, y1, x2, y2, class: "light" });
      const a = Math.atan2(y2 - y1, x2 - x1), h = 8;
      add(svg, "polygon", { class: "light", points: [[x2, y2],
        [x2 - h * Math.cos(a - 0.4), y2 - h * Math.sin(a - 0.4)],
        [x2 - h * Math.cos(a + 0.4), y2 - h * Math.sin(a + 0.4)]].map((p) => p.join()).join(" ") });
    }
    const points = cut(run, w, factor);
    for (const part of [points.filter((p) => Math.abs(p[0]) <= 90),
      points.filter((p) => p[0] > 90).concat(points.filter((p) => p[0] < -90).map((p) => [p[0] + 360, p[1], p[2]]))]) {
      if (!part.length || (!below && Math.abs(part[0][0]) > 90)) continue;
      add(svg, "polyline", { class: "curve", points: part.map((p) => at(p[0], p[1]).join()).join(" ") });
      for (const p of part) {
        const [x1, y1] = at(p[0], p[1] - p[2]), [x2, y2] = at(p[0], p[1] + p[2]), [x, y] = at(p[0], p[1]);
        add(svg, "line", { x1, y1, x2, y2, class: "bar" });
        add(svg, "circle", { cx: x, cy: y, r: 2.2, class: "dot" });
      }
    }
    const what = factor ? "radiance factor" : "radiant intensity per incident power (1/sr)";
    add(svg, "text", { x: 260, y: below ? 438 : 254, "text-anchor": "middle" }, what + (run.incidence === null ? "; diffuse light" : "; light from the left"));
  }

  // Lambert's equal-area projection of one hemisphere, one polygon a patch, coloured by value.
  const discs = [];
  function disc(svg, cx, cy, down, title) {
    const R = 118, place = (p, a) => {
      const r = R * Math.SQRT2 * Math.sin(0.5 * Math.min(p, 90) * rad);
      return [(cx + r * Math.cos(a * rad)).toFixed(1), (cy - r * Math.sin(a * rad)).toFixed(1)].join();
    };
    patches.forEach((p, i) => {
      if ((p[0] > 90) !== down) return;
      const o = p[4], points = [];
      for (let k = 0; k < o.length; k += 2) points.push(place(down ? 180 - o[k] : o[k], o[k + 1]));
      const node = add(svg, "polygon", { points: points.join(" "), "stroke-width": 0.5 });
      discs.push([node, i]);
    });
    for (const ring of [30, 60]) {
      const r = R * Math.SQRT2 * Math.sin(0.5 * ring * rad);
      add(svg, "circle", { cx, cy, r, fill: "none", stroke: "#fff", "stroke-width": 0.6 });
    }
    add(svg, "circle", { cx, cy, r: R, class: "axis" });
    add(svg, "text", { x: cx, y: cy - R - 20, "text-anchor": "middle" }, title);
    add(svg, "text", { x: cx, y: cy - R - 6, "text-anchor": "middle" }, "90°");
    add(svg, "text", { x: cx, y: cy + R + 14, "text-anchor": "middle" }, "270°");
    return R;
  }
  const map = el("map");
  disc(map, below ? 150 : 270, 150, false, "above (reflected)");
  if (below) disc(map, 410, 150, true, "below (transmitted)");
  for (let i = 0; i < 60; i++)
    add(map, "rect", { x: 110 + 5 * i, y: 296, width: 5.5, height: 12, fill: colour((i + 0.5) / 60) });
  const low = add(map, "text", { x: 110, y: 322, "text-anchor": "middle" }, "0");
  const high = add(map, "text", { x: 410, y: 322, "text-anchor": "middle" }, "");
  const brightest = [false, true].map((factor) => {
    let top = 0;
    for (const run of D.runs) for (const w of run.powers)
      patches.forEach((p, i) => { if (p[3] > 0.2 * p[2]) top = Math.max(top, w[i] * scale(i, factor)); });
    return top > 0 ? top : 1;
  });
  function paint(run, w, factor) {
    const top = brightest[+factor];
    for (const [node, i] of discs) {
      const c = colour(run.powers[w][i] * scale(i, factor) / top);
      node.setAttribute("fill", c);
      node.setAttribute("stroke", c);
    }
    low.textContent = "0";
    high.textContent = Number(top.toPrecision(3));
  }

  function draw() {
    const run = D.runs[+el("run").value], w = +el("wavelength").value, factor = el("quantity").value === "factor";
    el("run-out").textContent = run.label;
    el("wavelength-out").textContent = D.wavelengths[w] + " nm";
    polar(run, w, factor);
    paint(run, w, factor);
  }
  for (const id of ["run", "wavelength", "quantity"]) el(id).addEventListener("input", draw);
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
  draw();
})();
