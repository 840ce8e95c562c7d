// The two chosen designs: in numbers, in space, contact, gages, forces. One slider moves the
// increment of all pictures, which figures.py and geometry.py have made.
(() => {
  "use strict";
  const at = (id, side) => FD.byId(`${id}-${side}`);
  const views = [0, 1].map(() => ({ turn: -32, tilt: 24, zoom: 1 })); // outlast the pair
  let kept = Infinity; // the chosen increment, for the next pair too
  let webgl = null;
  let items = [];

  /** A row of the two in numbers; null where neither has the value, or both what was varied. */
  function row(column) {
    const [p, q] = FD.selected.map((number) => (number === null ? null : FD.value(number, column)));
    const texts = [p, q].map((value) => (value === null ? "" : FD.number(value).slice(0, column.most)));
    if (!texts.join("") || (column.path[0] === "values" && texts[0] === texts[1])) return null;
    const both = FD.isNumber(p) && FD.isNumber(q);
    const same = both && Math.abs(p - q) <= 1e-9 * Math.max(Math.abs(p), Math.abs(q));
    const percent = Number(Math.abs((100 * q) / p - 100).toPrecision(3));
    const share = same ? "equal" : both && p ? `${q > p ? "+" : "−"}${percent} %` : "";
    const better = both && !same && column.goal ? ((column.goal === "min") === p < q ? "A" : "B") : "";
    return FD.el("tr", {}, FD.el("th", { scope: "row", class: "text" }, FD.heading(column)),
      ...texts.map((text, k) => FD.el("td",
        { class: better === "AB"[k] ? "better" : column.numeric ? "" : "word" }, text)),
      FD.el("td", {}, share),
      FD.el("td", { class: "text" }, better && `${better} is better`));
  }

  function numbers() {
    const rows = FD.data.columns.map(row);
    FD.byId("table-pair").tBodies[0].replaceChildren(...rows.filter(Boolean));
    FD.byId("pair-same").hidden = rows.every(Boolean);
    const both = FD.selected.map((number) => FD.data.designs[number]);
    const notes = both.flatMap((each, k) => (each?.notes ?? []).map((text) => `${"AB"[k]}: ${text}`));
    const lifts = both.map((each) => each?.metrics.grip_success).filter(FD.isNumber);
    FD.byId("pair-unlike").hidden = lifts.length < 2 || lifts[0] === lifts[1];
    FD.byId("pair-notes").replaceChildren(...notes.map((text) => FD.el("p", {}, text)));
  }

  const status = (text) => [...text.matchAll(/(\d+)(\D)/g)]
    .map(([, count, character]) => character.repeat(Number(count))).join("");

  /** Give the points of each status to their trace, from marks.first on. */
  function marked(place, { first, kinds, each, ...places }, statuses) {
    const of = (values, kind) => [...statuses].flatMap((own, k) => (own !== kind ? []
      : [...values.slice(k * each, (k + 1) * each), null])); // a gap: lines do not go on
    const axes = ["x", "y", "z"].filter((key) => places[key]);
    const update = axes.map((key) => [key, [...kinds].map((kind) => of(places[key], kind))]);
    Plotly.restyle(place, Object.fromEntries(update), [...kinds].map((_, k) => first + k));
  }

  /** The scene's camera and zoom, of a turn about y and a tilt toward it. */
  function camera({ turn, tilt, zoom }) {
    const [t, p] = [(turn * Math.PI) / 180, (tilt * Math.PI) / 180];
    const [ct, st, cp, sp] = [Math.cos(t), Math.sin(t), Math.cos(p), Math.sin(p)];
    return { "scene.camera": { eye: { x: 2 * cp * st, y: 2 * sp, z: 2 * cp * ct },
      up: { x: -sp * st, y: cp, z: -sp * ct }, projection: { type: "orthographic" } },
    "scene.aspectratio": { x: 1.8 * zoom, y: 1.8 * zoom, z: 1.8 * zoom } };
  }

  /** Turn a view, or both together: `change` is by how much, `to` where to. */
  function turn(side, { turn: round = 0, tilt: down = 0, zoom: factor = 1, ...to }) {
    const from = { ...views[side ?? 0], ...to.to };
    const view = { turn: ((((from.turn + round + 180) % 360) + 360) % 360) - 180,
      tilt: Math.min(90, Math.max(-90, from.tilt + down)),
      zoom: Math.min(8, Math.max(0.5, from.zoom * factor)) };
    items.forEach((item, k) => {
      if (!item || at("shape", k).hidden || !(FD.byId("turn-both").checked || side === null || k === side)) return;
      views[k] = view;
      Plotly.relayout(at("shape", k), camera(view));
    });
    FD.byId("turned").textContent = `turned ${Math.round(view.turn)}°, ` +
      `tilted ${Math.round(view.tilt)}°, ${Math.round(100 * view.zoom)} %`;
  }
  const START = { to: { turn: -32, tilt: 24, zoom: 1 } };
  const KEYS = { ArrowLeft: { turn: 10 }, ArrowRight: { turn: -10 }, ArrowUp: { tilt: -10 },
    ArrowDown: { tilt: 10 }, "+": { zoom: 1.2 }, "=": { zoom: 1.2 }, "-": { zoom: 1 / 1.2 }, 0: START };

  /** One of the figures of both designs; axes that both show alike have one range. */
  function figure(key, more = () => ({})) {
    const found = items.map((item) => (item?.figures[key] && (key !== "shape" || webgl)
      ? item.figures[key] : null));
    found.forEach((each, side) => {
      at(key, side).hidden = !each;
      at(`${key}-none`, side).hidden = Boolean(each);
      if (!each) return;
      const layout = { ...each.layout, ...more(each, side) };
      for (const axis of each.shared)
        layout[axis] = { ...layout[axis],
          range: FD.range(found.flatMap((own) => own?.layout[axis].range ?? [])) };
      FD.chart(at(key, side), each.data, layout, `${"AB"[side]}: ${each.words}`);
    });
  }

  /** The camera, and one scale for both: what is longer is drawn longer. */
  function scene({ layout }, side) {
    const reach = 0.5 * Math.max(...items.map((item) => Math.hypot(...(item?.size ?? [0]))));
    const { "scene.camera": seen, "scene.aspectratio": aspectratio } = camera(views[side]);
    const axis = (middle) => ({ visible: false, range: [middle - reach, middle + reach] });
    const [xaxis, yaxis] = [axis(0), axis(0.5 * items[side].size[1])];
    return { scene: { ...layout.scene, xaxis, yaxis, zaxis: xaxis, camera: seen, aspectratio } };
  }

  /** Where a hand has turned a view to. */
  function byHand(side, { "scene.camera": seen }) {
    const { x, y, z } = seen?.eye ?? {};
    const [tilt, round] = [Math.asin(y / Math.hypot(x, y, z)), Math.atan2(x, z)]
      .map((angle) => (angle * 180) / Math.PI);
    if (Math.abs(tilt - views[side].tilt) + Math.abs(round - views[side].turn) % 360 > 0.5)
      turn(side, { to: { tilt, turn: round } });
  }

  /** Bring one gage out. */
  function bring(side) {
    const chosen = Number(at("gage", side).value);
    const of = (own, others) =>
      items[side].figures.gages.data.map((_, k) => (k === chosen ? own : others));
    Plotly.restyle(at("gages", side), { "line.width": of(2.6, 0.9),
      "line.color": of(FD.colour(["blue", "vermilion"][side]), FD.colour("muted")) });
  }

  /** All gages over x at an increment, both designs in one chart. */
  function profile(k) {
    const traces = items.flatMap((item, side) => {
      const { places, data, steps } = item?.figures.gages ?? {};
      if (!places) return [];
      const now = Math.min(k, steps.length - 1);
      const points = places.map((x, gage) => [x, data[gage].y[now]]).sort((p, q) => p[0] - q[0]);
      return [{ x: points.map(([x]) => x), y: points.map(([, y]) => y), name: "AB"[side],
        mode: "lines+markers", ...FD.data.looks.profile.lines[side] }];
    });
    FD.byId("profile").hidden = !traces.length;
    const { layout } = FD.data.looks.profile;
    const ends = items.flatMap((item) => item?.figures.gages?.layout.yaxis.range ?? []);
    if (traces.length) FD.chart(FD.byId("profile"), traces,
      { ...layout, yaxis: { ...layout.yaxis, range: FD.range(ends) } },
      `Readings of all gages over x at increment ${k + 1}.`);
  }

  /** Show the slider's increment in all pictures, and the readings at it. */
  function follow() {
    const slider = FD.byId("increment");
    const k = Number(slider.value) - 1;
    let shown = `${k + 1} of ${slider.max}`;
    items.forEach((item, side) => {
      if (!item) return;
      if (item.count && item.count <= k) shown += `; ${"AB"[side]} ends at ${item.count}`;
      const now = Math.min(k, item.count - 1);
      for (const cell of FD.all(`#readings [data-side="${side}"] [data-key]`))
        cell.textContent = FD.number(item.readings[cell.dataset.key][now]);
      const text = status(item.status[now] ?? "");
      for (const [key, each] of Object.entries(item.figures)) {
        const place = at(key, side);
        const step = each?.steps[Math.min(k, each.steps.length - 1)];
        if (step) Plotly.relayout(place, step);
        if (each?.marks && place.data && !place.hidden) marked(place, each.marks, text);
      }
    });
    FD.byId("increment-shown").textContent = shown;
    profile(k);
  }

  /** What is written of one design: gages to choose from, how far to believe the numbers. */
  function write({ words, figures, belief, mind }, side) {
    at("shape-words", side).textContent = words;
    at("gage", side).parentElement.hidden = !figures.gages;
    at("gage", side).replaceChildren(...(figures.gages?.names ?? []).map((name, k) =>
      FD.el("option", { value: k }, name)));
    at("gage", side).value = String(figures.gages?.best);
    at("belief", side).replaceChildren(...belief.flatMap(([words, value]) =>
      [FD.el("dt", {}, words), FD.el("dd", {}, value)]));
    at("mind", side).replaceChildren(...mind.map((sentence) => FD.el("li", {}, sentence)));
  }

  function draw() {
    webgl ??= Boolean(document.createElement("canvas").getContext("webgl"));
    FD.byId("no-webgl").hidden = webgl;
    items = FD.selected.map((number) => (number === null ? null : { ...FD.detail(number) }));
    const there = items.filter(Boolean);
    FD.byId("views").hidden = !there.length;
    if (!there.length) return;
    items.forEach((item, side) => item && write(item, side));
    figure("shape", scene);
    for (const key of ["contact", "gages", "forces"]) figure(key);
    for (const side of [0, 1])
      if (at("shape", side).data && !at("shape", side).dataset.turns) {
        at("shape", side).dataset.turns = "yes";
        at("shape", side).on("plotly_relayout", (event) => byHand(side, event));
      }
    items.forEach((item, side) => item?.figures.gages && bring(side));
    const count = Math.max(...there.map((item) => item.count));
    FD.byId("increments").hidden = !count;
    FD.byId("increment").max = Math.max(1, count);
    FD.byId("increment").value = Math.min(kept, count);
    if (count) follow();
  }

  FD.byId("increment").addEventListener("input", ({ target }) => {
    kept = target.value === target.max ? Infinity : Number(target.value); // the last stays the last
    follow();
  });
  FD.press("[data-view]", ({ view }) => turn(null, JSON.parse(view)));
  for (const side of [0, 1]) {
    at("gage", side).addEventListener("change", () => bring(side));
    const move = (event, change) => {
      if (!change || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      turn(side, change);
    };
    at("shape", side).addEventListener("keydown", (event) => move(event, KEYS[event.key]));
    // Only where the view has the focus: the wheel otherwise scrolls the page.
    at("shape", side).addEventListener("wheel", (event) => move(event,
      document.activeElement === at("shape", side) && { zoom: Math.exp(-0.0015 * event.deltaY) }),
    { passive: false });
  }
  FD.on("select", numbers);
  FD.on("select", FD.lazily(FD.byId("pair-views"), draw));
  FD.select(...FD.data.study.pair);
})();
