// The table of all designs, which is in the page already: sorted, filtered, chosen from; saved.
const table = FD.byId("table-designs");
const rows = new Map(); // design -> its row
const button = (number) => rows.get(number)?.querySelector("button");
const HEADINGS = [{ title: "design", path: ["name"] },
  { title: "standing", path: ["standing"], rank: ["rank"] }, ...FD.data.columns];
let columns = []; // each with its heading and the field that filters it
let order = []; // all designs of the table, as sorted
let sorted = { column: null, up: true };
let at = null; // the design whose button is a stop
const texts = new Intl.Collator("en", { numeric: true });
/** Sort by a column; what has no value stands last either way. */
function sort(column, up) {
  const compared = (p, q) => (Number.isFinite(p) && Number.isFinite(q) ? p - q
    : texts.compare(FD.number(p), FD.number(q)));
  order.sort((i, j) => {
    const [p, q] = [i, j].map((number) => FD.value(number, { path: column.rank ?? column.path }));
    return (p === null) - (q === null) || (up ? 1 : -1) * compared(p, q) || i - j;
  });
  table.tBodies[0].append(...order.map((number) => rows.get(number)));
  sorted = { column, up };
  const words = up ? "ascending" : "descending";
  for (const each of columns) each.head.ariaSort = each === column ? words : "none";
  apply();
  FD.say(`Sorted by ${column.title}, ${words}`);
}

const FORM = /^(?:(.+?)\s*(?:\.\.|to)|([<>]=?|[=≤≥])?)\s*(.+)$/; // 2..5, 2 to 5, <=5, 5
/** A test of values by a filter's text; null where the text cannot be read. */
function test(text, numeric) {
  const bounds = text.toLowerCase();
  if (!numeric || !text) return (value) => FD.number(value).toLowerCase().includes(bounds);
  const [, from, way = "=", to] = FORM.exec(bounds.replaceAll("−", "-"));
  const [low, high] = [from ?? to, to].map(Number);
  if (Number.isNaN(low + high)) return null;
  return (value) => value !== null && (from ? value >= low && value <= high
    : (/[=≤≥]/.test(way) && FD.near(value, low)) ||
      (/[<≤]/.test(way) && value < low) || (/[>≥]/.test(way) && value > low));
}
/** Show the rows that pass the filter. */
function apply() {
  const wrong = [];
  const tests = FD.all("#tools [form]:checked").map(({ value }) =>
    (number) => FD.data.designs[number][value]);
  for (const column of columns) {
    const found = test(column.input.value.trim(), column.numeric);
    column.input.setAttribute("aria-invalid", String(!found));
    if (found) tests.push((number) => found(FD.value(number, column)));
    else wrong.push(column.title);
  }
  FD.byId("fault").textContent = wrong.length
    ? `Not understood for ${wrong.join(", ")}: write <0.1, >=5, 2..5 or a number.` : "";
  FD.shown = order.filter((number) => tests.every((each) => each(number)));
  for (const row of rows.values()) row.hidden = true;
  for (const number of FD.shown) rows.get(number).hidden = false;
  FD.byId("shown-count").textContent = `${FD.shown.length} of ${order.length} shown`;
  if (rows.get(at)?.hidden !== false) stop(FD.shown[0]);
  FD.raise("shown");
}
/** One button of the table is a stop of the Tab key; arrows go on from it. */
function stop(number) {
  if (button(at)) button(at).tabIndex = -1;
  at = number;
  if (button(at)) button(at).tabIndex = 0;
}
function step(event) {
  if (!(event.key in FD.WAYS) || !event.target.matches("tbody button")) return;
  event.preventDefault();
  stop(FD.step(FD.shown, Number(event.target.dataset.i), FD.WAYS[event.key]));
  button(at).focus();
}
function mark() {
  for (const [number, row] of rows) {
    const letter = FD.letter(number);
    button(number).ariaPressed = String(letter !== null);
    if (letter) row.dataset.mark = letter;
    else delete row.dataset.mark;
  }
}
function start() {
  for (const row of table.tBodies[0].rows) rows.set(Number(row.dataset.i), row);
  order = [...rows.keys()];
  columns = FD.all("#table-designs [aria-sort]").map((head, place) =>
    ({ ...HEADINGS[place], head, input: FD.all("#table-designs .filters input")[place] }));
  // The better end first where a column has one; the second press turns it round.
  for (const each of columns)
    each.head.firstElementChild.addEventListener("click", () =>
      sort(each, sorted.column === each ? !sorted.up : each.goal !== "max"));
  for (const box of FD.all("[data-hides]")) {
    const hide = () => {
      for (const row of table.rows) row.cells[box.dataset.hides].hidden = !box.checked;
      columns[box.dataset.hides].input.value = "";
    };
    if (!box.checked) hide();
    box.addEventListener("input", hide);
  }
  table.closest("section").addEventListener("input", apply);
  FD.press("#clear-filter", () => (FD.byId("filter").reset(), apply()));
  table.addEventListener("keydown", step);
  FD.press("#table-designs tbody button", ({ i }) => FD.toggle(Number(i)));
  FD.on("select", mark);
  apply();
}
/** Filter a column by its bounds. */
FD.filter = (path, bounds) => {
  const ends = [...bounds].sort((p, q) => p - q).map((each) => each.toPrecision(6));
  columns.find((each) => String(each.path) === String(path)).input.value = ends.join("..");
  apply();
};
/** A file that lies packed in the page, or of the rows shown now, or all as one JSON list. */
FD.press("[data-save]", async ({ save, from, kind }) => {
  let text = await FD.unpacked(FD.all(`.archive[data-name="${from}"]`)[0]);
  const lines = text.split("\n"); // of designs.csv line k + 1 is design k
  if (kind === "shown") text = [0, ...FD.shown.map((k) => k + 1), -1].map((k) => lines.at(k)).join("\n");
  if (kind === "list") text = `[\n${lines.filter(Boolean).join(",\n")}\n]\n`;
  const href = URL.createObjectURL(new Blob([text]));
  FD.el("a", { href, download: save }).click();
  setTimeout(() => URL.revokeObjectURL(href), 10000);
  FD.say(`Saved ${save}`);
});
if (table) start();
