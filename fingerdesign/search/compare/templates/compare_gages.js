// What the gages read: every gage along the path, one of them brought out; and both designs' gages
// over x at the chosen increment.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const known = (traces) => (traces.gages || []).length > 0 && traces.gages[0].length > 0;
  const zero = (axes) => FD.svg("path", { class: "v-zero",
    d: FD.draw.line([[axes.left, axes.Y(0)], [axes.left + axes.inner.width, axes.Y(0)]]) });
  const column = (traces, k) => traces.gages.map((row) => row[k]);

  /** Gage and increment of the largest reading. */
  function largest(traces) {
    let best = { gage: 0, row: 0, value: 0 };
    traces.gages.forEach((readings, row) => readings.forEach((value, gage) => {
      if (FD.draw.isNumber(value) && Math.abs(value) > Math.abs(best.value))
        best = { gage, row, value };
    }));
    return best;
  }

  const placed = (traces, k) => FD.draw.isNumber(traces.gage_x_mm[k])
    ? `gage ${k + 1}, x = ${FD.draw.number(traces.gage_x_mm[k])} mm` : `gage ${k + 1}`;

  /** All gages along the path; `chosen` brought out. */
  function paths(item, look, y) {
    const { traces } = item;
    const count = traces.gages.length;
    const gages = traces.gages[0].length;
    const most = largest(traces);
    const axes = FD.draw.plot({ x: [1, Math.max(2, count)], y, right: 34, xLabel: "increment",
      yLabel: "reading (microstrain)", label: `Readings of ${gages} gages of ${item.letter}, ` +
        `${item.name}, over ${count} increments. The largest is ${FD.draw.number(most.value)} ` +
        `microstrain, of ${placed(traces, most.gage)}, at increment ${most.row + 1}.` });
    const points = (k) => column(traces, k).map((value, row) =>
      [axes.X(row + 1), FD.draw.isNumber(value) ? axes.Y(value) : null]);
    axes.layer.append(zero(axes),
      FD.svg("path", { class: "v-faint",
        d: Array.from({ length: gages }, (_, k) => FD.draw.line(points(k))).join("") }));
    const every = Math.ceil(count / 8); // beads on a string hide the dashes
    const bold = FD.draw.stroke(look, "", "v-bold");
    const marks = FD.svg("path", { class: `v-sign ${look.name}` });
    const cursor = FD.svg("path", { class: "v-cursor" });
    const name = FD.svg("text", { x: axes.width - axes.right + 5, class: "v-name" });
    axes.layer.append(bold, marks, cursor);
    axes.over.append(name);
    const choose = (k) => {
      const shown = points(k);
      bold.setAttribute("d", FD.draw.line(shown));
      marks.setAttribute("d", shown.filter(([, y_]) => y_ !== null)
        .filter((_, row) => row % every === 0)
        .map(([p, q]) => FD.draw.marker(look.marker, p, q, 3.2)).join(""));
      const end = shown[shown.length - 1][1];
      name.setAttribute("y", ((end === null ? axes.top : end) + 4).toFixed(1));
      name.textContent = String(k + 1);
    };
    return { svg: axes.svg, choose, gages, best: most.gage, at(k) {
      const x = axes.X(Math.min(k, count - 1) + 1);
      cursor.setAttribute("d", FD.draw.line([[x, axes.top], [x, axes.top + axes.inner.height]]));
    } };
  }

  /** Both designs' readings over x at one increment. */
  function profile(items, looks, y) {
    const x = FD.draw.bounds(items.map(({ traces }) => traces.gage_x_mm), 0.04);
    const axes = FD.draw.plot({ width: 900, height: 240, x, y, xLabel: "x of the gage (mm)",
      yLabel: "reading (microstrain)", label: "" });
    axes.layer.append(zero(axes));
    const drawn = items.map(({ traces }, k) => {
      const order = traces.gage_x_mm.map((_, gage) => gage)
        .sort((p, q) => traces.gage_x_mm[p] - traces.gage_x_mm[q]);
      const line = FD.draw.stroke(looks[k], "");
      const marks = FD.svg("path", { class: `v-sign ${looks[k].name}` });
      axes.layer.append(line, marks);
      return { traces, order, line, marks, look: looks[k], letter: items[k].letter };
    });
    return { svg: axes.svg, at(k) {
      const words = drawn.map(({ traces, order, line, marks, look, letter }) => {
        const row = Math.min(k, traces.gages.length - 1);
        const points = order.map((gage) => [axes.X(traces.gage_x_mm[gage]),
          FD.draw.isNumber(traces.gages[row][gage]) ? axes.Y(traces.gages[row][gage]) : null]);
        line.setAttribute("d", FD.draw.line(points));
        marks.setAttribute("d", points.filter(([p, q]) => Number.isFinite(p) && q !== null)
          .map(([p, q]) => FD.draw.marker(look.marker, p, q, 3)).join(""));
        const most = largest({ gages: [traces.gages[row]] });
        return `${letter} at increment ${row + 1}: largest ${FD.draw.number(most.value)} ` +
          `microstrain, ${placed(traces, most.gage)}`;
      });
      axes.svg.setAttribute("aria-label", `Readings over x. ${words.join("; ")}.`);
    } };
  }

  /** Charts of items {letter, name, traces}; returns what follows the increment. */
  function show(items, container, columns) {
    const seen = items.filter(({ traces }) => known(traces));
    const y = FD.draw.bounds(seen.flatMap(({ traces }) => traces.gages), 0.06, [0]);
    const followers = [];
    items.forEach((item, k) => {
      if (!known(item.traces)) {
        columns[k].append(FD.el("p", { class: "quiet" }, "No gages are recorded."));
        return;
      }
      const made = paths(item, FD.draw.DESIGNS[k], y);
      const choice = FD.el("select", { "aria-label": `Gage of ${item.letter} brought out` },
        ...Array.from({ length: made.gages }, (_, gage) =>
          FD.el("option", { value: String(gage) }, placed(item.traces, gage))));
      choice.value = String(made.best);
      choice.addEventListener("change", () => made.choose(Number(choice.value)));
      columns[k].append(made.svg, FD.el("label", { class: "v-bar" }, "brought out: ", choice));
      made.choose(made.best);
      followers.push(made.at);
    });
    const flat = seen.filter(({ traces }) =>
      (traces.gage_x_mm || []).length === traces.gages[0].length);
    if (flat.length) {
      const looks = flat.map((item) => FD.draw.DESIGNS[items.indexOf(item)]);
      const made = profile(flat, looks, y);
      container.append(FD.el("p", {}, "All gages at the chosen increment, over x:"),
        FD.draw.scrolled("All gages over x", made.svg),
        FD.draw.legend(flat.map((item, k) => [[FD.draw.stroke(looks[k], "M2 7H32"),
          FD.draw.sign(looks[k], 17, 7)], `${item.letter}: ${item.name}`])));
      followers.push(made.at);
    }
    return followers;
  }

  FD.gages = { show };
})();
