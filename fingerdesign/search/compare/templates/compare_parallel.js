// Parallel coordinates: every design a line through its studied values and metrics.
// FD.parallel.show(container, indices, [a, b], onSelect).
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const WIDTH = 960;
  const HEIGHT = 360;
  const [TOP, BOTTOM, SIDE] = [62, 306, 62];
  const NONE = HEIGHT - 22; // where a line passes an axis of which its design has no value
  const MOST_VALUES = 5;
  const MOST_METRICS = 5;
  const NEAR = 14; // units: farther from every line, a click means none
  let wanted = null; // the axes chosen by hand outlast a redrawing

  const UNITS = { mm: "mm", deg: "degrees", MPa: "MPa", N: "N", g: "g", ml: "ml", s: "s" };

  /** A key's last name in words, and the unit that it ends with. */
  function titled(key) {
    const parts = key.split(".").pop().split("_");
    const unit = parts.length > 1 && Object.hasOwn(UNITS, parts[parts.length - 1])
      ? UNITS[parts.pop()] : "";
    return [parts.join(" "), unit];
  }

  /** Axes of what differs between the designs: values, objectives, other metrics. */
  function axesOf(indices) {
    const designs = indices.map((index) => FD.data.designs[index]);
    const metrics = new Map((FD.data.metrics || []).map((metric) => [metric.name, metric]));
    const goals = new Map((((FD.data.study || {}).objectives) || [])
      .map(({ metric, goal }) => [metric, goal]));
    const keys = new Set(designs.flatMap((design) => Object.keys(design.values || {})));
    const names = new Set([...metrics.keys()].filter((name) =>
      designs.some((design) => FD.draw.isNumber((design.metrics || {})[name]))));
    const made = [];
    for (const key of keys) {
      const raw = designs.map((design) => (design.values || {})[key]);
      const present = raw.filter((value) => value !== undefined && value !== null);
      if (present.every((value) => FD.draw.isNumber(value)))
        made.push(numeric(`value ${key}`, ...titled(key), null, raw));
      else made.push(named(`value ${key}`, titled(key)[0], raw));
    }
    for (const name of names) {
      const { unit, better } = metrics.get(name);
      const goal = goals.get(name);
      const [title, own] = titled(name);
      made.push(numeric(`metric ${name}`, title, unit && unit !== "1" ? unit : own, goal || better,
        designs.map((design) => (design.metrics || {})[name]), goal !== undefined));
    }
    const rank = ({ key, objective, better }) =>
      (key.startsWith("value ") ? 0 : objective ? 1 : better ? 2 : 3);
    return made.filter((axis) => axis.differs).sort((p, q) => rank(p) - rank(q));
  }

  function numeric(key, title, unit, better, raw, objective = false) {
    const present = raw.filter(FD.draw.isNumber);
    const [lo, hi] = [Math.min(...present), Math.max(...present)];
    const turned = better === "min"; // up is better
    const share = (value) => {
      const at = (value - lo) / (hi - lo);
      return turned ? 1 - at : at;
    };
    return { key, title, unit, better, objective, differs: present.length > 1 && hi > lo,
      at: raw.map((value) => (FD.draw.isNumber(value) ? share(value) : null)),
      ticks: FD.draw.ticks(lo, hi, 4).map((value) => [share(value), FD.draw.number(value, 4)]),
      words: raw.map((value) =>
        FD.draw.number(value) + (FD.draw.isNumber(value) && unit ? ` ${unit}` : "")) };
  }

  function named(key, title, raw) {
    const text = raw.map((value) => (value === undefined || value === null ? null
      : typeof value === "string" ? value : JSON.stringify(value)));
    const kinds = [...new Set(text.filter((value) => value !== null))].sort();
    const share = (value) => (kinds.length > 1 ? kinds.indexOf(value) / (kinds.length - 1) : 0.5);
    const cut = (value) => (value.length > 14 ? `${value.slice(0, 13)}…` : value);
    return { key, title, unit: "", better: null, differs: kinds.length > 1,
      at: text.map((value) => (value === null ? null : share(value))),
      ticks: kinds.length <= 8 ? kinds.map((value) => [share(value), cut(value)]) : [],
      words: text.map((value) => (value === null ? "none" : value)) };
  }

  function usual(axes) {
    const values = axes.filter(({ key }) => key.startsWith("value "));
    const metrics = axes.filter(({ key }) => key.startsWith("metric "));
    return new Set([...values.slice(0, MOST_VALUES), ...metrics.slice(0, MOST_METRICS)]
      .map(({ key }) => key));
  }

  /** The box of axes to choose from. */
  function chooser(axes, shown, redraw) {
    const boxes = axes.map((axis) => {
      const box = FD.el("input", { type: "checkbox" });
      box.checked = shown.has(axis.key);
      box.addEventListener("change", () => {
        if (box.checked) shown.add(axis.key);
        else shown.delete(axis.key);
        wanted = shown;
        redraw();
      });
      return FD.el("label", {}, box, ` ${axis.title}${axis.unit ? ` (${axis.unit})` : ""}`);
    });
    return FD.el("details", {}, FD.el("summary", {}, "Choose the axes"),
      FD.el("div", { class: "v-bar" }, ...boxes));
  }

  /** The chart itself. */
  function chart(axes, indices, selected, onSelect, told) {
    const designs = indices.map((index) => FD.data.designs[index]);
    const X = (k) => SIDE + (k * (WIDTH - 2 * SIDE)) / Math.max(1, axes.length - 1);
    const Y = (share) => (share === null ? NONE : BOTTOM - share * (BOTTOM - TOP));
    const points = designs.map((_, row) => axes.map((axis, k) => [X(k), Y(axis.at[row])]));
    const rows = selected.map((index) => indices.indexOf(index));
    const describe = (row) => axes.map((axis) => `${axis.title} ${axis.words[row]}`).join(", ");
    const label = `Parallel coordinates of ${designs.length} designs over ${axes.length} axes: ` +
      `${axes.map(({ title }) => title).join(", ")}. ` +
      rows.map((row, k) =>
        (row < 0 ? "" : `${"AB"[k]}, ${designs[row].name}: ${describe(row)}. `)).join("") +
      "Up and down arrow keys go from design to design, Enter chooses.";
    const none = axes.some((axis) => axis.at.includes(null));
    const height = none ? HEIGHT : BOTTOM + 14;
    const svg = FD.svg("svg", { viewBox: `0 0 ${WIDTH} ${height}`, class: "v-chart v-parallel",
      tabindex: "0", role: "application", "aria-roledescription": "chart", "aria-label": label });
    svg.append(FD.svg("path", { class: `v-many ${designs.length > 100 ? "v-crowd" : ""}`,
      d: points.filter((_, row) => !rows.includes(row)).map(FD.draw.line).join("") }));
    axes.forEach((axis, k) => {
      const x = X(k).toFixed(1);
      svg.append(FD.svg("path", { class: "v-axis", d: `M${x} ${TOP}V${BOTTOM}` }));
      // Two lines of heading, in turn higher and lower, so that long names do not meet.
      const up = k % 2 ? 18 : 40;
      const arrow = axis.better ? " ▲" : "";
      svg.append(FD.svg("text", { class: "v-title", x, y: up, "text-anchor": "middle" },
        `${axis.title}${arrow}`));
      if (axis.unit)
        svg.append(FD.svg("text", { x, y: up + 13, "text-anchor": "middle" }, axis.unit));
      for (const [share, words] of axis.ticks)
        svg.append(FD.svg("path", { class: "v-axis", d: `M${x} ${Y(share).toFixed(1)}h-4` }),
          FD.svg("text", { class: "v-tick", x: (X(k) - 6).toFixed(1), y: (Y(share) + 4).toFixed(1),
            "text-anchor": "end" }, words));
    });
    if (none)
      svg.append(FD.svg("path", { class: "v-grid", d: `M${SIDE} ${NONE}H${WIDTH - SIDE}` }),
        FD.svg("text", { x: 6, y: NONE + 4 }, "none"));
    rows.forEach((row, k) => {
      if (row < 0) return;
      const look = FD.draw.DESIGNS[k];
      svg.append(FD.draw.stroke(look, FD.draw.line(points[row]), "v-bold"));
      for (const [x, y] of points[row]) svg.append(FD.draw.sign(look, x, y, 3.6));
      const [x, y] = points[row][points[row].length - 1];
      const other = rows[1 - k] >= 0 ? points[rows[1 - k]][points[row].length - 1][1] : Infinity;
      const shift = Math.abs(y - other) > 12 ? 0 : y < other || (y === other && k === 0) ? -6 : 6;
      svg.append(FD.svg("text", { class: "v-name", x: x + 10, y: (y + 4 + shift).toFixed(1) },
        look.letter));
    });
    const cursor = FD.svg("path", { class: "v-hover" });
    svg.append(cursor);
    let at = -1;
    const move = (row, aloud) => {
      at = row;
      cursor.setAttribute("d", row < 0 ? "" : FD.draw.line(points[row]));
      told.textContent = row < 0 ? "" : `${designs[row].name}: ${describe(row)}`;
      told.setAttribute("aria-live", aloud ? "polite" : "off");
    };
    const choose = () => at >= 0 && onSelect && onSelect(indices[at]);
    svg.addEventListener("keydown", (event) => {
      const steps = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 };
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key in steps) {
        const start = at < 0 && steps[event.key] < 0 ? 0 : at;
        move((start + steps[event.key] + designs.length) % designs.length, true);
      } else if (event.key === "Enter" || event.key === " ") choose();
      else if (event.key === "Escape") move(-1, false);
      else return;
      event.preventDefault();
    });
    const nearest = (event) => {
      const box = svg.getBoundingClientRect();
      const x = ((event.clientX - box.left) * WIDTH) / box.width;
      const y = ((event.clientY - box.top) * height) / box.height;
      const step = (WIDTH - 2 * SIDE) / Math.max(1, axes.length - 1);
      const k = Math.min(Math.max(0, Math.floor((x - SIDE) / step)), Math.max(0, axes.length - 2));
      let best = [-1, NEAR];
      points.forEach((line, row) => {
        const [p, q] = [line[k], line[Math.min(k + 1, line.length - 1)]];
        const share = q[0] > p[0] ? (x - p[0]) / (q[0] - p[0]) : 0;
        const away = Math.abs(p[1] + share * (q[1] - p[1]) - y);
        if (away < best[1]) best = [row, away];
      });
      return best[0];
    };
    svg.addEventListener("pointermove", (event) => move(nearest(event), false));
    svg.addEventListener("pointerleave", () => move(-1, false));
    svg.addEventListener("click", (event) => {
      move(nearest(event), false);
      choose();
    });
    return svg;
  }

  /** Draw the designs `indices`; what was in the container is gone. */
  function show(container, indices, selected, onSelect) {
    const whole = indices.filter((index) => FD.data.designs[index].status !== "failed");
    const axes = axesOf(whole);
    container.replaceChildren();
    container.classList.add("v-views");
    if (whole.length < 2 || axes.length < 2) {
      container.append(FD.el("p", { class: "quiet" },
        "Too few designs with results, or too little that differs between them, for this chart."));
      return;
    }
    const kept = wanted && axes.filter(({ key }) => wanted.has(key)).length > 1;
    const shown = kept ? wanted : usual(axes);
    const place = FD.draw.scrolled("Parallel coordinates");
    const told = FD.el("p", { class: "v-told", role: "status" });
    const redraw = () => {
      const drawn = axes.filter(({ key }) => shown.has(key));
      told.textContent = "";
      place.replaceChildren(drawn.length < 2
        ? FD.el("p", { class: "quiet" }, "Choose two axes or more.")
        : chart(drawn, whole, selected || [], onSelect, told));
    };
    const marked = (selected || []).map((index, k) => [index, k])
      .filter(([index]) => whole.includes(index));
    const failed = indices.length - whole.length;
    container.append(place, told);
    if (marked.length)
      container.append(FD.draw.legend(marked.map(([index, k]) => [
        [FD.draw.stroke(FD.draw.DESIGNS[k], "M2 7H32", "v-bold"),
          FD.draw.sign(FD.draw.DESIGNS[k], 17, 7)],
        `${"AB"[k]}: ${FD.data.designs[index].name}`])));
    container.append(FD.el("p", { class: "quiet" }, "Each line is a design. Up is better on axes " +
      "with ▲ (where less is better, they are turned over)." +
      (failed ? ` ${failed} without a result ${failed === 1 ? "is" : "are"} not drawn.` : "")),
    chooser(axes, shown, redraw));
    redraw();
  }

  FD.parallel = { show };
})();
