// What of the table is shown: a word in the name, a bound on any column, the front, some columns.
(() => {
  "use strict";
  const FD = window.FD;
  const NUMBER = "([-−+]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][-+]?\\d+)?)";
  const ONE = new RegExp(`^(<=|>=|<|>|=|≤|≥)?\\s*${NUMBER}$`);
  const RANGE = new RegExp(`^${NUMBER}\\s*(?:\\.\\.|to)\\s*${NUMBER}$`);
  const WAYS = {
    "<": (x, y) => x < y,
    "<=": (x, y) => x <= y,
    "≤": (x, y) => x <= y,
    ">": (x, y) => x > y,
    ">=": (x, y) => x >= y,
    "≥": (x, y) => x >= y,
  };
  const FIRST_COLUMNS = 14; // of the values shown at first; the rest is a tick away
  const inputs = new Map(); // key of a column -> its input
  let front = null;
  let feasible = null;
  let told = null;
  let fault = null;

  const toNumber = (text) => Number(text.replace("−", "-"));

  /** What a filter's text asks of a column's value; null where it cannot be read. */
  function asked(text, column) {
    const words = text.trim();
    if (!words) return () => true;
    if (!column.numeric) {
      const wanted = words.toLowerCase();
      return (value) => value !== null && FD.number(value).toLowerCase().includes(wanted);
    }
    const range = RANGE.exec(words);
    if (range) {
      const [low, high] = [toNumber(range[1]), toNumber(range[2])];
      return (value) => value !== null && value >= low && value <= high;
    }
    const one = ONE.exec(words);
    if (!one) return null;
    const bound = toNumber(one[2]);
    const way = WAYS[one[1]] ?? ((x, y) => Math.abs(x - y) <= 1e-9 * Math.max(1, Math.abs(y)));
    return (value) => value !== null && way(value, bound);
  }

  /** Whether a design passes all that is asked now. */
  function test(columns) {
    const asks = [];
    const wrong = [];
    for (const column of columns) {
      const input = inputs.get(column.key);
      if (!input || !input.value.trim()) {
        input?.removeAttribute("aria-invalid");
        continue;
      }
      const ask = asked(input.value, column);
      if (ask === null) {
        input.setAttribute("aria-invalid", "true");
        wrong.push(column.title);
      } else {
        input.removeAttribute("aria-invalid");
        asks.push((number) => ask(column.of(number)));
      }
    }
    const how = "write <0.1, >=5, 2..5 or a number";
    fault.textContent = wrong.length ? `Not understood for ${wrong.join(", ")}: ${how}.` : "";
    if (front.checked) asks.push((number) => FD.data.designs[number].front);
    if (feasible.checked) asks.push((number) => FD.data.designs[number].feasible);
    return (number) => asks.every((ask) => ask(number));
  }

  function hide(table, column, hidden) {
    const place = column.head.cellIndex;
    for (const row of table.rows) row.cells[place].hidden = hidden;
    inputs.get(column.key).value = "";
  }

  function chooser(table, columns, apply) {
    const atFirst = (column, place) => place < FIRST_COLUMNS || column.wanted === true;
    const boxes = columns.slice(2).map((column, place) => {
      const box = FD.el("input", {
        type: "checkbox",
        checked: atFirst(column, place),
        onchange: () => {
          hide(table, column, !box.checked);
          apply();
        },
      });
      if (!atFirst(column, place)) hide(table, column, true);
      return FD.el("label", {}, box, FD.heading(column));
    });
    const count = boxes.length;
    const seen = columns.slice(2).filter(atFirst).length;
    const more = count > seen ? ` (${seen} of ${count} shown at first)` : "";
    return FD.el(
      "details",
      {},
      FD.el("summary", {}, `Columns${more}`),
      FD.el("div", { class: "columns" }, ...boxes),
    );
  }

  function start(table, columns, apply) {
    const line = FD.el("tr", { class: "filters" });
    for (const column of columns) {
      const example = column.numeric ? "<0.1 or 2..5" : "part of a word";
      const input = FD.el("input", {
        type: "text",
        "aria-label": `Filter ${column.title}, for example ${example}`,
        placeholder: column.numeric ? "<  >  .." : "has",
        oninput: apply,
        autocomplete: "off",
        spellcheck: "false",
      });
      inputs.set(column.key, input);
      const name = column.head.classList.contains("name") ? "text name" : "";
      line.append(FD.el("td", { class: name }, input));
    }
    table.tHead.append(line);
    front = FD.el("input", { type: "checkbox", id: "only-front", onchange: apply });
    feasible = FD.el("input", { type: "checkbox", id: "only-feasible", onchange: apply });
    told = FD.el("output", { id: "shown-count" });
    fault = FD.el("span", { class: "fault", role: "alert" });
    const clear = () => {
      for (const input of inputs.values()) input.value = "";
      front.checked = feasible.checked = false;
      apply();
    };
    document.getElementById("tools").append(
      told,
      FD.el("label", {}, front, "only the Pareto front"),
      FD.el("label", {}, feasible, "only feasible ones"),
      FD.el("button", { type: "button", id: "clear-filter", onclick: clear }, "Clear the filter"),
      fault,
      chooser(table, columns, apply),
    );
  }

  FD.filter = {
    start,
    test,
    tell: (shown, all) => {
      told.textContent = `${shown} of ${all} shown`;
    },
  };
})();
