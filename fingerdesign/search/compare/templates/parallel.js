// Every design a line through axes of values and metrics; up is better where one end is.
const { columns, looks: { lines } } = FD.data;
const NONE = -0.14; // where a line passes an axis of which its design has no value
const BETWEEN = [0, 0.25, 0.5, 0.75]; // of two axes: where a line can be pointed at
let axes = [];
const boxes = FD.all("#parallel-axes input");
const sentence = (number) => FD.sentence(number, axes);
const trace = (numbers, more) => {
  const line = (number) => [...axes.flatMap(({ at }, k) => {
    const [own, next] = [at(number), axes[k + 1]?.at(number)];
    return next === undefined ? [[k, own, number]]
      : BETWEEN.map((share) => [k + share, own + share * (next - own), number]);
  }), [null, null, null]];
  const [x, y, customdata] = [0, 1, 2].map((k) => numbers.flatMap(line).map((p) => p[k]));
  return { x, y, customdata, mode: "lines", hoverinfo: "none", ...more };
};

function axisOf(column) {
  const of = (number) => {
    const value = FD.value(number, column);
    return column.kinds ? column.kinds.indexOf(FD.number(value)) : value;
  };
  const [low, high] = FD.range(FD.shown.map(of));
  const range = column.goal === "min" ? [high, low] : [low, high];
  const share = (value) => (value - range[0]) / (range[1] - range[0]);
  const at = (number) => (FD.value(number, column) === null ? NONE : share(of(number)));
  return { ...column, at, range, different: new Set(FD.shown.map(of)).size > 1 };
}
function draw(chart, place) {
  axes = boxes.filter((box) => box.checked).map((box) => axisOf(columns[box.value]))
    .filter(({ different }) => different);
  place.hidden = FD.shown.length < 2 || axes.length < 2;
  FD.byId("parallel-none").hidden = !place.hidden;
  if (place.hidden) return [];
  const chosen = FD.selected.filter((number) => FD.shown.includes(number));
  const rest = FD.shown.filter((number) => !chosen.includes(number));
  const lacking = FD.shown.some((number) => axes.some(({ at }) => at(number) === NONE));
  const [bottom, top] = [lacking ? NONE - 0.04 : -0.04, 1.04];
  const traces = [trace(rest, { ...lines.rest, opacity: rest.length > 100 ? 0.3 : 0.45 }),
    trace([], lines.ring), ...chosen.map((number) => trace([number], lines[FD.letter(number)]))];
  const layout = { ...lines.layout,
    xaxis: { range: [-0.02, axes.length - 0.9], visible: false },
    yaxis: { range: [bottom, top], visible: false } };
  layout.annotations = axes.map(({ short, goal }, k) =>
    ({ ...lines.title, x: k, yshift: (k % 2) * 28, text: short + (goal ? " ▲" : "") }));
  if (lacking) layout.annotations.push({ ...lines.none, y: NONE });
  axes.forEach(({ range: [low, high], ticks }, k) => {
    layout[`yaxis${k + 2}`] = { ...lines.upright, ...ticks,
      range: [bottom, top].map((share) => low + share * (high - low)),
      position: (k + 0.02) / (axes.length - 0.88) };
    traces.push({ x: [null], y: [null], yaxis: `y${k + 2}`, hoverinfo: "skip" });
  });
  chart(traces, layout, `Parallel coordinates of ${FD.shown.length} designs over ` +
    `${axes.map(({ heading }) => heading).join(", ")}. ${chosen.map(sentence).join(". ")}. ` +
    "Arrow keys go from design to design, Enter chooses.");
  return FD.shown;
}
const again = FD.walked("parallel-chart", { draw, sentence, order: () => FD.shown,
  ring: (number) => trace(number === null ? [] : [number]) });
for (const box of boxes) box.addEventListener("change", again);
