// The two chosen designs in numbers and pictures; one slider moves the increment of all of them.
const at = (id, side) => FD.byId(`${id}-${side}`);
const views = [FD.data.looks.start, FD.data.looks.start]; // outlast the pair
let increment = Infinity; // the chosen increment, for the next pair too
let webgl = null;
let items = [];
/** A row of the two in numbers; null where neither has the value, or both what was varied. */
function row(column) {
  const [p, q] = FD.selected.map((number) => FD.value(number, column));
  const texts = [p, q].map((value) => (value === null ? "" : FD.number(value).slice(0, column.most)));
  if (!texts.join("") || (column.path[0] === "values" && texts[0] === texts[1])) return null;
  const both = Number.isFinite(p) && Number.isFinite(q);
  const same = both && (FD.near(p, q) || texts[0] === texts[1]); // as they read
  const times = q / p;
  const change = `${q > p ? "+" : "−"}${Number(Math.abs(100 * times - 100).toPrecision(3))} %`;
  const share = same ? "equal" : both && p ? (times > 10 ? `× ${Number(times.toPrecision(3))}` : change) : "";
  const chance = Math.hypot(...FD.selected.map((number) => // by how much chance changes them
    FD.value(number, { path: ["unsure", column.path[1]] })));
  const differ = both && !same && Math.abs(p - q) > chance;
  const better = differ && column.goal ? "AB"[Number((column.goal === "max") === p < q)] : "";
  const words = better ? `${better} is better` : both && !same && !differ ? "no difference shown" : "";
  const cell = (className, text) => FD.el("td", { className }, text);
  return FD.el("tr", {}, FD.el("th", { scope: "row", className: "text" }, column.heading),
    ...texts.map((text, k) => cell(better === "AB"[k] ? "better" : column.numeric ? "" : "word", text)),
    cell("", share), cell("text", words));
}
function numbers() {
  const rows = FD.data.columns.map(row);
  FD.byId("table-pair").tBodies[0].replaceChildren(...rows.filter(Boolean));
  FD.byId("pair-same").hidden = rows.every(Boolean);
  const both = FD.selected.map((number) => FD.data.designs[number]);
  const notes = both.flatMap((each, k) => (each?.notes ?? []).map((text) => `${"AB"[k]}: ${text}`));
  const lifts = both.map((each) => each?.metrics.grip_success).filter(Number.isFinite);
  FD.byId("pair-lifts-differ").hidden = lifts.length < 2 || lifts[0] === lifts[1];
  FD.byId("pair-notes").replaceChildren(...notes.map((text) => FD.el("p", {}, text)));
}
/** Give the points of each status to their trace, from marks.first on. */
function marked(place, { first, kinds, each, places }, statuses = "") {
  const of = (values, kind) => [...statuses].flatMap((own, k) => (own !== kind ? []
    : [...values.slice(k * each, (k + 1) * each), null])); // a gap: lines do not go on
  const update = Object.entries(places).map(([axis, values]) =>
    [axis, [...kinds].map((kind) => of(values, kind))]);
  Plotly.restyle(place, Object.fromEntries(update), [...kinds].map((_, k) => first + k));
}
/** The scene of a view, a turn about y and a tilt toward it; both fingers at one scale. */
function scene(side) {
  const { turn, tilt, zoom } = views[side];
  const [t, p] = [(turn * Math.PI) / 180, (tilt * Math.PI) / 180];
  const [ct, st, cp, sp] = [Math.cos(t), Math.sin(t), Math.cos(p), Math.sin(p)];
  const [eye, up] = [{ x: 2 * cp * st, y: 2 * sp, z: 2 * cp * ct }, { x: -sp * st, y: cp, z: -sp * ct }];
  const reach = items.map((item) => Math.hypot(...(item?.size ?? [])));
  const size = (1.8 * zoom * reach[side]) / Math.max(...reach);
  return { camera: { eye, up, projection: { type: "orthographic" } },
    aspectratio: { x: size, y: size, z: size } };
}
/** Turn a view, or both together: by how much, `to` where to. */
function turn(side, { turn: round = 0, tilt: down = 0, zoom: factor = 1, to }) {
  const from = { ...views[side ?? 0], ...to };
  const view = { turn: from.turn + round - 360 * Math.round((from.turn + round) / 360),
    tilt: Math.min(90, Math.max(-90, from.tilt + down)),
    zoom: Math.min(8, Math.max(0.5, from.zoom * factor)) };
  for (const k of FD.byId("turn-both").checked || side === null ? [0, 1] : [side]) {
    views[k] = view;
    if (!items[k] || at("shape", k).hidden) continue;
    const { camera: { eye, up }, aspectratio } = scene(k);
    Plotly.relayout(at("shape", k),
      { "scene.camera.eye": eye, "scene.camera.up": up, "scene.aspectratio": aspectratio });
  }
  FD.byId("turned").textContent = `turned ${Math.round(view.turn)}°, ` +
    `tilted ${Math.round(view.tilt)}°, ${Math.round(100 * view.zoom)} %`;
}
/** One of the figures of both designs; axes that both show alike have one range. */
function figure(key) {
  const found = items.map((item) => (key === "shape" && !webgl ? null : item?.figures[key]));
  found.forEach((each, side) => {
    at(key, side).hidden = !each;
    at(`${key}-none`, side).hidden = Boolean(each);
    if (!each) return;
    const layout = { ...each.layout };
    if (key === "shape") layout.scene = { ...layout.scene, ...scene(side) };
    for (const axis of each.shared)
      layout[axis] = { ...layout[axis],
        range: FD.range(found.flatMap((own) => own?.layout[axis].range ?? [])) };
    FD.chart(at(key, side), each.data, layout, `${"AB"[side]}: ${each.words}`,
      { plotly_relayout: (event) => byHand(side, event["scene.camera"]?.eye) });
  });
}
/** Follow a hand that has turned a view. */
function byHand(side, eye) {
  if (!eye) return;
  const [tilt, round] = [Math.asin(eye.y / Math.hypot(eye.x, eye.y, eye.z)), Math.atan2(eye.x, eye.z)]
    .map((angle) => (angle * 180) / Math.PI);
  turn(side, { to: { tilt, turn: round } });
}
/** Highlight one gage. */
function highlight(side) {
  const style = (width, colour, traces) =>
    Plotly.restyle(at("gages", side), { "line.width": width, "line.color": FD.colour(colour) }, traces);
  style(0.9, "muted");
  style(2.6, ["blue", "vermilion"][side], [Number(at("gage", side).value)]);
}
/** All gages over x at an increment, both designs in one chart. */
function profile(k) {
  const { layout, lines } = FD.data.looks.profile;
  const traces = items.flatMap((item, side) => {
    const { places: x, order, data, steps } = item?.figures.gages ?? {};
    const now = Math.min(k, steps?.length - 1);
    return x ? [{ x, y: order.map((gage) => data[gage].y[now]), ...lines[side] }] : [];
  });
  FD.byId("profile").hidden = !traces.length;
  const range = FD.range(items.flatMap((item) => item?.figures.gages?.layout.yaxis.range ?? []));
  if (traces.length) FD.chart(FD.byId("profile"), traces,
    { ...layout, yaxis: { ...layout.yaxis, range } },
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
    for (const [key, each] of Object.entries(item.figures)) {
      const place = at(key, side);
      const step = each?.steps[Math.min(k, each.steps.length - 1)];
      if (step) Plotly.relayout(place, step);
      if (each?.marks && place.data && !place.hidden) marked(place, each.marks, item.status[now]);
    }
  });
  FD.byId("increment-shown").textContent = shown;
  profile(k);
}
/** What is written of one design: gages to choose from, the accuracy of the numbers. */
function write({ words, figures, accuracy, warnings }, side) {
  at("shape-words", side).textContent = words;
  at("gage", side).parentElement.hidden = !figures.gages;
  at("gage", side).replaceChildren(...(figures.gages?.names ?? []).map((name, k) =>
    FD.el("option", { value: k, selected: k === figures.gages.best }, name)));
  at("accuracy", side).replaceChildren(...accuracy.flatMap(([words, value]) =>
    [FD.el("dt", {}, words), FD.el("dd", {}, value)]));
  at("warnings", side).replaceChildren(...warnings.map((sentence) => FD.el("li", {}, sentence)));
  if (figures.gages) highlight(side);
}
function draw() {
  webgl ??= Boolean(document.createElement("canvas").getContext("webgl"));
  FD.byId("no-webgl").hidden = webgl;
  items = FD.selected.map((number) => (number === null ? null : FD.details[number]));
  const there = items.filter(Boolean);
  FD.byId("views").hidden = !there.length;
  if (!there.length) return;
  ["shape", "contact", "gages", "forces"].forEach(figure);
  items.forEach((item, side) => item && write(item, side));
  const count = Math.max(...there.map((item) => item.count));
  FD.byId("increments").hidden = !count;
  Object.assign(FD.byId("increment"), { max: Math.max(1, count), value: Math.min(increment, count) });
  if (count) follow();
}
FD.byId("increment").addEventListener("input", ({ target }) => {
  increment = target.value === target.max ? Infinity : Number(target.value); // the last stays the last
  follow();
});
FD.press("[data-view]", ({ view }) => turn(null, JSON.parse(view)));
for (const side of [0, 1]) {
  at("gage", side).addEventListener("change", () => highlight(side));
  const move = (event, change) => {
    if (!change || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    turn(side, change);
  };
  at("shape", side).addEventListener("keydown", (event) => move(event, FD.data.looks.keys[event.key]));
  // Only where the view has the focus: the wheel otherwise scrolls the page.
  at("shape", side).addEventListener("wheel", (event) => move(event,
    document.activeElement === at("shape", side) && { zoom: Math.exp(-0.0015 * event.deltaY) }),
  { passive: false });
}
FD.on("select", numbers);
FD.on("select", FD.lazily(FD.byId("pair-views"), draw));
FD.select(...FD.data.study.pair);
