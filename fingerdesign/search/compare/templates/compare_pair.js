// The two chosen designs in numbers, and where their drawings and the lines of all designs go.
(() => {
  "use strict";
  const FD = window.FD;
  const SAME = 1e-9; // of the larger one

  const cell = (text, kind) => FD.el("td", kind ? { class: kind } : {}, text);

  function verdict(a, b, goal) {
    if (!FD.isNumber(a) || !FD.isNumber(b)) return ["", null];
    if (Math.abs(a - b) <= SAME * Math.max(Math.abs(a), Math.abs(b))) return ["equal", null];
    const share = a === 0 ? "" : `${b > a ? "+" : "−"}${Number(Math.abs((100 * b) / a - 100).toPrecision(3))} %`;
    const better = goal ? ((goal === "min") === a < b ? "A" : "B") : null;
    return [share, better];
  }

  function row(column, a, b) {
    const values = [a, b].map((number) => (number === null ? null : FD.value(number, column)));
    if (values.every((value) => value === null)) return null;
    const short = (value) => (column.path[0] === "digest" ? value.slice(0, 12) : FD.number(value));
    const texts = values.map((value) => (value === null ? "" : short(value)));
    const [share, better] = verdict(...values, column.goal);
    return FD.el(
      "tr",
      {},
      FD.el("th", { scope: "row", class: "text" }, FD.heading(column)),
      ...values.map((value, place) => {
        const word = typeof value === "string" && column.path[0] !== "digest" ? "word" : "";
        return cell(texts[place], better === "AB"[place] ? "better" : word);
      }),
      cell(share),
      cell(better ? `${better} is better` : "", "text"),
    );
  }

  const head = (text, kind) => FD.el("th", { scope: "col", class: kind ?? "" }, text);

  function numbers() {
    const place = document.getElementById("pair-numbers");
    const [a, b] = FD.selected;
    if (a === null && b === null) {
      place.replaceChildren(FD.el("p", {}, "Choose designs in the table or in the chart."));
      return;
    }
    const named = (number, letter) =>
      number === null ? `${letter}: none chosen` : `${letter}: ${FD.name(number)}`;
    const differ = (column) =>
      column.path[0] !== "values" ||
      b === null ||
      FD.number(FD.value(a, column)) !== FD.number(FD.value(b, column));
    const all = FD.data.columns;
    const rows = all.filter(differ).map((column) => row(column, a, b)).filter(Boolean);
    const hidden = all.length - all.filter(differ).length;
    const table = FD.el(
      "table",
      { id: "table-pair" },
      FD.el("caption", {}, "The two in numbers"),
      FD.el(
        "thead",
        {},
        FD.el(
          "tr",
          {},
          head("what", "text"),
          head(named(a, "A")),
          head(named(b, "B")),
          head("B against A"),
          head("", "text"),
        ),
      ),
      FD.el("tbody", {}, ...rows),
    );
    const region = { class: "scroll", tabindex: "0", role: "region", "aria-label": "The two in numbers" };
    const same = hidden ? FD.el("p", { class: "quiet" }, `Equal in both: ${hidden} values.`) : null;
    const notes = [...missed(a, b), ...unlike(a, b), ...warnings(a, b)];
    const fill = [...notes, FD.el("div", region, table), same];
    place.replaceChildren(...fill.filter(Boolean));
  }

  const told = (strong, text) => FD.el("p", {}, FD.el("strong", {}, strong), text);

  /** Which constraint or objective each misses, and by what. */
  function missed(a, b) {
    return [a, b].flatMap((number, place) => {
      const causes = number === null ? [] : FD.data.designs[number].missed;
      return causes.length ? [told(`Not feasible, ${"AB"[place]}: `, `${causes.join("; ")}.`)] : [];
    });
  }

  /** Measures of grips that lifted are of different grips where A and B lift different shares. */
  function unlike(a, b) {
    const both = [a, b].map((number) =>
      number === null ? null : FD.data.designs[number].metrics.grip_success,
    );
    if (!both.every(FD.isNumber) || both[0] === both[1]) return [];
    const shares = both.map((share, place) => `${"AB"[place]} ${FD.number(100 * share)} %`);
    const text =
      `the grip success of the two differs (${shares.join(", ")} of the grips lifted). Margins and ` +
      "force ratios are over the grips that lifted, so they are not of the same grips here.";
    return [told("Mind: ", text)];
  }

  function warnings(a, b) {
    return [a, b].flatMap((number, place) =>
      number === null
        ? []
        : FD.data.designs[number].warnings.map((text) => told(`Mind, ${"AB"[place]}: `, text)),
    );
  }

  /** Draw the two as soon as their heavy parts are there and the place is near the window. */
  function views() {
    const place = document.getElementById("views");
    const draw = FD.lazily(place, () => FD.views.show(...FD.selected, place));
    FD.onSelect(async () => {
      const asked = FD.selected;
      try {
        await FD.load(asked.filter((number) => number !== null));
      } catch {
        place.textContent = "This browser cannot unpack the drawings; a newer one can.";
        return;
      }
      if (FD.selected === asked) draw();
    });
  }

  function start() {
    FD.onSelect(numbers);
    views();
    const lines = document.getElementById("parallel-chart");
    const again = FD.lazily(lines, () =>
      FD.parallel.show(lines, FD.shown, FD.selected, FD.toggle),
    );
    FD.onSelect(again);
    FD.onShown(again);
  }

  FD.pair = { start };
})();
