// Figures that lie packed behind their places; before them fields, of their sliders and menus.
const webgl = document.createElement("canvas").getContext("webgl") !== null;
FD.plotly().then(async () => {
  for (const place of FD.all(".fields + .plot")) {
    const still = place.querySelector(".still"); // for browsers that do not draw in space
    if ((place.previousElementSibling.hidden = still && !webgl)) continue;
    const { data, layout: { sliders = [], updatemenus = [], ...layout }, config } =
      JSON.parse(await FD.unpacked(place.nextElementSibling));
    const choices = [...sliders, ...updatemenus].map(({ steps, buttons }) => steps ?? buttons);
    const fields = [...place.previousElementSibling.querySelectorAll("input, select")];
    const act = async (k) => {
      const { label, method, args } = choices[k][fields[k].value];
      fields[k].ariaValueText = label;
      await Plotly[method](place, ...FD.themed(args));
    };
    const draw = async () => {
      const given = FD.themed([data, layout, config]);
      const { aspectratio } = given[1].scene ?? {}; // what is wide is smaller in a narrow window
      for (const axis in aspectratio) aspectratio[axis] *= Math.min(1, place.clientWidth / 540);
      still?.remove();
      await Plotly.newPlot(place, ...given);
      for (const k of fields.keys()) await act(k);
    };
    for (const [k, field] of fields.entries()) field.addEventListener("input", () => act(k));
    FD.onLook(draw);
    await draw();
  }
  document.body.dataset.drawn = "all";
});
