// Assembles the page: one connection feeds one team, which the parts show.

import { ActionPlot, LANES } from "./action_plot.js";
import { AlarmList } from "./alarm_list.js";
import { AlarmSignal } from "./alarm_signal.js";
import { BorderLine } from "./border_line.js";
import { CardList } from "./card_list.js";
import { Connection } from "./connection.js";
import { CoverageStrip } from "./coverage_strip.js";
import { DistancePlot } from "./distance_plot.js";
import { element, setText } from "./element.js";
import { EmptyTeam } from "./empty_team.js";
import { Figures } from "./figures.js";
import { duration } from "./format.js";
import { Header } from "./header.js";
import { History } from "./history.js";
import { listenToKeys } from "./keyboard.js";
import { makeLayers } from "./layer_switches.js";
import { MapToolbar } from "./map_toolbar.js";
import { MapView } from "./map_view.js";
import { NumberKeys } from "./number_keys.js";
import { OperatorName } from "./operator_name.js";
import { PlaybackBar } from "./playback_bar.js";
import { PlotCursor } from "./plot_cursor.js";
import { Roster } from "./roster.js";
import { Selection } from "./selection.js";
import { ShiftLog } from "./shift_log.js";
import { Team } from "./team.js";
import { Theme } from "./theme.js";

const CARDS_MS = 200;
const PLOTS_MS = 1000;
const SPANS = [60, 300, 900, 3600];

const find = (id) => document.getElementById(id);
const site = await (await fetch("/site.json")).json();
const team = new Team();
const figures = new Figures();
const header = new Header(team, figures, (id) => robotName(id), showAlarm);
const selection = new Selection(() => selected());
const layers = makeLayers(find("layers").querySelector("div"), () => map.refresh());
const map = new MapView(find("map"), site, team, layers, selection, (place) => toolbar.tell(place));
const border = new BorderLine(site.border);
const zones = map.ground.zones;
const toolbar = new MapToolbar(map, border, zones, { fit, follow });
const roster = new Roster(team, zones);
const cards = new CardList(find("cards"), team, site.actions, roster, selection);
const coverage = new CoverageStrip(find("coverage"), find("idleness"), find("coverage-legend"), {
  team, border, zones, go: (s) => {
    selection.stopFollowing();
    map.show(border.at(s));
  },
});
const history = new History(team, roster);
const cursor = new PlotCursor(() => plots.forEach((plot) => plot.draw()), (time) => playback.go(time));
const plots = [
  new DistancePlot(find("distance"), find("distance-reading"), history, selection, cursor),
  new ActionPlot(find("actions"), find("actions-reading"), find("actions-legend"), site.actions, history, selection, cursor),
];
const theme = new Theme(find("theme"), () => {
  map.restyle();
  drawPlots();
});
const connection = new Connection(take, (up) => header.showLink(up));
const playback = new PlaybackBar(find("playback"), (request) => connection.send(request), (entry) => showAlarm(entryAlarm(entry)));
const empty = new EmptyTeam(find("empty"));
let surveyed = false;
const robotName = (id) => team.robots.get(id)?.name ?? id;
const operator = new OperatorName(find("operator"));
const signal = new AlarmSignal(find("sound"), find("notify"));
const alarms = new AlarmList(find("alarms"), find("alarm-count"), find("acknowledge-all"), {
  acknowledge: (alarm) => connection.send({ acknowledge: alarm.number, by: operator.value }),
  robotName,
  go: showAlarm,
});
const log = new ShiftLog(find("log"), find("open-log"), robotName, (entry) => showAlarm(entryAlarm(entry)));
setText(find("site"), site.name);
site.actions.forEach((_action, index) => {
  const [item, colour] = [element("span", "", LANES[index]), element("i")];
  colour.style.background = `var(--action-${index})`;
  item.prepend(colour);
  find("actions-legend").append(item);
});

