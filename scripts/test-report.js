// Called by test-report.sh: node test-report.js REPORT PICTURES PROFILE
"use strict";
const { chromium } = require("playwright-core");
const fs = require("fs");
const path = require("path");

const [report, pictures, profile] = process.argv.slice(2);
const args = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

function check(what, good) {
  console.log((good ? "ok    " : "FAILS ") + what);
  if (!good) process.exitCode = 1;
}

(async () => {
  const size = fs.statSync(report).size;
  check(`the file is ${(size / 1e6).toFixed(2)} MB, below 2 MB`, size < 2e6);
  const text = fs.readFileSync(report, "utf8");
  check("it asks for nothing outside itself", !/(src|href)="(?!data:|#)/.test(text) && !/url\((?!["']?data:)/.test(text));
  const browser = await chromium.launchPersistentContext(profile,
    { executablePath: "/usr/bin/chromium", headless: true, args, viewport: { width: 1100, height: 900 }, offline: true });
  const page = await browser.newPage();
  const errors = [];
  page.on("console", (m) => { if (m.type() === "error" || m.type() === "warning") errors.push(m.text()); });
  page.on("pageerror", (e) => errors.push(String(e)));
  page.on("requestfailed", (r) => errors.push("request " + r.url()));
  await page.goto("file://" + report);
  await page.waitForTimeout(300);

  const live = await page.locator("#polar").count();
  if (live) {
    const state = () => page.evaluate(() => document.querySelector("#polar .curve").getAttribute("points")
      + [...document.querySelectorAll("#map polygon")].slice(0, 400).map((p) => p.getAttribute("fill")).join());
    for (const id of ["wavelength", "run"]) {
      const slider = page.locator("#" + id);
      if (await slider.isDisabled()) { console.log(`note  slider ${id} has one position`); continue; }
      const before = await state(), label = await page.textContent(`#${id}-out`);
      await slider.focus();
      await page.keyboard.press("End");
      check(`slider ${id} moves the plot`, before !== await state());
      check(`slider ${id} says where it is`, label !== await page.textContent(`#${id}-out`));
    }
    const before = await state();
    await page.selectOption("#quantity", "factor");
    check("the choice of quantity moves the plot", before !== await state());
    await page.selectOption("#quantity", "intensity");
    check("the polar curve has points", await page.locator("#polar .dot").count() > 8);
  }
  const view = await page.evaluate(() => {
    const svg = document.querySelector("svg.view");
    if (!svg) return null;
    const box = svg.getBoundingClientRect();
    const marks = [...svg.querySelectorAll("path, circle, rect")].map((n) => n.getBoundingClientRect());
    const out = marks.filter((b) => b.left < box.left - 2 || b.right > box.right + 2 || b.top < box.top - 2 || b.bottom > box.bottom + 2);
    const of = (s) => svg.querySelectorAll(s).length;
    return { bodies: of(".v-bodies path"), paths: of(".v-path"), grid: of(".v-grid"), marks: of(".v-sphere path[fill-opacity]"), out: out.length, width: box.width };
  });
  check("the sheet is drawn: bodies, paths and the sphere with its event",
    view !== null && view.bodies > 10 && view.paths > 2 && view.grid === 1 && view.marks >= 2 && view.width > 500);
  check("nothing of it lies outside its picture", view !== null && view.out === 0);
  // Every text of every plot lies inside its picture, and no two texts of one plot overlap.
  const faults = await page.evaluate(() => {
    const out = [];
    document.querySelectorAll("details").forEach((d) => { d.open = false; });
    for (const svg of document.querySelectorAll("svg")) {
      const box = svg.getBoundingClientRect();
      const name = (svg.querySelector("title") || {}).textContent || svg.id;
      if (svg.querySelectorAll("polyline, path, polygon, rect, circle").length < 3) out.push("empty: " + name);
      const texts = [...svg.querySelectorAll("text")].map((t) => [t.textContent.trim(), t.getBoundingClientRect()]);
      for (const [text, b] of texts)
        if (b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1)
          out.push(`clipped: "${text}" in ${name}`);
      texts.forEach(([a, p], i) => texts.slice(i + 1).forEach(([b, q]) => {
        const w = Math.min(p.right, q.right) - Math.max(p.left, q.left);
        const h = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
        if (w > 2 && h > 3) out.push(`overlap: "${a}" and "${b}" in ${name}`);
      }));
    }
    if (document.documentElement.scrollWidth > document.documentElement.clientWidth + 1) out.push("the page is too wide");
    return out;
  });
  for (const f of faults) console.log("FAILS " + f);
  check("no clipped or overlapping label, no empty plot, no overflow", faults.length === 0);
  check("no console error" + (errors.length ? ": " + errors.join("; ") : ""), errors.length === 0);

  await page.screenshot({ path: path.join(pictures, "light.png"), fullPage: true });
  await page.emulateMedia({ colorScheme: "dark" });
  await page.screenshot({ path: path.join(pictures, "dark.png"), fullPage: true });
  await page.setViewportSize({ width: 420, height: 800 });
  await page.screenshot({ path: path.join(pictures, "narrow.png"), fullPage: true });
  await page.emulateMedia({ colorScheme: "light", media: "print" });
  const pdf = await page.pdf({ path: path.join(pictures, "print.pdf"), format: "A4", margin: { top: "15mm", bottom: "15mm", left: "15mm", right: "15mm" } });
  check("it prints", pdf.length > 20000);
  await browser.close();
})().catch((e) => { console.error(e); process.exit(1); });
