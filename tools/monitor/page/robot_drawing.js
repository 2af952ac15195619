// One robot on the map, layer by layer, each to scale in metres.

import { colour, robotColour } from "./palette.js";

const ELLIPSE_95 = 2.448; // radius in standard deviations that holds 95 % in two dimensions
const CLOSE = 60; // px per m
const FAR_SHARE = 5; // one particle in so many is drawn below CLOSE
const SMALLEST_ELLIPSE = 4; // px
const TRAIL_SECONDS = 600;
const GAP = 3; // s without a sample that breaks the trail
const FRESH = 1.5; // s after which a scan or a track is stale

// The path of the last TRAIL_SECONDS to the present pose; broken where telemetry is missing.
export function drawTrail(context, robot, scale) {
  const points = robot.samples.slice(-TRAIL_SECONDS);
  if (!points.length) return;
  context.strokeStyle = robotColour(robot.number);
  context.lineWidth = 2 / scale;
  context.lineJoin = "round";
  // Three pieces, each fainter than the next: shows the direction of motion.
  const third = Math.ceil(points.length / 3);
  for (let piece = 0; piece < 3; piece += 1) {
    context.globalAlpha = 0.12 + 0.14 * piece;
    context.beginPath();
    let before = -Infinity;
    for (const [wall, x, y] of points.slice(piece * third, (piece + 1) * third + 1)) {
      if (wall - before > GAP) context.moveTo(x, y);
      else context.lineTo(x, y);
      before = wall;
    }
    if (piece === 2 && robot.age("pose", robot.at.decision) < GAP) context.lineTo(robot.pose[0], robot.pose[1]);
    context.stroke();
  }
  context.globalAlpha = 1;
}

