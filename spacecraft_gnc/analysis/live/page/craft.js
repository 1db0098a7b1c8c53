// Craft on their paths, where they are to be, and the lines between them. The picture holds the
// craft that answer and the ring that they are to be on.

import { Camera } from "./camera.js";
import { componentColor } from "./scene.js";

const TRAIL = 60; // samples of the past that are drawn
const ROOM = 1.15; // of what is shown, in the picture

// The points (m, 3) of a flat list of numbers.
const pointsOf = (numbers) => Array.from({ length: (numbers?.length ?? 0) / 3 }, (_, i) => numbers.slice(3 * i, 3 * i + 3));
const isKnown = (point) => point?.every((v) => v !== null) ?? false;

export class Craft extends Camera {
  constructor(canvas, colors, redraw) {
    super(canvas, colors, redraw);
    // Along the track to the right and outward up, as in the figures: from below the orbital plane.
    this.azimuth = 0.25;
    this.elevation = -1.15;
    this.at = {}; // where the craft were drawn [px], and their depth
  }

  draw(frame, setup, trail) {
    const craft = pointsOf(frame[setup.trail]), places = pointsOf(frame.places);
    const answers = (i) => frame.answers?.[i] !== false;
    this.begin();
    this.#look([...setup.ring, ...places, ...craft.filter((_, i) => answers(i))].filter(isKnown));
    this.#curve(setup.ring, "#93a1b1", 1.3, [6, 5]);
    this.#cross();
    const past = trail.slice(-TRAIL).map(pointsOf);
    craft.forEach((_, i) => this.#curve(past.map((points) => points[i]), componentColor(this.colors, i), 1.6));
    for (const [first, second, kept] of pointsOf(frame.links)) this.#link(craft[first], craft[second], kept);
    places.forEach((place, i) => isKnown(place) && this.#diamond(this.project(place), componentColor(this.colors, i)));
    craft.forEach((point, i) => isKnown(point) && this.#craft(point, setup.craft[i] ?? `${i + 1}`, componentColor(this.colors, i), answers(i)));
  }

  // What has to be seen in the middle, as large as it fits.
  #look(points) {
    this.middle = [0, 0, 0];
    this.scale = 1;
    const [cx, cy] = this.center;
    const shown = points.map((p) => this.project(p)).map(([x, y]) => [x - cx, cy - y]);
    const [[left, right], [low, high]] = [0, 1].map((i) => [Math.min(-1, ...shown.map((p) => p[i])), Math.max(1, ...shown.map((p) => p[i]))]);
    this.scale = Math.min((2 * cx) / (right - left), (2 * cy) / (high - low)) / ROOM;
    this.middle = [0, 1, 2].map((i) => 0.5 * ((left + right) * this.right[i] + (low + high) * this.up[i]));
  }

  #curve(points, color, width, dash = []) {
    this.pen.setLineDash(dash);
    this.path(points.filter(isKnown).map((p) => this.project(p)), color, width);
    this.pen.setLineDash([]);
  }

  // The origin, the outward direction and that along the track.
  #cross() {
    const length = 34 / this.scale;
    [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
      const tip = this.project(axis.map((v) => v * length));
      this.line(this.project([0, 0, 0]), tip, "#93a1b1", 1);
      this.text(name, this.project(axis.map((v) => 1.3 * v * length)), "#93a1b1");
    });
  }

  #link(first, second, kept) {
    if (!isKnown(first) || !isKnown(second)) return;
    this.line(this.project(first), this.project(second), kept ? "#c9d3df" : this.colors.bad, kept ? 1 : 3);
  }

  #diamond([x, y], color) {
    this.path([[x, y - 7], [x + 7, y], [x, y + 7], [x - 7, y], [x, y - 7]], color, 1.6);
  }

  #craft(point, name, color, answers) {
    const [x, y, depth] = this.project(point);
    this.dot([x, y], color, 5);
    this.at[name] = [x, y, depth];
    if (!answers) {
      this.line([x - 8, y - 8], [x + 8, y + 8], this.colors.bad, 2.5);
      this.line([x - 8, y + 8], [x + 8, y - 8], this.colors.bad, 2.5);
    }
    this.text(name, [x, y - 17], color);
  }
}
