// The table of all designs: its rows stand in the page already; here they are sorted and chosen.
(() => {
  "use strict";
  const FD = window.FD;
  const rows = new Map(); // design -> its row
  let body = null;
  let columns = [];
  let order = []; // all designs of the table, as sorted
  let sorted = { key: null, up: true };

  const STANDING = ["recommended", "front", "feasible", "not feasible"];
  function standing(number) {
    const { feasible, front } = FD.data.designs[number];
    if (number === FD.data.study.recommended) return 0;
    return front ? 1 : feasible ? 2 : 3;
  }

  function column(key) {
    if (key === "name") return { key, title: "design", numeric: false, of: FD.name };
    if (key === "place")
      return {
        key,
        title: "standing",
        numeric: false,
        of: (number) => STANDING[standing(number)],
        rank: standing,
      };
    const found = FD.data.columns[Number(key)];
    return { ...found, key, of: (number) => FD.value(number, found) };
  }

  const texts = new Intl.Collator("en", { numeric: true });
  /** Sort by a column; what has no value stands last either way. */
  function sort(key, up) {
    const by = columns.find((each) => each.key === key);
    const of = by.rank ?? by.of;
    const told = order.map((number) => [of(number), number]);
    const sign = up ? 1 : -1;
    const isText = !by.numeric && !by.rank;
    told.sort(([x, i], [y, j]) => {
      if (x === null || y === null) return (x === null) - (y === null) || i - j;
      const way = isText ? texts.compare(FD.number(x), FD.number(y)) : x - y;
      return sign * way || i - j;
    });
    order = told.map(([, number]) => number);
    const all = document.createDocumentFragment();
    for (const number of order) all.append(rows.get(number));
    body.append(all);
    sorted = { key, up };
    for (const each of columns) {
      const way = each.key === key ? (up ? "ascending" : "descending") : "none";
      each.head.setAttribute("aria-sort", way);
    }
    apply();
    FD.say(`Sorted by ${by.title}, ${up ? "ascending" : "descending"}`);
  }

  /** Better ends first where a column has one; the second press turns it round. */
  function press(each) {
    const first = each.goal !== "max";
    sort(each.key, sorted.key === each.key ? !sorted.up : first);
  }

  /** Show the rows that pass the filter. */
  function apply() {
    const passes = FD.filter.test(columns);
    const shown = [];
    for (const number of order) {
      const row = rows.get(number);
      row.hidden = !passes(number);
      if (!row.hidden) shown.push(number);
    }
    FD.filter.tell(shown.length, order.length);
    rove(shown);
    FD.tellShown(shown);
  }

  /** One button of the table is a stop of the Tab key; arrows go on from it. */
  function rove(shown) {
    const now = body.querySelector('button[tabindex="0"]');
    if (now && !now.closest("tr").hidden) return;
    if (now) now.tabIndex = -1;
    if (shown.length) rows.get(shown[0]).querySelector("button").tabIndex = 0;
  }

  function step(event) {
    const ways = { ArrowDown: 1, ArrowUp: -1, Home: -Infinity, End: Infinity };
    if (!(event.key in ways) || !event.target.matches("tbody button")) return;
    event.preventDefault();
    const shown = FD.shown;
    const at = shown.indexOf(Number(event.target.closest("tr").dataset.i));
    const to = Math.min(shown.length - 1, Math.max(0, at + ways[event.key]));
    event.target.tabIndex = -1;
    const next = rows.get(shown[to]).querySelector("button");
    next.tabIndex = 0;
    next.focus();
  }

  function mark() {
    for (const [number, row] of rows) {
      const letter = FD.letter(number);
      if ((row.dataset.mark ?? null) === letter) continue;
      const button = row.querySelector("button");
      button.setAttribute("aria-pressed", String(letter !== null));
      button.replaceChildren(...(letter ? [FD.badge(letter), " "] : []), FD.name(number));
      if (letter) row.dataset.mark = letter;
      else delete row.dataset.mark;
    }
  }

  function start() {
    const table = document.getElementById("table-designs");
    if (!table) {
      FD.tellShown([]);
      return;
    }
    body = table.tBodies[0];
    for (const row of body.rows) {
      const number = Number(row.dataset.i);
      rows.set(number, row);
      order.push(number);
      const button = FD.el(
        "button",
        { type: "button", tabindex: "-1", "aria-pressed": "false" },
        FD.name(number),
      );
      row.cells[0].replaceChildren(button);
    }
    columns = [...table.tHead.rows[0].cells].map((head) => {
      const made = { ...column(head.dataset.column), head };
      const button = FD.el("button", { type: "button", onclick: () => press(made) });
      button.append(...head.childNodes);
      head.replaceChildren(button);
      head.setAttribute("aria-sort", "none");
      return made;
    });
    table.addEventListener("keydown", step);
    body.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) FD.toggle(Number(button.closest("tr").dataset.i));
    });
    FD.filter.start(table, columns, apply);
    FD.onSelect(mark);
    apply();
  }

  FD.table = { start, sort, apply };
})();
