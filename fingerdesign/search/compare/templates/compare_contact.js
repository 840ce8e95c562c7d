// Where the contact surface is open, sticks and slips: over x and increments in plane strain, over
// x and z at the chosen increment in 3-D. Slip is hatched (or hollow) as well as coloured.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const NAMES = { ".": "open", "#": "stick", "/": "slip" };
  const MARKS = { "#": ["v-stick-mark", "circle"], "/": ["v-slip-mark", "diamond"],
    ".": ["v-open-mark", "circle"] };

  /** One character a point of a row that is coded run by run ("3.12#"). */
  function status(text, points) {
    let found = "";
    for (const [, count, character] of String(text).matchAll(/(\d+)([^\d])/g))
      found += character.repeat(Math.min(Number(count), 1e6));
    return points === undefined ? found : found.padEnd(points, ".").slice(0, points);
  }

  const count = (list) => (list || []).length;
  const is3d = (traces) => count(traces.contact_z_mm) > 0;
  const known = (traces) => count(traces.status) > 0 && count(traces.contact_x_mm) > 0;

  /** What of x is shown: all that ever touched in any of the designs, and a little more. */
  function window_(all) {
    const touched = [];
    const every = [];
    for (const traces of all.filter(known)) {
      const rows = traces.status.map((text) => status(text, traces.contact_x_mm.length));
      traces.contact_x_mm.forEach((x, k) => {
        every.push(x);
        if (rows.some((row) => row[k] !== ".")) touched.push(x);
      });
    }
    if (!touched.length) return FD.draw.bounds([every], 0);
    const [lo, hi] = FD.draw.bounds([touched], 0);
    const more = 0.15 * (hi - lo) + 0.1;
    return [Math.max(lo - more, Math.min(...every)), Math.min(hi + more, Math.max(...every))];
  }

  function words(traces) {
    const rows = traces.status.map((text) => status(text));
    const begins = rows.findIndex((row) => /[#/]/.test(row));
    if (begins < 0) return "The object does not touch the finger in any increment.";
    const counts = rows.map((row) => [row.split("#").length - 1, row.split("/").length - 1]);
    const most = counts.reduce((best, each, k) => (each[0] > counts[best][0] ? k : best), 0);
    const [stick, slip] = counts[counts.length - 1];
    const last = stick + slip === 0 ? "nothing touches"
      : `${stick} points stick and ${slip} slip`;
    return `Contact begins at increment ${begins + 1}; most sticks at increment ${most + 1} ` +
      `(${counts[most][0]} of ${rows[most].length} points); at the last, increment ` +
      `${rows.length}, ${last}.`;
  }

  /** Rows over x, one an increment; `at(k)` frames the chosen one. */
  function rows(traces, reach, name) {
    const order = traces.contact_x_mm.map((_, k) => k)
      .sort((p, q) => traces.contact_x_mm[p] - traces.contact_x_mm[q]);
    const x = order.map((k) => traces.contact_x_mm[k]);
    const edge = (k) =>
      (k <= 0 ? x[0] : k >= x.length ? x[x.length - 1] : 0.5 * (x[k - 1] + x[k]));
    const last = traces.status.length;
    const height = 54 + Math.min(340, Math.max(60, 13 * last));
    const step = Math.max(1, Math.ceil(last / 16));
    const yTicks = Array.from({ length: Math.ceil(last / step) }, (_, k) => 1 + k * step);
    const axes = FD.draw.plot({ height, x: reach, y: [0.5, last + 0.5], down: true, yTicks,
      xLabel: "x (mm)", yLabel: "increment", label: `Contact of ${name}. ${words(traces)}` });
    const hatch = FD.draw.id();
    axes.svg.prepend(FD.svg("pattern", { id: hatch, width: 5, height: 5,
      patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      FD.svg("rect", { width: 5, height: 5, class: "v-slip" }),
      FD.svg("path", { d: "M0 0V5", class: "v-hatch" })));
    const high = Math.max(1, (axes.inner.height / last) * 0.78);
    axes.layer.append(FD.svg("rect", { x: axes.left, y: axes.top, width: axes.inner.width,
      height: axes.inner.height, class: "v-open" }));
    traces.status.forEach((text, row) => {
      const given = status(text, x.length);
      const characters = order.map((k) => given[k]).join("");
      let start = 0;
      for (const [run] of characters.matchAll(/\.+|#+|\/+/g)) {
        const end = start + run.length;
        const from = axes.X(edge(start));
        if (run[0] !== ".")
          axes.layer.append(FD.svg("rect", { x: from.toFixed(1),
            y: (axes.Y(row + 1) - 0.5 * high).toFixed(1),
            width: Math.max(0.5, axes.X(edge(end)) - from).toFixed(1), height: high.toFixed(1),
            ...(run[0] === "#" ? { class: "v-stick" } : { fill: `url(#${hatch})` }) }));
        start = end;
      }
    });
    const frame = FD.svg("rect", { class: "v-cursor", x: axes.left, width: axes.inner.width,
      height: (high + 3).toFixed(1) });
    axes.over.append(frame);
    return { svg: axes.svg, at(k) {
      frame.setAttribute("y", (axes.Y(Math.min(k, last - 1) + 1) - 0.5 * high - 1.5).toFixed(1));
    } };
  }

  /** The points over x and z at the chosen increment. */
  function top(traces, reach, name) {
    // A model of the half z >= 0 alone is its own mirror image.
    const half = traces.contact_z_mm.every((place) => place >= -1e-9);
    const twice = (list, sign) => (half ? [...list, ...list.map((value) => sign * value)] : list);
    const [x, z] = [twice(traces.contact_x_mm, 1), twice(traces.contact_z_mm, -1)];
    const deep = FD.draw.bounds([z], 0.06);
    const width = 440;
    const inner = width - 66;
    const equal = (inner * (deep[1] - deep[0])) / (reach[1] - reach[0]); // of both scales
    const height = Math.min(420, Math.max(120, equal)) + 52;
    const axes = FD.draw.plot({ width, height, x: reach, y: deep, xLabel: "x (mm)",
      yLabel: "z (mm)", label: "" });
    const size = Math.min(4, Math.max(1.6, 0.35 * Math.sqrt((inner * (height - 52)) / x.length)));
    const marks = Object.entries(MARKS).map(([character, [look, shape]]) => {
      const path = FD.svg("path", { class: look });
      axes.layer.append(path);
      return { character, path, shape };
    });
    return { svg: axes.svg, at(k) {
      const row = Math.min(k, traces.status.length - 1);
      const given = status(traces.status[row], traces.contact_x_mm.length).repeat(half ? 2 : 1);
      const found = { "#": 0, "/": 0, ".": 0 };
      const paths = { "#": "", "/": "", ".": "" };
      x.forEach((_, point) => {
        const character = given[point] in found ? given[point] : ".";
        found[character] += 1;
        paths[character] += FD.draw.marker(MARKS[character][1], axes.X(x[point]),
          axes.Y(z[point]), character === "." ? 0.35 * size : size);
      });
      marks.forEach(({ character, path }) => path.setAttribute("d", paths[character]));
      axes.svg.setAttribute("aria-label", `Contact of ${name} at increment ${row + 1}: ` +
        Object.entries(NAMES).map(([each, word]) => `${found[each]} points ${word}`).join(", ") +
        `. ${words(traces)}`);
    } };
  }

  function legend(flat) {
    const hatch = FD.draw.id();
    const area = (look) => [FD.svg("rect", { x: 4, y: 1, width: 26, height: 12, ...look })];
    if (!flat)
      return FD.draw.legend(Object.entries(MARKS).map(([character, [look, shape]]) => [
        [FD.svg("path", { class: look,
          d: FD.draw.marker(shape, 17, 7, character === "." ? 1.5 : 4) })], NAMES[character]]));
    return FD.draw.legend([[area({ class: "v-stick" }), "stick"],
      [[FD.svg("pattern", { id: hatch, width: 5, height: 5, patternUnits: "userSpaceOnUse",
        patternTransform: "rotate(45)" }, FD.svg("rect", { width: 5, height: 5, class: "v-slip" }),
        FD.svg("path", { d: "M0 0V5", class: "v-hatch" })), ...area({ fill: `url(#${hatch})` })],
      "slip"], [area({ class: "v-open" }), "open"]]);
  }

  /** Maps of items {letter, name, traces} into `columns`; returns what follows the increment. */
  function show(items, container, columns) {
    const reach = window_(items.map((item) => item.traces));
    const followers = [];
    items.forEach(({ letter, name, traces }, column) => {
      if (!known(traces)) {
        columns[column].append(FD.el("p", { class: "quiet" }, "No contact is recorded."));
        return;
      }
      const made = (is3d(traces) ? top : rows)(traces, reach, `${letter}, ${name}`);
      columns[column].append(made.svg);
      followers.push((k) => made.at(k));
    });
    const seen = items.filter(({ traces }) => known(traces));
    for (const flat of [true, false])
      if (seen.some(({ traces }) => is3d(traces) !== flat)) container.append(legend(flat));
    return followers;
  }

  FD.status = status;
  FD.contact = { show };
})();
