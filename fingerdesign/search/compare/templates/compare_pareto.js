// The chart of two measures: every shown design a point, the front of the two a line.
(() => {
  "use strict";
  const FD = window.FD;
  const WIDE = 760;
  const HIGH = 430;
  const BOX = { left: 74, right: WIDE - 18, top: 16, bottom: HIGH - 56 };
  const REACH = 16; // of the mouse, in the drawing's units
  let axes = []; // the columns that can be an axis
  let x = null;
  let y = null;
  let points = []; // {number, x, y, px, py, front}
  let active = null; // the number that the keys stand at
  let picture = null;
  let told = null;
  let words = null;
  let field = null;

  function ticks(low, high) {
    const span = high - low;
    const power = 10 ** Math.floor(Math.log10(span / 5));
    const step = [1, 2, 5, 10].map((each) => each * power).find((each) => span / each <= 6);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k += 1)
      found.push(Number((k * step).toPrecision(12)));
    return found;
  }

  function scale(values, from, to) {
    let low = Math.min(...values);
    let high = Math.max(...values);
    const alike = high === low ? low : null; // one mark in the middle, no made-up range
    const pad = high > low ? 0.05 * (high - low) : 0.5 * Math.max(Math.abs(low), 1e-6);
    low -= pad;
    high += pad;
    const at = (value) => from + ((value - low) / (high - low)) * (to - from);
    return { at, alike, ticks: alike === null ? ticks(low, high) : [alike] };
  }

  /** Of those feasible: whom nobody is nowhere worse and somewhere better than, in these two. */
  function frontOf(found) {
    if (!x.goal || !y.goal) return [];
    const sign = (column) => (column.goal === "min" ? 1 : -1);
    const kept = [];
    const ordered = found
      .filter((point) => FD.data.designs[point.number].feasible)
      .sort((p, q) => sign(x) * (p.x - q.x) || sign(y) * (p.y - q.y));
    let best = Infinity;
    let at = null; // equal in both: neither is worse
    for (const point of ordered) {
      const value = sign(y) * point.y;
      if (value < best || (at && point.x === at.x && point.y === at.y)) {
        kept.push(point);
        best = value;
        at = point;
      }
    }
    return kept;
  }

  /** What a search was to beat. */
  function isReference(number) {
    return FD.data.study.references.includes(number);
  }

  function shape(point) {
    const { px, py, number } = point;
    const star = number === FD.data.study.recommended;
    const feasible = FD.data.designs[number].feasible;
    if (isReference(number)) {
      const d = `M${px - 6} ${py - 6}h12v12h-12z`;
      return FD.svg("path", { class: "point reference", d });
    }
    const kind = star ? "star" : point.front ? "front" : feasible ? "in" : "out";
    if (kind === "in") return FD.svg("circle", { class: "point", cx: px, cy: py, r: 4.5 });
    if (kind === "out") {
      const d = `M${px - 3.5} ${py - 3.5}l7 7m0 -7l-7 7`;
      return FD.svg("path", { class: "point out", d });
    }
    if (kind === "front") {
      const d = `M${px} ${py - 7}l7 7l-7 7l-7 -7z`;
      return FD.svg("path", { class: "point front", d });
    }
    const corners = [...Array(10).keys()].map((k) => {
      const angle = (Math.PI * (k - 2.5)) / 5;
      const size = k % 2 ? 4.2 : 10.5;
      return `${px + size * Math.cos(angle)} ${py + size * Math.sin(angle)}`;
    });
    return FD.svg("path", { class: "point star", d: `M${corners.join("L")}z` });
  }

  function pick(point, letter) {
    const px = point.px + (letter === "A" ? 15 : -15); // beside the point: its shape says what it is
    const py = point.py - 13;
    const mark =
      letter === "A"
        ? FD.svg("circle", { class: "pick-a", cx: px, cy: py, r: 9 })
        : FD.svg("rect", { class: "pick-b", x: px - 8, y: py - 8, width: 16, height: 16 });
    return [mark, FD.svg("text", { class: "letter", x: px, y: py + 4 }, letter)];
  }

  function sentence(point) {
    const { designs, study } = FD.data;
    const design = designs[point.number];
    const letter = FD.letter(point.number);
    const marks = [
      letter ? `chosen as ${letter}` : "",
      isReference(point.number) ? "the reference" : "",
      point.number === study.recommended ? "recommended" : "",
      point.front ? "on the front of these two" : design.feasible ? "" : "not feasible",
    ].filter(Boolean);
    const values = [x, y].map((c) => `${FD.heading(c)} ${FD.number(FD.value(point.number, c))}`);
    return `${design.name}: ${[...values, ...marks].join(", ")}`;
  }

  function frame(across, up) {
    const { left, right, top, bottom } = BOX;
    const parts = [];
    for (const value of across.ticks) {
      const at = across.at(value);
      parts.push(FD.svg("line", { class: "rule", x1: at, x2: at, y1: top, y2: bottom }));
      const place = { class: "tick", x: at, y: bottom + 16, "text-anchor": "middle" };
      parts.push(FD.svg("text", place, FD.number(value)));
    }
    for (const value of up.ticks) {
      const at = up.at(value);
      parts.push(FD.svg("line", { class: "rule", x1: left, x2: right, y1: at, y2: at }));
      const place = { class: "tick", x: left - 6, y: at + 4, "text-anchor": "end" };
      parts.push(FD.svg("text", place, FD.number(value)));
    }
    const way = { min: ["← better", "better ↓"], max: ["better →", "better ↑"] };
    const said = (column, place, alike) => {
      const better = column.goal ? `   ${way[column.goal][place]}` : "";
      return FD.heading(column) + (alike === null ? better : ": the same for all shown");
    };
    const middle = { x: (left + right) / 2, y: HIGH - 16, "text-anchor": "middle" };
    parts.push(FD.svg("text", middle, said(x, 0, across.alike)));
    const turned = `translate(16 ${(top + bottom) / 2}) rotate(-90)`;
    // Turned by a quarter, the arrow that points at smaller values points to the left.
    const label = said(y, 0, up.alike);
    parts.push(FD.svg("text", { transform: turned, "text-anchor": "middle" }, label));
    return parts;
  }

  /** The border of what is dominated: between two of the front its corner is the worse of both. */
  function stairs(line) {
    const across = x.goal === "min" ? Math.max : Math.min;
    const up = y.goal === "min" ? Math.min : Math.max; // py grows downward
    const parts = line.map(({ px, py }, k) => {
      if (k === 0) return `M${px} ${py}`;
      const last = line[k - 1];
      return `L${across(px, last.px)} ${up(py, last.py)}L${px} ${py}`;
    });
    return parts.join("");
  }

  function draw() {
    const found = FD.shown
      .map((number) => ({ number, x: FD.value(number, x), y: FD.value(number, y) }))
      .filter((point) => FD.isNumber(point.x) && FD.isNumber(point.y));
    if (!found.length) {
      points = [];
      field.removeAttribute("aria-activedescendant");
      picture.replaceChildren(
        FD.svg("text", { x: WIDE / 2, y: HIGH / 2, "text-anchor": "middle" }, "No design to show"),
      );
      words.textContent = "No design that is shown has both measures.";
      return;
    }
    const across = scale(found.map((point) => point.x), BOX.left, BOX.right);
    const up = scale(found.map((point) => point.y), BOX.bottom, BOX.top);
    const front = frontOf(found);
    const leads = new Set(front.map((point) => point.number));
    points = found.map((point) => ({
      ...point,
      px: Number(across.at(point.x).toFixed(1)),
      py: Number(up.at(point.y).toFixed(1)),
      front: leads.has(point.number),
    }));
    points.sort((p, q) => p.x - q.x || p.y - q.y);
    const line = points.filter((point) => point.front);
    const parts = frame(across, up);
    if (line.length > 1) {
      parts.push(FD.svg("path", { class: "line", d: stairs(line) }));
    }
    const plain = points.filter((p) => !p.front && p.number !== FD.data.study.recommended);
    const over = points.filter((p) => !plain.includes(p));
    for (const point of [...plain, ...over]) {
      const letter = FD.letter(point.number);
      const group = FD.svg(
        "g",
        {
          role: "option",
          id: `point-${point.number}`,
          "aria-selected": String(letter !== null),
          "aria-label": sentence(point),
        },
        shape(point),
      );
      parts.push(group);
    }
    for (const letter of ["B", "A"]) {
      const point = points.find((each) => FD.letter(each.number) === letter);
      if (point) parts.push(...pick(point, letter));
    }
    picture.replaceChildren(...parts);
    if (!points.some((point) => point.number === active)) active = null;
    ring();
    summarise(line);
  }

  function summarise(line) {
    const all = `${points.length} designs, ${FD.heading(y)} over ${FD.heading(x)}.`;
    const ends = line.length ? [...new Set([line[0], line[line.length - 1]])] : [];
    const said = ends.map((p) => `${FD.name(p.number)} (${FD.number(p.x)}, ${FD.number(p.y)})`);
    words.textContent = line.length
      ? `${all} The front of these two has ${line.length}: from ${said.join(" to ")}.`
      : `${all} No front: one of the two has no better end, or no design is feasible.`;
  }

  /** Round the point that the keys or the mouse stand at; say what it is. */
  function ring() {
    picture.querySelector(".ring")?.remove();
    const point = points.find((each) => each.number === active);
    if (!point) {
      field.removeAttribute("aria-activedescendant");
      told.textContent = "";
      return;
    }
    picture.append(FD.svg("circle", { class: "ring", cx: point.px, cy: point.py, r: 12 }));
    field.setAttribute("aria-activedescendant", `point-${point.number}`);
    told.textContent = sentence(point);
  }

  function nearest(event) {
    const box = picture.getBoundingClientRect();
    const mx = ((event.clientX - box.left) / box.width) * WIDE;
    const my = ((event.clientY - box.top) / box.height) * HIGH;
    let best = null;
    for (const point of points) {
      const away = Math.hypot(point.px - mx, point.py - my);
      if (away < REACH && (!best || away < best.away)) best = { point, away };
    }
    return best?.point ?? null;
  }

  function key(event) {
    const ways = { ArrowRight: 1, ArrowLeft: -1, ArrowUp: 1, ArrowDown: -1 };
    const upright = event.key === "ArrowUp" || event.key === "ArrowDown";
    const line = upright ? [...points].sort((p, q) => p.y - q.y || p.x - q.x) : points;
    if (!line.length) return;
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      if (active !== null) FD.toggle(active);
      return;
    }
    let to = null;
    if (event.key === "Home") to = 0;
    else if (event.key === "End") to = line.length - 1;
    else if (event.key in ways) {
      const at = line.findIndex((point) => point.number === active);
      to = at < 0 ? 0 : Math.min(line.length - 1, Math.max(0, at + ways[event.key]));
    }
    if (to === null) return;
    event.preventDefault();
    active = line[to].number;
    ring();
  }

  function chooser(title, id, now, set) {
    const options = axes.map((column, place) =>
      FD.el("option", { value: place, selected: column === now }, FD.heading(column)),
    );
    const change = (event) => {
      set(axes[Number(event.target.value)]);
      draw();
    };
    return FD.el("label", {}, title, FD.el("select", { id, onchange: change }, ...options));
  }

  function start() {
    axes = FD.data.columns.filter((column) => column.numeric);
    const place = document.getElementById("pareto");
    if (!axes.length || !FD.shown.length) {
      place.append("There is nothing to draw.");
      return;
    }
    const named = (each) => axes.find((column) => column.path[1] === each.metric);
    const alike = (column) => new Set(FD.shown.map((n) => FD.value(n, column))).size < 2;
    const all = FD.data.study.objectives.map(named).filter(Boolean);
    const wanted = [...all].sort((p, q) => alike(p) - alike(q)); // what decides nothing comes last
    x = wanted[0] ?? axes[0];
    y = wanted[1] ?? axes.find((column) => column !== x) ?? x;
    picture = FD.svg("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "none" });
    const label = "Designs by two measures: arrow keys move, Enter chooses";
    field = FD.el(
      "div",
      { class: "field", role: "listbox", tabindex: "0", "aria-multiselectable": "true", "aria-label": label },
      picture,
    );
    told = FD.el("p", { class: "told" });
    words = FD.el("p", {});
    field.addEventListener("keydown", key);
    picture.addEventListener("mousemove", (event) => {
      const point = nearest(event);
      if (point && point.number !== active) {
        active = point.number;
        ring();
      }
    });
    picture.addEventListener("click", (event) => {
      const point = nearest(event);
      if (!point) return;
      active = point.number;
      FD.toggle(active);
    });
    place.append(
      FD.el(
        "div",
        { class: "tools" },
        chooser("across", "axis-x", x, (column) => (x = column)),
        chooser("up", "axis-y", y, (column) => (y = column)),
      ),
      field,
      told,
      FD.el(
        "ul",
        { class: "legend" },
        ...[
          "★ recommended",
          "◆ on the front of these two measures (dashed line)",
          "○ feasible",
          "× not feasible",
          ...(FD.data.study.references.length ? ["□ the reference, which the search was to beat"] : []),
          "A, B: the chosen two",
        ].map((text) => FD.el("li", {}, text)),
      ),
      FD.el("details", {}, FD.el("summary", {}, "In words"), words),
    );
    draw();
    FD.onShown(draw);
    FD.onSelect(draw);
  }

  FD.pareto = { start };
})();