export function drawVisibility(context, robot, site, scale) {
  context.strokeStyle = robotColour(robot.number);
  context.fillStyle = robotColour(robot.number);
  context.lineWidth = 1 / scale;
  context.beginPath();
  context.arc(robot.pose[0], robot.pose[1], site.visibility, 0, 2 * Math.PI);
  context.globalAlpha = 0.05;
  context.fill();
  context.globalAlpha = 0.4;
  context.setLineDash([5 / scale, 5 / scale]);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

export function drawScan(context, robot, site, scale, now) {
  if (!robot.scan || robot.age("scan", now) > FRESH) return;
  const [x, y, theta] = robot.scan.at;
  const [mx, my, turn] = robot.status?.laserAt ?? site.laser;
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  const [lx, ly] = [x + c * mx - s * my, y + s * mx + c * my];
  const dot = Math.max(2 / scale, 0.03);
  context.fillStyle = robotColour(robot.number);
  context.globalAlpha = 0.75;
  const { ranges, start, step } = robot.scan;
  let [lastX, lastY] = [Infinity, Infinity];
  for (let beam = 0; beam < ranges.length; beam += 1) {
    if (!ranges[beam]) continue;
    const angle = theta + turn + start + beam * step;
    const px = lx + (ranges[beam] / 100) * Math.cos(angle);
    const py = ly + (ranges[beam] / 100) * Math.sin(angle);
    if (Math.abs(px - lastX) < 0.75 * dot && Math.abs(py - lastY) < 0.75 * dot) continue; // same dot
    context.fillRect(px - dot / 2, py - dot / 2, dot, dot);
    [lastX, lastY] = [px, py];
  }
  context.globalAlpha = 1;
}

// Drawn over the body when zoomed in, since a well localized robot covers all particles.
export function drawParticles(context, robot, scale) {
  const particles = robot.particles ?? [];
  const dot = 2 / scale;
  context.fillStyle = scale > CLOSE ? colour("text") : robotColour(robot.number);
  context.globalAlpha = 0.5;
  const step = scale > CLOSE ? 3 : 3 * FAR_SHARE; // zoomed out, they overlap
  for (let at = 0; at < particles.length; at += step) {
    context.fillRect(particles[at] / 100 - dot / 2, particles[at + 1] / 100 - dot / 2, dot, dot);
  }
  context.globalAlpha = 1;
}

// The 95 % ellipse of the pose estimate's position.
export function drawCovariance(context, robot, scale) {
  const estimate = robot.status?.localization;
  if (!estimate?.pose || estimate.covariance.length < 9) return;
  const [a, b, , , d] = estimate.covariance;
  const mean = (a + d) / 2;
  const spread = Math.hypot((a - d) / 2, b);
  if (ELLIPSE_95 * Math.sqrt(Math.max(mean + spread, 0)) * scale < SMALLEST_ELLIPSE) return;
  const [x, y] = robot.pose ?? estimate.pose;
  context.beginPath();
  context.ellipse(
    x, y,
    ELLIPSE_95 * Math.sqrt(Math.max(mean + spread, 0)) + 1 / scale,
    ELLIPSE_95 * Math.sqrt(Math.max(mean - spread, 0)) + 1 / scale,
    Math.atan2(2 * b, a - d) / 2, 0, 2 * Math.PI,
  );
  context.strokeStyle = colour("text");
  context.lineWidth = 1.2 / scale;
  context.stroke();
}

// Teammates are rings, strangers squares, intruders triangles: distinct without colour.
export function drawTracks(context, robot, scale, now) {
  if (!robot.tracks || robot.age("tracks", now) > FRESH) return;
  for (const track of robot.tracks) {
    const size = Math.max(track.size / 2, 5 / scale);
    const intruder = track.kind === "intruder";
    context.strokeStyle = intruder ? colour("critical") : track.kind === "teammate" ? robotColour(robot.number) : colour("quiet");
    context.lineWidth = (intruder ? 3 : 1.6) / scale;
    context.beginPath();
    if (intruder) {
      context.moveTo(track.x, track.y + 1.5 * size);
      context.lineTo(track.x + 1.3 * size, track.y - size);
      context.lineTo(track.x - 1.3 * size, track.y - size);
      context.closePath();
    } else if (track.kind === "teammate") {
      context.arc(track.x, track.y, size, 0, 2 * Math.PI);
    } else {
      context.rect(track.x - size, track.y - size, 2 * size, 2 * size);
    }
    context.stroke();
    if (track.speed > 0.05) {
      context.beginPath();
      context.moveTo(track.x, track.y);
      context.lineTo(track.x + track.speed * Math.cos(track.heading), track.y + track.speed * Math.sin(track.heading));
      context.stroke();
    }
  }
}

// trouble: severity of its worst alarm, a ring in that colour; a silent robot is hollow.
export function drawBody(context, robot, site, scale, { chosen, silent, trouble }) {
  const { front, rear, halfWidth } = robot.status?.body ?? site.robot;
  const [x, y, theta] = robot.pose;
  context.save();
  context.translate(x, y);
  context.rotate(theta);
  // A robot shorter than 15 px is drawn larger, to stay visible.
  const enlarged = Math.max(1, 15 / ((front + rear) * scale));
  context.scale(enlarged, enlarged);
  const pixel = 1 / (scale * enlarged);
  context.beginPath();
  context.roundRect(-rear, -halfWidth, front + rear, 2 * halfWidth, 0.07);
  context.fillStyle = silent ? colour("panel") : robotColour(robot.number);
  context.strokeStyle = silent ? robotColour(robot.number) : colour("ground");
  context.lineWidth = (silent ? 2.2 : 1.5) * pixel;
  context.fill();
  context.stroke();
  context.beginPath();
  context.moveTo(front - 0.03, 0);
  context.lineTo(front - 0.2, 0.6 * halfWidth);
  context.lineTo(front - 0.2, -0.6 * halfWidth);
  context.closePath();
  context.fillStyle = silent ? robotColour(robot.number) : colour("ground");
  context.fill();
  context.restore();
  if (trouble && trouble !== "info") drawRing(context, [x, y], Math.max(0.36, 13 / scale), colour(trouble), 2.5 / scale);
  if (chosen) drawRing(context, [x, y], Math.max(0.46, 17 / scale), colour("text"), 1.5 / scale);
}

function drawRing(context, [x, y], radius, style, width) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.strokeStyle = style;
  context.lineWidth = width;
  context.stroke();
}
