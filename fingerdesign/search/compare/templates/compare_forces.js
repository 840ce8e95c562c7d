// Force paths against the friction limits: tangential over normal force, of the scene's path and of
// every grip; above a grip's own line the finger slips as a whole.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const count = (list) => (list || []).length;

  const frictions = (items) => {
    const all = items.flatMap(({ grips }) => (grips || []).map((g) => g.friction_coefficient));
    return [...new Set(all)].filter((value) => value > 0).sort((p, q) => p - q);
  };

  function words(item) {
    const { grips, traces } = item;
    const told = [];
    if (count(traces.normal_force_N)) {
      const end = traces.normal_force_N.length - 1;
      told.push(`The scene's path ends at ${FD.draw.number(traces.normal_force_N[end])} N normal ` +
        `and ${FD.draw.number(traces.tangential_force_N[end])} N tangential`);
    }
    for (const grip of grips || [])
      told.push(`friction ${FD.draw.number(grip.friction_coefficient)}, ` +
        `${FD.draw.number(grip.object_mass_g)} g, ${grip.controller}: ` +
        `${grip.lifted ? "lifted" : "not lifted"}` +
        `${grip.gross_slip ? ", slipped as a whole" : ""}, peak ` +
        `${FD.draw.number(grip.peak_normal_force_N)} N`);
    return told.length ? `${told.join(". ")}.` : "No forces are recorded.";
  }

  function chart(item, x, y, looks) {
    const axes = FD.draw.plot({ height: 300, right: 46, x, y, xLabel: "normal force (N)",
      yLabel: "tangential force (N)",
      label: `Force paths of ${item.letter}, ${item.name}. ${words(item)}` });
    let above = looks.size;
    looks.forEach((look, friction) => {
      // The limit, to where it leaves the chart.
      const end = Math.min(x[1], y[1] / friction);
      const [p, q] = [axes.X(end), axes.Y(friction * end)];
      axes.layer.append(FD.svg("path", { class: `v-limit ${look.name}`,
        "stroke-dasharray": look.dash, d: FD.draw.line([[axes.X(0), axes.Y(0)], [p, q]]) }));
      // Its name beside it: each steeper one's higher, so that they do not meet.
      above -= 1;
      const height = Math.max(q, axes.top + 4 + 15 * above);
      const beside = axes.X(0) + ((p - axes.X(0)) * (axes.Y(0) - height)) / (axes.Y(0) - q);
      axes.over.append(FD.svg("text", { class: "v-name", x: (beside + 5).toFixed(1),
        y: (height + 4).toFixed(1) }, `μ ${FD.draw.number(friction)}`));
    });
    const at = (normal, tangential) => normal.map((force, k) =>
      [FD.draw.isNumber(force) ? axes.X(force) : null,
        FD.draw.isNumber(tangential[k]) ? axes.Y(tangential[k]) : null]);
    for (const grip of item.grips || []) {
      const look = looks.get(grip.friction_coefficient) || FD.draw.LOOKS[4];
      const points = at(grip.normal_force_N || [], grip.tangential_force_N || []);
      const whole = points.filter(([p, q]) => p !== null && q !== null);
      if (!whole.length) continue;
      const [p, q] = whole[whole.length - 1];
      axes.layer.append(FD.draw.stroke(look, FD.draw.line(points)));
      axes.over.append(grip.lifted && !grip.gross_slip ? FD.draw.sign(look, p, q, 4)
        : FD.svg("path", { class: `v-cross ${look.name}`, d: FD.draw.marker("cross", p, q, 4.5) }));
    }
    const { normal_force_N: normal = [], tangential_force_N: tangential = [] } = item.traces;
    axes.layer.append(FD.svg("path", { class: "v-scene",
      d: FD.draw.line(at(normal, tangential)) }));
    const now = FD.svg("path", { class: "v-now" });
    axes.over.append(now);
    return { svg: axes.svg, at(k) {
      const row = Math.min(k, normal.length - 1);
      const there = FD.draw.isNumber(normal[row]) && FD.draw.isNumber(tangential[row]);
      now.setAttribute("d", there
        ? FD.draw.marker("circle", axes.X(normal[row]), axes.Y(tangential[row]), 5) : "");
    } };
  }

  /** Charts of items {letter, name, traces, grips}; returns what follows the increment. */
  function show(items, container, columns) {
    const looks = new Map(frictions(items).map((friction, k) =>
      [friction, FD.draw.LOOKS[k % FD.draw.LOOKS.length]]));
    const all = (key) => items.flatMap(({ traces, grips }) =>
      [traces[key] || [], ...(grips || []).map((grip) => grip[key] || [])]);
    const x = FD.draw.bounds(all("normal_force_N"), 0.05, [0]);
    const y = FD.draw.bounds(all("tangential_force_N"), 0.08, [0]);
    const followers = [];
    items.forEach((item, k) => {
      if (!count(item.traces.normal_force_N) && !count(item.grips)) {
        columns[k].append(FD.el("p", { class: "quiet" }, "No forces are recorded."));
        return;
      }
      const made = chart(item, x, y, looks);
      columns[k].append(made.svg);
      followers.push(made.at);
    });
    const entries = [];
    if (items.some(({ traces }) => count(traces.normal_force_N)))
      entries.push([[FD.svg("path", { class: "v-scene", d: "M2 7H32" }),
        FD.svg("path", { class: "v-now", d: FD.draw.marker("circle", 17, 7, 4.5) })],
      "the scene's path, and the chosen increment"]);
    looks.forEach((look, friction) => entries.push([[FD.draw.stroke(look, "M2 7H32"),
      FD.draw.sign(look, 17, 7)], `grips at friction ${FD.draw.number(friction)}, lifted`]));
    if (items.some(({ grips }) => (grips || []).some((grip) => !grip.lifted || grip.gross_slip)))
      entries.push([[FD.svg("path", { class: "v-cross v-ink",
        d: FD.draw.marker("cross", 17, 7, 4.5) })],
      "a grip that was not lifted or slipped as a whole"]);
    if (looks.size)
      entries.push([[FD.svg("path", { class: "v-limit v-ink", d: "M4 13L30 1" })],
        "thin straight lines: the friction limit, tangential = μ × normal"]);
    container.append(FD.draw.legend(entries));
    return followers;
  }

  FD.forces = { show };
})();
