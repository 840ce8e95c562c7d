// Two measures of all designs that pass the filter; the front of the two as stairs.
const { columns, designs, looks } = FD.data;
const axes = () => ["x", "y"].map((key) => columns[FD.byId(`axis-${key}`).value]);
let [points, front] = [[], []];
// What a design is by itself; of those alike, the front of these two stands out.
const kind = (point) => (designs[point.number].kind === "in" && front.includes(point)
  ? "front" : designs[point.number].kind);
const trace = (some, more) => ({ x: some.map((p) => p.x), y: some.map((p) => p.y),
  customdata: some.map((p) => p.number), ...more });
const badge = ({ number, x, y }) => // beside the point: its shape says what it is
  ({ x, y, text: FD.letter(number), ...looks.badges[FD.letter(number)] });
const axis = (column, key) => {
  const all = [...new Set(points.map((point) => point[key]))];
  return all.length > 1 ? { title: { text: column.label } }
    : { title: { text: column.alike }, tickvals: all };
};

function draw(chart) {
  const [x, y] = axes();
  points = FD.shown.map((number) => ({ number, x: FD.value(number, x), y: FD.value(number, y) }))
    .filter((point) => Number.isFinite(point.x) && Number.isFinite(point.y));
  const [right, up] = [x, y].map(({ goal }) => ({ min: 1, max: -1 })[goal]);
  const good = points.filter(({ number }) => designs[number].competes && right && up);
  // Whom nobody is nowhere worse and somewhere better than, in these two.
  front = good.filter((p) => !good.some((q) => right * (q.x - p.x) <= 0 &&
    up * (q.y - p.y) <= 0 && (q.x !== p.x || q.y !== p.y))).sort((p, q) => p.x - q.x);
  const line = { color: "--green", dash: "dash", shape: x.goal === "min" ? "hv" : "vh" };
  const traces = [trace(front, { name: "line", mode: "lines", hoverinfo: "skip", line }),
    ...Object.values(looks.points).map((look) =>
      trace(points.filter((point) => kind(point) === look.name), look))];
  const touch = matchMedia("(pointer: coarse)").matches; // there a drag scrolls the page
  chart(traces, { height: 430, dragmode: !touch && "select", selections: [],
    xaxis: axis(x, "x"), yaxis: axis(y, "y"),
    annotations: points.filter(({ number }) => FD.letter(number)).map(badge) },
  "Designs by two measures: arrow keys move, Enter chooses");
  const ends = [...new Set([front[0], front.at(-1)])]
    .map((p) => p && `${FD.name(p.number)} (${FD.number(p.x)}, ${FD.number(p.y)})`);
  const words = front.length ? `The front of these two has ${front.length}: ${ends.join(" to ")}.`
    : "No front: one of the two has no better end, or no design is feasible.";
  FD.byId("pareto-words").textContent =
    `${points.length} designs, ${y.heading} over ${x.heading}. ${words}`;
  return points.map(({ number }) => number);
}
const again = FD.walked("pareto", { draw,
  order: (upright) => [...points].sort((p, q) =>
    (upright ? p.y - q.y || p.x - q.x : p.x - q.x || p.y - q.y)).map(({ number }) => number),
  ring: (number) => trace(points.filter((point) => point.number === number)),
  sentence: (number) => [FD.sentence(number, axes()),
    FD.letter(number) && `chosen as ${FD.letter(number)}`, ...designs[number].marks,
    front.some((p) => p.number === number) && "on the front of these two"]
    .filter(Boolean).join(", ") });
for (const select of FD.all("#axis-x, #axis-y")) select.addEventListener("change", again);
FD.bound = (range) => axes().forEach(({ path }, k) => FD.filter(path, range["xy"[k]]));
