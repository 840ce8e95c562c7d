const variable = (_, name) => JSON.stringify(getComputedStyle(document.body).getPropertyValue(name).trim());
const camera = ({ layout }) => (layout?.scene ? { camera: layout.scene.camera, aspectratio: layout.scene.aspectratio } : {}); // stays
const drawn = ({ $el, figure: { layout: { scene, ...layout }, ...figure } }) => window.Plotly.react($el, JSON.parse(JSON.stringify(
  { ...figure, layout: { ...layout, ...(scene && { scene: { ...scene, ...camera($el) } }) } }).replace(/"(--[a-z-]+)"/g, variable)));
const mounted = function () {
  drawn(this).then(() => this.$el.on("plotly_click", ({ points }) => this.$emit("pick", points[0].customdata)));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn(this)); new ResizeObserver(() => this.$el.isConnected && window.Plotly.Plots.resize(this.$el)).observe(this.$el);
};
window.fingerdesign_studio = { install: (app) => app.component("finger-chart", { props: ["figure"], emits: ["pick"], render: () => window.Vue.h("div"), mounted, watch: { figure() {
  clearTimeout(this.due); this.due = setTimeout(() => drawn(this), this.figure.layout.scene ? 400 : 0); } } }) }; // seconds without a graphics card: at rest
