// The page's own object: data, the two chosen designs, elements made without any HTML of strangers.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const SVG = "http://www.w3.org/2000/svg";
  const LETTERS = ["A", "B"];
  const KEPT = 8; // packed parts that are held open

  FD.data = JSON.parse(document.getElementById("data").textContent);
  FD.selected = [null, null];
  FD.shown = []; // numbers of the designs that pass the filter, in the table's order
  const onSelect = [];
  const onShown = [];

  /** An element; attributes whose value is null or false are left out; strings become text. */
  function filled(made, attributes, children) {
    for (const [name, value] of Object.entries(attributes || {})) {
      if (value === null || value === undefined || value === false) continue;
      if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
      else made.setAttribute(name, value === true ? "" : String(value));
    }
    made.append(...children.filter((child) => child !== null && child !== undefined));
    return made;
  }
  FD.el = (tag, attributes, ...children) =>
    filled(document.createElement(tag), attributes, children);
  FD.svg = (tag, attributes, ...children) =>
    filled(document.createElementNS(SVG, tag), attributes, children);

  FD.isNumber = (value) => typeof value === "number" && Number.isFinite(value);

  /** A value for reading: numbers with four significant digits. */
  FD.number = (value) => {
    if (value === null || value === undefined) return "–";
    if (!FD.isNumber(value)) return typeof value === "string" ? value : JSON.stringify(value);
    const size = Math.abs(value);
    if (Number.isInteger(value) && size < 1e6) return String(value).replace("-", "−");
    if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(3);
    return String(Number(value.toPrecision(4))).replace("-", "−");
  };

  FD.value = (number, column) =>
    column.path.reduce((found, key) => (found ? found[key] : undefined), FD.data.designs[number]) ??
    null;
  FD.heading = (column) => (column.unit ? `${column.title} (${column.unit})` : column.title);
  FD.label = (key) => {
    const found = FD.data.columns.find((column) => column.path[column.path.length - 1] === key);
    return found ? FD.heading(found) : key;
  };
  FD.name = (number) => FD.data.designs[number].name;
  FD.colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  FD.onTheme = (f) => {
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", f);
    matchMedia("print").addEventListener("change", f);
  };

  /** The text that an element holds packed: gzip in base64. */
  FD.unpacked = async (element) => {
    const bytes = Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };

  const parts = new Map(); // of the packed heavy parts, those that were opened
  const together = () => Number(document.getElementById("details-0").dataset.together);
  /** Make the heavy part of these designs ready. */
  FD.load = async (numbers) => {
    for (const number of numbers) {
      const part = Math.floor(number / together());
      if (parts.has(part)) continue;
      const text = await FD.unpacked(document.getElementById(`details-${part}`));
      parts.set(part, JSON.parse(text));
      if (parts.size > KEPT) parts.delete(parts.keys().next().value);
    }
  };
  /** The heavy part of a design that was made ready: {design, traces, grips, geometry}. */
  FD.detail = (number) => parts.get(Math.floor(number / together()))[number % together()];

  FD.say = (text) => {
    document.getElementById("said").textContent = text;
  };

  FD.select = (a, b) => {
    FD.selected = [a ?? null, b ?? null];
    for (const f of onSelect) f();
  };
  /** Take a design into the pair, or out of it; of three the oldest goes. */
  FD.toggle = (number) => {
    const [a, b] = FD.selected;
    if (number === a) FD.select(b, null);
    else if (number === b) FD.select(a, null);
    else if (a === null) FD.select(number, null);
    else if (b === null) FD.select(a, number);
    else FD.select(b, number);
    const chosen = FD.selected.filter((each) => each !== null).map(FD.name);
    FD.say(`Chosen: ${chosen.join(" and ") || "none"}`);
  };
  FD.letter = (number) => LETTERS[FD.selected.indexOf(number)] ?? null;
  FD.badge = (letter) => FD.el("span", { class: `mark-${letter.toLowerCase()}` }, letter);
  FD.onSelect = (f) => onSelect.push(f);
  FD.onShown = (f) => onShown.push(f);
  FD.tellShown = (numbers) => {
    FD.shown = numbers;
    for (const f of onShown) f();
  };

  /** A function that asks for a drawing, which is made once its place is near the window. */
  FD.lazily = (element, draw) => {
    let near = false;
    let stale = false; // nothing to draw before it is asked for
    const now = () => {
      if (near && stale) {
        stale = false;
        draw();
      }
    };
    new IntersectionObserver(
      (entries) => {
        near = entries[entries.length - 1].isIntersecting;
        now();
      },
      { rootMargin: "500px" },
    ).observe(element);
    window.addEventListener("beforeprint", () => {
      if (stale) {
        stale = false;
        draw();
      }
    });
    return () => {
      stale = true;
      now();
    };
  };

  function bar() {
    const place = document.getElementById("chosen");
    const [a, b] = FD.selected;
    place.hidden = a === null && b === null;
    const one = (number, letter) =>
      number === null
        ? null
        : FD.el(
            "span",
            { class: "one" },
            FD.badge(letter),
            FD.name(number),
            FD.el(
              "button",
              {
                type: "button",
                "aria-label": `Leave ${FD.name(number)} out`,
                onclick: () => FD.toggle(number),
              },
              "×",
            ),
          );
    place.replaceChildren(
      ...[one(a, "A"), one(b, "B")].filter(Boolean),
      FD.el("a", { href: "#pair" }, "See them side by side"),
    );
    if (a !== null && b !== null)
      place.append(
        FD.el("button", { type: "button", onclick: () => FD.select(b, a) }, "Swap A and B"),
      );
  }

  /** The recommended design and the runner-up. */
  function first() {
    const { designs, study } = FD.data;
    const good = designs.flatMap((each, number) => (each.status === "ok" ? [number] : []));
    const a = study.recommended ?? good[0] ?? null;
    const others = good.filter((number) => number !== a);
    const b = study.runner_up ?? others[0] ?? null;
    FD.select(a, b);
  }

  FD.start = () => {
    FD.onSelect(bar);
    FD.table.start();
    FD.pareto.start();
    FD.pair.start();
    FD.save.start();
    first();
  };
})();
