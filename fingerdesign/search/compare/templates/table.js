// The table of all designs, which stands in the page already: sorted, filtered, chosen from; saved.
(() => {
  "use strict";
  const table = FD.byId("table-designs");
  const rows = new Map(); // design -> its row
  let columns = [];
  let order = []; // all designs of the table, as sorted
  let sorted = { column: null, up: true };

  const texts = new Intl.Collator("en", { numeric: true });
  /** Sort by a column; what has no value stands last either way. */
  function sort(column, up) {
    const keyed = order.map((number) => [(column.rank ?? column.of)(number), number]);
    order = keyed.sort(([x, i], [y, j]) => {
      if (x === null || y === null) return (x === null) - (y === null) || i - j;
      const way = FD.isNumber(x) && FD.isNumber(y) ? x - y
        : texts.compare(FD.number(x), FD.number(y));
      return (up ? way : -way) || i - j;
    }).map(([, number]) => number);
    table.tBodies[0].append(...order.map((number) => rows.get(number)));
    sorted = { column, up };
    const words = up ? "ascending" : "descending";
    for (const each of columns)
      each.head.setAttribute("aria-sort", each === column ? words : "none");
    apply();
    FD.say(`Sorted by ${column.title}, ${words}`);
  }

  const NUMBER = "([-−+]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][-+]?\\d+)?)";
  const ONE = new RegExp(`^(<=|>=|<|>|=|≤|≥)?\\s*${NUMBER}$`);
  const RANGE = new RegExp(`^${NUMBER}\\s*(?:\\.\\.|to)\\s*${NUMBER}$`);
  const near = (x, y) => Math.abs(x - y) <= 1e-9 * Math.max(1, Math.abs(y));
  /** Whether a value passes what a filter's text asks for; null where it cannot be read. */
  function test(text, numeric) {
    const wanted = text.trim();
    if (!numeric) return (value) => FD.number(value).toLowerCase().includes(wanted.toLowerCase());
    const [range, one] = [RANGE.exec(wanted), ONE.exec(wanted)];
    if (!range && !one) return null;
    const [low, high] = (range ?? one).slice(range ? 1 : 2)
      .map((each) => Number(each.replace("−", "-")));
    const [way, equal] = [one?.[1] ?? "=", (value) => /[=≤≥]/.test(way) && near(value, low)];
    const holds = (value) => (range ? value >= low && value <= high : equal(value) ||
      (/[<≤]/.test(way) && value < low) || (/[>≥]/.test(way) && value > low));
    return (value) => value !== null && holds(value);
  }

  /** Show the rows that pass the filter. */
  function apply() {
    const wrong = [];
    const tests = FD.all("#only-front:checked, #only-feasible:checked").map(({ id }) => (number) =>
      FD.data.designs[number][id.slice("only-".length)]);
    for (const { input, title, numeric, of } of columns) {
      const found = input.value.trim() ? test(input.value, numeric) : () => true;
      input.setAttribute("aria-invalid", String(!found));
      if (!found) wrong.push(title);
      else if (input.value.trim()) tests.push((number) => found(of(number)));
    }
    FD.byId("fault").textContent = wrong.length
      ? `Not understood for ${wrong.join(", ")}: write <0.1, >=5, 2..5 or a number.` : "";
    const shown = order.filter((number) => tests.every((each) => each(number)));
    const passes = new Set(shown);
    for (const [number, row] of rows) row.hidden = !passes.has(number);
    FD.byId("shown-count").textContent = `${shown.length} of ${order.length} shown`;
    const now = table.tBodies[0].querySelector('button[tabindex="0"]');
    if (!now || now.closest("tr").hidden) stop(now, shown[0]);
    FD.show(shown);
  }

  /** One button of the table is a stop of the Tab key; arrows go on from it. */
  function stop(from, number) {
    if (from) from.tabIndex = -1;
    const to = rows.get(number)?.querySelector("button");
    if (to) to.tabIndex = 0;
    return to;
  }
  function step(event) {
    const ways = { ArrowDown: 1, ArrowUp: -1, Home: -Infinity, End: Infinity };
    if (!(event.key in ways) || !event.target.matches("tbody button")) return;
    event.preventDefault();
    const at = FD.shown.indexOf(Number(event.target.closest("tr").dataset.i)) + ways[event.key];
    stop(event.target, FD.shown[Math.min(FD.shown.length - 1, Math.max(0, at))]).focus();
  }

  function mark() {
    for (const [number, row] of rows) {
      const letter = FD.letter(number);
      row.querySelector("button").setAttribute("aria-pressed", String(letter !== null));
      if (letter) row.dataset.mark = letter;
      else delete row.dataset.mark;
    }
  }

  function column(head, place) {
    const row = (number) => rows.get(number);
    const own = FD.data.columns[head.dataset.column] ?? [
      { title: "design", of: FD.name },
      { title: "standing", of: (number) => row(number).cells[1].firstChild.data,
        rank: (number) => Number(row(number).cells[1].dataset.rank) }][place];
    const made = { of: (number) => FD.value(number, own), ...own, head,
      input: table.tHead.rows[1].cells[place].firstElementChild };
    // The better end first where a column has one; the second press turns it round.
    head.firstElementChild.addEventListener("click", () =>
      sort(made, sorted.column === made ? !sorted.up : made.goal !== "max"));
    made.input.addEventListener("input", apply);
    return made;
  }

  function start() {
    for (const row of table.tBodies[0].rows) rows.set(Number(row.dataset.i), row);
    order = [...rows.keys()];
    columns = [...table.tHead.rows[0].cells].map(column);
    for (const box of FD.all("#tools input")) {
      const place = columns.findIndex(({ head }) => head.dataset.column === box.dataset.hides);
      const hide = () => {
        for (const row of place < 0 ? [] : table.rows) row.cells[place].hidden = !box.checked;
        if (place >= 0) columns[place].input.value = "";
      };
      if (!box.checked) hide();
      box.addEventListener("change", () => (hide(), apply()));
    }
    FD.press("#clear-filter", () => {
      for (const { input } of columns) input.value = "";
      for (const box of FD.all("#only-front, #only-feasible")) box.checked = false;
      apply();
    });
    table.addEventListener("keydown", step);
    FD.press("#table-designs tbody button", ({ i }) => FD.toggle(Number(i)));
    FD.on("select", mark);
    apply();
  }

  /** Filter a column by its bounds. */
  FD.filter = (path, bounds) => {
    const ends = [...bounds].sort((p, q) => p - q).map((each) => each.toPrecision(6));
    columns.find((each) => each.path?.join() === path.join()).input.value = ends.join("..");
    apply();
  };

  /** A file that lies packed in the page, or of the rows shown now, or all as one JSON list. */
  FD.press("[data-save]", async ({ save, from, kind }) => {
    let text = await FD.unpacked(FD.all(`.archive[data-name="${from}"]`)[0]);
    const lines = text.split("\n"); // of designs.csv line k + 1 is design k
    if (kind === "shown") text = [0, ...FD.shown.map((k) => k + 1), -1].map((k) => lines.at(k)).join("\n");
    if (kind === "list") text = `[\n${lines.filter(Boolean).join(",\n")}\n]\n`;
    const type = `${save.endsWith(".csv") ? "text/csv" : "application/json"};charset=utf-8`;
    const href = URL.createObjectURL(new Blob([text], { type }));
    FD.el("a", { href, download: save }).click();
    setTimeout(() => URL.revokeObjectURL(href), 10000);
    FD.say(`Saved ${save}`);
  });
  if (table) start();
})();
