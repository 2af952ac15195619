// The border as a polyline: the place at an abscissa s, and the abscissa nearest to a place.

export class BorderLine {
  // border: of the site, null without one.
  constructor(border) {
    this.points = border?.points ?? [];
    this.length = border?.length ?? 0;
  }

  at(s) {
    const last = this.points.length - 1;
    return this.points[Math.min(Math.max(Math.round((s / this.length) * last), 0), last)];
  }

  // Returns { s, distance } in m; null without a border.
  nearest(x, y) {
    if (!this.points.length) return null;
    let [best, distance] = [0, Infinity];
    this.points.forEach(([px, py], at) => {
      const away = (px - x) ** 2 + (py - y) ** 2;
      if (away < distance) [best, distance] = [at, away];
    });
    return { s: (best / (this.points.length - 1)) * this.length, distance: Math.sqrt(distance) };
  }
}
