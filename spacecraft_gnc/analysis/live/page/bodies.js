// Bodies that move relative to the first one, which stands still: cuboids with ports, a region with
// eight corners, and a trail. The picture comes closer the closer they are.

import { Camera, boxFaces, plus, rotate } from "./camera.js";

const EDGES = [4, 2, 1].flatMap((bit) => [0, 1, 2, 3, 4, 5, 6, 7].filter((i) => !(i & bit)).map((i) => [i, i | bit]));
const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [4, 2, 1].map((bit) => (i & bit ? 1 : -1)));
const STILL = { position: [0, 0, 0], attitude: [1, 0, 0, 0, 1, 0, 0, 0, 1] };
const COLORS = ["#93a1b1", "#58aef0", "#f58a45"];

export class Bodies extends Camera {
  constructor(canvas, colors, redraw) {
    super(canvas, colors, redraw);
    this.azimuth = -1.1;
    this.elevation = 0.35;
    this.ports = {}; // where the ports were drawn [px], and their depth
  }

  draw(frame, setup, trail) {
    const shown = setup.bodies.map((body, i) => ({ ...body, color: COLORS[i % 3], pose: frame.bodies?.[body.name] ?? (i ? null : STILL) }))
      .filter(({ pose }) => pose?.position && pose.attitude);
    this.begin();
    this.#look(shown);
    for (const [a, b] of setup.region.length ? EDGES : []) {
      this.line(this.project(setup.region[a]), this.project(setup.region[b]), this.colors.good, 1);
    }
    this.path(trail.map((p) => this.project(p)), COLORS[1], 1.6);
    if (frame.aim) this.#diamond(this.project(frame.aim));
    const depth = ({ pose }) => this.project(pose.position)[2];
    for (const body of shown.sort((a, b) => depth(a) - depth(b))) this.#body(body);
  }

  // The bodies in the middle, with room around them.
  #look(shown) {
    const [first, last] = [shown[0], shown.at(-1)].map((body) => body?.pose.position ?? [0, 0, 0]);
    const size = Math.max(1, ...shown.flatMap((body) => body.size));
    this.middle = plus(first, last).map((v) => v / 2);
    this.scale = this.size / (1.3 * Math.hypot(...last.map((v, i) => v - first[i])) + 2 * size);
  }

  #body({ name, size, port, pose, color }) {
    this.solid(boxFaces([0, 0, 0], size.map((edge) => edge / 2), color), pose.attitude, pose.position);
    const at = this.project(plus(pose.position, rotate(pose.attitude, port)));
    this.dot(at, this.colors.warn, 3);
    this.ports[name] = at;
    const corners = CORNERS.map((corner) => this.project(
      plus(pose.position, rotate(pose.attitude, corner.map((c, i) => (c * size[i]) / 2)))));
    const [x] = this.project(pose.position);
    this.text(name, [x, Math.min(...corners.map(([, y]) => y)) - 11], color);
  }

  #diamond([x, y]) {
    this.path([[x, y - 6], [x + 6, y], [x, y + 6], [x - 6, y], [x, y - 6]], this.colors.warn, 1.6);
  }
}
