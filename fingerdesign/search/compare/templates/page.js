// The page's own object; no HTML of untrusted names. Plotly lies packed until the first chart.
const { byId } = FD;
const data = JSON.parse(byId("data").textContent);
// details: the heavy parts of the designs that were made ready, {figures, readings, ...}.
Object.assign(FD, { data, details: {}, selected: [null, null], shown: [] });
const chosen = () => FD.selected.filter((number) => number !== null);

FD.on = (event, act) => window.addEventListener(`page-${event}`, act);
FD.raise = (event) => window.dispatchEvent(new Event(`page-${event}`));
FD.press = (selector, act) => FD.all(selector).forEach((button) =>
  button.addEventListener("click", () => act(button.dataset)));
FD.near = (p, q) => Math.abs(p - q) <= 1e-9 * Math.max(Math.abs(p), Math.abs(q));
/** A value for reading: numbers with four significant digits. */
FD.number = (given) => {
  const value = given ?? "–";
  if (typeof value === "string") return value;
  if (!Number.isFinite(value)) return JSON.stringify(value);
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(3);
  return String(Number.isInteger(value) ? value : Number(value.toPrecision(4))).replace("-", "−");
};
FD.value = (number, { path }) => path.reduce((found, key) => found?.[key], data.designs[number]) ?? null;
FD.name = (number) => data.designs[number]?.name ?? "none chosen";
FD.say = (text) => (byId("announced").textContent = text);
/** Make Plotly and the heavy parts of the chosen designs ready. */
async function ready() {
  await FD.plotly();
  for (const number of chosen().filter((each) => !(each in FD.details))) {
    const some = byId(`details-${Math.floor(number / data.together)}`);
    Object.assign(FD.details, JSON.parse(await FD.unpacked(some)));
  }
}
/** Draw or change a chart, "--blue" as the page's colour; words: its text alternative. */
FD.chart = (place, traces, layout, words, events = {}) => {
  const { options, template } = data.looks;
  const fresh = !place.data;
  place.ariaLabel = words;
  Plotly.react(place, FD.themed(traces), FD.themed({ template, ...layout }), options);
  for (const [event, act] of Object.entries(fresh ? events : {})) place.on(event, act);
};
/** Least and greatest of the numbers of a list; some width where they are one. */
FD.range = (list) => {
  const found = list.filter(Number.isFinite).sort((p, q) => p - q);
  const [low, high] = [found[0] ?? 0, found.at(-1)];
  return high > low ? [low, high] : [low - 0.5, low + 0.5];
};
/** A function that asks for a drawing, which is made once its place is near the window. */
FD.lazily = (place, draw) => {
  let [near, stale] = [false, false];
  const now = () => stale && (stale = false, draw());
  const soon = () => ready().then(() => near && now(), () =>
    place.replaceChildren("This browser cannot unpack the drawings; a newer one can."));
  new IntersectionObserver((entries) => {
    near = entries.at(-1).isIntersecting;
    soon();
  }, { rootMargin: "500px" }).observe(place);
  window.addEventListener("beforeprint", () => window.Plotly && now());
  const again = () => (stale = true, soon());
  FD.on("look", again);
  return again;
};
FD.onLook(() => FD.raise("look"));

FD.select = (a, b) => {
  FD.selected = [a ?? null, b ?? null];
  FD.selected.forEach((number, side) => {
    for (const place of FD.all(`[data-side="${side}"]`)) place.hidden = number === null;
    for (const place of FD.all(`[data-name="${side}"]`)) place.textContent = FD.name(number);
  });
  FD.raise("select");
};
/** Take a design into the pair, or out of it; of three the oldest goes. */
FD.toggle = (number) => {
  const rest = chosen().filter((each) => each !== number);
  FD.select(...(FD.selected.includes(number) ? rest : [...rest, number].slice(-2)));
  FD.say(`Chosen: ${chosen().map(FD.name).join(" and ") || "none"}`);
};
FD.letter = (number) => "AB"[FD.selected.indexOf(number)] ?? null;
/** The one of a list that is so many places on; at its ends, the end. */
FD.WAYS = { ArrowDown: 1, ArrowUp: -1, Home: -Infinity, End: Infinity };
FD.step = (list, from, way) =>
  list[Math.min(list.length - 1, Math.max(0, list.indexOf(from) + way))];
FD.press("[data-leave]", ({ leave }) => FD.toggle(FD.selected[leave]));
FD.press("#swap", () => FD.select(...FD.selected.reverse()));
