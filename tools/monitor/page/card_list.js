// The cards of robots in trouble first, else in the order of their names; the selected one is open, or all.

import { RobotCard } from "./robot_card.js";

export class CardList {
  constructor(box, team, actions, zones, selection) {
    this.box = box;
    this.team = team;
    this.actions = actions;
    this.zones = zones;
    this.selection = selection;
    this.cards = new Map();
    this.all = false;
  }

  clear() {
    this.cards.clear();
    this.box.replaceChildren();
  }

  show() {
    for (const [id, card] of this.cards) {
      if (this.team.robots.has(id)) continue;
      card.root.remove();
      this.cards.delete(id);
    }
    const rank = { critical: 0, warning: 1, info: 2 };
    const worst = new Map(this.team.ordered.map((robot) => [robot.id, this.team.trouble(robot.id)]));
    const order = [...this.team.ordered].sort((a, b) => (rank[worst.get(a.id)] ?? 3) - (rank[worst.get(b.id)] ?? 3));
    for (const robot of order) {
      const card = this.card(robot);
      const chosen = this.selection.id === robot.id;
      if (card.open !== (this.all || chosen)) card.setOpen(this.all || chosen);
      card.update(this.team.now, chosen, worst.get(robot.id));
    }
    this.arrange(order);
  }

  card(robot) {
    const known = this.cards.get(robot.id);
    if (known?.robot === robot) return known;
    known?.root.remove();
    const card = new RobotCard(robot, this.actions, this.zones, () => this.selection.toggle(robot.id));
    card.setOpen(false);
    this.cards.set(robot.id, card);
    this.box.append(card.root);
    return card;
  }

  // Moves only cards out of place: moving one takes the keyboard focus away.
  arrange(order) {
    let before = null;
    for (const robot of order) {
      const { root } = this.cards.get(robot.id);
      const expected = before ? before.nextElementSibling : this.box.firstElementChild;
      if (expected !== root) this.box.insertBefore(root, expected);
      before = root;
    }
  }

  reveal(id) {
    this.cards.get(id)?.root.scrollIntoView({ block: "nearest" });
  }
}