function take(message) {
  if (message.fresh) {
    cards.clear();
    alarms.clear();
    signal.forget();
  }
  team.take(message);
  map.changed = true;
  alarms.show(team.alarms, team.source.mayAct);
  log.take(team.log, find("open-log"));
  if (message.surveyed && !surveyed) survey();
  if (team.source.kind === "live") signal.take(team.alarms, robotName);
}

// The survey of the recordings is done: their whole history and all their alarms can be had.
async function survey() {
  surveyed = true;
  await Promise.all([history.load(), playback.marks.load()]);
  drawPlots();
}

function selected() {
  map.following = selection.following;
  if (selection.following) map.follow(true);
  find("follow").setAttribute("aria-pressed", String(selection.following));
  map.changed = true;
  showCards();
  cards.reveal(selection.id);
  drawPlots();
}

function showCards() {
  cards.show();
  empty.show(team);
  const listed = cards.cards.size;
  setText(find("robot-count"), listed === team.ordered.length ? `${listed}` : `${listed} of ${team.ordered.length}`);
  playback.show(team.source);
  header.show();
  alarms.showAges(team.wall);
}

// An entry of the log as the alarm it was; its place is the one it had then.
function entryAlarm(entry) {
  const place = entry.place_x === null ? null : [entry.place_x, entry.place_y];
  return { robot: entry.robot, raised: entry.raised, seen: entry.raised, place };
}

// Chooses the alarm's robot and shows its place; in a playback, at the time it was raised.
function showAlarm(alarm) {
  const live = team.source.kind === "live";
  if (!live) connection.send({ seek: alarm.raised });
  selection.stopFollowing();
  const robot = team.robots.get(alarm.robot);
  if (robot) selection.choose(robot.id);
  map.centre(live && alarm.seen === null ? (robot?.pose ?? alarm.place) : alarm.place);
}

function drawPlots() {
  playback.marks.draw();
  coverage.draw();
  for (const plot of plots) plot.draw();
}

function frame() {
  if (map.draw()) figures.drawn(team);
  requestAnimationFrame(frame);
}

for (const span of SPANS) find("span").append(new Option(`last ${duration(span)}`, span, span === 300, span === 300));
find("span").addEventListener("change", (event) => {
  history.span = Number(event.target.value);
  drawPlots();
});
find("help").addEventListener("click", () => find("keys").showModal());
find("robot-search").addEventListener("input", (event) => {
  roster.words = event.target.value;
  showCards();
  drawPlots();
});
find("robot-filter").addEventListener("change", (event) => {
  roster.filter = event.target.value;
  showCards();
  drawPlots();
});
find("expand").addEventListener("click", (event) => {
  cards.all = !cards.all;
  event.target.setAttribute("aria-pressed", String(cards.all));
  showCards();
});

function fit() {
  selection.stopFollowing();
  map.fit();
}

function follow() {
  if (selection.id === null && team.ordered.length) selection.choose(team.ordered[0].id);
  selection.follow(!selection.following);
}

// Typing 1 and then 2 chooses robot 1, then 12.
const numbers = new NumberKeys((number) => {
  const robot = team.ordered.find((each) => each.mark === number);
  if (robot) selection.choose(robot.id);
});

const KEYS = {
  "/": () => find("robot-search").focus(),
  "+": () => map.zoom(1.4),
  "-": () => map.zoom(1 / 1.4),
  0: fit,
  f: follow,
  a: () => alarms.acknowledgeFirst(),
  l: () => team.log !== null && log.open(),
  t: () => theme.toggle(),
  m: () => toolbar.toggleMeasure(),
  Escape: () => toolbar.stopMeasure(),
  " ": () => playback.toggle(),
  ",": () => playback.skip(-10),
  ".": () => playback.skip(10),
  "?": () => find("keys").showModal(),
};

listenToKeys(KEYS, numbers, () => playback.shown);
setInterval(showCards, CARDS_MS);
setInterval(drawPlots, PLOTS_MS);
requestAnimationFrame(frame);
window.patrol = { team, figures, map, selection, signal, roster, history, playback };
