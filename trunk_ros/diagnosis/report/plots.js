"use strict";
(() => {
  const held = JSON.parse(document.getElementById("series").textContent);
  const box = document.getElementById("plots"), chips = document.getElementById("chips");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const sync = uPlot.sync("time");
  const shown = new Map();  // signal -> its two plots
  let range = null, quiet = false;

  const unpack = text => {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    return Array.from(new Float32Array(bytes.buffer), v => Number.isNaN(v) ? null : v);
  };
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const number = v => v == null ? "–" : Number(v.toPrecision(4)).toString().replace("-", "−");

  // One zoom for all: x of any plot is x of every plot.
  const zoomed = plot => {
    if (quiet) return;
    quiet = true;
    range = [plot.scales.x.min, plot.scales.x.max];
    for (const pair of shown.values())
      for (const other of pair) if (other !== plot) other.setScale("x", {min: range[0], max: range[1]});
    quiet = false;
  };
  const shade = signal => plot => {
    const {ctx, bbox} = plot;
    ctx.save();
    ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    signal.regimes.forEach((regime, k) => {
      ctx.fillStyle = colour(k % 2 ? "--shade2" : "--shade1");
      for (const [from, until] of regime.spans) {
        const left = plot.valToPos(from, "x", true), right = plot.valToPos(until, "x", true);
        ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
      }
    });
    ctx.restore();
  };
  const axis = (label, size, space) => ({
    label, size, space, labelSize: 16, labelGap: 2, font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif",
    stroke: colour("--muted"), grid: {stroke: colour("--line"), width: 1}, ticks: {stroke: colour("--line"), width: 1, size: 4},
    values: (_, ticks) => ticks.map(v => v == null ? "" : number(v)),
  });
  const line = (label, name, width, dash) => ({
    label, stroke: colour(name), width, dash, points: {show: false}, spanGaps: false, value: (_, v) => number(v),
  });
  const options = (signal, height, unit, lines, last) => ({
    width: box.clientWidth, height,
    cursor: {sync: {key: sync.key, setSeries: false}, drag: {x: true, y: false}, y: false},
    legend: {live: true},
    scales: {x: {time: false}},
    axes: [axis(last ? "time / s" : "", last ? 30 : 22, 60), axis(unit, 56, 24)],
    series: [{label: "t / s", value: (_, v) => number(v)}, ...lines],
    hooks: {drawClear: [shade(signal)], setScale: [(plot, key) => key === "x" && zoomed(plot)]},
  });

  const draw = signal => {
    const frame = document.createElement("div");
    frame.className = "plot";
    const h = document.createElement("h4");
    h.textContent = signal.name;
    frame.append(h);
    box.append(frame);
    const t = unpack(signal.time), measured = unpack(signal.measured), residuals = signal.residuals.map(unpack);
    const predicted = residuals.map(r => r.map((v, k) => v == null ? null : measured[k] - signal.scale * v));
    const angles = new uPlot(options(signal, 170, signal.quantity + " / " + signal.unit, [
      line("measured", "--ink", 1.6), line("nominal", "--grey", 1.4, [5, 4]), ...(predicted.length > 1 ? [line("fitted", "--accent", 1.4)] : []),
    ], false), [t, measured, ...predicted], frame);
    const rest = new uPlot(options(signal, 170, "residual / " + signal.residual_unit, [
      line("nominal", "--grey", 1.1), ...(residuals.length > 1 ? [line("fitted", "--accent", 1.1)] : []),
    ], true), [t, ...residuals], frame);
    for (const regime of signal.regimes) {
      const note = document.createElement("p");
      note.className = "note key key" + (1 + signal.regimes.indexOf(regime) % 2);
      note.textContent = regime.what;
      frame.append(note);
    }
    shown.set(signal, [angles, rest]);
    sync.sub(angles); sync.sub(rest);
    if (range) for (const plot of [angles, rest]) plot.setScale("x", {min: range[0], max: range[1]});
  };
  const erase = () => {
    for (const pair of shown.values()) for (const plot of pair) { sync.unsub(plot); plot.destroy(); }
    shown.clear();
    box.replaceChildren();
  };
  const redraw = () => { const keep = range; erase(); range = keep; held.signals.filter(s => s.open).forEach(draw); };

  for (const signal of held.signals) {
    const chip = document.createElement("button");
    chip.type = "button";
    chip.textContent = signal.name;
    chip.setAttribute("aria-pressed", String(signal.open));
    chip.addEventListener("click", () => {
      signal.open = !signal.open;
      chip.setAttribute("aria-pressed", String(signal.open));
      redraw();
    });
    chips.append(chip);
  }
  document.documentElement.classList.add("scripted");  // has a width from here on
  try { redraw(); } catch (error) { document.documentElement.classList.remove("scripted"); throw error; }
  let width = box.clientWidth;
  new ResizeObserver(() => { if (box.clientWidth !== width) { width = box.clientWidth; redraw(); } }).observe(box);
  dark.addEventListener("change", redraw);
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(d => { d.open = true; }));
})();
