// The page's own object: data, the two chosen designs, elements and charts without any HTML of
// untrusted names. Plotly lies packed in the page and is unpacked for its first chart.
const FD = (() => {
  "use strict";
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent);
  const parts = new Map(); // of the packed heavy parts, those that were opened
  const watchers = { select: [], shown: [], look: [] };
  const my = { data, selected: [null, null], shown: [], byId };

  my.on = (event, act) => watchers[event].push(act);
  const raise = (event) => watchers[event].forEach((act) => act());
  my.all = (selector) => [...document.querySelectorAll(selector)];
  my.press = (selector, act) => my.all(selector).forEach((button) =>
    button.addEventListener("click", () => act(button.dataset)));

  /** An element; strings become text. */
  my.el = (tag, attributes, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };
  my.isNumber = (value) => typeof value === "number" && Number.isFinite(value);

  /** A value for reading: numbers with four significant digits. */
  my.number = (value) => {
    if (value === null || value === undefined) return "–";
    if (!my.isNumber(value)) return typeof value === "string" ? value : JSON.stringify(value);
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(3);
    return String(Number.isInteger(value) ? value : Number(value.toPrecision(4))).replace("-", "−");
  };
  my.value = (number, { path }) =>
    path.reduce((found, key) => found?.[key], data.designs[number]) ?? null;
  my.heading = ({ title, unit }) => (unit ? `${title} (${unit})` : title);
  my.name = (number) => data.designs[number]?.name ?? "none chosen";
  my.colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  my.say = (text) => (byId("said").textContent = text);

  /** The text that an element holds packed: gzip in base64. */
  my.unpacked = async (element) => {
    const text = atob(element.textContent);
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };
  const together = () => Number(byId("details-0").dataset.together);
  const partOf = (number) => Math.floor(number / together());
  /** The heavy part of a design that was made ready: {geometry, figures, ...}. */
  my.detail = (number) => parts.get(partOf(number))[number % together()];

  const idle = new Promise((go) => (window.requestIdleCallback ?? setTimeout)(go)); // text first
  let plotly = null;
  /** Make Plotly and the heavy parts of the chosen designs ready. */
  async function ready() {
    await idle;
    plotly ??= my.unpacked(byId("plotly")).then((text) =>
      document.head.append(my.el("script", {}, text))); // the policy knows its digest
    for (const part of my.selected.filter((number) => number !== null).map(partOf))
      if (!parts.has(part))
        parts.set(part, JSON.parse(await my.unpacked(byId(`details-${part}`))));
    await plotly;
  }

  /** Draw or change a chart, "--blue" as the page's colour; words: its text alternative. */
  my.chart = (place, traces, layout, words) => {
    const whole = { ...data.looks.chart, ...layout };
    for (const key of Object.keys(whole).filter((name) => /^[xy]axis/.test(name)))
      whole[key] = { ...data.looks.axis, ...whole[key] };
    const themed = (given) => JSON.parse(JSON.stringify(given), (key, value) =>
      typeof value === "string" && value.startsWith("--") ? my.colour(value.slice(2)) : value);
    place.setAttribute("aria-label", words);
    Plotly.react(place, themed(traces), themed(whole), data.looks.options);
  };

  /** Least and greatest of the numbers of a list; some width where they are one. */
  my.range = (list) => {
    const found = list.filter(my.isNumber);
    const [low, high] = [Math.min, Math.max].map((end) => found.reduce((p, q) => end(p, q), found[0]));
    return high > low ? [low, high] : [(low ?? 0) - 0.5, (low ?? 0) + 0.5];
  };

  /** A function that asks for a drawing, which is made once its place is near the window. */
  my.lazily = (place, draw) => {
    let [near, stale] = [false, false];
    const now = () => stale && (stale = false, draw());
    const soon = () => ready().then(() => near && now(), () =>
      place.replaceChildren("This browser cannot unpack the drawings; a newer one can."));
    new IntersectionObserver((entries) => {
      near = entries[entries.length - 1].isIntersecting;
      soon();
    }, { rootMargin: "500px" }).observe(place);
    window.addEventListener("beforeprint", () => window.Plotly && now());
    const again = () => (stale = true, soon());
    my.on("look", again);
    return again;
  };
  for (const query of ["(prefers-color-scheme: dark)", "print"])
    matchMedia(query).addEventListener("change", () => raise("look"));

  my.select = (a, b) => {
    my.selected = [a ?? null, b ?? null];
    my.selected.forEach((number, side) => {
      for (const place of my.all(`[data-side="${side}"]`)) place.hidden = number === null;
      for (const place of my.all(`[data-name="${side}"]`)) place.textContent = my.name(number);
    });
    byId("chosen").hidden = a === null && b === null;
    byId("swap").hidden = a === null || b === null;
    raise("select");
  };
  /** Take a design into the pair, or out of it; of three the oldest goes. */
  my.toggle = (number) => {
    const [a, b] = my.selected;
    if (number === a) my.select(b, null);
    else if (number === b) my.select(a, null);
    else if (a === null || b === null) my.select(a ?? number, a === null ? b : number);
    else my.select(b, number);
    const chosen = my.selected.filter((each) => each !== null).map(my.name);
    my.say(`Chosen: ${chosen.join(" and ") || "none"}`);
  };
  my.letter = (number) => ["A", "B"][my.selected.indexOf(number)] ?? null;
  my.show = (numbers) => {
    const before = new Set(my.shown);
    my.shown = numbers;
    if (before.size !== numbers.length || !numbers.every((each) => before.has(each))) raise("shown");
  };
  my.press("[data-leave]", ({ leave }) => my.toggle(my.selected[leave]));
  my.press("#swap", () => my.select(...my.selected.reverse()));
  return my;
})();
