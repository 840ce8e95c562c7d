// Charts of all designs that pass the filter: two measures with their front, and all at once.
(() => {
  "use strict";
  const { designs, columns, looks } = FD.data;
  const words = (number, some) =>
    some.map((each) => `${FD.heading(each)} ${FD.number(FD.value(number, each))}`).join(", ");

  /** A chart whose designs are gone through by keys and mouse: Enter or a click chooses. */
  function walked(id, { order, ring, sentence, draw }) {
    const place = FD.byId(id);
    if (!place) return () => {};
    let at = null; // the active design
    const move = (number) => {
      at = number;
      FD.byId(`${id}-active`).textContent = at === null ? "" : sentence(at);
      if (place.data) ring(place, at);
    };
    place.addEventListener("keydown", (event) => {
      const list = order(event.key === "ArrowUp" || event.key === "ArrowDown");
      const ways = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, Home: -1e9, End: 1e9 };
      const way = ways[event.key];
      if (event.ctrlKey || event.metaKey || event.altKey || !list.length) return;
      if (way) {
        const from = list.indexOf(at);
        const to = from < 0 && way ** 2 === 1 ? 0 : from + way;
        move(list[Math.min(list.length - 1, Math.max(0, to))]);
      } else if (event.key === "Escape") move(null);
      else if (event.key !== "Enter" && event.key !== " ") return;
      else if (at !== null) FD.toggle(at);
      event.preventDefault();
    });
    const under = (event) => event.points[0].customdata ?? null;
    const again = FD.lazily(place.parentElement, () => {
      const first = !place.data;
      const drawn = draw(place);
      if (first && place.data) {
        place.on("plotly_hover", (event) => under(event) !== at && move(under(event)));
        place.on("plotly_click", (event) => FD.toggle(under(event)));
        place.on("plotly_selected", (event) => event?.range && FD.bound(event.range));
      }
      move(drawn.includes(at) ? at : null);
    });
    FD.on("shown", again);
    FD.on("select", again);
    return again;
  }

  /** Two measures; the front of the two as stairs. */
  function pareto() {
    const axes = () => ["x", "y"].map((key) => columns[FD.byId(`axis-${key}`).value]);
    let [points, front] = [[], []];
    const has = (some, number) => some.some((point) => point.number === number);
    // What a design is by itself; of those alike, the front of these two stands out.
    const kind = ({ number }) => (/^(in|out)$/.test(designs[number].kind) && has(front, number)
      ? "front" : designs[number].kind);
    const trace = (some, more) => ({ x: some.map((p) => p.x), y: some.map((p) => p.y),
      customdata: some.map((p) => p.number), ...more });
    function badge({ number, x, y }) { // beside the point: its shape says what it is
      const letter = FD.letter(number);
      return { x, y, text: letter, showarrow: false, xshift: letter === "A" ? 22 : -22, yshift: 16,
        bgcolor: letter === "A" ? "--blue" : "--no", font: { color: "--paper" } };
    }
    function axis(column, key) {
      const all = [...new Set(points.map((point) => point[key]))];
      const better = { min: "   ← better", max: "   better →" }[column.goal] ?? "";
      if (all.length > 1) return { title: { text: column.label + better } };
      return { title: { text: `${column.label}: the same for all shown` }, tickvals: all };
    }

    function draw(place) {
      const [x, y] = axes();
      points = FD.shown.map((number) =>
        ({ number, x: FD.value(number, x), y: FD.value(number, y) }))
        .filter((point) => FD.isNumber(point.x) && FD.isNumber(point.y));
      const [right, up] = [x, y].map(({ goal }) => ({ min: 1, max: -1 })[goal]);
      const good = points.filter(({ number }) => designs[number].feasible && right && up);
      // Whom nobody is nowhere worse and somewhere better than, in these two.
      front = good.filter((p) => !good.some((q) => right * (q.x - p.x) <= 0 &&
        up * (q.y - p.y) <= 0 && (q.x !== p.x || q.y !== p.y))).sort((p, q) => p.x - q.x);
      const line = { color: "--green", dash: "dash", shape: x.goal === "min" ? "hv" : "vh" };
      const traces = [trace(front, { name: "line", mode: "lines", hoverinfo: "skip", line }),
        ...Object.values(looks.points).map((look) =>
          trace(points.filter((point) => kind(point) === look.name), look))];
      const touch = matchMedia("(pointer: coarse)").matches; // there a drag scrolls the page
      FD.chart(place, traces, { height: 430, dragmode: !touch && "select", selections: [],
        xaxis: axis(x, "x"), yaxis: axis(y, "y"),
        annotations: points.filter(({ number }) => FD.letter(number)).map(badge) },
      "Designs by two measures: arrow keys move, Enter chooses");
      const ends = [front[0], front[front.length - 1]].slice(0, front.length)
        .map((p) => `${FD.name(p.number)} (${FD.number(p.x)}, ${FD.number(p.y)})`);
      const said = front.length ? `The front of these two has ${front.length}: ${ends.join(" to ")}.`
        : "No front: one of the two has no better end, or no design is feasible.";
      FD.byId("pareto-words").textContent =
        `${points.length} designs, ${FD.heading(y)} over ${FD.heading(x)}. ${said}`;
      return points.map(({ number }) => number);
    }
    const again = walked("pareto", { draw,
      order: (upright) => [...points].sort((p, q) =>
        (upright ? p.y - q.y || p.x - q.x : p.x - q.x || p.y - q.y)).map(({ number }) => number),
      ring: (place, number) => {
        const point = points.find((each) => each.number === number);
        Plotly.restyle(place, { x: [[point?.x]], y: [[point?.y]] }, [1]);
      },
      sentence: (number) => [`${FD.name(number)}: ${words(number, axes())}`,
        FD.letter(number) && `chosen as ${FD.letter(number)}`, ...designs[number].marks,
        has(front, number) && "on the front of these two"].filter(Boolean).join(", ") });
    for (const select of document.querySelectorAll("#axis-x, #axis-y"))
      select.addEventListener("change", again);
    FD.bound = (range) => axes().forEach(({ path }, k) => FD.filter(path, range["xy"[k]]));
  }

  /** Every design a line through axes of values and metrics; up is better where one end is. */
  function parallel() {
    const NONE = -0.14; // where a line passes an axis of which its design has no value
    const BETWEEN = [0, 0.25, 0.5, 0.75]; // of two axes: where a line can be pointed at
    let axes = [];
    const boxes = [...document.querySelectorAll("#parallel-axes input")];
    const trace = (numbers, more) => {
      const line = (number) => [...axes.flatMap(({ at }, k) => {
        const [own, next] = [at(number), axes[k + 1]?.at(number)];
        return next === undefined ? [[k, own, number]]
          : BETWEEN.map((share) => [k + share, own + share * (next - own), number]);
      }), [null, null, null]];
      const [x, y, customdata] = [0, 1, 2].map((k) => numbers.flatMap(line).map((p) => p[k]));
      return { x, y, customdata, mode: "lines", hoverinfo: "none", ...more };
    };
    const sentence = (number) => `${FD.name(number)}: ${words(number, axes)}`;

    function axisOf(column) {
      const of = (number) => (column.kinds
        ? column.kinds.indexOf(FD.number(FD.value(number, column))) : FD.value(number, column));
      const [low, high] = FD.range(FD.shown.map(of));
      const range = column.goal === "min" ? [high, low] : [low, high];
      const share = (value) => (value - range[0]) / (range[1] - range[0]);
      const at = (number) => (FD.value(number, column) === null ? NONE : share(of(number)));
      const different = new Set(FD.shown.map(of)).size > 1;
      const ticks = column.kinds && { tickmode: "array", ticktext: column.ticks,
        tickvals: column.kinds.map((_, k) => k) };
      return { ...column, at, range, different, ticks };
    }

    function draw(place) {
      axes = boxes.filter((box) => box.checked).map((box) => axisOf(columns[box.value]))
        .filter(({ different }) => different);
      place.hidden = FD.shown.length < 2 || axes.length < 2;
      FD.byId("parallel-none").hidden = !place.hidden;
      if (place.hidden) return [];
      const chosen = FD.selected.filter((number) => FD.shown.includes(number));
      const rest = FD.shown.filter((number) => !chosen.includes(number));
      const lacking = FD.shown.some((number) => axes.some(({ at }) => at(number) === NONE));
      const [bottom, top] = [lacking ? NONE - 0.04 : -0.04, 1.04];
      const traces = [
        trace(rest, { opacity: rest.length > 100 ? 0.3 : 0.45, line: { color: "--muted", width: 1 } }),
        trace([], { hoverinfo: "skip", line: { color: "--ink", width: 2.4 } }),
        ...chosen.map((number) => trace([number], { line: FD.letter(number) === "A"
          ? { color: "--blue", width: 2.6 } : { color: "--vermilion", width: 2.6, dash: "dash" } }))];
      const layout = { height: 400, margin: { l: 70, r: 60, t: 66, b: 24 },
        xaxis: { range: [-0.02, axes.length - 0.9], visible: false },
        yaxis: { range: [bottom, top], visible: false } };
      layout.annotations = axes.map(({ short, goal }, k) => ({ x: k, y: 1, yref: "paper",
        yanchor: "bottom", yshift: (k % 2) * 28, showarrow: false, text: short + (goal ? " ▲" : "") }));
      if (lacking) layout.annotations.push({ x: -0.02, y: NONE, xanchor: "right", showarrow: false,
        text: "none" });
      axes.forEach(({ range: [low, high], ticks }, k) => {
        layout[`yaxis${k + 2}`] = { ...looks.upright, ...ticks,
          range: [bottom, top].map((share) => low + share * (high - low)),
          position: (k + 0.02) / (axes.length - 0.88) };
        traces.push({ x: [null], y: [null], yaxis: `y${k + 2}`, hoverinfo: "skip" });
      });
      FD.chart(place, traces, layout, `Parallel coordinates of ${FD.shown.length} designs over ` +
        `${axes.map(FD.heading).join(", ")}. ${chosen.map(sentence).join(". ")}. ` +
        "Arrow keys go from design to design, Enter chooses.");
      return FD.shown;
    }
    const again = walked("parallel-chart", { draw, sentence, order: () => FD.shown,
      ring: (place, number) => {
        const { x, y } = trace(number === null ? [] : [number]);
        Plotly.restyle(place, { x: [x], y: [y] }, [1]);
      } });
    for (const box of boxes) box.addEventListener("change", again);
  }
  pareto();
  parallel();
})();
