// The files that lie in the page, packed: unpacked and saved without any network.
(() => {
  "use strict";
  const FD = window.FD;
  const WORDS = {
    "designs.csv": "a row a design: values, metrics, errors, digest, failure",
    "outcomes.jsonl": "a line of JSON a design: everything, contact maps too",
    "increments.csv": "a row an increment of each design: motion, forces, stick, gages",
    "grips.csv": "a row a step of each grip: forces, and how it ended",
  };

  function save(name, text, type) {
    const address = URL.createObjectURL(new Blob([text], { type: `${type};charset=utf-8` }));
    const link = FD.el("a", { href: address, download: name });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
    FD.say(`Saved ${name}`);
  }

  const kind = (name) => (name.endsWith(".csv") ? "text/csv" : "application/json");
  const archive = (name) => document.querySelector(`.archive[data-name="${name}"]`);

  async function whole(name) {
    save(name, await FD.unpacked(archive(name)), kind(name));
  }

  /** The rows of designs.csv that the table shows, in its order: line k + 1 is design k. */
  async function shown() {
    const lines = (await FD.unpacked(archive("designs.csv"))).split("\n");
    const kept = [lines[0], ...FD.shown.map((number) => lines[number + 1])];
    save("designs_shown.csv", `${kept.join("\n")}\n`, "text/csv");
  }

  /** All of it as one JSON file: a list of outcomes. */
  async function json() {
    const lines = (await FD.unpacked(archive("outcomes.jsonl"))).trim().split("\n");
    save("outcomes.json", `[\n${lines.filter(Boolean).join(",\n")}\n]\n`, "application/json");
  }

  function entry(name, words, act) {
    const button = FD.el("button", { type: "button", "data-save": name, onclick: act }, name);
    return FD.el("li", {}, button, ` ${words}`);
  }

  function start() {
    const list = document.getElementById("save");
    if (typeof DecompressionStream === "undefined") {
      list.append(FD.el("li", {}, "This browser cannot unpack them; a newer one can."));
      return;
    }
    for (const [name, words] of Object.entries(WORDS))
      list.append(entry(name, words, () => whole(name)));
    list.append(entry("outcomes.json", "the same as one JSON list", json));
    list.append(entry("designs_shown.csv", "the rows that the table shows now", shown));
  }

  FD.save = { start };
})();
